"""The cost of a step in a dualcam.Fleet, beside the same loop in C and in Python.

    ./build.sh fleet

Every instance sets a torque, steps 1 ms, reads angle and speed. The torque changes every 32 steps, and the
helices slip most of the time. Each row is a median over rounds in which all ways take turns, per step of one
instance, for 1 to 10^5 instances:

C loop           the forward FMU's functions, called by a loop in C over all instances
fleet            Fleet.step, one thread
fleet, 2 threads Fleet.step, two threads
fleet, null      Fleet.step of an FMU that does nothing: what the fleet itself and FMI cost
Python loop      dualcam.Fmu, one handle per instance (up to 1000 instances)
"""

from __future__ import annotations

import statistics
import sys
import time
from contextlib import ExitStack

import numpy as np

from benchmarks.growth.instances import TORQUES, WORK, Instances, powers
from benchmarks.harness import core
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.timing import Block, Ratio, in_turns
from dualcam import Fleet, Fmu

STEP = 1e-3  # s
PERIOD = 32  # steps with one torque
START = {"initial.theta": 0.7}  # rad, as growth/instances.c
MOST_HANDLES = 1000
TARGETS = {"fleet": ("C loop", 1.2), "fleet, 2 threads": ("fleet", 1.0 / 1.8)}
TARGET_COUNT = 1000


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


def row_of(count: int, way: str, seconds: list[float], compared: list[float]) -> dict[str, str]:
    ratio = Ratio.of(seconds, compared)
    return {
        "instances": str(count),
        "way": way,
        "ns_per_step": f"{1e9 * statistics.median(seconds):.1f}",
        "share_of_c_loop": f"{ratio.median:.3f}",
        "lower_quartile": f"{ratio.lower:.3f}",
        "upper_quartile": f"{ratio.upper:.3f}",
    }


def main() -> int:
    parser = harness.options(__doc__, "fleet", 21)
    parser.add_argument("--instances", type=int, default=100_000, help="largest number of instances (10^5)")
    arguments = parser.parse_args()
    console = harness.new_console()
    instances = Instances()
    table = harness.table(
        "A step of 1 ms of one instance: set a torque, step, read angle and speed",
        *("instances", "through", "ns", "share of the C loop"),
    )
    rows, missed = [], False
    for count in powers(1, arguments.instances):
        with ExitStack() as stack:
            blocks = blocks_of(count, instances, stack)
            times = in_turns(blocks, arguments.rounds, f"{count} instances", console)
        for way, seconds in times.items():
            row = row_of(count, way, seconds, times["C loop"])
            rows.append(row)
            table.add_row(str(count), way, row["ns_per_step"], str(Ratio.of(seconds, times["C loop"])))
        for way, (other, target) in TARGETS.items() if count == TARGET_COUNT else ():
            share = Ratio.of(times[way], times[other]).median
            missed |= share > target
            verdict = harness.verdict(share, target)
            harness.say(console, f"{count} instances: {way} is {share:.3f} of {other}: target {verdict}")
    console.print(table)
    harness.publish(rows, circumstances("fleet", "numpy"), arguments.output, console)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
