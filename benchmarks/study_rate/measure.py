"""Rates, also from C, the profile of a run, and the memory of a whole study."""

from __future__ import annotations

import ctypes
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial

import fmpy
import numpy as np
from rich.console import Console

from benchmarks.harness import core
from benchmarks.harness.processes import resident_bytes
from benchmarks.harness.timing import Block, in_turns
from benchmarks.study_rate.study import (
    HALF,
    RAMPS,
    RESULTS,
    TORQUE,
    VARY,
    seconds_of_runs,
    smooth_study,
    study,
)
from dualcam import Fleet
from dualcam.fmi.fmu import Array
from dualcam.study.run.runner import Runner

NAIVE_RUNS = 10
FLEET = 1000  # instances


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


def naive(rows: Array) -> float:
    """Seconds per run of fmpy.simulate_fmu."""
    names = [(name, float) for name in ("time", "tau", "F_ext")]
    torque = np.array([(0.0, 8.0, 0.0), (0.2, 8.0, 0.0), (0.2, 0.0, 0.0)], dtype=names)
    start = time.process_time()
    for row in rows[:NAIVE_RUNS]:
        fmpy.simulate_fmu(
            str(core.fmu_path(core.FORWARD)),
            stop_time=0.4,
            step_size=0.2,
            output_interval=0.2,
            start_values=dict(zip(VARY, row.tolist(), strict=True)),
            input=torque,
            output=[name.partition("@")[0] for name in RESULTS],
        )
    return (time.process_time() - start) / NAIVE_RUNS


def fleet(rows: Array) -> Block:
    """Seconds of a run in a fleet. The results are those of a runner."""
    names = [name.partition("@")[0] for name in RESULTS]
    made = Fleet(core.fmu_path(core.FORWARD), FLEET, ["tau"], [])
    push, nothing = np.full((FLEET, 1), TORQUE), np.zeros((FLEET, 1))

    def runs(block: Array) -> Array:
        made.reset(parameters=dict(zip(VARY, block.T, strict=True)))
        made.step(push, HALF)
        first = made.get(names[0])
        made.step(nothing, HALF)
        return np.column_stack([first, *(made.get(name) for name in names[1:])])

    def seconds() -> float:
        start = time.process_time()
        for first in range(0, len(rows), FLEET):
            runs(rows[first : first + FLEET])
        return (time.process_time() - start) / len(rows)

    assert np.array_equal(runs(rows[:FLEET]), Runner(study().job()).run(rows[:FLEET]).values)
    return seconds


def profile(rows: Array) -> dict[str, float]:
    """Microseconds of a run by FMI function, called from Python; the clock's own time is taken off."""
    runner = Runner(study().job(), in_c=False)
    clock = time.perf_counter
    totals: dict[str, float] = {}
    plain = list(runner.calls)

    def timed(call: Callable[[], int], name: str) -> int:
        start = clock()
        status = call()
        totals[name] += clock() - start
        return status

    for k, call in enumerate(plain):
        assert isinstance(call, partial)
        totals[call.func.__name__] = 0.0
        runner.calls[k] = partial(timed, call, call.func.__name__)
    runner.run(rows)
    runner.calls[:] = plain
    start = clock()
    for _ in rows:
        clock()
    tick = (clock() - start) / len(rows)
    names = [call.func.__name__ for call in plain if isinstance(call, partial)]
    return {name: 1e6 * (total / len(rows) - names.count(name) * tick) for name, total in totals.items()}


def memory(runs: int) -> tuple[float, float, float]:
    """Most MiB during the second tenth of the chunks and during the last, and runs per second, of a study in
    this process. The memory goes up and down from chunk to chunk."""
    whole = study(runs=runs)
    whole.plan.rows(0, 1)  # the plan's own table is there from the start
    seen: list[float] = []
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        whole.run_to_files(
            folder,
            workers=0,
            file_format="parquet",
            runs_per_file=max(runs // 100, 1),
            on_file_written=lambda: seen.append(resident_bytes() / 2**20),
        )
    tenth = len(seen) // 10
    return max(seen[tenth : 2 * tenth]), max(seen[-tenth:]), runs / (time.perf_counter() - start)


def rates(cam: Runner, rows: Array, rounds: int, console: Console) -> dict[str, list[float]]:
    """Seconds per run, by the ways to run the study, in every round."""
    null = Runner(study(core.NULL).job())
    curves = smooth_study()
    blocks: dict[str, Block] = {
        "cam": partial(seconds_of_runs, cam, rows),
        "cam, reset": partial(seconds_of_runs, Runner(study().job(), saves_state=False), rows),
        "cam, from Python": partial(seconds_of_runs, Runner(study().job(), in_c=False), rows),
        "cam, fleet": fleet(rows),
        "null": partial(seconds_of_runs, null, rows),
        "cam, ramps": partial(seconds_of_runs, Runner(study(history=RAMPS).job()), rows),
        "cam, smooth": partial(seconds_of_runs, Runner(curves.job()), curves.plan.rows(0, len(rows))),
        "cam, in C": in_c(cam, rows),
        "null, in C": in_c(null, rows),
        "naive": partial(naive, rows),
    }
    return in_turns(blocks, rounds, "runs", console)
