"""Random scenes with helical grooves."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from .arithmetic import DOUBLE
from .kinematics import Helices
from .mechanism import Mechanism, Slip
from .parameters import Params
from .scene import Interval


def random_scene(rng: np.random.Generator) -> tuple[dict[str, float], list[Interval]]:
    """A varied, well-posed scene with helical grooves. Sizes follow from a characteristic axial force, so
    that the mechanism moves, reaches its stops, sticks and turns round; the number of swings is bounded."""
    while True:
        scene = _draw_scene(rng)
        if scene is not None:
            return scene


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def mixed(rng: np.random.Generator, zero_share: float, draw: Callable[[], float]) -> float:
    return 0.0 if rng.random() < zero_share else float(draw())


def _draw_scene(rng: np.random.Generator) -> tuple[dict[str, float], list[Interval]] | None:
    p: dict[str, float] = {}
    lead_ranges = [(0.35, 1.1), (0.05, 0.35), (1.1, 1.4)]
    for i in (1, 2):
        p[f"cam{i}.radius"] = rng.uniform(0.005, 0.05)
        p[f"cam{i}.lead_angle"] = rng.uniform(*lead_ranges[rng.choice(3, p=[0.6, 0.25, 0.15])])
        p[f"cam{i}.friction"] = mixed(rng, 0.15, lambda: rng.uniform(0.0, 0.5) * rng.choice([1.0, 0.4]))
    if rng.random() < 0.1:
        p["cam1.friction"] = p["cam2.friction"] = 0.0
    p["contacts"] = int(rng.integers(1, 3))
    p["stop.upper"] = rng.uniform(0.3, 2.5)
    p["stop.lower"] = mixed(rng, 0.6, lambda: -rng.uniform(0.1, 1.5))
    p["stop.restitution"] = mixed(rng, 0.3, lambda: rng.uniform(0.05, 0.9))
    span = p["stop.upper"] - p["stop.lower"]
    start = rng.choice(4, p=[0.4, 0.15, 0.15, 0.3])
    middle = rng.uniform(p["stop.lower"], p["stop.upper"])
    p["initial.theta"] = float([0.0, p["stop.lower"], p["stop.upper"], middle][start])

    probe = Mechanism(p, DOUBLE)
    kin = probe.groove.at(0.0)
    up, dz, dgamma = probe.static_ratio(kin, +1), kin.dz, kin.dgamma
    if up is None or up > 30 * dz:  # a loading jam, or nearly
        return None
    force = log_uniform(rng, 3.0, 3000.0)
    p["spring.stiffness"] = mixed(rng, 0.12, lambda: force / (dz * span) * log_uniform(rng, 0.1, 3.0))
    p["spring.preload"] = mixed(rng, 0.25, lambda: force * rng.uniform(0.02, 1.0))
    torque = up * force
    stiffness = max(p["spring.stiffness"], 0.1 * force / (dz * span)) * dz * dz  # as seen by cam 2
    regime = rng.choice(["inertial", "viscous", "quasi-static"], p=[0.7, 0.15, 0.15])
    time = log_uniform(rng, 1e-2, 1.0)
    p["inertia.shaft"] = 0.0
    if regime == "inertial":
        # J between 1e-5 and 1 kg.m2, with at most some tens of swings per interval
        shaft = max(log_uniform(rng, 1e-5, 1.0), stiffness * 1e-6)
        p["inertia.shaft"] = mixed(rng, 0.05, lambda: shaft)
        p["inertia.follower_mass"] = mixed(rng, 0.5, lambda: shaft / dz**2 * log_uniform(rng, 0.01, 5.0))
        p["inertia.follower"] = mixed(rng, 0.5, lambda: shaft / dgamma**2 * log_uniform(rng, 0.01, 5.0))
        inertia = p["inertia.shaft"] + p["inertia.follower_mass"] * dz**2 + p["inertia.follower"] * dgamma**2
        if inertia == 0:
            return None
        time = 2 * math.pi * math.sqrt(inertia / stiffness)
        critical = 2 * math.sqrt(inertia * stiffness)
        for side in ("load", "release"):
            draw = lambda: critical / dz**2 * log_uniform(rng, 0.01, 30.0)  # noqa: E731
            p[f"damper.c_{side}"] = mixed(rng, 0.35, draw)
        p["shaft.damping"] = mixed(rng, 0.5, lambda: critical * log_uniform(rng, 0.01, 10.0))
        speed = math.sqrt(torque * span / inertia)
        p["initial.omega"] = mixed(rng, 0.6, lambda: speed * rng.uniform(-1.0, 1.0))
        at_stop = p["initial.theta"] in (p["stop.lower"], p["stop.upper"])
        if at_stop and (p["initial.omega"] > 0) == (p["initial.theta"] == p["stop.upper"]):
            p["initial.omega"] *= -1.0
    elif regime == "viscous":
        for side in ("load", "release"):
            draw = lambda: stiffness / dz**2 * time * log_uniform(rng, 0.03, 30.0)  # noqa: E731
            p[f"damper.c_{side}"] = mixed(rng, 0.25, draw)
        p["shaft.damping"] = mixed(rng, 0.5, lambda: stiffness * time * log_uniform(rng, 0.03, 10.0))
    if regime == "inertial" and not inertia_is_positive(p):
        return None

    ramps, pulls = rng.random() < 0.35, rng.random() < 0.5
    longest = min(1.0, max(4e-3, 6.0 * time))
    intervals = []
    for _ in range(rng.integers(5, 21)):
        duration = log_uniform(rng, max(1e-3, min(0.02 * time, 0.3 * longest)), longest)
        tau = torque * rng.choice([0.0, rng.uniform(-2.0, 0.3), rng.uniform(0.0, 1.0), rng.uniform(0.5, 3.0)])
        pull = force * rng.choice([0.0, rng.uniform(-2.0, 0.0), rng.uniform(-0.5, 1.0)]) if pulls else 0.0
        rates = [0.0, 0.0]
        if ramps and rng.random() < 0.6:
            rates[0] = torque * rng.uniform(-3.0, 3.0) / duration
        if ramps and pulls and rng.random() < 0.5:
            rates[1] = force * rng.uniform(-2.0, 2.0) / duration
        intervals.append(Interval(duration, float(tau), rates[0], float(pull), rates[1]))
    return p, intervals


def inertia_is_positive(params: Params) -> bool:
    """Does more torque mean more acceleration on the flanks that statics chooses, in both directions, at any
    angle between the stops?"""
    mech = Mechanism(params, DOUBLE)
    angles = [0.0]
    if not isinstance(mech.groove, Helices):
        angles = np.linspace(mech.lower, mech.upper, 201).tolist()
    for kin in map(mech.groove.at, angles):
        for sigma in (+1, -1):
            for e in ((1, 1), (-1, -1), (1, -1), (-1, 1)):
                slip = Slip(sigma, e)
                q = mech.balance(kin, slip)
                x1, x2 = e[0] * q.n2 * q.delta, e[1] * q.n1 * q.delta
                used = (x1 >= 0 and x2 >= 0) or (x1 <= 0 and x2 <= 0)
                if used and not mech.inertia_and_drag(kin, slip)[1] * q.delta > 0:
                    return False
    return True
