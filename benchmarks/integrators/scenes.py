"""The scenes of the candidate integrators: smooth motion in elliptical grooves, from gentle to very stiff."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from benchmarks.integrators.structs import EllipseStruct, SceneStruct


def ellipse(radius: float, lead: float, a: float, b: float, curvature: int) -> EllipseStruct:
    start = math.sin(math.atan(a / b * math.tan(lead)))
    return EllipseStruct(start, curvature * radius / a, radius * b / a, curvature * b)


@dataclass
class Scene:
    name: str
    description: str
    parameters: dict[str, float]
    span: float
    stiff: bool = False
    parts: int = 1
    struct: SceneStruct = field(default_factory=SceneStruct)

    def __post_init__(self) -> None:
        r1, r2 = 0.03, 0.025
        given = {"r1": r1, "r2": r2, "mu1": 0.14, "mu2": 0.14, "span": self.span, "parts": self.parts}
        for name, value in {**given, **self.parameters}.items():
            setattr(self.struct, name, value)
        self.struct.groove1 = ellipse(r1, 0.70, 0.15, 0.15, 1)
        self.struct.groove2 = ellipse(r2, 0.85, 0.12, 0.12, -1)


SWING = {"inertia": 0.002, "preload": 100.0, "k": 50000.0, "tau0": 10.0}
FULL = {"mass": 0.3, "spin": 3e-5, "k2": 1e6, "k3": 1e8, "c": 50.0, "q": 20.0, "b": 0.005, "tau1": 50.0}
GENTLE = {"inertia": 0.002, "preload": 10.0, "k": 50.0, "tau0": 0.19, "theta": 0.2, "omega": 1.0, "c": 0.5}
STIFF = {"preload": 20.0, "k": 1000.0, "c": 400.0, "q": 1000.0, "tau0": 0.8, "tau1": 0.3}
RIGID = {"inertia": 0.002, "preload": 100.0, "k": 5e7, "c": 8e4, "tau0": 2.0, "tau1": 1000.0}


def scenes() -> list[Scene]:
    return [
        Scene("1 swing", "elliptical grooves, linear spring, 30 ms swing", SWING, 0.03),
        Scene("2 swing, full", "the same with all nonlinearities and masses", SWING | FULL, 0.03),
        Scene("3 gentle, 1 ms", "slow motion, 1 ms steps", GENTLE, 0.2, parts=200),
        Scene("3b swing, 1 ms", "scene 1 in 1 ms steps", SWING, 0.03, parts=30),
        Scene("3c full, 1 ms", "scene 2 in 1 ms steps", SWING | FULL, 0.03, parts=30),
        Scene("4 stiff", "fast time constant 1e-6 s, from rest", STIFF | {"inertia": 1e-7}, 0.3, True),
        Scene("4b stiff, 1 ms", "scene 4 in 1 ms steps", STIFF | {"inertia": 1e-7}, 0.3, True, 300),
        Scene("5 very stiff", "fast time constant 1e-9 s, from rest", STIFF | {"inertia": 1e-10}, 0.3, True),
        Scene("5b very stiff, 1 ms", "scene 5 in 1 ms steps", STIFF | {"inertia": 1e-10}, 0.3, True, 300),
        Scene("6 near-rigid", "stiff spring, damping ratio 2, from rest", RIGID, 0.1, True),
        Scene("6b near-rigid, 1 ms", "scene 6 in 1 ms steps", RIGID, 0.1, True, 100),
    ]
