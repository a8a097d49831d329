"""The runs of the study from C."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Sequence

import numpy as np

from benchmarks.harness import core
from benchmarks.harness.timing import Block
from benchmarks.study_rate.study import HALF, RESULTS, TORQUE, VARY
from dualcam.fmu import Array
from dualcam.study.runner import Runner


class Calls(ctypes.Structure):
    """`Study` of study_runs.c."""

    FUNCTIONS = (
        *("fmi2SetFMUstate", "fmi2Reset", "fmi2SetupExperiment", "fmi2EnterInitializationMode"),
        *("fmi2ExitInitializationMode", "fmi2SetReal", "fmi2DoStep", "fmi2GetReal"),
    )
    _fields_ = (
        *((name, ctypes.c_void_p) for name in FUNCTIONS),
        ("component", ctypes.c_void_p),
        ("state", ctypes.c_void_p),
        ("varied", ctypes.POINTER(ctypes.c_uint)),
        ("results", ctypes.POINTER(ctypes.c_uint)),
        ("varied_count", ctypes.c_size_t),
        ("results_count", ctypes.c_size_t),
        ("tau", ctypes.c_uint),
    )


def in_c(runner: Runner, rows: Array) -> Block:
    """Seconds of a run of the runner's FMU from C, of the processor. The results are those of the runner."""
    loop = core.load_loops("study_rate/study_runs.c", "seconds_study", flags=("-O2",))
    library, fmu, state = runner._fmu._instance.library, runner._fmu, runner._state

    def references(names: Sequence[str]) -> ctypes.Array[ctypes.c_uint]:
        return (ctypes.c_uint * len(names))(*(fmu.variable(name).value_reference for name in names))

    calls = Calls(
        *(ctypes.cast(getattr(library, name), ctypes.c_void_p) for name in Calls.FUNCTIONS),
        runner._component,
        state and state._address,
        references(list(VARY)),
        references([name.partition("@")[0] for name in RESULTS]),
        len(VARY),
        len(RESULTS),
        references(["tau"])[0],
    )
    values, results, status = np.ascontiguousarray(rows), np.empty((len(rows), len(RESULTS))), ctypes.c_int()

    def seconds() -> float:
        start = time.process_time()
        loop.seconds_study(
            ctypes.byref(calls),
            values.ctypes.data_as(ctypes.c_void_p),
            ctypes.c_size_t(len(rows)),
            ctypes.c_double(TORQUE),
            ctypes.c_double(HALF),
            results.ctypes.data_as(ctypes.c_void_p),
            ctypes.byref(status),
        )
        assert status.value == 0
        return (time.process_time() - start) / len(rows)

    seconds()
    assert np.array_equal(results, runner.run(rows).values)
    return seconds
