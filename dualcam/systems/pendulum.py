"""A segment that hangs from a moving hinge, as the shank hangs from the knee."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple


class HingeMotion(NamedTuple):
    """The motion of a hinge at one time, with time derivatives.

    Parameters
    ----------
    tilt : tuple of float
        Inclination of the carrier from straight down, + forward: derivatives 0 to 4 [rad, rad/s, ...].
    forward, upward : tuple of float
        The hinge's acceleration: derivatives 0 to 2 [m/s2, m/s3, m/s4].
    """

    tilt: tuple[float, float, float, float, float]
    forward: tuple[float, float, float]
    upward: tuple[float, float, float]


@dataclass(frozen=True)
class HingedPendulum:
    """A rigid segment that hangs from a hinge on a moving carrier.

    psi is the carrier's inclination, theta the flexion of the hinge, and chi = psi - theta + lead the
    inclination of the line from the hinge to the centre of mass. (a_x, a_y) is the hinge's acceleration, M
    the torque that extends the hinge. The moments about the moving hinge balance as

        I chi'' + m d [a_x cos chi + (a_y + g) sin chi] = M

    or I theta'' = drive - M with drive = I psi'' + m d [a_x cos chi + (a_y + g) sin chi].

    Parameters
    ----------
    inertia : float
        Inertia I about the hinge [kg.m2].
    moment : float
        Mass times distance of its centre from the hinge, m d [kg.m].
    lead : float
        Angle of the centre of mass ahead of the line that theta is measured to [rad].
    gravity : float
        Acceleration of gravity [m/s2].
    """

    inertia: float
    moment: float
    lead: float
    gravity: float = 9.81

    def drive(
        self, hinge: HingeMotion, theta: float, omega: float = 0.0, alpha: float = 0.0
    ) -> tuple[float, float, float]:
        """The torque that bends the hinge, and its first two time derivatives along a motion.

        Parameters
        ----------
        hinge : HingeMotion
            The motion of the hinge.
        theta : float
            Flexion [rad].
        omega : float
            Its first time derivative [rad/s].
        alpha : float
            Its second time derivative [rad/s2].

        Returns
        -------
        tuple of float
            Torque and derivatives [N.m, N.m/s, N.m/s2].
        """
        psi, psi1, psi2, psi3, psi4 = hinge.tilt
        x, x1, x2 = hinge.forward
        y, y1, y2 = hinge.upward
        y += self.gravity
        chi, chi1, chi2 = psi - theta + self.lead, psi1 - omega, psi2 - alpha
        c, s = math.cos(chi), math.sin(chi)
        tangential, radial = x * c + y * s, y * c - x * s  # radial = d tangential/d chi
        value = self.inertia * psi2 + self.moment * tangential
        first = self.inertia * psi3 + self.moment * (x1 * c + y1 * s + chi1 * radial)
        second = self.inertia * psi4 + self.moment * (
            x2 * c + y2 * s + 2.0 * chi1 * (y1 * c - x1 * s) + chi2 * radial - chi1**2 * tangential
        )
        return value, first, second
