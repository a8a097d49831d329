"""Friction that depends on the nominal load in the design quantities (docs/mechanism.md, section 9)."""

import math

import numpy as np
import pytest

from dualcam import Fmu
from dualcam.__main__ import main
from dualcam.design import Helix, Mechanism, Pin, Spring, assess, wear
from dualcam.design.load_law import LoadPower, LoadSamples
from dualcam.design.tolerances.sampled_mechanism import sampled_band
from dualcam.design_file import read_design

HELIX = Helix(0.02, math.pi / 4)
LAW = LoadPower(-0.3, 80.0)
CAM = Mechanism((HELIX, HELIX), (0.14, 0.14), Spring(50.0, 5e4), 1.3963, load_laws=(LAW, LAW))
DESIGN = """
[cam1]
friction_load_exponent = -0.3
friction_load = "80 N"
[cam2]
lead_angle = "40 deg"
friction_table = "law.csv"
"""
TABLE = "v_m_s,R_N,mu\n0,50,0.22\n0.02,50,0.16\n0.2,50,0.14\n0,200,0.18\n0.02,200,0.13\n0.2,200,0.11\n"


def friction(force: float) -> float:
    """Of CAM: lead angle 45 deg, two pin ends, so N = F/(2 sqrt(2))."""
    load = force / (2 * math.sqrt(2))
    return 0.14 * ((load / 80.0) ** 2 + 0.01) ** -0.15


@pytest.mark.parametrize("theta", [0.0, 0.5, 1.3963])
def test_band_reactions_and_friction_angle_of_equal_helices(theta):
    """T = F r/2 (1 + sigma mu)/(1 - sigma mu); R = F/(4 cos 45 deg (1 - mu)) in both grooves when loading."""
    force = 50.0 + 5e4 * 0.01 * theta
    mu = friction(force)
    release, load = CAM.band(theta)
    assert load == pytest.approx(0.01 * force * (1 + mu) / (1 - mu), rel=1e-13)
    assert release == pytest.approx(0.01 * force * (1 - mu) / (1 + mu), rel=1e-13)
    assert CAM.torque(theta, "loading") == pytest.approx(load, rel=1e-13)
    found = assess(CAM, None, points=2)
    end = -1 if theta else 0
    if theta in (0.0, 1.3963):
        assert found.friction_angle[:, end] == pytest.approx([math.atan(mu)] * 2, rel=1e-13)
        assert found.load[:, end] == pytest.approx([force / 4 * math.sqrt(2) / (1 - mu)] * 2, rel=1e-13)


def test_depth_of_wear_follows_the_reactions():
    """A cycle wears K (R_load + R_release)/L; at theta = 0 the force is 50 N."""
    found = wear(CAM, Pin(radius=0.003, width=0.008), (1e-15, 1e-15))
    mu = friction(50.0)
    both = 50.0 / 4 * math.sqrt(2) * (1 / (1 - mu) + 1 / (1 + mu))
    assert found.depth[:, 0] == pytest.approx([1e-15 * both / 0.008] * 2, rel=1e-12)


def test_a_table_holds_its_samples_and_stays_at_the_last_ones():
    law = LoadSamples([50.0, 100.0, 400.0], [0.22, 0.2, 0.15])
    found = 0.2 * law.factor(np.array([1.0, 50.0, 100.0, 400.0, 1e4]))
    assert found == pytest.approx([0.22, 0.22, 0.2, 0.15, 0.15], rel=1e-14)


@pytest.mark.parametrize("law", [LAW, LoadSamples([50.0, 100.0, 400.0], [0.22, 0.2, 0.15])])
def test_derivatives_of_the_tolerances_are_those_of_differences(law):
    cam = Mechanism((HELIX, HELIX), (0.14, 0.14), Spring(50.0, 5e4), 1.3963, load_laws=(law, law))
    theta = np.array([0.3, 0.9])
    by_step = sampled_band(cam, {"spring.preload": np.array([50.0 + 1e-20j])}, theta).load.imag / 1e-20
    shifted = sampled_band(cam, {"spring.preload": np.array([49.99, 50.01])}, theta).load
    assert by_step[0] == pytest.approx((shifted[1] - shifted[0]) / 0.02, rel=1e-7)
    assert sampled_band(cam, {"spring.preload": np.array([50.0])}, theta).load[0] == pytest.approx(
        cam.band(theta)[1], rel=1e-13
    )


@pytest.fixture
def design_file(tmp_path):
    (tmp_path / "law.csv").write_text(TABLE, encoding="utf-8")
    (tmp_path / "my.toml").write_text(DESIGN, encoding="utf-8")
    return tmp_path / "my.toml"


def test_the_band_of_a_design_is_that_of_the_fmu(design_file):
    design = read_design(design_file)
    with Fmu("inverse") as fmu:
        for theta in (0.0, 0.4, 1.2):
            fmu.start(design.parameters | {"theta": theta})
            found = [fmu.real(name) for name in ("torque_release", "torque_load")]
            assert found == pytest.approx([*map(float, design.mechanism().band(theta))], rel=1e-11)


def test_a_groove_for_a_torque_says_that_it_leaves_the_load_out(design_file, capsys):
    words = ["design", str(design_file), "--torque", "5", "-o", str(design_file.with_name("groove.csv"))]
    main([*words, "--groove2", "given"])
    assert "without the dependence on the load" in capsys.readouterr().err
