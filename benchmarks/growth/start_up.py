"""Cost of starting up: from nothing to the end of the first step."""

from __future__ import annotations

import math
import statistics
import subprocess
from collections.abc import Iterator

from benchmarks.growth.instances import Row
from benchmarks.harness import core, instructions
from benchmarks.harness.fmu import Slave
from benchmarks.harness.repository import BENCHMARKS

START_UP = ("load the library", "instantiate", "initialise", "first step")


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
