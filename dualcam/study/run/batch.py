"""The runs of a batch from C: the calls of a run as dualcam/fleet/runs.h takes them.

A call from Python takes 0.3 us besides the FMU's own time, a call from C some nanoseconds. Python's lock is
free meanwhile."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Iterable, Sequence
from ctypes import addressof, byref, c_double, c_void_p, memmove, sizeof
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from dualcam.errors import FmuError
from dualcam.fleet.native import RunsCall, RunsEnd, native
from dualcam.fmi.instance import Instance

SECONDS = 0.05  # of one call from Python: Ctrl-C and a signal wait for its end
MORE = 4  # times as many runs in the next call, at most

PLAIN, STATE, SET_UP2, ENTER3, ACCESS2, ACCESS3, RATES2, STEP2, STEP3, COPY = range(10)  # RunsKind
KINDS = {
    **dict.fromkeys(("fmi2Reset", "fmi2EnterInitializationMode", "fmi2ExitInitializationMode"), PLAIN),
    **dict.fromkeys(("fmi3Reset", "fmi3ExitInitializationMode"), PLAIN),
    **dict.fromkeys(("fmi2SetFMUstate", "fmi3SetFMUState"), STATE),
    "fmi2SetupExperiment": SET_UP2,
    "fmi3EnterInitializationMode": ENTER3,
    "fmi2SetRealInputDerivatives": RATES2,
    "fmi2DoStep": STEP2,
    "fmi3DoStep": STEP3,
    "copy": COPY,
}


@dataclass
class Window:
    """A buffer with a line for each run of a batch, and the pointer that goes along the lines."""

    lines: np.ndarray[Any, Any]
    pointer: c_void_p

    @classmethod
    def of(cls, kind: Any, runs: int, width: int) -> Window:  # noqa: ANN401
        lines = np.zeros((runs, width), np.uint64 if kind is c_void_p else np.dtype(kind))
        return cls(lines, c_void_p())

    def track(self) -> tuple[c_void_p, int, int]:
        return self.pointer, self.lines.ctypes.data, self.lines.strides[0]


def copy(target: int, pointer: c_void_p, size: int) -> int:
    """A call of a run that is no FMI call: the numbers of the run to their place."""
    memmove(target, pointer, size)
    return 0


def loop_in_c() -> ctypes.CDLL | None:
    """The library with the loop; None on a platform that has none."""
    try:
        return native()
    except FmuError:
        return None


class Batch:
    """The calls of a run, for C: FMI functions of one instance with their arguments, and `copy`. `windows`
    are the buffers of the arguments that differ between runs."""

    def __init__(
        self, loop: ctypes.CDLL, instance: Instance, calls: Sequence[partial[int]], windows: Iterable[Window]
    ) -> None:
        self._make, self._instance = loop.runs_make, instance
        self._kept: list[Any] = list(calls)  # what the calls point to
        self._lines = {id(window.pointer): window.lines for window in windows}
        self._calls = (RunsCall * len(calls))(*map(self._call, calls))
        self._end, self._at_once = RunsEnd(), 1

    def _call(self, call: partial[int]) -> RunsCall:
        name = call.func.__name__
        kind = KINDS.get(name, ACCESS3 if name.startswith("fmi3") else ACCESS2)
        if kind == COPY:
            target, pointer, size = call.args
            return self._moving(RunsCall(kind=kind, target=target, count=size), pointer)
        function: Any = self._instance.function(name)
        found = RunsCall(kind=kind, function=ctypes.cast(function, c_void_p))
        arguments = call.args[1:]  # without the instance
        if kind == STATE:
            found.values = arguments[0].value
        elif kind in (SET_UP2, ENTER3):
            has_tolerance, tolerance, start, *_ = arguments
            found.has_tolerance = int(has_tolerance.value)
            found.numbers = self._numbers(tolerance.value, start.value)
        elif kind in (STEP2, STEP3):
            start, size = arguments[:2]
            assert addressof(size) == addressof(start) + sizeof(c_double)  # dualcam.study.run.step_times
            found.numbers = addressof(start)
        elif kind != PLAIN:
            references, values = arguments[0], arguments[3 if kind == RATES2 else 2]
            found.references, found.count = addressof(references), len(references)
            found.orders = addressof(arguments[2]) if kind == RATES2 else None
            self._moving(found, values)
        return found

    def _numbers(self, *numbers: float) -> int:
        array = (c_double * len(numbers))(*numbers)
        self._kept.append(array)
        return addressof(array)

    def _moving(self, call: RunsCall, values: Any) -> RunsCall:  # noqa: ANN401
        """With the values of each run, or those that are the same for all."""
        lines = self._lines.get(id(values))
        if lines is None:
            call.values = addressof(values)
        else:
            call.values, call.line_size = lines.ctypes.data, lines.strides[0]
        return call

    def run(self, first: int, last: int) -> tuple[int, int, int]:
        """Make the runs from `first` to before `last`, up to one that fails or gives a warning: that run, the
        place of its call and the status; or the first run not made, 0, and the status OK or Warning."""
        end, component = self._end, self._instance.component
        while first < last:
            most = min(last, first + self._at_once)
            begun = time.perf_counter()
            self._make(self._calls, len(self._calls), component, first, most, byref(end))
            if end.status:
                break
            wanted = int((most - first) * SECONDS / max(time.perf_counter() - begun, 1e-6))
            self._at_once = max(1, min(wanted, MORE * self._at_once))
            first = most
        return (end.run, end.call, end.status) if first < last else (last, 0, 0)
