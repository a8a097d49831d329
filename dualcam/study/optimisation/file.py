"""Optimisations described by TOML files: a plan with a section [optimise], or a design file with
[study.optimise]."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from dualcam.common.entries import hint
from dualcam.common.mistakes import Findings, StudyError
from dualcam.fmi.model_description import Scalar
from dualcam.scenario.scenario import Scenario
from dualcam.study.file.context import Context, unit_in
from dualcam.study.file.plan_table import STAND_IN, plan_of
from dualcam.study.file.scenario_table import scenario_of
from dualcam.study.file.schema import model_of
from dualcam.study.file.schema_check import check_schema
from dualcam.study.file.study_file import NO_SCENARIO, Made, Tables, parameters_of, read_tables
from dualcam.study.optimisation.design_files import sections_of
from dualcam.study.optimisation.designs import Deviation, FmuRuns, Range
from dualcam.study.optimisation.task import NUMBERS, Optimisation
from dualcam.study.plan.plan import Plan
from dualcam.study.run.fmu_check import problems_with_fmu
from dualcam.study.study import Study

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile

ARRANGEMENT = ("kind", "runs", "seed", "levels", "second_order", "on_violation")  # of the runs of a study
REST = Scenario(1.0)  # instead of one that is refused, so that the rest can be checked


def is_search(content: Tables) -> bool:
    """Whether the tables of a file have a section [optimise] or [study.optimise]."""
    study = content.get("study", {})
    return "optimise" in content or (isinstance(study, Mapping) and "optimise" in study)


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
        The file describes no optimisation; all mistakes of a stage at once.
    DesignFileError
        The file is a design file with errors.

    Warns
    -----
    DualcamWarning
        For each warning about a design file.

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
    return read_tables(Path(path), _task_of_plan, task_of_design)


def _task_of_plan(folder: Path, content: Tables) -> Optimisation:
    check_schema(model_of("Search"), content, "the file")
    return _task(Context.of(folder, content["fmu"]), content, None, content.get("parameters", {}))


def task_of_design(design: DesignFile) -> Optimisation:
    """The optimisation of the section [study] of a design."""
    table = design.study or {}
    check_schema(model_of("SearchSection"), table, "study")
    context = Context.of(design.path.parent, design.model)
    return _task(context, table, design.scenario, design.parameters_for(), sections_of(design))


def _task(
    context: Context,
    table: Tables,
    scenario: Scenario | None,
    parameters: Mapping[str, Scalar],
    sections: Tables = MappingProxyType({}),
) -> Optimisation:
    """The optimisation of a table that keeps the schema; `scenario` where the table has none; `sections` are
    those of a design file. StudyError with all that is wrong with the values, or else with the FMU."""
    findings = Findings()
    fixed = findings.attempt(parameters_of, context, parameters)
    plan = findings.attempt(_plan_of, context, table["plan"])
    goals = findings.attempt(_Goals, context, table["optimise"])
    if "scenario" in table:
        scenario = findings.attempt(scenario_of, context, table["scenario"])
    elif scenario is None:
        findings.note(f"an optimisation {NO_SCENARIO}")
    model = FmuRuns(context.fmu, scenario or REST, fixed or {}, sections=sections)
    varied: dict[str, Any] = {"vary": dict.fromkeys(table["plan"].get("vary", ()), STAND_IN)}
    if plan is not None:
        model = replace(model, derived=plan.derived, conditions=plan.constraints)
        varied = {"vary": plan.vary, "same_as": plan.same_as, "correlations": plan.correlations}
    task = None
    if goals is not None:
        task = findings.attempt(
            Optimisation,
            model,
            objectives=goals.objectives,
            constraints=goals.constraints,
            start=goals.start if plan else {},
            tolerances=goals.tolerances,
            results=list(table.get("results", ())),
            units=goals.units | _units_of(table["plan"]),
            **varied,
            **goals.numbers,
        )
    findings.refuse()
    assert task is not None and plan is not None and scenario is not None and fixed is not None
    others = {name: value for name, value in fixed.items() if name not in plan.names}
    study = Study(context.fmu, plan, scenario, task.read, others)
    used = {*study.readings.used, *(name for each in task.formulas.values() for name in each.names)}
    findings.note(*problems_with_fmu(context.variables, plan, study.job(), used))
    findings.note(*_problems_of_tolerances(context, task, plan))
    findings.refuse()
    return task


def _plan_of(context: Context, content: Tables) -> Plan:
    """What varies. A plan of any kind will do: how its runs are arranged does not matter here."""
    if "table" in content:
        raise StudyError("a plan of a table has no bounds: an optimisation needs plan.vary")
    kept = {name: value for name, value in content.items() if name not in ARRANGEMENT}
    return plan_of(context, kept | {"kind": "latin", "runs": 1})


class _Goals:
    """The section [optimise]. StudyError with all that is wrong with its numbers."""

    def __init__(self, context: Context, content: Tables) -> None:
        self._context, self._content, self._findings = context, content, Findings()
        self.objectives = dict(content["objectives"])
        self.numbers = {name: content[name] for name in NUMBERS if name in content}
        self.units: dict[str, str] = {}  # in which the file gives limits, by their text
        self.constraints = self._each("constraints", self._range)
        self.tolerances = self._each("tolerances", self._deviation)
        self.start = self._each("start", self._start)
        self._findings.refuse()

    def _each(self, key: str, read: Callable[[str, Any], Made]) -> dict[str, Made]:
        return {name: read(name, value) for name, value in self._content.get(key, {}).items()}

    def _number(self, where: str, name: str, value: float | str) -> float | None:
        return self._findings.attempt(self._context.number, where, name, value)

    def _range(self, text: str, content: Tables) -> Range:
        where, name = f"optimise: constraint {text}", text.partition("@")[0]
        if units := [unit for value in content.values() if (unit := unit_in(value))]:
            self.units[text] = units[-1]
        limits = {key: self._number(f"{where}: {key}", name, value) for key, value in content.items()}
        return limits.get("from"), limits.get("to")

    def _deviation(self, name: str, content: Tables) -> Deviation:
        half = self._number(f"optimise: tolerances: {name}: plus_minus", name, content["plus_minus"])
        return Deviation(math.nan if half is None else half, content.get("shape", "normal"))

    def _start(self, name: str, value: float | str) -> float | str:
        if self._context.units.get(name, "1") is None or not unit_in(value):
            return value  # a whole number, or a text to choose from
        found = self._number(f"optimise: start: {name}", name, value)
        return value if found is None else found


def _problems_of_tolerances(context: Context, task: Optimisation, plan: Plan) -> list[str]:
    """Tolerances of what neither varies nor is a number of the FMU."""
    numbers = [name for name, unit in context.units.items() if unit is not None]
    return [
        f"optimise: tolerances: {name} is no number of the FMU{hint(name, numbers)}"
        for name in task.tolerances
        if name not in plan.names and name not in numbers
    ]


def _units_of(content: Tables) -> dict[str, str]:
    """The units in which the file gives the values of names."""
    found = {}
    vary = content.get("vary", {})
    for name, each in vary.items():
        each = vary.get(each.get("same_as"), each)
        given = [each.get("from"), each.get("to"), each.get("mean"), *each.get("values", ())]
        if units := [unit for value in given if (unit := unit_in(value))]:
            found[name] = units[0]
    return found
