"""The scenes: flywheel, shaft, motor and cam. The masters and their steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

STEPS = (0.5e-3, 1e-3, 2e-3, 4e-3, 8e-3)  # s
STEP = 4e-3  # s, of the claim
FITTED = STEPS[:4]  # the order of convergence is fitted to these
GRID = STEPS[0]  # s, where the truth is known
DURATION = 1.2  # s

# The start values of the FMU, but for the heavier shaft and the follower's masses.
CAM = {
    "cam1.radius": 0.02,
    "cam2.radius": 0.02,
    "cam1.lead_angle": math.pi / 4.0,
    "cam2.lead_angle": math.pi / 4.0,
    "cam1.friction": 0.14,
    "cam2.friction": 0.14,
    "spring.preload": 50.0,
    "spring.stiffness": 50e3,
    "inertia.shaft": 0.005,
    "inertia.follower_mass": 0.3,
    "inertia.follower": 3e-5,
}
STOPS = (0.0, 1.3963)  # rad; no scene reaches them


@dataclass(frozen=True)
class Scene:
    """Flywheel, shaft and motor. Both begin at rest, `twist` apart."""

    name: str
    description: str
    amplitude: float  # A, N.m
    frequency: float  # f, Hz
    twist: float  # phi - theta at the start, rad
    damping: float = 0.0  # D, N.m.s/rad
    stiffness: float = 15.0  # K, N.m/rad
    inertia: float = 0.01  # I, kg.m2
    bearing: float = 0.02  # d, N.m.s/rad
    mean: float = 5.0  # A0, N.m
    angle: float = 0.7  # theta at the start, rad

    def motor(self, t: float) -> float:
        return self.mean + self.amplitude * math.sin(2.0 * math.pi * self.frequency * t)


SCENES = (
    Scene(
        "reversals",
        "motor 5 + 5 sin(2 pi 8 t) N.m: the cam slips to and fro and turns round without rest",
        amplitude=5.0,
        frequency=8.0,
        twist=0.4,
    ),
    Scene(
        "stick and slip",
        "motor 5 + 2 sin(2 pi 5 t) N.m: the cam sticks at each upper turn",
        amplitude=2.0,
        frequency=5.0,
        twist=1.0 / 3.0,
    ),
    Scene(
        "damped shaft",
        "as stick and slip, with a damper of 0.05 N.m.s/rad beside the torsion spring",
        amplitude=2.0,
        frequency=5.0,
        twist=1.0 / 3.0,
        damping=0.05,
    ),
)


@dataclass(frozen=True)
class Master:
    order: int  # highest derivative that is passed on
    in_turn: bool = False  # Gauss-Seidel rather than Jacobi

    @property
    def name(self) -> str:
        return ("held", "first order", "second order")[self.order]

    @property
    def scheme(self) -> str:
        return "in turn" if self.in_turn else "at once"


MASTERS = tuple(Master(order, in_turn) for in_turn in (False, True) for order in range(3))
