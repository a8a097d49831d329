"""The runs themselves, one after another in one instance of the FMU.

All of a run is laid out once as a list of FMI calls on fixed buffers: begin, start values, steps, reads. A
run is then that list, called from front to back; the values of its row and its results are where the
buffers point. Where the FMU can save its state, a run begins with the state saved in initialization mode,
which also keeps what the FMU has computed of the fixed parameters; elsewhere with a reset.
"""

from __future__ import annotations

import math
import tempfile
import threading
import uuid
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from ctypes import c_double, c_uint, c_void_p
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from dualcam.errors import FmuError
from dualcam.fmu import Fmu
from dualcam.handle import FmuState
from dualcam.instance import OK_OR_WARNING, References
from dualcam.model_description import Kind, Scalar, Variable
from dualcam.reals import Array
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError
from dualcam.study.sampling.texts import Texts
from dualcam.study.scenario import Controller, Scenario, Step, instants, times_of

FATAL = 4  # FMI's status from which an instance cannot be used any more
Call = Callable[[], int]
NUMERIC: tuple[Kind, ...] = ("real", "integer", "boolean")


@dataclass(frozen=True)
class Job:
    """What every worker needs to know. `content` is the FMU itself where the workers may not see its path.

    dualcam.study.resolved says what a row means for its run."""

    path: str
    names: Sequence[str]  # of the columns of a row: variables of the FMU, and others for formulas
    parameters: Mapping[str, Scalar]
    scenario: Scenario
    results: Sequence[str]
    texts: Mapping[str, Texts] = field(default_factory=dict)  # of Strings: a row has the place in this list
    constraints: Mapping[str, str] = field(default_factory=dict)  # a run that violates one is not made
    content: bytes | None = field(default=None, repr=False)
    token: str = field(default_factory=lambda: uuid.uuid4().hex)


@dataclass
class Block:
    """Results of consecutive runs, shape (runs, results); what failed, by place: a message, and NaN as
    results."""

    values: Array
    messages: dict[int, str]

    @classmethod
    def lost(cls, width: int, message: str) -> Block:
        return cls(np.full((1, width), np.nan), {0: message})

    @classmethod
    def joined(cls, first: Block, second: Block) -> Block:
        moved = {len(first.values) + place: text for place, text in second.messages.items()}
        return cls(np.concatenate([first.values, second.values]), first.messages | moved)


@dataclass
class _Window:
    """A buffer with a line for each run, and the pointer that goes along it."""

    lines: np.ndarray[Any, Any]
    pointer: c_void_p

    @classmethod
    def of(cls, kind: Any, runs: int, width: int) -> _Window:  # noqa: ANN401
        lines = np.zeros((runs, width), np.dtype(kind))
        return cls(lines, c_void_p())

    def track(self) -> tuple[c_void_p, int, int]:
        return self.pointer, self.lines.ctypes.data, self.lines.strides[0]


class Runner:
    """Makes runs of a job in an instance of its own. Not for two threads at once."""

    BATCH = 1000  # runs whose buffers are laid out at once

    def __init__(self, job: Job, saves_state: bool = True) -> None:
        """`saves_state`: begin with a saved state where the FMU has that, which is faster than a reset."""
        self.job = job
        self._saves_state = saves_state
        self._windows: dict[str, _Window] = {}
        self._open()
        self._tracks = [window.track() for window in self._windows.values()]

    def _open(self) -> None:
        self._fmu = _unpacked(self.job)
        self._saves_state &= self._fmu.interface.can_save_state
        self._instance = self._fmu._instance
        self._component = self._instance.component
        self._reads: list[tuple[_Window, list[int]]] = []  # with the places of its columns among the results
        self._state: FmuState | None = None
        self.calls = self._layout()

    def close(self) -> None:
        self._fmu.close()

    # ---- the list of calls ----

    def _call(self, name: str, *arguments: object) -> Call:
        """A call that may take long, such as a step."""
        return partial(self._instance.function(name), self._component, *arguments)

    def _access(
        self, action: Literal["Get", "Set"], type_name: str, names: Sequence[str], values: object
    ) -> Call:
        """A call that gets or sets variables of one type."""
        function = self._instance.brief_function(self._instance.access(action, type_name))
        arguments = self._instance.access_arguments(self._references(names), values)
        return partial(function, self._component, *arguments)

    def _references(self, names: Sequence[str]) -> References:
        return (c_uint * len(names))(*(self._fmu.variable(name).value_reference for name in names))

    def _layout(self) -> list[Call]:
        job, interface = self.job, self._fmu.interface
        steps = job.scenario.steps(
            list(times_of(job.results, job.scenario.stop)),
            interpolates=interface.can_interpolate_inputs,
            fixed=not interface.can_handle_variable_steps,
        )
        wanted = instants(job.results, job.scenario.stop)
        calls = self._beginning(self._values(steps[0]))
        if control := job.scenario.controller:
            self._sensed, self._commands = self._fmu.reals(*control.reads), self._fmu.reals(*control.writes)
            calls.append(partial(self._control_start, control))
        calls += self._read([k for k, (_, time) in enumerate(wanted) if time == 0.0])
        for number, step in enumerate(steps):
            calls += self._inputs(step, first=number == 0)
            calls.append(self._step(step))
            end = step.time + step.size
            margin = 1e-9 * step.size
            calls += self._read([k for k, (_, time) in enumerate(wanted) if abs(time - end) <= margin])
        return calls

    def _beginning(self, inputs: Sequence[Call]) -> list[Call]:
        """Up to the first step. These inputs are there while the FMU initializes: it may depend on them."""
        fmu, instance, scenario = self._fmu, self._instance, self.job.scenario
        for name, value in self.job.parameters.items():  # one by one: what is refused is named
            fmu._set(name, value)
        instance.allow_calls()
        fixed, varied = self._set_fixed(), self._set_varied()
        enter = [
            self._call(name, *arguments)
            for name, arguments in instance.initialization_calls(scenario.tolerance)
        ]
        leave = self._call(instance.EXIT_INITIALIZATION)
        if self._saves_state and all(call() <= OK_OR_WARNING for call in enter):
            with suppress(FmuError):  # it says that it can, but cannot now: then without
                self._state = fmu.save_state()
                restore = self._call(instance.SET_STATE, c_void_p(self._state._address))
                return [restore, *varied, *inputs, leave]
        return [self._call(instance.RESET), *fixed, *varied, *enter, *inputs, leave]

    def _step(self, step: Step) -> Call:
        function, end = self._instance.step_function(), self._instance.step_end
        return partial(function, self._component, c_double(step.time), c_double(step.size), *end)

    def _window(self, key: str, kind: str, width: int) -> _Window:
        """The same one for an instance that replaces another one in the middle of a batch."""
        return self._windows.setdefault(key, _Window.of(self._instance.CTYPES[kind], self.BATCH, width))

    def _by_kind(self, names: Sequence[str]) -> dict[str, list[str]]:
        kinds: dict[str, list[str]] = {}
        for name in names:
            kinds.setdefault(self._fmu.variable(name).type, []).append(name)
        return kinds

    def _set_fixed(self) -> list[Call]:
        calls = []
        for kind, names in self._by_kind(list(self.job.parameters)).items():
            values = [self.job.parameters[name] for name in names]
            content = [value.encode() if isinstance(value, str) else value for value in values]
            array = (self._instance.CTYPES[kind] * len(names))(*content)
            calls.append(self._access("Set", kind, names, array))
        return calls

    def _set_varied(self) -> list[Call]:
        calls = []
        for kind, names in self._by_kind(self.job.names).items():
            window = self._window(f"set {kind}", kind, len(names))
            calls.append(self._access("Set", kind, names, window.pointer))
        return calls

    def _values(self, step: Step) -> list[Call]:
        calls = []
        for kind, names in self._by_kind(list(step.values)).items():
            values = (c_double * len(names))(*(step.values[name] for name in names))
            calls.append(self._access("Set", kind, names, values))
        return calls

    def _inputs(self, step: Step, first: bool) -> list[Call]:
        calls: list[Call] = [partial(self._control, step.time)] if step.control else []
        calls += [] if first else self._values(step)
        if step.rates:
            calls.append(self._set_rates(step.rates))
        return calls

    def _set_rates(self, rates: Mapping[tuple[str, int], float]) -> Call:
        """A call that sets time derivatives of inputs, by name and order."""
        references = self._references([name for name, _ in rates])
        values = (c_double * len(rates))(*rates.values())
        return self._instance.input_derivatives_call(references, [order for _, order in rates], values)

    def _read(self, places: Sequence[int]) -> list[Call]:
        calls = []
        names = [self.job.results[place].partition("@")[0] for place in places]
        by_kind = self._by_kind(names)
        for kind in by_kind:
            chosen = [k for k in range(len(names)) if self._fmu.variable(names[k]).type == kind]
            window = self._window(f"get {places[chosen[0]]}", kind, len(chosen))
            self._reads.append((window, [places[k] for k in chosen]))
            calls.append(self._access("Get", kind, [names[k] for k in chosen], window.pointer))
        return calls

    # ---- the controller ----

    def _control_start(self, control: Controller) -> int:
        self._law = control.create_law()
        return 0

    def _control(self, time: float) -> int:
        self._commands.values[:] = self._law(time, self._sensed.read())
        self._commands.write()
        return 0

    # ---- runs ----

    def run(self, rows: Array) -> Block:
        """One run for each row, shape (runs, names). A run that fails gives NaN and the FMU's message."""
        values, messages = np.empty((len(rows), len(self.job.results))), {}
        for start in range(0, len(rows), self.BATCH):
            batch = rows[start : start + self.BATCH]
            failed = self._run_batch(batch)
            for window, places in self._reads:
                values[start : start + len(batch), places] = window.lines[: len(batch)]
            for place, text in failed.items():
                values[start + place] = np.nan
                messages[start + place] = text
        return Block(values, messages)

    def _run_batch(self, rows: Array) -> dict[int, str]:
        for kind, names in self._by_kind(self.job.names).items():
            columns = [self.job.names.index(name) for name in names]
            self._windows[f"set {kind}"].lines[: len(rows)] = rows[:, columns]
        failed: dict[int, str] = {}
        place = 0
        while place < len(rows):
            place, text = self._go(place, len(rows))
            if place < len(rows):
                failed[place] = text
                place += 1
        return failed

    def _go(self, place: int, stop: int) -> tuple[int, str]:
        """Runs from `place` on, up to the first that fails: its place and why; `stop` if none does."""
        tracks, calls, messages = self._tracks, self.calls, self._instance.messages
        try:
            for k in range(place, stop):
                place = k
                if messages:  # warnings of the run before
                    messages.clear()
                for pointer, base, stride in tracks:
                    pointer.value = base + k * stride
                for call in calls:
                    status = call()
                    if status > OK_OR_WARNING:
                        return k, self._failed(call, status)
        except FmuError as error:  # what the controller does is refused
            self._recover()
            return place, str(error)
        except Exception as error:  # in the controller: whatever it is, it concerns this run alone
            self._recover()
            return place, f"controller: {type(error).__name__}: {error}"
        return stop, ""

    def _failed(self, call: Call, status: int) -> str:
        """The FMU's words; the instance is fit for the next run."""
        assert isinstance(call, partial)
        name = call.func.__name__
        text = "; ".join(self._instance.messages) or f"{name} returned status {status}, without a message"
        if status >= FATAL:
            self._fmu.abandon()
            self._open()
        else:
            self._recover()
        return text

    def _recover(self) -> None:
        """FMI wants a reset before an instance that failed goes on; other runs begin with it anyway."""
        if self._state is not None:
            self._call(self._instance.RESET)()


def _unpacked(job: Job) -> Fmu:
    if job.content is None:
        return Fmu(job.path)
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / Path(job.path).name
        try:
            path.write_bytes(job.content)
        except OSError as error:
            raise FmuError(
                f"the FMU cannot be unpacked into {directory}: {error.strerror or error}"
            ) from error
        return Fmu(path)


_own = threading.local()


def run_rows(job: Job, rows: Array) -> Block:
    """In a worker: the runner of this thread, made when it is first asked for."""
    runner: Runner | None = getattr(_own, "runner", None)
    if runner is None or runner.job.token != job.token:
        if runner is not None:
            runner.close()
        runner = _own.runner = Runner(job)
    return runner.run(rows)


def check(job: Job, plan: Plan) -> Runner:
    """A runner for the job, made here and now, so that what concerns every run is refused before any.
    FmuError for names, types and values that the FMU does not have or allow."""
    if not job.results:
        raise StudyError("the study reads nothing: name at least one result")
    for names in (list(job.names), list(job.results)):
        if twice := {name for name in names if names.count(name) > 1}:
            raise StudyError(f"{', '.join(twice)} is named twice: allowed is once")
    with Fmu(job.path) as fmu:
        _check_start_values(fmu, job, plan)
        for name, _ in instants(job.results, job.scenario.stop):
            fmu.variable(name, *NUMERIC)
        _check_inputs(fmu, job)
    return Runner(job)


def _check_start_values(fmu: Fmu, job: Job, plan: Plan) -> None:
    for name in [*job.names, *job.parameters]:
        variable = fmu.variable(name)
        if not _is_start_value(variable):
            raise StudyError(
                f"{name} is {variable.causality}, it cannot be set: allowed are parameters, inputs, and what "
                "starts from a value that is exact"
            )
    limits = plan.limits()
    for name in job.names:
        if name in job.parameters:
            raise StudyError(f"{name} varies and is fixed too: allowed is one of them")
        _check_range(fmu.variable(name, *NUMERIC), *limits[name])
        if fmu.variable(name).kind != "real" and not plan.is_whole(name):
            raise StudyError(
                f"plan: {name} is {fmu.variable(name).type}: allowed are values = [whole numbers]"
            )


def _is_start_value(variable: Variable) -> bool:
    """FMI 2.0, section 2.2.7: may be set in initialization mode."""
    exact = variable.initial == "exact" and variable.variability != "constant"
    return exact or variable.causality in ("parameter", "input")


def _check_range(variable: Variable, low: float, high: float) -> None:
    least = -math.inf if variable.min is None else float(variable.min)
    most = math.inf if variable.max is None else float(variable.max)
    if variable.kind == "boolean":
        least, most = 0.0, 1.0
    if low < least or high > most:
        raise StudyError(
            f"plan: {variable.name} from {low:g} to {high:g}: the FMU allows {least:g} to {most:g}"
        )


def _check_inputs(fmu: Fmu, job: Job) -> None:
    control = job.scenario.controller
    for name in [*job.scenario.inputs, *(control.writes if control else ())]:
        if fmu.variable(name, "real").causality != "input":
            raise StudyError(f"scenario: {name} is {fmu.variable(name).causality}: allowed are inputs")
        if name in job.names or name in job.parameters:
            raise StudyError(f"{name} has a history and a value of its own: allowed is one of them")
    for name in control.reads if control else ():
        fmu.variable(name, "real")
