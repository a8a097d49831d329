"""The state of a search: every design is evaluated once, and the best one is known."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from dualcam.fmi.reals import Array
from dualcam.study.optimisation.evaluation import DesignEvaluator, EvaluatedDesigns
from dualcam.study.optimisation.record import Record

TOLERANCE = 1e-6  # relative: a constraint that is missed by less is kept, as by the last digits of a search


class BudgetSpent(Exception):
    """The search is over: as many designs as allowed are evaluated."""


class Scores(NamedTuple):
    """Of designs: objectives to be minimised, shape (designs, objectives); constraints to be 0 or less, as
    shares of their limits, shape (designs, limits). NaN for failed designs."""

    losses: Array
    excess: Array


class Search:
    """Evaluates designs for a method, each once, until the budget is spent."""

    def __init__(
        self,
        evaluator: DesignEvaluator,
        record: Record,
        on_batch: Callable[[Search], None] = lambda search: None,
    ) -> None:
        self.evaluator, self.task, self._record, self._on_batch = evaluator, evaluator.task, record, on_batch
        self._signs = np.array([sign for _, sign, _ in evaluator.limits])
        self._limits = np.array([limit for _, _, limit in evaluator.limits])
        self._scales = np.where(self._limits != 0.0, np.abs(self._limits), 1.0)
        self._places: dict[bytes, int] = {}
        self.batches: list[EvaluatedDesigns] = []
        self.designs: list[Array] = []  # shares of the bounds of each design
        self.losses: list[Array] = []
        self.excess: list[Array] = []
        self.history: list[tuple[int, float]] = []  # designs so far, best loss that keeps all constraints
        self.best: int | None = None  # place of the best design
        self.failed = 0

    @property
    def count(self) -> int:
        """Designs evaluated."""
        return len(self.losses)

    def scores(self, shares: Array) -> Scores:
        """Of designs, shape (designs, varied). BudgetSpent once all that are allowed are evaluated."""
        shares = np.ascontiguousarray(np.clip(shares, 0.0, 1.0)) + 0.0  # no -0.0
        keys = [row.tobytes() for row in shares]
        fresh = [k for k, key in enumerate(keys) if key not in self._places and key not in keys[:k]]
        left = self.task.budget - self.count
        if fresh and left > 0:
            self._evaluate(shares[fresh[:left]])
        if len(fresh) > left:
            raise BudgetSpent
        places = [self._places[key] for key in keys]
        losses = np.array([self.losses[place] for place in places])
        excess = np.array([self.excess[place] for place in places])
        shape = len(places), len(self._limits)  # also of no designs and no limits
        return Scores(losses.reshape(len(places), len(self.task.signs)), excess.reshape(shape))

    def _evaluate(self, shares: Array) -> None:
        batch = self._record.next_known(shares)
        if batch is None:
            batch = self.evaluator.evaluate(shares)
            self._record.append(batch)
        first = self.count
        self.batches.append(batch)
        self.designs += list(shares)
        self.losses += list(batch.objectives * self.task.signs)
        self.excess += list((batch.constraints * self._signs - self._limits * self._signs) / self._scales)
        self._places |= {row.tobytes(): first + k for k, row in enumerate(shares)}
        self.failed += len(batch.messages)
        for place in range(first, self.count):
            self._compare(place)
        self._on_batch(self)

    def _compare(self, place: int) -> None:
        """Whether this design is the best so far: the least loss, or the least violation if none is whole."""
        if not np.all(np.isfinite(self.losses[place])):
            return
        if self.best is None or self._rank(place) < self._rank(self.best):
            self.best = place
            if self.feasible(place):
                self.history.append((place + 1, float(self.losses[place][0])))

    def _rank(self, place: int) -> tuple[float, float]:
        return self.violation(place), float(self.losses[place][0])

    def violation(self, place: int) -> float:
        """Sum of what a design misses of its constraints, as shares of the limits; 0 within TOLERANCE."""
        excess = self.excess[place]
        return float(np.sum(np.where(excess > TOLERANCE, excess, 0.0)))

    def feasible(self, place: int) -> bool:
        """Whether a design could be evaluated and keeps all constraints."""
        return bool(np.all(np.isfinite(self.losses[place]))) and self.violation(place) == 0.0
