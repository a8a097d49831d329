"""Grooves of constant lead angle."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from dualcam.common.groove_laws import HELIX
from dualcam.common.unit_guards import warn_units
from dualcam.design.grooves.groove import ClosedForm, Numbers, Point, check_lead_angle, check_radius


@dataclass(frozen=True)
class Helix(ClosedForm):
    """A groove of constant lead angle: z = r tan(lambda) psi.

    DesignError: a value outside its range. Source: docs/mechanism.md, section 2.

    Parameters
    ----------
    radius : Radius r of the cam [m], > 0.
    lead_angle : Lead angle lambda [rad], from 0 to less than pi/2.

    Examples
    --------
    >>> import math
    >>> from dualcam.design import Helix
    >>> groove = Helix(radius=0.02, lead_angle=math.radians(45))
    >>> round(float(groove.at(0.5).z), 6)  # m, at psi = 0.5 rad
    0.01
    """

    law: ClassVar = HELIX
    radius: float
    lead_angle: float

    def __post_init__(self) -> None:
        check_radius(self.radius)
        check_lead_angle(self.lead_angle)
        warn_units({"radius": ("cam1.radius", self.radius)})

    @staticmethod
    def ends(radius: Numbers, lead_angle: Numbers) -> tuple[Numbers, Numbers]:
        return -math.inf, math.inf

    @staticmethod
    def formula(psi: NDArray[Any], radius: Numbers, lead_angle: Numbers) -> Point:
        gain = radius * np.tan(lead_angle)
        return Point(gain * psi, gain + np.zeros_like(psi), np.zeros_like(psi))
