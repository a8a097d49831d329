"""Groove laws z = g(psi): helix, ellipse, cycloid, and the choice among all profiles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from .parameters import CAM, DEFAULTS, Params
from .table import Table, read_table

HELIX, ELLIPSE, TABLE, CYCLOID = 1, 2, 3, 4


class Groove(Protocol):
    """z = g(psi), g(0) = 0, as smooth pieces between knots."""

    @property
    def knots(self) -> Sequence[float]: ...

    range: tuple[float, float]  # limits of psi, between which g' >= 0

    def derivatives(self, psi: float, piece: int) -> tuple[float, float, float]:
        """g, g', g'' at psi on a piece, whose formula also serves beyond the ends of the piece."""
        ...


class Helix:
    """g = a psi."""

    knots: Sequence[float] = ()
    range = (-math.inf, math.inf)

    def __init__(self, a: float) -> None:
        self.a = a

    def derivatives(self, psi: float, piece: int) -> tuple[float, float, float]:
        return self.a * psi, self.a, 0.0


class Ellipse:
    """z = kappa b (sqrt(1 - S0^2) - sqrt(1 - S^2)), S = S0 + kappa r psi/a; the difference of the roots is
    (S^2 - S0^2)/(their sum). g' = r (b/a) S/sqrt(1 - S^2), g'' = kappa (r/a)^2 b/(1 - S^2)^(3/2)."""

    knots: Sequence[float] = ()

    def __init__(self, r: float, lead: float, a: float, b: float, kappa: int) -> None:
        steep = a / b * math.tan(lead)
        self.s0 = steep / math.hypot(1.0, steep)
        self.c0 = 1.0 / math.hypot(1.0, steep)
        self.ratio, self.kappa, self.b = r / a, kappa, b
        ends = [(s - self.s0) / (kappa * self.ratio) for s in (0.0, 1.0)]
        self.range = min(ends), max(ends)

    def derivatives(self, psi: float, piece: int) -> tuple[float, float, float]:
        ds = self.ratio * psi
        s = self.s0 + self.kappa * ds
        square = (1.0 - s) * (1.0 + s)
        if square <= 0.0:
            return math.nan, math.nan, math.nan
        c = math.sqrt(square)
        scale = self.ratio * self.b / c
        return (
            self.b * ds * (s + self.s0) / (self.c0 + c),
            scale * s,
            self.kappa * self.ratio * scale / square,
        )


class Cycloid:
    """z = H (psi/B - sin(2 pi psi/B)/(2 pi)), g' = 2 H/B sin^2(pi psi/B), g'' its derivative."""

    knots: Sequence[float] = ()

    def __init__(self, rise: float, angle: float) -> None:
        self.rise, self.angle, self.range = rise, angle, (0.0, angle)

    def derivatives(self, psi: float, piece: int) -> tuple[float, float, float]:
        turn, rate = 2.0 * math.pi * psi / self.angle, self.rise / self.angle
        return (
            self.rise * (psi / self.angle - math.sin(turn) / (2.0 * math.pi)),
            2.0 * rate * math.sin(turn / 2.0) ** 2,
            2.0 * math.pi / self.angle * rate * math.sin(turn),
        )


def groove_of(params: Params, i: int) -> Groove:
    p = {name: params.get(f"cam{i}.{name}", DEFAULTS[f"cam{i}.{name}"]) for name in CAM}
    if p["profile"] == HELIX:
        return Helix(p["radius"] * math.tan(p["lead_angle"]))
    if p["profile"] == ELLIPSE:
        curvature = int(p["ellipse_curvature"])
        return Ellipse(p["radius"], p["lead_angle"], p["ellipse_a"], p["ellipse_b"], curvature)
    if p["profile"] == CYCLOID:
        return Cycloid(p["cycloid_rise"], p["cycloid_angle"])
    return Table(*read_table(p["table"]))
