"""FMI 3.0: the same mechanism as in FMI 2.0."""

import math

import driver as fmi2
import fmpy
import numpy as np
import pytest
from driver3 import FORWARD, INVERSE
from fmi3_scenes import BOUNCING, FORCES, GENERAL, wave
from reference import LOADING, LOWER_STOP, STICK, UPPER_STOP


@pytest.mark.parametrize("scene", [{}, GENERAL, BOUNCING, {"inertia.shaft": 0.0}], ids=str)
def test_co_simulation_is_bit_for_bit_that_of_fmi2(make_model, make3, scene):
    old, new = make_model(fmi2.FORWARD).start(scene), make3().start(scene)
    modes = set()
    for k in range(400):
        h = 1e-3 * (1 + k % 3)
        inputs = {"tau": wave(new.time), "F_ext": 3.0 * (k % 5)}
        old.step(h, **inputs)
        assert new.step(h, **inputs) == (False, False)
        assert new.get("time") == new.time
        for name in fmi2.FORWARD.variables:
            if k % 20 == 0 or name in ("theta", "omega", "mode", "energy.residual"):
                assert new.get(name) == old.get(name), (name, k)
        modes.add(new.get("mode"))
    assert (modes & {LOWER_STOP, UPPER_STOP} or new.get("energy.heat_stop") > 0) and len(modes) >= 2


def test_friction_tables_are_those_of_fmi2(make_model, make3, tmp_path):
    (tmp_path / "law.csv").write_text("v_m_s,mu\n0,0.2\n0.01,0.15\n0.1,0.12\n")
    table = {f"cam{i}.friction_table": str(tmp_path / "law.csv") for i in (1, 2)}
    for of2, of3, inputs in (
        (fmi2.FORWARD, FORWARD, {"tau": 7.0}),
        (fmi2.models["DualCamInverse"], INVERSE, {"theta": 0.1, "omega": 3.0}),
    ):
        old, new = make_model(of2).start(table), make3(of3).start(table)
        assert old.get("cam1.friction_coefficient") == 0.2
        for _ in range(3):
            old.step(0.01, **inputs)
            new.step(0.01, **inputs)
            for name in ("cam1.friction_coefficient", "z", "energy.heat_cam1", "torque_load"):
                assert new.get(name) == old.get(name)


@pytest.mark.parametrize("stiffness", [0.0, 20.0])
def test_inverse_co_simulation_is_bit_for_bit_that_of_fmi2(make_model, make3, stiffness):
    scene = FORCES | {"shaft.stiffness": stiffness}
    old = make_model(fmi2.models["DualCamInverse"]).start(scene)
    new = make3(INVERSE).start(scene)
    for _ in range(200):
        new.set({"F_ext": 2.0})
        t = new.time + 1e-3
        motion = {"theta": 0.4 * (1 - math.cos(40 * t)), "omega": 16.0 * math.sin(40 * t), "F_ext": 2.0}
        old.step(1e-3, **motion)
        new.step(1e-3, **motion)
        for name in fmi2.models["DualCamInverse"].variables:
            assert new.get(name) == old.get(name), name


def simulate(model, kind: str, **options):
    options = {"stop_time": 0.2, "output_interval": 1e-3, "relative_tolerance": 1e-9} | options
    if kind == "CoSimulation":
        options |= {"step_size": 1e-3}
    return fmpy.simulate_fmu(str(model.fmu), fmi_type=kind, validate=True, **options)


@pytest.mark.parametrize("scene", [{}, {"cam1.profile": 2, "cam2.profile": 2}], ids=["helices", "ellipses"])
def test_model_exchange_agrees_with_co_simulation(scene):
    """Through FMPy, CVode against the FMU's own integrator, with a constant torque: slip, then stick."""
    start = {"tau": 2.0, "damper.c_load": 50.0, "damper.c_release": 50.0, **scene}
    found = [
        simulate(FORWARD, kind, start_values=start, output=["theta", "omega", "mode", "alpha"])
        for kind in ("CoSimulation", "ModelExchange")
    ]
    own, outer = found
    outer = outer[np.searchsorted(outer["time"], own["time"] - 1e-12, side="left")]
    assert np.max(np.abs(own["theta"] - np.interp(own["time"], found[1]["time"], found[1]["theta"]))) < 1e-6
    assert own["mode"][-1] == found[1]["mode"][-1] == STICK
    assert LOADING in own["mode"]


def test_model_exchange_of_the_inverse_fmu():
    times = np.linspace(0, 0.2, 201)
    angle = 20 * math.pi * times
    columns = [
        times,
        0.4 * (1 - np.cos(angle)),
        8 * math.pi * np.sin(angle),
        160 * math.pi**2 * np.cos(angle),
    ]
    given = np.rec.fromarrays([*columns, 0 * times], names=["time", "theta", "omega", "alpha", "F_ext"])
    own, outer = (
        simulate(INVERSE, kind, input=given, output=["tau"]) for kind in ("CoSimulation", "ModelExchange")
    )
    # co-simulation reaches what is set before a step at its end: one row later
    rows = np.searchsorted(outer["time"], own["time"][40:45])
    assert np.allclose(own["tau"][41:46], outer["tau"][rows], rtol=1e-9, atol=1e-9)
