"""Wear of grooves and pin by Archard's law, and what wear changes: preload and torque.

One cycle is a slow move from the lower stop to the upper one and back, without external force; its loads are
those of the new mechanism. docs/design-quantities.md derives, with the specific wear rate K, N the load and L
the width of the pin:

    depth of a groove  K N/L in each pass of the pin, normal to the flank; lowered by h/cos(lambda)
    flat of a pin      h = (3 V/(4 L sqrt(2 R)))^(2/3) from the lost volume V; R the least relative radius
    a pin that turns   h = V/(2 pi r L)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from dualcam.design.hertz import Pin, relative_radius
from dualcam.design.mechanism import POINTS, Mechanism, check_pair
from dualcam.design.statics import Array, check_points
from dualcam.errors import DesignError

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

LARGEST_DEPTH = 0.25  # of the pin's radius: deeper wear changes the contact too much for these formulas
SAME_PLACE = 1e-12  # rad: a pin that moves less along a groove stands still
NEWTON_STEPS = 40


@dataclass(frozen=True)
class WearLife:
    """Cycles until the wear has an allowed depth.

    `groove1`, `groove2`, `pin`: cycles of each part; infinite for a part that does not wear.
    """

    groove1: float
    groove2: float
    pin: float

    @property
    def cycles(self) -> float:
        """The least number of cycles."""
        return min(self.groove1, self.groove2, self.pin)

    @property
    def part(self) -> str:
        """The part that first has the allowed depth."""
        return min(("groove 1", self.groove1), ("groove 2", self.groove2), ("pin", self.pin), key=_second)[0]


def _second(pair: tuple[str, float]) -> float:
    return pair[1]


@dataclass(frozen=True, eq=False)
class WornMechanism:
    """The mechanism after a number of cycles, at angles theta of shape (n,).

    Attributes
    ----------
    cycles : The number of cycles.
    theta : Angle of cam 2 [rad].
    drop : Way by which the follower stands lower than when new [m].
    force_loss : Force that the spring has lost [N].
    preload_loss : The same at theta = 0 [N].
    release, load : Edges of the stick band [N.m].
    new_release, new_load : Edges of the stick band of the new mechanism [N.m].
    """

    cycles: float
    theta: Array
    drop: Array
    force_loss: Array
    preload_loss: float
    release: Array
    load: Array
    new_release: Array
    new_load: Array

    @property
    def load_loss(self) -> Array:
        """Torque to load that is lost, as a share of that of the new mechanism [1], shape (n,)."""
        return 1.0 - self.load / self.new_load

    @property
    def release_loss(self) -> Array:
        """The same of the torque that releasing gives back, shape (n,); NaN where the new mechanism locks
        itself."""
        gives = self.new_release > 0.0
        return np.where(gives, 1.0 - self.release / np.where(gives, self.new_release, 1.0), np.nan)


@dataclass(frozen=True, eq=False)
class Wear:
    """Wear of one cycle; pairs have shape (2, n), for groove 1 and groove 2.

    Attributes
    ----------
    mechanism : Mechanism
    pin : Pin
    turns : Whether the pin turns while it moves along the groove.
    theta : Angle of cam 2 [rad], shape (n,).
    psi : Place of the pin along each groove [rad], shape (2, n).
    depth
        Depth that the flank which supports the spring loses in a cycle [m], shape (2, n), normal to the
        flank.
    other_depth
        The same of the other flank, shape (2, n). The pin bears on that flank only while a self-locking cam
        releases.
    path : Sliding distance along each groove in a cycle [m], shape (2,).
    volume : Volume that each groove loses in a cycle [m3], of one contact, shape (2,).
    pin_volume : Volume that the pin loses in a cycle [m3], of one contact, shape (2,).
    """

    mechanism: Mechanism
    pin: Pin
    turns: bool
    theta: Array
    psi: Array
    depth: Array
    other_depth: Array
    path: Array
    volume: Array
    pin_volume: Array

    @property
    def largest(self) -> Array:
        """Largest depth of each groove in a cycle [m], shape (2,)."""
        return np.asarray(np.maximum(self.depth, self.other_depth).max(axis=1))

    def pin_depth(self, cycles: float) -> Array:
        """Depth of wear on the pin in grooves 1 and 2 [m], shape (2,), after a number of `cycles`, >= 0."""
        area = _count(cycles) * self.pin_volume / self.pin.width
        if self.turns:
            return np.asarray(area / (2.0 * math.pi * self.pin.radius))
        return np.asarray((3.0 * area / (4.0 * np.sqrt(2.0 * self._flat_radius))) ** (2.0 / 3.0))

    def life(self, allowed: float) -> WearLife:
        """Cycles until a part has the allowed depth of wear.

        `allowed` depth normal to the surface [m], > 0, of each groove and of the pin. DesignError: a depth
        that is not above 0.
        """
        if not 0.0 < allowed < math.inf:
            raise DesignError(f"allowed depth = {allowed}: allowed is a finite number > 0 in m")
        if self.turns:
            volume = np.full(2, 2.0 * math.pi * self.pin.radius * self.pin.width * allowed)
        else:
            flat = 4.0 / 3.0 * allowed * np.sqrt(2.0 * self._flat_radius * allowed)
            volume = self.pin.width * flat
        grooves, pin = _cycles(np.full(2, allowed), self.largest), _cycles(volume, self.pin_volume)
        return WearLife(float(grooves[0]), float(grooves[1]), float(pin.min()))

    def after(self, cycles: float) -> WornMechanism:
        """The mechanism after a number of `cycles`, >= 0: lost preload, and torque.

        It has the wear of the flanks that support the spring, and of the pin.

        DesignError: so many cycles that the wear is deeper than a quarter of the pin's radius, or that the
        spring is slack.

        Examples
        --------
        By hand, as in `wear`: at theta = 0 both grooves lose 1e6 * 1e-15 * 36.06/0.008 = 4.508 um, along the
        axis 4.508/cos(45 deg) = 6.375 um. The follower sinks by as much: 50e3 * 6.375e-6 = 0.3187 N.

        >>> import math
        >>> from dualcam.design import Helix, Mechanism, Pin, Spring, wear
        >>> groove = Helix(radius=0.02, lead_angle=math.pi / 4)
        >>> cam = Mechanism((groove, groove), (0.14, 0.14), Spring(50.0, 5e4), upper=1.3963)
        >>> worn = wear(cam, Pin(radius=0.003, width=0.008), (1e-15, 1e-15)).after(1e6)
        >>> round(worn.preload_loss, 4)  # N
        0.3187
        """
        limit = LARGEST_DEPTH * self.pin.radius
        depth = max(float((_count(cycles) * self.largest).max()), float(self.pin_depth(cycles).max()))
        if depth > limit:
            raise DesignError(
                f"cycles = {cycles:.6g}: the wear is {1e3 * depth:.4g} mm deep; allowed is up to a quarter of"
                f" the pin's radius, {1e3 * limit:.4g} mm"
            )
        return _worn(self, float(cycles))

    @cached_property
    def _flat_radius(self) -> Array:
        """Least relative radius of pin and supporting flank in each groove [m], shape (2,)."""
        radius = relative_radius(self.pin, self.mechanism.curvature(self.theta))
        return np.asarray(radius.min(axis=1))


def wear(
    mechanism: Mechanism, pin: Pin, rates: Sequence[float], turns: bool = False, points: int = POINTS
) -> Wear:
    """Wear of grooves and pin of a `mechanism` in one slow cycle, from the lower stop to the upper and back.

    `pin`: with the specific wear rate of the pin, `pin.wear`. `rates`: specific wear rates of groove 1 and
    groove 2 [m3/(N.m)], >= 0, shape (2,): the FMU's `cam1.wear`, `cam2.wear`. `turns`: whether the pin turns
    in the groove, as a roller does. Then the pin wears all around. `points`: angles, evenly over the range,
    >= 5. DesignError: rates that are negative, too few points, an undercut flank, or grooves
    that are level together. Source: the formulas at the head of this file.

    Examples
    --------
    By hand: two helices of 45 deg, r = 20 mm, mu = 0.14, loading at theta = 1.3963 rad. z = 13.963 mm, so
    F = 50 + 698.15 = 748.15 N, N = F/2 / sqrt(2) / (1 - mu) / 2 per contact
    = 748.15/4 * 1.4142/0.86 = 307.57 N; releasing N = 748.15/4 * 1.4142/1.14 = 232.03 N. A place there
    loses 1e-15 * 539.6/0.008 = 6.745e-11 m in a cycle.

    >>> import math
    >>> from dualcam.design import Helix, Mechanism, Pin, Spring, wear
    >>> groove = Helix(radius=0.02, lead_angle=math.pi / 4)
    >>> cam = Mechanism((groove, groove), (0.14, 0.14), Spring(50.0, 5e4), upper=1.3963)
    >>> found = wear(cam, Pin(radius=0.003, width=0.008), (1e-15, 1e-15))
    >>> round(1e12 * float(found.depth[0, -1]), 2)  # pm per cycle
    67.45
    >>> round(found.life(0.1e-3).cycles)  # until 0.1 mm, near the upper stop
    1482585
    """
    from scipy.integrate import simpson

    first, second = check_pair("wear rates", rates, 0.0)
    check_points(points, 5)
    theta = np.linspace(*mechanism.reach(), points)
    configuration = mechanism.configuration(theta)
    radius = np.array(mechanism.radius)[:, None]
    if not (relative_radius(pin, mechanism.curvature(theta)) > 0.0).all():
        raise DesignError(f"pin.radius = {pin.radius:g} m: a flank is undercut; allowed is a thinner pin")
    load = _loads(mechanism, configuration.slope, mechanism.spring.force(configuration.z))
    rate = np.array([first, second])[:, None]
    supporting, other = (np.maximum(sign * load, 0.0).sum(axis=0) / pin.width for sign in (1.0, -1.0))
    a1, a2 = configuration.slope
    if not (a1 + a2 > 0.0).all():
        raise DesignError(
            "both grooves are level at one angle: there the motion of the pin is not determined"
        )
    # sliding distance over theta [m/rad]
    travel = np.stack([a2, a1]) / (a1 + a2) * np.hypot(radius, configuration.slope)
    work = simpson(np.abs(load).sum(axis=0) * travel, x=theta, axis=1)  # N.m
    return Wear(
        mechanism,
        pin,
        turns,
        theta,
        configuration.psi,
        rate * supporting,
        rate * other,
        2.0 * simpson(travel, x=theta, axis=1),
        rate[:, 0] * work,
        pin.wear * work,
    )


def _loads(mechanism: Mechanism, slope: Array, force: Array) -> Array:
    """Normal force of one contact [releasing or loading, groove, theta], negative on the other flank [N]; 0
    where no torque moves the cam in that direction."""
    _, reaction = mechanism.edges(slope, force)
    found = np.asarray(reaction)
    return np.where(np.isfinite(found), found, 0.0) * force / mechanism.contacts


def _count(cycles: float) -> float:
    if not 0.0 <= cycles < math.inf:
        raise DesignError(f"cycles = {cycles}: allowed is a finite number >= 0")
    return cycles


def _cycles(allowed: Array, each: Array) -> Array:
    """How often the amount `each` fits into `allowed`; infinite where nothing wears."""
    with np.errstate(over="ignore"):  # hardly any wear: more cycles than a number can hold
        return np.where(each > 0.0, allowed / np.where(each > 0.0, each, 1.0), np.inf)


# ---- the worn mechanism ----


def _worn(wear: Wear, cycles: float) -> WornMechanism:
    mechanism, theta = wear.mechanism, wear.theta
    fresh = mechanism.configuration(theta)
    radius = np.array(mechanism.radius)[:, None]
    depth = cycles * wear.depth + wear.pin_depth(cycles)[:, None]
    sunk = depth * np.hypot(radius, fresh.slope) / radius  # along the axis: over cos(lambda)
    lowered = [_lowering(psi, way) for psi, way in zip(fresh.psi, sunk, strict=True)]
    angles = np.append(theta, 0.0)  # the preload is that at theta = 0
    z, slope = _meeting(mechanism, lowered, angles)
    drop = mechanism.configuration(angles).z - z
    force, before = mechanism.spring.force(z), mechanism.spring.force(z + drop)
    if not (force[:-1] > 0.0).all():
        raise DesignError(f"cycles = {cycles:.6g}: the spring is slack; allowed are fewer cycles")
    edges = mechanism.edges(slope[:, :-1], force[:-1])[0]
    old = mechanism.edges(fresh.slope, before[:-1])[0]
    (release, load), (new_release, new_load) = (
        tuple(edge * newton for edge in pair) for pair, newton in ((edges, force[:-1]), (old, before[:-1]))
    )
    lost = before - force
    return WornMechanism(
        cycles, theta, drop[:-1], lost[:-1], float(lost[-1]), release, load, new_release, new_load
    )


def _lowering(psi: Array, way: Array) -> CubicSpline:
    """Way along the axis by which a groove is lowered, over psi; the same beyond the ends."""
    from scipy.interpolate import CubicSpline

    places = np.concatenate([[True], np.diff(psi) > SAME_PLACE])
    if places.sum() < 4:
        return CubicSpline([0.0, 1.0], [way.max()] * 2)  # the pin stands still in this groove
    return CubicSpline(psi[places], way[places])


def _meeting(mechanism: Mechanism, lowered: Sequence[CubicSpline], theta: Array) -> tuple[Array, Array]:
    """Height of the pin [m], and slopes of the worn grooves [m/rad], by Newton's method from the new ones."""

    def worn(i: int, psi: Array) -> tuple[Array, Array]:
        spline, point = lowered[i], mechanism.grooves[i].at(psi)
        inside = np.clip(psi, spline.x[0], spline.x[-1])
        return point.z - spline(inside), point.slope - np.where(inside == psi, spline(psi, 1), 0.0)

    gamma = mechanism.configuration(theta).psi[0]
    for _ in range(NEWTON_STEPS):
        (z1, a1), (z2, a2) = worn(0, gamma), worn(1, theta - gamma)
        if not (a1 + a2 > 0.0).all():
            raise DesignError("the wear makes both grooves level at one place; allowed are fewer cycles")
        step = (z2 - z1) / (a1 + a2)
        gamma = gamma + step
        if np.abs(step).max() <= 1e-14:
            break
    (z, slope1), (_, slope2) = worn(0, gamma), worn(1, theta - gamma)
    return z, np.stack([slope1, slope2])
