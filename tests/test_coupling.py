"""The closed loop of benchmarks/coupling.py: what it claims, its parts, the truth that it measures with."""

import functools
import math
import sys

import numpy as np
import pytest
from driver import ROOT
from numpy.polynomial import Polynomial
from rich.console import Console
from scipy.integrate import solve_ivp

sys.path.insert(0, str(ROOT / "benchmarks"))
import coupling
from coupling import LOADING, RELEASING, SCENES, STEP, STICK, Flywheel, Fmu, Master, Monolith

REVERSALS, STICK_SLIP, DAMPED = SCENES
WAYS = [False, True]
each_scene = pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
CHECK_STEP = 50e-6


@functools.cache
def studied(scene):
    with Fmu(coupling.FMU) as slave:
        return coupling.study(slave, scene, Console(quiet=True), CHECK_STEP)


# ---- the claim ----


@each_scene
@pytest.mark.parametrize("in_turn", WAYS)
def test_second_order_is_50_times_closer_than_held_inputs(scene, in_turn):
    made = studied(scene)
    assert (made.ratio(Master(2, in_turn), STEP) >= 50).all()
    assert (made.ratio(Master(1, in_turn), STEP) > 1).all()


@each_scene
@pytest.mark.parametrize("in_turn", WAYS)
def test_orders_of_convergence(scene, in_turn):
    """At steps up to 2 ms: at more, held inputs are too far off for an error proportional to the step.
    With a damper in the shaft the error of second order is that of the few steps in which alpha jumps; where
    in a step each jump falls is chance, and it takes a wider range of steps to see the slope."""
    made, (theta, omega) = studied(scene), (0, 2)
    for measure in (theta, omega):
        for n, order in enumerate((1, 2) if scene is DAMPED else (1, 2, 3)):
            slope = made.convergence(Master(n, in_turn), measure, coupling.STEPS[:3])
            assert slope == pytest.approx(order, abs=0.2)
        if scene is DAMPED:
            slope = made.convergence(Master(2, in_turn), measure, coupling.STEPS)
            assert slope == pytest.approx(2, abs=0.25)


# ---- the truth ----


@each_scene
def test_fmu_and_monolith_agree(scene):
    """To what is left of second order at small steps."""
    made = studied(scene)
    coarse = made.errors[Master(2), coupling.GRID]
    order = 2 if scene is DAMPED else 3
    assert (made.agreement < 2 * coarse * (CHECK_STEP / coupling.GRID) ** order).all()
    assert made.mode_changes == len(made.truth.modes) - 1


@each_scene
def test_truth_does_not_depend_on_its_steps(scene):
    truth, finer = studied(scene).truth, Monolith(scene, longest=3e-4).solve()
    assert [mode for _, mode in truth.modes] == [mode for _, mode in finer.modes]
    assert np.abs(truth.states - finer.states).max(axis=0) == pytest.approx(0, abs=1e-9)
    assert np.abs(truth.states - finer.states)[:, 0].max() < 2e-11


@each_scene
def test_truth_conserves_energy(scene):
    """At every instant: the shaft's power is that of inertia, spring and friction, the friction from the
    reactions (mechanism.md, sections 4 and 6). In stick the torque is inside the band of section 3."""
    cam, monolith = coupling.CAM, Monolith(scene)
    r, slope, mu = cam["cam1.radius"], 1.0, cam["cam1.friction"]  # both contacts alike: gamma' = 1/2
    rise, half = r * slope / 2, 1 / 2
    for y in studied(scene).truth.states[1:]:  # the first is the start, from which it moves at once
        theta, omega = y[0], y[1]
        tau, spring = monolith.torque(y), cam["spring.preload"] + cam["spring.stiffness"] * rise * theta
        if omega == 0:
            assert spring * r / 2 * 0.86 / 1.14 <= tau <= spring * r / 2 * 1.14 / 0.86
            continue
        sigma = 1 if omega > 0 else -1
        alpha = monolith.rates(LOADING if sigma > 0 else RELEASING)(0.0, y)[1]
        at_cam2 = tau - cam["inertia.shaft"] * alpha
        at_cam1 = at_cam2 - cam["inertia.follower"] * half * alpha
        stretch = math.hypot(1.0, slope)
        sliding = half * abs(omega) * r * stretch
        reactions = [t * stretch / (r * (slope + sigma * mu)) for t in (at_cam1, at_cam2)]
        assert min(reactions) > 0
        inertia = cam["inertia.shaft"] + cam["inertia.follower_mass"] * rise**2
        inertia += cam["inertia.follower"] * half**2
        power = inertia * alpha * omega + spring * rise * omega + mu * sum(reactions) * sliding
        assert power == pytest.approx(tau * omega, rel=1e-11, abs=1e-11)


def test_scenes_are_what_they_say():
    modes = {scene.name: {mode for _, mode in studied(scene).truth.modes} for scene in SCENES}
    assert modes[REVERSALS.name] == {LOADING, RELEASING}
    assert modes[STICK_SLIP.name] == modes[DAMPED.name] == {STICK, LOADING, RELEASING}
    for scene in SCENES:
        changes = np.diff([start for start, _ in studied(scene).truth.modes])
        assert len(changes) >= 12
    assert sum(b - a for a, b in studied(STICK_SLIP).truth.resting()) > 0.1


# ---- the parts ----


def test_flywheel_against_an_integrator_and_its_own_equation():
    scene, h, start = DAMPED, 4e-3, 0.123
    angle, speed = [0.7, 5.0, -300.0], [5.0, -300.0, 2e4]
    wheel = Flywheel(scene, h)
    wheel.state[:2] = 1.1, 6.0
    wheel.see(start, [list(pair) for pair in zip(angle, speed, strict=True)])
    theta, omega = (Polynomial([c0, c1, c2 / 2]) for c0, c1, c2 in (angle, speed))

    def torque(t, y):
        return scene.stiffness * (y[0] - theta(t)) + scene.damping * (y[1] - omega(t))

    def rates(t, y):
        return [y[1], (scene.motor(start + t) - scene.bearing * y[1] - torque(t, y)) / scene.inertia]

    solution = solve_ivp(rates, (0, h), [1.1, 6.0], method="DOP853", rtol=1e-13, atol=1e-15)
    tau, rise, bend = wheel.torque(2)
    acceleration = rates(0, [1.1, 6.0])[1]
    assert tau == pytest.approx(torque(0, [1.1, 6.0]), rel=1e-13)
    assert rise == pytest.approx(
        scene.stiffness * (6.0 - angle[1]) + scene.damping * (acceleration - speed[1]), rel=1e-12
    )
    circular = 2 * math.pi * scene.frequency
    motor = scene.amplitude * circular * math.cos(circular * start)
    jerk = (motor - scene.bearing * acceleration - rise) / scene.inertia
    assert bend == pytest.approx(
        scene.stiffness * (acceleration - angle[2]) + scene.damping * (jerk - speed[2]), rel=1e-12
    )
    wheel.step()
    assert wheel.state[:2] == pytest.approx(solution.y[:, -1], rel=1e-12)


def test_expansion_about_another_point():
    derivatives, shift = [0.3, -2.0, 7.0], -0.4
    polynomial = Polynomial([0.3, -2.0, 3.5])
    expected = [polynomial.deriv(i)(shift) if i else polynomial(shift) for i in range(3)]
    assert coupling.expanded(derivatives, shift) == pytest.approx(expected, rel=1e-14)


def test_derivatives_by_the_wrapper():
    """What is read is omega, alpha and the slope of alpha; what is written is a torque that is a parabola."""
    h, parabola = 1e-3, Polynomial([9.0, 50.0, -4e3])
    with Fmu(coupling.FMU) as slave:
        tau, motion = slave.reals("tau"), slave.reals("theta", "omega")

        def after(cuts):
            """Reached through as many steps, and alpha on the way."""
            slave.start(coupling.CAM | {"initial.theta": 0.5, "tau": 9.0})
            alphas = [slave.get("alpha")]
            for k in range(cuts):
                t = k * h / cuts
                tau.values[0] = parabola(t)
                tau.write()
                tau.write_derivatives(1, [parabola.deriv(1)(t)])
                tau.write_derivatives(2, [parabola.deriv(2)(t)])
                slave.step(h / cuts)
                alphas.append(slave.get("alpha"))
            return motion.read(), alphas

        whole, _ = after(1)
        parts, alphas = after(100)
        assert whole == pytest.approx(parts, rel=1e-12)
        rate, bend = motion.read_derivatives(1), motion.read_derivatives(2)
        assert rate == pytest.approx([parts[1], alphas[-1]], rel=1e-12)
        assert bend[0] == rate[1]
        backwards = np.array([11, -18, 9, -2]) / 6 / (h / 100)  # of third order
        assert bend[1] == pytest.approx(backwards @ alphas[:-5:-1], rel=1e-5)
