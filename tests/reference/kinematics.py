"""z, gamma and their derivatives by theta, for one pair of grooves."""

from __future__ import annotations

import math
from bisect import bisect_right
from itertools import pairwise
from typing import NamedTuple

from .arithmetic import Number
from .grooves import Ellipse, Groove
from .parameters import Refused


class Kinematics(NamedTuple):
    """Section 2 of docs/mechanism.md at one theta: a_i = g_i', a prime is d/dtheta."""

    a1: Number
    a2: Number
    gamma: Number
    dgamma: Number
    ddgamma: Number
    z: Number
    dz: Number
    ddz: Number
    da1: Number = 0
    da2: Number = 0


class Helices:
    """Two plain helices: everything is linear in theta."""

    def __init__(self, a1: Number, a2: Number) -> None:
        self.a1, self.a2 = a1, a2
        self.dgamma, self.dz = a2 / (a1 + a2), a1 * a2 / (a1 + a2)

    def at(self, theta: Number, piece: int | None = None) -> Kinematics:
        dgamma, dz = self.dgamma, self.dz
        return Kinematics(self.a1, self.a2, dgamma * theta, dgamma, 0, dz * theta, dz, 0)

    def ahead(self, theta: Number, sigma: int) -> tuple[int, Number | None]:
        """The smooth piece that motion in direction sigma from theta is on, and where it ends."""
        return 0, None


class Grooves:
    """Any two grooves: gamma is the root of g1(gamma) = g2(theta - gamma), to rounding.

    Between the angles where either pin passes a knot everything is smooth: `breaks` holds these, and each
    piece between them one piece of either groove and, on a grid, gamma and its slope as a first guess."""

    cells = 12  # grid cells per piece; more of them for grooves without knots
    margin = 1e-12  # rad, breaks at a smaller distance count as one

    def __init__(self, first: Groove, second: Groove, lower: float, upper: float) -> None:
        self.first, self.second, self.lower, self.upper = first, second, lower, upper
        ends = [self._solve(theta) for theta in (lower, upper)]
        for groove, psi in ((first, ends), (second, [lower - ends[0], upper - ends[1]])):
            if not (groove.range[0] <= psi[0] and psi[1] <= groove.range[1]):
                raise Refused("a groove is left inside the stops")
        used = [(ends[0], ends[1]), (lower - ends[0], upper - ends[1])]
        breaks = self._passes(first, second, *used) + self._passes(second, first, *used[::-1])
        breaks = sorted(theta for theta in breaks if lower + self.margin < theta < upper - self.margin)
        self.breaks = [b for a, b in pairwise([lower, *breaks]) if b - a > self.margin]
        bounds = [lower, *self.breaks, upper]
        self.pieces: list[tuple[int, int]] = []
        self.grids: list[tuple[float, float, list[float], list[float]]] = []
        for a, b in pairwise(bounds):
            middle = (a + b) / 2
            gamma = self._solve(middle)
            self.pieces.append((self._index(first, gamma), self._index(second, middle - gamma)))
            cells = self.cells if len(bounds) > 4 else 16 * self.cells
            width = (b - a) / cells
            found = [self._at(a, *self.pieces[-1], self._solve(a))]
            for k in range(1, cells + 1):
                guess = found[-1].gamma + width * found[-1].dgamma
                found.append(self._at(a + k * width, *self.pieces[-1], guess))
            self.grids.append((a, width, [k.gamma for k in found], [k.dgamma for k in found]))

    @staticmethod
    def _index(groove: Groove, psi: float) -> int:
        return min(max(bisect_right(groove.knots, psi) - 1, 0), max(len(groove.knots) - 2, 0))

    @classmethod
    def _value(cls, groove: Groove, psi: float) -> float:
        """g, continued with slope 1 beyond its range, so that g1(gamma) = g2(phi) always has one root."""
        inside = min(max(psi, groove.range[0]), groove.range[1])
        if isinstance(groove, Ellipse):  # at the end of its range the slope is infinite
            low, high = groove.range
            inside = min(max(inside, low + 1e-13 * (high - low)), high - 1e-13 * (high - low))
        return groove.derivatives(inside, cls._index(groove, inside))[0] + (psi - inside)

    def _solve(self, theta: float) -> float:
        """gamma by bisection alone, between 0 and theta, to the last bit."""
        low, high = min(0.0, theta), max(0.0, theta)
        while True:
            middle = (low + high) / 2
            if not low < middle < high:
                return middle
            if self._value(self.first, middle) < self._value(self.second, theta - middle):
                low = middle
            else:
                high = middle

    @classmethod
    def _passes(
        cls, groove: Groove, other: Groove, used: tuple[float, float], others: tuple[float, float]
    ) -> list[float]:
        """theta at which the pin passes the knots of `groove`; one such theta if `other` has a dwell
        there."""
        found = []
        for psi in groove.knots:
            if not used[0] <= psi <= used[1]:
                continue
            z = cls._value(groove, psi)
            low, high = others
            while True:
                middle = (low + high) / 2
                if not low < middle < high:
                    break
                low, high = (middle, high) if cls._value(other, middle) < z else (low, middle)
            found.append(psi + middle)
        return found

    def ahead(self, theta: float, sigma: int) -> tuple[int, float | None]:
        """The smooth piece that motion in direction sigma from theta is on, and where it ends."""
        if sigma > 0:
            piece = bisect_right(self.breaks, theta + self.margin / 2)
            return piece, self.breaks[piece] if piece < len(self.breaks) else None
        piece = bisect_right(self.breaks, theta - self.margin / 2)
        return piece, self.breaks[piece - 1] if piece > 0 else None

    def at(self, theta: float, piece: int | None = None) -> Kinematics:
        """Kinematics at theta. The formulas of a given piece also serve a little beyond the ends of the
        piece."""
        index = bisect_right(self.breaks, theta) if piece is None else piece
        start, width, gammas, slopes = self.grids[index]
        place = (theta - start) / width
        last = len(gammas) - 2
        if not -2 < place < last + 3:  # only a trial step of the integrator leads so far out
            if piece is not None:
                return self.at(theta)
            return self._at(theta, *self.pieces[index], self._solve(theta) if place == place else theta)
        cell = min(max(int(place), 0), last)
        t = place - cell
        g, h, d, e = gammas[cell], gammas[cell + 1], width * slopes[cell], width * slopes[cell + 1]
        guess = g + t * (d + t * (3 * (h - g) - 2 * d - e + t * (2 * (g - h) + d + e)))
        return self._at(theta, *self.pieces[index], guess)

    def _at(self, theta: float, i: int, j: int, gamma: float) -> Kinematics:
        """Kinematics on one piece of either groove, by Newton's method from a guess of gamma."""
        first, second = self.first.derivatives, self.second.derivatives
        for _ in range(12):
            z, a1, b1 = first(gamma, i)
            other, a2, b2 = second(theta - gamma, j)
            total = a1 + a2
            if not total > 0:
                return Kinematics(*[math.nan] * 10)
            step = (other - z) / total
            if abs(step) <= 1e-15 * (abs(theta) + abs(z) / total):
                break
            gamma += step
        dgamma, dphi = a2 / total, a1 / total
        bend1, bend2 = b1 * dgamma * dgamma, b2 * dphi * dphi
        return Kinematics(
            a1,
            a2,
            gamma,
            dgamma,
            (bend2 - bend1) / total,
            z,
            a1 * dgamma,
            (a2 * bend1 + a1 * bend2) / total,
            b1 * dgamma,
            b2 * dphi,
        )
