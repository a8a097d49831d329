"""Inputs over time: points with lines or curves between them, and sines. Numbers may be formulas."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from dualcam.common.arrays import Array, real_array
from dualcam.common.mistakes import StudyError
from dualcam.scenario.formula import formula, is_formula

ORDER = 3  # of the input derivatives that FMI 2.0 masters send
STEPS_MAX = 1_000_000  # of one run: its calls are laid out in memory, which takes some hundred bytes for each
SHAPES = ("linear", "smooth", "sine")
AT_POINT = 1e-9  # share of a piece's length from its ends within which an extreme is that of the point there
PIECES = 24  # cubic pieces of a sine's period: their error is 1.2e-5 of the amplitude

Number = Any  # a float, or a str: a formula over the values of a run, which `at` turns into a float


@dataclass(frozen=True)
class History:
    """One input over time.

    Before the first time and after the last one the value stands still. An input that is the time derivative
    of another one, such as omega of theta, has `derivative_of` instead of points.

    Parameters
    ----------
    time : Times [s], not decreasing. The same time twice is a jump.
    value : Values at these times, in the FMU's unit.
    shape : {"linear", "smooth", "sine"}
        Between the points: straight lines, or the cubic spline that starts and ends at rest, which can go
        beyond the largest and the least point. "sine" has no points:
        mean + amplitude sin(2 pi frequency t + phase).
    derivative_of : Name of the input whose time derivative this one is.
    mean, amplitude : Of "sine", in the FMU's unit.
    frequency : Of "sine" [Hz], above 0.
    phase : Of "sine" [rad].

    Notes
    -----
    Every number may be a text: a formula over the names that vary, such as "peak" or "0.2 + delay".

    Examples
    --------
    >>> from dualcam.study import History
    >>> push = History(time=[0.0, 0.2, 0.2], value=[8.0, 8.0, 0.0])  # s, N.m: 8 N.m for 0.2 s, then nothing
    >>> push.problems()
    []
    >>> History(time=[0.0, "end", "end"], value=["peak", "peak", 0.0]).names
    ('end', 'peak')
    """

    time: Sequence[Number] = ()
    value: Sequence[Number] = ()
    shape: str = "linear"
    derivative_of: str = ""
    mean: Number = 0.0
    amplitude: Number = 0.0
    frequency: Number = 0.0
    phase: Number = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """The names in formulas, each once."""
        return names_in([*self.time, *self.value, *self._wave])

    @property
    def _wave(self) -> tuple[Number, ...]:
        return self.mean, self.amplitude, self.frequency, self.phase

    def at(self, values: Mapping[str, float]) -> History:
        """The history with the numbers of a run: without formulas. `values` of the run by name."""
        if not self.names:
            return self
        time, value = ([number_at(n, values) for n in each] for each in (self.time, self.value))
        return History(
            time, value, self.shape, self.derivative_of, *(number_at(n, values) for n in self._wave)
        )

    def problems(self) -> list[str]:
        """All that is wrong with the points, as far as it does not depend on the run."""
        if self.derivative_of:
            return []
        found = [
            problem for number in [*self.time, *self.value, *self._wave] for problem in _of_formula(number)
        ]
        if self.shape not in SHAPES:
            found.append(f"shape {self.shape!r}: allowed are {', '.join(SHAPES)}")
        elif self.shape == "sine":
            return found + self._problems_of_wave()
        elif any(self._wave):
            found.append(
                "amplitude, frequency, mean and phase belong to shape = 'sine': allowed are time and value"
            )
        return found + self._problems_of_points()

    def _problems_of_points(self) -> list[str]:
        found = []
        if len(self.time) == 0 or len(self.time) != len(self.value):
            found.append(
                f"{len(self.value)} values at {len(self.time)} times: allowed is one value for each time"
            )
        for name, numbers in (("time", self.time), ("value", self.value)):
            try:
                given = [number for number in numbers if number is not None and not isinstance(number, str)]
                real_array(given, name, StudyError)
            except StudyError as error:
                return [*found, str(error)]
            strange = [number for number in map(known_number, numbers) if number is not None]
            found += [
                f"{name} = {number:g}: allowed are finite numbers"
                for number in strange
                if not math.isfinite(number)
            ][:1]
        return found + self._problems_of_order()

    def _problems_of_order(self) -> list[str]:
        """Numbers that stand beside formulas are in order, too."""
        times = [time for time in map(known_number, self.time) if time is not None and math.isfinite(time)]
        allowed = "allowed are times that do not fall; the same time twice is a jump, where it is linear"
        for before, after in pairwise(times):
            if after < before or (after == before and self.shape == "smooth"):
                return [f"times must increase: {after:g} s comes after {before:g} s: {allowed}"]
        if self.shape == "smooth" and len(self.time) == 1:
            return ["times must increase: a smooth curve needs two or more"]
        return []

    def _problems_of_wave(self) -> list[str]:
        found = []
        if len(self.time) or len(self.value):
            found.append("shape sine has time or value: allowed are amplitude, frequency, mean and phase")
        numbers = [known_number(each) for each in self._wave]
        if not all(number is None or math.isfinite(number) for number in numbers):
            found.append("amplitude, frequency, mean and phase must be finite")
        elif numbers[2] is not None and not numbers[2] > 0.0:
            found.append(f"frequency = {numbers[2]:g}: allowed is above 0")
        return found

    def taylor(self, stop: float = 0.0) -> list[tuple[float, list[float]]]:
        """The history as pieces of polynomials: the time [s] at which each piece starts, and there the value
        and its derivatives of orders 1 to 3.

        `stop`: end of the pieces of a "sine" [s].
        """
        if self.shape == "sine":
            return self._wave_pieces(stop)
        time, value = np.asarray(self.time, float), np.asarray(self.value, float)
        before = (-math.inf, [float(value[0]), 0.0, 0.0, 0.0])
        after = (float(time[-1]), [float(value[-1]), 0.0, 0.0, 0.0])
        if self.shape == "smooth":
            from scipy.interpolate import CubicSpline

            between = _cubics(time, CubicSpline(time, value, bc_type="clamped"))
        else:
            between = [
                (
                    float(time[k]),
                    [float(value[k]), float((value[k + 1] - value[k]) / (time[k + 1] - time[k])), 0.0, 0.0],
                )
                for k in range(len(time) - 1)
                if time[k + 1] > time[k]
            ]
        return [before, *between, after]

    @cached_property
    def extremes(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Time [s] and value where the history is least, and where it is largest. Only of one with points."""
        time, value = np.asarray(self.time, float), np.asarray(self.value, float)
        if self.shape == "smooth":
            between = _turning_points(self.taylor()[1:])
            time, value = np.append(time, between[0]), np.append(value, between[1])
        low, high = int(np.argmin(value)), int(np.argmax(value))
        return (float(time[low]), float(value[low])), (float(time[high]), float(value[high]))

    def derivative(self) -> History:
        """Of "sine": the time derivative, which is a sine, too."""
        rate = 2.0 * math.pi * self.frequency
        amplitude, phase = rate * self.amplitude, self.phase + math.pi / 2.0
        return replace(self, mean=0.0, amplitude=amplitude, phase=phase)

    def _wave_pieces(self, stop: float) -> list[tuple[float, list[float]]]:
        """Cubics with the sine's values and slopes at their ends."""
        from scipy.interpolate import CubicHermiteSpline

        rate = 2.0 * math.pi * self.frequency
        count = math.ceil(min(PIECES * self.frequency * stop, 2.0 * STEPS_MAX))
        if count > STEPS_MAX:
            raise StudyError(
                f"frequency = {self.frequency:g} Hz over {stop:g} s: allowed are up to "
                f"{STEPS_MAX // PIECES:,} periods"
            )
        time = np.linspace(0.0, stop, max(count, 1) + 1)
        angle = rate * time + self.phase
        value = self.mean + self.amplitude * np.sin(angle)
        return _cubics(time, CubicHermiteSpline(time, value, rate * self.amplitude * np.cos(angle)))


def _cubics(time: Array, spline: Any) -> list[tuple[float, list[float]]]:  # noqa: ANN401
    """The pieces of a cubic spline: where each starts, value and derivatives there."""
    return [
        (float(t), [math.factorial(k) * float(c[ORDER - k]) for k in range(ORDER + 1)])
        for t, c in zip(time[:-1], spline.c.T, strict=True)
    ]


def _turning_points(pieces: Sequence[tuple[float, list[float]]]) -> tuple[Array, Array]:
    """Times [s] and values where the slope of cubic pieces is 0, each up to the start of the next, inside."""
    start = np.array([time for time, _ in pieces])
    value, slope, bend, jerk = np.array([taylor for _, taylor in pieces[:-1]]).T
    length = np.diff(start)
    with np.errstate(all="ignore"):  # slope + bend h + jerk h^2/2 = 0, which may have no root
        far = -(bend + np.copysign(np.sqrt(bend**2 - 2.0 * slope * jerk), bend))
        roots = np.array([far / jerk, 2.0 * slope / far])
        inside = (roots > AT_POINT * length) & (roots < (1.0 - AT_POINT) * length)
        values = value + roots * (slope + roots * (bend / 2.0 + roots * jerk / 6.0))
        return (start[:-1] + roots)[inside], values[inside]


def names_in(numbers: Sequence[Number]) -> tuple[str, ...]:
    """The names in those that are formulas, each once."""
    found = [name for number in numbers if is_formula(number) for name in formula(number).names]
    return tuple(dict.fromkeys(found))


def number_at(number: Number, values: Mapping[str, Any]) -> float:
    """The number itself, or the formula's value."""
    return float(formula(number)(values)) if isinstance(number, str) else float(number)


def numbers_in(number: Number, columns: Mapping[str, Array], count: int) -> Array:
    """The number, or the formula's value, in each of `count` rows with these columns."""
    if isinstance(number, str):
        return formula(number).numbers(columns, count)
    return np.full(count, float(number))


def known_number(number: Number) -> float | None:
    """A number that is the same in each run; None for a formula of names, and for what is no number."""
    if not isinstance(number, str):
        return None if number is None else float(number)
    return None if _of_formula(number) or formula(number).names else number_at(number, {})


def _of_formula(number: Number) -> list[str]:
    """What is wrong with a formula; nothing is with a number."""
    if not isinstance(number, str):
        return []
    try:
        found = formula(number)
        if found.names:
            return []
        value = found({})
    except StudyError as error:
        return [str(error)]
    return [
        f"{number!r}, a text in which no name varies: allowed is a number, such as {value:.12g}, a number"
        " with its unit in quotes, or a formula of names that vary"
    ]


def problem_of_number(name: str, number: Number, above: float = 0.0) -> list[str]:
    """What is wrong with a number or a formula, if anything is."""
    if problems := _of_formula(number):
        return [f"{name} = {problem}" for problem in problems]
    value = known_number(number)
    if value is None or (math.isfinite(value) and value > above):
        return []
    return [f"{name} = {number}: allowed is a finite number{' above 0' if above == 0.0 else ''}"]
