"""NSGA-II of pymoo, whose generations are batches."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from dualcam.common.mistakes import StudyError
from dualcam.fmi.reals import Array
from dualcam.study.optimisation.evolution import first_designs
from dualcam.study.optimisation.optimum import unbeaten
from dualcam.study.optimisation.search import TOLERANCE, Search

FAILED = 1e3  # violation of a failed design, in limits
WORST = 1e30  # objective of a failed design


def run(search: Search) -> None:
    """The whole search.

    Source: K. Deb et al., A fast and elitist multiobjective genetic algorithm: NSGA-II, IEEE Transactions on
    Evolutionary Computation 6 (2002) 182.
    """
    nsga2, problem_of = load()
    task = search.task
    size = task.population_used
    algorithm = nsga2(pop_size=size, sampling=first_designs(search, size))
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


def load() -> tuple[Any, Any]:
    """NSGA2 and Problem of pymoo. StudyError if it is not installed."""
    try:
        nsga2 = importlib.import_module("pymoo.algorithms.moo.nsga2").NSGA2
        return nsga2, importlib.import_module("pymoo.core.problem").Problem
    except ImportError:
        raise StudyError(
            'several objectives need pymoo: pip install "dualcam[optimise]"; without it, make one objective '
            "and limit the others in constraints"
        ) from None


def hypervolume(losses: Array, reference: float) -> float:
    """Volume between a front and a point that has this number as all its losses."""
    if len(losses) == 0:
        return 0.0
    indicator = importlib.import_module("pymoo.indicators.hv").HV
    return float(indicator(ref_point=np.full(losses.shape[1], reference))(losses[unbeaten(losses)]))
