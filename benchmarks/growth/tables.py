"""Cost over the number of points of a groove table."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import numpy as np

from benchmarks.growth.instances import Row, powers
from benchmarks.harness import steps
from benchmarks.harness.fmu import Slave
from benchmarks.harness.processes import resident_bytes
from benchmarks.harness.steps import StepBlock
from benchmarks.mechanisms import START, STEP, STEPS, TABLE_WIDTH, tables, to_and_fro


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
