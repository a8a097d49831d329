"""A scene on the FMU, and its comparison with the reference."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from driver import FORWARD, OK, Driver

from .domain import REFUSED, SELF_LOCKING, UNIQUE
from .mechanics import Unresolved
from .reference import Ambiguous, Interval, Point, nudged, solve
from .scenes import Scene, draw_far, draw_scene

LIMIT = 10.0  # tolerances
OUTPUTS = ["theta", "omega", "energy.residual"]
WHOLE = ["mode", "events"]
ACCOUNTS = [name for name in FORWARD.variables if name.startswith("energy.") and name != "energy.residual"]
CLASSES = {UNIQUE: 1, SELF_LOCKING: 2}


@dataclass
class Outcome:
    """What a scene showed. `problems` is empty where FMU and reference agree."""

    seed: int
    kind: str
    problems: list[str] = field(default_factory=list)
    error: float = 0.0  # in tolerances: largest of angle and speed against the reference
    cut_error: float = 0.0  # likewise, of the same run cut anywhere
    residual: float = 0.0  # of the largest account
    refusal: str = ""  # the FMU's message, numbers left out
    open: str = ""  # why the reference does not judge this scene


class Refusal(Exception):
    """The FMU refused a call."""


class Run:
    """One instance that plays intervals."""

    def __init__(self, library: Any, params: dict[str, Any], first: Interval, tolerance: float) -> None:
        self.driver = Driver(library)
        for name, given in (params | {"tau": first.tau[0], "F_ext": first.f_ext[0]}).items():
            self._ask(self.driver.try_set({name: given}))
        self.driver.setup(0.0, tolerance)
        self._ask(self.driver.call("fmi2EnterInitializationMode"))
        self._ask(self.driver.call("fmi2ExitInitializationMode"))

    def _ask(self, status: int) -> None:
        if status != OK:
            text = self.driver.messages[-1].text if self.driver.messages else "no message"
            self.close()
            raise Refusal(text)

    def step(self, interval: Interval) -> None:
        driver = self.driver
        self._ask(driver.try_set({"tau": interval.tau[0], "F_ext": interval.f_ext[0]}))
        rates = {
            name: [c * math.factorial(k) for k, c in enumerate(polynomial) if k > 0]
            for name, polynomial in (("tau", interval.tau), ("F_ext", interval.f_ext))
            if len(polynomial) > 1
        }
        if rates:
            self._ask(driver.try_set_derivatives(rates))
        self._ask(driver.call("fmi2DoStep", driver.time, interval.duration, 1))
        driver.time += interval.duration

    def read(self) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for names in (OUTPUTS, WHOLE, ACCOUNTS):
            _, values = self.driver.try_get(names)
            found |= dict(zip(names, values, strict=True))
        return found

    def close(self) -> None:
        self.driver.free()


def pieces(interval: Interval, rng: np.random.Generator) -> list[Interval]:
    """The same interval cut at random places."""
    shares = np.sort(rng.uniform(0.0, 1.0, int(rng.integers(1, 5))))
    return cut(interval, (shares * interval.duration).tolist())


def cut(interval: Interval, times: Sequence[float]) -> list[Interval]:
    """The same interval cut at these times, s, which rise."""
    ends = [0.0, *(float(t) for t in times if 0 < t < interval.duration), interval.duration]
    return [
        Interval(b - a, _moved(interval.tau, a), _moved(interval.f_ext, a))
        for a, b in pairwise(ends)
        if b > a
    ]


def _moved(polynomial: Sequence[float], by: float) -> tuple[float, ...]:
    return tuple(
        sum(math.comb(i, k) * c * by ** (i - k) for i, c in enumerate(polynomial) if i >= k)
        for k in range(len(polynomial))
    )


def play(
    library: Any, params: dict[str, Any], intervals: Sequence[Sequence[Interval]], tolerance: float
) -> list[dict[str, Any]]:
    """The FMU's variables at the end of each group of intervals. Raises Refusal."""
    run = Run(library, params, intervals[0][0], tolerance)
    rows = []
    for group in intervals:
        for interval in group:
            run.step(interval)
        rows.append(run.read())
    run.close()
    return rows


def judge(library: Any, seed: int, tolerance: float) -> Outcome:
    """Scene `seed` against the reference, against itself cut anywhere, and its energy."""
    scene = draw_scene(seed)
    outcome = Outcome(seed, scene.verdict.kind)
    rng = np.random.default_rng([49, seed])
    try:
        rows = play(library, scene.params, [[i] for i in scene.intervals], tolerance)
    except Refusal as refusal:
        outcome.refusal = plain(str(refusal))
        return outcome
    if scene.verdict.kind == REFUSED:
        if not scene.verdict.border:
            outcome.problems.append(f"not refused: {scene.verdict.reason}")
        return outcome
    _judge_class(library, scene, outcome)
    outcome.residual = max(residual(row) for row in rows)
    if outcome.residual > 1e-9:
        outcome.problems.append(f"energy residual {outcome.residual:.1e}")
    outcome.problems += falling_heats(rows)
    try:
        points = solve(scene.params, scene.intervals, scene.verdict.kind == UNIQUE)
        _compare(scene, rows, points, tolerance, outcome)
        _compare_cut(library, scene, rows, points, rng, tolerance, outcome)
    except Unresolved as reason:
        outcome.open = str(reason)
    except ZeroDivisionError:  # a groove that is level where the reference divides by its slope
        outcome.open = "the reference divides by zero"
    except Ambiguous as reason:
        outcome.problems.append(f"reference: {reason}")
    except Refusal as refusal:
        outcome.problems.append(f"refused when cut: {plain(str(refusal))}")
    return outcome


def _judge_class(library: Any, scene: Scene, outcome: Outcome) -> None:
    if "friction_class" not in FORWARD.variables:
        return
    run = Run(library, scene.params, scene.intervals[0], 1e-9)
    found = run.driver.get("friction_class")
    run.close()
    if found != CLASSES[scene.verdict.kind] and not scene.verdict.border:
        outcome.problems.append(f"friction_class {found}, not {CLASSES[scene.verdict.kind]}")


def _turnover(row: dict[str, Any]) -> float:
    """J, the largest account."""
    return max(1e-9, *(abs(row[name]) for name in ACCOUNTS))


def residual(row: dict[str, Any]) -> float:
    return abs(row["energy.residual"]) / _turnover(row)


def falling_heats(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Heats that fall by more than a share of 1e-9 of the largest account. On wrong flanks they do, although
    the energy closes."""
    return [
        f"interval {number}: {name} falls by {before[name] - row[name]:.1e}"
        for number, (before, row) in enumerate(pairwise([dict.fromkeys(ACCOUNTS, 0.0), *rows]))
        for name in ACCOUNTS
        if "heat" in name and row[name] < before[name] - 1e-9 * _turnover(row)
    ]


def _scales(scene: Scene, points: Sequence[Point]) -> tuple[float, float]:
    """rad and rad/s in which errors are measured."""
    span = scene.params["stop.upper"] - scene.params["stop.lower"]
    speeds = [abs(scene.params.get("initial.omega", 0.0)), *(abs(p.omega) for p in points)]
    path = [scene.params["initial.theta"], *(p.theta for p in points)]
    mean = [abs(b - a) / i.duration for a, b, i in zip(path[:-1], path[1:], scene.intervals, strict=True)]
    return span, max(1e-6, *speeds, *mean)


def _follows_band(scene: Scene) -> bool:
    names = ("inertia.", "damper.", "shaft.damping")
    return not any(given for name, given in scene.params.items() if name.startswith(names))


def _distance(
    scene: Scene, one: tuple[float, float], other: tuple[float, float], scales: tuple[float, float]
) -> float:
    """The larger error of angle and speed, in their scales; without inertia and damping that of the angle."""
    angle = abs(one[0] - other[0]) / scales[0]
    return angle if _follows_band(scene) else max(angle, abs(one[1] - other[1]) / scales[1])


def _compare(
    scene: Scene, rows: Sequence[dict[str, Any]], points: Sequence[Point], tolerance: float, outcome: Outcome
) -> None:
    scales = _scales(scene, points)
    errors = [
        _distance(scene, (row["theta"], row["omega"]), (p.theta, p.omega), scales) / tolerance
        for row, p in zip(rows, points, strict=True)
    ]
    outcome.error = max(errors)
    wrong = []
    for number, (row, point, error) in enumerate(zip(rows, points, errors, strict=True)):
        if not error <= LIMIT:
            wrong.append(f"interval {number}: {error:.3g} tolerances")
        elif row["mode"] != point.mode:
            wrong.append(f"interval {number}: mode {row['mode']}, not {point.mode}")
        elif not point.doubtful and row["events"] != point.events:
            wrong.append(f"interval {number}: {row['events']} events, not {point.events}")
    if not wrong:
        return
    if _is_sensitive(scene, points, scales, outcome.error * tolerance, tolerance):
        outcome.open = "changes of the data by a tolerance change as much"
    else:
        outcome.problems.append(wrong[0])


def _is_sensitive(
    scene: Scene, points: Sequence[Point], scales: tuple[float, float], error: float, tolerance: float
) -> bool:
    """Does the reference change as much, or by a mode or event, under data changed by a tolerance?"""
    rng = np.random.default_rng([50, scene.seed])
    for _ in range(3):
        signs = iter(rng.choice([-1, 1], 200).tolist())
        params = nudged(scene.params, tolerance, signs)
        intervals = [
            Interval(i.duration, tuple(c * (1 + next(signs) * tolerance) for c in i.tau), i.f_ext)
            for i in scene.intervals
        ]
        try:
            others = solve(params, intervals, scene.verdict.kind == UNIQUE)
        except (Unresolved, Ambiguous):
            return True
        pairs = list(zip(points, others, strict=True))
        if any((p.mode, p.events) != (q.mode, q.events) and not p.doubtful for p, q in pairs):
            return True
        moved = max(_distance(scene, p[:2], q[:2], scales) for p, q in pairs)
        if error > LIMIT * tolerance and error <= 3 * moved:
            return True
    return False


def _compare_cut(
    library: Any,
    scene: Scene,
    rows: Sequence[dict[str, Any]],
    points: Sequence[Point],
    rng: np.random.Generator,
    tolerance: float,
    outcome: Outcome,
) -> None:
    cut = play(library, scene.params, [pieces(i, rng) for i in scene.intervals], tolerance)
    scales = _scales(scene, points)
    outcome.cut_error = max(
        _distance(scene, (a["theta"], a["omega"]), (b["theta"], b["omega"]), scales) / tolerance
        for a, b in zip(rows, cut, strict=True)
    )
    if not outcome.cut_error <= LIMIT and not outcome.problems and not outcome.open:
        error = outcome.cut_error * tolerance
        if _is_sensitive(scene, points, scales, error, tolerance):
            outcome.open = "changes of the data by a tolerance change as much"
        else:
            outcome.problems.append(f"cut anywhere: {outcome.cut_error:.3g} tolerances")


def judge_far(library: Any, seed: int, tolerance: float) -> Outcome:
    """A scene far outside: each answer is finite and gains no energy, or a message refuses the call."""
    drawn, intervals = draw_far(seed)
    limits = FORWARD.variables
    params = {
        name: type(given)(min(max(given, limits[name].min), limits[name].max))
        for name, given in drawn.items()
        if name in limits
    }
    outcome = Outcome(seed, "far outside")
    try:
        rows = play(library, params, [[i] for i in intervals], tolerance)
    except Refusal as refusal:
        outcome.refusal = plain(str(refusal))
        if outcome.refusal == "no message":
            outcome.problems.append("refused without a message")
        return outcome
    for row in rows:
        if not all(math.isfinite(row[name]) for name in (*OUTPUTS, *ACCOUNTS)):
            outcome.problems.append("not finite")
            return outcome
    outcome.residual = max(residual(row) for row in rows)
    if outcome.residual > 1e-6:
        outcome.problems.append(f"energy residual {outcome.residual:.1e}")
    outcome.problems += falling_heats(rows)
    return outcome


def plain(message: str) -> str:
    """The message without its numbers, so that those of one kind are counted together."""
    return re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", message.splitlines()[0])[:150]
