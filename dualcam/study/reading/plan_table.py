"""The plan of a table in a file; the plan may still be wrong."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from dualcam.common.tables import in_unit
from dualcam.errors import DualcamError
from dualcam.fmi.reals import Array
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError, unchecked
from dualcam.study.reading import quantities
from dualcam.study.reading.context import Context
from dualcam.study.reading.files import missing_file
from dualcam.study.reading.values import ValuesReader, note_missing_files
from dualcam.study.sampling import tables
from dualcam.study.sampling.correlation import Correlation

REFUSED = Correlation("", "", 0.0)  # in place of one that is refused


def plan_of(context: Context, content: Mapping[str, Any] | None) -> Plan | None:
    """The plan of a table, unchecked. None where there is none, or a table of runs that cannot be read."""
    if content is None:
        return None
    if "table" in content:
        return _plan_of_file(context, content)
    if "kind" not in content and context.findings.is_told("plan", "kind"):
        context.findings.note(("plan", "kind"), "plan lacks kind")
    same_as, vary = {}, {}
    seed = content.get("seed", 0)
    for name, each in content.get("vary", {}).items():
        reader = ValuesReader(context, name, each)
        if "same_as" in each:
            reader.check_keys()
            same_as[name] = each["same_as"]
        else:
            vary[name] = reader.values(max(seed, 0))
    correlations = [
        _correlation(context, number, each) for number, each in enumerate(content.get("correlation", ()))
    ]
    return unchecked(
        Plan,
        kind=content.get("kind", "random"),
        vary=vary,
        runs=content.get("runs", 0),
        seed=seed,
        same_as=same_as,
        derived={name: str(text) for name, text in content.get("derived", {}).items()},
        constraints={name: str(text) for name, text in content.get("constraints", {}).items()},
        on_violation=content.get("on_violation", "redraw"),
        correlations=correlations,
        second_order=content.get("second_order", True),
        levels=content.get("levels", 4),
    )


def _plan_of_file(context: Context, content: Mapping[str, Any]) -> Plan | None:
    findings = context.findings
    if others := sorted(set(content) - {"kind", "table"}):
        findings.note(("plan", "keys"), f"plan of a table has {', '.join(others)}: allowed are kind, table")
    if content.get("kind", "table") != "table":
        text = f"plan has a table and is of kind {content['kind']}: allowed is one of them"
        findings.note(("plan", "kind"), text)
    written = content["table"]
    if problem := missing_file(context.folder, written):
        findings.note(("plan", "table"), f"plan: table = {written!r}: {problem}")
        return None
    path = context.folder / written
    texts = [name for name, unit in context.units.items() if unit == quantities.STRING]
    try:
        converted = partial(_in_unit_of_fmu, context)
        columns = (
            tables.read_parquet(path) if tables.is_parquet(path) else tables.read_csv(path, texts, converted)
        )
        vary, table = tables.places(columns, path.parent)
    except DualcamError as error:
        problems = error.problems if isinstance(error, StudyError) else [str(error)]
        findings.note(("plan", "table"), *problems)
        return None
    for name in texts:
        if name in columns:
            note_missing_files(context, name, [str(text) for text in columns[name]])
    return unchecked(Plan, kind="table", vary=vary, table=table)


def _in_unit_of_fmu(context: Context, name: str, unit: str, values: Array) -> Array:
    """The values of a column with a unit, in the unit of the FMU's variable."""
    where = f"plan: column {name}"
    zero, one = (quantities.number(where, name, f"{count} {unit}", context.units) for count in (0, 1))
    return in_unit(values, one - zero) + zero


def _correlation(context: Context, number: int, content: Mapping[str, Any]) -> Correlation:
    """One of the list; a stand-in for one that is refused."""
    place = ("plan", "correlation", number)
    if not context.findings.is_sound(*place):
        return REFUSED
    of = list(content["of"])
    if len(of) != 2:
        context.findings.note(place, f"plan: correlation of {', '.join(of)}: allowed are two names")
    kinds = [kind for kind in ("rank", "pearson") if kind in content]
    if len(kinds) != 1:
        text = f"plan: correlation of {' and '.join(of)}: allowed is one of rank and pearson"
        context.findings.note(place, text)
    if not context.findings.is_sound(*place):
        return REFUSED
    return Correlation(of[0], of[1], float(content[kinds[0]]), kinds[0])
