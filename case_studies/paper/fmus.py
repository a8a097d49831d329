"""The numbers that come from the FMUs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from case_studies.paper.cams import Pair, other_pairs, pair
from case_studies.paper.printed import Case
from case_studies.paper.published import (
    EQUAL,
    GREASES,
    OTHERS,
    PAIRS,
    PULL,
    QUADRATIC,
    RANGE,
    SPEED,
    TORQUE,
    WAYS,
)
from dualcam import Fmu
from dualcam.design.statics import Array


@dataclass(frozen=True)
class Curve:
    """One way along the range as DualCamInverse gives it."""

    angle: Array  # rad
    torque: Array  # N.m
    reactions: tuple[Array, Array]  # per contact, N
    sliding: tuple[Array, Array]  # m/s at 1 rad/s


def curve(inverse: Fmu, cams: Pair, friction: float, direction: int, angle: Array) -> Curve:
    """Torque and reactions at 1 rad/s without inertia: the kinetostatic ones."""
    inverse.start({**cams.parameters(friction), "ledger": False})
    motion = inverse.reals("theta", "omega")
    wanted = inverse.reals(
        "tau", "cam1.reaction", "cam2.reaction", "cam1.sliding_speed", "cam2.sliding_speed"
    )
    rows = []
    for theta in angle[::direction]:
        motion.values[:] = theta, direction
        motion.write()
        inverse.step(1.0)
        rows.append(wanted.read())
    tau, first, second, slow, fast = np.array(rows)[::direction].T
    return Curve(angle, tau, (first, second), (np.abs(slow), np.abs(fast)))


def edges(inverse: Fmu, parameters: dict[str, float]) -> tuple[float, float]:
    """Torques when loading and releasing at the start of two helices, N.m."""
    inverse.start({"inertia.shaft": 0.0, "stop.upper": 0.01, **parameters})
    return inverse.real("torque_load"), inverse.real("torque_release")


def helices(
    lead: tuple[float, float], friction: tuple[float, float], radii: tuple[float, float], force: float
) -> dict[str, float]:
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
    load, release = edges(inverse, helices(lead, friction, radii, 1000.0))
    return release / load


def friction_heat(forward: Fmu, cams: Pair, friction: float) -> tuple[float, float]:
    """Heat at cam 1 and cam 2 of a slow cycle over the whole range, J: torque up and down in ramps."""
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
    """All that is taken from the FMUs."""

    inverse: Fmu
    forward: Fmu

    @cached_property
    def angle(self) -> Array:
        return np.linspace(0.0, RANGE, 57)

    @cached_property
    def curves(self) -> dict[tuple[str, float, int], Curve]:
        return {
            (name, mu, way): curve(self.inverse, pair(name), mu, way, self.angle)
            for name in PAIRS
            for mu in GREASES
            for way in WAYS
        }

    @cached_property
    def others(self) -> dict[str, list[tuple[Pair, Array, Array]]]:
        """Other pairs with their torques when loading and releasing, grease 1."""
        found: dict[str, list[tuple[Pair, Array, Array]]] = {name: [] for name in PAIRS}
        for name in PAIRS:
            for cams in other_pairs(name, OTHERS):
                up, down = (curve(self.inverse, cams, GREASES[0], way, self.angle).torque for way in WAYS)
                found[name].append((cams, up, down))
        return found

    @cached_property
    def heat(self) -> dict[tuple[str, float], float]:
        """Friction heat of a slow cycle, J."""
        return {
            (name, mu): sum(friction_heat(self.forward, pair(name), mu)) for name in PAIRS for mu in GREASES
        }

    def best_on_grid(self, friction: float) -> tuple[float, float, float]:
        """Largest efficiency on a grid of lead angles with pi/4 in it: lead angles and efficiency."""
        grid = np.linspace(0.3, 0.5 * math.pi - 0.3, 21)
        found = [
            (efficiency_of_fmu(self.inverse, (x, y), (friction, friction), EQUAL), x, y)
            for x in grid
            for y in grid
        ]
        best, x, y = max(found)
        return float(x), float(y), best


def torques_of_fmu(work: FmuResults, case: Case) -> tuple[float, float]:
    """Torques of the FMU when loading and releasing."""
    parameters = helices(case.lead, (case.friction, case.friction), case.radii, case.force)
    return edges(work.inverse, parameters)


def damper_of_fmu(work: FmuResults, case: Case) -> tuple[float, float]:
    """Damper force and torque when releasing at SPEED."""
    s1, s2 = (r * math.tan(x) for r, x in zip(case.radii, case.lead, strict=True))
    parameters = helices(case.lead, (case.friction,) * 2, case.radii, case.force)
    omega = -SPEED * (s1 + s2) / (s1 * s2)
    work.inverse.start({**parameters, "inertia.shaft": 0.0, "damper.q_release": QUADRATIC, "omega": omega})
    return work.inverse.real("damper.force"), work.inverse.real("tau")


def pull_of_fmu(work: FmuResults, case: Case) -> tuple[float, float]:
    """Torque when loading at 1 rad/s with the follower pulled up, and its speed: friction takes T - F v."""
    parameters = helices(case.lead, (case.friction,) * 2, case.radii, case.force)
    work.inverse.start({**parameters, "inertia.shaft": 0.0, "F_ext": PULL, "omega": 1.0})
    return work.inverse.real("tau"), work.inverse.real("v")
