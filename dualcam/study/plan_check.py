"""All that is wrong with the numbers, values and formulas of a plan, at once."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from dualcam.study.entries import hint, is_whole
from dualcam.study.problem import StudyError
from dualcam.study.sampling import designs
from dualcam.study.sampling.formula import CONSTANTS, formula

if TYPE_CHECKING:
    from dualcam.study.plan import Plan

ON_VIOLATION = ("redraw", "mark")
ROWS_NAMED = 10  # of a table with numbers that are not finite


def problems_of(plan: Plan) -> list[str]:
    """What is wrong, one text each, each with the value and what is allowed."""
    found = _of_numbers(plan)
    if plan.vary:
        found += _of_table(plan) if plan.kind == "table" else _of_values(plan)
    found += _of_formulas(plan)
    return [text if text.startswith("the plan") else f"plan: {text}" for text in found]


def _of_numbers(plan: Plan) -> list[str]:
    found = []
    if plan.kind not in designs.KINDS:
        found.append(f"kind = {plan.kind!r}{hint(plan.kind, designs.KINDS)}")
    if not plan.vary:
        found.append("the plan varies nothing: name at least one variable in vary")
    numbers = (("runs", plan.runs), ("seed", plan.seed), ("levels", plan.levels))
    wrong = [f"{name} = {n!r}: allowed is a whole number" for name, n in numbers if not is_whole(n)]
    if wrong:
        return found + wrong
    if plan.seed < 0:
        found.append(f"seed = {plan.seed}: allowed is 0 or more")
    if problem := designs.problem(plan.kind, plan.runs, plan.levels):
        found.append(problem)
    return found


def _of_table(plan: Plan) -> list[str]:
    rows = plan._rows
    if rows.ndim != 2 or rows.shape[1] != len(plan.vary):
        return [f"table of shape {rows.shape}: allowed is (runs, {len(plan.vary)})"]
    names = list(plan.vary)
    return [
        f"run {row} of the table (from 0) has {names[column]} = {rows[row, column]}: allowed are finite "
        "numbers"
        for row, column in np.argwhere(~np.isfinite(rows))[:ROWS_NAMED]
    ]


def _of_values(plan: Plan) -> list[str]:
    problems = {name: vary.problem(plan.kind == "grid") for name, vary in plan.vary.items()}
    found = [f"{name}: {problem}" for name, problem in problems.items() if problem]
    refused = {name for name, problem in problems.items() if problem}
    for name, other in plan.same_as.items():
        if name in plan.vary or other not in plan.vary:
            found.append(f"{name} the same as {other}: allowed is one that varies, for one that does not")
    if plan.kind == "morris":
        found += [
            f"{name}: Morris takes both ends of the range, and {vary.distribution} has none: give from and to"
            for name, vary in plan.vary.items()
            if name not in refused and not all(map(math.isfinite, vary.limits()))
        ]
    return found + (_of_correlations(plan, refused) if plan.correlations else [])


def _of_correlations(plan: Plan, refused: set[str]) -> list[str]:
    if plan.kind in designs.KINDS and plan.kind not in designs.INDEPENDENT:
        kinds = ", ".join(designs.INDEPENDENT)
        return [f"correlation in a plan of kind {plan.kind}: allowed are plans of kind {kinds}"]
    found = [
        f"correlation: {problem}"
        for each in plan.correlations
        if not {each.first, each.second} & refused and (problem := each.problem(plan.vary))
    ]
    if not found and not refused:
        try:
            plan._copula  # noqa: B018  made here for its checks
        except StudyError as error:
            found.append(str(error))
    return found


def _of_formulas(plan: Plan) -> list[str]:
    found = [
        f"{name} is a constant of formulas: allowed is another name"
        for name in plan.names
        if name in CONSTANTS
    ]
    if plan.on_violation not in ON_VIOLATION:
        found.append(f"on_violation = {plan.on_violation!r}: allowed are {', '.join(ON_VIOLATION)}")
    found += [
        f"{name} varies and is derived: allowed is one of them"
        for name in plan.derived
        if name in plan.vary or name in plan.same_as
    ]
    texts = {name for name, vary in plan.vary.items() if vary.is_list and vary.texts is not None}
    for word, formulas in (("derived", plan.derived), ("constraints", plan.constraints)):
        for name, text in formulas.items():
            found += [f"{word}: {name}: {each}" for each in problems_of_formula(text, plan.names, texts)]
    if not found:
        try:
            plan._order  # noqa: B018  made here for its check
        except StudyError as error:
            found.append(str(error))
    return found


def problems_of_formula(text: str, known: Iterable[str], texts: Iterable[str] = ()) -> list[str]:
    """What is wrong with a formula over the names that are known, of which some are texts."""
    known = list(known)
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
