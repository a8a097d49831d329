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

    Parameters
    ----------
    radius : Radius of both cams [m].
    lead_angle : Lead angle at theta = 0 [rad].
    ellipse_a : Semi-axis along the circumference [m].
    ellipse_b : Semi-axis along z [m].
    friction : Coulomb coefficient of both contacts [1].
    stiffness : Stiffness of the spring [N/m].
    release_damping : Linear damper while the spring is released [N.s/m].

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.blocks.elliptical_cam import EllipticalCam
    >>> cam = EllipticalCam(0.02, 1.2, 0.03, 0.02, friction=0.14, stiffness=2e4)
    >>> cam.torque(np.array([0.5, 0.5]), np.array([1.0, -1.0])).round(3).tolist()  # N.m: loading, releasing
    [1.64, 0.93]
    """

    radius: float
    lead_angle: float
    ellipse_a: float
    ellipse_b: float
    friction: float
    stiffness: float = 0.0
    release_damping: float = 0.0

    @property
    def groove(self) -> Ellipse:
        """The law of both grooves."""
        return Ellipse(self.radius, self.lead_angle, self.ellipse_a, self.ellipse_b, -1)

    def slope_and_height(self, theta: Array) -> tuple[Array, Array]:
        """Tangent of the lead angle [1] and z [m] at `theta` [rad], of the shape of theta."""
        point = self.groove.at(0.5 * theta)
        return point.slope / self.radius, point.z

    def torque(self, theta: Array, omega: Array) -> Array:
        """The torque against +theta during motion [N.m], of the shape of theta.

        The pin bears on the flank that the axial force F presses it to, so friction acts with the sign of
        omega F.

        `theta`: angle [rad]. `omega`: speed [rad/s], not zero, of the shape of theta.
        """
        point = self.groove.at(0.5 * theta)
        speed = 0.5 * point.slope * omega
        force = self.stiffness * point.z + np.where(speed < 0.0, self.release_damping * speed, 0.0)
        pairs = (point.slope, point.slope), (self.friction, self.friction), (self.radius, self.radius)
        against, along = (transfer(*pairs, sign).rho for sign in (1, -1))
        return force * np.where(omega * force > 0.0, against, along)

    def with_damping_scaled(self, factor: float) -> EllipticalCam:
        """The same cam with `factor` times the damping [1]."""
        return replace(self, release_damping=self.release_damping * factor)

    def parameters(self) -> dict[str, float]:
        """The same mechanism as start values of the FMU by name, in SI units."""
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
