"""Inputs over one interval, and the quantities of the interface at its end."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from .arithmetic import Number, Polynomial


@dataclass(frozen=True)
class Interval:
    """Inputs over `duration` seconds: u(t) = sum of u_k t^k/k!, with u_k the value and the derivatives at
    the start."""

    duration: float
    tau: float
    tau_rate: float = 0.0
    F_ext: float = 0.0
    F_ext_rate: float = 0.0
    tau_rate2: float = 0.0
    tau_rate3: float = 0.0
    F_ext_rate2: float = 0.0
    F_ext_rate3: float = 0.0

    def coefficients(self, name: str, number: Callable[[Any], Number] = float) -> Polynomial:
        """Coefficients of input `name` in t; trailing zeros beyond the linear term left out."""
        u = [number(getattr(self, name + order)) for order in ("", "_rate", "_rate2", "_rate3")]
        u[2], u[3] = u[2] / 2, u[3] / 6
        while len(u) > 2 and u[-1] == 0:
            u.pop()
        return tuple(u)

    def at(self, name: str, t: float) -> list[float]:
        """Value and three derivatives of input `name` at time t of the interval."""
        u = [getattr(self, name + order) for order in ("", "_rate", "_rate2", "_rate3")]
        return [
            math.fsum(u[k + j] * t**j / math.factorial(j) for j in range(4 - k)) for k in range(4)
        ]  # fmt: skip


@dataclass
class Point:
    """Values that an FMU must report at the end of an interval."""

    theta: float
    omega: float
    z: float
    v: float
    mode: int
    events: int
    energy: dict[str, float]
    peak: dict[str, float]
    doubts: list[str] = field(default_factory=list)  # decisions of this interval that depend on rounding

    def value(self, name: str) -> float:
        """The value of an interface variable, by its name."""
        group, _, entry = name.partition(".")
        if group == "energy":
            return self.energy[entry]
        if group == "peak":
            return self.peak[entry]
        return getattr(self, name)
