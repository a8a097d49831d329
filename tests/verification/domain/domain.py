"""The class of a design by docs/mechanism.md, section 3: corners of D, sampled between the stops."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from .mechanics import Mechanism, Place

UNIQUE, SELF_LOCKING, REFUSED = "unique", "self-locking", "refused"
SAMPLES = 201
SAMPLES_OF_HELICES = 9  # their slopes are the same everywhere; the load is not
BORDER = 1e-6  # relative; a design nearer to the border of a class belongs to either


class Verdict(NamedTuple):
    kind: str
    border: bool  # near another class, or so only between some angles
    reason: str


def classify(params: Mapping[str, Any], f_ext: float) -> Verdict:
    """The class under F_ext's start value, N."""
    mech = Mechanism(params)
    if not mech.inertial and any(law.varies_with_speed for law in mech.laws):
        return Verdict(REFUSED, False, "friction that varies with the speed, without inertia")
    samples = SAMPLES_OF_HELICES if mech.helical else SAMPLES
    places = [mech.at(theta) for theta in np.linspace(mech.lower, mech.upper, samples).tolist()]
    if any(k.a1 + k.a2 < 1e-9 * (mech.r1 + mech.r2) for k in places):
        return Verdict(REFUSED, False, "both grooves dwell")
    mu = _largest_coefficients(mech, places, f_ext)
    corners = [_worst_corner(mech, k, mu) for k in places]
    refused = _refusal(mech, places, f_ext, mu)
    if refused is not None:
        return refused
    worst = min(corners)
    return Verdict(UNIQUE if worst > 0 else SELF_LOCKING, abs(worst) < BORDER, "corner of D")


def _largest_coefficients(mech: Mechanism, places: list[Place], f_ext: float) -> tuple[float, float]:
    """mu_1 and mu_2 at rest, the largest between the stops."""
    found = [mech.friction(k, 0.0, mech.spring_force(k.z) + f_ext) for k in places]
    return max(first for first, _ in found), max(second for _, second in found)


def _worst_corner(mech: Mechanism, k: Place, mu: tuple[float, float]) -> float:
    """The smallest of D, relative to the sum of the sizes of its terms."""
    return min(
        _relative(mech, k, g * mu[0], h * mu[1], parts)
        for parts in _kinds_of_inertia(mech)
        for g in (1, -1)
        for h in (1, -1)
    )


def _kinds_of_inertia(mech: Mechanism) -> list[tuple[float, float, float]]:
    """(J, m, I), or what takes their place without inertia: dampers at no speed and at a high one, or the
    factor of Delta alone."""
    if mech.inertial:
        return [(mech.J, mech.m, mech.I)]
    if not mech.damped:
        return [(1.0, 0.0, 0.0)]
    ways = mech.damper.values()
    return [(mech.b, c, 0.0) for c, _ in ways if mech.b + c > 0] + [(0.0, q, 0.0) for _, q in ways if q > 0]


def _relative(mech: Mechanism, k: Place, f1: float, f2: float, parts: tuple[float, float, float]) -> float:
    each = [tuple(part if i == j else 0.0 for j in range(3)) for i, part in enumerate(parts)]
    size = sum(abs(mech.inertia(k, f1, f2, (one[0], one[1], one[2]))) for one in each)
    return mech.inertia(k, f1, f2, parts) / size if size > 0 else 0.0


def _refusal(mech: Mechanism, places: list[Place], f_ext: float, mu: tuple[float, float]) -> Verdict | None:
    loading = [mech.corner(k, *mu)[4] / (mech.r1 * mech.r2 * (k.a1 + k.a2 + mech.r1)) for k in places]
    if min(loading) <= BORDER:
        return Verdict(REFUSED, abs(min(loading)) <= BORDER, "no pair loads the mechanism")
    if not (mech.inertial or mech.damped):
        return None
    shares = [share for k in places if (share := _releasing_share(mech, k, f_ext)) is not None]
    if shares and min(shares) <= BORDER:
        somewhere = len(shares) < len(places) or max(shares) > 0
        return Verdict(REFUSED, somewhere, "the releasing pair resists no motion")
    return None


def _releasing_share(mech: Mechanism, k: Place, f_ext: float) -> float | None:
    """D/Delta of the pair that releases, relative to its terms."""
    f0 = mech.spring_force(k.z) + f_ext
    edge = mech.edge_pair(k, -1 if f0 >= 0 else 1, f0)
    if edge is None:
        return None
    sigma, (e1, e2) = (-1 if f0 >= 0 else 1), edge[0]
    mu1, mu2 = mech.friction(k, 0.0, f0)
    f1, f2 = sigma * e1 * mu1, sigma * e2 * mu2
    delta = mech.corner(k, f1, f2)[4]
    c, q = mech.damper[sigma]
    slow = mech.b, c or q, 0.0  # without inertia; quadratic damping resists from the first speed on
    parts = (mech.J, mech.m, mech.I) if mech.inertial else slow
    return _relative(mech, k, f1, f2, parts) * (1 if delta > 0 else -1)
