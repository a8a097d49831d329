"""Searches by generations of designs: differential evolution, then SLSQP from its best design; NSGA-II."""

import importlib
from typing import Any

import numpy as np

from dualcam.common.mistakes import optional_module
from dualcam.fmi.reals import Array
from dualcam.study.optimisation import gradient
from dualcam.study.optimisation.optimum import unbeaten
from dualcam.study.optimisation.search import TOLERANCE, Search

FAILED = 1e3  # violation of a failed design, in limits
WORST = 1e30  # objective of a failed design
POLISHED = 0.25  # share of the budget that is left for SLSQP
STOP = 1e-8  # spread of the population's losses, as a share of their mean


def differential_evolution(search: Search) -> None:
    """The whole search for one objective."""
    from scipy import optimize

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

    optimize.differential_evolution(
        losses,
        [(0.0, 1.0)] * len(task.designed),
        init=first,
        maxiter=generations,
        rng=np.random.default_rng(task.seed),
        constraints=optimize.NonlinearConstraint(excess, -np.inf, TOLERANCE),
        polish=False,
        updating="deferred",
        vectorized=True,
        tol=STOP,
    )
    if smooth and search.best is not None:
        gradient.descend(search, search.designs[search.best])


def first_designs(search: Search, population: int) -> Array:
    """The start, and a Latin hypercube."""
    from scipy.stats import qmc

    random = qmc.LatinHypercube(len(search.task.designed), rng=search.task.seed).random(population)
    random[0] = search.evaluator.start()
    return random


def nsga2(search: Search) -> None:
    """The whole search for several objectives.

    Source: K. Deb et al., A fast and elitist multiobjective genetic algorithm: NSGA-II, IEEE Transactions on
    Evolutionary Computation 6 (2002) 182.
    """
    method, problem_of = pymoo_classes()
    task = search.task
    size = task.population_used
    algorithm = method(pop_size=size, sampling=first_designs(search, size))
    problem = problem_of(
        n_var=len(task.designed),
        n_obj=len(task.objectives),
        n_ieq_constr=len(search.evaluator.limits) + 1,
        xl=0.0,
        xu=1.0,
    )
    algorithm.setup(problem, termination=("n_gen", task.budget // size), seed=task.seed, verbose=False)
    while algorithm.has_next():
        asked = algorithm.ask()
        scores = search.scores(asked.get("X"))
        failed = ~np.all(np.isfinite(scores.losses), axis=1)
        excess = np.column_stack(
            [np.where(failed[:, None], FAILED, scores.excess - TOLERANCE), failed * FAILED]
        )
        asked.set("F", np.where(failed[:, None], WORST, scores.losses))
        asked.set("G", excess)
        for one in asked:
            one.evaluated.update({"F", "G"})
        algorithm.tell(infills=asked)


def pymoo_classes() -> tuple[Any, Any]:
    """NSGA2 and Problem of pymoo."""
    advice = (
        'several objectives need pymoo: pip install "dualcam[optimise]"; without it, make one objective and '
        "limit the others in constraints"
    )
    nsga2 = optional_module("pymoo.algorithms.moo.nsga2", advice).NSGA2
    return nsga2, optional_module("pymoo.core.problem", advice).Problem


def hypervolume(losses: Array, reference: float) -> float:
    """Volume between a front and a point that has this number as all its losses."""
    if len(losses) == 0:
        return 0.0
    indicator = importlib.import_module("pymoo.indicators.hv").HV
    return float(indicator(ref_point=np.full(losses.shape[1], reference))(losses[unbeaten(losses)]))
