"""Grooves that unwrap to an arc of an ellipse."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from dualcam.common.groove_laws import ELLIPSE
from dualcam.common.unit_guards import warn_units
from dualcam.design.grooves.groove import (
    ClosedForm,
    Numbers,
    Point,
    check,
    check_lead_angle,
    check_radius,
)

VERTICAL = 1e-10  # of S: an elliptical groove ends that much before it is vertical, as in the FMU


@dataclass(frozen=True)
class Ellipse(ClosedForm):
    """A groove that unwraps to an arc of an ellipse.

    DesignError: a value outside its range. Source: docs/mechanism.md, section 2.

    Parameters
    ----------
    radius : Radius of the cam [m], > 0.
    lead_angle : Lead angle at psi = 0 [rad], from 0 to less than pi/2.
    a, b : Semi-axes along the circumference and along z [m], > 0.
    bending : +1: the groove steepens. -1: the groove flattens. The FMU's `ellipse_curvature`.

    Examples
    --------
    >>> from dualcam.design import Ellipse
    >>> groove = Ellipse(radius=0.02, lead_angle=0.6, a=0.05, b=0.05)
    >>> low, high = groove.range  # rad, where the law holds
    >>> low < 0.0 < 1.0 < high
    True
    """

    law: ClassVar = ELLIPSE
    radius: float
    lead_angle: float
    a: float
    b: float
    bending: int = -1

    def __post_init__(self) -> None:
        check_radius(self.radius)
        check_lead_angle(self.lead_angle)
        check("a", self.a, 0.0 < self.a < math.inf, "a finite number > 0 in m")
        check("b", self.b, 0.0 < self.b < math.inf, "a finite number > 0 in m")
        check("bending", self.bending, self.bending in (-1, 1), "+1 (steepens) or -1 (flattens)")
        starts = bool(_start(self.lead_angle, self.a, self.b) <= 1.0 - VERTICAL)
        check("lead_angle", self.lead_angle, starts, "less: this elliptical groove would start vertical")
        lengths = {"radius": "cam1.radius", "a": "cam1.ellipse_a", "b": "cam1.ellipse_b"}
        warn_units({name: (rule, getattr(self, name)) for name, rule in lengths.items()})

    @staticmethod
    def ends(
        radius: Numbers, lead_angle: Numbers, a: Numbers, b: Numbers, bending: Numbers
    ) -> tuple[Numbers, Numbers]:
        start = _start(lead_angle, a, b)
        ends = [(S - start) * a / radius * bending for S in (0.0, 1.0 - VERTICAL)]
        return np.minimum(*ends), np.maximum(*ends)

    @staticmethod
    def formula(
        psi: NDArray[Any], radius: Numbers, lead_angle: Numbers, a: Numbers, b: Numbers, bending: Numbers
    ) -> Point:
        rate, start = bending * radius / a, _start(lead_angle, a, b)
        u = rate * psi
        S, C0 = start + u, np.sqrt(1.0 - start**2)
        rise = u * (start + S)  # C0^2 - C^2
        C = np.sqrt(C0**2 - rise)
        gain = radius * b / a
        return Point(bending * b * rise / (C0 + C), gain * S / C, gain * rate / C**3)


def _start(lead_angle: Numbers, a: Numbers, b: Numbers) -> Numbers:
    """S at psi = 0: sin(atan(a/b tan(lead angle)))."""
    ratio = a / b * np.tan(lead_angle)
    return ratio / np.sqrt(1.0 + ratio**2)
