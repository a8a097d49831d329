"""The dual cam with two equal elliptical grooves, a spring and a damper, as a designer uses it. The statics
are those of dualcam.design."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from dualcam.design.grooves import Ellipse
from dualcam.design.statics import Array, transfer


@dataclass(frozen=True)
class EllipticalCam:
    """Two equal grooves, elliptical arcs that start steep and flatten, under a spring F = k z without preload
    and a linear damper that acts while the spring is released.

    Both pins turn by psi = theta/2, and dz/dtheta = g'(psi)/2.
    """

    radius: float  # m
    lead_angle: float  # rad, at theta = 0
    ellipse_a: float  # m, semi-axis along the circumference
    ellipse_b: float  # m, semi-axis along z
    friction: float  # Coulomb coefficient
    stiffness: float = 0.0  # N/m
    release_damping: float = 0.0  # N.s/m

    @property
    def groove(self) -> Ellipse:
        """The law of both grooves."""
        return Ellipse(self.radius, self.lead_angle, self.ellipse_a, self.ellipse_b, -1)

    def slope_and_height(self, theta: Array) -> tuple[Array, Array]:
        """Tangent of the lead angle, and z [m], at theta [rad], both of the shape of theta."""
        point = self.groove.at(0.5 * theta)
        return point.slope / self.radius, point.z

    def torque(self, theta: Array, omega: Array) -> Array:
        """Torque [N.m] against +theta during motion through theta [rad] with omega [rad/s], not zero; arrays
        of one shape.

        The pin bears on the flank that the axial force F presses it to, so friction acts with the sign of
        omega F.
        """
        point = self.groove.at(0.5 * theta)
        speed = 0.5 * point.slope * omega
        force = self.stiffness * point.z + np.where(speed < 0.0, self.release_damping * speed, 0.0)
        pairs = (point.slope, point.slope), (self.friction, self.friction), (self.radius, self.radius)
        against, along = (transfer(*pairs, sign).rho for sign in (1, -1))
        return force * np.where(omega * force > 0.0, against, along)

    def with_damping_scaled(self, factor: float) -> EllipticalCam:
        """The same cam with its damping times `factor`."""
        return replace(self, release_damping=self.release_damping * factor)

    def parameters(self) -> dict[str, float]:
        """The same mechanism as start values of the FMU."""
        values: dict[str, float] = {
            "spring.preload": 0.0,
            "spring.stiffness": self.stiffness,
            "damper.c_release": self.release_damping,
        }
        for cam in ("cam1", "cam2"):
            values |= {f"{cam}.{name}": value for name, value in self.groove.parameters().items()}
            values[f"{cam}.friction"] = self.friction
        return values


NO_CAM = {  # start values of the FMU without spring and friction: the FMU is then an inertia
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
    "cam1.friction": 0.0,
    "cam2.friction": 0.0,
}
