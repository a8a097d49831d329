"""FMI 3.0: event mode and early return."""

import math

import fmpy
import numpy as np
import pytest
from driver3 import FORWARD, INVERSE
from fmi3_scenes import BOUNCING, ELLIPSES, GENERAL, MODE_CHANGES_MEET, balance, events_of, frequency, wave
from mechanisms import LIFT, STIFFNESS
from reference import LOADING, LOWER_STOP, RELEASING, STICK


def test_early_return_is_at_the_time_of_the_closed_form(make3):
    """Swing up under a constant torque to velocity zero, half a period later; then released onto the stop."""
    fmu = make3(events=True, early=True).start()
    event, early = fmu.step(1.0, tau=2.0)
    rest = math.pi / frequency(1)
    assert (event, early) == (True, True)
    assert fmu.time == pytest.approx(rest, rel=1e-13)
    assert fmu.get("time") == fmu.time
    assert (fmu.get("mode"), fmu.get("omega")) == (STICK, 0.0)
    top = 2 * balance(1, 2.0)
    assert fmu.get("theta") == pytest.approx(top, rel=1e-13)
    assert fmu.handle_event() == dict.fromkeys(("again", "terminate", "nominals", "moved", "timed"), False)
    assert fmu.step(0.1, tau=2.0) == (False, False)  # it holds
    assert fmu.time == pytest.approx(rest + 0.1, rel=1e-15)
    start = fmu.time
    assert fmu.step(1.0, tau=0.0) == (True, True)
    low = balance(-1, 0.0)
    fall = math.acos(low / (low - top)) / frequency(-1)
    assert fmu.time - start == pytest.approx(fall, rel=1e-12)
    assert (fmu.get("mode"), fmu.get("theta"), fmu.get("omega")) == (LOWER_STOP, 0.0, 0.0)
    assert abs(fmu.get("energy.residual")) < 1e-14


def test_the_jacobian_after_an_early_return_is_that_of_the_part_made(make3):
    """The swing up ends at 2 (tau/rho - F_0)/(k z'), from where the mechanism swings back at once."""
    mu = 0.02
    fmu = make3(events=True, early=True).start({"cam1.friction": mu, "cam2.friction": mu})
    assert fmu.step(1.0, tau=2.0) == (True, True)
    assert fmu.get("mode") == RELEASING and fmu.time < 0.5
    rho = LIFT * (1.0 + mu) / (1.0 - mu)  # lead angles of 45 deg
    assert fmu.get("step.dtheta_dtau") == pytest.approx(2.0 / (rho * STIFFNESS * LIFT), rel=1e-9)


def test_a_change_brought_about_by_the_input_is_none_of_the_step(make3):
    """Stick to loading at the very start; the step goes on to the change after it."""
    fmu = make3(events=True, early=True).start()
    assert fmu.get("mode") == LOWER_STOP
    fmu.step(1e-3, tau=2.0)
    assert (fmu.get("mode"), fmu.time) == (LOADING, 1e-3)


def bisect(make3, scene, torque: float, interval: tuple[float, float]) -> float:
    """When the mode changes, found with whole steps and snapshots only."""
    fmu = make3().start(scene)
    fmu.step(interval[0], tau=torque)
    state, before, origin = fmu.take(), fmu.get("mode"), fmu.time
    low, high = 0.0, interval[1] - interval[0]
    while high - low > 1e-13:
        middle = 0.5 * (low + high)
        fmu.restore(state)
        fmu.time = origin
        fmu.step(middle)
        low, high = (middle, high) if fmu.get("mode") == before else (low, middle)
    fmu.free_state(state)
    return origin + high


@pytest.mark.parametrize(
    "scene", [ELLIPSES, GENERAL, GENERAL | BOUNCING], ids=["ellipses", "forces", "bounces"]
)
def test_early_return_is_where_bisection_finds_the_change(make3, scene):
    fmu = make3(events=True, early=True).start(scene)
    count = 0
    for torque in (2.0, 0.0):
        start = fmu.time
        event, early = fmu.step(0.5, tau=torque)
        assert event and early
        if torque > 0:
            found = bisect(make3, scene, torque, (0.5 * fmu.time, 0.5))
            assert fmu.time == pytest.approx(found, abs=MODE_CHANGES_MEET)
        assert fmu.time > start
        fmu.handle_event()
        count += 1
    assert count == 2


@pytest.mark.parametrize(
    ("scene", "tolerance"), [({}, 1e-13), (BOUNCING, 1e-11), (GENERAL, 1e-8), (GENERAL | BOUNCING, 1e-8)]
)
def test_parts_of_a_step_give_what_the_whole_step_gives(make3, scene, tolerance):
    parts, whole = make3(events=True, early=True).start(scene), make3().start(scene)
    h, until = 0.03, 0.9
    changes = events_of(parts, until, h, wave)
    for k in range(round(until / h)):
        whole.step(h, tau=wave(k * h))
    assert len(changes) > 10 and len({mode for _, mode in changes}) >= 3
    assert parts.get("events") == whole.get("events")
    for name in ("theta", "omega", "energy.work_in", "energy.heat_cam1", "energy.heat_stop", "peak.omega"):
        assert parts.get(name) == pytest.approx(whole.get(name), rel=tolerance, abs=tolerance), name
    assert abs(parts.get("energy.residual")) < 1e-9


def test_without_early_return_only_the_end_of_the_step_is_an_event(make3):
    fmu = make3(events=True).start()
    assert fmu.step(0.2, tau=2.0) == (False, False)  # the change was inside
    assert fmu.get("mode") == STICK and fmu.time == 0.2


def test_a_plain_master_never_sees_an_event(make3):
    for options in ({}, {"early": True}):
        fmu = make3(**options).start()
        for _ in range(20):
            assert fmu.step(0.02, tau=wave(fmu.time)) == (False, False)
        assert fmu.time == pytest.approx(0.4, rel=1e-14)


def test_event_mode_takes_new_inputs_and_parameters(make3):
    fmu = make3(events=True, early=True).start()
    fmu.ok("EnterEventMode")
    fmu.set({"tau": 2.0, "cam1.friction": 0.1})
    fmu.settle()
    assert fmu.get("mode") == LOADING
    fmu.ok("EnterStepMode")
    event, early = fmu.step(1.0)
    assert event and early and fmu.get("omega") == 0.0
    assert abs(fmu.get("energy.residual")) < 1e-14


def test_events_of_the_inverse_fmu_are_at_the_end_of_its_steps(make3):
    fmu = make3(INVERSE, events=True, early=True).start()
    assert fmu.step(0.1, theta=0.1, omega=1.0) == (True, False)
    assert fmu.step(0.1, theta=0.2, omega=1.0) == (False, False)
    assert fmu.step(0.1, theta=0.2, omega=-1.0) == (True, False)
    fmu.handle_event()
    assert fmu.get("mode") == RELEASING


def test_fmpy_with_event_mode_and_early_return():
    """The same swing through FMPy, which enters event mode where it is told to."""
    found = fmpy.simulate_fmu(
        str(FORWARD.fmu), stop_time=0.1, output_interval=1e-2, start_values={"tau": 2.0},
        output=["theta", "mode"], use_event_mode=True, early_return_allowed=True,
    )  # fmt: skip
    assert np.min(np.abs(found["time"] - math.pi / frequency(1))) < 1e-12
    assert found["theta"][-1] == pytest.approx(2 * balance(1, 2.0), rel=1e-12)


@pytest.mark.parametrize("h", [1e16, 1e300, 1.7e308])
def test_early_return_from_an_endless_step_is_not_before_the_step(make3, h):
    """The time of the mode change, t + h less what is left of the step, rounds to zero."""
    fmu = make3(events=True, early=True).start()
    fmu.step(0.01, tau=2.0)
    begin = fmu.time
    assert fmu.step(h, tau=2.0) == (True, True)
    assert begin <= fmu.time < begin + h
    assert fmu.get("time") == fmu.time
