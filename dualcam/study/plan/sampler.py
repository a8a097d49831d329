"""The rows of a plan: points of its arrangement, turned into values, and drawn again for the constraints."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dualcam.common.mistakes import StudyError
from dualcam.fmi.reals import Array
from dualcam.study.plan import arrangements
from dualcam.study.plan.correlation import OPEN, Copula
from dualcam.study.plan.fields import PlanFields
from dualcam.study.plan.rows import in_order, violating

TRIES = 1000  # draws of a run that violates a constraint
AT_ONCE = 20  # of them
SENT = 1_000_000  # bytes of random numbers that travel with a study to each worker


class Sampler:
    """Makes the rows of a plan, for any of its runs."""

    def __init__(self, plan: PlanFields) -> None:
        self._plan = plan
        self._redraws = plan.on_violation == "redraw" and plan.kind in arrangements.INDEPENDENT
        self._order = in_order(plan.derived)

    def rows(self, numbers: NDArray[np.int_]) -> Array:
        """The values of the runs of these numbers, columns in the order of the plan's names."""
        rows = self.completed(self._drawn(numbers))
        if self._plan.constraints and self._redraws:
            self._redraw(numbers, rows)
        return rows

    def completed(self, varied: Array) -> Array:
        """Rows of `vary`, shape (n, len(vary)), with the columns of `same_as` and `derived`."""
        plan = self._plan
        if not plan.same_as and not plan.derived:
            return varied
        columns = dict(zip(plan.vary, varied.T, strict=True))
        columns |= {name: columns[other] for name, other in plan.same_as.items()}
        for name, each in self._order:
            columns[name] = each.numbers(columns, len(varied))
        return np.column_stack([columns[name] for name in plan.names])

    def violating(self) -> tuple[int, int, str]:
        """How many runs violate a constraint, of how many looked at, up to 100,000; what becomes of them."""
        looked = min(self._plan.count, 100_000)
        bad = 0
        for start in range(0, looked, 10_000):
            numbers = np.arange(start, min(start + 10_000, looked))
            bad += int(np.sum(self._violated(self.completed(self._drawn(numbers)))))
        return bad, looked, "drawn again" if self._redraws else "not made"

    def _violated(self, rows: Array) -> NDArray[np.bool_]:
        """Which rows violate a constraint."""
        columns = dict(zip(self._plan.names, rows.T, strict=True))
        return violating(self._plan.constraints, columns, len(rows))

    def _drawn(self, numbers: NDArray[np.int_]) -> Array:
        """The columns of `vary`, before constraints, of the runs of these numbers."""
        plan = self._plan
        if plan.kind == "grid":
            points = [vary.points() for vary in plan.vary.values()]
            places = np.unravel_index(numbers, [len(each) for each in points])
            return np.column_stack([each[place] for each, place in zip(points, places, strict=True)])
        if plan.kind == "table":
            return plan.table_rows[numbers]
        return self._at(self._mixed(numbers) if plan.kind == "indices" else self._shares[numbers])

    def take_few_numbers(self, other: Sampler) -> None:
        """The random numbers that the sampler of an equal plan has made, where they are few."""
        shares = vars(other).get("_shares")
        if shares is not None and shares.nbytes <= SENT:
            self._shares = shares

    def _redraw(self, numbers: NDArray[np.int_], rows: Array) -> None:
        """Puts values that keep the constraints in place of others; random numbers by the run's number."""
        plan = self._plan
        left = np.flatnonzero(self._violated(rows))
        random = {place: np.random.default_rng([plan.seed, int(numbers[place])]) for place in left.tolist()}
        for _ in range(0, TRIES, AT_ONCE):
            if len(left) == 0:
                return
            shares = [random[place].random((AT_ONCE, len(plan.vary))) for place in left.tolist()]
            again = self.completed(self._at(np.concatenate(shares)))
            good = ~self._violated(again).reshape(len(left), AT_ONCE)
            found = np.flatnonzero(good.any(axis=1))
            rows[left[found]] = again[found * AT_ONCE + good[found].argmax(axis=1)]
            left = np.delete(left, found)

    def _at(self, shares: Array) -> Array:
        """Values at points of the unit cube."""
        plan = self._plan
        if plan.correlations:
            shares = self._copula.shares(np.clip(shares, OPEN, 1.0 - OPEN))
        elif plan.kind != "morris" and any(vary.distribution for vary in plan.vary.values()):
            shares = np.clip(shares, OPEN, 1.0 - OPEN)
        return np.column_stack([vary.at(s) for vary, s in zip(plan.vary.values(), shares.T, strict=True)])

    @cached_property
    def _copula(self) -> Copula:
        return Copula(self._plan.vary, self._plan.correlations)

    @cached_property
    def _shares(self) -> Array:
        plan = self._plan
        width = len(plan.vary)
        try:
            return arrangements.shares(plan.kind, plan.runs, width, plan.seed, plan.second_order, plan.levels)
        except MemoryError:
            why = "their table does not fit into memory: take fewer, or a grid"
            raise StudyError(f"plan: runs = {plan.runs}: {why}") from None

    def _mixed(self, numbers: NDArray[np.int_]) -> Array:
        """Points of Saltelli's arrangement: A, B, then A with one column of B."""
        width = len(self._plan.vary)
        block, row = np.divmod(numbers, self._plan.runs)
        first, second = self._shares[row, :width], self._shares[row, width:]
        from_second = (block[:, None] == 1) | (block[:, None] - 2 == np.arange(width))
        return np.where(from_second, second, first)
