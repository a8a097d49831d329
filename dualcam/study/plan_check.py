"""All that is wrong with the numbers, values and formulas of a plan, at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from dualcam.study.entries import hint, is_whole
from dualcam.study.problem import Findings, Place, StudyError
from dualcam.study.sampling import designs
from dualcam.study.sampling.correlation import Copula, Correlation
from dualcam.study.sampling.formula import CONSTANTS, formula
from dualcam.study.sampling.rules import in_order

if TYPE_CHECKING:
    from dualcam.study.plan import Plan
    from dualcam.study.sampling.vary import Vary

ON_VIOLATION = ("redraw", "mark")
VARIES_NOTHING = "the plan varies nothing: name at least one variable in vary"
ROWS_NAMED = 10  # of a table with numbers that are not finite
RUNS_MAX = 10**9  # the names of the files of results are in order up to there


def check_plan(plan: Plan, findings: Findings) -> None:
    """Notes what is wrong with a plan, each message with the value and what is allowed.

    What depends on a place that is not sound is left out. The places are those of the section [plan]."""
    _check_numbers(plan, findings)
    if plan.kind == "table":
        _check_table(plan, findings)
    else:
        _check_values(plan, findings)
        _check_same(plan, findings)
        _check_correlations(plan, findings)
    _check_names(plan, findings)
    _check_formulas(plan, findings)
    _check_count(plan, findings)


def _check_numbers(plan: Plan, findings: Findings) -> None:
    if findings.is_sound("plan", "kind") and plan.kind not in designs.KINDS:
        findings.note(("plan", "kind"), f"plan: kind = {plan.kind!r}{hint(plan.kind, designs.KINDS)}")
    if not plan.vary and findings.is_sound("plan", "vary"):
        findings.note(("plan", "vary"), VARIES_NOTHING)
    for key, number, least in (
        ("runs", plan.runs, None),
        ("seed", plan.seed, 0),
        ("levels", plan.levels, None),
    ):
        if not findings.is_sound("plan", key):
            continue
        if not is_whole(number):
            findings.note(("plan", key), f"plan: {key} = {number!r}: allowed is a whole number")
        elif least is not None and number < least:
            findings.note(("plan", key), f"plan: {key} = {number}: allowed is {least} or more")
    key = "levels" if plan.kind == "morris" else "runs"
    is_sound = findings.is_sound("plan", "kind") and findings.is_sound("plan", key)
    if is_sound and (problem := designs.problem(plan.kind, plan.runs, plan.levels)):
        findings.note(("plan", key), f"plan: {problem}")
    is_sound = findings.is_sound("plan", "kind") and findings.is_sound("plan", "runs")
    arrangement = plan.kind, plan.runs, len(plan.vary), plan.second_order
    if is_sound and (problem := designs.problem_of_size(*arrangement)):
        findings.note(("plan", "runs"), f"plan: {problem}")
    if findings.is_sound("plan", "on_violation") and plan.on_violation not in ON_VIOLATION:
        text = f"plan: on_violation = {plan.on_violation!r}: allowed are {', '.join(ON_VIOLATION)}"
        findings.note(("plan", "on_violation"), text)


def _check_table(plan: Plan, findings: Findings) -> None:
    if not findings.is_sound("plan", "table") or not plan.vary:
        return
    rows = findings.attempt(("plan", "table"), lambda: plan.table_rows)
    if rows is None:
        return
    if rows.ndim != 2 or rows.shape[1] != len(plan.vary):
        text = f"plan: table of shape {rows.shape}: allowed is (runs, {len(plan.vary)})"
        findings.note(("plan", "table"), text)
        return
    names = list(plan.vary)
    for row, column in np.argwhere(~np.isfinite(rows))[:ROWS_NAMED]:
        findings.note(
            ("plan", "table"),
            f"plan: run {row} of the table (from 0) has {names[column]} = {rows[row, column]}: allowed are "
            "finite numbers",
        )


def _check_values(plan: Plan, findings: Findings) -> None:
    in_grid = plan.kind == "grid" and findings.is_sound("plan", "kind")
    for name, vary in plan.vary.items():
        place = ("plan", "vary", name)
        if not findings.is_sound(*place):
            continue
        problems = vary.problems(in_grid)
        if not problems and plan.kind == "morris" and not all(map(math.isfinite, vary.limits())):
            problems = [
                f"Morris takes both ends of the range, and {vary.distribution} has none: give from and to"
            ]
        findings.note(place, *(f"plan: {name}: {problem}" for problem in problems))


def _check_same(plan: Plan, findings: Findings) -> None:
    """What gets the value of another name, which must be one of `vary`."""
    for name, other in plan.same_as.items():
        place = ("plan", "vary", name)
        if not findings.is_sound(*place):
            continue
        if name in plan.vary:
            text = f"plan: {name} varies, and is the same as {other}: allowed is one of them"
            findings.note(place, text)
        elif problem := problem_of_same(other, plan.vary, plan.same_as, plan.derived):
            findings.note(place, f"plan: {name} is the same as {other}: {problem}")


def problem_of_same(
    other: str,
    vary: Iterable[str],
    same_as: Mapping[str, str] | None = None,
    derived: Mapping[str, str] | None = None,
) -> str | None:
    """Why no name can have the same value as `other` in each run, if that is so."""
    known = list(vary)
    if other in known:
        return None
    if same_as and other in same_as:
        return f"{other} is itself the same as {same_as[other]}: give same_as = {same_as[other]!r}"
    if derived and other in derived:
        return f"{other} is derived: give a line in plan.derived instead, with the formula {other!r}"
    return f"{other} does not vary{hint(other, known)}"


def _check_correlations(plan: Plan, findings: Findings) -> None:
    if not plan.correlations:
        return
    is_known = findings.is_sound("plan", "kind")
    if is_known and plan.kind not in designs.INDEPENDENT:
        kinds = ", ".join(designs.INDEPENDENT)
        text = f"plan: correlation in a plan of kind {plan.kind}: allowed are plans of kind {kinds}"
        findings.note(("plan", "correlation"), text)
        return
    seen: set[frozenset[str]] = set()
    sound = []
    for number, each in enumerate(plan.correlations):
        place = ("plan", "correlation", number)
        if not findings.is_sound(*place):
            continue
        names = (each.first, each.second)
        problems = [f"plan: correlation: {problem}" for problem in each.problems(plan.vary)]
        if not problems and frozenset(names) in seen:
            pair = " and ".join(names)
            problems = [f"plan: correlation of {pair} is given twice: allowed is once"]
        seen.add(frozenset(names))
        findings.note(place, *problems)
        if not problems and all(findings.is_sound("plan", "vary", name) for name in names):
            sound.append((place, each))
    _check_copula(plan, findings, sound)


def _check_copula(plan: Plan, findings: Findings, sound: Sequence[tuple[Place, Correlation]]) -> None:
    """Whether the distributions can have these correlations, each alone, then all together.

    Correlations that contradict each other do so beside any others, too."""
    vary = {name: each for name, each in plan.vary.items() if findings.is_sound("plan", "vary", name)}
    possible = []
    for place, each in sound:
        if problem := _problem_of_copula(vary, [each]):
            findings.note(place, problem)
        else:
            possible.append(each)
    if len(possible) > 1 and (problem := _problem_of_copula(vary, possible)):
        findings.note(("plan", "correlation"), problem)


def _problem_of_copula(vary: Mapping[str, Vary], correlations: Sequence[Correlation]) -> str | None:
    try:
        Copula(vary, correlations)
    except StudyError as error:
        return f"plan: {error}"
    return None


def _check_names(plan: Plan, findings: Findings) -> None:
    for name in plan.names:
        if name in CONSTANTS:
            findings.note(
                ("plan", "derived" if name in plan.derived else "vary", name),
                f"plan: {name} is a constant of formulas: allowed is another name",
            )
    for name in plan.derived:
        if name in plan.vary or name in plan.same_as:
            text = f"plan: {name} varies and is derived: allowed is one of them"
            findings.note(("plan", "derived", name), text)


def _check_formulas(plan: Plan, findings: Findings) -> None:
    texts = {name for name, vary in plan.vary.items() if vary.is_list and vary.texts is not None}
    for word, formulas in (("derived", plan.derived), ("constraints", plan.constraints)):
        for name, text in formulas.items():
            if findings.is_sound("plan", word, name):
                problems = problems_of_formula(text, plan.names, texts)
                findings.note(("plan", word, name), *(f"plan: {word}: {name}: {each}" for each in problems))
    sound = {name: text for name, text in plan.derived.items() if findings.is_sound("plan", "derived", name)}
    try:
        in_order(sound)
    except StudyError as error:
        findings.note(("plan", "derived"), f"plan: {error}")


def _check_count(plan: Plan, findings: Findings) -> None:
    """The number of runs, where all that makes it is sound."""
    is_sound = findings.is_sound("plan", "kind") and findings.is_sound("plan", "runs")
    if not (is_sound and findings.is_sound("plan", "vary") and findings.is_sound("plan", "table")):
        return
    if not 1 <= plan.count <= RUNS_MAX:
        text = f"the plan, of kind {plan.kind}, has {plan.count} runs: allowed are 1 to {RUNS_MAX:,}"
        findings.note(("plan", "runs"), text)


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
