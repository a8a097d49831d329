"""Scenes and helpers that several FMI 3.0 tests share."""

import math

import pytest
from driver3 import models
from mechanisms import INERTIA, LIFT, PRELOAD, RHO, STIFFNESS

MODE_CHANGES_MEET = 1e-9  # s: to the default tolerance, times of order 1 s

each_model = pytest.mark.parametrize("model", models.values(), ids=repr)

ELLIPSES = {"cam1.profile": 2, "cam2.profile": 2, "stop.upper": 0.6}
FORCES = {
    "spring.stiffness3": 1e6, "damper.c_load": 20.0, "damper.q_release": 5.0, "inertia.follower_mass": 0.3,
    "inertia.follower": 1e-4, "shaft.damping": 0.001,
}  # fmt: skip
GENERAL = ELLIPSES | FORCES
BOUNCING = {"stop.restitution": 0.6}


def frequency(sigma: int) -> float:
    """Angular frequency of the oscillation about the balance, rad/s."""
    return math.sqrt(RHO[sigma] * STIFFNESS * LIFT / INERTIA)


def balance(sigma: int, tau: float) -> float:
    """Angle at which spring and friction balance tau, rad."""
    return (tau / RHO[sigma] - PRELOAD) / (STIFFNESS * LIFT)


def wave(t: float) -> float:
    """Torque, N.m, under which the mechanism sticks, slips in both directions and meets the lower stop."""
    return 2.5 + 2.5 * math.sin(2 * math.pi * 7 * t)


def events_of(fmu, until: float, h: float, torque) -> list[tuple[float, int]]:
    """Time and mode after each early return, the torque constant over each step of h."""
    found = []
    while fmu.time < until - 1e-12:
        goal = min(until, (math.floor(fmu.time / h + 1e-9) + 1) * h)
        event, early = fmu.step(goal - fmu.time, tau=torque(goal - h))
        assert event or not early
        if event:
            found.append((fmu.time, fmu.get("mode")))
            assert fmu.handle_event()["again"] is False
    return found
