"""Friction that varies with sliding speed and load: torque and reactions of steady slow turning.

The law is that of docs/mechanism.md, section 9, over the nominal load N of one contact:

    mu_i(v, N) = mu_k [1 + (peak - 1) exp(-(v/v_s)^delta)] ((N^2 + (N_ref/10)^2)/N_ref^2)^(nu/2) + mu_v v
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from case_studies.paper.cams import Statics
from dualcam.design.load_law import LoadPower
from dualcam.design.statics import Array

Number = float | Array


@dataclass(frozen=True)
class FrictionLaw:
    """mu(v, N) of one contact. All values may be arrays that broadcast with the angles."""

    kinetic: Number
    peak: Number = 1.0  # static over kinetic coefficient
    stribeck_velocity: float = 0.01  # m/s
    stribeck_exponent: int = 2
    viscous: Number = 0.0  # s/m
    load_exponent: Number = 0.0
    load: float = 100.0  # N, of one contact

    def at(self, speed: Array, load: Array) -> Array:
        """The coefficient at sliding speeds [m/s] and nominal loads of one contact [N]."""
        fall = np.exp(-((speed / self.stribeck_velocity) ** self.stribeck_exponent))
        pressed = LoadPower(self.load_exponent, self.load).factor(load)
        return self.kinetic * (1.0 + (self.peak - 1.0) * fall) * pressed + self.viscous * speed

    def parameters(self) -> dict[str, float | int]:
        """Start values of the FMU, the same for both cams."""
        own = {
            "friction": self.kinetic,
            "friction_peak": self.peak,
            "stribeck_velocity": self.stribeck_velocity,
            "stribeck_exponent": self.stribeck_exponent,
            "friction_viscous": self.viscous,
            "friction_load_exponent": self.load_exponent,
            "friction_load": self.load,
        }
        return {f"cam{i}.{name}": value for i in (1, 2) for name, value in own.items()}  # type: ignore[misc]


@dataclass(frozen=True)
class Turning:
    """Steady turning in one direction; arrays over the angles, or over more axes before them."""

    torque: Array  # N.m; nan where a contact locks
    reactions: tuple[Array, Array]  # N, of one contact
    friction: tuple[Array, Array]  # mu of both contacts
    sliding: tuple[Array, Array]  # m/s


def turning(statics: Statics, law: FrictionLaw, direction: int, speed: float = 0.0) -> Turning:
    """Steady turning of the cam at `speed` [rad/s]; 0: the edge of the stick band, at mu(0+, N)."""
    sliding = statics.sliding(speed)
    mu1, mu2 = (law.at(v, load) for v, load in zip(sliding, statics.nominal_loads(), strict=True))
    first, second = statics.reactions(direction, mu1, mu2)
    torque = statics.torque(direction, mu1, mu2)
    sound = (torque > 0.0) & (first > 0.0) & (second > 0.0)
    return Turning(np.where(sound, torque, math.nan), (first, second), (mu1, mu2), sliding)
