"""The plan of a table in a file."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from functools import partial
from typing import Any

from dualcam.common.mistakes import Findings, StudyError
from dualcam.common.tables import in_unit
from dualcam.fmi.reals import Array
from dualcam.scenario.formula import formula, is_formula
from dualcam.study.file.context import STRING, Context
from dualcam.study.file.values import STAND_IN, ValuesReader
from dualcam.study.plan import tables
from dualcam.study.plan.correlation import Correlation
from dualcam.study.plan.plan import Plan
from dualcam.study.plan.vary import Vary

AS_GIVEN = ("runs", "seed", "on_violation", "second_order", "levels")  # keys that are arguments of Plan


def plan_of(context: Context, content: Mapping[str, Any]) -> Plan:
    """The plan of a table. StudyError with all that is wrong with its values."""
    if "table" in content:
        return _plan_of_file(context, content)
    findings = Findings()
    if "kind" not in content:
        findings.note("plan lacks kind")
    same_as: dict[str, str] = {}
    vary: dict[str, Vary] = {}
    for name, each in content.get("vary", {}).items():
        found = findings.attempt(ValuesReader(context, name, each).read, max(content.get("seed", 0), 0))
        if "same_as" in each:
            same_as[name] = each["same_as"]
        else:
            vary[name] = found or STAND_IN
    correlations = [findings.attempt(_correlation, each) for each in content.get("correlation", ())]
    formulas = {
        key: {name: str(text) for name, text in content.get(key, {}).items()}
        for key in ("derived", "constraints")
    }
    sound = [each for each in correlations if each is not None]
    used = [name for each in sound for name in (each.first, each.second)]
    used += [name for each in formulas.values() for text in each.values() for name in _names_in(text)]
    findings.note(*_with_names_of_fmu(context, vary, {*same_as.values(), *used} - {*formulas["derived"]}))
    given = {key: content[key] for key in AS_GIVEN if key in content}
    kind = content.get("kind", "random")
    plan = findings.attempt(Plan, kind, vary, same_as=same_as, correlations=sound, **formulas, **given)
    return findings.result(plan)


def _names_in(text: str) -> tuple[str, ...]:
    return formula(text).names if is_formula(text) else ()


def _with_names_of_fmu(context: Context, vary: dict[str, Vary], used: set[str]) -> list[str]:
    """A name in `vary` with a slip, which is written in full elsewhere, is told once and gets its name."""
    found = []
    unknown = [name for name in vary if name not in context.units]
    for name in sorted(used - {*vary}):
        if name in context.units and (close := get_close_matches(name, unknown, n=1, cutoff=0.6)):
            found.append(f"plan: {close[0]} is no variable of the FMU: did you mean {name}?")
            vary[name] = vary[close[0]]
    return found


def _plan_of_file(context: Context, content: Mapping[str, Any]) -> Plan:
    if others := sorted(set(content) - {"kind", "table"}):
        raise StudyError(f"plan of a table has {', '.join(others)}: allowed are kind, table")
    if content.get("kind", "table") != "table":
        raise StudyError(f"plan has a table and is of kind {content['kind']}: allowed is one of them")
    written = content["table"]
    if problem := context.missing_file(written):
        raise StudyError(f"plan: table = {written!r}: {problem}")
    path = context.folder / written
    texts = [name for name, unit in context.units.items() if unit == STRING]
    if tables.is_parquet(path):
        columns = tables.read_parquet(path)
    else:
        columns = tables.read_csv(path, texts, partial(_in_unit_of_fmu, context))
    findings = Findings()
    for name in texts:
        findings.note(*context.missing_texts(name, [str(text) for text in columns.get(name, ())]))
    return findings.result(findings.attempt(Plan.from_columns, columns, path.parent))


def _in_unit_of_fmu(context: Context, name: str, unit: str, values: Array) -> Array:
    """The values of a column with a unit, in the unit of the FMU's variable."""
    where = f"plan: column {name}"
    zero, one = (context.number(where, name, f"{count} {unit}") for count in (0, 1))
    return in_unit(values, one - zero) + zero


def _correlation(content: Mapping[str, Any]) -> Correlation:
    """One of the list."""
    of = list(content["of"])
    if len(of) != 2:
        raise StudyError(f"plan: correlation of {', '.join(of)}: allowed are two names")
    kinds = [kind for kind in ("rank", "pearson") if kind in content]
    if len(kinds) != 1:
        raise StudyError(f"plan: correlation of {' and '.join(of)}: allowed is one of rank and pearson")
    return Correlation(of[0], of[1], float(content[kinds[0]]), kinds[0])
