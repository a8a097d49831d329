"""Steps per second of the environments of dualcam.gym: one, many by gymnasium's loop, many by one fleet.

A step of the elbow is 10 control periods of 1 ms: 200 samples of the current loop and 10 steps of the FMU.
Random torques; episodes begin anew as they end. The times are per step of one instance:

gymnasium.make      one environment
sync                gymnasium.make_vec with vectorization_mode="sync": a loop over environments
fleet               gymnasium.make_vec: one dualcam.Fleet, one thread
fleet, 2 threads    the same with threads=2: the FMU's share of the work runs in two threads
Batch               dualcam.gym.Batch, the same work without gymnasium's words
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import gymnasium
import numpy as np
from rich.console import Console

from benchmarks.harness.timing import Block, in_turns
from benchmarks.rates.measure import Group, Measure
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


def take(rounds: int, console: Console) -> Iterator[Group]:
    for task in TASKS:
        for count in (1, *COUNTS) if task == "Elbow" else (1, 1000):
            what = f"{task}, {count}"
            with ExitStack() as stack:
                yield Group(what, in_turns(blocks_of(task, count, stack), rounds, what, console))


MEASURE = Measure(
    *("gym", "A step of the environments, random torques", take, 5), packages=("numpy", "gymnasium")
)
