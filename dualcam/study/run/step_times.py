"""Steps of runs as numbers in one buffer: runs of the same steps differ in these numbers alone.

The FMI calls of a run are laid out once for each arrangement of steps, on the views of a buffer. A row of the
plan is then a line of numbers that is copied into the buffer before the first call.

Where inputs are lines or smooth curves between points at times that vary, the steps of many runs, the same as
`Scenario.steps` for each, are computed with arrays: a line for each run."""

import math
from collections.abc import Callable, Sequence
from ctypes import c_double, sizeof
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dualcam.fmi.reals import Array
from dualcam.scenario.history import ORDER, History, Number
from dualcam.scenario.scenario import SAME_TIME, Scenario, Step, instants, source_of

Key = tuple[Any, ...]
Evaluate = Callable[[Number], Array]  # a number or a formula as an array, shape (runs,)
AT_ONE_INSTANT = 1e-9  # share of a step by which a reading may miss the end of the step
FIRST = -1  # of a result that is read before the first step


@dataclass(frozen=True)
class Arrangement:
    """Which calls the steps make, and the views on their numbers: times, sizes, inputs and their rates.

    `steps` are those of one run. `read_after` has for each result the step after which it is read; -1: before
    the first step."""

    steps: tuple[Step, ...]
    read_after: tuple[int, ...]

    @cached_property
    def buffer(self) -> Any:  # noqa: ANN401
        """The numbers, an array of c_double."""
        numbers = numbers_of(self.steps)
        return (c_double * len(numbers))(*numbers)

    @cached_property
    def key(self) -> Key:
        """Equal for runs that make the same calls."""
        calls = tuple((step.control, tuple(step.values), tuple(step.rates)) for step in self.steps)
        return self.read_after, calls

    @cached_property
    def _begins(self) -> list[int]:
        """Where the numbers of each step begin."""
        return np.cumsum([0, *(2 + len(step.values) + len(step.rates) for step in self.steps)]).tolist()

    def view(self, place: int, part: str) -> Any:  # noqa: ANN401
        """The numbers of a step as C has them, a view on `buffer`: "time", "size", "values" or "rates"."""
        start, step = self._begins[place], self.steps[place]
        at, count = {
            "time": (0, 0),
            "size": (1, 0),
            "values": (2, len(step.values)),
            "rates": (2 + len(step.values), len(step.rates)),
        }[part]
        kind = c_double * count if part in ("values", "rates") else c_double
        return kind.from_buffer(self.buffer, (start + at) * sizeof(c_double))


def numbers_of(steps: Sequence[Step]) -> list[float]:
    """The numbers of all steps, one after another."""
    found: list[float] = []
    for step in steps:
        found += [step.time, step.size, *step.values.values(), *step.rates.values()]
    return found


@dataclass(frozen=True)
class Group:
    """Runs of one arrangement: their places among the rows, and a line of numbers for each."""

    arrangement: Arrangement
    places: NDArray[np.intp]
    numbers: Array


# ---- many runs at once ----


def has_points(scenario: Scenario, interpolates: bool, fixed: bool) -> bool:
    """Whether `groups_of_rows` can lay out the runs of a scenario."""
    points = all(each.derivative_of or each.shape != "sine" for each in scenario.inputs.values())
    control = scenario.controller
    asks_vary = control is not None and (isinstance(control.period, str) or isinstance(scenario.stop, str))
    return points and interpolates and not fixed and not asks_vary


class _Curve:
    """One input: points of all runs, shape (runs, points), and how often it is differentiated."""

    def __init__(self, history: History, order: int, evaluate: Evaluate) -> None:
        self._order, self._is_smooth = order, history.shape == "smooth"
        self.time = np.column_stack([evaluate(each) for each in history.time])
        self._value = np.column_stack([evaluate(each) for each in history.value])
        with np.errstate(all="ignore"):  # of runs that are not sound
            self.is_sound = self._checked()
            self._taylor = self._pieces()

    def _checked(self) -> NDArray[np.bool_]:
        """Which runs have finite points at times that suit the shape."""
        finite = np.all(np.isfinite(self.time) & np.isfinite(self._value), axis=1)
        steps = np.diff(self.time, axis=1)
        rising = np.all(steps > 0.0, axis=1) if self._is_smooth else np.all(steps >= 0.0, axis=1)
        return np.asarray(finite & rising & (not self._is_smooth or self.time.shape[1] > 1))

    def _pieces(self) -> Array:
        """Value and derivatives at each point, of the piece that starts there, shape (orders, runs, points).
        Behind the last point the value stands still."""
        taylor = np.zeros((1 + (ORDER if self._is_smooth else 1), *self.time.shape))
        taylor[0] = self._value
        width = np.diff(self.time, axis=1)
        width = np.where(width > 0.0, width, np.inf)  # a jump, whose piece is never the last that starts
        slope = np.diff(self._value, axis=1) / width
        if self._is_smooth:
            taylor[1:, :, :-1] = _derivatives_of_spline(width, slope)
        else:
            taylor[1, :, :-1] = slope
        return taylor

    def taylor(self, rows: NDArray[np.intp], start: Array, tolerance: Array) -> list[Array]:
        """Value and derivatives at the start of a step: of the piece that starts there or goes on."""
        time = self.time[rows]
        # The last point that is not after the start; -1: before all points.
        place = np.sum(time <= (start + tolerance)[:, None], axis=1) - 1
        is_before = place < 0
        here = np.maximum(place, 0)
        runs = np.arange(len(rows))
        shift = np.where(is_before, 0.0, start - time[runs, here])
        own = [np.where(is_before & (k > 0), 0.0, each[rows, here]) for k, each in enumerate(self._taylor)]
        own = [*own, *[np.zeros(len(rows))] * self._order][self._order :]
        return [
            sum((own[k + n] * shift**n / math.factorial(n) for n in range(1, len(own) - k)), own[k])
            for k in range(len(own))
        ]


def _derivatives_of_spline(width: Array, slope: Array) -> Array:
    """First to third derivative at the start of each piece of the cubic splines that start and end at rest,
    shape (3, runs, pieces).

    The speeds s_i at the inner points follow from continuous second derivatives, with w_i and d_i the width
    and the mean slope of a piece:

        w_i s_(i-1) + 2 (w_(i-1) + w_i) s_i + w_(i-1) s_(i+1) = 3 (w_i d_(i-1) + w_(i-1) d_i)

    (de Boor, A Practical Guide to Splines, chapter IV), by elimination, as the diagonal dominates."""
    runs, pieces = width.shape
    speed = np.zeros((runs, pieces + 1))
    above = np.zeros((runs, pieces))  # what remains of s_(i+1) in row i, divided by the diagonal
    for k in range(1, pieces):
        before, after = width[:, k - 1], width[:, k]
        diagonal = 2.0 * (before + after) - after * above[:, k - 1]
        above[:, k] = before / diagonal
        right = 3.0 * (after * slope[:, k - 1] + before * slope[:, k])
        speed[:, k] = (right - after * speed[:, k - 1]) / diagonal
    for k in range(pieces - 1, 0, -1):
        speed[:, k] -= above[:, k] * speed[:, k + 1]
    bend = (speed[:, :-1] + speed[:, 1:] - 2.0 * slope) / width
    return np.stack([speed[:, :-1], 2.0 * ((slope - speed[:, :-1]) / width - bend), 6.0 * bend / width])


def groups_of_rows(
    scenario: Scenario, results: Sequence[str], evaluate: Evaluate, count: int
) -> tuple[list[Group], NDArray[np.intp]]:
    """The steps of `count` runs, by the calls that they make, and the places of runs that are no scenario."""
    curves = {}
    for name in scenario.inputs:
        history, order = source_of(scenario.inputs, name)
        curves[name] = _Curve(history, order, evaluate)
    stop = evaluate(scenario.stop)
    wanted = [
        np.full(count, instants([result], np.inf)[0][1]) if "@" in result else stop for result in results
    ]
    sound = np.isfinite(stop) & (stop > 0.0)
    for each in curves.values():
        sound &= each.is_sound
    for time in wanted:
        sound &= time <= stop
    rows = np.flatnonzero(sound)
    starts, steps_made = _starts(scenario, curves, wanted, stop, rows)
    ends = np.concatenate([starts[:, 1:], np.full((len(rows), 1), np.nan)], axis=1)
    ends[np.arange(len(rows)), steps_made - 1] = stop[rows]
    read_after = np.column_stack(
        [_step_that_ends_at(time[rows], starts, ends, steps_made) for time in wanted]
    )
    asked = _asked(scenario, starts, stop[rows])
    signature = np.column_stack([steps_made, read_after, asked])
    different, alike = np.unique(signature, axis=0, return_inverse=True)
    groups = []
    for number, line in enumerate(different):
        which = np.flatnonzero(np.ravel(alike) == number)
        made, members = int(line[0]), rows[which]
        after = tuple(line[1 : 1 + len(wanted)].tolist())
        asks = line[1 + len(wanted) :][:made].astype(bool)
        groups.append(
            _group(curves, members, starts[which, :made], ends[which, :made], stop[members], after, asks)
        )
    return groups, np.flatnonzero(~sound)


def _starts(
    scenario: Scenario,
    curves: dict[str, _Curve],
    wanted: Sequence[Array],
    stop: Array,
    rows: NDArray[np.intp],
) -> tuple[Array, NDArray[np.intp]]:
    """Starts of the steps of each run, shape (runs, most steps), NaN beyond; and how many there are."""
    asks = scenario.asks()
    columns = [each.time[rows] for each in curves.values()]
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


def _group(
    curves: dict[str, _Curve],
    rows: NDArray[np.intp],
    starts: Array,
    ends: Array,
    stop: Array,
    read_after: tuple[int, ...],
    asks: NDArray[np.bool_],
) -> Group:
    steps, columns = [], []
    for number in range(starts.shape[1]):
        start, size = starts[:, number], ends[:, number] - starts[:, number]
        taylor = {name: each.taylor(rows, start, SAME_TIME * stop) for name, each in curves.items()}
        rates = {
            (name, order): own[order]
            for name, own in taylor.items()
            for order in range(1, len(own))
            if np.any(own[order])
        }
        columns += [start, size, *(own[0] for own in taylor.values()), *rates.values()]
        values = {name: float(own[0][0]) for name, own in taylor.items()}
        own = {key: float(rate[0]) for key, rate in rates.items()}
        steps.append(Step(float(start[0]), float(size[0]), values, own, bool(asks[number])))
    return Group(Arrangement(tuple(steps), read_after), rows, np.column_stack(columns))
