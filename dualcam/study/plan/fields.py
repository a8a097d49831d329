"""What a plan says: its fields, what follows from them alone, and all that is wrong with them at once."""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import TRUTH, Array, real_array
from dualcam.common.entries import hint, is_whole
from dualcam.common.mistakes import StudyError
from dualcam.scenario.formula import CONSTANTS, formula, is_formula
from dualcam.study.plan import arrangements
from dualcam.study.plan.correlation import Copula, Correlation
from dualcam.study.plan.rows import in_order
from dualcam.study.plan.texts import Texts
from dualcam.study.plan.vary import Vary

ON_VIOLATION = ("redraw", "mark")
ROWS_NAMED = 10  # of a table with numbers that are not finite
RUNS_MAX = 10**9  # the names of the files of results are in order up to there


@dataclass(frozen=True)
class PlanFields:
    """The fields of a `Plan`, which may be wrong."""

    kind: str
    vary: Mapping[str, Vary] = field(default_factory=dict)
    runs: int = 0
    seed: int = 0
    table: ArrayLike | None = None
    same_as: Mapping[str, str] = field(default_factory=dict)
    derived: Mapping[str, str] = field(default_factory=dict)
    constraints: Mapping[str, str] = field(default_factory=dict)
    on_violation: str = "redraw"
    correlations: Sequence[Correlation] = ()
    second_order: bool = True
    levels: int = 4

    @property
    def names(self) -> list[str]:
        """The names of the columns of `rows`: what varies, then `same_as`, then `derived`."""
        return [*self.vary, *self.same_as, *self.derived]

    @cached_property
    def texts(self) -> dict[str, Texts]:
        """The texts of each String, by name: `rows` has their places."""
        own = {name: vary.texts for name, vary in self.vary.items() if vary.texts is not None}
        return own | {name: own[other] for name, other in self.same_as.items() if other in own}

    @cached_property
    def table_rows(self) -> Array:
        """The table as an array, shape (runs, variables)."""
        return real_array(self.table, "plan: table", StudyError, kinds=TRUTH)  # type: ignore[arg-type]

    @cached_property
    def count(self) -> int:
        """The number of runs."""
        if self.kind == "grid":
            return math.prod(vary.size() for vary in self.vary.values())
        if self.kind == "table":
            return len(self.table_rows)
        return arrangements.count(self.kind, self.runs, len(self.vary), self.second_order)


# ---- checks ----


def problems_of_plan(plan: PlanFields) -> list[str]:
    """What is wrong with a plan, each text with the value and what is allowed."""
    found = [*_of_numbers(plan)]
    if plan.kind == "table":
        found += _of_table(plan)
    else:
        found += [*_of_values(plan), *_of_same(plan), *_of_correlations(plan)]
    found += [*_of_names(plan), *_of_formulas(plan)]
    if not found and not 1 <= plan.count <= RUNS_MAX:
        return [f"the plan, of kind {plan.kind}, has {plan.count} runs: allowed are 1 to {RUNS_MAX:,}"]
    return [text if text.startswith("the plan") else f"plan: {text}" for text in found]


def _of_numbers(plan: PlanFields) -> Iterator[str]:
    if not plan.vary:
        yield "the plan varies nothing: name at least one variable in vary"
    if plan.on_violation not in ON_VIOLATION:
        yield f"on_violation = {plan.on_violation!r}: allowed are {', '.join(ON_VIOLATION)}"
    given = {"runs": plan.runs, "seed": plan.seed, "levels": plan.levels}
    if strange := [key for key, number in given.items() if not is_whole(number)]:
        yield from (f"{key} = {given[key]!r}: allowed is a whole number" for key in strange)
    elif plan.seed < 0:
        yield f"seed = {plan.seed}: allowed is 0 or more"
    if plan.kind not in arrangements.KINDS:
        yield f"kind = {plan.kind!r}{hint(plan.kind, arrangements.KINDS)}"
    elif not strange:
        yield from arrangements.problems(plan.kind, plan.runs, len(plan.vary), plan.second_order, plan.levels)


def _of_table(plan: PlanFields) -> Iterator[str]:
    rows = plan.table_rows
    if rows.ndim != 2 or rows.shape[1] != len(plan.vary):
        yield f"table of shape {rows.shape}: allowed is (runs, {len(plan.vary)})"
        return
    names = list(plan.vary)
    for row, column in np.argwhere(~np.isfinite(rows))[:ROWS_NAMED]:
        value = rows[row, column]
        yield f"run {row} of the table (from 0) has {names[column]} = {value}: allowed are finite numbers"


def _of_values(plan: PlanFields) -> Iterator[str]:
    for name, vary in plan.vary.items():
        problems = vary.problems(in_grid=plan.kind == "grid")
        yield from (f"{name}: {problem}" for problem in problems)
        if not problems and plan.kind == "morris" and not all(map(math.isfinite, vary.limits())):
            why = f"Morris takes both ends of the range, and {vary.distribution} has none"
            yield f"{name}: {why}: give from and to"


def _of_same(plan: PlanFields) -> Iterator[str]:
    """What gets the value of another name, which must be one of `vary`."""
    for name, other in plan.same_as.items():
        if name in plan.vary:
            yield f"{name} varies, and is the same as {other}: allowed is one of them"
        elif problem := problem_of_same(other, plan.vary, plan.same_as, plan.derived):
            yield f"{name} is the same as {other}: {problem}"


def problem_of_same(
    other: str, vary: Collection[str], same_as: Mapping[str, str], derived: Mapping[str, str]
) -> str | None:
    """Why no name can have the same value as `other` in each run, if that is so."""
    if other in vary:
        return None
    if other in same_as:
        return f"{other} is itself the same as {same_as[other]}: give same_as = {same_as[other]!r}"
    if other in derived:
        return f"{other} is derived: give a line in plan.derived instead, with the formula {other!r}"
    return f"{other} does not vary{hint(other, vary)}"


def _of_correlations(plan: PlanFields) -> list[str]:
    if plan.correlations and plan.kind in arrangements.KINDS and plan.kind not in arrangements.INDEPENDENT:
        kinds = ", ".join(arrangements.INDEPENDENT)
        return [f"correlation in a plan of kind {plan.kind}: allowed are plans of kind {kinds}"]
    found: list[str] = []
    possible: dict[frozenset[str], Correlation] = {}
    for each in plan.correlations:
        problems = [f"correlation: {problem}" for problem in each.problems(plan.vary)]
        pair = frozenset((each.first, each.second))
        if pair in possible and not problems:
            problems = [f"correlation of {each.first} and {each.second} is given twice: allowed is once"]
        if not problems and not any(plan.vary[name].problems(in_grid=False) for name in pair):
            problems = _of_copula(plan.vary, [each])
            possible |= {} if problems else {pair: each}
        found += problems
    # Correlations that contradict each other do so beside any others, too.
    return found + (_of_copula(plan.vary, list(possible.values())) if len(possible) > 1 else [])


def _of_copula(vary: Mapping[str, Vary], correlations: Sequence[Correlation]) -> list[str]:
    """Why the distributions cannot have these correlations, if they cannot."""
    try:
        Copula(vary, correlations)
    except StudyError as error:
        return [str(error)]
    return []


def _of_names(plan: PlanFields) -> Iterator[str]:
    for name in plan.names:
        if name in CONSTANTS:
            yield f"{name} is a constant of formulas: allowed is another name"
    for name in plan.derived:
        if name in plan.vary or name in plan.same_as:
            yield f"{name} varies and is derived: allowed is one of them"


def _of_formulas(plan: PlanFields) -> list[str]:
    texts = [name for name, vary in plan.vary.items() if vary.texts is not None]
    found: list[str] = []
    for word, formulas in (("derived", plan.derived), ("constraints", plan.constraints)):
        for name, text in formulas.items():
            found += [f"{word}: {name}: {each}" for each in problems_of_formula(text, plan.names, texts)]
    if all(map(is_formula, plan.derived.values())):
        try:
            in_order(plan.derived)
        except StudyError as error:
            found.append(str(error))
    return found


def problems_of_formula(text: str, known: Collection[str], texts: Iterable[str] = ()) -> list[str]:
    """What is wrong with a formula over the names that are known, of which some are texts."""
    try:
        used = formula(text).names
    except StudyError as error:
        return [str(error)]
    found = [
        f"{text!r} uses {name}, which does not vary{hint(name, known)}" for name in used if name not in known
    ]
    return found + [
        f"{text!r} uses {name}, which is a text: allowed are numbers" for name in used if name in texts
    ]
