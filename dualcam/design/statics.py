"""Torque and reactions with friction (docs/mechanism.md, sections 3 and 8), for whole arrays at once.

With the slope a_i = dz/dpsi = r_i tan(lambda_i) of groove i, moving in direction sigma against F > 0,

    n_i = a_i + sigma mu_i r_i     d_i = r_i - sigma mu_i a_i     kappa_i = d_i/(r_i n_i)
    T = rho_sigma F,  rho_sigma = 1/(kappa_1 + kappa_2)     eta = rho_-/rho_+

Pairs (slopes, frictions, radii, lead angles) are sequences of two numbers or arrays that broadcast.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import Array, real_array
from dualcam.common.entries import is_whole
from dualcam.errors import DesignError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.contour import QuadContourSet

Pair = Sequence[ArrayLike] | Array

DIRECTIONS = {"loading": 1, "releasing": -1, "frictionless": 0}


def is_number(value: object) -> bool:
    """Whether a `value` is a real number; text, None and truth values are not."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def check_numbers(values: Mapping[str, object]) -> None:
    """Refuse with a DesignError `values`, by name, that are no numbers, such as text with a unit."""
    for name, value in values.items():
        if not is_number(value):
            raise DesignError(
                f"{name} = {value!r:.60}: allowed is a number in the SI unit, such as 0.003 for 3 mm"
            )


def sign_of(direction: str) -> int:
    """The sign sigma of a direction: +1 loading, -1 releasing, 0 frictionless, else a DesignError."""
    if direction not in DIRECTIONS:
        raise DesignError(f"direction {direction!r}: allowed are {', '.join(DIRECTIONS)}")
    return DIRECTIONS[direction]


@dataclass(frozen=True)
class Transfer:
    """Torque and reactions per newton of the axial force F, for one choice of flanks."""

    rho: Array  # torque over F [m]
    reaction: Array  # normal force of all contacts in each groove over F [1], shape (2, ...)
    regular: NDArray[np.bool_]  # whether both reactions have the signs of their flanks, and none is infinite


def transfer(
    slope: Pair, friction: Pair, radius: Pair, sign: int, flank: tuple[int, int] = (1, 1)
) -> Transfer:
    """Torque and reactions per newton of the axial force F, by the formulas at the head of this file, also
    where they have no meaning: see `Transfer.regular`. `sign`: sigma. `flank` of each groove: +1 where the
    pin bears on the flank that supports F, else -1."""
    given = [np.asarray(one) for pair in (slope, friction, radius) for one in pair]
    kind = np.result_type(float, *given)  # complex for derivatives by a complex step
    parts = np.broadcast_arrays(*(one.astype(kind) for one in given))
    a, mu, r = (np.stack(parts[k : k + 2]) for k in (0, 2, 4))
    mu *= sign * np.reshape(flank, (2, *[1] * (mu.ndim - 1)))
    n, d = a + mu * r, r - mu * a
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / (r[1] * d[0] * n[1] + r[0] * d[1] * n[0])
        axial = np.stack([r[1] * n[1] * inverse, r[0] * n[0] * inverse])
        rho = r[0] * r[1] * n[0] * n[1] * inverse
    good = np.isfinite(inverse) & (flank[0] * axial[0].real >= 0.0) & (flank[1] * axial[1].real >= 0.0)
    length = np.sqrt(r * r + a * a) if kind.kind == "c" else np.hypot(r, a)
    return Transfer(rho, axial * length, good)


def band_factors(slope: Pair, friction: Pair, radius: Pair) -> tuple[Array, Array]:
    """The edges of the stick band over the axial force F: T_release/F and T_load/F [m].

    T_load is +inf where no torque loads. T_release is <= 0 where a contact locks itself (lambda_i <= atan
    mu_i), -inf where both are wedged. `slope`: slopes a_i = dz/dpsi of both grooves [m/rad]. `friction`:
    coefficients of friction mu_i [1]. `radius`: radii r_i [m]. Source: docs/mechanism.md, section 3.

    Examples
    --------
    >>> from dualcam.design import band_factors
    >>> release, load = band_factors((0.02, 0.02), (0.14, 0.14), (0.02, 0.02))  # two helices of 45 deg
    >>> round(float(release), 6), round(float(load), 6)  # m
    (0.007544, 0.013256)
    """
    (release, load), _ = band(slope, friction, radius)
    return release, load


def band(slope: Pair, friction: Pair, radius: Pair) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """The factors (release, load) of `band_factors` [m], and their normal forces over F, shape (2, ...)."""
    loading = transfer(slope, friction, radius, 1)
    load = np.where(loading.regular, loading.rho, np.inf)
    push = np.where(loading.regular, loading.reaction, np.inf)
    # Where one contact locks and the other does not, the unlocked one bears on its other flank.
    release, pull = np.full(load.shape, -np.inf), np.full(push.shape, np.inf)
    for flank in ((-1, 1), (1, -1), (1, 1)):  # the last one that agrees with its reactions counts
        found = transfer(slope, friction, radius, -1, flank)
        release = np.where(found.regular, found.rho, release)
        pull = np.where(found.regular, found.reaction, pull)
    return (release, load), (pull, push)


def efficiency(lead_angle: Pair, friction: Pair, radius: Pair = (1.0, 1.0)) -> Array:
    """The efficiency eta = T_release/T_load at the same z [1].

    It is <= 0 where a contact locks itself, -inf or nan where the mechanism is wedged. `lead_angle`: lead
    angles lambda_i [rad]. `friction`: coefficients of friction mu_i [1], >= 0. `radius`: radii r_i [m], > 0.
    Only the ratio of the radii counts. DesignError: a coefficient of friction or a radius outside its range.
    Source: docs/mechanism.md, section 8.

    Examples
    --------
    >>> import math
    >>> from dualcam.design import efficiency
    >>> round(float(efficiency((math.pi / 4, math.pi / 4), (0.14, 0.14))), 4)  # ((1 - mu)/(1 + mu))^2
    0.5691
    """
    _check_ranges(friction, radius)
    angles = [real_array(angle, f"lead_angle[{i}]", DesignError) for i, angle in enumerate(lead_angle)]
    slope = [np.asarray(r) * np.tan(angle) for r, angle in zip(radius, angles, strict=True)]
    release, load = band_factors(slope, friction, radius)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(release / load)


def _check_ranges(friction: Pair, radius: Pair) -> None:
    """DesignError unless all are finite, coefficients of friction >= 0, and radii > 0."""
    for name, pair, allowed in (("friction", friction, ">= 0"), ("radius", radius, "> 0")):
        for i, values in enumerate(pair):
            found = real_array(values, f"{name}[{i}]", DesignError)
            good = found >= 0.0 if name == "friction" else found > 0.0
            if not (np.isfinite(found) & good).all():
                raise DesignError(f"{name}[{i}] = {values}: allowed is a finite number {allowed}")


@dataclass(frozen=True)
class BestLeadAngles:
    """The pair of lead angles with the best efficiency.

    `lead_angle`: lambda_1 and lambda_2 [rad]. `efficiency`: the best efficiency. `friction`: mu_e: two equal
    contacts with this coefficient would have the same efficiency.
    """

    lead_angle: tuple[float, float]
    efficiency: float
    friction: float


def optimum(friction: Sequence[float], radius: Sequence[float] = (1.0, 1.0)) -> BestLeadAngles:
    """The best lead angles, in closed form.

    `friction`: coefficients of friction mu_1, mu_2 [1], both > 0 or both 0, shape (2,). `radius`: radii r_1,
    r_2 [m], > 0, shape (2,). Only the ratio of the radii counts. DesignError: there is no optimum. With mu_e
    >= 1 the spring drives nothing back. With one friction zero eta only tends to 1 as lambda_i tend to 0 and
    90 deg.

    Notes
    -----
    For every load, and for mu_1 = mu_2 also for all radii (45 deg):

        mu_e^2 = (mu_1/r_1 + mu_2/r_2)/(1/(mu_1 r_1) + 1/(mu_2 r_2))
        tan lambda_i = mu_i/mu_e     eta = ((1 - mu_e)/(1 + mu_e))^2

    Source: docs/mechanism.md, section 8.

    Examples
    --------
    >>> import math
    >>> from dualcam.design import optimum
    >>> best = optimum((0.14, 0.10))
    >>> [round(math.degrees(angle), 2) for angle in best.lead_angle], round(best.efficiency, 4)  # deg, 1
    ([49.8, 40.2], 0.6216)
    """
    for name, pair in (("friction", friction), ("radius", radius)):
        if np.shape(pair) != (2,):
            raise DesignError(f"{name} = {pair!r}: allowed are two numbers")
    _check_ranges(friction, radius)
    (mu1, mu2), (r1, r2) = (tuple(map(float, pair)) for pair in (friction, radius))
    if mu1 == mu2 == 0.0:
        return BestLeadAngles((math.pi / 4, math.pi / 4), 1.0, 0.0)
    if mu1 == 0.0 or mu2 == 0.0:
        raise DesignError(
            f"friction = {(mu1, mu2)}: the efficiency tends to 1 as one lead angle tends to 0 and the other"
            " to 90 deg, and has no maximum: both must be > 0, or both 0"
        )
    mu = math.sqrt((mu1 / r1 + mu2 / r2) / (1.0 / (mu1 * r1) + 1.0 / (mu2 * r2)))
    if mu >= 1.0:
        raise DesignError(
            f"friction = {(mu1, mu2)} is like {mu:.6g} at both contacts: at every pair of lead angles one of"
            " them locks itself, or no torque loads; the mean must be < 1"
        )
    return BestLeadAngles((math.atan(mu1 / mu), math.atan(mu2 / mu)), ((1.0 - mu) / (1.0 + mu)) ** 2, mu)


@dataclass(frozen=True)
class EfficiencyMap:
    """Efficiency over both lead angles.

    `lead_angle`: lead angles of both axes [rad], shape (n,). `efficiency`: [i, j] at lambda_1 =
    lead_angle[j], lambda_2 = lead_angle[i], shape (n, n). `friction`, `radius`: coefficients of friction [1]
    and radii [m].
    """

    lead_angle: Array
    efficiency: Array
    friction: tuple[float, float]
    radius: tuple[float, float]

    def draw(self, axes: Axes) -> QuadContourSet:
        """Contours with the optimum, for `figure.colorbar`; grey where the spring cannot drive the cam back.

        `axes`: where the map is drawn.
        """
        degrees = np.degrees(self.lead_angle)
        driven = np.ma.masked_where(~(self.efficiency > 0.0), self.efficiency)
        axes.set_facecolor("0.85")
        try:
            best = optimum(self.friction, self.radius)
        except DesignError:  # there is none: the largest value of the map
            best = None
        highest = best.efficiency if best else float(driven.max()) if driven.count() else 1.0
        levels = np.linspace(0.0, highest, 13)
        filled = axes.contourf(degrees, degrees, driven, levels=levels, cmap="viridis", extend="max")
        axes.contour(degrees, degrees, driven, levels=levels, colors="w", linewidths=0.4)
        if best:
            first, second = np.degrees(best.lead_angle)
            axes.plot(first, second, "r+", ms=12, mew=2)
            text = f"{best.efficiency:.4f} at\n{first:.1f}, {second:.1f} deg"
            axes.annotate(text, (first, second), (7, 7), textcoords="offset points", color="w")
        axes.set_xlabel("lead angle of groove 1 [deg]")
        axes.set_ylabel("lead angle of groove 2 [deg]")
        return filled


def efficiency_map(
    friction: tuple[float, float], radius: tuple[float, float] = (1.0, 1.0), points: int = 201
) -> EfficiencyMap:
    """The efficiency over all lead angles, 0 and 90 deg left out.

    `friction`: coefficients of friction mu_1, mu_2 [1], >= 0. `radius`: radii r_1, r_2 [m], > 0. Only the
    ratio of the radii counts. `points`: lead angles on each axis, >= 2. DesignError: an argument outside its
    range.

    Examples
    --------
    >>> from dualcam.design import efficiency_map
    >>> chart = efficiency_map((0.14, 0.14), points=89)  # every degree
    >>> round(float(chart.efficiency[44, 44]), 4)  # at 45 deg, 45 deg
    0.5691
    """
    check_points(points, 2)
    angle = np.linspace(0.0, 0.5 * np.pi, points + 2)[1:-1]
    return EfficiencyMap(
        angle, efficiency((angle[None, :], angle[:, None]), friction, radius), friction, radius
    )


def check_points(points: object, least: int) -> None:
    """DesignError unless `points` is a whole number from `least` on."""
    if not is_whole(points) or points < least:
        raise DesignError(
            f"points = {points!r:.60}: allowed is a whole number, {least} or more: how many angles are taken"
        )
