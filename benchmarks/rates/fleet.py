"""A step in a dualcam.Fleet of 1 to 10^5 instances, beside the same loop in C and in Python.

Every instance sets a torque, steps 1 ms, reads angle and speed. The torque changes every 32 steps, and the
helices slip most of the time. The times are per step of one instance:

C loop           the forward FMU's functions, called by a loop in C over all instances
fleet            Fleet.step, one thread
fleet, 2 threads Fleet.step, two threads
fleet, null      Fleet.step of an FMU that does nothing: what the fleet itself and FMI cost
Python loop      dualcam.Fmu, one handle per instance (up to 1000 instances)
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack

import numpy as np
from rich.console import Console

from benchmarks.growth.measure import TORQUES, WORK, Instances, powers
from benchmarks.harness import core
from benchmarks.harness.timing import Block, in_turns
from benchmarks.rates.measure import Group, Limit, Measure
from dualcam import Fleet, Fmu

STEP = 1e-3  # s
PERIOD = 32  # steps with one torque
START = {"initial.theta": 0.7}  # rad, as growth/instances.c
MOST_HANDLES = 1000
MOST = 100_000  # instances


def rounds_of(count: int) -> int:
    """Steps of each instance in a block."""
    return max(2 * PERIOD, WORK // count // (2 * PERIOD) * 2 * PERIOD)


def c_loop(instances: Instances, stack: ExitStack, count: int) -> Block:
    made, _ = stack.enter_context(instances.made(count))
    steps, done = rounds_of(count), 0

    def block() -> float:
        nonlocal done
        seconds = instances.sweep(made, steps, done * STEP)
        done += steps
        return seconds / steps / count

    return block


def fleet_loop(fleet: Fleet) -> Block:
    torques = [np.full((fleet.count, 1), torque) for torque in TORQUES]
    out = np.empty((fleet.count, 2))
    steps = rounds_of(fleet.count)

    def block() -> float:
        start = time.perf_counter()
        for k in range(steps):
            fleet.step(torques[k // PERIOD % 2], STEP, out)
        return (time.perf_counter() - start) / steps / fleet.count

    return block


def handle_loop(handles: list[Fmu]) -> Block:
    for handle in handles:
        handle.start(START)
    ports = [(handle.reals("tau"), handle.reals("theta", "omega")) for handle in handles]
    steps = 2 * PERIOD

    def block() -> float:
        start = time.perf_counter()
        for k in range(steps):
            torque = TORQUES[k // PERIOD % 2]
            for handle, (command, state) in zip(handles, ports, strict=True):
                command.values[0] = torque
                command.write()
                handle.step(STEP)
                state.read()
        return (time.perf_counter() - start) / steps / len(handles)

    return block


def blocks_of(count: int, instances: Instances, stack: ExitStack) -> dict[str, Block]:
    def fleet(source: str, threads: int = 1) -> Fleet:
        return stack.enter_context(Fleet(core.fmu_path(source), count, parameters=START, threads=threads))

    blocks = {
        "C loop": c_loop(instances, stack, count),
        "fleet": fleet_loop(fleet(core.FORWARD)),
        "fleet, 2 threads": fleet_loop(fleet(core.FORWARD, 2)),
        "fleet, null": fleet_loop(fleet(core.NULL)),
    }
    if count <= MOST_HANDLES:
        handles = [stack.enter_context(Fmu(core.fmu_path(core.FORWARD))) for _ in range(count)]
        blocks["Python loop"] = handle_loop(handles)
    return blocks


def take(rounds: int, console: Console) -> Iterator[Group]:
    instances = Instances()
    for count in powers(1, MOST):
        with ExitStack() as stack:
            blocks = blocks_of(count, instances, stack)
            yield Group(f"{count}", in_turns(blocks, rounds, f"{count} instances", console))


MEASURE = Measure(
    *("fleet", "A step of 1 ms of one instance of a fleet", take, 21, "C loop"),
    packages=("numpy",),
    limits=(Limit("1000", "fleet", "C loop", 1.2), Limit("1000", "fleet, 2 threads", "fleet", 1.0 / 1.8)),
)
