"""Cycloidal grooves, level at both ends."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from dualcam.common.groove_laws import CYCLOID
from dualcam.common.unit_guards import warn_units
from dualcam.design.grooves.groove import ClosedForm, Numbers, Point, check, check_radius


@dataclass(frozen=True)
class Cycloid(ClosedForm):
    """A cycloidal groove: z = H (psi/B - sin(2 pi psi/B)/(2 pi)) for 0 <= psi <= B, level at both ends.

    The second derivative is 0 at both ends. So a dwell beside the groove causes no step of the acceleration.
    The groove is steepest in the middle, dz/dpsi = 2 H/B. DesignError: a value outside its range. Source:
    docs/mechanism.md, section 2.

    Parameters
    ----------
    radius : Radius of the cam [m], > 0.
    rise : Height H of the whole groove [m], > 0. The FMU's `cycloid_rise`.
    angle : Angle B over which the groove rises [rad], > 0. The FMU's `cycloid_angle`.

    Examples
    --------
    >>> from dualcam.design import Cycloid
    >>> groove = Cycloid(radius=0.02, rise=0.02, angle=1.4)
    >>> [round(float(z), 6) for z in groove.at([0.0, 0.7, 1.4]).z]  # m
    [0.0, 0.01, 0.02]
    """

    law: ClassVar = CYCLOID
    radius: float
    rise: float
    angle: float

    def __post_init__(self) -> None:
        check_radius(self.radius)
        check("rise", self.rise, 0.0 < self.rise < math.inf, "a finite number > 0 in m")
        check("angle", self.angle, 0.0 < self.angle < math.inf, "a finite number > 0 in rad")
        names = {"radius": "radius", "rise": "cycloid_rise", "angle": "cycloid_angle"}
        warn_units({name: (f"cam1.{rule}", getattr(self, name)) for name, rule in names.items()})

    @staticmethod
    def ends(radius: Numbers, rise: Numbers, angle: Numbers) -> tuple[Numbers, Numbers]:
        return 0.0, angle

    @staticmethod
    def formula(psi: NDArray[Any], radius: Numbers, rise: Numbers, angle: Numbers) -> Point:
        x = psi / angle
        upper = x.real > 0.5
        turn = 2.0 * math.pi * np.where(upper, 1.0 - x, x)  # from the nearer end, where the groove is level
        height = rise * _less_sine(turn) / (2.0 * math.pi)
        bend = 2.0 * math.pi * rise / angle**2 * np.sin(turn)
        return Point(
            np.where(upper, rise - height, height),
            2.0 * rise / angle * np.sin(0.5 * turn) ** 2,
            np.where(upper, -bend, bend),
        )

    def steepness(self, lead_angle: float) -> float:
        """The rise [m] for a mean lead angle [rad]."""
        return self.radius * self.angle * math.tan(lead_angle)


def _less_sine(y: NDArray[Any]) -> NDArray[Any]:
    """y - sin y for 0 <= y <= pi, by its series where the difference cancels."""
    series = np.ones_like(y)
    for n in range(16, 1, -2):
        series = 1.0 - y**2 / ((n + 2) * (n + 3)) * series
    return np.where(y.real < 1.0, y**3 / 6.0 * series, y - np.sin(y))
