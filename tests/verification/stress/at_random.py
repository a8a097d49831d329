"""Scenes at random: every parameter and input over many decades."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.harness.oracles import Interval, reference
from verification.stress.mechanisms import LEADS, Tables
from verification.stress.scene import Params, Scene


def decades(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high))


def draw_groove(rng: np.random.Generator, tables: Tables, i: int, span: tuple[float, float]) -> Params:
    kind, radius = int(rng.integers(1, 4)), decades(rng, -2.5, -0.5)
    made: Params = {f"cam{i}.profile": kind, f"cam{i}.radius": radius}
    if kind == 1:
        made[f"cam{i}.lead_angle"] = float(rng.choice([*LEADS, rng.uniform(0.1, 1.4)], p=[*[0.04] * 9, 0.64]))
    elif kind == 2:
        s0, s1 = rng.choice([0.0, 1e-6, *rng.uniform(0.05, 0.95, 4)], 2).tolist()
        s1 = 1.0 - decades(rng, -9, -1) if rng.random() < 0.1 else s1
        if s0 == s1:
            s1 = s0 + 0.01
        # a lower stop below zero needs arc on that side too
        a = radius * max(span[1], 0.1) * rng.uniform(1.001, 2.0) / abs(s1 - s0)
        if span[0] < 0.0:
            s0 = min(max(s0, 0.1), 0.9)
            a = max(a, radius * -span[0] * 1.1 / min(s0, 1.0 - s0))
        b = a * decades(rng, -1, 1)
        made |= {
            f"cam{i}.ellipse_a": a,
            f"cam{i}.ellipse_b": b,
            f"cam{i}.lead_angle": math.atan(b / a * s0 / math.sqrt(1.0 - s0 * s0)),
            f"cam{i}.ellipse_curvature": 1 if s1 > s0 else -1,
        }
    elif (share := rng.random()) < 0.7:
        psi, z = reference.draw_table(rng, radius, *span)
        made[f"cam{i}.table"] = tables.write(psi, z)
    elif share < 0.8 and span[0] >= 0.0:
        angle = span[1] * rng.uniform(1.001, 2.0)
        made[f"cam{i}.profile"], made[f"cam{i}.cycloid_angle"] = 4, angle
        made[f"cam{i}.cycloid_rise"] = radius * angle * decades(rng, -1, 1)
    else:  # rough: steps, flats and corners
        psi = np.sort(
            np.concatenate([rng.uniform(span[0] - 0.2, span[1] + 0.2, int(rng.integers(3, 30))), [0.0]])
        )
        psi[0], psi[-1] = span[0] - 0.2, span[1] + 0.2
        rise = rng.choice([0.0, 1.0, 1e-3], len(psi) - 1, p=[0.2, 0.7, 0.1]) * rng.uniform(
            0.1, 3.0, len(psi) - 1
        )
        made[f"cam{i}.table"] = tables.write(
            psi, np.concatenate([[0.0], np.cumsum(radius * rise * np.diff(psi))])
        )
    friction = [0.0, rng.uniform(0.0, 0.3), rng.uniform(0.0, 1.5), decades(rng, -9, -1)]
    made[f"cam{i}.friction"] = float(rng.choice(friction, p=[0.15, 0.6, 0.15, 0.1]))
    return made


def maybe(rng: np.random.Generator, share: float, value: float) -> float:
    """The value in that share of the draws, else 0."""
    return value if rng.random() < share else 0.0


def draw_intervals(rng: np.random.Generator, force: float, torque: float) -> list[Interval]:
    """Up to six cubic polynomials of torque and follower force, which have about the sizes given [N, N.m]."""
    duration = decades(rng, -1, 0)
    intervals = []
    shares = rng.dirichlet(np.ones(int(rng.integers(1, 7)))).tolist()
    for share in shares:
        length = max(duration * share, 1e-6)
        values = [
            torque
            * float(rng.choice([0.0, rng.uniform(-2.0, 0.0), rng.uniform(0.0, 1.5), rng.uniform(1.0, 5.0)]))
        ]
        values += [
            torque * maybe(rng, 0.25, rng.uniform(-3.0, 3.0)) * math.factorial(o) / length**o
            for o in (1, 2, 3)
        ]
        pulls = [force * maybe(rng, 0.4, rng.uniform(-2.0, 1.0))]
        pulls += [
            force * maybe(rng, 0.15, rng.uniform(-2.0, 2.0)) * math.factorial(o) / length**o
            for o in (1, 2, 3)
        ]
        intervals.append(Interval(length, values[0], values[1], pulls[0], pulls[1], *values[2:], *pulls[2:]))
    return intervals


def draw(rng: np.random.Generator, tables: Tables) -> Scene:
    """Sizes over many decades, but such that the cam moves in 0.1 to 1 s."""
    lower, upper = -maybe(rng, 0.4, rng.uniform(0.05, 1.0)), float(rng.uniform(0.2, 2.5))
    p: Params = {"stop.lower": lower, "stop.upper": upper}
    for i in (1, 2):
        p |= draw_groove(rng, tables, i, (lower, upper))
    k = decades(rng, -2, 8) if rng.random() < 0.3 else decades(rng, 2, 5)
    reach = 0.5 * (p["cam1.radius"] + p["cam2.radius"]) * 0.5
    force = k * reach
    p |= {
        "spring.stiffness": maybe(rng, 0.9, k),
        "spring.preload": maybe(rng, 0.8, force * decades(rng, -3, 1) * rng.choice([1.0, 1.0, 1.0, -1.0])),
        "spring.stiffness2": maybe(rng, 0.5, k / reach * rng.uniform(-0.3, 1.0)),
        "spring.stiffness3": maybe(rng, 0.5, k / reach**2 * rng.uniform(-0.2, 1.0)),
        "stop.restitution": maybe(rng, 0.3, float(rng.choice([rng.uniform(0.0, 0.9), 0.99, 1.0]))),
        "contacts": int(rng.integers(1, 3)),
        "initial.theta": float(rng.choice([max(lower, 0.0), lower, upper, rng.uniform(lower, upper)])),
    }
    dz_dtheta = reach  # m/rad, by its size
    time = decades(rng, -2, 0)
    J = k * dz_dtheta**2 * (time / 6.0) ** 2  # a swing takes about `time`
    critical = 2.0 * math.sqrt(J * k) / dz_dtheta
    p["inertia.shaft"] = maybe(rng, 0.75, J * decades(rng, *([-9, 1] if rng.random() < 0.3 else [-1, 1])))
    p["inertia.follower_mass"] = maybe(rng, 0.4, J / dz_dtheta**2 * decades(rng, -3, 1))
    p["inertia.follower"] = maybe(rng, 0.3, J * decades(rng, -3, 1))
    wide = rng.random() < 0.25
    for side in ("load", "release"):
        p[f"damper.c_{side}"] = maybe(rng, 0.5, critical * decades(rng, -2, 7 if wide else 1))
        p[f"damper.q_{side}"] = maybe(rng, 0.4, critical * time / reach * decades(rng, -2, 7 if wide else 1))
    p["shaft.damping"] = maybe(rng, 0.4, critical * dz_dtheta**2 * decades(rng, -2, 4 if wide else 1))
    if p["inertia.shaft"]:
        p["initial.omega"] = maybe(rng, 0.4, rng.uniform(-1.0, 1.0) * upper / time * 3.0)
    torque = force * dz_dtheta * (1.0 + abs(p["spring.preload"]) / force)
    intervals = draw_intervals(rng, force, torque)
    tolerance = None if rng.random() < 0.5 else float(rng.choice([1e-4, 1e-6, 1e-8, 1e-11]))
    return Scene("", {n: reference.plain(v) for n, v in p.items()}, intervals, "cuts", "", tolerance)


def random_scene(tables: Tables, number: int, seed: int = 0) -> Scene:
    """One scene of fuzz()."""
    return replace(draw(np.random.default_rng([77, seed, number]), tables), label=f"fuzz {number}")


def fuzz(tables: Tables, count: int, seed: int = 0) -> Iterator[Scene]:
    row = f"everything at random ({count} scenes of 0.1 to 1 s)"
    for number in range(count):
        yield replace(random_scene(tables, number, seed), row=row)
