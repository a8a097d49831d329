"""Does the answer of the FMU depend on how an interval is cut into steps? One scene is played twice, in whole
intervals and in cut ones, and judged against what small changes of its data do."""

from __future__ import annotations

import math
import random
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import Any

import numpy as np
from driver import OK, Driver
from random_scenes import LEAST, curve, inertia_felt, slopes, unit_of_torque
from reference import DOUBLE, Groove, Mechanism, Slip, groove_of

TOLERANCE = 1e-9  # the FMU's, where none is given
# Cuts may change ten times the tolerance, and ten times what a nudge of every number by a hundred tolerances
# changes: a stop grazed, a speed that dies away, contacts about to change flanks. A scene that a nudge moves
# by more than the share STEADY is not judged.
NUDGE, STEADY = 1e-7, 1e-4
# Each number has its own sign in a nudge. All forces and inertias together would change nothing but the share
# of the inputs.
NUDGES = 8
# A torque within this share of the terms of its balance is on the edge of the stick band: a tie is rest.
# What such a torque does to the speed is rounding.
TIE = 2e-12
ANGLE = 4 * sys.float_info.epsilon  # share of the farther stop: a rounding of theta
# Where a mode is decided, a reaction below this share of its terms is zero (CANDIDATE_COARSE in
# fmu_src/numerics/tolerances.h). Beside a dwell a reaction is proportional to the slope that is nearly zero.
ZERO_SHARE = 1e-12

Curve = tuple[float, Sequence[float], Sequence[float]]  # as random_scenes.CURVES draws them
Part = tuple[float, float]
WHOLE: Sequence[Part] = [(0.0, 1.0)]


class Outcome(StrEnum):
    AGREES = "agrees"
    SENSITIVE = "sensitive to the data"
    REFUSED = "refused"
    REFUSED_IN_PART = "refused in one of both ways"
    DEPENDS = "depends on cuts"


@dataclass(frozen=True)
class Scene:
    parameters: Mapping[str, Any]
    curves: Sequence[Curve]  # one of an interval
    cuts: Sequence[float]  # shares of each interval, rising


@dataclass(frozen=True)
class Verdict:
    outcome: Outcome
    interval: int  # the last one that was played
    text: str = ""


def started(make: Callable[[], Driver], parameters: Mapping[str, Any]) -> Driver | None:
    """A started FMU, or None where a parameter or the start is refused."""
    fmu = make()
    if any(fmu.try_set({name: value}) != OK for name, value in parameters.items()):
        return None
    fmu.setup()
    fmu.ok("fmi2EnterInitializationMode")
    return fmu if fmu.call("fmi2ExitInitializationMode") == OK else None


def plays(fmu: Driver, torque_unit: float, one: Curve, parts: Iterable[Part]) -> bool:
    return all(curve(fmu, torque_unit, *one, part) == OK for part in parts)


def rounding_of_speed(
    fmu: Driver, parameters: Mapping[str, Any], grooves: Sequence[Groove], torque_unit: float, one: Curve
) -> float:
    """rad/s: the speed that a tie of the torques gives the inertia within the interval `one`."""
    h, taus, forces = one
    felt, z = inertia_felt(fmu, parameters, grooves), fmu.get("z")
    if not felt:
        return 0.0
    a1, a2 = slopes(fmu, grooves)
    k = [parameters[f"spring.{name}"] for name in ("preload", "stiffness", "stiffness2", "stiffness3")]
    force = math.fsum(abs(c * z**i) for i, c in enumerate(k)) + math.fsum(map(abs, forces))
    lift = abs(a1 * a2 / (a1 + a2))  # m/rad; where a groove is level, its slope is a rounding of either sign
    return TIE * (torque_unit * math.fsum(map(abs, taus)) + lift * force) * h / felt


def rounding_by_angle(fmu: Driver, parameters: Mapping[str, Any]) -> float:
    """rad/s. Without inertia the angle gives the speed, and the angle has a rounding of the farther stop."""
    mechanism = Mechanism(parameters, DOUBLE)
    if mechanism.inertial or not fmu.get("omega"):
        return 0.0
    flanks = tuple(1 if fmu.get(f"cam{i}.reaction") > 0.0 else -1 for i in (1, 2))
    slip = Slip(1 if fmu.get("omega") > 0.0 else -1, flanks)
    rate = mechanism.rate(mechanism.groove.at(fmu.get("theta")), slip, fmu.get("omega"))
    return ANGLE * max(map(abs, (parameters["stop.lower"], parameters["stop.upper"]))) * rate


def loads_are_rounding(
    runs: Sequence[Driver], parameters: Mapping[str, Any], grooves: Sequence[Groove]
) -> bool:
    """Have all runs come to angles beside a dwell at which the slope of a groove is not zero, but so small
    that no reaction tells where the contacts jam?"""
    angles = np.linspace(parameters["stop.lower"], parameters["stop.upper"], 257)
    places = map(Mechanism(parameters, DOUBLE).groove.at, map(float, angles))
    steepest = max(max(place.a1, place.a2) for place in places)
    now = zip(*(slopes(fmu, grooves) for fmu in runs), strict=True)
    return any(min(slope) > 0.0 and max(slope) <= ZERO_SHARE * steepest for slope in now)


def nudge_stops(values: dict[str, Any], chance: random.Random) -> None:
    """By a rounding of the angle. A mechanism that leaves an unstable balance at a stop leaves by that."""
    rounding = ANGLE * max(map(abs, (values["stop.lower"], values["stop.upper"])))
    for name in ("stop.lower", "stop.upper"):
        values[name] += rounding * chance.choice((-1.0, 1.0))
    start = values.get("initial.theta", 0.0)
    values["initial.theta"] = min(max(start, values["stop.lower"]), values["stop.upper"])


def nudged(scene: Scene, chance: random.Random) -> Scene:
    """The same scene, each number a little larger or smaller; the stops, which are places, by a rounding."""

    def near(x: float) -> float:
        return x * (1.0 + NUDGE * chance.choice((-1.0, 1.0)))

    values = {
        name: near(value) if isinstance(value, float) and not name.startswith("stop.") else value
        for name, value in scene.parameters.items()
    }
    nudge_stops(values, chance)
    for i in (1, 2):  # the least value that is allowed
        if f"cam{i}.friction_peak" in values:
            values[f"cam{i}.friction_peak"] = max(1.0, values[f"cam{i}.friction_peak"])
    curves = [(h, [near(x) for x in taus], [near(x) for x in forces]) for h, taus, forces in scene.curves]
    return Scene(values, curves, scene.cuts)


def played_whole(make: Callable[[], Driver], scene: Scene, intervals: int, unit: float) -> Driver | None:
    """The FMU after that many intervals, or None where one is refused."""
    fmu = started(make, scene.parameters)
    done = fmu is not None and all(plays(fmu, unit, one, WHOLE) for one in scene.curves[:intervals])
    return fmu if done else None


def moved_by_nudges(
    make: Callable[[], Driver], scene: Scene, intervals: int, unit: float, name: str, value: float
) -> float:
    """How far nudges of the data move the variable `name` from `value`."""
    chance, moved = random.Random(0), 0.0
    for _ in range(NUDGES):
        fmu = played_whole(make, nudged(scene, chance), intervals, unit)
        if fmu is not None:
            moved = max(moved, abs(fmu.get(name) - value))
    return moved


def sizes(runs: Sequence[Driver], parameters: Mapping[str, Any]) -> dict[str, float]:
    """What errors are relative to: the farther stop, the largest speed."""
    speed = max(fmu.get("peak.omega") for fmu in runs)
    # without inertia and damping theta snaps on: the speed there is infinite
    if not 0.0 < speed < math.inf:
        speed = max(1e-300, abs(runs[0].get("omega")))
    return {"theta": max(map(abs, (parameters["stop.lower"], parameters["stop.upper"]))), "omega": speed}


def judge(make: Callable[[], Driver], scene: Scene) -> Verdict:
    whole, cut = started(make, scene.parameters), started(make, scene.parameters)
    if whole is None or cut is None:
        return Verdict(Outcome.REFUSED, -1)
    unit, places = unit_of_torque(whole, LEAST), [0.0, *scene.cuts, 1.0]
    grooves = [groove_of(scene.parameters, i) for i in (1, 2)]
    rounding = {"theta": 0.0, "omega": 0.0}
    for k, one in enumerate(scene.curves):
        rounding["omega"] += rounding_of_speed(whole, scene.parameters, grooves, unit, one)
        done = plays(whole, unit, one, WHOLE), plays(cut, unit, one, pairwise(places))
        if not all(done):
            return Verdict(Outcome.REFUSED_IN_PART if any(done) else Outcome.REFUSED, k)
        for name, size in sizes((whole, cut), scene.parameters).items():
            first, second = whole.get(name), cut.get(name)
            allowed = 10 * TOLERANCE * size + rounding[name]
            if name == "omega" and abs(second - first) > allowed:
                allowed += rounding_by_angle(whole, scene.parameters)
            if abs(second - first) <= allowed:
                continue
            if name == "theta" and loads_are_rounding((whole, cut), scene.parameters, grooves):
                return Verdict(Outcome.SENSITIVE, k)
            moved = moved_by_nudges(make, scene, k + 1, unit, name, first)
            if moved > STEADY * size or abs(second - first) <= allowed + 10 * moved:
                return Verdict(Outcome.SENSITIVE, k)
            text = (
                f"{name} after interval {k} is {first!r} in one step, {second!r} in {len(places) - 1} steps;"
                f" allowed is a difference of {allowed:.2g}, nudges of the data make {moved:.2g}"
            )
            return Verdict(Outcome.DEPENDS, k, text)
    return Verdict(Outcome.AGREES, len(scene.curves) - 1)
