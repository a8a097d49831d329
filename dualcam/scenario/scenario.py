"""What is done in each run: histories of the inputs, or a controller, until the end."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from dualcam.common.entries import hint, repeated
from dualcam.common.mistakes import StudyError, refuse
from dualcam.scenario.history import ORDER, STEPS_MAX, History, Number, names_in, number_at, problem_of_number

SAME_TIME = 1e-12  # instants closer than this share of the whole are one

Law = Callable[[float, list[float]], Sequence[float]]


@dataclass(frozen=True)
class Controller:
    """A closed loop in each run: a law is asked every period, and the FMU's inputs are held in between.

    Parameters
    ----------
    create_law
        Function of a module that the workers can import. It returns a new law for each run: a function of the
        time [s] and of the values read, in the order of `reads`. The law returns one number for each of
        `writes`, in their order.
    period : Time between two calls of the law [s], or a formula.
    reads : Real variables that the law gets.
    writes : Inputs that the law gives.
    arguments : Arguments that `create_law` gets by name: numbers, or formulas over the names that vary.

    Examples
    --------
    >>> from dualcam.study import Controller
    >>> def create_law():
    ...     return lambda time, values: [5.0 - 20.0 * values[0]]  # N.m, from theta [rad]
    >>> loop = Controller(create_law, period=1e-3, reads=["theta"], writes=["tau"])
    """

    create_law: Callable[..., Law]
    period: Number
    reads: Sequence[str]
    writes: Sequence[str]
    arguments: Mapping[str, Number] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """The names in formulas, each once."""
        return names_in([self.period, *self.arguments.values()])

    def problems(self) -> list[str]:
        """All that is wrong, as far as it does not depend on the run."""
        found = problem_of_number("controller.period", self.period)
        if not hasattr(self.create_law, "__qualname__"):
            found.append(f"create_law = {self.create_law!r}: allowed is a function of a module")
        for key in ("reads", "writes"):
            if repeated(names := getattr(self, key)):
                found.append(f"controller.{key} = {list(names)}: allowed is each variable once")
        for name, number in self.arguments.items():
            found += problem_of_number(f"argument {name}", number, above=-math.inf)
        return found

    def at(self, values: Mapping[str, float | str]) -> Controller:
        """The controller with the numbers of a run: without formulas. `values` of the run by name; of an
        argument that is such a name alone, also a text.
        """
        arguments = {
            name: text if isinstance(text := values.get(str(each)), str) else number_at(each, values)
            for name, each in self.arguments.items()
        }
        return replace(self, period=number_at(self.period, values), arguments=arguments)


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
    stop : End of the run [s].
    inputs : Inputs over time, by name. All others keep their start values.
    step
        Step [s] for FMUs that take no derivatives of inputs, and for FMUs that need steps of one length. The
        inputs are then held over each step at their value in the middle. Other steps are as long as the
        histories allow.
    tolerance : Relative tolerance of the FMU's integrator.
    controller : A closed loop.

    Raises
    ------
    StudyError
        All that is wrong: a number that is not finite and above 0, a history with a mistake, a formula that
        is none, or an input with both a history and a controller.

    Notes
    -----
    Every number may be a text: a formula over the names that vary. `names` says which names the scenario
    needs, `at` gives the scenario of a run.

    Examples
    --------
    >>> from dualcam.study import History, Scenario
    >>> Scenario(0.4, {"tau": History([0.0, 0.2, 0.2], [8.0, 8.0, 0.0])}).stop
    0.4
    """

    stop: Number
    inputs: Mapping[str, History] = field(default_factory=dict)
    step: Number | None = None
    tolerance: float | None = None
    controller: Controller | None = None

    def __post_init__(self) -> None:
        refuse(f"scenario: {problem}" for problem in self.problems())

    def problems(self) -> list[str]:
        """All that is wrong, as far as it does not depend on the run."""
        found = [
            problem
            for key in ("stop", "step", "tolerance")
            for problem in problem_of_number(key, getattr(self, key))
        ]
        for name, history in self.inputs.items():
            own = [f"{name}: {problem}" for problem in history.problems()]
            found += own or self._problems_of_source(name)
        control = self.controller
        if control is not None:
            found += control.problems()
            found += [
                f"{name} has a history and a controller: allowed is one of them"
                for name in control.writes
                if name in self.inputs
            ]
        return found

    def _problems_of_source(self, name: str) -> list[str]:
        """What is wrong with the history whose derivative an input is."""
        other = self.inputs[name].derivative_of
        if other and other not in self.inputs:
            return [f"{name}: derivative of {other}, which has no history{hint(other, self.inputs)}"]
        chain = [name]
        while other in self.inputs:
            if other in chain:
                circle = ", ".join(sorted(chain[chain.index(other) :]))
                allowed = "allowed is one with time and value"
                return [f"{circle} are derivatives of each other in a circle: {allowed}"]
            chain.append(other)
            other = self.inputs[other].derivative_of
        return []

    # ---- numbers of a run ----

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names that the formulas use, each once; none if every run has the same scenario."""
        own = names_in([number for number in (self.stop, self.step) if number is not None])
        parts = [own, *(history.names for history in self.inputs.values())]
        if self.controller:
            parts.append(self.controller.names)
        return tuple(dict.fromkeys(name for part in parts for name in part))

    def at(self, values: Mapping[str, float | str]) -> Scenario:
        """The scenario with the numbers of a run: without formulas.

        `values` of the run by name, at least those of `names`. StudyError: these numbers are no scenario.
        """
        if not self.names:
            return self
        numbers: Any = values
        stop, step = (None if each is None else number_at(each, numbers) for each in (self.stop, self.step))
        inputs = {name: history.at(numbers) for name, history in self.inputs.items()}
        control = self.controller.at(values) if self.controller else None
        return Scenario(stop, inputs, step, self.tolerance, control)

    def facts(self) -> dict[str, Any]:
        """What makes two scenarios the same, as plain data."""
        facts: dict[str, Any] = {
            "stop": self.stop,
            "inputs": {},
            "step": self.step,
            "tolerance": self.tolerance,
        }
        for name, history in self.inputs.items():
            own = {"time": history.time, "value": history.value, "shape": history.shape}
            own["derivative_of"] = history.derivative_of
            facts["inputs"][name] = own | ({"wave": history._wave} if history.shape == "sine" else {})
        control = self.controller
        facts["controller"] = control and {
            "create_law": f"{control.create_law.__module__}.{control.create_law.__qualname__}",
            "period": control.period,
            "reads": control.reads,
            "writes": control.writes,
            **({"arguments": dict(control.arguments)} if control.arguments else {}),
        }
        return facts

    # ---- steps of a run ----

    def _laws(self, name: str) -> list[tuple[float, list[float]]]:
        """Taylor pieces of an input, differentiated as often as its history says."""
        history, times = source_of(self.inputs, name)
        if history.shape == "sine":
            for _ in range(times):
                history = history.derivative()
            return history.taylor(self.stop)
        pieces = history.taylor()
        for _ in range(times):
            pieces = [(start, [*values[1:], 0.0]) for start, values in pieces]
        return pieces

    def steps(self, reads: Sequence[float], interpolates: bool, fixed: bool) -> list[Step]:
        """The steps of a run that can be read at given times: from 0 to `stop`.

        `reads`: times [s]. `interpolates`: whether the FMU takes derivatives of inputs. `fixed`: whether the
        FMU needs steps of one length. StudyError: the FMU needs `step`, or a time is no multiple of `step`.
        """
        laws = {name: self._laws(name) for name in self.inputs}
        marks = [start for pieces in laws.values() for start, _ in pieces] + list(reads)
        bends = any(any(values[1:]) for pieces in laws.values() for _, values in pieces)
        if (fixed or (bends and not interpolates)) and self.step is None:
            why = (
                "needs steps of one length" if fixed else "takes no derivatives of inputs, which change here"
            )
            raise StudyError(f"scenario: this FMU {why}: give step, in seconds")
        asks = self.asks()
        grid = self._multiples(self.step) if self.step and (fixed or (bends and not interpolates)) else []
        times = self._merged([*([] if fixed else marks), *([] if fixed else asks), *grid])
        if fixed:
            self._check_grid(times, [*marks, *asks])
        return [
            self._make_step(laws, start, end, interpolates, self._is_in(asks, start))
            for start, end in pairwise(times)
        ]

    def asks(self) -> list[float]:
        """Times [s] at which the controller is asked; none without one. StudyError for too many."""
        return self._multiples(self.controller.period) if self.controller else []

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


def source_of(inputs: Mapping[str, History], name: str) -> tuple[History, int]:
    """The history with points or a sine from which an input follows, and how often it is differentiated."""
    times = 0
    while inputs[name].derivative_of:
        name, times = inputs[name].derivative_of, times + 1
    return inputs[name], times


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
        if 0.0 < time <= SAME_TIME * stop < math.inf:
            raise StudyError(
                f"result {result!r}: in a run of {stop:g} s that time is the same as 0 s: allowed are 0 and "
                f"more than {SAME_TIME * stop:g} s"
            )
        found.append((name, time))
    return found
