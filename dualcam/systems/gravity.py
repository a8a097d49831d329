"""Loads by gravity: a mass on an arm, and a body that hangs on a tilted hinge."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dualcam.design.statics import Array


@dataclass(frozen=True)
class GravityLoad:
    """A mass on an arm: a pendulum that leans from upright at theta = 0 and falls as theta grows."""

    moment: float  # kg.m, mass times distance of its centre from the axis
    lean: float  # rad from upright at theta = 0
    gravity: float = 9.81  # m/s2

    def torque(self, theta: float) -> float:
        """Torque about the axis [N.m] at theta [rad], + in the direction of theta."""
        return self.moment * self.gravity * math.sin(self.lean + theta)

    def energy(self, theta: float) -> float:
        """Potential energy [J] at theta [rad], 0 with the arm horizontal."""
        return self.moment * self.gravity * math.cos(self.lean + theta)


def hinged_load(mass: float, hinge: tuple[Array, Array], centre: Array, up: Array) -> GravityLoad:
    """The weight of a body [kg] about a tilted hinge, as an equivalent pendulum.

    hinge    two points of its axis [m], shape (3,) each; theta is right-handed about the vector from the
             first to the second
    centre   the body's centre of mass at theta = 0 [m], shape (3,)
    up       the upward vertical, a unit vector of shape (3,), in the same axes

    Let e1 point from the axis to the centre and e2 = axis x e1, both unit vectors. The centre's height is
    r up.(e1 cos theta + e2 sin theta). That is a pendulum which leans atan2(-up.e2, up.e1) from upright,
    under the component of gravity across the axis.
    """
    first, second = hinge
    axis = (second - first) / np.linalg.norm(second - first)
    arm = np.cross(np.cross(axis, centre - first), axis)
    along, across = float(up @ arm), float(up @ np.cross(axis, arm))  # m
    return GravityLoad(moment=mass * math.hypot(along, across), lean=math.atan2(-across, along))


def vertical_in_car(pitch: float, roll: float) -> Array:
    """The upward vertical in the car's axes (x to the rear, y to the right, z to the roof), shape (3,).

    `pitch` > 0 lifts the nose, `roll` > 0 lifts the right side [rad]. The car is turned by
    R_x(roll) R_y(pitch). The vertical is the last row of that matrix.
    """
    return np.array([-math.cos(roll) * math.sin(pitch), math.sin(roll), math.cos(roll) * math.cos(pitch)])
