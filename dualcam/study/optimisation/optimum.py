"""What a search found."""

from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from dualcam.fmi.reals import Array
from dualcam.study.optimisation.designs import Design, share_of
from dualcam.study.optimisation.evaluation import DesignEvaluator
from dualcam.study.optimisation.task import Optimisation

ACTIVE = 1e-3  # a bound or a limit that is nearer than this share of the range or of the limit is active
PLACES = (0.0, 0.25, 0.5, 0.75, 1.0)  # shares of the bounds
UNCHANGED = 1e-7  # relative: an objective that changes by less is the same


@dataclass(frozen=True)
class Optimum:
    """The best design, or the best ones of several objectives.

    Attributes
    ----------
    task
        What was asked.
    design
        Values of the best design by name. With several objectives: of the front the design that is nearest to
        the best of each objective, as a share of the front's extent.
    results
        Its results, of the parts exactly as designed.
    objectives, constraints
        Its values by the text of the formula, with tolerances the percentile. A constraint with two limits
        has the value that is nearer to its limit.
    feasible
        Whether it keeps all constraints. If it does not, no design was found that does: this one is nearest.
    active
        Bounds and constraints that hold the best design back, in words.
    violated
        Constraints that the best design misses, in words with the distance.
    front
        Values, results and objectives of all designs that no other one beats in each objective: arrays by
        name, in order of the first objective. With one objective: the best design alone.
    designs
        All designs in the order of their evaluation: values, results, objectives, `feasible` (1 or 0) and
        `message` (why it failed, or empty), arrays by name.
    history
        Convergence, shape (n, 2): designs evaluated so far, and the best objective until then; of several
        objectives the hypervolume of the front until then, as a share of that at the end.
    evaluated, infeasible, failed
        Number of designs, of those that miss a constraint or failed, and of those that failed.
    messages
        Number of failed designs by the reason.
    folder
        Where the results are; None: nowhere.
    """

    task: Optimisation
    design: Design
    results: dict[str, float]
    objectives: dict[str, float]
    constraints: dict[str, float]
    feasible: bool
    active: list[str]
    violated: list[str]
    front: dict[str, Any]
    designs: dict[str, Any]
    history: Array
    evaluated: int
    infeasible: int
    failed: int
    messages: dict[str, int]
    folder: Path | None = None

    @cached_property
    def without_influence(self) -> list[str]:
        """Names of the designed values that change no objective, wherever they lie between their bounds while
        the others are those of the best design. Found by five further runs for each value."""
        return _without_influence(self.task, self.design, list(self.objectives.values()))

    @property
    def holding(self) -> list[str]:
        """`active` without the bounds of values that have no influence: those hold nothing back."""
        idle = tuple(f"{name} is at its " for name in self.without_influence)
        return [text for text in self.active if not text.startswith(idle)]

    def idle_words(self) -> list[str]:
        """One sentence for each name in `without_influence`."""
        limits = "; any value that keeps the constraints is as good" if self.task.constraints else ""
        return [f"{name} has no influence on the goal{limits}" for name in self.without_influence]


def unbeaten(losses: Array) -> Array:
    """Places of the designs that no other one beats, in order of the first loss; of equal ones the first."""
    order = np.lexsort(losses.T[::-1])  # a design is beaten by earlier ones only
    kept = np.empty_like(losses)
    places: list[int] = []
    for place in order:
        if not np.any(np.all(kept[: len(places)] <= losses[place], axis=1)):
            kept[len(places)] = losses[place]
            places.append(int(place))
    return np.array(places, dtype=np.intp)


def _without_influence(task: Optimisation, design: Design, objectives: list[float]) -> list[str]:
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
