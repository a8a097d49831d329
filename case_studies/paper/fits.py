"""Which friction that depends on the load makes the published RMSEs?

Along the range the sliding speed of steady turning is nearly constant. So at one speed the law of
docs/mechanism.md, section 9, is about f mu (N/N_ref)^nu: a factor f, which holds static coefficient,
Stribeck's fall and lubricated branch, and the exponent nu of the nominal load N. A grid over f and nu is
computed at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from case_studies.paper.cams import Statics, other_pairs, pair
from case_studies.paper.published import DIRECTIONS, FACTORS, LOAD, OTHERS, PAIRS, PUBLISHED, RANGE
from case_studies.paper.varying import FrictionLaw, turning
from dualcam.design.statics import Array

HOPELESS = 9.0  # logarithm of a misfit: where the mechanism locks or jams
COARSE = (np.linspace(*FACTORS, 103), np.linspace(-1.0, 1.0, 9) / 1.5)
SLACK = 1e-9  # of an exponent at the end of its range
Grid = tuple[Array, Array]


@dataclass(frozen=True)
class Fit:
    """The law that comes nearest."""

    factor: float
    exponent: float
    misfit: float  # the worst RMSE is off by this factor, 1 or more


def rmse_of_factors(name: str, friction: float, direction: int, factors: Array) -> Array:
    """RMSE over the published one for factors and nu = -1/3, 0, 1/3, shape (factors, 3)."""
    statics = Statics(pair(name), np.linspace(0.0, RANGE, 57))
    exponents = np.array([-1 / 3, 0.0, 1 / 3])
    return _rmse(statics, friction, direction, (factors, exponents)) / PUBLISHED[name][direction]


def _rmse(statics: Statics, friction: float, direction: int, grid: Grid) -> Array:
    """RMSE against constant friction [N.m], shape (factors, exponents); nan where the mechanism locks."""
    factors, exponents = grid
    law = FrictionLaw(friction * factors[:, None, None], load_exponent=exponents[None, :, None], load=LOAD)
    error = turning(statics, law, direction).torque - statics.torque(direction, friction)
    return np.asarray(np.sqrt(np.mean(error**2, axis=-1)))


def misfits(statics: Statics, name: str, friction: float, grid: Grid) -> Array:
    """Logarithm of the factor by which the worse RMSE of a pair is off, shape (factors, exponents)."""
    worst = np.zeros((len(grid[0]), len(grid[1])))
    for direction in DIRECTIONS:
        with np.errstate(divide="ignore"):
            off = np.abs(np.log(_rmse(statics, friction, direction, grid) / PUBLISHED[name][direction]))
        worst = np.maximum(worst, np.nan_to_num(off, nan=HOPELESS, posinf=HOPELESS))
    return worst


@cache
def best(names: str, friction: float, least: float, greatest: float) -> Fit:
    """The law that comes nearest to the RMSEs of pairs "A", "B" or "AB", nu from `least` to `greatest`: on a
    grid, then twice on a finer grid around the best point."""
    found = _best_of(names, friction, _grid(FACTORS, (least, greatest), (171, 41)))
    for finer in (10.0, 100.0):
        reach = (FACTORS[1] - FACTORS[0]) / finer, (greatest - least) / finer
        factors = found.factor - reach[0], found.factor + reach[0]
        exponents = max(least, found.exponent - reach[1]), min(greatest, found.exponent + reach[1])
        found = _best_of(names, friction, _grid(factors, exponents, (41, 21)))
    return found


def _grid(factors: tuple[float, float], exponents: tuple[float, float], counts: tuple[int, int]) -> Grid:
    """Even values from end to end; one exponent if both its ends are equal."""
    count = counts[1] if exponents[1] > exponents[0] else 1
    return np.linspace(*factors, counts[0]), np.linspace(*exponents, count)


def _best_of(names: str, friction: float, grid: Grid) -> Fit:
    """The best point of a grid."""
    worst = np.max([misfits(_statics(name), name, friction, grid) for name in names], axis=0)
    i, j = np.unravel_index(np.argmin(worst), worst.shape)
    return Fit(float(grid[0][i]), float(grid[1][j]), float(np.exp(worst[i, j])))


@cache
def _statics(name: str) -> Statics:
    """Pair A or B at 29 angles."""
    return Statics(pair(name), np.linspace(0.0, RANGE, 29))


@dataclass(frozen=True)
class Others:
    """The laws that come nearest in other pairs that the published facts allow."""

    alone: dict[str, Array]  # misfit of each pair of a kind alone, shape (OTHERS,)
    together: Array  # misfit of each pair A with each pair B under one law, shape (OTHERS^2,)


@cache
def _of_others(friction: float) -> dict[str, Array]:
    """`misfits` of the other pairs, shape (OTHERS, factors, exponents)."""
    angle = np.linspace(0.0, RANGE, 10)
    return {
        name: np.array(
            [misfits(Statics(cams, angle), name, friction, COARSE) for cams in other_pairs(name, OTHERS)]
        )
        for name in PAIRS
    }


@cache
def others(friction: float, greatest: float) -> Others:
    """With the grease's friction, and exponents from -`greatest` to `greatest`."""
    allowed = np.abs(COARSE[1]) <= greatest + SLACK
    worst = {name: found[:, :, allowed].reshape(OTHERS, -1) for name, found in _of_others(friction).items()}
    together = [np.maximum(one, worst["B"]).min(axis=1) for one in worst["A"]]
    alone = {name: np.exp(found.min(axis=1)) for name, found in worst.items()}
    return Others(alone, np.exp(np.concatenate(together)))
