"""The bridge to python-control: the sampled plant."""

import gc
import random
import tempfile

import control
import numpy as np
import pytest
from control_cases import ALL, FORWARD, PERIOD, edge
from mechanisms import GROOVES, INERTIA, LIFT, PRELOAD, RHO, STIFFNESS

import dualcam
from dualcam import ContinuousFmu


def torques(count, period):
    return 3.0 + 6.0 * np.sin(2.0 * np.pi * 3.0 * period * np.arange(count))


@pytest.mark.parametrize("period", [1e-4, 1e-3, 0.0123, 0.3])
@pytest.mark.parametrize(
    "parameters",
    [{}, {"stop.restitution": 0.5}, GROOVES["mixed"] | ALL],
    ids=["helices", "bounces", "all"],
)
def test_a_sampled_plant_is_the_stepped_fmu(slave, parameters, period):
    """Through stick, slip, stops and bounces; all that it forgets between periods is the mode."""
    count = max(200, round(0.3 / period))
    system = dualcam.to_nonlinear_io_system(FORWARD, "tau", None, parameters, period)
    time = period * np.arange(count + 1)
    found = control.input_output_response(system, time, torques(count + 1, period), [0.5, 1.0])
    slave.start(parameters | {"initial.theta": 0.5, "initial.omega": 1.0})
    command, outputs = slave.reals("tau"), slave.reals("theta", "omega", "z", "v")
    events = slave.get("events")
    for k, tau in enumerate(torques(count + 1, period)):
        assert found.outputs[:, k] == pytest.approx(outputs.read(), rel=1e-7, abs=1e-9)
        command.values[0] = tau
        command.write()
        slave.step(period)
    assert slave.get("events") > events


def test_outputs_in_one_text():
    system = dualcam.to_nonlinear_io_system(FORWARD, "tau", "theta, spring.force", period=PERIOD)
    assert (system.input_labels, system.output_labels) == (["tau"], ["theta", "spring_force"])


def test_a_sampled_plant_forgets(sampled):
    states = [(0.5, 2.0, 3.0), (0.5, -2.0, 3.0), (0.5, 0.0, 3.0), (1.3963, 1.0, 5.0), (0.9, 0.0, 9.0)]
    order = states * 5
    random.Random(2).shuffle(order)
    found = {}
    for theta, omega, tau in order:
        x = sampled.dynamics(0.0, [theta, omega], [tau, 0.0]).tolist()
        sampled.output(0.0, [0.1, 0.0], [0.0, 0.0])
        assert found.setdefault((theta, omega, tau), x) == x


def test_without_inertia_it_is_the_play_of_the_torque():
    system = dualcam.to_nonlinear_io_system(FORWARD, "tau", "theta", {"inertia.shaft": 0.0}, 0.01)
    theta = 0.5
    for tau in (3.0, 4.5, 4.0, 3.0, 2.0, 6.0):
        low, high = ((tau / RHO[sign] - PRELOAD) / (STIFFNESS * LIFT) for sign in (+1, -1))
        theta, wanted = system.dynamics(0.0, [theta, 0.0], [tau])[0], min(max(theta, low), high)
        assert theta == pytest.approx(wanted, rel=1e-12)


def test_other_outputs_and_an_input_left_out():
    outputs = dict.fromkeys(["alpha", "mode", "torque_load", "cam1.reaction", "theta"]).keys()
    for period in (None, PERIOD):
        system = dualcam.to_nonlinear_io_system(FORWARD, "tau", outputs, {"F_ext": 25.0}, period)
        assert system.output_labels == ["alpha", "mode", "torque_load", "cam1_reaction", "theta"]
        found = dict(zip(outputs, system.output(0.0, [0.5, 2.0], [3.0]), strict=True))
        assert found["alpha"] == pytest.approx((3.0 - edge(+1, 0.5, 25.0)) / INERTIA, rel=1e-9)
        assert found["torque_load"] == pytest.approx(edge(+1, 0.5, 25.0), rel=1e-12)
        assert (found["mode"], found["theta"]) == (2.0, 0.5)
        assert found["cam1.reaction"] > 0.0


def test_a_handle_gives_its_parameters(slave):
    slave.start({"spring.preload": 80.0, "initial.theta": 1.0})
    for system in (
        dualcam.to_nonlinear_io_system(slave, outputs="torque_load"),
        dualcam.to_nonlinear_io_system(slave, outputs="torque_load", period=PERIOD),
    ):
        assert system.output(0.0, [0.5, 0.0], [3.0, 0.0]) == pytest.approx(RHO[+1] * (80.0 + 250.0))
    assert slave.get("theta") == 1.0  # itself it stays as it is
    with ContinuousFmu(FORWARD) as fmu:
        fmu.start({"inertia.shaft": 0.004})
        assert dualcam.linearize(fmu, 0.5, 1.0).B[1, 0] == pytest.approx(250.0)


@pytest.mark.parametrize("period", [None, PERIOD])
def test_systems_free_their_fmu(period, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    system = dualcam.to_nonlinear_io_system(FORWARD, period=period)
    twin = system.copy()
    assert list(tmp_path.iterdir())
    del system, twin
    gc.collect()
    assert not list(tmp_path.iterdir())
