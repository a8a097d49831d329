"""Optimisations described by TOML files: a plan with a section [optimise], or a design file with
[study.optimise]."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from dualcam.design_file.toml_text import tables_of
from dualcam.fmi.model_description import Scalar
from dualcam.study.checking import Parts
from dualcam.study.entries import hint
from dualcam.study.optimisation.design_files import sections_of
from dualcam.study.optimisation.task import Deviation, FmuRuns, Optimisation, Range
from dualcam.study.optimisation.task_check import check_task
from dualcam.study.plan import Plan
from dualcam.study.problem import Findings, Place, unchecked
from dualcam.study.reading.context import Context
from dualcam.study.reading.parts import check_together, parameters_of, readings_of
from dualcam.study.reading.plan_table import plan_of
from dualcam.study.reading.quantities import number, unit_in
from dualcam.study.reading.scenario_table import scenario_of
from dualcam.study.reading.study_file import (
    content_of,
    context_of,
    context_of_design,
    refuse_section,
    scenario_of_design,
)
from dualcam.study.reading.tables import validated
from dualcam.study.readings import column_of
from dualcam.study.sampling.formula import formula, is_formula
from dualcam.study.scenario import Scenario

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile

NUMBERS = ("method", "budget", "population", "starts", "seed", "percentile", "samples", "difference")
ARRANGEMENT = ("kind", "runs", "seed", "levels", "second_order", "on_violation")  # of the runs of a study
REST = Scenario(1.0)  # instead of one that is refused, so that the rest can be checked


def is_search(content: Mapping[str, Any]) -> bool:
    """Whether the tables of a file have a section [optimise] or [study.optimise]."""
    study = content.get("study", {})
    return "optimise" in content or (isinstance(study, Mapping) and "optimise" in study)


def asks_for_optimum(path: Path) -> bool:
    """Whether a file describes an optimisation; False for one that cannot be read."""
    try:
        content = tables_of(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError):
        return False
    return content is not None and is_search(content)


def read_optimisation(path: str | Path) -> Optimisation:
    """The optimisation that a TOML file describes.

    Parameters
    ----------
    path : str or Path
        A plan with a section [optimise], or a design file with a section [study.optimise]. Paths in the file
        are relative to the file.

    Returns
    -------
    Optimisation
        For `optimise`.

    Raises
    ------
    StudyError
        The file describes no optimisation; all mistakes at once.
    DesignFileError
        The file is a design file with errors.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from dualcam.study import read_optimisation
    >>> with TemporaryDirectory() as folder:
    ...     with open(f"{folder}/best.toml", "w") as file:
    ...         print('fmu = "forward"', "scenario.stop = 0.001", file=file, sep=chr(10))
    ...         print('plan.vary."cam1.lead_angle" = {from = "20 deg", to = "70 deg"}', file=file)
    ...         print('optimise.objectives.efficiency = "maximise"', file=file)
    ...         print('optimise.constraints.torque_load = {from = "0.6 N.m"}', file=file)
    ...     task = read_optimisation(f"{folder}/best.toml")
    >>> task.method_used, task.constraints
    ('evolution', {'torque_load': (0.6, None)})
    """
    path = Path(path)
    content = content_of(path)
    return _of_design(path) if "study" in content else _of_plan(path, content)


def _of_plan(path: Path, content: Mapping[str, Any]) -> Optimisation:
    from dualcam.study.reading.schema import search_model

    findings = Findings()
    table = validated(search_model(), content, "the file", findings)
    context = context_of(path.parent, table.get("fmu"), findings)
    scenario = scenario_of(context, table.get("scenario"))
    task = _task(context, table, content, scenario, parameters_of(context, table.get("parameters", {})))
    findings.refuse(str(path))
    assert task is not None
    return task


def _of_design(path: Path) -> Optimisation:
    from dualcam.design_file import read_design

    design = read_design(path)
    context = context_of(path.parent, design.model, Findings())
    task = _task_of_design(context, design)
    context.findings.refuse(str(path))
    assert task is not None
    return task


def check_search_section(design: DesignFile, is_scenario_refused: bool) -> None:
    """StudyError with all mistakes of the section [study] of a design file that is optimised.

    The rest of the design may have mistakes, too; `is_scenario_refused`: also its scenario."""
    context = context_of_design(design, is_scenario_refused)
    _task_of_design(context, design)
    refuse_section(context.findings)


def _task_of_design(context: Context, design: DesignFile) -> Optimisation | None:
    from dualcam.study.reading.schema import search_section_model

    table = validated(search_section_model(), design.study or {}, "study", context.findings)
    scenario = scenario_of(context, table.get("scenario"))
    scenario = scenario or scenario_of_design(context, design, "an optimisation")
    parameters = design.parameters_for()
    return _task(context, table, design.study or {}, scenario, parameters, sections_of(design))


def _task(
    context: Context,
    table: Mapping[str, Any],
    content: Mapping[str, Any],
    scenario: Scenario | None,
    parameters: Mapping[str, Scalar],
    sections: Mapping[str, Any] = MappingProxyType({}),
) -> Optimisation | None:
    """The optimisation of all parts, checked. None without a plan.

    `content` is the table with what the schema refuses; `sections` are those of a design file."""
    plan = _plan_of(context, table.get("plan"))
    goals = _Goals(context, table.get("optimise", {}))
    results = list(table.get("results", ()))
    others = {name: value for name, value in parameters.items() if plan is None or name not in plan.names}
    named = _names_in(goals)
    read = [name for name in named if name not in {*(plan.names if plan else ()), *map(column_of, results)}]
    readings = readings_of(context, list(dict.fromkeys([*read, *results])), plan, scenario)
    assert readings is not None
    parts = Parts(plan, scenario, readings.raw, others, {*readings.used, *named})
    plan = check_together(context, parts, content, references=goals.start)
    if plan is None or context.fmu is None:
        return None
    if "optimise" not in table:
        context.findings.spoil("optimise", "objectives")
    _check_tolerances(context, goals, plan)
    task = unchecked(
        Optimisation,
        model=FmuRuns(context.fmu, scenario or REST, parameters, plan.derived, plan.constraints, sections),
        vary=plan.vary,
        same_as=plan.same_as,
        correlations=plan.correlations,
        results=results,
        objectives=goals.objectives,
        constraints=goals.constraints,
        start=goals.start,
        tolerances=goals.tolerances,
        units=goals.units | _units_of(table["plan"]),
        **goals.numbers,
    )
    check_task(task, context.findings)
    return task


def _plan_of(context: Context, content: Mapping[str, Any] | None) -> Plan | None:
    """What varies. A plan of any kind will do: how its runs are arranged does not matter here."""
    if content is not None and "table" in content:
        text = "a plan of a table has no bounds: an optimisation needs plan.vary"
        context.findings.note(("plan", "table"), text)
        return None
    if content is None:
        return None
    kept = {name: value for name, value in content.items() if name not in ARRANGEMENT}
    return plan_of(context, kept | {"kind": "latin", "runs": 1})


class _Goals:
    """The section [optimise]."""

    def __init__(self, context: Context, content: Mapping[str, Any]) -> None:
        self._context = context
        self.objectives = dict(content.get("objectives", {}))
        self.numbers = {name: content[name] for name in NUMBERS if name in content}
        self.units: dict[str, str] = {}  # in which the file gives limits, by their text
        self.constraints = {
            text: self._range(text, limits) for text, limits in content.get("constraints", {}).items()
        }
        self.tolerances = {
            name: self._deviation(name, each) for name, each in content.get("tolerances", {}).items()
        }
        self.start = {name: self._start(name, value) for name, value in content.get("start", {}).items()}

    def _number(self, place: Place, where: str, name: str, value: float | str) -> float | None:
        return self._context.findings.attempt(place, number, where, name, value, self._context.units)

    def _range(self, text: str, content: Mapping[str, Any]) -> Range:
        where, name = f"optimise: constraint {text}", text.partition("@")[0]
        limits = []
        for key in ("from", "to"):
            value = content.get(key)
            if unit := unit_in(value):
                self.units[text] = unit
            place = ("optimise", "constraints", text, key)
            limits.append(None if value is None else self._number(place, f"{where}: {key}", name, value))
        return limits[0], limits[1]

    def _deviation(self, name: str, content: Mapping[str, Any]) -> Deviation:
        place = ("optimise", "tolerances", name)
        half = None
        if "plus_minus" in content:
            where = f"optimise: tolerances: {name}: plus_minus"
            half = self._number(place, where, name, content["plus_minus"])
        return Deviation(1.0 if half is None else half, content.get("shape", "normal"))

    def _start(self, name: str, value: float | str) -> float | str:
        if self._context.units.get(name, "1") is None or not unit_in(value):
            return value  # a whole number, or a text to choose from
        place, where = ("optimise", "start", name), f"optimise: start: {name}"
        found = self._number(place, where, name, value)
        return value if found is None else found


def _names_in(goals: _Goals) -> list[str]:
    """Names in the formulas of objectives and constraints; those that are no formulas are told elsewhere."""
    sound = [formula(text) for text in [*goals.objectives, *goals.constraints] if is_formula(text)]
    return [name for each in sound for name in each.names]


def _check_tolerances(context: Context, goals: _Goals, plan: Plan) -> None:
    """Notes tolerances of what neither varies nor is a number of the FMU."""
    if context.variables is None:
        return
    numbers = [name for name, unit in context.units.items() if unit is not None]
    for name in goals.tolerances:
        if name not in plan.names and name not in numbers:
            text = f"optimise: tolerances: {name} is no number of the FMU{hint(name, numbers)}"
            context.findings.note(("optimise", "tolerances", name), text)


def _units_of(content: Mapping[str, Any]) -> dict[str, str]:
    """The units in which the file gives the values of names."""
    found = {}
    vary = content.get("vary", {})
    for name, each in vary.items():
        each = vary.get(each.get("same_as"), each)
        given = [each.get("from"), each.get("to"), each.get("mean"), *each.get("values", ())]
        if units := [unit for value in given if (unit := unit_in(value))]:
            found[name] = units[0]
    return found
