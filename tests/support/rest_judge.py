"""May the mechanism rest where the FMU rests? The judge of tests/test_properties.py.

Edges of the stick band and motions by trial of the pairs of flanks, from docs/mechanism.md and the
reference. The geometry is that of the reference.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from driver import Driver
from reference import LOWER_STOP, STICK, UPPER_STOP, Slip

EPS = 2.0**-52
TOLERANCE = 1e-9  # the FMU's, where none is given
# J or N.m. Below 1e-300 numbers have no digits left to lose, and products of small ones get there: an account
# of 1e-242 J is nothing, whatever share of it is missing.
NOTHING = 1e-200
SLOPE_KNOWN = 1e-13  # share of the steepest slope between the stops: the allowed error of the transmission


def band(r, a, mu, force):
    """Both edges of the stick band, from docs/mechanism.md: by trial of the pairs of flanks, those that the
    force rests on first."""
    s = math.copysign(1.0, force)
    edges = []
    for way in (-1, 1):
        found = way * math.inf
        for e in ((s, s), (s, -s), (-s, s), (-s, -s))[: 1 if way * s > 0 else 4]:
            n = [a[i] + way * e[i] * mu[i] * r[i] for i in (0, 1)]
            d = [r[i] - way * e[i] * mu[i] * a[i] for i in (0, 1)]
            delta = r[1] * d[0] * n[1] + r[0] * d[1] * n[0]
            if delta == 0.0:
                continue
            x = [force * r[1 - i] * n[1 - i] / delta for i in (0, 1)]
            if all(e[i] * x[i] >= 0.0 or mu[i] == 0.0 for i in (0, 1)):
                found = r[1] * n[1] * x[1]
                break
        edges.append(found)
    return edges


def pair_agrees(parameters, a, mu, tau, force, way, flank) -> bool:
    """Does the pair of flanks let slip begin at rest in the direction `way`? docs/mechanism.md, section 3:
    y_i = r_i x_i and alpha from two torques and one axial force; alpha points along `way`, the inertia felt
    is positive (section 6), and each y_i presses its own flank, to rounding."""
    r = [parameters[f"cam{i}.radius"] for i in (1, 2)]
    J, m, inertia = (parameters[f"inertia.{name}"] for name in ("shaft", "follower_mass", "follower"))
    gamma, lift = a[1] / (a[0] + a[1]), a[0] * a[1] / (a[0] + a[1])
    n = [a[i] + way * flank[i] * mu[i] * r[i] for i in (0, 1)]
    d = [(r[i] - way * flank[i] * mu[i] * a[i]) / r[i] for i in (0, 1)]
    by_alpha = d[0] * (J + inertia * gamma) * n[1] + d[1] * J * n[0] + m * lift * n[0] * n[1]
    delta = d[0] * n[1] + d[1] * n[0]  # over r_1 r_2
    alpha = (delta * tau - force * n[0] * n[1]) / by_alpha if by_alpha * delta > 0.0 else math.nan
    y = (
        [(tau - (J + inertia * gamma) * alpha) / n[0], (tau - J * alpha) / n[1]]
        if n[0] * n[1]
        else [0.0, 0.0]
    )
    size = abs(force) + abs(m * lift * alpha) + sum(abs(d[i] * y[i]) for i in (0, 1))
    return way * alpha > 0.0 and all(flank[i] * y[i] > TOLERANCE * size or not mu[i] for i in (0, 1))


def wedges(parameters, a, mu, tau, force) -> bool:
    """Beyond a finite edge of the band: rigid bodies under Coulomb friction have no motion where no pair of
    flanks agrees with its own forces (P. Painleve, 1895)."""
    if not any(parameters[f"inertia.{name}"] for name in ("shaft", "follower_mass", "follower")):
        return False
    pairs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    return not any(pair_agrees(parameters, a, mu, tau, force, way, pair) for way in (1, -1) for pair in pairs)


@lru_cache(maxsize=1)
def steepest_slope(mechanism) -> float:
    """m/rad, of both grooves between the stops, from samples."""
    places = [mechanism.groove.at(theta) for theta in np.linspace(mechanism.lower, mechanism.upper, 201)]
    return max(max(kin.a1, kin.a2) for kin in places)


def rests(fmu: Driver, mechanism, parameters) -> bool:
    """May it stand still there? The geometry is that of the reference."""
    tau, theta, mode = (fmu.get(name) for name in ("tau", "theta", "mode"))
    k = [parameters[f"spring.{name}"] for name in ("preload", "stiffness", "stiffness2", "stiffness3")]
    kin = mechanism.groove.at(theta)
    z, a = kin.z, [kin.a1, kin.a2]
    pull = fmu.get("F_ext")
    terms = [pull, *(c * z**i for i, c in enumerate(k))]
    force, size = math.fsum(terms), sum(map(abs, terms))
    r = [parameters[f"cam{i}.radius"] for i in (1, 2)]
    mu = mechanism.friction(kin, Slip(1, (1, 1)), 0.0, force)

    def edges(force, steeper=0.0, angle=theta):
        here = mechanism.groove.at(angle)
        rubbed = mechanism.friction(here, Slip(1, (1, 1)), 0.0, force)
        return band(r, [slope + steeper for slope in (here.a1, here.a2)], rubbed, force)

    # z is known to 1e-13 of the whole way. The tie is twice that, for the edge and the frictionless torque.
    # That matters where the force is small.
    doubt = 4e-13 * mechanism.reach
    noise = sum(abs(c) * ((abs(z) + doubt) ** i - abs(z) ** i) for i, c in enumerate(k))
    # contacts that lock under one sign of F_0 may not under the other one
    least = 4 * EPS * size + noise
    forces = [force] if abs(force) > least else [force, least, -least]
    releases, loadings = zip(*map(edges, forces), strict=True)
    release, load = max(releases), min(loadings)
    ratio = max((abs(edge) for edge in band(r, a, mu, size) if math.isfinite(edge)), default=0.0)
    rounding = TOLERANCE * (abs(tau) + ratio + a[0] * a[1] / (a[0] + a[1]) * size) + NOTHING
    rounding += 1e-15 * max(r) * size  # a groove that is level there is so to its digits
    reach = max((abs(edge) for edge in band(r, a, mu, 1.0) if math.isfinite(edge)), default=0.0)
    rounding += (reach + max(r)) * noise
    # where contacts lock, and at the end of a dwell, where one contact carries nothing and wedges as soon as
    # the other groove rises, the digits of a slope decide
    known = SLOPE_KNOWN * max(*a, steepest_slope(mechanism))
    stops = mechanism.lower, mechanism.upper

    def beside(share, axial):
        shift = share * max(map(abs, stops))
        places = [min(max(theta + way * shift, stops[0]), stops[1]) for way in (-1, 1)]
        return [edges(axial(place), 0.0, place) for place in places]

    if mode == STICK:
        # theta is known to a rounding of the farther stop: at the end of a dwell that makes a slope, or none
        near = beside(4 * EPS, lambda _: force) + [edges(force, way * known) for way in (-1, 1)]
        lowest, highest = min(edge[0] for edge in near), max(edge[1] for edge in near)
        return min(lowest, *releases) - rounding <= tau <= max(highest, *loadings) + rounding
    if mode == LOWER_STOP:
        return theta == stops[0] and tau <= release + rounding
    if mode == UPPER_STOP:
        return theta == stops[1] and tau >= load - rounding
    # theta is known to a rounding of the farther stop: so near a stop, the stop holds the torque toward it
    angle = 4 * EPS * max(map(abs, stops))
    if theta - stops[0] <= angle and tau <= release:
        return True
    if stops[1] - theta <= angle and tau >= load:
        return True
    if not release <= tau <= load and wedges(parameters, a, mu, tau, force):
        return True
    # without any force the pin wedges as under the smallest one, of either sign
    loads = [force] if force else [1.0, -1.0, 1e-12, -1e-12]
    found = [edge for load in loads for steeper in (0.0, known, -known) for edge in edges(load, steeper)]
    if any(map(math.isinf, found)):
        return True
    # the place where a motion ends is known to the tolerance, and with the place the sign of F_0: rest beyond
    near = beside(TOLERANCE, lambda place: mechanism.spring_force(mechanism.groove.at(place).z) + pull)
    return any(release <= tau <= load for release, load in near)
