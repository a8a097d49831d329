"""The dual cam with two helical grooves and a linear spring, as a designer and a controller use it: the stick
band in closed form, and the spring for a given load. The statics are those of dualcam.design.statics."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from dualcam.design.statics import band_factors


@dataclass(frozen=True)
class HelicalCam:
    """Two helical grooves under a linear spring, with Coulomb friction at both contacts.

    The velocity ratio and the torque per axial force do not depend on theta. So the stick band is affine in
    theta, and one evaluation costs a few multiplications.

    Parameters
    ----------
    radius : Radii of cams 1 and 2 [m].
    lead_angle : Lead angles [rad].
    friction : Coulomb coefficients [1].
    preload : Force of the spring at theta = 0 [N].
    stiffness : Stiffness of the spring [N/m].

    Examples
    --------
    >>> from dualcam.systems.blocks.helical_cam import HelicalCam
    >>> cam = HelicalCam((0.02, 0.02), (0.7854, 0.7854), (0.14, 0.14), preload=50.0, stiffness=5e4)
    >>> [round(edge, 3) for edge in cam.band(0.7)]  # N.m
    [3.018, 5.302]
    """

    radius: tuple[float, float]
    lead_angle: tuple[float, float]
    friction: tuple[float, float]
    preload: float = 0.0
    stiffness: float = 0.0

    @cached_property
    def _slopes(self) -> tuple[float, float]:
        """a_i = r_i tan(lambda_i) [m/rad]."""
        (r1, r2), (lead1, lead2) = self.radius, self.lead_angle
        return r1 * math.tan(lead1), r2 * math.tan(lead2)

    @cached_property
    def dz_dtheta(self) -> float:
        """Velocity ratio a1 a2/(a1 + a2) [m/rad]."""
        a1, a2 = self._slopes
        return a1 * a2 / (a1 + a2)

    @cached_property
    def _torque_per_force(self) -> tuple[float, float]:
        """While releasing and while loading [m]."""
        release, load = band_factors(self._slopes, self.friction, self.radius)
        return float(release), float(load)

    @property
    def release_arm(self) -> float:
        """Torque per axial force while releasing [m]."""
        return self._torque_per_force[0]

    @property
    def load_arm(self) -> float:
        """Torque per axial force while loading [m]."""
        return self._torque_per_force[1]

    @property
    def efficiency(self) -> float:
        """Releasing torque over loading torque at the same angle."""
        return self.release_arm / self.load_arm

    @property
    def relative_half_band(self) -> float:
        """Half width of the stick band over its middle."""
        return (1.0 - self.efficiency) / (1.0 + self.efficiency)

    def band(self, theta: float) -> tuple[float, float]:
        """Stick band at `theta` [rad]: torques [N.m] that just release and just load; between, it rests."""
        force = self.preload + self.stiffness * self.dz_dtheta * theta
        return self.release_arm * force, self.load_arm * force

    def torque(self, theta: float, direction: float) -> float:
        """The torque of slow motion [N.m] at `theta` [rad]. `direction` > 0 loads, else releases."""
        release, load = self.band(theta)
        return load if direction > 0.0 else release

    def with_friction_scaled(self, factor: float) -> HelicalCam:
        """The same cam with `factor` times the friction, as in a controller with that error."""
        return replace(self, friction=(factor * self.friction[0], factor * self.friction[1]))

    def parameters(self) -> dict[str, float]:
        """The same mechanism as start values of the FMU by name, in SI units."""
        values = {"spring.preload": self.preload, "spring.stiffness": self.stiffness}
        for i in (0, 1):
            values[f"cam{i + 1}.radius"] = self.radius[i]
            values[f"cam{i + 1}.lead_angle"] = self.lead_angle[i]
            values[f"cam{i + 1}.friction"] = self.friction[i]
        return values


def fit_spring(
    cam: HelicalCam, load: Callable[[float], float], lower: float, upper: float, points: int = 400
) -> HelicalCam:
    """The cam with the spring that puts the middle of the stick band on a load, by least squares.

    `cam`: its spring is not used. `load`: wanted torque [N.m] by theta [rad], not 0. `lower`, `upper`: ends
    of the range [rad]. `points`: number of angles. The middle is affine in theta, so both unknowns enter
    linearly. The deviation is weighted by 1/load: the width of the band grows with the torque that it
    carries, and only inside the band a load is held for free.
    """
    theta = np.linspace(lower, upper, points)
    wanted = np.array([load(angle) for angle in theta])
    middle_arm = 0.5 * (cam.load_arm + cam.release_arm)
    columns = np.column_stack([np.ones(points), theta]) / wanted[:, None]
    (constant, slope), *_ = np.linalg.lstsq(columns, np.ones(points), rcond=None)
    preload, rise = float(constant) / middle_arm, float(slope) / middle_arm  # N, N/rad
    return replace(cam, preload=preload, stiffness=rise / cam.dz_dtheta)


def holding_torque(band: tuple[float, float], weight: float, margin: float) -> float:
    """The smallest torque [N.m], added to the load's, that keeps a load inside the stick band.

    `band`: edges [N.m]. `weight`: torque of the load [N.m]. `margin`: distance from both edges [N.m].

    Examples
    --------
    >>> from dualcam.systems.blocks.helical_cam import holding_torque
    >>> holding_torque((3.0, 5.0), weight=4.0, margin=0.5), holding_torque((3.0, 5.0), weight=6.0, margin=0.5)
    (0.0, -1.5)
    """
    return min(max(weight, band[0] + margin), band[1] - margin) - weight
