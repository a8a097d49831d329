"""Friction that depends on the sliding speed and on the reaction (docs/mechanism.md, section 9)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq, fsolve

from .parameters import Refused

LEAST_LOAD = 1e-9  # of R_ref: below this reaction the coefficient is constant


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
    def of_cam(cls, p: Mapping[str, Any], i: int) -> FrictionLaw:
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
            dry *= max(abs(reaction) / self.load, LEAST_LOAD) ** self.load_exponent
        return dry + self.viscous * v

    def tangent(self, v: Any, reaction: Any) -> Any:
        """d(mu R)/dR"""
        lubricated = self.viscous * v
        return (1 + self.load_exponent) * (self.at(v, reaction) - lubricated) + lubricated


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
