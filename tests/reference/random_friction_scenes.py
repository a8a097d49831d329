"""Random scenes with friction that depends on the sliding speed and, on request, on the load."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .arithmetic import DOUBLE
from .mechanism import Mechanism
from .parameters import Params
from .random_general_scenes import random_general_scene
from .random_scenes import log_uniform, random_scene
from .scene import Interval
from .simulation import simulate

HELICAL_EVERY = 3  # every third scene has helical grooves
ANGLES = 401  # at which the scene must be in the domain


def random_friction_scene(
    rng: np.random.Generator, number: int, folder: str | Path, loaded: bool = False
) -> tuple[dict[str, Any], list[Interval]] | None:
    """A scene of the other generators, with inertia, and with a friction law whose speeds suit its motion;
    None if no law does. Tables are written into `folder`."""
    if number % HELICAL_EVERY == 0:
        params, intervals = random_scene(rng)
    else:
        params, intervals = random_general_scene(rng, folder)
    if not Mechanism(params, DOUBLE).inertial:
        return None
    if loaded:  # the times at which rest ends are then those of a fixed band
        intervals = [replace(one, F_ext_rate=0.0, F_ext_rate2=0.0, F_ext_rate3=0.0) for one in intervals]
    found = _with_law(rng, dict(params), intervals, loaded)
    return None if found is None else (found, intervals)


def _with_law(
    rng: np.random.Generator, params: dict[str, Any], intervals: list[Interval], loaded: bool
) -> dict[str, Any] | None:
    mechanism = Mechanism(params, DOUBLE)
    middle = mechanism.groove.at((params["stop.upper"] + params.get("stop.lower", 0.0)) / 2)
    peak = simulate(params, intervals, 1e-8)[-1].peak
    fastest = peak["omega"]
    if not math.isfinite(fastest) or fastest == 0:
        return None
    varies = False
    for i in (1, 2):
        friction = params.get(f"cam{i}.friction", 0.14)
        speed = fastest * mechanism.sliding(middle)[i - 1]
        if friction == 0 or speed == 0:
            continue
        if rng.random() < 0.8:
            params[f"cam{i}.friction_peak"] = 1 + float(rng.uniform(0.05, 1.0))
            params[f"cam{i}.stribeck_velocity"] = speed * log_uniform(rng, 0.01, 1.0)
            params[f"cam{i}.stribeck_exponent"] = int(rng.integers(1, 3))
            varies = True
        if loaded:
            params[f"cam{i}.friction_load_exponent"] = float(rng.uniform(-0.5, 0.5))
            params[f"cam{i}.friction_load"] = peak[f"reaction{i}"] * log_uniform(rng, 0.1, 1.0)
            varies = True
        if rng.random() < 0.5:
            params[f"cam{i}.friction_viscous"] = friction / speed * log_uniform(rng, 0.03, 1.0)
            varies = True
    return params if varies and is_in_domain(params) else None


def is_in_domain(params: Params) -> bool:
    """Does a torque load everywhere, and does the pair that releases feel a positive inertia, with the static
    coefficients under the spring's force and, where friction falls with the load, without load?"""
    mechanism = Mechanism(params, DOUBLE)
    for theta in np.linspace(mechanism.lower, mechanism.upper, ANGLES):
        kin = mechanism.groove.at(float(theta))
        force = mechanism.spring_force(kin.z)
        up = mechanism.static_ratio(kin, 1, force)
        if up is None or not 0 <= up < 20 * (kin.dz + 0.2 * mechanism.reach):
            return False
        for axial in (force, 0.0):
            pair = mechanism.static_pair(kin, -1, axial)
            if pair is not None and not mechanism.felt_inertia(kin, pair, axial) > 0:
                return False
    return True
