"""The program that runs under callgrind: the jobs of a pickled plan, one after the other. See
instructions.py."""

from __future__ import annotations

import ctypes
import os
import pickle
import sys
from pathlib import Path
from typing import Any

from benchmarks.harness import slave

Job = dict[str, Any]


class Replay:
    def __init__(self, loops: str) -> None:
        self.loops = ctypes.CDLL(loops)
        self.made: dict[tuple[str, str, str], slave.Bare] = {}

    def fmu(self, words: tuple[str, str, str]) -> slave.Bare:
        """The one instance for all jobs with that FMU. Each job begins with a saved state of its own."""
        if words not in self.made:
            self.made[words] = slave.Bare(*words)
        return self.made[words]

    def steps(self, job: Job, first: tuple[object, ...]) -> None:
        """`first`: the arguments of the C loop between the slave and the steps."""
        fmu = self.fmu(job["fmu"])
        struct = slave.slave_struct(fmu.library, fmu.component, job["references"])
        torques = doubles(job["torques"])
        status, total = ctypes.c_int(), ctypes.c_double()
        size, ends = ctypes.c_size_t(len(torques)), (ctypes.byref(status), ctypes.byref(total))
        begin()
        self.loops[job["loop"]](ctypes.byref(struct), *first, doubles(job["steps"]), torques, size, *ends)
        end()
        if status.value != 0:
            raise SystemExit(f"replay: status {status.value}")

    def seconds_steps(self, job: Job) -> None:
        for state in job["states"]:
            self.fmu(job["fmu"]).restore(state)
        self.steps(job, (ctypes.c_double(*doubles(job["instants"])),))

    def seconds_separate(self, job: Job) -> None:
        fmu = self.fmu(job["fmu"])
        states = [fmu.state(one) for one in job["states"]]
        made = (ctypes.c_void_p * len(states))(*(one.value for one in states))
        self.steps(job, (made, doubles(job["instants"])))

    def run_steps(self, job: Job) -> None:
        """Counts the last step of a sequence that starts from a saved state."""
        fmu = self.fmu(job["fmu"])
        fmu.restore(job["states"][0])
        instance = slave.instance_struct(fmu.library, fmu.component, job["references"])
        columns = [doubles(job[name]) for name in ("tau", "tau_rate", "force")]
        last = len(columns[0]) - 1

        def run(first: int, count: int) -> None:
            starts = (ctypes.addressof(column) + 8 * first for column in columns)
            part = slave.InputsStruct(*starts, job["step"], job["first"] + first, count)
            if self.loops.run_steps(ctypes.byref(instance), ctypes.byref(part)) != 0:
                raise SystemExit("replay: a step failed")

        run(0, last)
        begin()
        run(last, 1)
        end()


def begin() -> None:
    """Sets the counters to zero: instructions.py has callgrind watch this function of the C library."""
    os.getpgrp()


def end() -> None:
    """Writes the counters, likewise."""
    os.getppid()


def doubles(raw: bytes) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * (len(raw) // 8)).from_buffer_copy(raw)


def main() -> None:
    plan = pickle.loads(Path(sys.argv[1]).read_bytes())
    replay = Replay(plan["loops"])
    for job in plan["jobs"]:
        getattr(replay, job["loop"])(job)


if __name__ == "__main__":
    main()
