"""Friction that depends on the sliding speed (docs/mechanism.md, section 9)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class FrictionLaw:
    """mu(v) of one contact."""

    kinetic: Any
    peak: Any
    stribeck_velocity: Any
    stribeck_exponent: int
    viscous: Any

    @classmethod
    def of_cam(cls, p: Mapping[str, Any], i: int) -> FrictionLaw:
        names = ("friction", "friction_peak", "stribeck_velocity", "stribeck_exponent", "friction_viscous")
        kinetic, peak, velocity, exponent, viscous = (p[f"cam{i}.{name}"] for name in names)
        return cls(kinetic, peak, velocity, int(exponent), viscous)

    @property
    def varies(self) -> bool:
        return bool(self.kinetic * (self.peak - 1) != 0 or self.viscous != 0)

    @property
    def static(self) -> Any:
        return self.kinetic * self.peak

    def at(self, v: Any) -> Any:
        """mu at the sliding speed v. A trial step of the integrator may ask for a small negative speed."""
        if not self.varies:
            return self.kinetic
        ratio = max(v / self.stribeck_velocity, -2.0)
        fall = math.exp(-(ratio**self.stribeck_exponent))
        return self.kinetic * (1 + (self.peak - 1) * fall) + self.viscous * v
