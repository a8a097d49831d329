"""The judges of a run: an independent reference, the same intervals cut differently, or the laws alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.harness.oracles import Interval, general_scenes, reference
from benchmarks.harness.processes import TooLong, time_limit
from verification.stress.drive import Cut, drive
from verification.stress.scene import ACCOUNTS, COMPARED, DEFAULT_TOLERANCE, Params, Scene, Trace, Verdict
from verification.stress.stiff import radau

PATIENCE = 60.0  # s, for a reference; one that takes longer is given up and the laws judge alone


def sizes_of(largest: dict[str, float], turnover: float) -> dict[str, float]:
    """The sizes that errors are relative to. Energy below a millionth of the work of the largest torque
    between the stops (`turnover`, J) is no motion but rounding."""
    energy = max(1e-6 * turnover, *(largest[f"energy.{name}"] for name in ACCOUNTS)) or 1.0  # J
    return {n: energy if n.startswith("energy.") else largest[n] or 1.0 for n in COMPARED}


def plain(scene: Scene) -> Params:
    p = scene.params if scene.instead is None else scene.instead
    return {name: value for name, value in p.items() if name != "ledger"}


def solved(scene: Scene, intervals: Sequence[Interval], params: Params) -> list[dict[str, float]]:
    if scene.judge == "radau":
        return radau(params, intervals)
    solve = reference.simulate_exact if scene.judge == "exact" else reference.simulate
    points = scene.points if scene.points is not None and params == plain(scene) else solve(params, intervals)
    doubts = {doubt for point in points for doubt in point.doubts}
    if doubts - {general_scenes.FADING, general_scenes.STILL}:
        raise reference.Refused(f"the reference is in doubt: {sorted(doubts)}")
    return [{name: float(point.value(name)) for name in COMPARED} for point in points]


def largest_error(
    scene: Scene,
    found: Sequence[dict[str, float]],
    wanted: Sequence[dict[str, float]],
    size: dict[str, float],
) -> tuple[float, str]:
    worst, where = 0.0, ""
    for number, (values, point) in enumerate(zip(found, wanted, strict=True)):
        for name in set(scene.compared) & set(point):
            error = abs(values[name] - point[name]) / size[name]
            if not error <= worst:
                worst, where = error, f"interval {number}: {name} {values[name]!r}, not {point[name]!r}"
    return worst, where


def solved_in_time(scene: Scene, intervals: Sequence[Interval], params: Params) -> list[dict[str, float]]:
    """TooLong after PATIENCE."""
    with time_limit(PATIENCE):
        return solved(scene, intervals, params)


def change_of_reference(
    scene: Scene, params: Params, wanted: Sequence[dict[str, float]], size: dict[str, float], by: float
) -> float:
    """The largest change of the reference when its data change by `by`, relative. 0 if it cannot be
    solved."""
    rng, moved = np.random.default_rng(1), 0.0
    try:
        for _ in range(2):
            changed, intervals = general_scenes.nudged(params, scene.intervals, rng, by)
            found = solved_in_time(replace(scene, points=None), intervals, changed)
            moved = max(moved, largest_error(scene, found, wanted, size)[0])
    except (reference.Refused, ArithmeticError, ValueError, TooLong):
        return 0.0
    return moved


def change_of_fmu(scene: Scene, trace: Trace, size: dict[str, float], by: float, library: Any) -> float:
    """The largest change of the FMU's own run when its data change by `by` and by ten times as much."""
    rng, moved = np.random.default_rng(6), 0.0
    for change in (by, by, 10.0 * by):
        params, intervals = general_scenes.nudged(scene.params, scene.intervals, rng, change)
        other = drive(library, replace(scene, params=params, intervals=intervals))
        if len(other.read) == len(trace.read):
            moved = max(moved, largest_error(scene, other.read, trace.read, size)[0])
    return moved


def by_reference(scene: Scene, trace: Trace, verdict: Verdict) -> None:
    params = plain(scene)
    try:
        wanted = solved_in_time(scene, scene.intervals, params)
    except (reference.Refused, ArithmeticError, ValueError, NotImplementedError, TooLong) as doubt:
        verdict.note = f"no reference: {type(doubt).__name__} {doubt}"
        return
    largest = {n: max([trace.largest[n], *(abs(point.get(n, 0.0)) for point in wanted)]) for n in COMPARED}
    size = sizes_of(largest, trace.turnover)
    verdict.error, where = largest_error(scene, trace.read, wanted, size)
    verdict.judged = True
    if verdict.error <= scene.allowed:
        return
    by = scene.tolerance or DEFAULT_TOLERANCE
    moved = change_of_reference(scene, params, wanted, size, by)
    if verdict.error > scene.allowed + 30.0 * moved:
        verdict.problems.append(f"error {verdict.error:.2e} ({where}); data amplify {moved / by:.1e}")
    else:
        verdict.note = f"amplified {moved / by:.1e} times"
        verdict.error = math.nan


def random_cuts(rng: np.random.Generator) -> Cut:
    def cut(_: int, length: float) -> list[float]:
        count = int(rng.choice([1, 2, 5, 20]))
        return [0.0, *np.unique(rng.uniform(0.0, length, count - 1)).tolist(), length]

    return cut


def by_cutting(scene: Scene, trace: Trace, verdict: Verdict, library: Any) -> None:
    """Whole intervals against intervals cut at random. Where these differ: against data changed by a
    tolerance."""
    tolerance = scene.tolerance or DEFAULT_TOLERANCE
    pieces = drive(library, scene, random_cuts(np.random.default_rng(5)))
    verdict.problems += [f"in pieces: {text}" for text in pieces.problems]
    verdict.step = max(verdict.step, pieces.step)
    if pieces.refusal or trace.refusal or not (pieces.read and trace.read):
        refusals = pieces.refusal + trace.refusal
        if bool(pieces.refusal) != bool(trace.refusal) and "too many segments" not in refusals:
            verdict.note = f"refused in one piece only: {trace.refusal or '-'} | {pieces.refusal or '-'}"
        return
    if pieces.problems or trace.problems or len(pieces.read) != len(trace.read):
        return
    size = sizes_of({n: max(trace.largest[n], pieces.largest[n]) for n in COMPARED}, trace.turnover)
    verdict.error, where = largest_error(scene, trace.read, pieces.read, size)
    verdict.judged = True
    if verdict.error <= 100.0 * tolerance:
        return
    moved = change_of_fmu(scene, trace, size, tolerance, library)
    if verdict.error > 100.0 * tolerance + 10.0 * moved:
        verdict.problems.append(
            f"cutting changes {verdict.error:.2e} ({where}); data amplify {moved / tolerance:.1e}"
        )
    else:
        verdict.note = f"chaotic: data amplify {moved / tolerance:.1e}"
        verdict.error = math.nan


def judge(scene: Scene, libraries: dict[bool, Any]) -> Verdict:
    library = libraries[scene.general]
    trace = drive(library, scene)
    verdict = Verdict(
        residual=trace.residual, step=trace.step, refusal=trace.refusal, problems=trace.problems
    )
    verdict.rate = trace.total / trace.simulated if trace.simulated else 0.0
    if scene.judge == "cuts":
        by_cutting(scene, trace, verdict, library)
    elif scene.judge != "laws" and len(trace.read) == len(scene.intervals) and trace.largest:
        by_reference(scene, trace, verdict)
    return verdict
