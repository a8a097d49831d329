"""Friction that depends on the sliding speed and on the reaction (docs/mechanism.md, section 9)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import BPoly, CubicSpline
from scipy.optimize import brentq, fsolve

from .parameters import Refused

LEVEL = 0.01  # of R_ref: below this reaction the coefficient levels off


def log_load(share: float) -> float:
    """ln(R/R_ref), levelled off below LEVEL: four terms of the series of ln(share^2)/2 about LEVEL^2."""
    if share >= LEVEL:
        return math.log(share)
    below = 1 - (share / LEVEL) ** 2
    return math.log(LEVEL) - sum(below**k / k for k in range(1, 5)) / 2


def log_load_power(share: float) -> float:
    """d log_load/d ln share: the part of nu that acts."""
    return 1.0 if share >= LEVEL else 1 - (1 - (share / LEVEL) ** 2) ** 4


@dataclass(frozen=True)
class FrictionLaw:
    """mu(v, R) of one contact."""

    kinetic: Any
    peak: Any
    stribeck_velocity: Any
    stribeck_exponent: int
    viscous: Any
    load_exponent: Any = 0.0
    load: Any = 100.0

    @classmethod
    def of_cam(cls, p: Mapping[str, Any], i: int) -> FrictionLaw | TableLaw:
        if p[f"cam{i}.friction_table"]:
            return TableLaw.read(p[f"cam{i}.friction_table"])
        names = (
            "friction",
            "friction_peak",
            "stribeck_velocity",
            "stribeck_exponent",
            "friction_viscous",
            "friction_load_exponent",
            "friction_load",
        )
        kinetic, peak, velocity, exponent, viscous, load_exponent, load = (p[f"cam{i}.{n}"] for n in names)
        return cls(kinetic, peak, velocity, int(exponent), viscous, load_exponent, load)

    @property
    def varies(self) -> bool:
        """Does mu depend on the sliding speed?"""
        return bool(self.kinetic * (self.peak - 1) != 0 or self.viscous != 0)

    @property
    def is_loaded(self) -> bool:
        """Does mu depend on the reaction?"""
        return bool(self.kinetic * self.load_exponent != 0)

    @property
    def static(self) -> Any:
        """mu(0+, R_ref)"""
        return self.kinetic * self.peak

    def at(self, v: Any, reaction: Any = None) -> Any:
        """mu at the sliding speed v and the reaction of one contact. A trial step of the integrator may
        ask for a small negative speed."""
        if not self.varies and not self.is_loaded:
            return self.kinetic
        ratio = max(v / self.stribeck_velocity, -2.0)
        fall = math.exp(-(ratio**self.stribeck_exponent))
        dry = self.kinetic * (1 + (self.peak - 1) * fall)
        if self.is_loaded and reaction is not None:
            dry *= math.exp(self.load_exponent * log_load(float(abs(reaction) / self.load)))
        return dry + self.viscous * v

    def tangent(self, v: Any, reaction: Any) -> Any:
        """d(mu R)/dR"""
        lubricated = self.viscous * v
        power = self.load_exponent * log_load_power(abs(reaction) / self.load)
        return (1 + power) * (self.at(v, reaction) - lubricated) + lubricated


class TableLaw:
    """mu(v) through samples: ln mu is a curve of quintic pieces, twice continuously differentiable, which
    rises or falls in each piece as the samples do; mu is constant beyond the last speed.

    Slope d_j and second derivative c_j at sample j start as those of the polynomial through the five nearest
    samples. They are then limited so that in each piece, of width h and mean slope D, the Bernstein
    coefficients of the derivative, d_0, d_0 + c_0 h/4, 5 D - e, d_1 - c_1 h/4 and d_1, have the sign of D,
    where e = 2 d_0 + c_0 h/4 + 2 d_1 - c_1 h/4."""

    varies, is_loaded, peak, stribeck_velocity = True, False, 1.0, 1.0

    @staticmethod
    def read(path: str | Path) -> TableLaw | LoadedTableLaw:
        rows = np.loadtxt(Path(path), delimiter=",", skiprows=1)
        if rows.shape[1] == 2:
            return TableLaw(*rows.T)
        loads = np.unique(rows[:, 1])
        by_load = [TableLaw(*rows[rows[:, 1] == load][:, [0, 2]].T) for load in loads]
        return LoadedTableLaw(loads, by_load)

    def __init__(self, v: np.ndarray, mu: np.ndarray) -> None:
        y, n = np.log(mu), len(v)
        h, mean = np.diff(v), np.diff(y) / np.diff(v)
        d, c = np.zeros(n), np.zeros(n)
        for j in range(n):
            first = min(max(j - 2, 0), max(n - 5, 0))
            near = slice(first, min(first + 5, n))
            local = np.linalg.solve(np.vander(v[near] - v[j], increasing=True), y[near])
            beside = [mean[k] for k in (j - 1, j) if 0 <= k < n - 1]
            if any(m == 0 for m in beside):
                continue
            rises = np.sign(beside[-1])
            d[j] = rises * max(rises * local[1], 0.0) if all(np.sign(m) == rises for m in beside) else 0.0
            c[j] = 2 * local[2]
            if j < n - 1:
                c[j] = rises * max(rises * c[j], -4 * rises * d[j] / h[j])
            if j > 0:
                rose = np.sign(beside[0])
                c[j] = rose * min(rose * c[j], 4 * rose * d[j] / h[j - 1])
        d[-1] = c[-1] = 0.0
        e = 2 * d[:-1] + c[:-1] * h / 4 + 2 * d[1:] - c[1:] * h / 4
        share = np.array([min(1.0, 5 * m / x) if m * x > 0 else 1.0 for m, x in zip(mean, e, strict=True)])
        share = np.minimum(np.append(share, 1.0), np.insert(share, 0, 1.0))
        self.curve = BPoly.from_derivatives(v, np.column_stack([y, share * d, share * c]))
        self.end, self.static, self.last = float(v[-1]), float(mu[0]), float(mu[-1])
        self.kinetic = self.last
        slopes = self.curve.derivative()(np.linspace(0, self.end, 2001))
        self.viscous = float(np.abs(slopes).max() * mu.max())  # 1/(m/s), for an estimate of rates alone

    def at(self, v: Any, reaction: Any = None) -> Any:
        if v >= self.end:
            return self.last
        return float(np.exp(self.curve(max(v, 0.0))))


class LoadedTableLaw:
    """mu(v, R) through samples: at each load a TableLaw; over ln R the natural cubic spline of ln mu, and
    beyond the loads a power of R."""

    varies, is_loaded, peak, stribeck_velocity = True, True, 1.0, 1.0

    def __init__(self, loads: np.ndarray, by_load: list[TableLaw]) -> None:
        self.loads, self.by_load = loads, by_load
        middle = by_load[len(loads) // 2]
        self.static, self.kinetic, self.viscous = middle.static, middle.kinetic, middle.viscous
        self.x = np.log(loads)
        # The natural spline is linear in its values: these go through 1 at one load and through 0 elsewhere.
        self.cardinal = CubicSpline(self.x, np.eye(len(loads)), bc_type="natural")
        self.speed, self.values = math.nan, np.zeros(len(loads))  # ln mu at each load, of the last speed

    def _at_speed(self, v: float) -> np.ndarray:
        if v != self.speed:
            self.speed, self.values = v, np.log([law.at(v) for law in self.by_load])
        return self.values

    def _log(self, v: Any, reaction: Any) -> tuple[float, float]:
        """ln mu and its derivative by ln R."""
        values, x, share = self._at_speed(v), self.x, reaction / self.loads[0]
        place = x[0] + log_load(share)
        inside = min(max(place, x[0]), x[-1])
        slope = float(self.cardinal(inside, 1) @ values)
        return float(self.cardinal(inside) @ values) + slope * (place - inside), slope * log_load_power(share)

    def at(self, v: Any, reaction: Any = None) -> Any:
        if reaction is None:
            return self.by_load[len(self.loads) // 2].at(v)
        return math.exp(self._log(v, abs(reaction))[0])

    def tangent(self, v: Any, reaction: Any) -> Any:
        """d(mu R)/dR"""
        log_mu, slope = self._log(v, abs(reaction))
        return math.exp(log_mu) * (1 + slope)


# ---- a pin under given loads, from the equations of section 9 ----


@dataclass(frozen=True)
class LoadedContact:
    """One contact: r_i, s_i, the law, the sliding speed, the number of pin ends and e_i sigma."""

    radius: float
    lead: float  # s_i
    law: FrictionLaw
    speed: float
    ends: int
    turn: int  # e_i sigma

    def torque(self, reaction: float) -> float:
        """T_i on the flank e_i = 1"""
        mu = self.law.at(self.speed, reaction)
        h = math.hypot(1.0, self.lead)
        return self.ends * reaction * self.radius * (self.lead + self.turn * mu) / h

    def axial(self, reaction: float) -> float:
        mu = self.law.at(self.speed, reaction)
        return self.ends * reaction * (1 - self.turn * mu * self.lead) / math.hypot(1.0, self.lead)

    def grows(self, reaction: float) -> bool:
        """R (s + e sigma mu(R)) grows with R."""
        return self.lead + self.turn * self.law.tangent(self.speed, reaction) > 0


def reactions_under(contacts: tuple[LoadedContact, LoadedContact], axial: float, moment: float) -> np.ndarray:
    """Both reactions R_i of one contact under the axial load A > 0 and the moment W, on the flanks e_i = 1:
    T_2 - T_1 = W and the axial balance, solved by SciPy. Raises Refused where SciPy finds none."""

    def residual(log_r: np.ndarray) -> list[float]:
        r = np.exp(log_r)
        torque = [c.torque(x) for c, x in zip(contacts, r, strict=True)]
        size = sum(abs(t) for t in torque) + abs(moment)
        carried = sum(c.axial(x) for c, x in zip(contacts, r, strict=True))
        return [(carried - axial) / axial, (torque[1] - torque[0] - moment) / size]

    start = np.log([axial / contacts[0].ends / 2] * 2)
    found, _, _, _ = fsolve(residual, start, xtol=1e-15, full_output=True)
    if max(abs(x) for x in residual(found)) > 1e-11:
        raise Refused("no reactions found")
    return np.exp(found)


def torque_of_symmetric_edge(
    contact: LoadedContact, axial: float, bracket: tuple[float, float] = (1e-12, 1e9)
) -> float:
    """N.m: the edge of the stick band of two equal contacts under F_0 = `axial`, by bisection."""
    carried: Callable[[float], float] = lambda r: 2 * contact.axial(r) - axial  # noqa: E731
    return contact.torque(brentq(carried, *bracket, xtol=1e-300, rtol=1e-15))
