"""Designs in, objectives and constraints out, with parts as made where there are tolerances."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dualcam.reals import Array
from dualcam.study.optimisation.models import Model, nominal_values, open_model
from dualcam.study.optimisation.task import Optimisation, share_of

RUNS_AT_ONCE = 100_000  # so that memory does not grow with designs times samples


@dataclass
class Batch:
    """Some designs and what they gave. NaN throughout for a design that failed, whose message says why.

    Attributes
    ----------
    shares
        Designs, as shares of the bounds, shape (designs, varied).
    results
        Results of the parts exactly as designed, shape (designs, results).
    objectives, constraints
        Values, of parts as made the percentile, shape (designs, objectives) and (designs, constraints). A
        constraint with two limits has two columns.
    messages
        By the place of the design.
    """

    shares: Array
    results: Array
    objectives: Array
    constraints: Array
    messages: dict[int, str]


class Evaluator:
    """Evaluates designs of a task. Values of a design do not depend on what is evaluated with it."""

    def __init__(self, task: Optimisation, workers: int = 0) -> None:
        self.task = task
        nominal = nominal_values(task)
        self._extra = [name for name in task.tolerances if name not in task.vary]
        self.names = [*task.vary, *task.same_as, *self._extra]
        self._fixed = [nominal.get(name, math.nan) for name in self._extra]
        self._deviations = _deviations(task)
        self._model: Model = open_model(task, self.names, workers)
        self.limits = [
            (text, sign, limit)
            for text, (least, most) in task.constraints.items()
            for sign, limit in ((-1.0, least), (1.0, most))
            if limit is not None
        ]

    def close(self) -> None:
        self._model.close()

    def values(self, shares: Array) -> Array:
        """Values of designs, columns in the order of `vary`."""
        columns = [vary.at(share) for vary, share in zip(self.task.vary.values(), shares.T, strict=True)]
        return np.column_stack(columns)

    def start(self) -> Array:
        """Shares of the design with which the search begins."""
        own = nominal_values(self.task)
        found = np.full(len(self.task.vary), 0.5)
        for place, (name, vary) in enumerate(self.task.vary.items()):
            low, high = vary.limits()
            value = self.task.start.get(name, own.get(name, math.nan))
            if len(vary.values) > 0 and value not in list(vary.values):
                continue
            if low <= value <= high:
                found[place] = share_of(vary, value)
        return found

    def evaluate(self, shares: Array) -> Batch:
        """Objectives and constraints of designs, shape (designs, varied)."""
        size = max(1, RUNS_AT_ONCE // (1 + len(self._deviations)))
        parts = [self._evaluate(shares[k : k + size]) for k in range(0, len(shares), size)]
        messages = {
            k * size + place: text for k, part in enumerate(parts) for place, text in part.messages.items()
        }
        results, objectives, constraints = (
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("results", "objectives", "constraints")
        )
        return Batch(shares, results, objectives, constraints, messages)

    def _evaluate(self, shares: Array) -> Batch:
        count, copies = len(shares), 1 + len(self._deviations)
        designed = self._all_columns(self.values(shares))
        block = self._model.run(self._made(designed).reshape(count * copies, -1))
        results = block.values.reshape(count, copies, -1)
        known = self._known(self._made(designed), results)
        formulas = self.task.formulas
        with_sign = [(text, 1.0 if way == "minimise" else -1.0) for text, way in self.task.objectives.items()]
        objectives = np.column_stack(
            [self._value(formulas[text].value(known), sign) for text, sign in with_sign]
        )
        constraints = np.empty((count, len(self.limits)))
        for place, (text, sign, _) in enumerate(self.limits):
            constraints[:, place] = self._value(formulas[text].value(known), sign)
        messages = self._messages(block.messages, copies, objectives, constraints)
        for place in messages:
            objectives[place] = constraints[place] = math.nan
        return Batch(shares, results[:, 0], objectives, constraints, messages)

    def _all_columns(self, values: Array) -> Array:
        place = {name: k for k, name in enumerate(self.task.vary)}
        same = [values[:, place[other]] for other in self.task.same_as.values()]
        extra = [np.full(len(values), value) for value in self._fixed]
        return np.column_stack([values, *same, *extra]) if same or extra else values

    def _made(self, designed: Array) -> Array:
        """The parts as designed, then as made, shape (designs, 1 + samples, names)."""
        made = np.repeat(designed[:, None, :], 1 + len(self._deviations), axis=1)
        if len(self._deviations):
            made[:, 1:] += self._deviations
        return made

    def _known(self, made: Array, results: Array) -> Mapping[str, Array]:
        values = {name: made[:, :, k] for k, name in enumerate(self.names)}
        return values | {name: results[:, :, k] for k, name in enumerate(self.task.read)}

    def _value(self, values: Array, sign: float) -> Array:
        """Of shape (designs, 1 + samples) the value of each design; `sign` 1: less is better."""
        if values.shape[1] == 1:
            return values[:, 0]
        return sign * percentile(sign * values[:, 1:], self.task.percentile)

    def _messages(
        self, of_runs: Mapping[int, str], copies: int, objectives: Array, constraints: Array
    ) -> dict[int, str]:
        """Why designs failed, by their place."""
        unfit = ~np.all(np.isfinite(np.column_stack([objectives, constraints])), axis=1)
        first: dict[int, str] = {}
        for run, text in of_runs.items():
            first.setdefault(run // copies, text)
        found = {}
        for place in map(int, np.flatnonzero(unfit)):
            found[place] = first.get(place, "an objective or a constraint has no finite value")
        return found


def percentile(values: Array, level: float) -> Array:
    """The percentile along the last axis, as NumPy's, where NaN counts as infinite: worse than all others."""
    ordered = np.sort(np.where(np.isnan(values), np.inf, values), axis=-1)
    place = level / 100.0 * (values.shape[-1] - 1)
    low, high = ordered[..., math.floor(place)], ordered[..., math.ceil(place)]
    with np.errstate(invalid="ignore"):
        between = low + (place - math.floor(place)) * (high - low)
    return np.where(low == high, low, between)


def _deviations(task: Optimisation) -> Array:
    """Common random numbers: the same deviations for every design, shape (samples, names)."""
    if not task.tolerances:
        return np.empty((0, 0))
    from scipy.stats import qmc

    shares = qmc.LatinHypercube(len(task.tolerances), rng=task.seed).random(task.samples)
    of = {name: deviation.at(shares[:, k]) for k, (name, deviation) in enumerate(task.tolerances.items())}
    extra = [name for name in task.tolerances if name not in task.vary]
    sources = [*task.vary, *task.same_as.values(), *extra]
    return np.column_stack([of.get(name, np.zeros(task.samples)) for name in sources])
