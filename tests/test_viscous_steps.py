"""Steps without inertia through a curved groove, under torques whose curvature a step hardly resolves.

The speed follows from the balance of torques (docs/mechanism.md, section 6): with the damper c v + q v^2
and the shaft's damping b, tau - b omega = rho (F + c v + q v^2), where rho is that of the supporting flanks.
SciPy integrates the speed. A step that the FMU accepts keeps the tolerance."""

import math

import numpy as np
import pytest
from driver import models
from mechanisms import LIFT, PRELOAD, RHO
from pin_equations import Pin, edge, ellipse, helix, polynomial, spring_force
from scipy.integrate import solve_ivp

PIN = Pin(helix(0.016, 0.416), ellipse(0.035, 0.456, 0.17, 0.15, 1))
MU, START = (0.13, 0.25), -0.08  # rad
DAMPING, LINEAR, SQUARE = 3e-4, 200.0, 3000.0  # N.m.s, N.s/m, N.s2/m2
PARAMETERS = PIN.values | {
    "cam1.friction": MU[0],
    "cam2.friction": MU[1],
    "spring.preload": 28.0,
    "spring.stiffness": 4200.0,
    "spring.stiffness2": 1.07e6,
    "spring.stiffness3": 1.05e8,
    "damper.c_load": LINEAR,
    "damper.q_load": SQUARE,
    "shaft.damping": DAMPING,
    "inertia.shaft": 0.0,
    "initial.theta": START,
    "stop.lower": -0.43,
    "stop.upper": 1.13,
}
# Step size in s; the torque and its derivatives.
STEPS = [
    (0.0005821887747379205, [0.4126335, 513.04958, 6193979.2, -36024577325.0]),
    (0.0006031448951155408, [1.3105457, 4150.7341, 8506520.0, -106475404707.0]),
    (0.0009812176328042644, [1.6042212, 976.02166, 7312514.4, -28361005722.0]),
    (0.0009280706308471897, [0.84450874, 293.17183, 3835132.9, -15073899204.0]),
    (0.002345514747325594, [0.80296342, -658.17529, 366386.38, 0.0]),
    (0.0026679270082481522, [0.71569277, 375.0171, 183227.22, -486859930.6]),
    (0.00109871753356184, [1.3468252, 1677.3388, 3232102.6, -16081632472.0]),
    (0.0013286363787621501, [1.2, 500.0, 2e6, -8e9]),
]


def speed(torque, theta):
    """omega >= 0 by the balance of torques; 0 inside the stick band."""
    place = PIN.at(theta)
    rho, force = edge(place, MU, 1, 1.0)[0], spring_force(PARAMETERS, place.z)
    left = torque - rho * force
    linear, square = DAMPING + rho * LINEAR * place.lift, rho * SQUARE * place.lift**2
    return 2.0 * left / (linear + math.sqrt(linear**2 + 4.0 * square * left)) if left > 0.0 else 0.0


@pytest.mark.parametrize("tolerance", [1.5e-7, 1e-6, 1e-5])
def test_an_accepted_step_keeps_the_tolerance(make_model, tolerance):
    for h, torque in STEPS:
        way = solve_ivp(
            lambda t, x, torque=torque: [speed(polynomial(torque, t), x[0])],
            (0.0, h), [START], method="DOP853", rtol=1e-13, atol=1e-16, max_step=h / 50,
        )  # fmt: skip
        assert all(speed(polynomial(torque, t), x) > 0.0 for t, x in zip(way.t, way.y[0], strict=True))
        fmu = make_model(models["DualCamForward"]).start(PARAMETERS, tolerance=tolerance)
        fmu.set({"tau": torque[0]})
        fmu.set_derivatives({"tau": torque[1:]})
        fmu.step(h)
        distance = np.ptp(way.y[0])
        assert abs(fmu.get("theta") - way.y[0, -1]) <= tolerance * distance


@pytest.mark.parametrize("tau", [1.0, 3.0])
def test_speed_under_quadratic_damping_alone(make_model, tau):
    """Two helices under a constant force: q v^2 = tau/rho - F, from the first instant on."""
    quadratic = {"damper.q_load": SQUARE, "spring.stiffness": 0.0, "inertia.shaft": 0.0, "stop.upper": 10.0}
    fmu = make_model(models["DualCamForward"]).start(quadratic)
    omega = math.sqrt((tau / RHO[1] - PRELOAD) / SQUARE) / LIFT
    for _ in range(3):
        fmu.step(0.01, tau=tau)
        assert fmu.get("omega") == pytest.approx(omega, rel=1e-9)
    assert fmu.get("theta") == pytest.approx(0.03 * omega, rel=1e-9)
    assert fmu.get("energy.heat_damper") == pytest.approx(SQUARE * (LIFT * omega) ** 3 * 0.03, rel=1e-8)


def test_a_motion_keeps_its_flanks_while_the_axial_load_passes_zero(make_model):
    """Several speeds balance the torque there, each with its own flanks. Steps of any length follow one."""
    p = {
        **{
            "cam1.radius": 0.013,
            "cam1.lead_angle": 0.27,
            "cam1.friction": 0.09,
            "cam1.friction_viscous": 1.0,
        },
        **{"cam2.radius": 0.02, "cam2.lead_angle": 1.12, "cam2.friction": 0.017},
        **{"cam2.friction_viscous": 0.019, "spring.preload": 1.0, "spring.stiffness": 0.0},
        **{"spring.stiffness2": 9.7e5, "inertia.shaft": 0.0, "damper.c_load": 0.0, "damper.q_load": 1.17},
    }
    h, steep, found = 2.2e-6, -1.5e12, []
    for pieces in (1, 16, 64):
        fmu = make_model(models["DualCamForward"]).start(p | {"tau": 4.5e-3, "F_ext": 1.0})
        for k in range(pieces):
            t = h * k / pieces
            fmu.set({"F_ext": 1.0 + steep * t * t / 2.0})
            fmu.set_derivatives({"F_ext": [steep * t, steep]})
            fmu.step(h / pieces)
        found.append(fmu.get("theta"))
    assert found[0] > 1e-4
    assert found == pytest.approx([found[0]] * 3, rel=1e-8)


def test_a_motion_stops_where_the_torque_comes_back_into_the_stick_band(make_model):
    """The damper still presses on the flanks of the motion while the spring's load F has changed its sign:
    tau = rho (F + q v^2). At rest the other flanks lock under F and hold tau from F = -tau/rho_locked on."""
    pin, mu, tau, start = Pin(helix(0.016, 0.12), helix(0.035, 0.12)), 0.5, 1.0, 0.2
    place = pin.at(start)
    rho, locked = (edge(place, (mu, mu), 1, sign)[0] for sign in (1.0, -1.0))
    assert locked > 0.0
    z, force, least = place.lift * start, 0.1 * tau / rho, -tau / locked  # F falls from `force` to `least`
    softening = (force - least) / (0.21 * z * z)  # F = preload - softening z^2: `least` after 1.1 z
    speed = [math.sqrt((tau / rho - load) / SQUARE) for load in (force, least)]
    h = 0.2 * z / sum(speed)  # s, up to there
    values = pin.values | {"cam1.friction": mu, "cam2.friction": mu, "initial.theta": start, "tau": tau}
    values |= {"spring.preload": force + softening * z * z, "spring.stiffness": 0.0, "inertia.shaft": 0.0}
    values |= {"spring.stiffness2": -softening, "damper.q_load": SQUARE, "stop.upper": 10.0}
    fmu = make_model(models["DualCamForward"]).start(values, tolerance=1e-4)
    for length in (0.01 * h, 1.4 * h):  # the first step begins at rest
        fmu.step(length)
    assert fmu.get("theta") == pytest.approx(1.1 * start, rel=1e-9)
    assert fmu.get("omega") == 0.0
