"""A designed groove, and what friction does to it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import real_array
from dualcam.design.band import TorqueBand, span, torque_band
from dualcam.design.grooves import Table
from dualcam.design.mechanism import POINTS, Mechanism
from dualcam.design.statics import Array
from dualcam.design.torque import Torque
from dualcam.errors import DesignError

SMALL = 1e-3  # share of the largest torque below which errors are relative to that share of it


@dataclass(frozen=True, eq=False)
class Design:
    """A groove for a wanted torque, from `synthesize`.

    Attributes
    ----------
    mechanism : With the designed table as groove 1, or as both grooves.
    direction : Direction in which the torque is wanted: "loading", "releasing" or "frictionless".
    wanted : Wanted torque [N.m] at an array of theta [rad].
    largest_error : Largest relative error of the torque that was found between the samples of the table [1].
    largest_error_at : Angle theta of that error [rad].
    """

    mechanism: Mechanism
    direction: str
    wanted: Torque
    largest_error: float
    largest_error_at: float

    @property
    def table(self) -> Table:
        """The designed groove. `table.write(path)` writes a CSV file for the FMU."""
        groove = self.mechanism.grooves[0]
        assert isinstance(groove, Table)
        return groove

    def torque(self, theta: ArrayLike) -> Array:
        """Torque of slow motion in the wanted direction [N.m], as in the FMU, at `theta` of cam 2 [rad]."""
        return self.mechanism.torque(theta, self.direction)

    def error(self, theta: ArrayLike) -> Array:
        """Relative error of the torque (given - wanted)/wanted [1] at angles `theta` of cam 2 [rad].

        Wanted torques below 1/1000 of the largest count as that much.
        """
        theta = real_array(theta, "theta", DesignError)
        largest = np.max(np.abs(self.wanted(np.linspace(0.0, self.mechanism.upper, 400))))
        scale = np.maximum(np.abs(self.wanted(theta)), SMALL * largest)
        return (self.torque(theta) - self.wanted(theta)) / scale

    def torque_band(self, points: int = POINTS) -> TorqueBand:
        """The torque band of the finished grooves at `points` angles, evenly over the range."""
        return torque_band(self.mechanism, points)

    def summary(self) -> str:
        """What was wanted, what the groove gives, and what friction does to it, as text for a reader."""
        theta = self.mechanism.angles()
        verb = {
            "loading": "of slow loading",
            "releasing": "of slow releasing",
            "frictionless": "without friction",
        }
        first = self.table.psi[0], self.table.psi[-1]
        slope = self.table.at(np.linspace(*first, POINTS)).slope
        lead = np.degrees(np.arctan(slope / self.table.radius))
        return "\n".join(
            [
                f"wanted torque {verb[self.direction]}: {span(self.wanted(theta))} N.m from theta = 0 to"
                f" {self.mechanism.upper:.4g} rad, obtained to {self.largest_error:.1g}",
                f"groove: {len(self.table.psi)} samples, psi {first[0]:.4g} to {first[1]:.4g} rad, z 0 to"
                f" {self.table.z[-1]:.4g} m, lead angle {span(lead)} deg",
                str(self.torque_band()),
            ]
        )
