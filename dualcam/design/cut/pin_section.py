"""The section of a radial cylindrical pin on a cylinder around the cam's axis, unwrapped, and where the
section touches the flanks of its groove (docs/cut-grooves.md).

With the pin's radius p, the cylinder's rho, q = p/rho, x = rho times the angle from the pin's axis, z from
there, and the slope s of the path on that cylinder:

    x(t) = rho asin(p cos(t)/rho)      z(t) = p sin(t)
    cos(t) = -+ s sqrt(2/(1 + s^2 + sqrt((1 + s^2)^2 - 4 q^2 s^2)))      - upper flank, + lower flank
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from dualcam.design.statics import Array


class Contact(NamedTuple):
    """Where the section touches the upper flank; the lower flank is touched at the opposite point."""

    angle: Array  # rad, from the pin's axis, about the cam's axis; in the direction of growing psi
    height: Array  # m, from the pin's axis


def contact(slope: ArrayLike, pin_radius: float, radius: ArrayLike) -> Contact:
    """The point of the pin on the upper flank of a path of slope dz/dpsi [m/rad], for arrays."""
    cosine, sine = _direction(slope, pin_radius, radius)
    rho = np.asarray(radius, dtype=float)
    return Contact(np.arcsin(pin_radius * cosine / rho), pin_radius * sine)


def section(turn: ArrayLike, pin_radius: float, radius: ArrayLike) -> Contact:
    """Points of the section's edge at the parameter t = `turn` [rad]."""
    t, rho = np.asarray(turn, dtype=float), np.asarray(radius, dtype=float)
    return Contact(np.arcsin(pin_radius * np.cos(t) / rho), pin_radius * np.sin(t) * np.ones_like(rho))


def contact_turn(slope: ArrayLike, pin_radius: float, radius: ArrayLike) -> Array:
    """The parameter t of the point on the upper flank [rad], from pi/2 (level groove) to pi (upright)."""
    cosine, sine = _direction(slope, pin_radius, radius)
    return np.arctan2(sine, cosine)


def section_radius(slope: ArrayLike, pin_radius: float, radius: ArrayLike) -> Array:
    """Radius of curvature of the unwrapped section at the flanks [m]. The radius is p in a level groove."""
    cosine, sine = _direction(slope, pin_radius, radius)
    q = pin_radius / np.asarray(radius, dtype=float)
    w2 = 1.0 - (q * cosine) ** 2
    bend = 1.0 - (q * sine * cosine) ** 2 / w2
    return np.asarray(pin_radius * (sine**2 / w2 + cosine**2) ** 1.5 * np.sqrt(w2) / bend)


def _direction(slope: ArrayLike, pin_radius: float, radius: ArrayLike) -> tuple[Array, Array]:
    """cos(t) and sin(t) on the upper flank."""
    rho = np.asarray(radius, dtype=float)
    s, q = np.asarray(slope, dtype=float) / rho, pin_radius / rho
    one = 1.0 + s**2
    cosine = -s * np.sqrt(2.0 / (one + np.sqrt(one**2 - (2.0 * q * s) ** 2)))
    return cosine, np.sqrt(1.0 - cosine**2)
