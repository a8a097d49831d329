"""Steps whose inputs are given one by one: the time, the outputs and the instructions of each step."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track

from benchmarks.harness import core, instructions, slave
from benchmarks.harness.fmu import Parameters, Slave
from benchmarks.harness.timing import pointer

STEP = 1e-3  # s
LEAD_IN = 200  # steps before a counted step; they fill what the FMU keeps from step to step
READ = ("theta", "omega", "energy.heat_stop", "cam1.reaction", "cam2.reaction")
SOURCE = "harness/inputs.c"

Array = NDArray[Any]


@dataclass
class Inputs:
    """Torque [N.m] and its rate [N.m/s] at the start of every step, and the follower force [N]."""

    tau: Array
    tau_rate: Array
    force: Array

    def __len__(self) -> int:
        return len(self.tau)


class ReadoutStruct(ctypes.Structure):
    """`Readout` of inputs.c."""

    _fields_ = [
        ("get_integer", ctypes.c_void_p),
        ("integers", ctypes.c_uint * 2),
        ("reals", ctypes.c_void_p),
        ("count", ctypes.c_size_t),
    ]


class InputRun:
    """An instance of the forward FMU at the start of a run of steps, and the inputs of the run.

    A step that fails raises SystemExit."""

    def __init__(self, parameters: Parameters, inputs: Inputs) -> None:
        self.inputs = inputs
        self.loops = core.load_loops(SOURCE, "clock_seconds")
        self.slave = Slave()
        self.slave.set(parameters)
        self.slave.enter_initialization()
        self.slave.set({"tau": float(inputs.tau[0]), "F_ext": float(inputs.force[0])})
        fmu = self.slave.fmu
        fmu.exitInitializationMode()
        self.state = fmu.getFMUState()
        self.instance = slave.instance_struct(fmu.dll, fmu.component, self.slave.references)

    def part(self, first: int, end: int) -> slave.InputsStruct:
        columns = (self.inputs.tau, self.inputs.tau_rate, self.inputs.force)
        return slave.InputsStruct(*(c[first:].ctypes.data for c in columns), STEP, first, end - first)

    def run(self, loop: str, *arguments: object, first: int = 0, end: int | None = None) -> None:
        """All steps from the saved state, or the steps `first` to `end` from where the instance stands."""
        if end is None:
            self.slave.fmu.setFMUState(self.state)
            end = len(self.inputs)
        part = self.part(first, end)
        failed = getattr(self.loops, loop)(ctypes.byref(self.instance), ctypes.byref(part), *arguments)
        if failed != 0:
            raise SystemExit(f"{loop}: {failed} of {end - first} steps failed")

    def least_seconds(self, rounds: int, description: str, console: Console) -> Array:
        """The least time of each step over the rounds, free of interrupts: these never hit the same step
        twice."""
        least = np.full(len(self.inputs), np.inf)
        for _ in track(range(rounds), description, console=console, transient=True):
            self.run("time_steps", pointer(least))
        return np.maximum(least - self.loops.clock_seconds(), 0.0)

    def record(self) -> tuple[NDArray[np.int32], Array]:
        """Mode and events after each step, shape (steps, 2), and the variables READ, shape (steps, 5)."""
        references = (ctypes.c_uint * len(READ))(*(self.slave.references[name] for name in READ))
        readout = ReadoutStruct(
            slave.address(self.slave.fmu.dll, "fmi2GetInteger"),
            (ctypes.c_uint * 2)(self.slave.references["mode"], self.slave.references["events"]),
            ctypes.addressof(references),
            len(READ),
        )
        integers = np.zeros((len(self.inputs), 2), dtype=np.int32)
        reals = np.zeros((len(self.inputs), len(READ)))
        pointers = (ctypes.c_void_p(integers.ctypes.data), pointer(reals))
        self.run("record_steps", ctypes.byref(readout), *pointers)
        return integers, reals

    def jobs(self, chosen: NDArray[np.intp]) -> list[instructions.Job]:
        """For instructions.count(): each of the chosen steps, in rising order, from the state LEAD_IN steps
        before."""
        fmu = self.slave.fmu
        fmu.setFMUState(self.state)
        found, here = [], 0
        for k in chosen.tolist():
            start = max(0, k - LEAD_IN)
            self.run("run_steps", first=here, end=start)
            here = start
            state = fmu.getFMUState()
            found.append(
                {
                    "loop": "run_steps",
                    "fmu": instructions.fmu_words(fmu),
                    "references": self.slave.references,
                    "states": [instructions.serialized(fmu, state)],
                    "tau": instructions.raw(self.inputs.tau[start : k + 1]),
                    "tau_rate": instructions.raw(self.inputs.tau_rate[start : k + 1]),
                    "force": instructions.raw(self.inputs.force[start : k + 1]),
                    "step": STEP,
                    "first": start,
                }
            )
            fmu.freeFMUState(state)
        return found

    def count(self, chosen: NDArray[np.intp]) -> NDArray[np.int64]:
        """Instructions of the chosen steps; zeros where valgrind is not installed."""
        if not instructions.available():
            return np.zeros(len(chosen), dtype=np.int64)
        return np.array(instructions.count(core.loop_library(SOURCE), self.jobs(chosen)))
