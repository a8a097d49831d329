"""A run of a scene: the time of every step, and the instructions of chosen steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from benchmarks.harness.inputs import Array, InputRun
from benchmarks.worst_step.history import History
from benchmarks.worst_step.scenes import Levels, Scene, random_inputs


@dataclass
class Study:
    scene: Scene
    seconds: Array
    history: History
    chosen: NDArray[np.intp]
    instructions: NDArray[np.int64]

    def counted(self, mask: NDArray[np.bool_]) -> int:
        """Most instructions among the counted steps of that mask; 0 if none was counted."""
        inside = mask[self.chosen]
        return int(self.instructions[inside].max()) if inside.any() else 0

    def counted_per_change(self, mask: NDArray[np.bool_]) -> int:
        """The same, divided by the mode changes and one more: the instructions between two mode changes."""
        inside = mask[self.chosen]
        each = self.instructions / (1 + self.history.changes[self.chosen])
        return int(each[inside].max()) if inside.any() else 0

    @property
    def uncounted(self) -> NDArray[np.bool_]:
        """The steps that were not counted."""
        mask = np.ones(len(self.seconds), dtype=bool)
        mask[self.chosen] = False
        return mask

    @property
    def worst(self) -> int:
        """Place in `chosen` of the step with most instructions, or of the longest where none are counted."""
        return int(np.argmax(self.instructions if self.instructions.any() else self.seconds[self.chosen]))


def longest(seconds: Array, count: int, mask: NDArray[np.bool_] | None = None) -> NDArray[np.intp]:
    inside = np.arange(len(seconds)) if mask is None else np.flatnonzero(mask)
    return inside[np.argsort(seconds[inside])[-count:]]


def choose(seconds: Array, history: History, count: int) -> NDArray[np.intp]:
    """The steps to count, in rising order."""
    masks = [history.changes == n for n in np.unique(history.changes)] + list(history.kinds().values())
    picked = [longest(seconds, count), *(longest(seconds, max(1, count // 10), mask) for mask in masks)]
    chance = np.random.default_rng(5).choice(len(seconds), min(count, len(seconds)), replace=False)
    return np.unique(np.concatenate([*picked, chance]))


def study(scene: Scene, count: int, rounds: int, counted: int, console: Console) -> Study:
    """`count` steps, each timed `rounds` times; the instructions of the `counted` longest and some more."""
    inputs = random_inputs(count, Levels.of(scene.parameters))
    run = InputRun(scene.parameters, inputs)
    history = History.of(*run.record(), inputs)
    seconds = run.least_seconds(rounds, scene.name, console)
    chosen = choose(seconds, history, counted)
    return Study(scene, seconds, history, chosen, run.count(chosen))
