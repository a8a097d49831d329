"""Impedance control: the motor acts like a spring and a damper between a joint and its reference motion."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Impedance:
    """A virtual spring and damper between a joint and its reference motion."""

    stiffness: float  # N.m/rad
    damping: float  # N.m.s/rad

    @classmethod
    def tuned(cls, inertia: float, frequency: float, damping_ratio: float) -> Impedance:
        """The impedance on which `inertia` [kg.m2] has this natural frequency [Hz] and damping ratio."""
        rate = 2.0 * math.pi * frequency
        return cls(rate**2 * inertia, 2.0 * damping_ratio * rate * inertia)

    def torque(self, error: float, rate: float) -> float:
        """Torque [N.m] for an error of the angle [rad] and of the speed [rad/s], both actual minus wanted."""
        return -self.stiffness * error - self.damping * rate
