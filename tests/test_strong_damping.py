"""Damping that ends a motion within nanoseconds, under torques and forces that rise through a whole step.

The slow part of the motion is lost in the rounding of the derivatives at the start. Oracle: the closed form
at 60 digits (tests/reference).
"""

import math
from itertools import product

import pytest
import reference
from driver import VARIABLES
from reference import Interval
from scipy.integrate import solve_ivp

HELICES = {"cam1.radius": 0.02, "cam2.radius": 0.03, "cam1.lead_angle": 0.7, "cam2.lead_angle": 0.6}
FORCES = {"spring.preload": 20.0, "spring.stiffness": 1e3, "inertia.shaft": 1e-12}
DAMPING = {"damper.c_load": 50.0, "damper.c_release": 10.0}  # 1e9 and 4e8 times J per s
STOPS = {"stop.lower": -1.0, "stop.upper": 1.4, "stop.restitution": 0.5}


ALL = list(product((0.0, 0.1), (4e5, -4e5, 1e-3), (-30.0, 0.0, 40.0), (0.0, 0.4)))
QUICK = [(0.0, 4e5, -30.0, 0.0), (0.1, 1e-3, -30.0, 0.4), (0.1, -4e5, 0.0, 0.4)]


@pytest.mark.parametrize(
    ("friction", "omega", "force_rate", "torque_rate"),
    QUICK + [pytest.param(*case, marks=pytest.mark.long) for case in ALL if case not in QUICK],
)
def test_a_motion_damped_at_once_turns_at_the_right_place(make, friction, omega, force_rate, torque_rate):
    """One step of 1 s: a start at high speed, the turn after nanoseconds, the slow return, further turns."""
    parameters = HELICES | FORCES | DAMPING | STOPS | {"initial.omega": omega, "initial.theta": 0.4}
    parameters |= {"cam1.friction": friction, "cam2.friction": friction}
    interval = Interval(1.0, -0.02, torque_rate, 0.0, force_rate)
    (expected,) = reference.simulate_exact(parameters, [interval])
    fmu = make().start(parameters)
    fmu.set({"tau": interval.tau, "F_ext": 0.0})
    fmu.set_rates(tau=torque_rate, F_ext=force_rate)
    fmu.ok("fmi2DoStep", 0.0, 1.0, 1)
    assert fmu.get("theta") == pytest.approx(expected.theta, abs=1e-11)
    assert fmu.get("omega") == pytest.approx(expected.omega, abs=1e-9)
    assert fmu.get("mode") == expected.mode
    for name in (n for n in VARIABLES if n.startswith("energy.heat") or n == "energy.work_in"):
        assert fmu.get(name) == pytest.approx(expected.energy[name.removeprefix("energy.")], abs=1e-10)


def test_years_instead_of_seconds_change_no_energy(make):
    """The same motion in a unit of time of 1e10 s: masses times its square, dampers times the unit."""
    unit, way = 1e10, {"initial.theta": 0.4, "cam1.friction": 0.0, "cam2.friction": 0.0}
    slow = {name: unit * value for name, value in DAMPING.items()} | {"initial.omega": -4e5 / unit}
    parameters = HELICES | STOPS | way | FORCES | slow | {"inertia.shaft": 1e-12 * unit**2}
    interval = Interval(unit, -0.02, 0.0, 0.0, -30.0 / unit)
    (expected,) = reference.simulate_exact(parameters, [interval])
    fmu = make().start(parameters)
    fmu.set({"tau": interval.tau, "F_ext": 0.0})
    fmu.set_rates(F_ext=interval.F_ext_rate)
    fmu.ok("fmi2DoStep", 0.0, unit, 1)
    assert fmu.get("theta") == pytest.approx(expected.theta, abs=1e-11)
    assert unit * fmu.get("omega") == pytest.approx(unit * expected.omega, abs=1e-9)
    for name in ("energy.heat_damper", "energy.work_in", "energy.work_ext"):
        assert fmu.get(name) == pytest.approx(expected.energy[name.removeprefix("energy.")], abs=1e-10)


@pytest.mark.parametrize("cut", [0.01, 0.1, 0.5])
def test_a_force_that_grows_a_thousandfold_in_a_step(make, cut):
    """A quadratic damper and next to no inertia: the speed is that at which the forces balance,
    q (z' omega)^2 = F_s(z) + F_ext - tau/z'. The rounding of the forces hides the slow part of alpha."""
    square, end, tau, force, cubed = 4e5, 2.6e-3, 0.02, 1.9, 5.6e11  # N.s2/m2, s, N.m, N, N/s3
    parameters = HELICES | STOPS | {"cam1.friction": 0.0, "cam2.friction": 0.0, "damper.q_release": square}
    parameters |= {"spring.preload": 2.6, "spring.stiffness": 15.0, "inertia.shaft": 1e-18}
    slopes = [parameters[f"cam{i}.radius"] * math.tan(parameters[f"cam{i}.lead_angle"]) for i in (1, 2)]
    lift = slopes[0] * slopes[1] / sum(slopes)

    def speed(t, theta):
        load = 2.6 + 15.0 * lift * theta[0] + force + cubed * t**3 / 6.0 - tau / lift
        return [-math.sqrt(load / square) / lift]

    found = solve_ivp(speed, (0.0, end), [0.0], "DOP853", rtol=1e-13, atol=1e-15)
    fmu = make().start(parameters)
    for t, h in ((0.0, cut * end), (cut * end, (1.0 - cut) * end)):
        fmu.set({"tau": tau, "F_ext": force + cubed * t**3 / 6.0})
        fmu.set_derivatives({"F_ext": [cubed * t**2 / 2.0, cubed * t, cubed]})
        fmu.step(h)
    assert fmu.get("theta") == pytest.approx(found.y[0, -1], abs=1e-9)
