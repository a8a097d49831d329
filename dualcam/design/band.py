"""The torque band of slow motion over the whole range of angles (docs/mechanism.md, section 3)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dualcam.design.mechanism import Mechanism
from dualcam.design.statics import Array, check_points

NOT_LOCKING = "without torque the spring turns the cam back, a torque inside the band holds it"
LOCKING = "there the spring cannot turn the cam back"


@dataclass(frozen=True, eq=False)
class TorqueBand:
    """The torque band of slow motion over the angle.

    Attributes
    ----------
    theta : Angle of cam 2 [rad], shape (n,).
    z : Displacement of the follower [m].
    release, load
        Edges of the stick band [N.m]: below `release` the cam releases, above `load` the cam loads. Infinite
        `load`: friction jams the mechanism.
    efficiency
        Torque given back over torque to load, at the same angle; below 0 where the mechanism locks itself.
    frictionless : Torque of the same grooves without friction [N.m].
    lead_angle : Of both grooves at the pin [rad], shape (2, n).
    """

    theta: Array
    z: Array
    release: Array
    load: Array
    efficiency: Array
    frictionless: Array
    lead_angle: Array

    @property
    def self_locking(self) -> bool:
        """Whether the spring cannot drive the cam back at some angle."""
        return bool((self.efficiency <= 0.0).any())

    @property
    def locked(self) -> tuple[tuple[float, float], ...]:
        """Ranges of theta [rad] in which the spring cannot drive the cam back, in order.

        A border between two samples is where the efficiency is 0 on the straight line through both.
        """
        is_locked = np.concatenate([[False], self.efficiency <= 0.0, [False]]).astype(int)
        change = np.diff(is_locked)
        firsts, lasts = np.flatnonzero(change == 1), np.flatnonzero(change == -1) - 1
        pairs = zip(firsts.tolist(), lasts.tolist(), strict=True)
        return tuple((self._border(first, first - 1), self._border(last, last + 1)) for first, last in pairs)

    def _border(self, inner: int, outer: int) -> float:
        """The angle [rad] of efficiency 0 between both samples; that of the inner one where none is known."""
        is_sample = 0 <= outer < len(self.theta)
        if not is_sample or not np.isfinite(self.efficiency[[inner, outer]]).all():
            return float(self.theta[inner])
        (begin, end), (low, high) = self.theta[[inner, outer]], self.efficiency[[inner, outer]]
        return float(begin + (end - begin) * low / (low - high))

    @property
    def jams(self) -> bool:
        """Whether no torque loads the mechanism at some angle. The FMU refuses such a mechanism."""
        return bool(np.isinf(self.load).any())

    def __str__(self) -> str:
        lines = [
            f"slow loading takes {span(self.load)} N.m, slow releasing gives {span(self.release)} N.m back,"
            f" without friction both are {span(self.frictionless)} N.m",
            f"efficiency (releasing over loading) {span(self.efficiency)}",
        ]
        if self.self_locking:
            lines.append(f"self-locking {range_words(self.locked, 'rad')}: {LOCKING}")
        else:
            lines.append(f"not self-locking: {NOT_LOCKING}")
        if self.jams:
            at = self.theta[np.isinf(self.load)][0]
            lines.append(f"jams when loading from theta = {at:.4g} rad on: the FMU refuses this mechanism")
        return "\n".join(lines)


def span(values: Array) -> str:
    """Least and largest value in words; gaps do not count."""
    known = values[~np.isnan(values)]
    if not len(known):
        return "unknown"
    low, high = (f"{float(end):.4g}" for end in (known.min(), known.max()))
    return low if low == high else f"{low} to {high}"


def range_words(ranges: Sequence[tuple[float, float]], unit: str) -> str:
    """Ranges of theta [rad] in `unit`, to 0.01 deg or 0.0001 rad: "from theta = 0 to 4.31 deg and ..."."""
    found: list[str] = []
    for ends in ranges:
        rounded = (round(math.degrees(end), 2) if unit == "deg" else round(end, 4) for end in ends)
        low, high = (f"{end:g}" for end in rounded)
        name = "" if found else "theta = "
        found.append(f"at {name}{low} {unit}" if low == high else f"from {name}{low} to {high} {unit}")
    return " and ".join(found)


def locking_words(locked: Sequence[tuple[float, float]]) -> str:
    """Whether and where the mechanism locks itself; `locked`: ranges of theta [rad]."""
    return f"yes, {range_words(locked, 'deg')}: {LOCKING}" if locked else f"no, {NOT_LOCKING}"


def torque_band(mechanism: Mechanism, points: int = 181) -> TorqueBand:
    """The torque band at `points` angles evenly over the mechanism's range.

    `mechanism`: grooves, friction, spring and range. `points`: number of angles, 2 or more. DesignError:
    `points` is no whole number, or below 2.
    """
    check_points(points, 2)
    theta = mechanism.angles(points)
    configuration = mechanism.configuration(theta)
    force = mechanism.spring.force(configuration.z)
    (release_arm, load_arm), _ = mechanism.edges(configuration.slope, force)
    with np.errstate(divide="ignore", invalid="ignore"):
        efficiency = np.where(np.isfinite(load_arm), release_arm / load_arm, np.nan)
        release, load = release_arm * force, load_arm * force
    lead = np.arctan(configuration.slope / np.array(mechanism.radius)[:, None])
    frictionless = mechanism.torque(theta, "frictionless")
    return TorqueBand(theta, configuration.z, release, load, efficiency, frictionless, lead)
