"""Planning with CasADi against Pontryagin's principle; CasADi's view of the FMU against SciPy."""

import math

import casadi
import numpy as np
import pytest
from driver import ROOT
from scipy.integrate import solve_bvp, solve_ivp

from dualcam import Fmu
from dualcam.systems.blocks.radau_grid import RadauGrid
from dualcam.systems.machines import elbow
from system_examples import planned_elbow as example

FORWARD = ROOT / "build/DualCamForward.fmu"
INERTIA = elbow.inertia(elbow.DESIGN_PAYLOAD)
CAM, LOAD = elbow.design_cam(), elbow.weight(elbow.DESIGN_PAYLOAD)


@pytest.fixture(scope="module")
def results():
    return example.run(FORWARD)


def releasing_torque(theta):
    """T_release is affine in theta: helices and a linear spring."""
    low, high = CAM.band(0.0)[0], CAM.band(1.0)[0]
    return low + (high - low) * theta, high - low


def least_heat():
    """The boundary value problem of Pontryagin's principle for J alpha = tau_motor + tau_gravity - T_release.

    With the cost integral of tau_motor^2: tau_motor = -p_omega/(2 J), p_theta' = -p_omega/J d(tau_gravity -
    T_release)/d theta, p_omega' = -p_theta.
    """
    weight = LOAD.moment * LOAD.gravity

    def rates(_t, y):
        theta, omega, p_theta, p_omega = y
        released, slope = releasing_torque(theta)
        carried = weight * np.sin(LOAD.lean + theta)
        motor = -p_omega / (2.0 * INERTIA)
        by_theta = (weight * np.cos(LOAD.lean + theta) - slope) / INERTIA
        return np.array([omega, (motor + carried - released) / INERTIA, -p_omega * by_theta, -p_theta])

    def ends(first, last):
        return np.array([first[0] - example.LOW, first[1], last[0] - example.HIGH, last[1]])

    time = np.linspace(0.0, example.DURATION, 50)
    guess = np.zeros((4, 50))
    guess[0] = np.linspace(example.LOW, example.HIGH, 50)
    solved = solve_bvp(rates, ends, time, guess, tol=1e-9, max_nodes=20_000)
    assert solved.success
    return solved, lambda t: -solved.sol(t)[3] / (2.0 * INERTIA)


def test_the_plan_is_the_optimum(results):
    planned = results.planned
    solved, motor = least_heat()
    theta, omega = solved.sol(example.GRID.time)[:2]
    assert planned.theta == pytest.approx(theta, abs=1e-6)
    assert planned.omega == pytest.approx(omega, abs=1e-5)
    assert planned.motor_torque == pytest.approx(motor(example.GRID.time[1:]), abs=2e-3)
    node, weight = np.polynomial.legendre.leggauss(40)
    t = 0.5 * example.DURATION * (1.0 + node)
    heat = example.HEAT * 0.5 * example.DURATION * np.sum(weight * motor(t) ** 2)
    assert planned.heat == pytest.approx(heat, rel=1e-8)
    assert planned.heat < results.jerk_heat


def test_the_heat_of_minimum_jerk_is_that_of_the_inverse_fmu(results):
    n = 2000
    step = example.DURATION / n
    s = (np.arange(n) + 0.5) / n
    length = example.HIGH - example.LOW
    motion = np.array(
        [
            example.LOW + length * s**3 * (10.0 + s * (6.0 * s - 15.0)),
            length / example.DURATION * 30.0 * s**2 * (1.0 - s) ** 2,
            length / example.DURATION**2 * (60.0 * s - 180.0 * s**2 + 120.0 * s**3),
        ]
    )
    heat = 0.0
    start = elbow.plant_parameters(CAM, elbow.DESIGN_PAYLOAD)
    with Fmu(ROOT / "build/DualCamInverse.fmu") as fmu:
        first = dict(zip(("theta", "omega", "alpha"), motion[:, 0], strict=True))
        fmu.start({name: v for name, v in start.items() if name in fmu.names} | first)
        inputs = fmu.reals("theta", "omega", "alpha")
        for row in motion.T:
            inputs.values[:] = row
            inputs.write()
            heat += example.HEAT * step * (fmu.real("tau") - LOAD.torque(row[0])) ** 2
    assert results.jerk_heat == pytest.approx(heat, rel=1e-5)  # the rule of midpoints


def test_co_simulation_follows_the_plan_and_the_cam_holds(results):
    replay = results.as_planned
    assert replay.theta == pytest.approx(results.planned.theta[:: example.GRID.nodes], abs=1e-8)
    assert replay.omega == pytest.approx(results.planned.omega[:: example.GRID.nodes], abs=1e-7)
    assert (replay.mode, replay.creep) == (1, 0.0)  # stick


def test_without_the_payload_the_arm_meets_the_stop(results):
    replay = results.no_payload
    assert replay.theta.min() == 0.0
    assert replay.mode == 4  # at rest at the lower stop


@pytest.mark.parametrize("nodes", [1, 2, 3, 5])
def test_the_grid_is_that_of_casadi(nodes):
    grid = RadauGrid(duration=2.0, intervals=4, nodes=nodes)
    assert grid.shares == pytest.approx(casadi.collocation_points(nodes, "radau"), abs=1e-14)
    slopes, _, weights = casadi.collocation_coeff(list(grid.shares))
    assert grid.slopes * grid.interval == pytest.approx(np.array(slopes), abs=1e-11)
    if nodes > 1:  # for one node CasADi's weights are those of the trapezoidal rule, which has the start too
        assert grid.weights / grid.interval == pytest.approx(np.array(weights).ravel(), abs=1e-12)
    values = np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.7, -0.4][:nodes])
    rows = grid.derivatives_at_start(values(grid.time[1:]).reshape(4, nodes))
    for k in range(nodes):
        assert rows[:, k] == pytest.approx(values.deriv(k)(grid.interval * np.arange(4)), abs=1e-10)


def start_of_slip(values):
    builder = casadi.DaeBuilder("cam", str(FORWARD))
    for name, value in values.items():
        builder.set(name, float(value))
    return builder


SLIP = {"inertia.shaft": 0.01, "initial.theta": 0.2, "initial.omega": 2.0, "tau": 12.0}


def test_casadi_takes_the_jacobian_from_the_fmu():
    rates = start_of_slip(SLIP).create("rates", ["x", "u"], ["ode"])
    jacobian = rates.factory("jacobian", rates.name_in(), ["jac:ode:x", "jac:ode:u"])
    x, u = np.array([0.6, 3.0]), np.array([12.0, 5.0])
    by_x, by_u = (np.array(part) for part in jacobian(x, u))
    for point, found, which in ((x, by_x, 0), (u, by_u, 1)):
        for i in range(2):
            step = np.zeros(2)
            step[i] = 1e-4 * max(1.0, abs(point[i]))
            ends = [
                np.array(rates(*((x + s, u) if which == 0 else (x, u + s)))).ravel() for s in (step, -step)
            ]
            assert found[:, i] == pytest.approx((ends[0] - ends[1]) / (2.0 * step[i]), rel=1e-8, abs=1e-7)


def test_cvodes_of_casadi_follows_a_slip():
    """J alpha = tau - T_load: affine in theta, so SciPy's DOP853 has the equation in one line."""
    rates = start_of_slip(SLIP).create("rates", ["x", "u"], ["ode"])
    x, u = casadi.MX.sym("x", 2), casadi.MX.sym("u", 2)
    options = {"abstol": 1e-11, "reltol": 1e-11}
    slip = casadi.integrator("slip", "cvodes", {"x": x, "p": u, "ode": rates(x, u)}, 0.0, 0.02, options)
    found = np.array(slip(x0=[0.2, 2.0], p=[12.0, 0.0])["xf"]).ravel()
    with Fmu(FORWARD) as fmu:
        fmu.start(SLIP)
        fmu.step(0.02)
        assert found == pytest.approx(fmu.reals("theta", "omega").read(), rel=1e-8)
        fmu.start(SLIP)
        alpha = [fmu.real("alpha")]
        fmu.start(SLIP | {"initial.theta": 0.7})
        alpha.append(fmu.real("alpha"))
    slope = (alpha[1] - alpha[0]) / 0.5
    solved = solve_ivp(
        lambda _t, y: [y[1], alpha[0] + slope * (y[0] - 0.2)], (0.0, 0.02), [0.2, 2.0], "DOP853",
        rtol=1e-12, atol=1e-13,
    )  # fmt: skip
    assert found == pytest.approx(solved.y[:, -1], rel=1e-8)
    assert not math.isclose(found[0], 0.2)


def test_the_page_shows_what_the_example_prints(results):
    assert example.report(results) in (ROOT / "docs/use-python-control.md").read_text(encoding="utf-8")
