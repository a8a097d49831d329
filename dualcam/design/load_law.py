"""Friction at rest that depends on the nominal load of the contacts (docs/mechanism.md, section 9).

The nominal load N_i of a contact is the reaction that the axial force makes without friction and inertia:

    N_i = |F| a_j hypot(r_i, a_i)/(n r_i (a_1 + a_2))     j the other groove, n contacts

A law gives the factor by which it multiplies the coefficient of friction.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from dualcam.design.statics import Pair, transfer

LOW = 0.1  # of the reference load: keeps the coefficient finite without load
Values = NDArray[Any]  # real, or complex for derivatives by a complex step


class LoadLaw(Protocol):
    """The factor of the coefficient of friction over the nominal load."""

    def factor(self, load: Values) -> Values:
        """Factor [1] at nominal loads of one contact [N], of the shape of `load`."""


@dataclass(frozen=True)
class LoadPower:
    """((N^2 + (0.1 N_ref)^2)/N_ref^2)^(nu/2): `cam1.friction_load_exponent` and `cam1.friction_load`."""

    exponent: float | Values  # nu [1], float or of the shape of the loads
    reference: float  # N_ref [N]

    def factor(self, load: Values) -> Values:
        """Factor [1] at nominal loads of one contact [N], of the shape of `load`."""
        share = load / self.reference
        return (share * share + LOW**2) ** (0.5 * self.exponent)


class LoadSamples:
    """The first row of speeds of a friction table over loads [N], growing, over that at the middle load."""

    def __init__(self, loads: Sequence[float], coefficients: Sequence[float]) -> None:
        from scipy.interpolate import CubicSpline

        logs = np.log(coefficients)
        self._spline = CubicSpline(np.log(loads), logs - logs[len(logs) // 2], bc_type="clamped")

    def factor(self, load: Values) -> Values:
        """Factor [1] at nominal loads of one contact [N], of their shape; beyond the table the last one."""
        first, last = self._spline.x[[0, -1]]
        with np.errstate(divide="ignore"):
            place = np.log(np.abs(load.real))
        inside = np.clip(place, first, last)
        value = np.exp(self._spline(inside))
        if not np.iscomplexobj(load):
            return value
        rate = np.where(inside == place, self._spline(inside, 1) / load.real, 0.0)
        return value * (1.0 + 1j * rate * load.imag)


def friction_under(
    friction: Pair, laws: Sequence[LoadLaw | None], slope: Pair, radius: Pair, force_per_contact: Values
) -> Pair:
    """Coefficients of friction at rest [1] under an axial force, by the load `laws` of both contacts."""
    if not any(laws):
        return friction
    loads = transfer(slope, (0.0, 0.0), radius, 0).reaction * force_per_contact
    return [
        mu if law is None else mu * law.factor(load)
        for mu, law, load in zip(friction, laws, loads, strict=True)
    ]
