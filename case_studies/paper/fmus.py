"""The numbers that come from the FMUs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from case_studies.paper.cams import Pair, other_pairs, pair
from case_studies.paper.printed import Case
from case_studies.paper.published import (
    DIRECTIONS,
    EQUAL,
    GREASES,
    OTHERS,
    PAIRS,
    PULL,
    QUADRATIC,
    RANGE,
    SPEED,
    TORQUE,
)
from case_studies.paper.varying import FrictionLaw
from dualcam import Fmu
from dualcam.design.statics import Array


@dataclass(frozen=True)
class Curve:
    """Torque, reactions and sliding speeds in one direction along the range, as DualCamInverse gives them;
    arrays of shape (n,)."""

    angle: Array  # rad
    torque: Array  # N.m
    reactions: tuple[Array, Array]  # per contact, N
    sliding: tuple[Array, Array]  # m/s


def curve(
    inverse: Fmu,
    cams: Pair,
    friction: float,
    direction: int,
    angle: Array,
    speed: float = 1.0,
    law: FrictionLaw | None = None,
) -> Curve:
    """The kinetostatic curve: at `speed` [rad/s] without inertia, at these angles [rad], shape (n,)."""
    varying = law.parameters() if law else {}
    inverse.start({**cams.parameters(friction), **varying, "ledger": False})
    motion = inverse.reals("theta", "omega")
    wanted = inverse.reals(
        "tau", "cam1.reaction", "cam2.reaction", "cam1.sliding_speed", "cam2.sliding_speed"
    )
    rows = []
    for theta in angle[::direction]:
        motion.values[:] = theta, direction * speed
        motion.write()
        inverse.step(1.0)
        rows.append(wanted.read())
    tau, first, second, slow, fast = np.array(rows)[::direction].T
    return Curve(angle, tau, (first, second), (np.abs(slow), np.abs(fast)))


def edges(inverse: Fmu, parameters: dict[str, float]) -> tuple[float, float]:
    """Torques [N.m] when loading and releasing at theta = 0 of two helices."""
    inverse.start({"inertia.shaft": 0.0, "stop.upper": 0.01, **parameters})
    return inverse.real("torque_load"), inverse.real("torque_release")


def helices(
    lead: tuple[float, float], friction: tuple[float, float], radii: tuple[float, float], force: float
) -> dict[str, float]:
    """Start values of the FMU with two helices under a constant axial force [N]."""
    return {
        "cam1.radius": radii[0],
        "cam2.radius": radii[1],
        "cam1.lead_angle": lead[0],
        "cam2.lead_angle": lead[1],
        "cam1.friction": friction[0],
        "cam2.friction": friction[1],
        "spring.preload": force,
        "spring.stiffness": 0.0,
    }


def efficiency_of_fmu(
    inverse: Fmu, lead: tuple[float, float], friction: tuple[float, float], radii: tuple[float, float]
) -> float:
    """Torque when releasing over torque when loading."""
    load, release = edges(inverse, helices(lead, friction, radii, 1000.0))
    return release / load


def friction_heat(forward: Fmu, cams: Pair, friction: float) -> tuple[float, float]:
    """Friction heat [J] at cam 1 and cam 2 of a slow cycle over the whole range: torque in ramps up and
    down."""
    peak = 1.2 * TORQUE * max(1.0, friction / GREASES[0])
    forward.start(cams.parameters(friction))
    command = forward.reals("tau")
    for start, rate in ((0.0, peak), (peak, -peak)):
        command.values[0] = start
        command.write()
        command.write_derivatives(1, [rate])
        forward.step(1.0)
    assert abs(forward.real("theta")) < 1e-9, "the cycle does not come back"
    return forward.real("energy.heat_cam1"), forward.real("energy.heat_cam2")


@dataclass(frozen=True)
class FmuResults:
    """The numbers of the page that come from the FMUs, each computed once."""

    inverse: Fmu
    forward: Fmu

    @cached_property
    def angle(self) -> Array:
        """Angles of all curves [rad], shape (57,)."""
        return np.linspace(0.0, RANGE, 57)

    @cached_property
    def curves(self) -> dict[tuple[str, float, int], Curve]:
        """By pair, friction and direction."""
        return {
            (name, mu, direction): curve(self.inverse, pair(name), mu, direction, self.angle)
            for name in PAIRS
            for mu in GREASES
            for direction in DIRECTIONS
        }

    @cached_property
    def others(self) -> dict[str, list[tuple[Pair, Array, Array]]]:
        """Other pairs with their torques when loading and releasing, grease 1."""
        found: dict[str, list[tuple[Pair, Array, Array]]] = {name: [] for name in PAIRS}
        for name in PAIRS:
            for cams in other_pairs(name, OTHERS):
                up, down = (
                    curve(self.inverse, cams, GREASES[0], direction, self.angle).torque
                    for direction in DIRECTIONS
                )
                found[name].append((cams, up, down))
        return found

    @cached_property
    def heat(self) -> dict[tuple[str, float], float]:
        """Friction heat of a slow cycle [J], by pair and friction."""
        return {
            (name, mu): sum(friction_heat(self.forward, pair(name), mu)) for name in PAIRS for mu in GREASES
        }

    def best_on_grid(self, friction: float) -> tuple[float, float, float]:
        """Lead angles [rad] and efficiency of the best point of a grid that contains pi/4."""
        grid = np.linspace(0.3, 0.5 * math.pi - 0.3, 21)
        found = [
            (efficiency_of_fmu(self.inverse, (x, y), (friction, friction), EQUAL), x, y)
            for x in grid
            for y in grid
        ]
        best, x, y = max(found)
        return float(x), float(y), best


def torques_of_fmu(results: FmuResults, case: Case) -> tuple[float, float]:
    """Torques [N.m] of the FMU when loading and releasing."""
    parameters = helices(case.lead, (case.friction, case.friction), case.radii, case.force)
    return edges(results.inverse, parameters)


def damper_of_fmu(results: FmuResults, case: Case) -> tuple[float, float]:
    """Damper force [N] and torque [N.m] when releasing at SPEED."""
    s1, s2 = (r * math.tan(x) for r, x in zip(case.radii, case.lead, strict=True))
    parameters = helices(case.lead, (case.friction,) * 2, case.radii, case.force)
    omega = -SPEED * (s1 + s2) / (s1 * s2)
    results.inverse.start({**parameters, "inertia.shaft": 0.0, "damper.q_release": QUADRATIC, "omega": omega})
    return results.inverse.real("damper.force"), results.inverse.real("tau")


def pull_of_fmu(results: FmuResults, case: Case) -> tuple[float, float]:
    """Torque [N.m] when loading at 1 rad/s with the follower pulled up by PULL, and the follower's speed v
    [m/s]. Friction takes T - F v."""
    parameters = helices(case.lead, (case.friction,) * 2, case.radii, case.force)
    results.inverse.start({**parameters, "inertia.shaft": 0.0, "F_ext": PULL, "omega": 1.0})
    return results.inverse.real("tau"), results.inverse.real("v")
