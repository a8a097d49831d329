"""Random scenes with elliptical, tabulated and cycloidal grooves."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from .arithmetic import DOUBLE, poly
from .grooves import CYCLOID, ELLIPSE, HELIX, TABLE
from .mechanism import Mechanism
from .parameters import Refused
from .random_scenes import inertia_is_positive, log_uniform, mixed
from .scene import Interval
from .table import write_table


def random_general_scene(
    rng: np.random.Generator, folder: str | Path
) -> tuple[dict[str, Any], list[Interval]]:
    """A varied, well-posed scene with elliptical, tabulated and cycloidal grooves (some helices), nonlinear
    spring and damper, and inputs up to cubic in time. Tables are written into `folder`."""
    while True:
        scene = _draw_general_scene(rng, Path(folder))
        if scene is not None:
            return scene


def _draw_ellipse(rng: np.random.Generator, radius: float, lower: float, upper: float) -> dict[str, Any]:
    """From S_0 at psi = 0 towards S_1, with a margin beyond the largest possible angle."""
    s0, s1 = rng.uniform(0.1, 0.9, 2)
    kappa = 1 if s1 > s0 else -1
    room = min(s0, 1.0 - s0) if lower < 0 else 1.0
    span = max(upper, -lower * abs(s1 - s0) / room)
    a = radius * span * rng.uniform(1.05, 1.5) / abs(s1 - s0)
    lead = rng.uniform(0.25, 1.15)
    b = a * math.tan(lead) * math.sqrt(1.0 - s0 * s0) / s0
    return {"lead_angle": lead, "ellipse_a": a, "ellipse_b": b, "ellipse_curvature": kappa}


def _draw_cycloid(rng: np.random.Generator, radius: float, upper: float) -> dict[str, Any]:
    """Level at psi = 0, and again beyond the largest possible angle."""
    angle = upper * rng.uniform(1.02, 1.6)
    return {"cycloid_angle": angle, "cycloid_rise": radius * angle * math.tan(rng.uniform(0.3, 0.9))}


def draw_table(
    rng: np.random.Generator, radius: float, lower: float, upper: float
) -> tuple[np.ndarray, np.ndarray]:
    """psi, z of a smooth slope z' = r tan(lambda(psi)) w(psi); w is 0 in a dwell and 1 well beside it."""
    count = int(rng.integers(6, 61))
    low, high = lower - rng.uniform(0.02, 0.3), upper + rng.uniform(0.02, 0.3)
    if lower == 0 and rng.random() < 0.5:
        low = 0.0
    steps = rng.uniform(1.0, rng.choice([1.0, 1.5, 3.0]), count - 1)
    psi = low + (high - low) * np.concatenate([[0.0], np.cumsum(steps) / np.sum(steps)])
    mean, swing = rng.uniform(0.4, 1.0), rng.uniform(0.0, 0.3)
    waves, phase = rng.uniform(0.5, 1.0 + min(count, 20) / 8.0), rng.uniform(0.0, 6.0)
    dwell = None
    if count >= 16 and rng.random() < 0.35:
        first = int(rng.integers(2, count - 6))
        last = first + int(rng.integers(1, max(2, count // 6)))
        dwell = psi[first], psi[min(last, count - 3)], (high - low) * rng.uniform(0.05, 0.2)

    def slope(x: np.ndarray) -> np.ndarray:
        lead = mean + swing * np.sin(waves * x + phase)
        weight = 1.0
        if dwell is not None:
            outside = np.maximum(np.maximum(dwell[0] - x, x - dwell[1]), 0.0) / dwell[2]
            weight = -np.expm1(-(outside**2))
        return radius * np.tan(lead) * weight

    nodes, weights = np.polynomial.legendre.leggauss(12)
    middles, halves = (psi[1:] + psi[:-1]) / 2, np.diff(psi) / 2
    rises = (slope(middles[:, None] + halves[:, None] * nodes) @ weights) * halves
    return psi, np.concatenate([[0.0], np.cumsum(rises)])


def _draw_general_scene(
    rng: np.random.Generator, folder: Path
) -> tuple[dict[str, Any], list[Interval]] | None:
    p: dict[str, Any] = {"stop.upper": rng.uniform(0.4, 2.2)}
    p["stop.lower"] = mixed(rng, 0.6, lambda: -rng.uniform(0.1, 1.0))
    p["stop.restitution"] = mixed(rng, 0.7, lambda: rng.uniform(0.05, 0.6))
    lower, upper = p["stop.lower"], p["stop.upper"]
    span = upper - lower
    profiles = rng.choice([HELIX, ELLIPSE, TABLE, CYCLOID], 2, p=[0.15, 0.45, 0.3, 0.1])
    if all(profiles == HELIX) or all(profiles == CYCLOID) or (lower < 0 and CYCLOID in profiles):
        return None
    name = f"{rng.integers(2**48):012x}"
    dwell = False
    for i, profile in enumerate(profiles, start=1):
        radius = p[f"cam{i}.radius"] = rng.uniform(0.008, 0.05)
        p[f"cam{i}.profile"] = int(profile)
        if profile == HELIX:
            p[f"cam{i}.lead_angle"] = rng.uniform(0.2, 1.1)
        elif profile == ELLIPSE:
            drawn = _draw_ellipse(rng, radius, lower, upper)
            p |= {f"cam{i}.{key}": value for key, value in drawn.items()}
        elif profile == CYCLOID:
            dwell = True  # level at its start
            drawn = _draw_cycloid(rng, radius, upper)
            p |= {f"cam{i}.{key}": value for key, value in drawn.items()}
        else:
            psi, z = draw_table(rng, radius, lower, upper)
            dwell = dwell or bool(np.any(np.diff(z) == 0))
            p[f"cam{i}.table"] = str(folder / f"{name}-{i}.csv")
            write_table(p[f"cam{i}.table"], psi, z)
        p[f"cam{i}.friction"] = mixed(rng, 0.15, lambda: rng.uniform(0.0, 0.4) * rng.choice([1.0, 0.4]))
    p["contacts"] = int(rng.integers(1, 3))
    start = rng.choice(4, p=[0.4, 0.15, 0.15, 0.3])
    p["initial.theta"] = float([0.0, lower, upper, rng.uniform(lower, upper)][start])

    try:
        probe = Mechanism(p, DOUBLE)
    except Refused:
        return None
    configurations = [probe.groove.at(theta) for theta in np.linspace(lower, upper, 101).tolist()]
    ups: list[Any] = [probe.static_ratio(kin, +1) for kin in configurations]
    if not all(
        up is not None and 0 <= up < 20 * (kin.dz + 0.2 * probe.reach)
        for up, kin in zip(ups, configurations, strict=True)
    ):
        return None
    if min(kin.a1 + kin.a2 for kin in configurations) < 0.1 * max(kin.a1 + kin.a2 for kin in configurations):
        return None
    travel = configurations[-1].z - configurations[0].z
    dz, dgamma = travel / span, float(np.mean([kin.dgamma for kin in configurations]))
    force = log_uniform(rng, 3.0, 3000.0)
    up = float(np.mean(ups))
    p["spring.stiffness"] = mixed(rng, 0.1, lambda: force / travel * log_uniform(rng, 0.2, 2.0))
    p["spring.preload"] = mixed(rng, 0.2, lambda: force * rng.uniform(0.02, 1.0))
    p["spring.stiffness2"] = mixed(rng, 0.4, lambda: force / travel**2 * rng.uniform(-0.3, 1.0))
    p["spring.stiffness3"] = mixed(rng, 0.4, lambda: force / travel**3 * rng.uniform(-0.2, 1.0))
    stiffness = max(p["spring.stiffness"], 0.2 * force / travel) * dz * dz  # as seen by cam 2
    spring = [p[f"spring.{name}"] for name in ("preload", "stiffness", "stiffness2", "stiffness3")]
    force = max(abs(poly(spring, kin.z)) for kin in configurations) or force
    torque = up * force
    regime = rng.choice(["inertial", "viscous", "quasi-static"], p=[0.7, 0.15, 0.15])
    time = log_uniform(rng, 1e-2, 1.0)
    p["inertia.shaft"] = 0.0
    if regime == "inertial":
        shaft = max(log_uniform(rng, 1e-5, 0.1), stiffness * 1e-6)
        p["inertia.shaft"] = mixed(rng, 0.0 if dwell else 0.1, lambda: shaft)
        p["inertia.follower_mass"] = mixed(rng, 0.3, lambda: shaft / dz**2 * log_uniform(rng, 0.01, 2.0))
        p["inertia.follower"] = mixed(rng, 0.4, lambda: shaft / dgamma**2 * log_uniform(rng, 0.01, 2.0))
        inertia = p["inertia.shaft"] + p["inertia.follower_mass"] * dz**2 + p["inertia.follower"] * dgamma**2
        if inertia == 0:
            return None
        time = 2 * math.pi * math.sqrt(inertia / stiffness)
        critical = 2 * math.sqrt(inertia * stiffness)
        speed = math.sqrt(torque * span / inertia)
        for side in ("load", "release"):
            draw = lambda: critical / dz**2 * log_uniform(rng, 0.01, 4.0)  # noqa: E731
            p[f"damper.c_{side}"] = mixed(rng, 0.4, draw)
            draw = lambda: critical / dz**3 / speed * log_uniform(rng, 0.03, 6.0)  # noqa: E731
            p[f"damper.q_{side}"] = mixed(rng, 0.4, draw)
        p["shaft.damping"] = mixed(rng, 0.5, lambda: critical * log_uniform(rng, 0.01, 3.0))
        p["initial.omega"] = mixed(rng, 0.6, lambda: speed * rng.uniform(-1.0, 1.0))
        at_stop = p["initial.theta"] in (lower, upper)
        if at_stop and (p["initial.omega"] > 0) == (p["initial.theta"] == upper):
            p["initial.omega"] *= -1.0
    elif regime == "viscous":
        for side in ("load", "release"):
            draw = lambda: stiffness / dz**2 * time * log_uniform(rng, 0.1, 10.0)  # noqa: E731
            p[f"damper.c_{side}"] = mixed(rng, 0.4, draw)
            draw = lambda: stiffness / dz**3 * time**2 / span * log_uniform(rng, 0.1, 10.0)  # noqa: E731
            p[f"damper.q_{side}"] = mixed(rng, 0.4, draw)
        shaft_free = 0.0 if dwell else 0.6
        p["shaft.damping"] = mixed(rng, shaft_free, lambda: stiffness * time * log_uniform(rng, 0.1, 10.0))
    if regime == "inertial" and not inertia_is_positive(p):
        return None

    curved, pulls = rng.random() < 0.7, rng.random() < 0.5
    intervals = []
    for _ in range(rng.integers(4, 11)):
        duration = log_uniform(rng, 0.05 * time, 1.5 * time)
        none = rng.uniform(-0.3, 0.3) if regime == "quasi-static" else 0.0
        sizes = [none, rng.uniform(-1.0, 0.3), rng.uniform(0.0, 0.9), rng.uniform(0.5, 2.0)]
        tau = torque * rng.choice(sizes, p=[0.1, 0.2, 0.5, 0.2])
        sizes = [0.0, rng.uniform(-1.0, 0.0), rng.uniform(-0.3, 0.7)]
        pull = force * rng.choice(sizes, p=[0.2, 0.3, 0.5]) if pulls else 0.0
        rates = np.zeros((2, 3))
        for row, size, share in ((0, torque, 0.7), (1, force, 0.5 * pulls)):
            if curved and rng.random() < share:
                order = int(rng.integers(1, 4))
                swing = size * rng.uniform(-1.5, 1.5, order)
                rates[row, :order] = [
                    x * math.factorial(k + 1) / duration ** (k + 1) for k, x in enumerate(swing)
                ]
        values = [float(duration), float(tau), rates[0, 0], float(pull), rates[1, 0]]
        values += [rates[0, 1], rates[0, 2], rates[1, 1], rates[1, 2]]
        intervals.append(Interval(*map(float, values)))
    return {key: plain(value) for key, value in p.items()}, intervals


def plain(value: Any) -> Any:
    """The value as a Python number or text instead of a NumPy scalar."""
    return value.item() if isinstance(value, np.generic) else value
