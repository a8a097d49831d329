"""Arrangements of runs: points in the unit cube, which distributions then turn into values.

SciPy makes Latin hypercubes and Sobol sequences. SALib makes what its analysers take: the trajectories of
Morris, the search curves of FAST, the samples of Saltelli."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from dualcam.common.mistakes import optional_module
from dualcam.fmi.reals import Array

KINDS = ("grid", "random", "latin", "sobol", "indices", "saltelli", "morris", "fast", "table")
INDEPENDENT = ("random", "latin", "sobol")  # their runs may be correlated, and drawn again one by one
SALIB = ("saltelli", "morris", "fast")
HARMONICS = 4  # M of FAST
FAST_LEAST = 4 * HARMONICS**2 + 1  # runs of each variable
LARGEST = 100_000_000  # numbers of a table of points: 0.8 GB, of which SciPy and SALib make copies


def count(kind: str, runs: int, variables: int, second_order: bool) -> int:
    """How many runs an arrangement has, by the number that the user gives; not of "grid" and "table"."""
    blocks = {
        "indices": variables + 2,
        "saltelli": 2 * variables + 2 if second_order else variables + 2,
        "morris": variables + 1,
        "fast": variables,
    }
    return runs * blocks.get(kind, 1)


def problems(kind: str, runs: int, variables: int, second_order: bool, levels: int) -> Iterator[str]:
    """What is wrong with the numbers of an arrangement."""
    if kind in ("indices", "saltelli") and (runs < 2 or runs & (runs - 1)):
        yield f"runs = {runs}: Sobol's indices need a power of 2, at least 2"
    if kind == "fast" and runs < FAST_LEAST:
        yield f"runs = {runs}: FAST needs at least {FAST_LEAST} for each variable"
    if kind == "morris" and (levels < 2 or levels % 2):
        yield f"levels = {levels}: Morris needs an even number, at least 2"
    if kind in ("grid", "table"):
        return
    points = 2 * runs if kind == "indices" else count(kind, runs, variables, second_order)
    if (numbers := points * variables) > LARGEST:
        yield (
            f"runs = {runs}: the points of the runs are a table of {numbers:,} numbers; allowed are"
            f" {LARGEST:,}, here up to runs = {LARGEST * runs // numbers}; a grid needs no table"
        )


def shares(kind: str, runs: int, variables: int, seed: int, second_order: bool, levels: int) -> Array:
    """The points, shape (count, variables), in [0, 1]; of "indices" of both matrices, (runs, 2 variables)."""
    from scipy.stats import qmc

    if kind in SALIB:
        return _of_salib(kind, runs, variables, seed, second_order, levels)
    if kind == "random":
        return np.random.default_rng(seed).random((runs, variables))
    if kind == "latin":
        return np.asarray(qmc.LatinHypercube(variables, rng=seed).random(runs))
    width = variables * (2 if kind == "indices" else 1)
    return np.asarray(qmc.Sobol(width, rng=seed).random_base2((runs - 1).bit_length())[:runs])


def _of_salib(kind: str, runs: int, variables: int, seed: int, second_order: bool, levels: int) -> Array:
    names = [f"x{place}" for place in range(variables)]
    cube = {"num_vars": variables, "names": names, "bounds": [[0.0, 1.0]] * variables}
    samplers: dict[str, tuple[str, dict[str, Any]]] = {
        "saltelli": ("sobol", {"calc_second_order": second_order}),
        "morris": ("morris", {"num_levels": levels}),
        "fast": ("fast_sampler", {"M": HARMONICS}),
    }
    name, options = samplers[kind]
    kinds = ", ".join(SALIB)
    advice = f"plans of kind {kinds} need SALib: pip install SALib, or take kind = 'indices'"
    module = optional_module(f"SALib.sample.{name}", advice)
    return np.asarray(module.sample(cube, runs, seed=seed, **options), float)
