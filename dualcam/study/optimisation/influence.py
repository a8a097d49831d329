"""Which values of a design do not matter for the goal."""

from __future__ import annotations

from contextlib import closing

import numpy as np

from dualcam.study.optimisation.evaluation import DesignEvaluator
from dualcam.study.optimisation.fields import Design, share_of
from dualcam.study.optimisation.task import Optimisation

PLACES = (0.0, 0.25, 0.5, 0.75, 1.0)  # shares of the bounds
UNCHANGED = 1e-7  # relative: an objective that changes by less is the same


def without_influence(task: Optimisation, design: Design, objectives: list[float]) -> list[str]:
    """Names of what can be anywhere between its bounds without a change of an objective of the best design. A
    value at which all runs fail is not among them."""
    names = list(task.designed)
    best = np.array([share_of(task.designed[name], design[name]) for name in names])
    moved = np.tile(best, (len(names), len(PLACES), 1))
    for k in range(len(names)):
        moved[k, :, k] = PLACES
    with closing(DesignEvaluator(task)) as evaluator:
        found = evaluator.evaluate(moved.reshape(-1, len(names))).objectives
    values = found.reshape(len(names), len(PLACES), -1)
    failed = np.isnan(values).any(axis=2)
    same = np.all(np.abs(values - objectives) <= UNCHANGED * np.abs(objectives), axis=2)
    idle = np.all(same | failed, axis=1) & ~np.all(failed, axis=1)
    return [name for name, is_idle in zip(names, idle, strict=True) if is_idle]
