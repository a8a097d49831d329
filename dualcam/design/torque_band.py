"""The torque band of slow motion over the whole range of angles (docs/mechanism.md, section 3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dualcam.design.mechanism import Mechanism
from dualcam.design.statics import Array, band
from dualcam.errors import DesignError


@dataclass(frozen=True, eq=False)
class TorqueBand:
    """The torque band of slow motion over the angle.

    Attributes
    ----------
    theta
        Angle of cam 2 [rad], shape (n,).
    z
        Displacement of the follower [m].
    release, load
        Edges of the stick band [N.m]: below `release` the cam releases, above `load` the cam loads. Infinite
        `load`: friction jams the mechanism.
    efficiency
        Torque given back over torque to load, at the same angle; below 0 where the mechanism locks itself.
    lead_angle
        Of both grooves at the pin [rad], shape (2, n).
    """

    theta: Array
    z: Array
    release: Array
    load: Array
    efficiency: Array
    lead_angle: Array

    @property
    def self_locking(self) -> bool:
        """Whether the spring cannot drive the cam back at some angle."""
        return bool((self.efficiency <= 0.0).any())


def torque_band(mechanism: Mechanism, points: int = 181, lower: float = 0.0) -> TorqueBand:
    """The torque band at `points` angles evenly from `lower` to the mechanism's upper stop [rad].

    Parameters
    ----------
    mechanism
        Grooves, friction, spring and range.
    points
        Number of angles, 2 or more.
    lower
        Lowest angle [rad].

    Raises
    ------
    DesignError
        For fewer than 2 points.
    """
    if points < 2:
        raise DesignError(f"points = {points}: allowed is 2 or more")
    theta = np.linspace(lower, mechanism.upper, points)
    configuration = mechanism.configuration(theta)
    (release_arm, load_arm), _ = band(configuration.slope, mechanism.friction, mechanism.radius)
    force = mechanism.spring.force(configuration.z)
    with np.errstate(divide="ignore", invalid="ignore"):
        efficiency = np.where(np.isfinite(load_arm), release_arm / load_arm, np.nan)
        release, load = release_arm * force, load_arm * force
    lead = np.arctan(configuration.slope / np.array(mechanism.radius)[:, None])
    return TorqueBand(theta, configuration.z, release, load, efficiency, lead)
