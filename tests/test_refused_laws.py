"""Friction laws without inertia: what is allowed, and messages that name what is not."""

import numpy as np
import pytest
from driver import models
from pin_equations import edge
from test_friction_table_load import write

FORWARD = models["DualCamForward"]
MASSLESS = {"inertia.shaft": 0.0}
SPEEDS, LOADS = [0.0, 0.1, 0.4, 1.0], [50.0, 100.0, 400.0]


@pytest.fixture
def refused(make_model):
    """The message with which a start is refused."""

    def message(values):
        fmu = make_model(FORWARD)
        fmu.set(MASSLESS | values)
        fmu.setup()
        fmu.ok("fmi2EnterInitializationMode")
        return fmu.refused_start()

    return message


@pytest.mark.parametrize("cam", [1, 2])
def test_a_table_asks_for_an_inertia(refused, tmp_path, cam):
    (tmp_path / "law.csv").write_text("v_m_s,mu\n0,0.2\n0.1,0.21\n0.2,0.22\n", encoding="utf-8")
    text = refused({f"cam{cam}.friction_table": str(tmp_path / "law.csv")})
    assert f"cam{cam}.friction_table" in text and "inertia.shaft" in text


def test_a_peak_of_no_friction_is_none(make_model):
    """friction_peak is a factor of the kinetic coefficient."""
    band = {}
    for peak in (1.0, 3.0):
        fmu = make_model(FORWARD).start(MASSLESS | {"cam1.friction": 0.0, "cam1.friction_peak": peak})
        band[peak] = fmu.get("torque_load"), fmu.get("torque_release")
    assert band[1.0] == band[3.0]


def test_a_jam_names_the_load_exponent_of_cam_2(refused):
    jam = {"cam1.lead_angle": 1.5, "cam2.lead_angle": 1.5, "cam2.friction_load_exponent": 0.1}
    text = refused(jam)
    assert "jam" in text and "cam2.friction_load_exponent = 0.1" in text


def test_a_load_twice_in_a_table_is_refused(refused, tmp_path):
    path = write(tmp_path / "law.csv", SPEEDS, [50.0, 50.0], np.full((2, len(SPEEDS)), 0.1))
    text = refused({"cam1.friction_table": path})
    assert "line 6" in text and "R_N = 50 must be > 50" in text


def test_a_sample_with_the_load_of_another_one_is_refused(refused, tmp_path):
    path = tmp_path / "law.csv"
    rows = [*((v, 50.0) for v in SPEEDS), (0.0, 100.0), (0.1, 100.0), (0.4, 101.0), (1.0, 100.0)]
    path.write_text("v_m_s,R_N,mu\n" + "".join(f"{v},{load},0.1\n" for v, load in rows))
    assert "line 8: R_N = 101 must be 100" in refused({"cam1.friction_table": str(path)})


def test_a_table_at_cam_2_is_its_only_friction(make_model, tmp_path):
    """Without friction at cam 1 the edges are those of the table's static coefficient at cam 2."""
    path = tmp_path / "law.csv"
    path.write_text("v_m_s,mu\n0,0.2\n0.1,0.21\n0.2,0.22\n0.5,0.25\n")
    none = {"cam1.friction": 0.0, "cam2.friction": 0.0}
    fmu = make_model(FORWARD).start(none | {"cam2.friction_table": str(path)})

    class Place:
        r = a = (0.02, 0.02)

    for name, way in (("torque_load", 1), ("torque_release", -1)):
        expected = 50.0 * edge(Place, (0.0, 0.2), way, 1.0)[0]
        assert fmu.get(name) == pytest.approx(expected, rel=1e-12)
    fmu.step(0.01, tau=2.0)
    assert fmu.get("energy.heat_cam1") == 0.0 < fmu.get("energy.heat_cam2")
