"""dualcam.coupling: bounds of stability in closed form, the warning where the loop of the FMU itself
diverges, and Newton's answer against the whole system, in one FMU and by SciPy."""

import itertools
import math
import warnings
from contextlib import contextmanager

import numpy as np
import pytest
from driver import models
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from benchmarks.coupling import own_plant
from dualcam import Fmu
from dualcam.coupling import (
    Impedance,
    PlantCoupling,
    ShaftMotion,
    cam_of_step,
    impedance_of,
    largest_stable_step,
    reflected_inertia,
    spectral_radius,
    step_difference,
)
from dualcam.coupling.plant import loop_growth
from dualcam.errors import CouplingError, DualcamError, UnstableCouplingWarning
from dualcam.systems.blocks.motor import AK80_6

FORWARD = models["DualCamForward"].fmu
J, H = 0.002, 1e-3
# A cam without friction on a spring of 0 N.m/rad: an inertia that moves freely between the stops
FREE = {
    "cam1.friction": 0.0,
    "cam2.friction": 0.0,
    "spring.preload": 1e-9,
    "spring.stiffness": 0.0,
    "inertia.shaft": J,
    "initial.theta": 0.7,
}
# Bounds of D h/J: |1 - x| of a held torque; 1 + trace + determinant = 2 - 3 x + x^2/2 of a straight line
HELD, STRAIGHT = 2.0, 3.0 - math.sqrt(5.0)


@pytest.fixture(scope="module")
def fmu():
    with Fmu(FORWARD) as made:
        yield made


@contextmanager
def recorded():
    """All warnings of a block, also those that come again."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield caught


def explicit_steps(coupling, count, order=0):
    """Steps of H, until a speed is above 1 mrad/s."""
    steps = []
    while len(steps) < count and not (steps and abs(steps[-1].motion.omega) > 1e-3):
        steps.append(coupling.step_explicit(H, order))
    return steps, [abs(step.motion.omega) for step in steps]


# ---- bounds ----


def test_reflected_inertia():
    """The kinetic energy of the rotor is that of the inertia at the shaft."""
    speed = 3.0
    assert 0.5 * reflected_inertia(50.0, 6e-5) * speed**2 == pytest.approx(0.5 * 6e-5 * (50.0 * speed) ** 2)
    assert reflected_inertia(AK80_6.gear, AK80_6.rotor_inertia) == AK80_6.inertia
    for gear_ratio, inertia in ((math.nan, 1.0), (50.0, -1e-5), (50.0, math.inf), ("50", 1.0)):
        with pytest.raises(DualcamError, match=r"(gear_ratio|rotor_inertia) = .*: allowed"):
            reflected_inertia(gear_ratio, inertia)


@pytest.mark.parametrize("gain", [0.1, 0.9, 1.5, 1.99, 2.5, 60.0])
def test_damping_held(gain):
    """omega shrinks by 1 - D h/J per step; theta stays where it comes to."""
    radius = spectral_radius(H, J, Impedance(damping=gain * J / H))
    assert radius == pytest.approx(max(1.0, abs(1.0 - gain)), rel=1e-12)


@pytest.mark.parametrize("share", [0.3, 0.99, 1.01, 76.0])
@pytest.mark.parametrize("step", [1e-6, H])
def test_inertia_held(share, step):
    """alpha is multiplied by -M/J per step, whatever the step is. 1: theta and omega stay."""
    radius = spectral_radius(step, J, Impedance(inertia=share * J))
    assert radius == pytest.approx(max(1.0, share), rel=1e-6)


def test_spring_and_damper_held():
    """Eigenvalues of the 2 x 2 map of theta and omega; a held spring alone always grows."""
    for stiffness, damping in ((100.0, 0.0), (100.0, 1.0), (2000.0, 0.5), (3e4, 2.0)):
        k, d = stiffness * H**2 / J, damping * H / J
        trace, determinant = 2.0 - k / 2.0 - d, 1.0 + k / 2.0 - d
        exact = np.abs(np.roots([1.0, -trace, determinant])).max()
        assert spectral_radius(H, J, Impedance(stiffness, damping)) == pytest.approx(exact, rel=1e-9)
    assert spectral_radius(H, J, Impedance(100.0)) > 1.0


@pytest.mark.parametrize(("order", "bound"), [(0, HELD), (1, STRAIGHT)])
def test_largest_stable_step_of_damping(order, bound):
    damping = 5.0
    found = largest_stable_step(J, Impedance(damping=damping), order)
    assert found == pytest.approx(bound * J / damping, rel=1e-6)


def test_largest_stable_step_at_the_ends():
    assert largest_stable_step(J, Impedance()) == math.inf
    assert largest_stable_step(J, Impedance(inertia=0.9 * J)) == math.inf
    assert largest_stable_step(J, Impedance(inertia=1.1 * J)) == 0.0
    assert largest_stable_step(J, Impedance(damping=-1.0)) == 0.0


@pytest.mark.parametrize("stiffness", [1e-3, 1.0, 100.0, 1e5])
def test_largest_stable_step_of_a_held_spring(stiffness):
    """Errors of an undamped spring grow by K h^2/(4 J) per step, whatever h is. With the damping D, and h/J
    so short that D h/J does not matter, they decay where D > K h/2."""
    assert largest_stable_step(J, Impedance(stiffness)) == 0.0
    step = 1e-3 * math.sqrt(J / stiffness)
    damped = Impedance(stiffness, 0.5 * stiffness * step)
    assert largest_stable_step(J, damped) == pytest.approx(step, rel=1e-4)


@pytest.mark.filterwarnings("error")
def test_a_frictionless_spring_grows_in_the_fmu(fmu):
    """So slowly that no warning comes: the spring is in the plant, and the step stable but for 1e-3."""
    stiffness, step = 100.0, 2.5e-4
    growth = math.sqrt(1.0 + stiffness * step**2 / (2.0 * J))
    fmu.start({**FREE, "initial.theta": 0.701})
    coupling, angles = PlantCoupling(fmu, lambda shaft: -stiffness * (shaft.theta - 0.7)), []
    for _ in range(2000):
        angles.append(coupling.step_explicit(step).motion.theta - 0.7)
    sizes = [np.abs(angles[k : k + 200]).max() for k in (0, 1800)]
    assert sizes[1] / sizes[0] == pytest.approx(growth**1800, rel=0.05)
    assert largest_stable_step(J, Impedance(stiffness)) == 0.0


# ---- a plant that is an FMU of its own ----


@pytest.mark.parametrize("gain", [0.2, 0.25, 0.5, 0.99, 1.01, 1.24, 1.9])
def test_damping_one_step_late(gain):
    """z^2 - z + x = 0 for the speed; theta stays where it comes to."""
    radius = spectral_radius(H, J, Impedance(damping=gain * J / H), plant_is_fmu=True)
    late = np.abs(np.roots([1.0, -1.0, gain])).max()
    assert radius == pytest.approx(max(1.0, late), rel=1e-7)


def test_largest_stable_step_of_a_motor_that_is_an_fmu():
    """D h/J < 1, half of what is stable where the plant is a function. A late inertia is stable below J."""
    inertia, damping = 0.003022, 1.25
    found = largest_stable_step(inertia, Impedance(damping=damping), plant_is_fmu=True)
    assert found == pytest.approx(inertia / damping, rel=1e-6)
    assert largest_stable_step(J, Impedance(inertia=0.9 * J), plant_is_fmu=True) == math.inf
    assert largest_stable_step(J, Impedance(inertia=1.1 * J), plant_is_fmu=True) == 0.0


@pytest.mark.filterwarnings("ignore::dualcam.errors.UnstableCouplingWarning")
@pytest.mark.parametrize(("gain", "grows"), [(0.9, False), (0.99, False), (1.05, True), (1.24, True)])
def test_the_fmu_with_a_torque_one_step_late(fmu, gain, grows):
    """As an explicit master exchanges values: the motor computes in a step, from the speed before it."""
    damping = gain * J / H
    fmu.start({**FREE, "initial.omega": 1e-6})
    torque, speeds = [0.0], []
    coupling = PlantCoupling(fmu, lambda shaft: torque[0])
    for _ in range(400):
        before = coupling.motion().omega
        speeds.append(abs(coupling.step_explicit(H).motion.omega))
        torque[0] = -damping * before
        if speeds[-1] > 1e-3:
            break
    assert (speeds[-1] > 1e-3) is grows
    step = largest_stable_step(J, Impedance(damping=damping), plant_is_fmu=True)
    assert (step < H) is grows


def test_impedance_by_differences():
    found = impedance_of(
        lambda shaft: 3.0 - 2.0 * math.sin(shaft.theta) - 0.5 * shaft.omega**2 - 0.01 * shaft.alpha,
        ShaftMotion(0.0, 0.4, 3.0, 50.0),
    )
    assert found == pytest.approx((2.0 * math.cos(0.4), 3.0, 0.01), rel=1e-6)


# ---- the loop of the FMU itself ----


def growth(fmu, plant, order):
    """|omega| at the end of 300 steps over the largest of the first ten, and whether there was a warning."""
    fmu.start({**FREE, "initial.omega": 1e-9})
    with recorded() as caught:
        _, speeds = explicit_steps(PlantCoupling(fmu, plant), 300, order)
    assert len(caught) <= 1
    assert all(issubclass(one.category, UnstableCouplingWarning) for one in caught)
    return speeds[-1] / max(speeds[:10]), bool(caught)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("kind", ["damping", "inertia", "both"])
def test_warning_exactly_where_the_loop_diverges(fmu, order, kind):
    """From 10 % below to 10 % above the bound, which is found by the spectral radius."""

    def impedance(size):
        return {
            "damping": Impedance(damping=size * J / H),
            "inertia": Impedance(inertia=size * J),
            "both": Impedance(damping=0.3 * size * J / H, inertia=0.5 * size * J),
        }[kind]

    bound = brentq(lambda size: spectral_radius(H, J, impedance(size), order) - 1.0005, 0.05, 5.0)
    if kind == "damping" and order < 2:
        assert bound == pytest.approx((HELD, STRAIGHT)[order], rel=2e-3)
    for share, diverges in ((0.5, False), (0.9, False), (1.1, True), (1.5, True)):
        found = impedance(share * bound)

        def plant(shaft, found=found):
            return -found.damping * shaft.omega - found.inertia * shaft.alpha

        ratio, warned = growth(fmu, plant, order)
        assert (ratio > 100.0, warned) == (diverges, diverges), (share, ratio)


@pytest.mark.parametrize(("share", "diverges"), [(0.5, False), (0.95, False), (1.05, True), (3.0, True)])
def test_cam_without_inertia(fmu, share, diverges):
    """Its speed is tau/B: an error of omega is multiplied by -D/B per step, whatever the step is."""
    fmu.start({**FREE, "inertia.shaft": 0.0, "shaft.damping": 0.5, "tau": 1e-6})
    with recorded() as caught:
        plant = PlantCoupling(fmu, lambda shaft: 1e-9 - share * 0.5 * shaft.omega)
        steps, speeds = explicit_steps(plant, 60)
    assert steps[-1].stability.cam_damping == pytest.approx(0.5, rel=0.03)
    assert (speeds[-1] > speeds[0]) is diverges
    assert bool(caught) is diverges
    if diverges:
        assert "steps up to" not in str(caught[0].message)


@pytest.mark.parametrize("x", [0.01, 0.3, 1.0, 3.0, 20.0])
def test_cam_from_its_step(fmu, x):
    """J and B of an inertia with a damper, told from one step; an error of omega is multiplied by
    e^-x - (1 - e^-x) D/B if the torque is held."""
    damping = x * J / H
    fmu.start({**FREE, "shaft.damping": damping, "tau": 1e-3})
    fmu.step(H)
    found = cam_of_step(H, fmu.real("step.dtheta_dtau"), fmu.real("step.domega_dtau"))
    assert found == pytest.approx((J, damping), rel=1e-6)
    share = (1.0 + math.exp(-x)) / -math.expm1(-x)  # D/B at which e^-x - (1 - e^-x) D/B = -1
    radius = spectral_radius(H, J, Impedance(damping=1.1 * share * damping), cam_damping=damping)
    assert radius == pytest.approx(1.1 * (1.0 + math.exp(-x)) - math.exp(-x), rel=1e-9)


def test_warning_has_numbers_and_what_works(fmu):
    fmu.start({"inertia.shaft": J, "initial.theta": 0.4, "initial.omega": 2.0})
    coupling = PlantCoupling(fmu, lambda shaft: 4.0 - 10.0 * (shaft.omega - 2.0))
    with pytest.warns(UnstableCouplingWarning, match=r"damping 10 N.m.s/rad") as caught:
        step = coupling.step_explicit(H)
    text = str(caught[0].message)
    allowed = float(text.split("steps up to ")[1].split()[0])
    assert allowed == pytest.approx(2.0 * step.stability.inertia / 10.0, rel=2e-3)
    assert step.stability.inertia == pytest.approx(J, rel=1e-2)
    assert "step_implicit" in text and "inertia.shaft" in text
    fmu.start({"inertia.shaft": J, "initial.theta": 0.4, "initial.omega": 2.0})
    coupling = PlantCoupling(fmu, lambda shaft: 4.0 - 10.0 * (shaft.omega - 2.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(20):
            assert coupling.step_explicit(0.9 * allowed).motion.omega == pytest.approx(2.0, abs=0.2)


def caught_in_steps(fmu, plant, implicit, count=100):
    """The warnings of that many steps, from theta = 0.4 rad and omega = 1 rad/s on."""
    fmu.start({"inertia.shaft": 0.02, "initial.theta": 0.4, "initial.omega": 1.0})
    coupling = PlantCoupling(fmu, plant)
    step = coupling.step_implicit if implicit else coupling.step_explicit
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(count):
            step(H)
    return caught


@pytest.mark.parametrize("implicit", [False, True])
@pytest.mark.parametrize(
    "plant",
    [
        lambda shaft: 6.0 - 30.0 * (0.4 - shaft.theta) - 0.1 * shaft.omega,
        lambda shaft: 6.0 + 30.0 * (0.4 - shaft.theta) + 0.5 * shaft.omega,
    ],
)
def test_a_controller_of_the_wrong_sign_is_said_to_be_so(fmu, plant, implicit):
    """No way of coupling is recommended. The warning comes once, and points to this file."""
    (warning,) = caught_in_steps(fmu, plant, implicit)
    text = str(warning.message)
    assert warning.category is UnstableCouplingWarning and warning.filename == __file__
    assert "is itself unstable" in text and "Is the sign of the controller right?" in text
    assert "step_implicit" not in text and "steps up to" not in text


@pytest.mark.parametrize("stiffness", [-4.0, 30.0])
def test_the_spring_of_the_cam_may_outweigh_the_plant(fmu, stiffness):
    """Equal helices of 45 deg on 50 N/mm have 5 N.m/rad without friction, more while loading."""
    plant = lambda shaft: 6.0 + stiffness * (0.4 - shaft.theta) - 0.1 * shaft.omega  # noqa: E731
    assert not caught_in_steps(fmu, plant, implicit=True)


def test_the_growth_of_an_unstable_loop(fmu):
    """(J + M) s^2 + (B + D) s + k + K = 0 with k = 5 N.m/rad of the cam without friction."""
    frictionless = {"cam1.friction": 0.0, "cam2.friction": 0.0}
    fmu.start({**frictionless, "inertia.shaft": 0.02, "initial.theta": 0.4, "initial.omega": 1.0})
    stability = PlantCoupling(fmu, lambda shaft: 25.0 * shaft.theta).step_explicit(1e-5).stability
    assert stability.cam_stiffness == pytest.approx(5.0, rel=1e-6)
    cam = Impedance(5.0, 0.01, 0.02)
    rate = (-0.01 + math.sqrt(0.01**2 + 4.0 * 0.02 * 20.0)) / 0.04
    assert loop_growth(H, cam, Impedance(-25.0)) == pytest.approx(math.exp(rate * H), rel=1e-12)
    assert loop_growth(H, cam, Impedance(-4.0, 5.0)) == 1.0
    assert loop_growth(H, Impedance(-5.0, 0.0, J), Impedance()) == 1.0  # a plant that has no part in it
    assert loop_growth(H, cam, Impedance(inertia=-0.03)) == math.inf


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("start", [{"initial.theta": 0.4}, {}, {"initial.theta": 1.3963}])
def test_no_warning_at_rest(fmu, start):
    """In stick and at both stops the torque moves nothing, so the loop is open."""
    fmu.start(start)
    hold = fmu.real("torque_release") if start else -1.0
    hold = fmu.real("torque_load") + 1.0 if start.get("initial.theta") == 1.3963 else hold + 0.01
    coupling = PlantCoupling(fmu, lambda shaft: hold - 1e3 * shaft.omega)
    assert all(coupling.step_explicit(H).stability is None for _ in range(5))


# ---- feedback outside the plant function ----

GEAR, LIMIT, GOAL = 6.0, 24.0, 0.8  # 1, V, rad
GAIN = GEAR * AK80_6.torque_constant / AK80_6.resistance  # N.m/V at the shaft
BACK_EMF = GEAR * AK80_6.torque_constant  # V.s/rad


def held_voltage(fmu, step, proportional, derivative, seconds, implicit=False):
    """The angles [rad] under a voltage that is computed before each step, and the texts of the warnings."""
    fmu.start({"inertia.shaft": J})
    voltage = [0.0]
    coupling = PlantCoupling(fmu, lambda shaft: GAIN * (voltage[0] - BACK_EMF * shaft.omega))
    angles = []
    with recorded() as caught:
        for _ in range(round(seconds / step)):
            shaft = coupling.motion()
            wanted = proportional * (GOAL - shaft.theta) - derivative * shaft.omega
            voltage[0] = max(-LIMIT, min(LIMIT, wanted))
            made = coupling.step_implicit(step) if implicit else coupling.step_explicit(step)
            angles.append(made.motion.theta)
    assert all(one.category is UnstableCouplingWarning for one in caught)
    return np.array(angles), [str(one.message) for one in caught]


@pytest.mark.parametrize(("proportional", "derivative"), [(30.0, 2.0), (1000.0, 8.0)])
@pytest.mark.parametrize("implicit", [False, True])
def test_feedback_outside_the_plant_is_seen(fmu, proportional, derivative, implicit):
    """The cam should come to rest where the voltage makes the load edge of the stick band. The derivative
    held outside has GAIN derivative h/J > 2, so the cam trembles instead."""
    assert GAIN * derivative * H / J > 2.0
    angles, texts = held_voltage(fmu, H, proportional, derivative, 0.6, implicit)
    rise, first = (own * 0.02 / 2.0 * 1.14 / 0.86 for own in (50e3 * 0.02 / 2.0, 50.0))
    rest = (GAIN * proportional * GOAL - first) / (rise + GAIN * proportional)
    assert abs(angles[-1] - rest) > 0.04
    (text,) = texts
    assert "Something outside the plant function changes the torque" in text
    assert "step_implicit" in text and "step_difference" in text
    fine, texts = held_voltage(fmu, H / 10.0, proportional, derivative, 0.6, implicit)
    assert fine[-1] == pytest.approx(rest, abs=5e-3) and texts == []


def test_swings_from_stop_to_stop_between_set_points_are_seen(fmu):
    """A PI voltage outside, and a set-point that changes before 24 swings are made. At a hundredth of the
    step the cam follows, with less than a hundredth of the work."""

    def work(step):
        fmu.start({"inertia.shaft": J})
        voltage, sum_of_errors = [0.0], 0.0
        coupling = PlantCoupling(fmu, lambda shaft: GAIN * (voltage[0] - BACK_EMF * shaft.omega))
        for k in range(round(0.36 / step)):
            error = (0.3 if k * step < 0.18 else 0.9) - coupling.motion().theta
            sum_of_errors += error * step
            voltage[0] = max(-LIMIT, min(LIMIT, 30.0 * error + 50.0 * sum_of_errors))
            coupling.step_implicit(step)
        return fmu.real("energy.work_in")

    with pytest.warns(
        UnstableCouplingWarning, match="each of the last 8 steps of 0.02 s took the cam from stop"
    ):
        coarse = work(0.02)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert work(0.0002) < 0.01 * coarse


@pytest.mark.parametrize(("stiffness", "limit"), [(100.0, math.inf), (500.0, math.inf), (1500.0, 15.0)])
def test_an_angle_fed_back_outside_is_seen(fmu, stiffness, limit):
    """A held spring makes errors grow by sqrt(1 + K h^2/(2 J)) per step. With a limited torque the cam ends
    in swings from stop to stop, of many steps each."""
    held = 4.7  # N.m, in the stick band at GOAL
    fmu.start({"inertia.shaft": J, "initial.theta": 0.6, "tau": held})
    torque = [held]
    coupling, angles = PlantCoupling(fmu, lambda shaft: torque[0]), []
    with pytest.warns(UnstableCouplingWarning, match="outside the plant function") as caught:
        for _ in range(1000):
            torque[0] = held + max(-limit, min(limit, stiffness * (GOAL - coupling.motion().theta)))
            angles.append(coupling.step_explicit(H).motion.theta)
    assert [warning.filename for warning in caught] == [__file__]
    assert np.ptp(angles[-200:]) > 0.5


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "kind", ["noise outside", "binary noise outside", "square wave inside", "slow sine outside", "one move"]
)
def test_other_torques_are_no_feedback(fmu, kind):
    random, held = np.random.default_rng(7), [0.0]

    def outside(shaft):
        return {
            "noise outside": lambda: random.normal(3.0, 2.0),
            "binary noise outside": lambda: random.choice([1.0, 5.0]),
            "square wave inside": lambda: 0.0,
            "slow sine outside": lambda: 4.0 + 3.0 * math.sin(2.0 * math.pi * 5.0 * shaft.time),
            "one move": lambda: 30.0 * (GOAL - shaft.theta) - 0.3 * shaft.omega,
        }[kind]()

    def plant(shaft):
        wave = 3.0 * (-1.0) ** round(shaft.time / H) if kind == "square wave inside" else 0.0
        return held[0] + wave - 0.2 * shaft.omega

    fmu.start({"inertia.shaft": J, "initial.theta": 0.4})
    coupling = PlantCoupling(fmu, plant)
    for _ in range(1500):
        held[0] = outside(coupling.motion())
        coupling.step_explicit(H)


# ---- a run at a tenth of the step ----


def test_step_difference_of_a_held_damper(fmu):
    """omega shrinks by 1 - D h/J per step: both runs are known."""
    damping, speed = 0.2, 1e-3

    def run(step):
        fmu.start({**FREE, "initial.omega": speed})
        coupling = PlantCoupling(fmu, lambda shaft: -damping * shaft.omega)
        return [coupling.step_explicit(step).motion.omega for _ in range(round(0.02 / step))]

    steps = np.arange(1, 21)
    x = damping * H / J
    exact = np.abs((1.0 - x) ** steps - (1.0 - x / 10.0) ** (10 * steps)).max() * speed
    assert step_difference(run, H) == pytest.approx(exact, rel=1e-6)
    assert step_difference(lambda step: run(step)[-1], H) < exact
    assert step_difference(lambda step: [speed, *run(step)], H) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize(
    ("run", "step", "text"),
    [
        (lambda step: [0.0], 0.0, "step = 0.0: allowed"),
        (lambda step: np.zeros(round(1e-2 / step) + 3), H, r"\(13,\).* \(103,\): allowed are equal shapes"),
        (lambda step: [], H, "allowed are equal shapes"),
        (lambda step: math.nan, H, "not finite"),
    ],
)
def test_runs_that_cannot_be_compared(run, step, text):
    with pytest.raises(CouplingError, match=text):
        step_difference(run, step)


# ---- implicit coupling ----


def test_constant_acceleration_is_the_monoliths(fmu):
    """A spring of constant force: the acceleration is constant, and the mean acceleration is exact."""
    rotor, torque, force = 0.15, 3.0, 100.0
    constant = {"spring.preload": force, "spring.stiffness": 0.0}
    fmu.start({**constant, "inertia.shaft": J})
    coupling = PlantCoupling(fmu, lambda shaft: torque - rotor * shaft.alpha)
    for _ in range(100):
        step = coupling.step_implicit(H)
    edge = 0.02 / 2.0 * 1.14 / 0.86 * force  # rho F of two helices of 45 deg
    alpha = (torque - edge) / (J + rotor)
    assert step.motion.omega == pytest.approx(0.1 * alpha, rel=1e-9)
    assert step.motion.theta == pytest.approx(0.005 * alpha, rel=1e-9)
    fmu.start({**constant, "inertia.shaft": J + rotor, "tau": torque})
    fmu.step(0.1)
    assert (step.motion.theta, step.motion.omega) == pytest.approx(
        (fmu.real("theta"), fmu.real("omega")), rel=1e-9
    )


@pytest.mark.parametrize("weight", [0.5, 0.8, 1.0])
def test_torque_is_the_plants_at_the_motion_of_the_step(fmu, weight):
    """Nonlinear, and with stick, breakaway, slip and a stop inside."""

    def plant(shaft):
        return 8.0 * math.sin(9.0 * shaft.time) - 3.0 * shaft.omega**3 - shaft.theta**2 - 0.05 * shaft.alpha

    fmu.start({"inertia.shaft": J, "stop.restitution": 0.3})
    coupling, modes, h = PlantCoupling(fmu, plant), set(), 2e-3
    for _ in range(300):
        before = coupling.motion()
        step = coupling.step_implicit(h, weight)
        after = step.motion
        modes.add(fmu.get("mode"))
        theta, omega = (b + weight * (a - b) for a, b in zip(after[1:3], before[1:3], strict=True))
        mean = ShaftMotion(before.time + weight * h, theta, omega, (after.omega - before.omega) / h)
        assert step.torque == pytest.approx(plant(mean), rel=1e-8, abs=2e-9)
        assert step.fmu_steps <= 40
    assert {1, 2, 3, 4} <= modes


def test_second_trial_is_exact_for_a_linear_plant(fmu):
    fmu.start({"inertia.shaft": J, "initial.theta": 0.4, "initial.omega": 2.0, "tau": 4.0})
    coupling = PlantCoupling(fmu, lambda shaft: 22.0 - 5.0 * shaft.omega - 20.0 * shaft.theta)
    assert [coupling.step_implicit(H).fmu_steps for _ in range(5)] == [2] * 5


def test_relay_holds_the_speed_at_zero(fmu):
    """A plant that jumps: where the speed rests at the jump, the torque lies between its two values."""
    fmu.start({**FREE, "initial.omega": 0.05})
    coupling = PlantCoupling(fmu, lambda shaft: -math.copysign(1.0, shaft.omega))
    for _ in range(5):
        step = coupling.step_implicit(H, end_weight=1.0)
    assert abs(step.motion.omega) < 1e-9 and abs(step.torque) < 1.0


def test_stiff_damper_at_a_bouncing_stop(fmu):
    """An impact makes the residual fall where the end of the step passes it: bisection."""
    fmu.start({"stop.restitution": 0.9, "initial.theta": 1.2, "initial.omega": 15.0, "inertia.shaft": J})
    coupling = PlantCoupling(fmu, lambda shaft: 12.0 - 0.2 * shaft.omega)
    trials = [coupling.step_implicit(3e-3).fmu_steps for _ in range(200)]
    assert max(trials) <= 60 and np.median(trials) <= 4
    assert fmu.get("mode") == 5


# ---- the motor of the benchmark, with stick, slip and both stops ----


def scipy_truth(times):
    """theta at times [s]: J theta'' = T(t) - D omega - rho_sigma (F0 + k z), stops that do not bounce."""
    gain, inertia, damping = (
        own_plant.CONSTANT / AK80_6.resistance,
        own_plant.CAM + own_plant.ROTOR,
        own_plant.DAMPING,
    )
    upper, now, theta = 1.3963, 0.0, 0.0
    found = np.zeros(len(times))

    def edge(angle, sign):
        mu, r = 0.14, 0.02
        return r / 2.0 * (1.0 + sign * mu) / (1.0 - sign * mu) * (50.0 + 50e3 * r / 2.0 * angle)

    def torque(time):
        return gain * own_plant.voltage(time)

    while now < own_plant.DURATION:
        # rest: until the torque leaves the band towards a side that is free
        ways = [s for s in (1, -1) if (theta < upper if s > 0 else theta > 0.0)]
        grid = np.linspace(now, own_plant.DURATION, 20_001)
        starts = {}
        for sign in ways:
            beyond = [sign * (torque(t) - edge(theta, sign)) for t in grid]
            if beyond[0] > 0.0:
                starts[sign] = now
            elif (k := int(np.argmax(np.array(beyond) > 0.0))) > 0:
                starts[sign] = brentq(
                    lambda t, s=sign, a=theta: torque(t) - edge(a, s), grid[k - 1], grid[k], xtol=1e-15
                )
        start = min(starts.values(), default=own_plant.DURATION)
        found[(times >= now) & (times <= start)] = theta
        if not starts:
            break
        sign = min(starts, key=starts.get)

        def rates(t, y, sign=sign):
            return [y[1], (torque(t) - damping * y[1] - edge(y[0], sign)) / inertia]

        def rest(t, y, start=start):
            return y[1] if t > start else 1.0

        def stop(t, y, sign=sign):
            return y[0] - (upper if sign > 0 else 0.0)

        rest.terminal = stop.terminal = True
        rest.direction, stop.direction = -sign, sign
        # one small step by series, so that the speed at the start is not an event
        small = 1e-7
        jerk = (gain * (own_plant.voltage(start + small) - own_plant.voltage(start)) / small) / inertia
        alpha = rates(start, [theta, 0.0])[1]
        first = [
            theta + alpha * small**2 / 2.0 + jerk * small**3 / 6.0,
            alpha * small + jerk * small**2 / 2.0,
        ]
        solution = solve_ivp(
            rates, (start + small, own_plant.DURATION), first, method="DOP853", rtol=1e-12, atol=1e-14,
            events=(rest, stop), dense_output=True, max_step=1e-3,
        )  # fmt: skip
        now = solution.t[-1]
        inside = (times > start + small) & (times <= now)
        found[inside] = solution.sol(times[inside])[0]
        theta = (upper if sign > 0 else 0.0) if len(solution.t_events[1]) else solution.y[0, -1]
    return found


@pytest.fixture(scope="module")
def exact(fmu):
    return own_plant.truth(fmu)


def test_truth_is_scipys(exact):
    every = 20
    times = np.arange(0, len(exact), every) * own_plant.TRUTH_STEP
    assert exact[::every, 0] == pytest.approx(scipy_truth(times), abs=1e-8)
    assert exact[:, 0].max() == pytest.approx(1.3963, abs=1e-12) and exact[-1, 0] == 0.0


def variant(name):
    return next(one for one in own_plant.VARIANTS if one.name == name)


@pytest.mark.parametrize(("name", "order", "bound"), [("f", 2, 1e-3), ("g", 2, 1e-5), ("h", 1, 1e-4)])
def test_newton_converges_to_the_whole_system(fmu, exact, name, order, bound):
    """Steps of 2 and 0.5 ms; largest error of the angle at 1 ms [rad]."""
    errors = {}
    for step in (0.5e-3, 1e-3, 2e-3):
        made = own_plant.run(fmu, variant(name), step)
        errors[step] = own_plant.error(made, exact, step)
        assert not made.warned and made.fmu_steps < 2.1
    assert errors[1e-3] < bound
    assert math.log(errors[2e-3] / errors[0.5e-3], 4.0) == pytest.approx(order, abs=0.3)


@pytest.mark.parametrize(("name", "step", "stable"), [
    ("a", 1e-3, False), ("b", 0.5e-3, False), ("c", 1e-3, True), ("c", 2e-3, True), ("c", 4e-3, False),
    ("d", 0.5e-3, True), ("d", 1e-3, False), ("e", 0.5e-3, True), ("e", 1e-3, False),
])  # fmt: skip
def test_motor_is_stable_where_nothing_is_warned_of(fmu, exact, name, step, stable):
    made = own_plant.run(fmu, variant(name), step)
    assert made.warned is not stable
    assert (own_plant.error(made, exact, step) < 1e-4) is stable


def test_benchmark_writes_what_it_measures(tmp_path, fmu):
    exact, runs = own_plant.study(fmu, (own_plant.STEP,))
    rows = own_plant.rows_of(exact, runs)
    assert [row["warned"] for row in rows] == ["yes", "yes", "no", "yes", "yes", "no", "no", "no"]
    facts = {name: "x" for name in ("command", "commit", "date", "machine", "versions")}
    own_plant.picture(exact, runs, facts, tmp_path / "own_plant.png")
    assert (tmp_path / "own_plant.png").stat().st_size > 10_000


# ---- refusals ----


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda c: c.step_explicit(0.0), "step = 0.0: allowed is a finite number > 0, in s"),
        (lambda c: c.step_implicit(math.nan), "step = nan: allowed is a finite number > 0, in s"),
        (lambda c: c.step_implicit("1 ms"), "step = '1 ms': allowed is a finite number > 0, in s"),
        (lambda c: c.step_explicit([H, H]), r"step = \[0.001, 0.001\]: allowed"),
        (lambda c: c.step_explicit(H, order="1"), "order = 1: allowed"),
        (lambda c: c.step_implicit(H, end_weight="1"), "end_weight = '1': allowed"),
        (lambda c: step_difference(lambda step: 0.0, None), "step = None: allowed"),
        (lambda c: spectral_radius(H, J, 1.25), "plant = 1.25: allowed is an Impedance"),
        (lambda c: largest_stable_step(J, Impedance("5")), "stiffness = '5': allowed is a finite number"),
        (lambda c: spectral_radius(H, J, Impedance(), cam_damping=-1.0), "cam_damping = -1.0: allowed"),
        (lambda c: spectral_radius(H, J, Impedance(), 1, plant_is_fmu=True), "order = 1: allowed is 0"),
        (lambda c: c.step_explicit(H, order=3), "order = 3: allowed"),
        (lambda c: c.step_implicit(H, end_weight=0.4), "end_weight = 0.4: allowed"),
        (lambda c: spectral_radius(H, -1.0, Impedance()), "inertia = -1.0"),
    ],
)
def test_refused_arguments(fmu, call, text):
    fmu.start()
    with pytest.raises(CouplingError, match=text):
        call(PlantCoupling(fmu, lambda shaft: 0.0))


def counter():
    """A plant that changes its state at each call."""
    calls = itertools.count()
    return lambda shaft: 0.01 * next(calls)


def test_no_torque_within_the_trials(fmu, monkeypatch):
    """Two trials do not do for a plant that is not linear."""
    monkeypatch.setattr("dualcam.coupling.plant_coupling.ITERATIONS", 2)
    fmu.start({**FREE, "initial.omega": 2.0})
    coupling = PlantCoupling(fmu, lambda shaft: -(shaft.omega**3))
    before = coupling.motion()
    with pytest.raises(CouplingError, match="no torque suits the plant within 2 trials"):
        coupling.step_implicit(H)
    assert coupling.motion() == before


def test_a_plant_that_fails_in_a_trial_leaves_the_fmu_as_it_was(fmu):
    """The torque before the step is known, that of the motion at its middle is not."""
    fmu.start({"inertia.shaft": J, "initial.theta": 0.4, "initial.omega": 2.0})
    coupling = PlantCoupling(fmu, lambda shaft: 1.0 if shaft.time == 0.0 else 1.0 / 0.0)
    before = coupling.motion()
    with pytest.raises(ZeroDivisionError):
        coupling.step_implicit(H)
    assert coupling.motion() == before


@pytest.mark.parametrize("plant", [5.0, None])
def test_a_plant_is_a_function(fmu, plant):
    with pytest.raises(CouplingError, match=f"plant = {plant}: allowed is a function that gets the motion"):
        PlantCoupling(fmu, plant)


def test_only_the_forward_fmu_takes_a_torque():
    with Fmu("inverse") as inverse, pytest.raises(CouplingError, match="allowed is the forward FMU"):
        PlantCoupling(inverse, lambda shaft: 0.0)
    with pytest.raises(CouplingError, match="fmu = 'forward': allowed is the forward FMU, started"):
        PlantCoupling("forward", lambda shaft: 0.0)


@pytest.mark.parametrize(
    ("plant", "text"),
    [
        (counter(), "changes no state"),
        (lambda shaft: math.nan, "the plant returns nan at"),
        (lambda shaft: None, "the plant returns None at .* allowed is a finite number"),
        (lambda shaft: "5", "the plant returns '5' at .* allowed is a finite number"),
        (lambda shaft: np.array([1.0, 2.0]), r"the plant returns array\(\[1., 2.\]\) at"),
    ],
)
def test_refused_plant_leaves_the_fmu_as_it_was(fmu, plant, text):
    fmu.start({"inertia.shaft": J, "initial.theta": 0.4, "initial.omega": 2.0})
    coupling = PlantCoupling(fmu, plant)
    before = coupling.motion()
    with pytest.raises(CouplingError, match=text):
        coupling.step_implicit(H)
    assert coupling.motion() == before
    assert PlantCoupling(fmu, lambda shaft: 6.0).step_implicit(H).motion.time == H
