"""A jump of the torque that carries the pin almost to the angle where the contacts lock.

Without inertia theta follows the edge of the stick band (docs/mechanism.md, section 6). Both grooves are
equal ellipses that steepen, so that gamma = theta/2 and T = F/(2 kappa), kappa = (1 - mu s)/(r (s + mu)). The
torque grows without bound where mu s = 1. No rule with equal steps integrates heat and work up to there.
"""

import math

import pytest
from reference import UPPER_STOP
from scipy.integrate import quad

RADIUS, FRICTION, LEAD, AXIS = 0.02, 0.5, 0.6, 0.05  # m, 1, rad, m
PRELOAD, STIFFNESS, WEAR = 50.0, 50e3, 1e-15
CAM = {
    "radius": RADIUS,
    "profile": 2,
    "lead_angle": LEAD,
    "ellipse_a": AXIS,
    "ellipse_b": AXIS,
    "ellipse_curvature": 1,
    "friction": FRICTION,
    "wear": WEAR,
}
PARAMETERS = {f"cam{i}.{name}": value for i in (1, 2) for name, value in CAM.items()} | {"inertia.shaft": 0.0}
# With a = b the sine of the lead angle is linear in theta. The contacts lock where the tangent is 1/mu.
LOCK = 2.0 * (math.sin(math.atan(1.0 / FRICTION)) - math.sin(LEAD)) * AXIS / RADIUS


def sine(theta):
    return math.sin(LEAD) + RADIUS * 0.5 * theta / AXIS


def slope(theta):
    return sine(theta) / math.sqrt(1.0 - sine(theta) ** 2)


def axial_force(theta):
    return PRELOAD + STIFFNESS * AXIS * (math.cos(LEAD) - math.sqrt(1.0 - sine(theta) ** 2))


def edge(theta):
    """The torque that loads, N.m."""
    s = slope(theta)
    return axial_force(theta) * RADIUS * (s + FRICTION) / (2.0 * (1.0 - FRICTION * s))


def heat_of_a_cam(theta):
    """Half of the torque that the spring does not take, N.m."""
    return 0.5 * (edge(theta) - axial_force(theta) * RADIUS * 0.5 * slope(theta))


def integral(function, end):
    return quad(function, 0.0, end, epsabs=0.0, epsrel=1e-13, limit=1000)[0]


@pytest.mark.parametrize("gap", [1e-1, 1e-2, 1e-3, 1e-4])  # rad
def test_jump_to_a_stop_before_the_lock(make, gap):
    stop = LOCK - gap
    fmu = make().start(PARAMETERS | {"stop.upper": stop, "tau": 0.0})
    fmu.step(0.01, tau=1e7)
    assert (fmu.get("mode"), fmu.get("theta")) == (UPPER_STOP, stop)
    heat = integral(heat_of_a_cam, stop)
    wear = WEAR * heat / (2.0 * FRICTION)  # of one of two contacts
    reaction = edge(stop) * math.sqrt(1.0 + slope(stop) ** 2) / (RADIUS * (slope(stop) + FRICTION)) / 2.0
    for cam in (1, 2):
        assert fmu.get(f"energy.heat_cam{cam}") == pytest.approx(heat, rel=1e-10)
        assert fmu.get(f"wear.cam{cam}") == pytest.approx(wear, rel=1e-10)
        assert fmu.get(f"peak.reaction{cam}") == pytest.approx(reaction, rel=1e-9)
    assert fmu.get("energy.work_in") == pytest.approx(integral(edge, stop), rel=1e-10)
