"""Random scenes: a design with its inputs, drawn inside the domain or far outside it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from reference.grooves import CYCLOID, ELLIPSE, HELIX

from .domain import Verdict, classify
from .mechanics import Mechanism
from .reference import Interval

Rng = np.random.Generator
Params = dict[str, Any]


@dataclass(frozen=True)
class Scene:
    seed: int
    params: Params
    intervals: list[Interval]
    verdict: Verdict


def log_uniform(rng: Rng, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def sometimes(rng: Rng, share: float, value: float) -> float:
    """`value` in this share of the draws, else 0."""
    return float(value) if rng.random() < share else 0.0


def draw_scene(seed: int) -> Scene:
    """Scene number `seed` of the domain, of whatever class."""
    rng = np.random.default_rng([47, seed])
    params = _draw_geometry(rng)
    mech = Mechanism(params)
    travel = mech.at(mech.upper).z - mech.at(mech.lower).z
    slope, span = travel / (mech.upper - mech.lower), mech.upper - mech.lower
    force = log_uniform(rng, 5.0, 1000.0)
    params |= _draw_spring(rng, force, travel)
    params |= _draw_friction(rng, force)
    stiffness = max(params["spring.stiffness"], 0.3 * force / travel) * slope * slope
    regime = rng.choice(["inertial", "viscous", "play"], p=[0.86, 0.07, 0.07])
    if regime != "inertial":
        params |= _coulomb()
    params |= _draw_masses(rng, regime)
    if regime == "inertial" and rng.random() < 0.2:
        params |= _locked(rng)
    params |= _draw_dampers(rng, regime, stiffness, slope)
    inertia = sum(_inertias(params, slope))
    period = 2 * math.pi * math.sqrt(inertia / stiffness) if inertia > 0 else log_uniform(rng, 0.01, 1.0)
    if regime == "inertial":
        speed = math.sqrt(force * slope * span / inertia)
        for i in (1, 2):  # the lubricated branch adds at most 0.1 or so
            params[f"cam{i}.friction_viscous"] = min(
                params.get(f"cam{i}.friction_viscous", 0.0), 0.05 / (speed * mech.r1)
            )
        params["initial.omega"] = sometimes(rng, 0.4, rng.uniform(-1.0, 1.0) * speed)
        edge = params["initial.theta"]
        if edge in (mech.lower, mech.upper):
            params["initial.omega"] = abs(params["initial.omega"]) * (1 if edge == mech.lower else -1)
    intervals = _draw_inputs(rng, force, force * slope * 2, period, steady=regime == "play")
    params = {
        name: given.item() if isinstance(given, np.generic) else given for name, given in params.items()
    }
    return Scene(seed, params, intervals, classify(params, intervals[0].f_ext[0]))


def _inertias(params: Params, slope: float) -> tuple[float, float, float]:
    return params["inertia.shaft"], params["inertia.follower_mass"] * slope**2, params["inertia.follower"] / 4


def _draw_geometry(rng: Rng) -> Params:
    upper = rng.uniform(0.4, 1.8)
    kinds = rng.choice([HELIX, ELLIPSE, CYCLOID], 2, p=[0.6, 0.25, 0.15])
    if kinds[0] == kinds[1] == CYCLOID:
        kinds[0] = HELIX
    plain = bool(np.all(kinds == HELIX))
    p: Params = {
        "stop.upper": upper,
        "stop.lower": -sometimes(rng, 0.3, rng.uniform(0.1, 0.8)) if plain else sometimes(rng, 0.5, 0.1),
        "stop.restitution": sometimes(rng, 0.07, rng.uniform(0.1, 0.6)),
        "contacts": int(rng.integers(1, 3)),
    }
    for i, kind in enumerate(kinds, start=1):
        p[f"cam{i}.profile"], radius = int(kind), rng.uniform(0.01, 0.05)
        p[f"cam{i}.radius"] = radius
        if kind == CYCLOID:
            angle = upper * rng.uniform(1.05, 1.6)
            mean = math.tan(rng.uniform(math.radians(15), math.radians(60)))
            p |= {f"cam{i}.cycloid_angle": angle, f"cam{i}.cycloid_rise": mean * radius * angle}
            continue
        p[f"cam{i}.lead_angle"] = rng.uniform(math.radians(5), math.radians(75))
        if kind == ELLIPSE:
            p |= _draw_ellipse(rng, i, radius, p[f"cam{i}.lead_angle"], upper)
    start = rng.choice(3, p=[0.4, 0.1, 0.5])
    p["initial.theta"] = [p["stop.lower"], upper, rng.uniform(p["stop.lower"], upper)][start]
    return p


def _draw_ellipse(rng: Rng, i: int, radius: float, lead: float, upper: float) -> Params:
    """An arc that lasts beyond the upper stop."""
    kappa, b_over_a = int(rng.choice([-1, 1])), log_uniform(rng, 0.5, 2.0)
    s0 = math.sin(math.atan(math.tan(lead) / b_over_a))
    room = s0 if kappa < 0 else 1 - s0
    a = radius * upper * 1.4 / room * log_uniform(rng, 1.0, 3.0)
    return {f"cam{i}.ellipse_a": a, f"cam{i}.ellipse_b": a * b_over_a, f"cam{i}.ellipse_curvature": kappa}


def _draw_spring(rng: Rng, force: float, travel: float) -> Params:
    return {
        "spring.preload": sometimes(rng, 0.75, force * rng.uniform(0.05, 0.8)),
        "spring.stiffness": force / travel * rng.uniform(0.3, 1.5),
        "spring.stiffness2": sometimes(rng, 0.15, force / travel**2 * rng.uniform(0.0, 1.0)),
        "spring.stiffness3": sometimes(rng, 0.2, force / travel**3 * rng.uniform(0.0, 1.0)),
    }


def _draw_friction(rng: Rng, force: float) -> Params:
    p: Params = {}
    kind = rng.choice(["coulomb", "speed", "load", "both"], p=[0.55, 0.2, 0.15, 0.1])
    for i in (1, 2):
        p[f"cam{i}.friction"] = sometimes(rng, 0.92, rng.uniform(0.0, 0.4))
        if kind in ("speed", "both"):
            p[f"cam{i}.friction_peak"] = 1.0 + sometimes(rng, 0.8, rng.uniform(0.05, 0.6))
            p[f"cam{i}.friction"] /= p[f"cam{i}.friction_peak"]
            p[f"cam{i}.stribeck_velocity"] = log_uniform(rng, 0.01, 0.3)
            p[f"cam{i}.stribeck_exponent"] = int(rng.integers(1, 3))
            p[f"cam{i}.friction_viscous"] = sometimes(rng, 0.4, rng.uniform(0.005, 0.05))
        if kind in ("load", "both"):
            p[f"cam{i}.friction_load_exponent"] = rng.uniform(-0.35, 0.25)
            p[f"cam{i}.friction_load"] = force * log_uniform(rng, 0.2, 2.0)
    return p


def _coulomb() -> Params:
    """The same friction without its dependence on speed and load."""
    fixed = {"peak": 1.0, "viscous": 0.0, "load_exponent": 0.0}
    return {f"cam{i}.friction_{name}": value for i in (1, 2) for name, value in fixed.items()}


def _draw_masses(rng: Rng, regime: str) -> Params:
    if regime != "inertial":
        return {"inertia.shaft": 0.0, "inertia.follower_mass": 0.0, "inertia.follower": 0.0}
    shaft = log_uniform(rng, 1e-6, 0.05)
    return {
        "inertia.shaft": shaft,
        "inertia.follower_mass": sometimes(rng, 0.4, min(log_uniform(rng, 0.01, 2.0), 2e4 * shaft)),
        "inertia.follower": sometimes(rng, 0.3, shaft * log_uniform(rng, 0.01, 1.0)),
    }


def _locked(rng: Rng) -> Params:
    """A flat groove with much friction, and a follower that outweighs the shaft: often self-locking."""
    i, shaft = int(rng.integers(1, 3)), log_uniform(rng, 1e-6, 1e-3)
    return {
        f"cam{i}.profile": HELIX,
        f"cam{i}.lead_angle": math.radians(rng.uniform(5.0, 20.0)),
        f"cam{i}.friction": rng.uniform(0.2, 0.4),
        "inertia.shaft": shaft,
        "inertia.follower_mass": min(shaft * log_uniform(rng, 1e3, 1e6), 2.0),
    }


def _draw_dampers(rng: Rng, regime: str, stiffness: float, slope: float) -> Params:
    if regime == "play":
        return {}
    if regime == "viscous":
        drag = stiffness * log_uniform(rng, 0.01, 1.0)
        p = {"damper.c_load": drag / slope**2 * rng.uniform(0.5, 2.0)}
        p["damper.c_release"] = drag / slope**2 * rng.uniform(0.5, 2.0)
        p["damper.q_load"] = sometimes(rng, 0.3, drag / slope**3 * rng.uniform(0.1, 1.0))
        p["damper.q_release"] = sometimes(rng, 0.3, drag / slope**3 * rng.uniform(0.1, 1.0))
        return p | {"shaft.damping": sometimes(rng, 0.4, drag * rng.uniform(0.1, 2.0))}
    damper = sometimes(rng, 0.5, math.sqrt(stiffness) * log_uniform(rng, 1e-3, 0.1))
    return {
        "damper.c_load": damper / slope**2 * rng.uniform(0.2, 1.0),
        "damper.c_release": damper / slope**2 * rng.uniform(0.2, 1.0),
        "damper.q_load": sometimes(rng, 0.2, damper / slope**3 * rng.uniform(0.01, 0.2)),
        "damper.q_release": sometimes(rng, 0.2, damper / slope**3 * rng.uniform(0.01, 0.2)),
        "shaft.damping": sometimes(rng, 0.3, damper * rng.uniform(0.1, 1.0)),
    }


def _draw_inputs(rng: Rng, force: float, torque: float, period: float, steady: bool) -> list[Interval]:
    """Torque constant, a ramp, a sine cut into steps, or jumps; F_ext none, constant or varying."""
    kind = rng.choice(["constant", "ramp", "sine", "jumps", "cubic"], p=[0.15, 0.2, 0.2, 0.3, 0.15])
    pull = force * rng.choice([0.0, rng.uniform(-0.3, 0.3), rng.uniform(-1.5, 0.0)], p=[0.5, 0.3, 0.2])
    count = int(rng.integers(2, 9))
    lengths = [min(max(period * log_uniform(rng, 0.02, 0.8), 1e-6), 10.0) for _ in range(count)]
    if rng.random() < 0.05:
        lengths[0] = 1e-6
    if kind in ("constant", "jumps") and rng.random() < 0.05:
        lengths[-1] = min(10.0, 30 * period)
    level, swing = torque * rng.uniform(-0.3, 1.0), torque * rng.uniform(0.2, 1.2)
    rate, clock, intervals = 2 * math.pi / period * log_uniform(rng, 0.1, 1.0), 0.0, []
    for h in lengths:
        tau = {
            "constant": (level,),
            "ramp": (level + swing * rate * clock / 6, swing * rate / 6),
            "sine": (level + swing * math.sin(rate * clock),),
            "jumps": (torque * rng.choice([rng.uniform(-0.5, 0.2), rng.uniform(0.0, 1.5)]),),
            "cubic": (
                torque * rng.uniform(-0.3, 1.0),
                *(torque * rng.uniform(-2, 2) / h**k for k in (1, 2, 3)),
            ),
        }[kind]
        changing = not steady and kind in ("ramp", "cubic") and rng.random() < 0.3
        f_ext = (pull, force * rng.uniform(-0.5, 0.5) / h) if changing else (pull,)
        intervals.append(Interval(h, tuple(map(float, tau)), tuple(map(float, f_ext))))
        clock += h
    return intervals


def draw_far(seed: int) -> tuple[Params, list[Interval]]:
    """A scene of any numbers, most of them outside the domain."""
    rng = np.random.default_rng([48, seed])
    scene = draw_scene(int(rng.integers(2**31)))
    params = dict(scene.params)
    continuous = [name for name, value in params.items() if isinstance(value, float)]
    for name in rng.choice(continuous, int(rng.integers(1, 8)), replace=False):
        params[name] = float(rng.choice([0.0, -1.0, 1.0, 1e-3, 1.0])) * log_uniform(rng, 1e-9, 1e9)
    for i in (1, 2):
        if rng.random() < 0.4:
            params[f"cam{i}.friction"] = log_uniform(rng, 0.3, 30.0)
    intervals = [
        Interval(
            log_uniform(rng, 1e-9, 10.0),
            tuple(c * log_uniform(rng, 1e-6, 1e6) for c in interval.tau),
            tuple(c * log_uniform(rng, 1e-6, 1e6) for c in interval.f_ext),
        )
        for interval in scene.intervals
    ]
    return params, intervals
