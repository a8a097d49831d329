"""What is done in each run: histories of the inputs, or a controller, until the end."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from dualcam.fmu import Array
from dualcam.study.problem import StudyError

ORDER = 3  # of the input derivatives that FMI 2.0 masters send
STEPS_MAX = 1_000_000  # of one run: its calls are laid out in memory, which takes some hundred bytes for each
SAME_TIME = 1e-12  # instants closer than this share of the whole are one

Law = Callable[[float, list[float]], Sequence[float]]


@dataclass(frozen=True)
class History:
    """One input over time.

    Before the first time and after the last one the value stands still. An input that is the time derivative
    of another one, such as omega of theta, has `derivative_of` instead of points.

    Parameters
    ----------
    time : sequence of float
        Times [s], not decreasing. The same time twice is a jump.
    value : sequence of float
        Values at these times, in the FMU's unit.
    shape : {"linear", "smooth"}
        Between the points: straight lines, or the cubic spline that starts and ends at rest.
    derivative_of : str
        Name of the input whose time derivative this one is.

    Examples
    --------
    >>> from dualcam.study import History
    >>> push = History(time=[0.0, 0.2, 0.2], value=[8.0, 8.0, 0.0])  # s, N.m: 8 N.m for 0.2 s, then nothing
    >>> push.problem() is None
    True
    """

    time: Sequence[float] = ()
    value: Sequence[float] = ()
    shape: str = "linear"
    derivative_of: str = ""

    def problem(self) -> str | None:
        """What is wrong with the points, if anything is.

        Returns
        -------
        str or None
            What is given and what is allowed.
        """
        if self.derivative_of:
            return None
        if self.shape not in ("linear", "smooth"):
            return f"shape {self.shape!r}: allowed are linear, smooth"
        time = np.asarray(self.time, float)
        if len(time) == 0 or len(time) != len(self.value):
            return f"{len(self.value)} values at {len(time)} times: allowed is one value for each time"
        if not np.all(np.isfinite(np.concatenate([time, np.asarray(self.value, float)]))):
            return "times and values must be finite"
        steps = np.diff(time)
        if np.any(steps < 0.0) or (self.shape == "smooth" and (len(time) < 2 or np.any(steps <= 0.0))):
            return "times must increase; twice the same is allowed where it is linear"
        return None

    def taylor(self) -> list[tuple[float, list[float]]]:
        """The history as pieces of polynomials.

        Returns
        -------
        list of tuple
            The time [s] at which each piece starts, and there the value and its derivatives of orders 1 to 3.
        """
        time, value = np.asarray(self.time, float), np.asarray(self.value, float)
        before = (-math.inf, [float(value[0]), 0.0, 0.0, 0.0])
        after = (float(time[-1]), [float(value[-1]), 0.0, 0.0, 0.0])
        if self.shape == "smooth":
            from scipy.interpolate import CubicSpline

            spline = CubicSpline(time, value, bc_type="clamped")
            between = [
                (float(t), [math.factorial(k) * float(c[ORDER - k]) for k in range(ORDER + 1)])
                for t, c in zip(time[:-1], spline.c.T, strict=True)
            ]
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


@dataclass(frozen=True)
class Controller:
    """A closed loop in each run: a law is asked every period, and the FMU's inputs are held in between.

    Parameters
    ----------
    create_law : callable
        Function of a module that the workers can import. It returns a new law for each run: a function of the
        time [s] and of the values read, in the order of `reads`. The law returns the values to write.
    period : float
        Time between two calls of the law [s].
    reads : sequence of str
        Real variables that the law gets.
    writes : sequence of str
        Inputs that the law gives.

    Examples
    --------
    >>> from dualcam.study import Controller
    >>> def create_law():
    ...     return lambda time, values: [5.0 - 20.0 * values[0]]  # N.m, from theta [rad]
    >>> loop = Controller(create_law, period=1e-3, reads=["theta"], writes=["tau"])
    """

    create_law: Callable[[], Law]
    period: float
    reads: Sequence[str]
    writes: Sequence[str]


@dataclass(frozen=True)
class Step:
    """One step of every run, with input and derivative order -> value of what is sent before it; whether the
    controller is asked before it."""

    time: float
    size: float
    values: Mapping[str, float]
    rates: Mapping[tuple[str, int], float]
    control: bool


@dataclass(frozen=True)
class Scenario:
    """What is done in each run, from 0 to `stop`.

    Parameters
    ----------
    stop : float
        End of the run [s].
    inputs : mapping of str to History
        Inputs over time, by name. All others keep their start values.
    step : float, optional
        Step [s] for FMUs that take no derivatives of inputs, and for FMUs that need steps of one length. The
        inputs are then held over each step at their value in the middle. Other steps are as long as the
        histories allow.
    tolerance : float, optional
        Relative tolerance of the FMU's integrator.
    controller : Controller, optional
        A closed loop.

    Raises
    ------
    StudyError
        A number that is not finite and above 0, a history with a mistake, or an input with both a history and
        a controller.

    Examples
    --------
    >>> from dualcam.study import History, Scenario
    >>> Scenario(0.4, {"tau": History([0.0, 0.2, 0.2], [8.0, 8.0, 0.0])}).stop
    0.4
    """

    stop: float
    inputs: Mapping[str, History] = field(default_factory=dict)
    step: float | None = None
    tolerance: float | None = None
    controller: Controller | None = None

    def __post_init__(self) -> None:
        for name, number in (("stop", self.stop), ("step", self.step), ("tolerance", self.tolerance)):
            if number is not None and not (math.isfinite(number) and number > 0.0):
                raise StudyError(f"scenario: {name} = {number}: allowed is a finite number above 0")
        for name, history in self.inputs.items():
            if problem := history.problem():
                raise StudyError(f"scenario: {name}: {problem}")
            self._laws(name)
        control = self.controller
        if control is not None:
            if not hasattr(control.create_law, "__qualname__"):
                raise StudyError(
                    f"scenario: create_law = {control.create_law!r}: allowed is a function of a module"
                )
            if not (math.isfinite(control.period) and control.period > 0.0):
                raise StudyError(f"scenario: period = {control.period}: allowed is a finite number above 0")
            if both := set(control.writes) & set(self.inputs):
                raise StudyError(
                    f"scenario: {', '.join(both)} has a history and a controller: allowed is one of them"
                )

    def _laws(self, name: str, seen: tuple[str, ...] = ()) -> list[tuple[float, list[float]]]:
        """Taylor pieces of an input, differentiated as often as its history says."""
        history = self.inputs.get(name)
        if history is None or name in seen:
            raise StudyError(
                f"scenario: derivative of {name}, which has no history: allowed are {', '.join(self.inputs)}"
            )
        if not history.derivative_of:
            return history.taylor()
        pieces = self._laws(history.derivative_of, (*seen, name))
        return [(start, [*values[1:], 0.0]) for start, values in pieces]

    def steps(self, reads: Sequence[float], interpolates: bool, fixed: bool) -> list[Step]:
        """The steps of a run that can be read at given times.

        Parameters
        ----------
        reads : sequence of float
            Times [s].
        interpolates : bool
            Whether the FMU takes derivatives of inputs.
        fixed : bool
            Whether the FMU needs steps of one length.

        Returns
        -------
        list of Step
            From 0 to `stop`.

        Raises
        ------
        StudyError
            The FMU needs `step`, or a time is no multiple of `step`.
        """
        laws = {name: self._laws(name) for name in self.inputs}
        marks = [start for pieces in laws.values() for start, _ in pieces] + list(reads)
        bends = any(any(values[1:]) for pieces in laws.values() for _, values in pieces)
        if (fixed or (bends and not interpolates)) and self.step is None:
            why = (
                "needs steps of one length" if fixed else "takes no derivatives of inputs, which change here"
            )
            raise StudyError(f"scenario: this FMU {why}: give step, in seconds")
        asks = self._multiples(self.controller.period) if self.controller else []
        grid = self._multiples(self.step) if self.step and (fixed or (bends and not interpolates)) else []
        times = self._merged([*([] if fixed else marks), *([] if fixed else asks), *grid])
        if fixed:
            self._check_grid(times, [*marks, *asks])
        return [
            self._make_step(laws, start, end, interpolates, self._is_in(asks, start))
            for start, end in pairwise(times)
        ]

    def _multiples(self, period: float) -> list[float]:
        count = math.ceil(min(self.stop / period, 2.0 * STEPS_MAX) * (1.0 - SAME_TIME))
        if count > STEPS_MAX:
            raise StudyError(
                f"scenario: {self.stop:g} s in steps of {period:g} s: allowed are up to {STEPS_MAX:,} steps"
            )
        return [k * period for k in range(count)]

    def _is_in(self, instants: Sequence[float], time: float) -> bool:
        return any(abs(other - time) <= SAME_TIME * self.stop for other in self._near(instants, time))

    def _near(self, instants: Sequence[float], time: float) -> Sequence[float]:
        place = int(np.searchsorted(instants, time))
        return instants[max(place - 1, 0) : place + 1]

    def _merged(self, marks: Sequence[float]) -> list[float]:
        """Instants from 0 to the end, those that differ by rounding once."""
        times = [0.0]
        for mark in sorted(marks):
            if mark > times[-1] + SAME_TIME * self.stop and mark < self.stop * (1.0 - SAME_TIME):
                times.append(float(mark))
        return [*times, self.stop]

    def _check_grid(self, times: Sequence[float], marks: Sequence[float]) -> None:
        last = times[-1] - times[-2]
        if self.step is not None and abs(last - self.step) > 1e-9 * self.step:
            raise StudyError(
                f"scenario: stop = {self.stop:g} is no multiple of step = {self.step:g}, the FMU needs that"
            )
        for mark in marks:
            if 0.0 < mark < self.stop and not self._is_in(times, mark):
                raise StudyError(
                    f"scenario: {mark:g} s is no multiple of step = {self.step:g}, the FMU needs that"
                )

    def _make_step(
        self,
        laws: Mapping[str, list[tuple[float, list[float]]]],
        start: float,
        end: float,
        interpolates: bool,
        control: bool,
    ) -> Step:
        values: dict[str, float] = {}
        rates: dict[tuple[str, int], float] = {}
        for name, pieces in laws.items():
            origin, taylor = [piece for piece in pieces if piece[0] <= start + SAME_TIME * self.stop][-1]
            instant = start if interpolates else (start + end) / 2.0
            shift = instant - origin if math.isfinite(origin) else 0.0
            moved = _moved(taylor, shift)
            values[name] = moved[0]
            if interpolates:
                rates |= {(name, order): moved[order] for order in range(1, ORDER + 1) if moved[order] != 0.0}
        return Step(start, end - start, values, rates, control)


def _moved(taylor: Sequence[float], shift: float) -> list[float]:
    """Value and derivatives a while later."""
    count = len(taylor)
    return [sum(taylor[k + n] * shift**n / math.factorial(n) for n in range(count - k)) for k in range(count)]


def instants(results: Sequence[str], stop: float) -> list[tuple[str, float]]:
    """Variable and time [s] of results such as `theta`, at the end, and `theta@0.2`."""
    found: list[tuple[str, float]] = []
    for result in results:
        name, at, text = result.partition("@")
        try:
            time = float(text) if at else stop
        except ValueError:
            time = math.nan
        if not 0.0 <= time <= stop:
            raise StudyError(
                f"result {result!r}: allowed is a name, or name@time with a time from 0 to {stop:g} s"
            )
        found.append((name, time))
    return found


def times_of(results: Sequence[str], stop: float) -> Array:
    return np.unique([time for _, time in instants(results, stop)])
