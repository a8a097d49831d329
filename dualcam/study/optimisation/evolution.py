"""Differential evolution, whose generations are batches, and SLSQP from its best design."""

from __future__ import annotations

import numpy as np

from dualcam.fmi.reals import Array
from dualcam.study.optimisation import gradient
from dualcam.study.optimisation.search import TOLERANCE, Search

FAILED = 1e3  # violation of a failed design, in limits
POLISHED = 0.25  # share of the budget that is left for SLSQP
STOP = 1e-8  # spread of the population's losses, as a share of their mean


def run(search: Search) -> None:
    """The whole search."""
    from scipy.optimize import NonlinearConstraint, differential_evolution

    task = search.task
    smooth = not any(vary.is_list for vary in task.designed.values())
    population = task.population_used
    share = 1.0 - POLISHED if smooth else 1.0
    generations = max(0, int(share * task.budget) // population - 1)
    first = first_designs(search, population)

    def losses(shares: Array) -> Array:
        values = search.scores(np.atleast_2d(shares.T)).losses[:, 0]
        found = np.where(np.isfinite(values), values, np.inf)
        return found if shares.ndim == 2 else found[0]

    def excess(shares: Array) -> Array:
        scores = search.scores(np.atleast_2d(shares.T))
        failed = ~np.isfinite(scores.losses[:, :1])
        violations = np.where(failed, FAILED, scores.excess)
        found = np.column_stack([violations, np.where(failed, FAILED, 0.0)])
        return found.T if shares.ndim == 2 else found[0]

    differential_evolution(
        losses,
        [(0.0, 1.0)] * len(task.designed),
        init=first,
        maxiter=generations,
        rng=np.random.default_rng(task.seed),
        constraints=NonlinearConstraint(excess, -np.inf, TOLERANCE),
        polish=False,
        updating="deferred",
        vectorized=True,
        tol=STOP,
    )
    if smooth and search.best is not None:
        gradient.descend(search, search.shares(search.best))


def first_designs(search: Search, population: int) -> Array:
    """The start, and a Latin hypercube."""
    from scipy.stats import qmc

    random = qmc.LatinHypercube(len(search.task.designed), rng=search.task.seed).random(population)
    random[0] = search.evaluator.start()
    return random
