"""Loads by gravity: a mass on an arm, and a body that hangs on a tilted hinge."""

import math
from dataclasses import dataclass
from typing import Generic

import numpy as np

from dualcam.design.statics import Array
from dualcam.systems.blocks.elementwise import Number, cosine, sine


@dataclass(frozen=True)
class GravityLoad(Generic[Number]):
    """A mass on an arm, or many of them: a pendulum that leans from upright at theta = 0 and falls as theta
    grows.

    `moment`: mass times distance of its centre from the axis [kg.m], float or shape (count,). `lean` from
    upright at theta = 0 [rad], float or shape (count,). `gravity`: acceleration of gravity [m/s2].

    Examples
    --------
    >>> import math
    >>> from dualcam.systems.blocks.gravity import GravityLoad
    >>> round(GravityLoad(moment=0.75, lean=0.0).torque(math.pi / 2), 3)  # N.m, the arm is horizontal
    7.357
    """

    moment: Number
    lean: Number | float
    gravity: float = 9.81

    def torque(self, theta: Number) -> Number:
        """The torque of the weight about the axis [N.m], + in the direction of `theta` [rad]."""
        return self.moment * self.gravity * sine(self.lean + theta)

    def energy(self, theta: Number) -> Number:
        """The potential energy of the weight [J] at `theta` [rad], 0 with the arm horizontal."""
        return self.moment * self.gravity * cosine(self.lean + theta)


def hinged_load(mass: float, hinge: tuple[Array, Array], centre: Array, up: Array) -> GravityLoad:
    """The weight of a body about a tilted hinge, as an equivalent pendulum.

    `mass` of the body [kg]. `hinge`: two points of the hinge's axis [m], shape (3,) each; theta is
    right-handed about the vector from the first to the second. `centre`: the body's centre of mass at theta =
    0 [m], shape (3,). `up`: the upward vertical in the same axes, a unit vector, shape (3,).

    Notes
    -----
    Let e1 point from the axis to the centre and e2 = axis x e1, both unit vectors. The centre's height is r
    up.(e1 cos theta + e2 sin theta). That is a pendulum which leans atan2(-up.e2, up.e1) from upright, under
    the component of gravity across the axis.
    """
    first, second = hinge
    axis = (second - first) / np.linalg.norm(second - first)
    arm = np.cross(np.cross(axis, centre - first), axis)
    along, across = float(up @ arm), float(up @ np.cross(axis, arm))  # m
    return GravityLoad(moment=mass * math.hypot(along, across), lean=math.atan2(-across, along))


def vertical_in_car(pitch: float, roll: float) -> Array:
    """The upward vertical in the car's axes (x to the rear, y to the right, z to the roof), shape (3,).

    `pitch`, `roll`: angles of the car [rad]; `pitch` > 0 lifts the nose, `roll` > 0 lifts the right side. The
    car is turned by R_x(roll) R_y(pitch). The vertical is the last row of that matrix.
    """
    return np.array([-math.cos(roll) * math.sin(pitch), math.sin(roll), math.cos(roll) * math.cos(pitch)])
