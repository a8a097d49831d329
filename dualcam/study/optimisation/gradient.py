"""SLSQP with gradients from differences: each gradient is one batch of designs."""

from typing import Any

import numpy as np

from dualcam.fmi.reals import Array
from dualcam.study.optimisation.search import TOLERANCE, Search

ITERATIONS = 200  # of one search; with quadratic convergence ten to fifty are usual
STOP = 1e-10  # relative change of the objective
RETREAT = 10.0  # of a failed design's loss beyond the worst one, in scales of the objective


def run(search: Search) -> None:
    """Searches from the task's start and from designs of a Latin hypercube, the most promising first."""
    from scipy.stats import qmc

    task = search.task
    first = search.evaluator.start()[None, :]
    others = qmc.LatinHypercube(len(task.designed), rng=task.seed).random(max(1, 4 * (task.starts - 1)))
    starts = np.concatenate([first, others]) if task.starts > 1 else first
    scores = search.scores(starts)
    ranks = [
        (np.sum(np.maximum(excess, 0.0)), loss[0]) if np.isfinite(loss[0]) else (np.inf, np.inf)
        for loss, excess in zip(scores.losses, scores.excess, strict=True)
    ]
    rest = sorted(range(1, len(starts)), key=lambda k: ranks[k])[: task.starts - 1]
    for place in [0, *rest]:
        if np.isfinite(ranks[place][1]):
            descend(search, starts[place])


def descend(search: Search, start: Array) -> None:
    """One search with SLSQP."""
    from scipy.optimize import minimize

    problem = _Problem(search, start)
    constraints: Any = ()
    if len(search.evaluator.limits):
        constraints = {
            "type": "ineq",
            "fun": lambda shares: -problem.excess(shares),
            "jac": lambda shares: -problem.slopes(shares)[1],
        }
    minimize(
        problem.loss,
        start,
        jac=lambda shares: problem.slopes(shares)[0],
        bounds=[(0.0, 1.0)] * len(start),
        constraints=constraints,
        method="SLSQP",
        options={"maxiter": ITERATIONS, "ftol": STOP},
    )


class _Problem:
    """The task as SLSQP sees it: all numbers near 1, and finite."""

    def __init__(self, search: Search, start: Array) -> None:
        self._search = search
        loss = float(search.scores(start[None, :]).losses[0, 0])
        self._scale = abs(loss) or 1.0
        self._worst = loss
        self._excess = np.zeros(len(search.evaluator.limits))

    def loss(self, shares: Array) -> float:
        loss = float(self._search.scores(shares[None, :]).losses[0, 0])
        if not np.isfinite(loss):
            return self._worst / self._scale + RETREAT
        self._worst = max(self._worst, loss)
        return loss / self._scale

    def excess(self, shares: Array) -> Array:
        excess = self._search.scores(shares[None, :]).excess[0]
        if not np.all(np.isfinite(excess)):
            return self._excess + 1.0
        self._excess = excess
        return excess + 0.1 * TOLERANCE  # the end shall be on this side of the limit

    def slopes(self, shares: Array) -> tuple[Array, Array]:
        """Derivatives of loss and constraints by the shares, shape (varied,) and (constraints, varied), of
        second order: central, or one-sided near a bound. A derivative is 0 where designs fail."""
        shares, step = np.clip(shares, 0.0, 1.0), self._search.task.difference
        places, weights = [], []
        for k, share in enumerate(shares):
            moves, factors = _stencil(share, step)
            places += [shares + move * np.eye(len(shares))[k] for move in moves]
            weights.append(factors)
        scores = self._search.scores(np.array(places))
        loss = _weighted(scores.losses[:, :1] / self._scale, weights)
        return loss[:, 0], _weighted(scores.excess, weights).T


def _stencil(share: float, step: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Where to evaluate, and with which weights, for the first derivative."""
    if share - step < 0.0:
        return (0.0, step, 2.0 * step), (-1.5 / step, 2.0 / step, -0.5 / step)
    if share + step > 1.0:
        return (0.0, -step, -2.0 * step), (1.5 / step, -2.0 / step, 0.5 / step)
    return (-step, step), (-0.5 / step, 0.5 / step)


def _weighted(values: Array, weights: list[tuple[float, ...]]) -> Array:
    """Sums over consecutive rows, shape (varied, columns)."""
    found, first = [], 0
    for factors in weights:
        part = values[first : first + len(factors)]
        found.append(np.nan_to_num(np.array(factors) @ part, nan=0.0, posinf=0.0, neginf=0.0))
        first += len(factors)
    return np.array(found).reshape(len(weights), -1)
