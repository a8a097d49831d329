"""The four scenes, and the errors of a result in them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from benchmarks.harness.oracles import reference
from benchmarks.harness.pieces import Piece
from benchmarks.mechanisms import CUBIC, ELLIPSES, FORCES
from benchmarks.work_precision.plain_cam import PlainCam

Points = list[tuple[float, float]]  # theta, omega at the end of every piece
Result = tuple[Points, list[float]]  # and the energy dissipated until then [J]

HEATS = ("heat_cam1", "heat_cam2", "heat_damper", "heat_shaft", "heat_stop")


@dataclass(frozen=True)
class Scene:
    name: str
    description: str
    parameters: dict[str, Any]
    pieces: tuple[Piece, ...]

    @property
    def exact(self) -> bool:
        return PlainCam(self.parameters).linear

    @property
    def duration(self) -> float:
        return sum(duration for duration, _ in self.pieces)

    @cached_property
    def intervals(self) -> list[Any]:
        return [reference.Interval(duration, tau) for duration, tau in self.pieces]

    @cached_property
    def truth(self) -> Result:
        solve = reference.simulate_exact if self.exact else reference.simulate
        return of_reference(solve(self.parameters, self.intervals))

    def result(self, points: Points) -> Result:
        """The points with the energy dissipated until each of them: work done less energy stored."""
        cam = PlainCam(self.parameters)
        theta, work, heats = cam.start[0], 0.0, []
        before = cam.stored(*cam.start)
        for (_, tau), point in zip(self.pieces, points, strict=True):
            work += tau * (point[0] - theta)
            theta = point[0]
            heats.append(work - (cam.stored(*point) - before))
        return points, heats

    def errors(self, found: Result) -> tuple[float, float, float]:
        """Largest errors of theta, omega and energy, relative to the largest size of each (to 1 where that is
        0)."""
        pairs = zip(columns(found), columns(self.truth), strict=True)
        theta, omega, heat = (float(np.max(np.abs(a - b)) / (np.max(np.abs(b)) or 1.0)) for a, b in pairs)
        return theta, omega, heat


def columns(result: Result) -> list[np.ndarray]:
    return [*np.array(result[0]).T, np.array(result[1])]


def of_reference(points: Sequence[reference.Point]) -> Result:
    heats = [math.fsum(p.energy[name] for name in HEATS) for p in points]
    return [(p.theta, p.omega) for p in points], heats


def pieces(duration: float, *torques: float) -> tuple[Piece, ...]:
    return tuple((duration, tau) for tau in torques)


def quiet_hold() -> tuple[Piece, ...]:
    """Three moves in 100 s; else torques inside the stick band."""
    torques = [(3.5, 4.5)[k % 2] for k in range(100)]
    torques[0], torques[34], torques[67] = 5.0, 5.6, 3.0
    return pieces(1.0, *torques)


TORQUES = pieces(0.1, 5.0, 3.0, 5.0, 2.5, 4.0, 5.5, 4.5, 2.2, 5.0, 4.0)
STEEPENING = ELLIPSES | {
    f"cam{i}.ellipse_{name}": value
    for i in (1, 2)
    for name, value in (("a", 0.08), ("b", 0.08), ("curvature", 1))
}
SLOW = {"initial.theta": 0.6, "inertia.shaft": 0.005}
STIFF = {
    **STEEPENING,
    **CUBIC,
    "initial.theta": 0.6,
    "inertia.shaft": 2e-6,
    **dict.fromkeys(("damper.c_load", "damper.c_release"), 2000.0),
    **dict.fromkeys(("damper.q_load", "damper.q_release"), 500.0),
}
SCENES = [
    Scene(
        "helices, stick-slip",
        "helical grooves, J = 0.005 kg.m2, ten torques of 0.1 s: slips both ways, turns, sticks",
        SLOW,
        TORQUES,
    ),
    Scene(
        "ellipses, all forces",
        "elliptical grooves, cubic spring, quadratic damper, masses, shaft damping; ten torques of 0.1 s",
        {**STEEPENING, **FORCES, **SLOW},
        pieces(0.1, 8.0, 4.0, 8.0, 3.0, 6.0, 9.0, 6.0, 3.0, 8.0, 5.0),
    ),
    Scene(
        "stiff",
        "elliptical grooves, cubic spring, J = 2e-6 kg.m2, damper 2000 N.s/m: time constants 1e-5 and 0.03 s",
        STIFF,
        pieces(0.1, 8.0, 3.0),
    ),
    Scene(
        "long hold",
        "helical grooves, 100 s: a new torque inside the stick band every second, three moves",
        {"initial.theta": 0.6},
        quiet_hold(),
    ),
]
