"""The runs themselves, one after another in one instance of the FMU.

All of a run is laid out once as a list of FMI calls on fixed buffers: begin, start values, steps, reads. A
run is then that list, called from front to back; the values of its row and its results are where the
buffers point. Where the FMU can save its state, a run begins with the state saved in initialization mode,
which also keeps what the FMU has computed of the fixed parameters; elsewhere with fmi2Reset.
"""

from __future__ import annotations

import ctypes
import math
import tempfile
import threading
import uuid
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from ctypes import c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.model_description import ScalarVariable

from dualcam.fmu import OK_OR_WARNING, Array, Fmu, FmuError, FmuState, Scalar
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError
from dualcam.study.scenario import Controller, Scenario, Step, instants, times_of

FATAL = 4  # fmi2Status from which an instance cannot be used any more
Call = Callable[[], int]
CTYPES: dict[str, Any] = {
    "Real": c_double,
    "Integer": c_int,
    "Enumeration": c_int,
    "Boolean": c_int,
    "String": c_char_p,
}
SUFFIX = {
    "Real": "Real",
    "Integer": "Integer",
    "Enumeration": "Integer",
    "Boolean": "Boolean",
    "String": "String",
}
NUMERIC = tuple(name for name in SUFFIX if name != "String")


@dataclass(frozen=True)
class Job:
    """What every worker needs to know. `content` is the FMU itself where the workers may not see its path."""

    path: str
    names: Sequence[str]  # that vary, in the order of a row
    parameters: Mapping[str, Scalar]
    scenario: Scenario
    results: Sequence[str]
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
    def of(cls, kind: str, runs: int, width: int) -> _Window:
        lines = np.zeros((runs, width), np.float64 if kind == "Real" else np.int32)
        return cls(lines, c_void_p())

    def track(self) -> tuple[c_void_p, int, int]:
        return self.pointer, self.lines.ctypes.data, self.lines.strides[0]


class Runner:
    """Makes runs of a job in an instance of its own. Not for two threads at once."""

    BATCH = 1000  # runs whose buffers are laid out at once

    def __init__(self, job: Job, saves_state: bool = True) -> None:
        """`saves_state`: begin with a saved state where the FMU has that, which is faster than fmi2Reset."""
        self.job = job
        self._saves_state = saves_state
        self._windows: dict[str, _Window] = {}
        self._open()
        self._tracks = [window.track() for window in self._windows.values()]

    def _open(self) -> None:
        self._fmu = _unpacked(self.job)
        self._saves_state &= bool(self._fmu.description.coSimulation.canGetAndSetFMUstate)
        instance = self._fmu._instance
        # Not FMPy's functions, whose argument types are checked and converted at every call.
        self._library = ctypes.CDLL(instance._fmu.dll._name)
        # These take less time than giving Python's lock away and taking it back.
        self._brief = ctypes.PyDLL(instance._fmu.dll._name)
        self._component = c_void_p(instance.component)
        self._reads: list[tuple[_Window, list[int]]] = []  # with the places of its columns among the results
        self._state: FmuState | None = None
        self.calls = self._layout()

    def close(self) -> None:
        self._fmu.close()

    # ---- the list of calls ----

    def _call(self, name: str, *arguments: object) -> Call:
        brief = name.startswith(("fmi2Set", "fmi2Get")) and name != "fmi2SetupExperiment"
        function = getattr(self._brief if brief else self._library, name)
        function.restype = c_int
        return partial(function, self._component, *arguments)

    def _references(self, names: Sequence[str]) -> tuple[object, c_size_t]:
        references = [self._fmu.variable(name).valueReference for name in names]
        return (c_uint * len(names))(*references), c_size_t(len(names))

    def _layout(self) -> list[Call]:
        job, description = self.job, self._fmu.description.coSimulation
        steps = job.scenario.steps(
            list(times_of(job.results, job.scenario.stop)),
            interpolates=bool(description.canInterpolateInputs),
            fixed=not description.canHandleVariableCommunicationStepSize,
        )
        wanted = instants(job.results, job.scenario.stop)
        calls = self._beginning(self._values(steps[0]))
        if control := job.scenario.controller:
            self._sensed, self._commands = self._fmu.reals(*control.reads), self._fmu.reals(*control.writes)
            calls.append(partial(self._control_start, control))
        calls += self._read([k for k, (_, time) in enumerate(wanted) if time == 0.0])
        for number, step in enumerate(steps):
            calls += self._inputs(step, first=number == 0)
            calls.append(self._call("fmi2DoStep", c_double(step.time), c_double(step.size), c_int(1)))
            end = step.time + step.size
            margin = 1e-9 * step.size
            calls += self._read([k for k, (_, time) in enumerate(wanted) if abs(time - end) <= margin])
        return calls

    def _beginning(self, inputs: Sequence[Call]) -> list[Call]:
        """Up to the first step. These inputs are there while the FMU initializes: it may depend on them."""
        fmu, scenario = self._fmu, self.job.scenario
        for name, value in self.job.parameters.items():  # one by one: what is refused is named
            fmu.set(name, value)
        fixed, varied = self._set_fixed(), self._set_varied()
        tolerance = scenario.tolerance or 0.0
        nothing, none = c_double(0.0), c_int(0)
        defined = c_int(scenario.tolerance is not None)
        setup = self._call("fmi2SetupExperiment", defined, c_double(tolerance), nothing, none, nothing)
        enter, leave = self._call("fmi2EnterInitializationMode"), self._call("fmi2ExitInitializationMode")
        if self._saves_state and setup() <= OK_OR_WARNING and enter() <= OK_OR_WARNING:
            with suppress(FmuError):  # it says that it can, but cannot now: then without
                self._state = fmu.save_state()
                return [
                    self._call("fmi2SetFMUstate", c_void_p(self._state._address)),
                    *varied,
                    *inputs,
                    leave,
                ]
        return [self._call("fmi2Reset"), *fixed, *varied, setup, enter, *inputs, leave]

    def _window(self, key: str, kind: str, width: int) -> _Window:
        """The same one for an instance that replaces another one in the middle of a batch."""
        return self._windows.setdefault(key, _Window.of(kind, self.BATCH, width))

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
            calls.append(
                self._call(
                    f"fmi2Set{SUFFIX[kind]}", *self._references(names), (CTYPES[kind] * len(names))(*content)
                )
            )
        return calls

    def _set_varied(self) -> list[Call]:
        calls = []
        for kind, names in self._by_kind(self.job.names).items():
            window = self._window(f"set {kind}", kind, len(names))
            calls.append(self._call(f"fmi2Set{SUFFIX[kind]}", *self._references(names), window.pointer))
        return calls

    def _values(self, step: Step) -> list[Call]:
        if not step.values:
            return []
        values = (c_double * len(step.values))(*step.values.values())
        return [self._call("fmi2SetReal", *self._references(list(step.values)), values)]

    def _inputs(self, step: Step, first: bool) -> list[Call]:
        calls: list[Call] = [partial(self._control, step.time)] if step.control else []
        calls += [] if first else self._values(step)
        if step.rates:
            references, count = self._references([name for name, _ in step.rates])
            orders = (c_int * len(step.rates))(*(order for _, order in step.rates))
            rates = (c_double * len(step.rates))(*step.rates.values())
            calls.append(self._call("fmi2SetRealInputDerivatives", references, count, orders, rates))
        return calls

    def _read(self, places: Sequence[int]) -> list[Call]:
        calls = []
        names = [self.job.results[place].partition("@")[0] for place in places]
        by_kind = self._by_kind(names)
        for kind in by_kind:
            chosen = [k for k in range(len(names)) if self._fmu.variable(names[k]).type == kind]
            window = self._window(f"get {places[chosen[0]]}", kind, len(chosen))
            self._reads.append((window, [places[k] for k in chosen]))
            references = self._references([names[k] for k in chosen])
            calls.append(self._call(f"fmi2Get{SUFFIX[kind]}", *references, window.pointer))
        return calls

    # ---- the controller ----

    def _control_start(self, control: Controller) -> int:
        self._law = control.make()
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
        tracks, calls, messages = self._tracks, self.calls, self._fmu._instance.messages
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
        text = (
            "; ".join(self._fmu._instance.messages) or f"{name} returned status {status}, without a message"
        )
        if status >= FATAL:
            self._fmu.abandon()
            self._open()
        else:
            self._recover()
        return text

    def _recover(self) -> None:
        """FMI wants fmi2Reset before an instance that failed goes on; other runs begin with it anyway."""
        if self._state is not None:
            self._call("fmi2Reset")()


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
        if fmu.variable(name).type != "Real" and not plan.is_whole(name):
            raise StudyError(
                f"plan: {name} is {fmu.variable(name).type}: allowed are values = [whole numbers]"
            )


def _is_start_value(variable: ScalarVariable) -> bool:
    """FMI 2.0, section 2.2.7: may be set in initialization mode."""
    exact = variable.initial == "exact" and variable.variability != "constant"
    return exact or variable.causality in ("parameter", "input")


def _check_range(variable: ScalarVariable, low: float, high: float) -> None:
    least, most = _limit(variable, "min", -math.inf), _limit(variable, "max", math.inf)
    if variable.type == "Boolean":
        least, most = 0.0, 1.0
    if low < least or high > most:
        raise StudyError(
            f"plan: {variable.name} from {low:g} to {high:g}: the FMU allows {least:g} to {most:g}"
        )


def _limit(variable: ScalarVariable, end: str, none: float) -> float:
    own, declared = getattr(variable, end), getattr(variable.declaredType, end, None)
    return next((float(limit) for limit in (own, declared) if limit is not None), none)


def _check_inputs(fmu: Fmu, job: Job) -> None:
    control = job.scenario.controller
    for name in [*job.scenario.inputs, *(control.writes if control else ())]:
        if fmu.variable(name, "Real").causality != "input":
            raise StudyError(f"scenario: {name} is {fmu.variable(name).causality}: allowed are inputs")
        if name in job.names or name in job.parameters:
            raise StudyError(f"{name} has a history and a value of its own: allowed is one of them")
    for name in control.reads if control else ():
        fmu.variable(name, "Real")
