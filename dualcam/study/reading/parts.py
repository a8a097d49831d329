"""The parts of a study that a file describes, checked together."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import Any

from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import Scalar
from dualcam.study.checking import Parts, check_names, check_parts, names_used
from dualcam.study.first_runs import check_first_runs
from dualcam.study.history import History
from dualcam.study.plan import Plan
from dualcam.study.plan_check import VARIES_NOTHING, check_plan
from dualcam.study.plot_keys import columns_of, columns_to_draw, problems_of_plots
from dualcam.study.problem import unchecked
from dualcam.study.reading.context import Context
from dualcam.study.reading.quantities import STRING, in_unit
from dualcam.study.readings import Readings
from dualcam.study.sampling.formula import formula, is_formula
from dualcam.study.scenario import Scenario
from dualcam.study.scenario_check import check_scenario
from dualcam.study.sound_plan import STAND_IN, place_of

FORMULAS = ("derived", "constraints")  # tables of formulas in [plan]


def parameters_of(context: Context, content: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """Start values, with the texts of real variables as numbers in the unit of the variable."""
    found: dict[str, Scalar] = {}
    for name, value in content.items():
        unit = context.units.get(name)
        if isinstance(value, str) and unit not in (None, STRING):
            where = f"parameters: {name}"
            number = context.findings.attempt(("parameters", name), in_unit, where, value, str(unit))
            found[name] = value if number is None else number
        else:
            found[name] = value
    return found


def check_together(
    context: Context, parts: Parts, content: Mapping[str, Any], references: Collection[str] = ()
) -> Plan | None:
    """Notes all that is wrong with the parts of a study, unchecked, that stand in a file of this content.

    `references`: further names of the plan that the file has elsewhere. Gives the plan of the parts, with
    the names that others are meant to be."""
    findings = context.findings
    used = {*parts.used, *_names_in_refused(content)}
    plan = _with_meant_names(context, parts, used, references)
    if plan is not None:
        check_plan(plan, findings)
    if parts.scenario is not None:
        check_scenario(_with_meant_inputs(context, parts.scenario), findings)
    if context.variables is None:
        check_names(replace(parts, plan=plan, used=used), None, findings)
        return plan
    whole = replace(parts, plan=plan, used=used)
    check_parts(context.variables, whole, findings)
    if context.tries_runs and findings.problems and context.fmu is not None:
        check_first_runs(str(source_path(context.fmu)), whole, findings)
    return plan


def readings_of(
    context: Context, results: Sequence[str] | None, plan: Plan | None, scenario: Scenario | None
) -> Readings | None:
    """What of the results is sound; None without results."""
    if results is None:
        return None
    refused: dict[int, str] = {}
    is_known = scenario is not None and context.findings.is_sound("scenario", "stop")
    stop = scenario.stop if scenario is not None and is_known else None
    stop = stop if is_formula(stop) or not isinstance(stop, str) else None
    readings = Readings(results, stop, plan.names if plan else (), refused)
    for place, text in refused.items():
        context.findings.note(("results", place), text)
    return readings


def check_plots(
    context: Context, plots: Sequence[Mapping[str, Any]], plan: Plan | None, readings: Readings | None
) -> None:
    """Notes what is wrong with the pictures."""
    if plan is None or readings is None:
        return
    known = [*columns_to_draw(plan, readings), *readings.refused_columns]
    tables = [plot for plot in plots if isinstance(plot, Mapping)]
    drawn = {name for plot in tables for name in columns_of(plot) if isinstance(name, str)} - {*known}
    doubtful = _doubtful_columns(context, plan, readings)
    known += [name for name in drawn if get_close_matches(name, doubtful, n=1, cutoff=0.6)]
    kind = plan.kind if context.findings.is_sound("plan", "kind") else None
    context.findings.note(("plots",), *problems_of_plots(plots, kind, known))


# ---- one mistake, one message ----


def _doubtful_columns(context: Context, plan: Plan, readings: Readings) -> list[str]:
    """Columns whose names may have a slip: of a picture that has the right name no message is needed."""
    if context.variables is None:
        return []
    refused = [name for name in plan.names if not context.findings.is_sound(*place_of(plan, name))]
    names = [*refused, *(name for name in readings.columns if name in readings.raw)]
    return [name for name in names if name.partition("@")[0] not in context.variables.by_name]


def _names_in_refused(content: Mapping[str, Any]) -> set[str]:
    """What looks like a name in texts that are no formulas, or in tables that are refused: such a name is
    not unused."""
    plan = content.get("plan")
    tables = [plan.get(key) for key in FORMULAS] if isinstance(plan, Mapping) else []
    texts = _texts_in([*tables, content.get("scenario")])
    results = content.get("results")
    texts += [text.partition("=")[2] for text in _texts_in(results) if "=" in text]
    return {name for text in texts for name in _names_of(text)}


def _names_of(text: str) -> set[str]:
    return {*formula(text).names} if is_formula(text) else {*re.findall(r"[A-Za-z_][\w.]*", text)}


def _texts_in(content: Any) -> list[str]:  # noqa: ANN401
    if isinstance(content, str):
        return [content]
    if isinstance(content, Mapping):
        content = list(content.values())
    return [text for each in content for text in _texts_in(each)] if isinstance(content, list) else []


def _with_meant_names(
    context: Context, parts: Parts, used: Collection[str], references: Collection[str]
) -> Plan | None:
    """The plan with the names that formulas, `same_as` and correlations use, and that one of its names is
    meant to be: a name with a slip is told once."""
    plan, scenario, findings = parts.plan, parts.scenario, context.findings
    if plan is None:
        return plan
    missing = {*names_used(plan, scenario, with_references=True), *references} - {*plan.names, ""}
    if not plan.vary and findings.is_told("plan", "vary"):
        findings.note(("plan", "vary"), VARIES_NOTHING)
    if not (findings.is_told("plan", "vary") and findings.is_told("plan", "derived")):
        return _with_names(context, plan, sorted(missing))
    if context.variables is None:
        return plan
    known = {*context.variables.by_name, *names_used(plan, scenario), *used}
    unknown = [name for name in plan.names if name not in known]
    meant = {name for one in unknown for name in get_close_matches(one, missing, n=1, cutoff=0.6)}
    return _with_names(context, plan, sorted(meant))


def _with_names(context: Context, plan: Plan, meant: Sequence[str]) -> Plan:
    if not meant:
        return plan
    for name in meant:
        context.findings.spoil("meant", name)
        context.findings.spoil("plan", "vary", name)
    return unchecked(Plan, **{**_fields(plan), "vary": {**plan.vary, **dict.fromkeys(meant, STAND_IN)}})


def _fields(made: Any) -> dict[str, Any]:  # noqa: ANN401
    return {name: getattr(made, name) for name in made.__dataclass_fields__}


def _with_meant_inputs(context: Context, scenario: Scenario) -> Scenario:
    """The scenario with the inputs of which others are derivatives, and that one of its inputs is meant to
    be."""
    if context.variables is None:
        return scenario
    unknown = [name for name in scenario.inputs if name not in context.variables.by_name]
    missing = {each.derivative_of for each in scenario.inputs.values()} - {*scenario.inputs, ""}
    meant = {name for one in unknown for name in get_close_matches(one, missing, n=1, cutoff=0.6)}
    inputs = {**scenario.inputs, **{name: History([0.0], [0.0]) for name in meant}}
    return unchecked(Scenario, **{**_fields(scenario), "inputs": inputs})
