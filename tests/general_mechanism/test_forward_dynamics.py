"""Sections 6 and 7 of docs/mechanism.md: motion against the residual of the friction inclusion, SciPy and
closed forms.
"""

import math

import mpmath
import numpy as np
import pytest
from driver import models
from mechanisms import RHO
from pin_equations import (
    ACCOUNTS,
    PAIRS,
    Pin,
    band,
    damper_force,
    edge,
    ellipse,
    friction,
    polynomial,
    spring_force,
)
from random_mechanisms import random_inputs, random_mechanism, reactions, run_on, step
from reference import LOADING, LOWER_STOP, RELEASING, STICK, UPPER_STOP
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

# ---- section 6: forward dynamics ----


def moving_residual(fmu, pin, values):
    """How far theta, omega, alpha and the reactions read from the FMU miss the equations of sliding,
    relative to the sizes of their terms. Flanks: the signs of the reactions."""
    theta, omega, alpha = fmu.get("theta"), fmu.get("omega"), fmu.get("alpha")
    place, mu, direction = pin.at(theta), friction(values), 1 if fmu.get("mode") == LOADING else -1
    (r1, r2), (_a1, _a2) = place.r, place.a
    assert direction * omega >= 0.0
    x = [normal / place.length(i) for i, normal in enumerate(reactions(fmu))]
    e = [1 if value >= 0 else -1 for value in x]
    n = [a + direction * k * m * r for a, k, m, r in zip(place.a, e, mu, place.r, strict=True)]
    d = [r - direction * k * m * a for a, k, m, r in zip(place.a, e, mu, place.r, strict=True)]
    mass, twist = values.get("inertia.follower_mass", 0.0), values.get("inertia.follower", 0.0)
    lift_parts = mass * place.lift * alpha, mass * place.lift_bent * omega**2
    turn_parts = twist * place.turn * alpha, twist * place.turn_bent * omega**2
    axial_parts = [
        spring_force(values, place.z),
        fmu.get("F_ext"),
        damper_force(values, place.lift * omega),
        *lift_parts,
    ]
    torque_parts = [
        fmu.get("tau"),
        -values.get("shaft.damping", 0.0) * omega,
        -values["inertia.shaft"] * alpha,
    ]
    force, torque, moment = math.fsum(axial_parts), math.fsum(torque_parts), math.fsum(turn_parts)
    # the page's form, with the factors that are infinite at lambda = 0 multiplied out
    delta = r2 * d[0] * n[1] + r1 * d[1] * n[0]
    rho, rho_kappa1 = r1 * r2 * n[0] * n[1] / delta, r2 * n[1] * d[0] / delta
    size = abs(rho) * sum(map(abs, axial_parts)) + abs(rho_kappa1) * sum(map(abs, turn_parts))
    size += sum(map(abs, torque_parts))
    law = abs(torque - rho * force - rho_kappa1 * moment) / size
    # the balances that it is made of
    x2 = abs(torque - r2 * n[1] * x[1]) / size
    x1 = abs(torque - moment - r1 * n[0] * x[0]) / size
    return max(law, x1, x2)


def agrees_at_rest(fmu, pin, values):
    """Is the state a rest that section 3 allows?"""
    theta, tau, mode = fmu.get("theta"), fmu.get("tau"), fmu.get("mode")
    place = pin.at(theta)
    force = spring_force(values, place.z) + fmu.get("F_ext")
    release, load = band(place, friction(values), force)
    terms = spring_force(
        {name: abs(value) for name, value in values.items() if "spring" in name}, abs(place.z)
    )
    rounding = 1e-12 * (abs(tau) + place.lift * (abs(fmu.get("F_ext")) + terms))
    if fmu.get("omega") != 0.0:
        return False
    if mode == STICK:
        return release - rounding <= tau <= load + rounding
    if mode == LOWER_STOP:
        return theta == values["stop.lower"] and tau <= release + rounding
    if mode == UPPER_STOP:
        return theta == values["stop.upper"] and tau >= load - rounding
    return math.isinf(release if tau < place.lift * force else load)


@pytest.mark.parametrize("tolerance", [1e-4, None])
@pytest.mark.parametrize("regime", ["inertial", "viscous", "rate-independent"])
def test_section_6_residual_of_the_inclusion(make, tmp_path, regime, tolerance):
    """At every communication point of random scenes, whatever the tolerance: while it slips,
    T = tau - b omega - J alpha equals rho (F_s + F_ext + D + m z_ddot) + rho kappa_1 I gamma_ddot on the
    flanks that the signs of the reactions name; at rest T_release <= tau <= T_load, or a stop or a wedge
    holds it. 1e-12 of the terms is rounding: that of theta and z, amplified where a term is steep."""
    rng = np.random.default_rng([6, len(regime)])
    seen, mixed = dict.fromkeys(range(1, 7), 0), 0
    for _ in range(40):
        pin, values = random_mechanism(rng, tmp_path, regime=regime)
        fmu = make().start(values, tolerance=tolerance)
        for _ in range(30):
            h = 10.0 ** rng.uniform(-4, -1.5)
            step(fmu, h, random_inputs(rng, values, pin, h))
            mode = fmu.get("mode")
            seen[mode] += 1
            if mode in (LOADING, RELEASING):
                assert moving_residual(fmu, pin, values) <= 1e-12, (values, fmu.get("theta"))
                mixed += reactions(fmu)[0] * reactions(fmu)[1] < 0
            else:
                assert agrees_at_rest(fmu, pin, values), (values, fmu.get("theta"), mode)
    assert min(seen[mode] for mode in (STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP)) >= 3, seen
    assert mixed >= 3 or regime != "inertial"


@pytest.mark.parametrize("seed", range(8))
def test_section_6_motion_against_an_integrator(make, tmp_path, seed):
    """A swing without a mode change: the equation of motion, solved for alpha by the two balances,
    integrated by SciPy (DOP853, 1e-12)."""
    rng = np.random.default_rng([66, seed])
    pin, values = random_mechanism(rng, tmp_path, PAIRS[1 + seed])
    values |= {"initial.theta": 0.1 * values["stop.upper"], "initial.omega": 1.0}
    mu, p = friction(values), values
    place = pin.at(0.5 * values["stop.upper"])
    inputs = {
        "tau": [2.0 * band(place, mu, spring_force(values, place.z))[1], 20.0, -3e3, 2e5],
        "F_ext": [1.0, 30.0],
    }

    def alpha(t, theta, omega):
        """x1, x2 and alpha from three linear equations; both reactions positive all the time."""
        q = pin.at(theta)
        (r1, r2), (a1, a2) = q.r, q.a
        tau, pull = (polynomial(inputs[name], t) for name in ("tau", "F_ext"))
        axial = spring_force(p, q.z) + pull + damper_force(p, q.lift * omega)
        axial += p["inertia.follower_mass"] * q.lift_bent * omega**2
        moment = p["inertia.follower"] * q.turn_bent * omega**2
        matrix = [
            [r1 - mu[0] * a1, r2 - mu[1] * a2, -p["inertia.follower_mass"] * q.lift],
            [-r1 * (a1 + mu[0] * r1), r2 * (a2 + mu[1] * r2), -p["inertia.follower"] * q.turn],
            [0.0, r2 * (a2 + mu[1] * r2), p["inertia.shaft"]],
        ]
        x1, x2, acceleration = np.linalg.solve(
            matrix, [axial, moment, tau - p.get("shaft.damping", 0.0) * omega]
        )
        assert x1 > 0 and x2 > 0
        return acceleration

    def upper(_t, y):
        return values["stop.upper"] - y[0]

    def turning(_t, y):
        return y[1]

    upper.terminal = turning.terminal = True
    found = solve_ivp(
        lambda t, y: [y[1], alpha(t, *y)], (0.0, 0.05), [values["initial.theta"], 1.0],
        method="DOP853", rtol=1e-12, atol=1e-14, events=[upper, turning], dense_output=True,
    )  # fmt: skip
    end = found.t[-1]
    assert end > 1e-3
    for tolerance in (1e-6, None, 1e-11):
        fmu = make().start(values, tolerance=tolerance)
        size = max(np.abs(found.y[1]))
        for part in np.linspace(0.0, 0.99, 4)[1:]:
            run_on(fmu, inputs, fmu.time, part * end, 2)
            theta, omega = found.sol(part * end)
            assert fmu.get("theta") == pytest.approx(
                theta, abs=10 * (tolerance or 1e-9) * values["stop.upper"]
            )
            assert fmu.get("omega") == pytest.approx(omega, abs=10 * (tolerance or 1e-9) * size)


RIGHT_ANGLED = {"stop.lower": -40.0, "stop.upper": 40.0}


@pytest.mark.parametrize(("direction", "tau"), [(1, 5.0), (-1, 0.2)])
def test_section_6_viscous_linear_and_quadratic_damper(make, direction, tau):
    """c v + q v |v| = tau/rho - F_0 - k z, so (c + 2 q |v|) dv/dt = -k v: with x = 2 q |v|/c,
    x e^x = x_0 e^(x_0 - k t/c), x = W(...)."""
    c, q, k, preload = 900.0, 8000.0, 5e4, 50.0
    way = "load" if direction > 0 else "release"
    values = RIGHT_ANGLED | {"inertia.shaft": 0.0, f"damper.c_{way}": c, f"damper.q_{way}": q}
    start = 0.0 if direction > 0 else 0.6
    fmu = make().start(values | {"initial.theta": start})
    rho = RHO[direction]
    with mpmath.workdps(30):
        push = direction * (mpmath.mpf(tau) / rho - preload - k * mpmath.mpf(start) * 0.01)
        x0 = mpmath.sqrt(1 + 4 * q * push / c**2) - 1  # 2 q v/c of q v^2 + c v = push
        t = 0.0
        for h in (1e-4, 3e-3, 1e-2, 3e-2):
            fmu.step(h, tau=tau)
            t += h
            speed = c / (2 * q) * mpmath.lambertw(x0 * mpmath.exp(x0 - k * t / c)).real
            z = (tau / rho - preload - direction * (c * speed + q * speed**2)) / k
            assert fmu.get("z") == pytest.approx(float(z), rel=2e-9)
            assert fmu.get("v") == pytest.approx(float(direction * speed), rel=1e-7)
            assert fmu.get("omega") == pytest.approx(fmu.get("v") / 0.01, rel=1e-14)
            assert fmu.get("mode") == (LOADING if direction > 0 else RELEASING)


@pytest.mark.parametrize("inertia", [0.0, 0.002])
@pytest.mark.parametrize(("tau", "rho"), [(0.1, RHO[-1]), (0.0, RHO[-1]), (-0.3, RHO[1])])
def test_section_6_braking_return_through_the_damper(make, inertia, tau, rho):
    """The paper's (4) with a spring force that does not change: released, it ends at the speed at which
    c |v| + q v^2 = F_0 - tau/rho. With tau < 0 the total F is negative, the pins bear on their other
    flanks, and rho_+ applies. Without inertia that is so at once."""
    c, q, preload = 60.0, 900.0, 50.0
    values = RIGHT_ANGLED | {"inertia.shaft": inertia, "damper.c_release": c, "damper.q_release": q}
    values |= {"spring.stiffness": 0.0, "spring.preload": preload, "initial.theta": 39.0}
    fmu = make().start(values)
    fmu.step(2.5 if inertia else 1e-3, tau=tau)
    push = preload - tau / rho
    speed = (math.sqrt(c * c + 4 * q * push) - c) / (2 * q)
    assert fmu.get("mode") == RELEASING
    assert fmu.get("v") == pytest.approx(-speed, rel=1e-9)
    assert fmu.get("damper.force") == pytest.approx(-push, rel=2e-9)
    if tau:
        assert (
            math.copysign(1, tau)
            == math.copysign(1, reactions(fmu)[0])
            == math.copysign(1, reactions(fmu)[1])
        )


@pytest.mark.parametrize("stiffness", [0.0, 2000.0])
def test_section_6_quadratic_damper_riccati(make, stiffness):
    """Helices, J and q only: J omega omega' = tau - rho (F_0 + k z' theta) - rho q z'^2 omega^2, so omega^2
    is linear in theta plus an exponential; without spring rate omega = w tanh(w p t), w^2 = net/(rho q
    z'^2), J p = rho q z'^2, and theta = ln cosh(w p t)/p."""
    inertia, q, tau = 0.002, 3e4, 3.0
    values = RIGHT_ANGLED | {"damper.q_load": q, "spring.stiffness": stiffness}
    fmu = make().start(values, tolerance=1e-11)
    p = RHO[1] * q * 1e-4 / inertia
    net, rate = (tau - RHO[1] * 50.0) / inertia, RHO[1] * stiffness * 0.01 / inertia
    for h in (1e-3, 1e-2, 0.04, 0.05):
        fmu.step(h, tau=tau)
        assert fmu.get("mode") == LOADING
        theta = fmu.get("theta")
        # u = omega^2: u'/2 = net - rate theta - p u; u = A - B theta - A exp(-2 p theta)
        B = rate / p
        A = (net + 0.5 * B) / p
        square = -A * math.expm1(-2 * p * theta) - B * theta
        assert fmu.get("omega") == pytest.approx(math.sqrt(square), rel=1e-9)
        if stiffness == 0.0:
            w = math.sqrt(net / p)
            assert fmu.get("omega") == pytest.approx(w * math.tanh(w * p * fmu.time), rel=1e-9)
            assert theta == pytest.approx(math.log(math.cosh(w * p * fmu.time)) / p, rel=1e-9)
    # heat in the damper: integral of q z'^3 omega^3 dt = integral of q z'^3 omega^2 dtheta
    heat = q * 1e-6 * (A * theta - 0.5 * B * theta**2 + A * math.expm1(-2 * p * theta) / (2 * p))
    assert fmu.get("energy.heat_damper") == pytest.approx(heat, rel=1e-9)


def play_mechanism():
    """Both cams elliptical, nonlinear spring; T_load and T_release rise from stop to stop."""
    pin = Pin(ellipse(0.02, 0.8203, 0.06, 0.05, -1), ellipse(0.03, 0.6, 0.08, 0.05, 1))
    values = pin.values | {"cam1.friction": 0.14, "cam2.friction": 0.19, "inertia.shaft": 0.0}
    values |= {
        "spring.preload": 50.0,
        "spring.stiffness": 2e4,
        "spring.stiffness2": 4e5,
        "spring.stiffness3": 2e7,
    }
    values |= {"stop.upper": 1.2}

    def torque(theta, direction):
        place = pin.at(theta)
        return edge(place, friction(values), direction, spring_force(values, place.z))[0]

    def angle(tau, direction):
        ends = torque(0.0, direction), torque(1.2, direction)
        if not ends[0] < tau < ends[1]:
            return 0.0 if tau <= ends[0] else 1.2
        return brentq(lambda x: torque(x, direction) - tau, 0.0, 1.2, xtol=1e-15)

    return pin, values, torque, angle


def test_section_6_play_on_an_ellipse(make):
    """Without inertia and damping: theta stays inside the band, else it is on the edge, to where
    T_load(theta) = tau on the way up, T_release(theta) = tau on the way down."""
    _pin, values, torque, angle = play_mechanism()
    rng, theta, fmu, moves = np.random.default_rng(7), 0.0, make().start(values), 0
    for _ in range(60):
        tau = rng.uniform(0.3, 1.02) * torque(1.2, 1)
        fmu.step(0.01, tau=tau)
        before = theta
        theta = min(max(theta, angle(tau, 1)), angle(tau, -1))
        moves += theta != before
        assert fmu.get("theta") == pytest.approx(theta, abs=1e-11)
        assert fmu.get("omega") == 0.0
    assert moves >= 20
    assert abs(fmu.get("energy.residual")) <= 1e-9 * fmu.get("energy.work_in")


@pytest.mark.parametrize("ramped", [False, True])
def test_section_6_hysteresis_loop(make, ramped):
    """Over a closed loop the work of tau is what the friction took: the area between the edges
    T_load and T_release, from the angle where the lower torque lets go to that where the upper one arrives;
    whether tau jumps or ramps."""
    _pin, values, torque, angle = play_mechanism()
    high, low = 0.9 * torque(1.2, 1), 1.3 * torque(0.0, 1)
    top, bottom = angle(high, 1), angle(low, -1)
    assert 0.0 < bottom < top < 1.2
    fmu = make().start(values, tolerance=1e-11)

    def go(old, new):
        if ramped:
            run_on(fmu, {"tau": [old, (new - old) / 0.3]}, 0.0, 0.3, 3)
            assert fmu.get("mode") in (LOADING, RELEASING)
        fmu.step(0.1, tau=new)
        if ramped:
            assert fmu.get("omega") == 0.0

    # Driver counts time on its own; run_on takes times of the inputs only
    go(0.0, high)
    go(high, low)
    assert fmu.get("theta") == pytest.approx(bottom, abs=1e-11)
    before = {name: fmu.get(name) for name in ACCOUNTS}
    go(low, high)
    assert fmu.get("theta") == pytest.approx(top, abs=1e-11)
    go(high, low)
    assert fmu.get("theta") == pytest.approx(bottom, abs=1e-11)
    gain = {name: fmu.get(name) - value for name, value in before.items()}
    area, _ = quad(lambda x: torque(x, 1) - torque(x, -1), bottom, top, epsabs=1e-13)
    assert gain["energy.heat_cam1"] + gain["energy.heat_cam2"] == pytest.approx(area, rel=1e-9)
    assert gain["energy.work_in"] == pytest.approx(area, rel=1e-9)
    assert gain["energy.spring"] == pytest.approx(0.0, abs=1e-10)
    assert min(gain["energy.heat_cam1"], gain["energy.heat_cam2"]) > 0.1 * area


def test_section_6_speed_along_the_edge(make):
    """A ramp of tau along the edge: omega = (dtau/dt)/(dT/dtheta), by differences of the edge."""
    _, values, torque, angle = play_mechanism()
    fmu = make().start(values, tolerance=1e-11)
    start = torque(0.3, 1)
    fmu.step(0.1, tau=start)
    run_on(fmu, {"tau": [start, 4.0, 3.0]}, 0.0, 0.1, 1)
    theta = angle(start + 0.4 + 0.015, 1)
    assert fmu.get("theta") == pytest.approx(theta, abs=1e-11)
    h = 1e-3
    slope = (torque(theta - 2 * h, 1) - 8 * torque(theta - h, 1)) / (12 * h)
    slope += (8 * torque(theta + h, 1) - torque(theta + 2 * h, 1)) / (12 * h)
    assert fmu.get("omega") == pytest.approx(4.3 / slope, rel=1e-8)


# ---- section 7: inverse dynamics ----


def test_section_7_the_inverse_of_this_motion(make, make_model, tmp_path):
    """The inverse FMU, driven by theta, omega, alpha of a general motion, asks for the torque that made it
    (test_inverse.py has the rest of this section)."""
    rng, compared = np.random.default_rng(77), 0
    for _ in range(8):
        pin, values = random_mechanism(rng, tmp_path)
        forward = make().start(values, tolerance=1e-11)
        shared = {name: value for name, value in values.items() if not name.startswith("initial.")}
        inverse = make_model(models["DualCamInverse"])
        inverse.start(shared | {"theta": values["initial.theta"]})
        for _ in range(20):
            h = 10.0 ** rng.uniform(-4, -2)
            step(forward, h, random_inputs(rng, values, pin, h))
            if forward.get("mode") not in (LOADING, RELEASING):
                continue
            inverse.set({name: forward.get(name) for name in ("theta", "omega", "alpha", "F_ext")})
            place, tau = pin.at(forward.get("theta")), forward.get("tau")
            size = abs(tau) + place.lift * (abs(forward.get("spring.force")) + abs(forward.get("F_ext")))
            size += abs(values["inertia.shaft"] * forward.get("alpha"))
            assert inverse.get("tau") == pytest.approx(tau, abs=1e-9 * size)
            for i in (1, 2):
                name = f"cam{i}.reaction"
                assert inverse.get(name) == pytest.approx(forward.get(name), rel=1e-7, abs=1e-7)
            compared += 1
    assert compared > 40
