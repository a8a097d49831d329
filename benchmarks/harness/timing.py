"""Blocks of work timed in turns, their ratios, and the unit of time: one exp and one sincos."""

from __future__ import annotations

import ctypes
import math
import random
import statistics
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track

Array = NDArray[np.float64]
Block = Callable[[], float]  # seconds per unit of work

UNIT_CALLS = 1000  # of exp and of sincos in a block


def pointer(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


@dataclass
class Ratio:
    """Median and quartiles of the ratios of blocks of the same round."""

    median: float
    lower: float
    upper: float

    @classmethod
    def of(cls, above: list[float], below: list[float]) -> Ratio:
        lower, median, upper = statistics.quantiles(
            [a / b for a, b in zip(above, below, strict=True)], n=4, method="inclusive"
        )
        return cls(median, lower, upper)

    def __str__(self) -> str:
        return f"{self.median:.3g} ({self.lower:.3g}-{self.upper:.3g})"


def in_turns(
    blocks: dict[str, Block], rounds: int, description: str, console: Console
) -> dict[str, list[float]]:
    """Times of every block over the rounds, each round in a new order. The first round warms up and does not
    count."""
    order = list(blocks)
    shuffle = random.Random(3).shuffle
    times: dict[str, list[float]] = {name: [] for name in blocks}
    for number in track(range(-1, rounds), description, console=console, total=rounds + 1, transient=True):
        shuffle(order)
        for name in order:
            seconds = blocks[name]()
            if number >= 0:
                times[name].append(seconds)
    return times


def unit_block(loops: ctypes.CDLL, loop: str) -> Block:
    """Seconds of one exp and one sincos of the machine's libm, by a loop of unit.h or steps.c.

    The functions are looked up by name. They are then the newest versions in libm, also where an FMU that is
    built for an older glibc gets older ones."""
    libm = ctypes.CDLL("libm.so.6")
    functions = [ctypes.cast(getattr(libm, name), ctypes.c_void_p) for name in ("exp", "sincos")]
    angles = np.random.default_rng(2).uniform(0.0, 2.0 * math.pi, UNIT_CALLS)

    def block() -> float:
        total = ctypes.c_double()
        seconds = getattr(loops, loop)(
            *functions, pointer(angles), ctypes.c_size_t(UNIT_CALLS), ctypes.byref(total)
        )
        return float(seconds) / UNIT_CALLS

    return block
