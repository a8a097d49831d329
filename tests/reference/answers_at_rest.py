"""Reactions at rest under friction that depends on the load, on a given pair of flanks, found by samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

Pair = tuple[float, float]


def answers_at_rest(
    radii: Pair, slopes: Pair, axial: float, flanks: tuple[int, int], friction: Callable[[int, float], float]
) -> Iterator[Pair]:
    """x_1 and x_2 on their flanks, N/m, that bear the axial force > 0, N. friction(i, x): the friction force
    f_i x_i of contact i, 0 or 1, N/m. A contact that bears next to nothing hides between two samples of the
    other reaction: both are sampled. Answers beyond 1e4 times the load are left out: the rounding of the
    reactions hides the load there, and friction that grows with the load locks contacts."""
    yield from _by_samples(radii, slopes, axial, flanks, friction, 1)
    yield from _by_samples(radii, slopes, axial, flanks, friction, 0)


def _by_samples(
    radii: Pair,
    slopes: Pair,
    axial: float,
    flanks: tuple[int, int],
    friction: Callable[[int, float], float],
    i: int,
) -> Iterator[Pair]:
    """One reaction gives torque and axial force of its contact. Both contacts pass on the same torque. This
    torque and the rest of the axial force are linear in the other x and friction force, which must obey the
    law."""
    j = 1 - i
    r, a, other_r, other_a = radii[i], slopes[i], radii[j], slopes[j]

    def balanced(x: float) -> tuple[float, float]:
        q = friction(i, x)
        loads = [axial - (r * x - a * q), r * (a * x + r * q) / other_r]
        other, other_q = np.linalg.solve([[other_r, -other_a], [other_a, other_r]], loads)
        return float(other), float(other_q)

    def missed(log_x: float) -> float:
        other, q = balanced(flanks[i] * math.exp(log_x))
        return q - friction(j, other)

    grid = np.linspace(math.log(1e-12 * axial / r), math.log(1e4 * axial / r), 168)
    values = [missed(x) for x in grid]
    steps = zip(pairwise(grid), pairwise(values), strict=True)
    for low, high in (ends for ends, (before, after) in steps if before * after <= 0):
        x = flanks[i] * math.exp(brentq(missed, low, high, xtol=1e-14, rtol=1e-15))
        other = balanced(x)[0]
        if flanks[j] * other >= 0:
            yield (x, other) if i == 0 else (other, x)
