"""Steps of many runs at once, whose inputs are straight lines between points at times that vary.

The same as `Scenario.steps` for each run, computed with arrays: a line for each run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dualcam.reals import Array
from dualcam.study.history import History, Number
from dualcam.study.scenario import SAME_TIME, Scenario, Step, instants

Evaluate = Callable[[Number], Array]  # a number or a formula as an array, shape (runs,)
AT_ONE_INSTANT = 1e-9  # share of a step by which a reading may miss the end of the step
FIRST = -1  # of a result that is read before the first step


def is_piecewise_linear(scenario: Scenario, interpolates: bool, fixed: bool) -> bool:
    """Whether `steps_of_rows` can lay out the runs of a scenario."""
    lines = all(each.derivative_of or each.shape == "linear" for each in scenario.inputs.values())
    control = scenario.controller
    asks_vary = control is not None and (isinstance(control.period, str) or isinstance(scenario.stop, str))
    return lines and interpolates and not fixed and not asks_vary


@dataclass(frozen=True)
class StepRows:
    """Steps of runs that make the same calls.

    Attributes
    ----------
    places : ndarray of int, shape (runs,)
        Which rows these are.
    steps : tuple of Step
        Of the first of them.
    read_after : tuple of int
        For each result the step after which it is read; -1: before the first step.
    numbers : ndarray, shape (runs, numbers)
        Numbers of the steps of each run.
    """

    places: NDArray[np.intp]
    steps: tuple[Step, ...]
    read_after: tuple[int, ...]
    numbers: Array


class _Lines:
    """One input: points of all runs, shape (runs, points), and how often it is differentiated."""

    def __init__(self, history: History, order: int, evaluate: Evaluate) -> None:
        self.order = order
        self.time = np.column_stack([evaluate(each) for each in history.time])
        self.value = np.column_stack([evaluate(each) for each in history.value])

    @property
    def is_sound(self) -> NDArray[np.bool_]:
        """Which runs have finite points whose times do not decrease."""
        finite = np.all(np.isfinite(self.time) & np.isfinite(self.value), axis=1)
        return np.asarray(finite & np.all(np.diff(self.time, axis=1) >= 0.0, axis=1))

    def taylor(self, rows: NDArray[np.intp], start: Array, tolerance: Array) -> tuple[Array, Array]:
        """Value and first derivative at the start of a step: of the piece that starts there or goes on."""
        time, value = self.time[rows], self.value[rows]
        runs = np.arange(len(rows))
        # The last point that is not after the start; -1: before all points.
        place = np.sum(time <= (start + tolerance)[:, None], axis=1) - 1
        last = time.shape[1] - 1
        here, after = np.clip(place, 0, last), np.clip(place + 1, 0, last)
        width = time[runs, after] - time[runs, here]
        within = (place >= 0) & (place < last) & (width > 0.0)
        slope = np.where(
            within, (value[runs, after] - value[runs, here]) / np.where(width > 0.0, width, 1.0), 0.0
        )
        moved = value[runs, here] + slope * (start - time[runs, here])
        moved = np.where(within, moved, value[runs, here])
        if self.order == 0:
            return moved, slope
        return (slope if self.order == 1 else np.zeros_like(slope)), np.zeros_like(slope)


def steps_of_rows(
    scenario: Scenario, results: Sequence[str], evaluate: Evaluate, count: int
) -> tuple[list[StepRows], NDArray[np.intp]]:
    """The steps of `count` runs, by the calls that they make, and the places of runs that are no scenario."""
    lines = {}
    for name in scenario.inputs:
        history, order = scenario.source(name)
        lines[name] = _Lines(history, order, evaluate)
    stop = evaluate(scenario.stop)
    wanted = [_time_of(result, stop) for result in results]
    sound = np.isfinite(stop) & (stop > 0.0)
    for each in lines.values():
        sound &= each.is_sound
    for time in wanted:
        sound &= time <= stop
    rows = np.flatnonzero(sound)
    starts, steps_made = _starts(scenario, lines, wanted, stop, rows)
    ends = np.concatenate([starts[:, 1:], np.full((len(rows), 1), np.nan)], axis=1)
    ends[np.arange(len(rows)), steps_made - 1] = stop[rows]
    read_after = np.column_stack(
        [_step_that_ends_at(time[rows], starts, ends, steps_made) for time in wanted]
    )
    asked = _asked(scenario, starts, stop[rows])
    signature = np.column_stack([steps_made, read_after, asked])
    groups = []
    for line, which in _alike(signature):
        made, members = int(line[0]), rows[which]
        after = tuple(line[1 : 1 + len(wanted)].tolist())
        asks = line[1 + len(wanted) :][:made].astype(bool)
        groups.append(
            _group(lines, members, starts[which, :made], ends[which, :made], stop[members], after, asks)
        )
    return groups, np.flatnonzero(~sound)


def _time_of(result: str, stop: Array) -> Array:
    """The time at which a result is read, of each run."""
    return np.full(len(stop), instants([result], np.inf)[0][1]) if "@" in result else stop


def _starts(
    scenario: Scenario, lines: dict[str, _Lines], wanted: Sequence[Array], stop: Array, rows: NDArray[np.intp]
) -> tuple[Array, NDArray[np.intp]]:
    """Starts of the steps of each run, shape (runs, most steps), NaN beyond; and how many there are."""
    asks = scenario.asks()
    columns = [each.time[rows] for each in lines.values()]
    columns += [time[rows, None] for time in wanted]
    columns += [np.tile(asks, (len(rows), 1))] if asks else []
    marks = np.sort(np.concatenate(columns, axis=1), axis=1) if columns else np.empty((len(rows), 0))
    end = stop[rows]
    starts = np.full((len(rows), marks.shape[1] + 1), np.nan)
    starts[:, 0] = 0.0
    last, made = np.zeros(len(rows)), np.ones(len(rows), np.intp)
    for mark in marks.T:
        kept = np.flatnonzero((mark > last + SAME_TIME * end) & (mark < end * (1.0 - SAME_TIME)))
        starts[kept, made[kept]] = last[kept] = mark[kept]
        made[kept] += 1
    return starts[:, : made.max(initial=1)], made


def _step_that_ends_at(time: Array, starts: Array, ends: Array, made: NDArray[np.intp]) -> NDArray[np.intp]:
    with np.errstate(invalid="ignore"):
        hits = np.abs(ends - time[:, None]) <= AT_ONE_INSTANT * (ends - starts)
    return np.where(time == 0.0, FIRST, np.argmax(hits, axis=1))


def _asked(scenario: Scenario, starts: Array, stop: Array) -> NDArray[np.bool_]:
    """Whether the controller is asked before each step."""
    asks = np.asarray(scenario.asks())
    if len(asks) == 0:
        return np.zeros(starts.shape, bool)
    place = np.clip(np.searchsorted(asks, starts), 1, max(len(asks) - 1, 1))
    near = np.minimum(
        np.abs(asks[np.minimum(place, len(asks) - 1)] - starts), np.abs(asks[place - 1] - starts)
    )
    return np.asarray(near <= SAME_TIME * stop[:, None])


def _alike(signature: NDArray[np.intp]) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Different lines, and the places where each stands."""
    if len(signature) == 0:
        return []
    different, which = np.unique(signature, axis=0, return_inverse=True)
    which = np.ravel(which)
    return [(line, np.flatnonzero(which == place)) for place, line in enumerate(different)]


def _group(
    lines: dict[str, _Lines],
    rows: NDArray[np.intp],
    starts: Array,
    ends: Array,
    stop: Array,
    read_after: tuple[int, ...],
    asks: NDArray[np.bool_],
) -> StepRows:
    steps, columns = [], []
    for number in range(starts.shape[1]):
        start, size = starts[:, number], ends[:, number] - starts[:, number]
        taylor = {name: each.taylor(rows, start, SAME_TIME * stop) for name, each in lines.items()}
        rates = {(name, 1): slope for name, (_, slope) in taylor.items() if np.any(slope)}
        columns += [start, size, *(value for value, _ in taylor.values()), *rates.values()]
        values = {name: float(value[0]) for name, (value, _) in taylor.items()}
        own = {key: float(rate[0]) for key, rate in rates.items()}
        steps.append(Step(float(start[0]), float(size[0]), values, own, bool(asks[number])))
    return StepRows(rows, tuple(steps), read_after, np.column_stack(columns))
