"""Cost over the number of instances, of steps, of threads and of table points; cost of starting up."""

from __future__ import annotations

import ctypes
import math
import statistics
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from benchmarks.harness import core, instructions, steps
from benchmarks.harness.fmu import Slave
from benchmarks.harness.processes import resident_bytes
from benchmarks.harness.repository import BENCHMARKS
from benchmarks.harness.slave import address
from benchmarks.harness.steps import StepBlock
from benchmarks.mechanisms import START, STEP, STEPS, TABLE_WIDTH, tables, to_and_fro

TORQUES = (8.0, 1.0)  # N.m, 32 steps each
WORK = 100_000  # steps at least per timing
START_UP = ("load the library", "instantiate", "initialise", "first step")
Row = tuple[str, str, float, float, float]  # what, unit, size, seconds and bytes per unit


def powers(smallest: int, largest: int) -> list[int]:
    """The powers of ten from `smallest` to `largest`."""
    return [10**k for k in range(10) if smallest <= 10**k <= largest]


class MakerStruct(ctypes.Structure):
    """`Maker` of instances.c."""

    _fields_ = [
        *(
            (name, ctypes.c_void_p)
            for name in ("instantiate", "setup", "enter", "leave", "release", "set_real")
        ),
        ("initial", ctypes.c_uint),
        ("guid", ctypes.c_char_p),
        ("resources", ctypes.c_char_p),
        ("callbacks", ctypes.c_void_p),
    ]


class Instances:
    """Many instances of the forward FMU, made and stepped in C. SystemExit if a call of FMI fails."""

    def __init__(self) -> None:
        self.loops = core.load_loops("growth/instances.c", "sweep")
        self.slave = Slave()
        fmu = self.slave.fmu
        names = ("Instantiate", "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode")
        self.maker = MakerStruct(
            *(address(fmu.dll, f"fmi2{name}") for name in (*names, "FreeInstance", "SetReal")),
            self.slave.references["initial.theta"],
            fmu.guid.encode(),
            Path(fmu.unzipDirectory, "resources").as_uri().encode(),
            ctypes.addressof(fmu.callbacks),
        )
        self.struct = self.slave.struct()

    @contextmanager
    def made(self, count: int) -> Iterator[tuple[ctypes.Array[ctypes.c_void_p], tuple[float, float]]]:
        """Initialised instances, and the seconds of instantiating and of initialising all of them."""
        made, seconds = (ctypes.c_void_p * count)(), (ctypes.c_double * 2)()
        if self.loops.make(ctypes.byref(self.maker), ctypes.c_size_t(count), made, seconds) != 0:
            raise SystemExit("growth: an instance could not be made")
        yield made, (seconds[0], seconds[1])
        self.loops.release(ctypes.byref(self.maker), ctypes.c_size_t(count), made)

    def sweep(self, made: ctypes.Array[ctypes.c_void_p], steps: int, instant: float = 0.0) -> float:
        """Seconds in which every instance takes `steps` steps, starting at `instant` [s]."""
        status = ctypes.c_int()
        seconds = self.loops.sweep(
            ctypes.byref(self.struct),
            made,
            ctypes.c_size_t(len(made)),
            ctypes.c_double(instant),
            ctypes.c_size_t(steps),
            (ctypes.c_double * 2)(*TORQUES),
            ctypes.byref(status),
        )
        if status.value != 0:
            raise SystemExit(f"growth: status {status.value}")
        return float(seconds)

    def of_instances(self, largest: int) -> Iterator[Row]:
        for count in powers(1, largest):
            before = resident_bytes()
            with self.made(count) as (made, (instantiate, initialise)):
                gained = resident_bytes() - before
                rounds = max(64, WORK // count // 64 * 64)
                stepped = self.sweep(made, rounds)
            yield "instances: instantiate", "instance", count, instantiate / count, gained / count
            yield "instances: initialise", "instance", count, initialise / count, math.nan
            yield "instances: step", "step", count, stepped / count / rounds, math.nan

    def of_steps(self, largest: int) -> Iterator[Row]:
        for count in powers(1, largest):
            repeats = max(1, min(1000, WORK // count))
            seconds, gained = 0.0, 0
            for _ in range(repeats):
                with self.made(1) as (made, _times):
                    before = resident_bytes()
                    seconds += self.sweep(made, count)
                    gained = max(gained, resident_bytes() - before)
            yield "steps", "step", count, seconds / repeats / count, gained / count

    def of_threads(self) -> Iterator[Row]:
        """Each thread steps 100 instances of its own. The time is that of all threads together."""
        for count in (1, 2):
            pools = [self.made(100) for _ in range(count)]
            made = [pool.__enter__()[0] for pool in pools]
            threads = [threading.Thread(target=self.sweep, args=(own, 6400)) for own in made]
            start = time.perf_counter()
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            seconds = time.perf_counter() - start
            for pool in pools:
                pool.__exit__(None, None, None)
            yield "threads", "step", count, seconds / count / 640_000, math.nan


def of_tables(largest: int) -> Iterator[Row]:
    """Initialising and stepping with tables of 10 to `largest` points in both grooves."""
    for points in powers(10, largest):
        parameters = START | tables(points)
        slave = Slave()
        before = resident_bytes()
        start = time.perf_counter()
        slave.set(parameters)
        slave.initialise()
        seconds, gained = time.perf_counter() - start, resident_bytes() - before
        yield "table points: initialise", "point", points, seconds / points, gained / points
        block = StepBlock(steps.load_loops(), slave, to_and_fro(), np.full(STEPS, STEP), 0.0)
        block.save()
        block.seconds()
        stepped = block.seconds()
        yield "table points: step", "step", points, stepped, math.nan
        # The psi of each groove turns by about half of theta, and there are two grooves.
        knots = block.angle_travelled() * (points - 1) / TABLE_WIDTH
        per_knot = stepped / (1.0 + knots / STEPS)
        yield "table points: knot passed", "step and knot", points, per_knot, math.nan
        slave.fmu.freeInstance()


def start_up(rounds: int) -> Iterator[Row]:
    """The parts of a start-up, from C, in a new process for each round. All memory is touched for the first
    time."""
    program = core.BUILD / "start_up"
    core.compile_c(["-O2", "-ldl"], [BENCHMARKS / "growth/start_up.c"], program)
    slave = Slave()
    words = [str(program), *instructions.fmu_words(slave.fmu), str(slave.references["tau"])]
    runs = [list(map(float, subprocess.check_output(words, text=True).split())) for _ in range(rounds)]
    for name, seconds in zip(START_UP, zip(*runs, strict=True), strict=True):
        yield f"start-up: {name}", "call", 1, statistics.median(seconds), math.nan
