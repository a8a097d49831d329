"""Torques that touch an edge of the stick band: polynomials with double and triple roots.

At a root of even order the torque reaches the edge and turns back. Rounding can lift it over the edge by the
last digits. The mechanism then rests on: there is nothing that moves it. At a root of odd order the torque
passes the edge, first as slowly as t^3. Either way the step is made, and its result does not depend on how
the step is cut.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from control_cases import FORWARD
from numpy.polynomial import Polynomial
from reference import LOWER_STOP, STICK, UPPER_STOP, Interval, Refused, simulate

from dualcam import Fmu

UPPER = 1.2  # rad, the upper stop
NO_PRELOAD = {"spring.preload": 0.0}
ELLIPSES = {
    f"cam{i}.{name}": value
    for i in (1, 2)
    for name, value in {
        "profile": 2,
        "radius": 0.02,
        "lead_angle": 1.1867,
        "ellipse_a": 0.0756,
        "ellipse_b": 0.0188,
        "ellipse_curvature": -1,
    }.items()
}
KNEE = {
    **ELLIPSES,
    **NO_PRELOAD,
    "spring.stiffness": 44800.0,
    "damper.c_release": 20060.0,
    "inertia.shaft": 0.4127,
}
MECHANISMS = {
    "knee": KNEE,
    "helices": {},
    "helices, no preload": NO_PRELOAD,
    "helices, follower mass": NO_PRELOAD | {"inertia.follower_mass": 0.5},
    "helices, bounces": NO_PRELOAD | {"stop.restitution": 0.5},
    "helices, locked": {"cam1.friction": 1.2},
    "helices, shaft damping only": NO_PRELOAD | {"inertia.shaft": 0.0, "shaft.damping": 0.1},
    "ellipses": ELLIPSES,
    "ellipses, no preload": ELLIPSES | NO_PRELOAD,
    "ellipses, follower mass": ELLIPSES | NO_PRELOAD | {"inertia.follower_mass": 0.5},
    "ellipses, cubic spring": ELLIPSES | NO_PRELOAD | {"spring.stiffness2": 1e5},
    "ellipses, no friction": ELLIPSES | NO_PRELOAD | {"cam1.friction": 0.0, "cam2.friction": 0.0},
}
WHERE = {"lower": 0.0, "inside": 0.7, "upper": UPPER}  # rad


def taylor(polynomial):
    """Value and three derivatives at time 0."""
    return [float(polynomial.deriv(k)(0.0)) if k else float(polynomial(0.0)) for k in range(4)]


def later(derivatives, time):
    """Value and three derivatives at that time."""
    return [
        sum(derivatives[k + j] * time**j / math.factorial(j) for j in range(4 - k)) for k in range(4)
    ]  # fmt: skip


def root(time, order):
    return Polynomial([-time, 1.0]) ** order


@dataclass
class Scene:
    parameters: dict
    duration: float  # s
    tau: list  # value and three derivatives at time 0
    load: list

    def run(self, fmu, cuts=()):
        """(theta, omega, residual of the energies) at the end."""
        fmu.start(self.parameters, tolerance=1e-10)
        inputs = fmu.reals("tau", "F_ext")
        times = [0.0, *sorted(t for t in cuts if 0.0 < t < self.duration), self.duration]
        for start, end in pairwise(times):
            rows = list(zip(later(self.tau, start), later(self.load, start), strict=True))
            inputs.values[:] = rows[0]
            inputs.write()
            for order in (1, 2, 3):
                inputs.write_derivatives(order, rows[order])
            fmu.step(end - start)
        assert all(map(math.isfinite, fmu.reals("step.dtheta_dtau", "step.domega_dtau").read()))
        return fmu.reals("theta", "omega", "energy.residual").read()


def edges(fmu, parameters, load):
    """Torques at the edges of the stick band at the start, and zero."""
    fmu.start(parameters)
    fmu.set("F_ext", load)
    found = (fmu.get("torque_release"), fmu.get("torque_load"), 0.0)
    return [edge for edge in found if math.isfinite(edge)]


# ---- the torque touches the edge and turns back ----


def touching(fmu, mechanism, where, rng):
    """A torque that touches an edge from the side on which the mechanism rests."""
    parameters = MECHANISMS[mechanism] | {"stop.upper": UPPER, "initial.theta": WHERE[where]}
    release, load, *_ = edges(fmu, parameters, 0.0)
    # The stop holds the torque beyond the edge too.
    held = {"lower": [(release, -1), (load, -1)], "upper": [(load, 1), (release, 1)], "inside": [(load, -1)]}
    edge, side = held[where][rng.integers(len(held[where]))]
    duration = 10 ** rng.uniform(-3, -0.5)
    touch = rng.choice([0.0, duration, duration / 2, rng.uniform(0, duration)])
    torque = edge + side * 10 ** rng.uniform(-6, -3) * root(touch, 2) / duration**2
    tau = [u + int(rng.integers(-4, 5)) * math.ulp(u) for u in taylor(torque)]
    return Scene(parameters, duration, tau, [0.0] * 4), touch


@pytest.mark.parametrize("where", WHERE)
@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_a_touch_moves_nothing(mechanism, where):
    if mechanism == "ellipses, no friction" and where == "inside":
        pytest.skip("without friction the band has no width: nothing but a stop holds the mechanism")
    with Fmu(FORWARD) as fmu:
        for seed in range(20):
            rng = np.random.default_rng(seed)
            scene, touch = touching(fmu, mechanism, where, rng)
            for cuts in [(), (touch,), rng.uniform(0, scene.duration, 2)]:
                theta, _, _ = scene.run(fmu, cuts)
                assert theta == pytest.approx(WHERE[where], rel=0, abs=1e-13), seed


def test_the_knee_rests_at_its_stop():
    """The end of a smooth torque, as a spline with a level end has it; its coefficients round anywhere."""
    end = (-0.00079579199999813, 0.7943546666667203, -395.02133333333325, -2156.0)
    with Fmu(FORWARD) as fmu:
        for seed in range(60):
            rng = np.random.default_rng(seed)
            tau = [u + int(rng.integers(-8, 9)) * math.ulp(u) for u in end]
            scene = Scene(KNEE | {"stop.upper": 1.3963}, 0.002, tau, [0.0] * 4)
            theta, omega, _ = scene.run(fmu)
            assert (theta, omega, fmu.get("mode")) == (0.0, 0.0, LOWER_STOP), seed
            assert fmu.get("events") == 1, seed  # from rest without torque


@pytest.mark.parametrize("mechanism", ["helices", "ellipses"])
@pytest.mark.parametrize(("where", "mode"), [("lower", LOWER_STOP), ("inside", STICK), ("upper", UPPER_STOP)])
def test_a_touch_is_no_mode_change(mechanism, where, mode):
    """The torque touches the release edge, or at the upper stop the load edge, from the side of the mode."""
    with Fmu(FORWARD) as fmu:
        parameters = MECHANISMS[mechanism] | {"stop.upper": UPPER, "initial.theta": WHERE[where]}
        release, load, _ = edges(fmu, parameters, 0.0)
        edge, side = (load, 1) if where == "upper" else (release, -1 if where == "lower" else 1)
        scene = Scene(parameters, 0.5, taylor(edge + 0.01 * side * root(0.25, 2)), [0.0] * 4)
        before = Scene(parameters, 0.2, scene.tau, scene.load)
        before.run(fmu)
        events = fmu.get("events")
        assert fmu.get("mode") == mode
        scene.run(fmu)
        assert (fmu.get("mode"), fmu.get("events")) == (mode, events)


# ---- roots of any order ----


def random_scene(fmu, mechanism, rng):
    """Torque, or load, with a multiple root on an edge of the stick band."""
    duration = 10 ** rng.uniform(-3, -0.5)
    place = list(WHERE)[rng.integers(len(WHERE))]
    parameters = MECHANISMS[mechanism] | {"stop.upper": UPPER, "initial.theta": WHERE[place]}
    time = rng.choice([0.0, duration, duration / 2, rng.uniform(0, duration)])
    other = rng.choice([0.0, duration, rng.uniform(-duration, 2 * duration)])
    near = time + rng.uniform(-1, 1) * rng.choice([1e-15, 1e-12, 1e-9, 1e-6])
    shapes = [root(time, 1), root(time, 2), root(time, 3), root(time, 2) * root(other, 1)]
    shape = [*shapes, root(time, 1) * root(near, 1)][rng.integers(5)]
    shape = shape * (rng.choice([-1, 1]) * 10 ** rng.uniform(-6, 1.5) / duration ** shape.degree())
    fmu.start(parameters)
    spring = fmu.get("spring.force")
    load = [0.0] * 4
    kind = rng.choice(["none", "balanced", "some"], p=[0.6, 0.2, 0.2])
    if kind != "none":
        load[0] = -spring if kind == "balanced" else rng.uniform(-2, 1) * (spring + 10)
    values = edges(fmu, parameters, load[0])
    tau = taylor(shape)
    tau[0] += values[rng.integers(len(values))]
    return Scene(parameters, duration, tau, load), time


@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_the_result_does_not_depend_on_the_cuts(mechanism):
    with Fmu(FORWARD) as fmu:
        for seed in range(40):
            rng = np.random.default_rng(seed)
            scene, time = random_scene(fmu, mechanism, rng)
            whole, _, _ = scene.run(fmu)
            for cuts in [
                (time,),
                (time * (1 - 1e-15), time * (1 + 1e-13)),
                rng.uniform(0, scene.duration, 3),
            ]:
                theta, _, residual = scene.run(fmu, cuts)
                assert theta == pytest.approx(whole, rel=0, abs=1e-9), seed
                assert abs(residual) < 1e-9, seed


def reference_angle(scene, parts):
    """theta at the end of the scene, or None where the reference doubts. `parts`: the reference looks for
    events once in each part, and would miss two of them close together in a long one."""
    intervals = []
    for start in np.linspace(0.0, scene.duration, parts, endpoint=False):
        tau, load = later(scene.tau, start), later(scene.load, start)
        rates = {"tau_rate": tau[1], "tau_rate2": tau[2], "tau_rate3": tau[3]}
        intervals.append(Interval(scene.duration / parts, tau[0], F_ext=load[0], **rates))
    try:
        points = simulate(scene.parameters, intervals)
    except (Refused, ArithmeticError):
        return None
    return None if any(point.doubts for point in points) else points[-1].theta


@pytest.mark.parametrize("mechanism", ["helices", "helices, follower mass"])
def test_the_reference_gives_the_same(mechanism):
    compared = 0
    with Fmu(FORWARD) as fmu:
        for seed in range(1000, 1016):
            scene, _ = random_scene(fmu, mechanism, np.random.default_rng(seed))
            expected = reference_angle(scene, parts=20)
            if expected is None:
                continue
            compared += 1
            assert scene.run(fmu)[0] == pytest.approx(expected, rel=0, abs=1e-9), seed
    assert compared >= 8


@pytest.mark.parametrize("mechanism", ["ellipses, follower mass", "helices, follower mass"])
def test_the_flanks_after_a_triple_root(mechanism):
    """A step begins at the root. Rounding may let the torque fall first; the flanks are those of the rise."""
    with Fmu(FORWARD) as fmu:
        for seed in range(20):
            rng = np.random.default_rng(seed)
            duration = 10 ** rng.uniform(-3, -0.5)
            time = rng.uniform(0.2, 0.8) * duration
            torque = 10 ** rng.uniform(-3, 0) * root(time, 3) / duration**3
            parameters = MECHANISMS[mechanism] | {"stop.upper": UPPER}
            scene = Scene(parameters, duration, taylor(torque), [0.0] * 4)
            whole = scene.run(fmu)[0]
            assert whole > 0.0
            assert scene.run(fmu, (time,))[0] == pytest.approx(whole, rel=1e-6, abs=1e-12), seed
