"""The pairs of cams with the arcs assumed, and their statics by dualcam.design."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from case_studies.paper.published import (
    ARCS,
    CONTACTS,
    GREASES,
    INNER_RADIUS,
    LOADING,
    OUTER_RADIUS,
    PRELOAD,
    RANGE,
    RELEASING,
    TORQUE,
)
from dualcam.design import Ellipse, Mechanism, Spring
from dualcam.design.grooves import both_parameters
from dualcam.design.statics import Array, Transfer, transfer


def arc(radius: float, lead: float, size: float, bending: int = -1) -> Ellipse:
    """A groove that unwraps to an arc of a circle of radius `size` [m]: an ellipse with equal semi-axes."""
    return Ellipse(radius, lead, size, size, bending)


@dataclass(frozen=True)
class Pair:
    """Two cams and the spring. The torque does not depend on which of the cams turns."""

    inner: Ellipse
    outer: Ellipse
    preload: float = PRELOAD  # share of the force at the end of the range
    force: float = 1.0  # of the spring at the end of the range, N

    def scaled(self, torque: float = TORQUE) -> Pair:
        """With the spring that makes `torque` [N.m] the largest torque when loading with grease 1."""
        angle = np.linspace(0.0, RANGE, 141)
        return replace(self, force=self.force * torque / float(np.max(Statics(self, angle).torque(LOADING))))

    def mechanism(self, friction: float, spring: Spring) -> Mechanism:
        """The pair with this friction at both contacts and this spring."""
        return Mechanism((self.inner, self.outer), (friction, friction), spring, RANGE, CONTACTS)

    @cached_property
    def stroke(self) -> float:
        """Travel of the follower over the range [m]."""
        return float(self.mechanism(0.0, Spring(0.0, 0.0)).configuration(RANGE).z)

    @property
    def spring(self) -> Spring:
        """The spring whose force at the end of the range is `force`."""
        return Spring(self.preload * self.force, (1.0 - self.preload) * self.force / self.stroke)

    def parameters(self, friction: float) -> dict[str, float | int]:
        """Start values of the FMU."""
        return {
            **both_parameters((self.inner, self.outer)),
            "cam1.friction": friction,
            "cam2.friction": friction,
            "spring.preload": self.spring.preload,
            "spring.stiffness": self.spring.stiffness,
            "inertia.shaft": 0.0,
            "stop.upper": RANGE,
        }


class Statics:
    """Kinematics and statics of a pair at angles [rad] of the turning cam, shape (n,), by formula."""

    def __init__(self, pair: Pair, angle: Array) -> None:
        self.cams = (pair.inner, pair.outer)
        self.radii = (pair.inner.radius, pair.outer.radius)
        configuration = pair.mechanism(0.0, pair.spring).configuration(angle)
        self._slopes = configuration.slope  # m/rad, shape (2, n)
        self.slopes = tuple(configuration.slope / np.array(self.radii)[:, None])  # tangents of lead angles
        self.spring = pair.spring.force(configuration.z)  # N

    def _transfer(self, direction: int, friction: tuple[Array | float, ...]) -> Transfer:
        """With friction of both contacts (one number: of each; none: grease 1)."""
        first = friction[0] if friction else GREASES[0]
        second = friction[1] if len(friction) > 1 else first
        return transfer(self._slopes, (first, second), self.radii, direction)

    def torque(self, direction: int, *friction: Array | float) -> Array:
        """Torque at the turning cam [N.m], shape (n,)."""
        return self._transfer(direction, friction).rho * self.spring

    def reactions(self, direction: int, *friction: Array | float) -> tuple[Array, Array]:
        """Normal reaction at each contact of cam 1 and cam 2 [N], shape (n,) each."""
        first, second = self._transfer(direction, friction).reaction * self.spring / CONTACTS
        return first, second

    def nominal_loads(self) -> tuple[Array, Array]:
        """Normal reaction at each contact without friction [N], shape (n,) each."""
        return self.reactions(LOADING, 0.0)

    def sliding(self, speed: float) -> tuple[Array, Array]:
        """Sliding speed at cam 1 and cam 2 [m/s], shape (n,) each, at `speed` [rad/s] of the turning cam."""
        a1, a2 = self._slopes
        turns = a2 / (a1 + a2), a1 / (a1 + a2)  # of the pin along each groove, per turn of the cam
        first, second = (
            abs(speed) * turn * radius * np.hypot(1.0, slope)
            for turn, radius, slope in zip(turns, self.radii, self.slopes, strict=True)
        )
        return first, second

    def band(self, friction: float) -> Array:
        """Width of the stick band [N.m], shape (n,)."""
        return self.torque(LOADING, friction) - self.torque(RELEASING, friction)


def pair(name: str) -> Pair:
    """Pair A or B, with the assumed values."""
    lead, inner, outer = ARCS[name]
    return Pair(arc(INNER_RADIUS, lead, inner), arc(OUTER_RADIUS, lead, outer)).scaled()


def other_pairs(name: str, count: int, seed: int = 1) -> Iterator[Pair]:
    """Pairs that the published facts allow as well: start angle of the inner cam, an outer arc smaller (A) or
    larger (B) than the inner one. All else is drawn; torque still reaches 10 N.m."""
    random = np.random.default_rng(seed)
    found = 0
    while found < count:
        radii = random.uniform(0.010, 0.030, 2)
        inner = random.uniform(0.04, 0.20)
        ratio = random.uniform(0.4, 1.0) if name == "A" else random.uniform(1.0, 2.5)
        bending = random.choice([-1, 1], 2)
        lead, outer_lead, preload = ARCS[name][0], random.uniform(0.6, 0.95), random.uniform(0.0, 0.6)
        first = arc(float(radii[0]), lead, float(inner), int(bending[0]))
        second = arc(float(radii[1]), float(outer_lead), float(inner * ratio), int(bending[1]))
        if all(_usable(groove) for groove in (first, second)):
            found += 1
            yield Pair(first, second, float(preload)).scaled()


def _usable(groove: Ellipse) -> bool:
    """Whether all lead angles that the pin can reach are between 15 and 70 degrees."""
    end = math.sin(groove.lead_angle) + groove.bending * groove.radius * RANGE / groove.a
    return math.sin(math.radians(15.0)) < end < math.sin(math.radians(70.0))
