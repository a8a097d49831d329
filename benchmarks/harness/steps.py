"""Communication steps in C: a block of consecutive steps, or separate steps with a saved state each."""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from rich.console import Console

from benchmarks.harness import core, instructions
from benchmarks.harness.fmu import Slave
from benchmarks.harness.timing import Array, pointer

FMPY_STEPS = 200  # per block through FMPy
SOURCE = "harness/steps.c"


def library() -> Path:
    return core.loop_library(SOURCE)


def load_loops() -> ctypes.CDLL:
    timed = ("seconds_plain", "seconds_dependent", "seconds_steps", "seconds_separate")
    return core.load_loops(SOURCE, *timed)


def checked(seconds: float, status: ctypes.c_int, total: ctypes.c_double) -> float:
    if status.value != 0 or not math.isfinite(total.value):
        raise SystemExit(f"a timed step: status {status.value}, sum of outputs {total.value}")
    return float(seconds)


class StepBlock:
    """Consecutive steps of an initialised slave: torque [N.m] and size [s] of each, from `instant` [s] on."""

    def __init__(self, loops: ctypes.CDLL, slave: Slave, torque: Array, steps: Array, instant: float) -> None:
        self.loops, self.slave = loops, slave
        self.torque, self.steps, self.instant = np.ascontiguousarray(torque), steps, instant
        self.struct = slave.struct()
        self.state: ctypes.c_void_p | None = None

    def save(self) -> None:
        """Every block starts from the state of now. Without this a block continues the one before."""
        self.state = self.slave.fmu.getFMUState()

    def restore(self) -> None:
        if self.state is not None:
            self.slave.fmu.setFMUState(self.state)

    def seconds(self) -> float:
        """Seconds per step of one block in C."""
        self.restore()
        status, total = ctypes.c_int(), ctypes.c_double()
        seconds = self.loops.seconds_steps(
            ctypes.byref(self.struct),
            ctypes.c_double(self.instant),
            pointer(self.steps),
            pointer(self.torque),
            ctypes.c_size_t(len(self.steps)),
            ctypes.byref(status),
            ctypes.byref(total),
        )
        return checked(seconds, status, total) / len(self.steps)

    def job(self) -> instructions.Job:
        """One block for instructions.count()."""
        fmu = self.slave.fmu
        return {
            "loop": "seconds_steps",
            "fmu": instructions.fmu_words(fmu),
            "references": self.slave.references,
            "states": [] if self.state is None else [instructions.serialized(fmu, self.state)],
            "instants": instructions.raw([self.instant]),
            "steps": instructions.raw(self.steps),
            "torques": instructions.raw(self.torque[: len(self.steps)]),
        }

    def fmpy_seconds(self) -> float:
        """Seconds per step of FMPY_STEPS steps through FMPy's own methods."""
        self.restore()
        fmu, inputs = self.slave.fmu, [self.slave.references["tau"]]
        outputs = [self.slave.references["theta"], self.slave.references["omega"]]
        values = [[tau] for tau in self.torque[:FMPY_STEPS].tolist()]
        steps, instant = self.steps[:FMPY_STEPS].tolist(), self.instant
        start = time.perf_counter()
        for value, step in zip(values, steps, strict=True):
            fmu.setReal(inputs, value)
            fmu.doStep(instant, step)
            fmu.getReal(outputs)
            instant += step
        return (time.perf_counter() - start) / FMPY_STEPS

    def angle_travelled(self) -> float:
        """The sum of |change of theta| over the steps of a block [rad]."""
        self.restore()
        instant, travelled, last = self.instant, 0.0, self.slave.real("theta")
        for tau, step in zip(self.torque.tolist(), self.steps.tolist(), strict=True):
            self.slave.set({"tau": tau})
            self.slave.fmu.doStep(instant, step)
            theta = self.slave.real("theta")
            instant, travelled, last = instant + step, travelled + abs(theta - last), theta
        return travelled


class SeparateSteps:
    """The steps of a block in which the mode changes, each from the saved state before it."""

    def __init__(self, block: StepBlock) -> None:
        self.whole = block
        slave, fmu = block.slave, block.slave.fmu
        states, instants, torques, steps = [], [], [], []
        self.mode_changes, instant = 0, block.instant
        for tau, step in zip(block.torque.tolist(), block.steps.tolist(), strict=True):
            state, before = fmu.getFMUState(), slave.integer("events")
            slave.set({"tau": tau})
            fmu.doStep(instant, step)
            count = slave.integer("events") - before
            if count > 0:
                self.mode_changes += count
                states.append(state.value)
                instants.append(instant)
                torques.append(tau)
                steps.append(step)
            else:
                fmu.freeFMUState(state)
            instant += step
        self.count = len(states)
        if self.count == 0:
            raise SystemExit("no step of the scene has a mode change")
        self.states = (ctypes.c_void_p * self.count)(*states)
        self.instants, self.torques, self.steps = np.array(instants), np.array(torques), np.array(steps)

    def seconds(self) -> float:
        """Seconds per step, over all of them."""
        status, total = ctypes.c_int(), ctypes.c_double()
        seconds = self.whole.loops.seconds_separate(
            ctypes.byref(self.whole.struct),
            self.states,
            pointer(self.instants),
            pointer(self.steps),
            pointer(self.torques),
            ctypes.c_size_t(self.count),
            ctypes.byref(status),
            ctypes.byref(total),
        )
        return checked(seconds, status, total) / self.count

    def job(self) -> instructions.Job:
        """All of them for instructions.count()."""
        fmu = self.whole.slave.fmu
        return {
            **self.whole.job(),
            "loop": "seconds_separate",
            "states": [instructions.serialized(fmu, ctypes.c_void_p(state)) for state in self.states],
            "instants": instructions.raw(self.instants),
            "steps": instructions.raw(self.steps),
            "torques": instructions.raw(self.torques),
        }


def instructions_per_step(
    blocks: Mapping[str, StepBlock | SeparateSteps], console: Console
) -> dict[str, float]:
    """By name; empty where valgrind is not installed."""
    if not instructions.available():
        console.print(instructions.WITHOUT)
        return {}
    jobs = [block.job() for block in blocks.values()]
    counts = instructions.count(library(), jobs)
    lengths = [len(job["torques"]) // 8 for job in jobs]
    return {name: n / length for name, n, length in zip(blocks, counts, lengths, strict=True)}
