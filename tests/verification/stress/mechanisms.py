"""Parameters of the scenes: grooves, springs, dampers, tables, and the sizes of a mechanism."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.oracles import Interval, reference
from verification.stress.scene import Params

DECADES_OF_ANGLE = [1e-6, 1e-4, 1e-2, 0.2, 0.8, 1.3]
LEADS = [*DECADES_OF_ANGLE, *(math.pi / 2 - x for x in (1e-2, 1e-4, 1e-6))]


def ellipses(**more: float) -> Params:
    given = {
        1: {"radius": 0.03, "lead_angle": 0.70, "ellipse_a": 0.15, "ellipse_b": 0.15, "ellipse_curvature": 1},
        2: {
            "radius": 0.025,
            "lead_angle": 0.85,
            "ellipse_a": 0.12,
            "ellipse_b": 0.12,
            "ellipse_curvature": -1,
        },
    }
    made: Params = {f"cam{i}.{name}": v for i, cam in given.items() for name, v in cam.items()}
    return made | {"cam1.profile": 2, "cam2.profile": 2} | more


def helices(lead1: float = 0.75, lead2: float = 0.85) -> Params:
    return {
        "cam1.radius": 0.03,
        "cam2.radius": 0.025,
        "cam1.lead_angle": lead1,
        "cam2.lead_angle": lead2,
    }


def spring(k: float, reach: float, preload: float = 0.2, nonlinear: bool = True) -> Params:
    """Preload and nonlinear terms in units of the force of k at the travel `reach` [m]."""
    made = {"spring.stiffness": k, "spring.preload": preload * k * reach}
    terms = {"spring.stiffness2": 0.3 * k / reach, "spring.stiffness3": 0.2 * k / reach**2}
    return made | (terms if nonlinear else {})


def damper(c: float = 0.0, q: float = 0.0) -> Params:
    return {f"damper.{kind}_{side}": v for kind, v in (("c", c), ("q", q)) for side in ("load", "release")}


@dataclass(frozen=True)
class Sizes:
    """Torque that loads, stiffness and inertia at the shaft of cam 2, at an angle theta [rad]."""

    mechanism: Any

    @classmethod
    def of(cls, params: Params) -> Sizes:
        return cls(reference.Mechanism({n: v for n, v in params.items() if n != "ledger"}, reference.DOUBLE))

    def torque(self, theta: float, f_ext: float = 0.0) -> float:
        kin = self.mechanism.groove.at(theta)
        ratio = self.mechanism.static_ratio(kin, +1)
        if ratio is None:
            ratio = kin.dz
        return ratio * (self.mechanism.spring_force(kin.z) + f_ext)

    def dz_dtheta(self, theta: float = 0.7) -> float:
        return float(self.mechanism.groove.at(theta).dz)

    def stiffness(self, theta: float = 0.7) -> float:
        kin = self.mechanism.groove.at(theta)
        return float(abs(self.mechanism.spring_slope(kin.z)) * kin.dz**2)

    def inertia(self, theta: float = 0.7) -> float:
        m, kin = self.mechanism, self.mechanism.groove.at(theta)
        return float(m.J + m.m * kin.dz**2 + m.I * kin.dgamma**2)

    def period(self) -> float:
        return 2.0 * math.pi * math.sqrt(self.inertia() / self.stiffness())


def up_and_back(torque: float, duration: float) -> list[Interval]:
    """Loads, holds, lets go, pulls back, and loads along a ramp."""
    return [
        Interval(duration, torque),
        Interval(0.5 * duration, 0.4 * torque),
        Interval(0.7 * duration, -0.2 * torque),
        Interval(duration, 0.0, 1.5 * torque / duration),
    ]


class Tables:
    """Writes groove tables into a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.count = folder, 0

    def write(self, psi: Iterable[float], z: Iterable[float]) -> str:
        path = self.folder / f"{self.count}.csv"
        self.count += 1
        reference.write_table(path, psi, z)
        return str(path)

    def write_law(self, speeds: np.ndarray, loads: np.ndarray, mu: np.ndarray) -> str:
        """A friction table; `mu`: by load and speed."""
        path = self.folder / f"{self.count}.csv"
        self.count += 1
        rows = [
            f"{float(v)!r},{float(load)!r},{float(m)!r}"
            for load, row in zip(loads, mu, strict=True)
            for v, m in zip(speeds, row, strict=True)
        ]
        path.write_text("\n".join(["v_m_s,R_N,mu", *rows, ""]))
        return str(path)

    def helix(self, radius: float, lead: float, lower: float, upper: float, count: int = 9) -> str:
        psi = np.linspace(min(lower, 0.0) - 0.1, upper + 0.1, count)
        return self.write(psi, radius * math.tan(lead) * psi)

    def dwell(self, radius: float, first: float, last: float, lead: float = 0.7) -> str:
        """Steep on both sides of a flat part from first to last, with rounded ends."""
        psi = np.linspace(-0.6, 2.0, 66)
        x = np.linspace(-0.6, 2.0, 65 * 40 + 1)
        outside = np.maximum(np.maximum(first - x, x - last), 0.0) / 0.15
        slope = radius * math.tan(lead) * -np.expm1(-(outside**2))
        rise = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(x))])
        return self.write(psi, rise[::40])
