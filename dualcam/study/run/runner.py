"""The runs themselves, one after another in one instance of the FMU.

All of a run is laid out once as a list of FMI calls on fixed buffers: begin, start values, steps, reads. A
run is then that list, called from front to back; the values of its row and its results are where the
buffers point. Where the FMU can save its state, a run begins with the state saved in initialization mode,
which also keeps what the FMU has computed of the fixed parameters; elsewhere with a reset. A batch of runs is
made in C (dualcam.study.run.batch) unless a controller in Python is called between the steps.
"""

from __future__ import annotations

import tempfile
import threading
import uuid
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from ctypes import addressof, c_double, c_uint, c_void_p, create_string_buffer, sizeof
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import real_array
from dualcam.errors import FmuError
from dualcam.fmi.fmu import Fmu
from dualcam.fmi.handle import FmuState
from dualcam.fmi.instance import OK_OR_WARNING, References
from dualcam.fmi.model_description import Scalar
from dualcam.fmi.reals import Array
from dualcam.scenario.scenario import Controller, Scenario
from dualcam.study.plan.rows import values_of, violated_by, violating
from dualcam.study.plan.texts import Texts
from dualcam.study.run.batch import Batch, Window, copy, loop_in_c
from dualcam.study.run.step_numbers import StepNumbers
from dualcam.study.run.step_times import FIRST, Arrangement, Key

FATAL = 4  # FMI's status from which an instance cannot be used any more
IN_C_FROM = 3  # runs of one layout: to lay the calls out for C takes as long as some runs from Python
NUMBERS = frozenset((float, int, np.float64))
Call = Callable[[], int]


@dataclass(frozen=True)
class Job:
    """What every worker needs to know. `content` is the FMU itself where the workers may not see its path.

    dualcam.study.plan.rows says what a row means for its run."""

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
    """Results of runs, shape (runs, results); those that failed, by place: a message, and NaN as results."""

    values: Array
    messages: dict[int, str]

    @classmethod
    def lost(cls, width: int, message: str) -> Block:
        return cls(np.full((1, width), np.nan), {0: message})

    @classmethod
    def joined(cls, blocks: Sequence[Block]) -> Block:
        values = [block.values for block in blocks]
        return cls(np.concatenate(values), joined_messages(values, [block.messages for block in blocks]))


def joined_messages(parts: Sequence[Array], messages: Sequence[Mapping[int, str]]) -> dict[int, str]:
    """Messages by their places in all parts, of those by their places in each."""
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    pairs = zip(starts, messages, strict=False)
    return {start + place: text for start, own in pairs for place, text in own.items()}


@dataclass
class _Layout:
    """The calls of a run with the steps of one arrangement, and the buffers that they use."""

    arrangement: Arrangement
    windows: dict[str, Window] = field(default_factory=dict)
    reads: list[tuple[Window, list[int]]] = field(default_factory=list)  # with the places among the results
    calls: list[Call] = field(default_factory=list)
    batch: Batch | None = None  # the calls for C, made when they are needed


class Runner:
    """Makes runs of a job in an instance of its own. Not for two threads at once."""

    BATCH = 1000  # runs whose buffers are laid out at once
    LAYOUTS = 50  # that are kept: each may have thousands of calls

    def __init__(self, job: Job, saves_state: bool = True, in_c: bool = True) -> None:
        """`saves_state`: begin with a saved state where the FMU has that, which is faster than a reset.
        `in_c`: make the calls of a batch in C where no controller is between them, which is faster, too."""
        self.job = job
        self._saves_state = saves_state
        self._loop = loop_in_c() if in_c and job.scenario.controller is None else None
        self._used: _Layout | None = None
        self._kept: dict[str, list[Any]] = {}  # texts of the batch, by the name of the String
        self._open()
        if not job.scenario.names:
            self._use(self.steps.arrangement(job.scenario))

    def _open(self) -> None:
        self._fmu = _unpacked(self.job)
        self._saves_state &= self._fmu.interface.can_save_state
        self._instance = self._fmu._instance
        self._component = self._instance.component
        self._state: FmuState | None = None
        self._layouts: dict[Key, _Layout] = {}
        job, interface = self.job, self._fmu.interface
        self.steps = StepNumbers(
            job.scenario,
            job.results,
            job.names,
            job.texts,
            interpolates=interface.can_interpolate_inputs,
            fixed=not interface.can_handle_variable_steps,
        )
        known = set(self._fmu.names)
        self.columns = [name for name in job.names if name in known]
        self._enter()
        if self._used is not None:
            self._lay_out(self._used)

    def close(self) -> None:
        self._fmu.close()

    @property
    def _layout(self) -> _Layout:
        """The layout that is in use."""
        assert self._used is not None
        return self._used

    @property
    def calls(self) -> list[Call]:
        """The calls of a run of the arrangement that was used last."""
        return self._layout.calls

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

    def _use(self, arrangement: Arrangement) -> _Layout:
        """The layout of an arrangement, made where it is new."""
        layout = self._layouts.get(arrangement.key)
        if layout is None:
            layout = _Layout(arrangement)
            if len(self._layouts) >= self.LAYOUTS:
                self._layouts.pop(next(iter(self._layouts)))
            self._lay_out(layout)
        self._used = layout
        return layout

    def _lay_out(self, layout: _Layout) -> None:
        """Its calls, on its buffers if it has some: for an instance that replaces another one in a batch."""
        self._layouts[layout.arrangement.key] = self._used = layout
        arrangement, control = layout.arrangement, self.job.scenario.controller
        layout.reads, layout.batch = [], None
        calls = [self._copy_numbers(arrangement)] if self.job.scenario.names else []
        calls += self._beginning(self._values(arrangement, 0))
        if control:
            self._sensed, self._commands = self._fmu.reals(*control.reads), self._fmu.reals(*control.writes)
            if control.arguments:
                self._window("law", c_double, len(control.arguments))
            calls.append(partial(self._control_start, control))
        calls += self._read([k for k, after in enumerate(arrangement.read_after) if after == FIRST])
        for number in range(len(arrangement.steps)):
            calls += self._inputs(arrangement, number)
            calls.append(self._step(arrangement, number))
            calls += self._read([k for k, after in enumerate(arrangement.read_after) if after == number])
        layout.calls = calls

    def _copy_numbers(self, arrangement: Arrangement) -> Call:
        """A call that puts the numbers of the run in place."""
        pointer = self._window("numbers", c_double, len(arrangement.buffer)).pointer
        return partial(copy, addressof(arrangement.buffer), pointer, sizeof(arrangement.buffer))

    def _enter(self) -> None:
        """Into initialization mode with the fixed parameters, and keep that state where the FMU can."""
        fmu, instance = self._fmu, self._instance
        for name, value in self.job.parameters.items():  # one by one: what is refused is named
            fmu._set(name, value)
        instance.allow_calls()
        calls = instance.initialization_calls(self.job.scenario.tolerance)
        self._enter_calls = [self._call(name, *arguments) for name, arguments in calls]
        if self._saves_state and all(call() <= OK_OR_WARNING for call in self._enter_calls):
            with suppress(FmuError):  # it says that it can, but cannot now: then without
                self._state = fmu.save_state()

    def _beginning(self, inputs: Sequence[Call]) -> list[Call]:
        """Up to the first step. These inputs are there while the FMU initializes: it may depend on them."""
        instance, varied = self._instance, self._set_varied()
        leave = self._call(instance.EXIT_INITIALIZATION)
        if self._state is not None:
            restore = self._call(instance.SET_STATE, c_void_p(self._state._address))
            return [restore, *varied, *inputs, leave]
        reset = self._call(instance.RESET)
        return [reset, *self._set_fixed(), *varied, *self._enter_calls, *inputs, leave]

    def _step(self, arrangement: Arrangement, number: int) -> Call:
        function, end = self._instance.step_function(), self._instance.step_end
        time, size = arrangement.view(number, "time"), arrangement.view(number, "size")
        return partial(function, self._component, time, size, *end)

    def _window(self, key: str, kind: Any, width: int) -> Window:  # noqa: ANN401
        """The same one for an instance that replaces another one in the middle of a batch."""
        return self._layout.windows.setdefault(key, Window.of(kind, self.BATCH, width))

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
        for kind, names in self._by_kind(self.columns).items():
            # A String is passed as the address of its text.
            line = c_void_p if kind == "String" else self._instance.CTYPES[kind]
            window = self._window(f"set {kind}", line, len(names))
            calls.append(self._access("Set", kind, names, window.pointer))
        return calls

    def _values(self, arrangement: Arrangement, number: int) -> list[Call]:
        names = list(arrangement.steps[number].values)
        values = arrangement.view(number, "values")
        kinds = self._by_kind(names)
        if len(kinds) == 1:
            return [self._access("Set", kind, names, values) for kind in kinds]
        return [
            self._access("Set", self._fmu.variable(name).type, [name], _one_of(values, k))
            for k, name in enumerate(names)
        ]

    def _inputs(self, arrangement: Arrangement, number: int) -> list[Call]:
        step = arrangement.steps[number]
        calls: list[Call] = [partial(self._control, arrangement.view(number, "time"))] if step.control else []
        calls += [] if number == 0 else self._values(arrangement, number)
        if step.rates:
            references = self._references([name for name, _ in step.rates])
            orders = [order for _, order in step.rates]
            rates = arrangement.view(number, "rates")
            calls.append(self._instance.input_derivatives_call(references, orders, rates))
        return calls

    def _read(self, places: Sequence[int]) -> list[Call]:
        calls = []
        names = [self.job.results[place].partition("@")[0] for place in places]
        for kind in self._by_kind(names):
            chosen = [k for k in range(len(names)) if self._fmu.variable(names[k]).type == kind]
            window = self._window(f"get {places[chosen[0]]}", self._instance.CTYPES[kind], len(chosen))
            self._layout.reads.append((window, [places[k] for k in chosen]))
            calls.append(self._access("Get", kind, [names[k] for k in chosen], window.pointer))
        return calls

    # ---- the controller ----

    def _control_start(self, control: Controller) -> int:
        self._law = control.create_law(**self._arguments(control))
        return 0

    def _arguments(self, control: Controller) -> dict[str, Any]:
        """Of the law of the run that begins."""
        if not control.arguments:
            return {}
        pointer = self._window("law", c_double, len(control.arguments)).pointer
        numbers = (c_double * len(control.arguments)).from_address(pointer.value or 0)
        return {
            name: self.job.texts[each][round(number)] if each in self.job.texts else number
            for (name, each), number in zip(control.arguments.items(), numbers, strict=True)
        }

    def _control(self, time: c_double) -> int:
        returned = self._law(time.value, self._sensed.read())
        self._commands._buffer[:] = _commanded(returned, self._commands.names)  # faster than `values`
        self._commands.write()
        return 0

    # ---- runs ----

    def run(self, rows: Array) -> Block:
        """One run for each row, shape (runs, names). A run that fails gives NaN and the FMU's message; so
        does one that violates a constraint, or whose numbers are no scenario.

        Runs of the same texts are made one after another: the FMU keeps what it made of a groove table."""
        columns = [rows[:, self.job.names.index(name)] for name in self.job.texts if name in self.columns]
        if not columns:
            return self._run(rows)
        order = np.lexsort(columns)
        block = self._run(rows[order])
        values = np.empty_like(block.values)
        values[order] = block.values
        messages = {int(order[place]): text for place, text in block.messages.items()}
        return Block(values, dict(sorted(messages.items())))

    def _run(self, rows: Array) -> Block:
        values, messages = np.full((len(rows), len(self.job.results)), np.nan), self._violations(rows)
        kept = np.delete(np.arange(len(rows)), list(messages))
        for start in range(0, len(kept), self.BATCH):
            wanted = kept[start : start + self.BATCH]
            if not self.job.scenario.names:
                self._run_places(rows, wanted, values, messages)
                continue
            groups, failed = self.steps.groups(rows[wanted])
            messages |= {int(wanted[place]): text for place, text in failed.items()}
            for group in groups:
                layout = self._use(group.arrangement)
                layout.windows["numbers"].lines[: len(group.places)] = group.numbers
                self._run_places(rows, wanted[group.places], values, messages)
        return Block(values, dict(sorted(messages.items())))

    def _violations(self, rows: Array) -> dict[int, str]:
        """By the places of the rows that violate constraints: which."""
        names, constraints = self.job.names, self.job.constraints
        if not constraints:
            return {}
        found = violating(constraints, dict(zip(names, rows.T, strict=True)), len(rows))
        values = {int(k): values_of(names, rows[k], self.job.texts) for k in np.flatnonzero(found)}
        return {place: "; ".join(violated_by(constraints, each)) for place, each in values.items()}

    def _run_places(
        self, rows: Array, places: NDArray[np.intp], values: Array, messages: dict[int, str]
    ) -> None:
        """The runs of some rows, a batch at most, in the layout that is in use."""
        failed = self._run_batch(rows[places])
        for window, columns in self._layout.reads:
            values[places[:, None], columns] = window.lines[: len(places)]
        for place, text in failed.items():
            values[places[place]] = np.nan
            messages[int(places[place])] = text

    def _run_batch(self, rows: Array) -> dict[int, str]:
        for kind, names in self._by_kind(self.columns).items():
            columns = [self.job.names.index(name) for name in names]
            lines = self._layout.windows[f"set {kind}"].lines
            if kind == "String":
                for column, name in enumerate(names):
                    lines[: len(rows), column] = self._addresses(name, rows[:, columns[column]])
            else:
                lines[: len(rows)] = rows[:, columns]
        if (control := self.job.scenario.controller) and control.arguments:
            self._layout.windows["law"].lines[: len(rows)] = self.steps.law_arguments(rows)
        failed: dict[int, str] = {}
        place = 0
        while place < len(rows):
            place, text = self._go(place, len(rows))
            if place < len(rows):
                failed[place] = text
                place += 1
        return failed

    def _addresses(self, name: str, places: Array) -> NDArray[np.uint64]:
        """Addresses of the texts at these places, which stay alive until the next batch."""
        texts = self.job.texts[name]
        chosen, which = np.unique(places.astype(int), return_inverse=True)
        self._kept[name] = [create_string_buffer(texts[int(place)].encode()) for place in chosen]
        return np.array([addressof(buffer) for buffer in self._kept[name]], np.uint64)[which]

    def _go(self, place: int, stop: int) -> tuple[int, str]:
        """Runs from `place` on, up to the first that fails: its place and why; `stop` if none does."""
        if self._loop is None or stop - place < IN_C_FROM:
            return self._go_by_python(place, stop)
        layout = self._layout
        if layout.batch is None:
            calls = [call for call in layout.calls if isinstance(call, partial)]
            layout.batch = Batch(self._loop, self._instance, calls, layout.windows.values())
        while place < stop:
            place, which, status = layout.batch.run(place, stop)
            if status >= FATAL:
                return place, self._failed(layout.calls[which], status)
            self._instance.messages.clear()  # of warnings
            if status > OK_OR_WARNING:  # the run is made once more, with its messages
                self._recover()
                place, text = self._go_by_python(failed := place, place + 1)
                if place == failed:
                    return failed, text
        return stop, ""

    def _go_by_python(self, place: int, stop: int) -> tuple[int, str]:
        """The same, with the calls of each run one by one."""
        tracks = [window.track() for window in self._layout.windows.values()]
        calls, messages = self._layout.calls, self._instance.messages
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


def _one_of(values: Any, place: int) -> Any:  # noqa: ANN401
    """One number of an array, as an array of its own in the same memory."""
    return (c_double * 1).from_buffer(values, place * sizeof(c_double))


def _commanded(returned: Any, names: Sequence[str]) -> list[c_double | float]:  # noqa: ANN401
    """What a law returned, as one number for each name. FmuError for anything else."""
    given = returned.tolist() if type(returned) is np.ndarray else returned
    if type(given) is list and len(given) == len(names) and NUMBERS.issuperset(map(type, given)):
        return given  # `real_array` would take as long as a step
    values = real_array(returned, "controller: what the law returned", FmuError)
    if values.size != len(names):
        count = f"{values.size} value{'s' * (values.size != 1)}"
        raise FmuError(f"controller: the law returned {count}, writes has {len(names)}: {', '.join(names)}")
    return [*values.ravel().tolist()]


def _unpacked(job: Job) -> Fmu:
    if job.content is None:
        return Fmu(job.path)
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / Path(job.path).name
        try:
            path.write_bytes(job.content)
        except OSError as error:
            text = f"the FMU cannot be unpacked into {directory}: {error.strerror or error}"
            raise FmuError(text) from error
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
