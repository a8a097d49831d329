"""Steps per second of the environments of dualcam.gym: one, many by gymnasium's loop, many by one fleet.

    ./build.sh gym

A step of the elbow is 10 control periods of 1 ms: 200 samples of the current loop and 10 steps of the FMU.
Random torques; episodes begin anew as they end. Each row is a median over rounds in which all ways take
turns:

gymnasium.make      one environment
sync                gymnasium.make_vec with vectorization_mode="sync": a loop over environments
fleet               gymnasium.make_vec: one dualcam.Fleet, one thread
fleet, 2 threads    the same with threads=2: the FMU's share of the work runs in two threads
Batch               dualcam.gym.Batch, the same work without gymnasium's words
"""

from __future__ import annotations

import statistics
import sys
import time
from contextlib import ExitStack
from typing import Any

import gymnasium
import numpy as np

from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.timing import Block, in_turns
from dualcam.gym import EPISODE_STEPS, TASKS, Batch

COUNTS = (10, 100, 1000, 10_000)
MOST_IN_A_LOOP = 100  # environments of the way "sync"
WORK = 4000  # steps of one instance, of all instances together, in a block


def single(task: str, stack: ExitStack) -> Block:
    environment = gymnasium.make(f"dualcam/{task}-v0")
    stack.callback(environment.close)
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (WORK // 10, 1))
    environment.reset(seed=1)

    def block() -> float:
        start = time.perf_counter()
        for action in actions:
            _, _, terminated, truncated, _ = environment.step(action)
            if terminated or truncated:
                environment.reset()
        return (time.perf_counter() - start) / len(actions)

    return block


def vector(task: str, count: int, stack: ExitStack, way: str) -> Block:
    options: dict[str, Any] = {}
    if way == "sync":
        options["vectorization_mode"] = "sync"
    if way == "fleet, 2 threads":
        options["threads"] = 2
    environment = gymnasium.make_vec(f"dualcam/{task}-v0", num_envs=count, **options)
    stack.callback(environment.close)
    steps = max(4, WORK // 10 // count if way == "sync" else WORK // count)
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (steps, count, 1))
    environment.reset(seed=1)

    def block() -> float:
        start = time.perf_counter()
        for action in actions:
            environment.step(action)
        return (time.perf_counter() - start) / steps / count

    return block


def raw(task: str, count: int, stack: ExitStack) -> Block:
    batch = stack.enter_context(Batch(TASKS[task](), count))
    random, steps = np.random.default_rng(1), max(4, WORK // count)
    torques = random.uniform(-1.0, 1.0, (steps, count)) * batch.task.motor.peak_torque
    done = EPISODE_STEPS[task]

    def block() -> float:
        nonlocal done
        start = time.perf_counter()
        for torque in torques:
            if done == EPISODE_STEPS[task]:
                batch.reset(random.random((count, batch.task.draws)))
                done = 0
            batch.step(torque)
            done += 1
        return (time.perf_counter() - start) / steps / count

    return block


def blocks_of(task: str, count: int, stack: ExitStack) -> dict[str, Block]:
    if count == 1:
        return {"gymnasium.make": single(task, stack)}
    ways = (["sync"] if count <= MOST_IN_A_LOOP else []) + ["fleet", "fleet, 2 threads"]
    blocks = {way: vector(task, count, stack, way) for way in ways}
    return blocks | {"Batch": raw(task, count, stack)}


def main() -> int:
    parser = harness.options(__doc__, "gym_rate", 5)
    arguments = parser.parse_args()
    console = harness.new_console()
    table = harness.table(
        "Steps of the environments, random torques",
        *("task", "instances", "through", "us per step", "steps per second"),
    )
    rows = []
    for task in TASKS:
        for count in (1, *COUNTS) if task == "Elbow" else (1, 1000):
            with ExitStack() as stack:
                times = in_turns(blocks_of(task, count, stack), arguments.rounds, f"{task}, {count}", console)
            for way, seconds in times.items():
                median = statistics.median(seconds)
                row = {
                    "task": task,
                    "instances": str(count),
                    "way": way,
                    "us_per_step": f"{1e6 * median:.2f}",
                    "steps_per_second": f"{1.0 / median:.0f}",
                }
                rows.append(row)
                table.add_row(*row.values())
    console.print(table)
    harness.publish(rows, circumstances("gym", "numpy", "gymnasium"), arguments.output, console)
    return 0


if __name__ == "__main__":
    sys.exit(main())
