"""A segment that hangs from a moving hinge, as the shank hangs from the knee."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Generic, NamedTuple

from dualcam.systems.blocks.elementwise import Number, cosine, sine


class HingeMotion(NamedTuple):
    """The motion of a hinge at one time, with time derivatives.

    `tilt`: inclination of the carrier from straight down, + forward: derivatives 0 to 4 [rad, rad/s, ...].
    `forward`, `upward`: the hinge's acceleration: derivatives 0 to 2 [m/s2, m/s3, m/s4].
    """

    tilt: tuple[float, float, float, float, float]
    forward: tuple[float, float, float]
    upward: tuple[float, float, float]


def across_acceleration(ahead: Number, above: Number, inclination: Number) -> Number:
    """The acceleration across a hanging line [m/s2].

    `ahead`, `above`: acceleration forward and upward [m/s2]. `inclination` of the line from straight down, +
    forward [rad].
    """
    return ahead * cosine(inclination) + above * sine(inclination)


@dataclass(frozen=True)
class HingedPendulum(Generic[Number]):
    """A rigid segment that hangs from a hinge on a moving carrier.

    psi is the carrier's inclination, theta the flexion of the hinge, and chi = psi - theta + lead the
    inclination of the line from the hinge to the centre of mass. (a_x, a_y) is the hinge's acceleration, M
    the torque that extends the hinge. The moments about the moving hinge balance as

        I chi'' + m d [a_x cos chi + (a_y + g) sin chi] = M

    or I theta'' = drive - M with drive = I psi'' + m d [a_x cos chi + (a_y + g) sin chi].

    Parameters
    ----------
    inertia : Inertia I about the hinge [kg.m2], float or shape (count,).
    moment : Mass times distance of its centre from the hinge, m d [kg.m], float or shape (count,).
    lead : Angle of the centre of mass ahead of the line that theta is measured to [rad].
    gravity : Acceleration of gravity [m/s2].
    """

    inertia: Number
    moment: Number
    lead: float
    gravity: float = 9.81

    def torque(self, tilt: Number, turning: Number, ahead: Number, above: Number, theta: Number) -> Number:
        """The torque that bends the hinge [N.m], float or shape (count,) as all arguments.

        `tilt`: inclination of the carrier [rad]. `turning`: its second time derivative [rad/s2]. `ahead`,
        `above`: the hinge's acceleration, forward and upward [m/s2]. `theta`: flexion [rad].
        """
        across = across_acceleration(ahead, above + self.gravity, tilt - theta + self.lead)
        return self.inertia * turning + self.moment * across

    def drive(
        self: HingedPendulum[float],
        hinge: HingeMotion,
        theta: float,
        omega: float = 0.0,
        alpha: float = 0.0,
    ) -> tuple[float, float, float]:
        """The torque that bends the hinge [N.m], and its first two time derivatives along a motion.

        `hinge`: its motion. `theta`: flexion [rad]. `omega`, `alpha`: its first and second time derivative
        [rad/s, rad/s2].
        """
        psi, psi1, psi2, psi3, psi4 = hinge.tilt
        x, x1, x2 = hinge.forward
        y, y1, y2 = hinge.upward
        value = self.torque(psi, psi2, x, y, theta)
        y += self.gravity
        chi, chi1, chi2 = psi - theta + self.lead, psi1 - omega, psi2 - alpha
        c, s = math.cos(chi), math.sin(chi)
        across, radial = across_acceleration(x, y, chi), y * c - x * s  # radial = d across/d chi
        first = self.inertia * psi3 + self.moment * (x1 * c + y1 * s + chi1 * radial)
        second = self.inertia * psi4 + self.moment * (
            x2 * c + y2 * s + 2.0 * chi1 * (y1 * c - x1 * s) + chi2 * radial - chi1**2 * across
        )
        return value, first, second
