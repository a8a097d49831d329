"""Designs in, objectives and constraints out, with parts as made where there are tolerances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from dualcam.fmi.reals import Array
from dualcam.study.optimisation.designs import Design, is_within, share_of
from dualcam.study.optimisation.models import open_model, own_values, plan_of
from dualcam.study.optimisation.task import Optimisation
from dualcam.study.plan.plan import Plan
from dualcam.study.plan.rows import values_of
from dualcam.study.run.runner import joined_messages

if TYPE_CHECKING:
    from distributed import Client

ARRAYS = ("shares", "results", "objectives", "constraints")
RUNS_AT_ONCE = 100_000  # so that memory does not grow with designs times samples


@dataclass
class EvaluatedDesigns:
    """Some designs and what they gave: a row for each. A design that failed has NaN throughout."""

    shares: Array  # of the bounds
    results: Array  # of the parts exactly as designed
    objectives: Array  # of parts as made the percentile
    constraints: Array  # likewise; two columns for two limits
    messages: dict[int, str]  # why designs failed, by their place

    @classmethod
    def joined(cls, parts: Sequence[EvaluatedDesigns]) -> EvaluatedDesigns:
        messages = joined_messages([part.shares for part in parts], [part.messages for part in parts])
        arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAYS}
        return cls(**arrays, messages=messages)


class DesignEvaluator:
    """Evaluates designs of a task."""

    def __init__(self, task: Optimisation, workers: int = 0, scheduler: str | Client | None = None) -> None:
        self.task = task
        self.plan = plan_of(task)
        self._deviations, self._chance = _parts(task, self.plan)
        self._model = open_model(task, self.plan, workers, scheduler)
        self.limits = [
            (text, sign, limit)
            for text, (least, most) in task.constraints.items()
            for sign, limit in ((-1.0, least), (1.0, most))
            if limit is not None
        ]

    def close(self) -> None:
        self._model.close()

    def start(self) -> Array:
        """Shares of the design with which the search begins."""
        values: dict[str, float | str] = {**own_values(self.task), **self.task.start}
        found = np.full(len(self.task.designed), 0.5)
        for place, (name, vary) in enumerate(self.task.designed.items()):
            value = values.get(name, math.nan)
            if is_within(vary, value):
                found[place] = share_of(vary, value)
        return found

    def rows(self, shares: Array) -> Array:
        """Values of the parts exactly as designed, columns in the order of the plan's names."""
        return self.plan.sampler.completed(self._designed(shares))

    def design(self, shares: Array) -> Design:
        """Values of one design by name, without those that only happen."""
        values = values_of(self.plan.names, self.rows(shares[None, :])[0], self.plan.texts)
        return {name: values[name] for name in self.chosen}

    @property
    def chosen(self) -> list[str]:
        """Names of what a design says, and of what follows from that."""
        happens = {name for name in self.plan.vary if name not in self.task.designed}
        happens |= {name for name, other in self.task.same_as.items() if other in happens}
        return [name for name in self.plan.names if name not in happens]

    def _designed(self, shares: Array) -> Array:
        """Columns in the order of the plan's `vary`: what happens has its median."""
        columns = [vary.at(share) for vary, share in zip(self.task.designed.values(), shares.T, strict=True)]
        middle = np.full(len(shares), 0.5)
        others = [vary.at(middle) for name, vary in self.plan.vary.items() if name not in self.task.designed]
        return np.column_stack([*columns, *others])

    def made(self, shares: Array) -> Array:
        """The parts as designed, then as made, shape (designs, 1 + samples, names)."""
        designed = self._designed(shares)
        parts = np.repeat(designed[:, None, :], 1 + len(self._deviations), axis=1)
        if len(self._deviations):
            parts[:, 1:] = np.where(self._chance, 0.0, parts[:, 1:]) + self._deviations
        count, copies, width = parts.shape
        return self.plan.sampler.completed(parts.reshape(count * copies, width)).reshape(count, copies, -1)

    def evaluate(self, shares: Array) -> EvaluatedDesigns:
        """Objectives and constraints of designs, shape (designs, designed values)."""
        size = max(1, RUNS_AT_ONCE // (1 + len(self._deviations)))
        parts = [self._evaluate(shares[k : k + size]) for k in range(0, len(shares), size)]
        return EvaluatedDesigns.joined(parts)

    def _evaluate(self, shares: Array) -> EvaluatedDesigns:
        made = self.made(shares)
        count, copies, width = made.shape
        block = self._model(made.reshape(count * copies, width))
        results = block.values.reshape(count, copies, -1)
        known = {name: made[:, :, k] for k, name in enumerate(self.plan.names)}
        known |= {name: results[:, :, k] for k, name in enumerate(self.task.columns)}
        signs = zip(self.task.objectives, self.task.signs, strict=True)
        objectives = np.column_stack([self._value(text, known, sign) for text, sign in signs])
        constraints = np.empty((count, len(self.limits)))
        for place, (text, sign, _) in enumerate(self.limits):
            constraints[:, place] = self._value(text, known, sign)
        messages = _messages(block.messages, copies, objectives, constraints)
        for place in messages:
            objectives[place] = constraints[place] = math.nan
        return EvaluatedDesigns(shares, results[:, 0], objectives, constraints, messages)

    def _value(self, text: str, known: Mapping[str, Array], sign: float) -> Array:
        """The formula's value of each design; `sign` 1: less is better."""
        shape = next(iter(known.values())).shape
        values = np.broadcast_to(np.asarray(self.task.formulas[text](known), float), shape)
        if shape[1] == 1:
            return values[:, 0]
        return sign * percentile(sign * values[:, 1:], self.task.percentile)


def _messages(
    of_runs: Mapping[int, str], copies: int, objectives: Array, constraints: Array
) -> dict[int, str]:
    """Why designs failed, by their place."""
    unfit = ~np.all(np.isfinite(np.column_stack([objectives, constraints])), axis=1)
    first: dict[int, str] = {}
    for run, text in of_runs.items():
        first.setdefault(run // copies, text)
    return {
        place: first.get(place, "an objective or a constraint has no finite value")
        for place in map(int, np.flatnonzero(unfit))
    }


def percentile(values: Array, level: float) -> Array:
    """The percentile along the last axis, as NumPy's, where NaN counts as infinite: worse than all others."""
    ordered = np.sort(np.where(np.isnan(values), np.inf, values), axis=-1)
    place = level / 100.0 * (values.shape[-1] - 1)
    low, high = ordered[..., math.floor(place)], ordered[..., math.ceil(place)]
    with np.errstate(invalid="ignore"):
        between = low + (place - math.floor(place)) * (high - low)
    return np.where(low == high, low, between)


def _parts(task: Optimisation, plan: Plan) -> tuple[Array, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]:
    """What is added to each design, shape (samples, columns of the plan's `vary`); which columns are that
    alone."""
    chance = np.array([name in task.chance for name in plan.vary])
    if not task.is_robust:
        return np.empty((0, len(plan.vary))), chance
    spread = {name: each.distribution() for name, each in task.tolerances.items()}
    drawn = Plan(
        "latin", {**task.chance, **spread}, runs=task.samples, seed=task.seed, correlations=task.correlations
    )
    columns = dict(zip(drawn.names, drawn.rows(0, task.samples).T, strict=True))
    nothing = np.zeros(task.samples)
    return np.column_stack([columns.get(name, nothing) for name in plan.vary]), chance
