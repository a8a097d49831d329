"""Friction that depends on the sliding speed and on the nominal load (docs/mechanism.md, section 9)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import BPoly, CubicSpline

LOW = 0.1  # of N_ref: keeps mu finite without load


@dataclass(frozen=True)
class FrictionLaw:
    """mu(v, N) of one contact."""

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
        """Does mu depend on the nominal load?"""
        return bool(self.kinetic * self.load_exponent != 0)

    @property
    def static(self) -> Any:
        """The static coefficient of a law that does not depend on the load."""
        return self.kinetic * self.peak

    def at(self, v: Any, load: Any = None) -> Any:
        """mu at the sliding speed v and the nominal load of one contact; None: without the factor of the
        load. A trial step of the integrator may ask for a small negative speed."""
        if not self.varies and not self.is_loaded:
            return self.kinetic
        ratio = max(v / self.stribeck_velocity, -2.0)
        fall = math.exp(-(ratio**self.stribeck_exponent))
        dry = self.kinetic * (1 + (self.peak - 1) * fall)
        if self.is_loaded and load is not None:
            dry *= ((load / self.load) ** 2 + LOW**2) ** (self.load_exponent / 2)
        return dry + self.viscous * v


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

    def at(self, v: Any, load: Any = None) -> Any:
        if v >= self.end:
            return self.last
        return float(np.exp(self.curve(max(v, 0.0))))


class LoadedTableLaw:
    """mu(v, N) through samples: at each load a TableLaw; over ln N the cubic spline of ln mu with slope zero
    at both ends. Beyond the loads mu stays at the last value."""

    varies, is_loaded, peak, stribeck_velocity = True, True, 1.0, 1.0

    def __init__(self, loads: np.ndarray, by_load: list[TableLaw]) -> None:
        self.loads, self.by_load = loads, by_load
        middle = by_load[len(loads) // 2]
        self.static, self.kinetic, self.viscous = middle.static, middle.kinetic, middle.viscous
        # The spline is linear in its values: these go through 1 at one load and through 0 elsewhere.
        self.cardinal = CubicSpline(np.log(loads), np.eye(len(loads)), bc_type="clamped")

    def at(self, v: Any, load: Any = None) -> Any:
        if load is None:
            return self.by_load[len(self.loads) // 2].at(v)
        inside = min(max(load, self.loads[0]), self.loads[-1])
        return math.exp(float(self.cardinal(math.log(inside)) @ np.log([law.at(v) for law in self.by_load])))
