"""Friction that varies with sliding speed and load: torque and reactions of steady slow turning.

The law is that of docs/mechanism.md, section 9, with the exponent nu of the load:

    mu_i(v, R) = mu_k [1 + (peak - 1) exp(-(v/v_s)^delta)] (R/R_ref)^nu + mu_v v

R_i, the reaction of one contact, stands on both sides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from case_studies.paper.cams import Statics
from case_studies.paper.published import CONTACTS, RELEASING
from dualcam.design.statics import Array

Number = float | Array
STEPS = 15  # of Newton's method, at most
SETTLED = 1e-13  # relative change of the reactions: the last step
LEAST = 0.1  # of a reaction, after one step


@dataclass(frozen=True)
class FrictionLaw:
    """mu(v, R) of one contact. All values may be arrays that broadcast with the angles."""

    kinetic: Number
    peak: Number = 1.0  # static over kinetic coefficient
    stribeck_velocity: float = 0.01  # m/s
    stribeck_exponent: int = 2
    viscous: Number = 0.0  # s/m
    load_exponent: Number = 0.0
    load: float = 100.0  # N, of one contact

    def at(self, speed: Array, reaction: Array) -> Array:
        """The coefficient at sliding speeds [m/s] and reactions of one contact [N]."""
        fall = np.exp(-((speed / self.stribeck_velocity) ** self.stribeck_exponent))
        pressed = (np.abs(reaction) / self.load) ** self.load_exponent
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
    """Steady turning of the cam at `speed` [rad/s]; 0: the edge of the stick band, at mu(0+, R).

    Newton's method for both reactions R_i of one contact, with s_i = tan(lead angle), h_i = hypot(1, s_i),
    sigma the direction:

        r_1 R_1 (s_1 + sigma mu_1)/h_1 = r_2 R_2 (s_2 + sigma mu_2)/h_2
        R_1 (1 - sigma mu_1 s_1)/h_1 + R_2 (1 - sigma mu_2 s_2)/h_2 = F/n

    The torque is nan where a contact locks: where R (s - mu(R)) does not grow with R when releasing, or where
    no positive reactions solve the equations.
    """
    (r1, r2), (s1, s2) = statics.radii, statics.slopes
    h1, h2 = np.hypot(1.0, s1), np.hypot(1.0, s2)
    sliding = statics.sliding(speed)
    guess = [law.at(v, np.full_like(v, law.load)) for v in sliding]
    first, second = (np.abs(reaction) for reaction in statics.reactions(direction, *guess))
    with np.errstate(all="ignore"):  # what does not settle is nan below
        for _ in range(STEPS):
            mu1, mu2 = (law.at(v, r) * direction for v, r in zip(sliding, (first, second), strict=True))
            grown1, grown2 = (
                mu + law.load_exponent * (mu - direction * law.viscous * v)
                for mu, v in zip((mu1, mu2), sliding, strict=True)
            )  # d(R mu)/dR
            moment = r1 * first * (s1 + mu1) / h1 - r2 * second * (s2 + mu2) / h2
            axial = first * (1 - mu1 * s1) / h1 + second * (1 - mu2 * s2) / h2 - statics.spring / CONTACTS
            m1, m2 = r1 * (s1 + grown1) / h1, -r2 * (s2 + grown2) / h2
            a1, a2 = (1 - grown1 * s1) / h1, (1 - grown2 * s2) / h2
            determinant = m1 * a2 - m2 * a1
            step1, step2 = (moment * a2 - axial * m2) / determinant, (axial * m1 - moment * a1) / determinant
            change = np.maximum(np.abs(step1 / first), np.abs(step2 / second))
            first, second = (
                np.maximum(first - step1, LEAST * first),
                np.maximum(second - step2, LEAST * second),
            )
            if np.nanmax(change) < SETTLED:
                break
        mu1, mu2 = (law.at(v, r) for v, r in zip(sliding, (first, second), strict=True))
        torque = CONTACTS * r2 * second * (s2 + direction * mu2) / h2
        sound = (change < SETTLED) & (torque > 0.0)
        if direction == RELEASING:
            for slope, mu, v in ((s1, mu1, sliding[0]), (s2, mu2, sliding[1])):
                sound = sound & (slope > mu + law.load_exponent * (mu - law.viscous * v))
    return Turning(np.where(sound, torque, math.nan), (first, second), (mu1, mu2), sliding)
