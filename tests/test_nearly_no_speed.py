"""Speeds and distances far below the rounding of theta: the motion is that from rest, and costs no refusal.

The axial force F_ext = R t presses the follower down. The shaft turns up by hardly anything, turns back, and
rests at its lower stop.
"""

import math

import pytest
from driver import FORWARD
from reference import LOWER_STOP, RELEASING

SPEEDS = [1e-10, 1e-20, 1e-40, 1e-60, 1e-100, 1e-200, 1e-307, 3e-309]  # rad/s
RATE, INERTIA = 1.0, 1.0  # N/s, kg.m2
NOTHING = 1e-150  # J
HEATS = ["heat_cam1", "heat_cam2", "heat_damper", "heat_stop"]

PARAMETERS = {
    "cam1.radius": 0.1,
    "cam2.radius": 0.01,
    "cam1.lead_angle": 1.0,
    "cam2.lead_angle": 1.0,
    "cam1.friction": 0.1,
    "cam2.friction": 0.1,
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
    "damper.c_load": 1.0,
    "damper.c_release": 1.0,
    "damper.q_load": 1.0,  # N.s2/m2: by collocation
    "damper.q_release": 1.0,
    "inertia.shaft": INERTIA,
    "inertia.follower_mass": 0.0,
    "inertia.follower": 0.0,
    "stop.lower": 0.0,
    "stop.upper": 1.0,
}


def pressed_down(make_model, parameters):
    fmu = make_model(FORWARD).start(PARAMETERS | parameters)
    fmu.set_derivatives({"F_ext": [RATE]})
    fmu.step(1.0)
    return fmu


def assert_rests_at_stop(fmu, speed, heats=HEATS):
    """With heats no larger than the energy of a motion at `speed`, rad/s."""
    assert (fmu.get("theta"), fmu.get("omega"), fmu.get("mode")) == (0.0, 0.0, LOWER_STOP)
    for name in heats:
        assert -NOTHING <= fmu.get(f"energy.{name}") <= 100.0 * INERTIA * speed**2 + NOTHING


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_bounce_off_the_stop_with_nearly_no_speed_ends_at_the_stop(make_model, speed):
    """The impact at 1 rad/s leaves speed rad/s; its heat is the energy J/2 to rounding."""
    fmu = pressed_down(make_model, {"initial.omega": -1.0, "stop.restitution": speed})
    assert_rests_at_stop(fmu, speed, HEATS[:3])
    assert fmu.get("energy.heat_stop") == pytest.approx(INERTIA / 2.0, rel=1e-15)


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_start_with_nearly_no_speed_ends_at_the_stop(make_model, speed):
    assert_rests_at_stop(pressed_down(make_model, {"initial.omega": speed}), speed)


@pytest.mark.parametrize("distance", [1e-14, 1e-20, 1e-40, 1e-200, 3e-309])  # rad
def test_a_start_nearly_at_the_stop_ends_at_the_stop(make_model, distance):
    fmu = pressed_down(make_model, {"initial.theta": distance})
    assert_rests_at_stop(fmu, math.sqrt(distance))


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_motion_with_nearly_no_speed_is_that_from_rest(make_model, speed):
    ends = []
    for omega in (0.0, speed):
        fmu = pressed_down(make_model, {"initial.theta": 0.5, "initial.omega": omega})
        assert fmu.get("mode") == RELEASING
        ends.append([fmu.get(name) for name in ("theta", "omega", "energy.heat_cam1", "energy.work_ext")])
    assert ends[1] == pytest.approx(ends[0], rel=1e-6)
