"""Studies described by TOML files."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from dualcam.common.mistakes import Findings, StudyError, refuse, told_of
from dualcam.design_file.toml_text import tables_of
from dualcam.errors import DualcamWarning, UnitWarning
from dualcam.fmi.model_description import Scalar
from dualcam.scenario.scenario import Scenario
from dualcam.study.file.context import STRING, Context, in_unit
from dualcam.study.file.plan_table import plan_of
from dualcam.study.file.scenario_table import scenario_of
from dualcam.study.file.schema import model_of
from dualcam.study.file.schema_check import check_schema
from dualcam.study.plan.unit_warnings import unit_warnings_of
from dualcam.study.plot_keys import problems_of_columns
from dualcam.study.run.fmu_check import problems_with_fmu
from dualcam.study.run.readings import Readings
from dualcam.study.study import Study

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile

Made = TypeVar("Made")
Tables = Mapping[str, Any]
NO_STUDY = """this design file has no section [study]. Add one, such as
[study]
results = ["efficiency", "theta"]
[study.plan]
kind = "grid"
vary."cam1.lead_angle" = {from = "35 deg", to = "50 deg", count = 4}
docs/use-studies.md explains the keys; `dualcam study --help` has an example"""
NAMED = ("vary", "derived")  # tables of [plan] by the names of columns
NO_SCENARIO = "needs a [scenario]: what is done in each run, for example stop = 1.0"


def read_study(path: str | Path) -> Study:
    """The study that a TOML file describes.

    Parameters
    ----------
    path : A plan, or a design file with a section [study]. Paths in the file are relative to the file.

    Returns
    -------
    Study
        Its `run` makes the runs.

    Raises
    ------
    StudyError
        The file describes no study: all mistakes of a stage at once, of the schema, or else of values,
        or else names that the FMU does not have and ranges that it does not allow.
    DesignFileError
        The file is a design file with errors.

    Warns
    -----
    DualcamWarning
        For each warning about a design file.
    UnitWarning
        The least or greatest value of a name that varies looks as if it were in another unit.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from dualcam.study import read_study
    >>> text = '''
    ... fmu = "forward"
    ... results = ["efficiency"]
    ... [plan]
    ... kind = "grid"
    ... vary."cam1.lead_angle" = {from = "35 deg", to = "55 deg", count = 5}
    ... [scenario]
    ... stop = 0.1
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "angles.toml"
    ...     _ = path.write_text(text)
    ...     study = read_study(path)
    >>> study.plan.count, study.plan.names
    (5, ['cam1.lead_angle'])
    """
    return read_tables(Path(path), _study_of_plan, study_of_design)


def read_tables(
    path: Path, of_plan: Callable[[Path, Tables], Made], of_design: Callable[[DesignFile], Made]
) -> Made:
    """What is made of a plan's folder and tables, or else of a design with a section [study]."""
    content = content_of(path)
    if "study" not in content and _is_design(content):
        raise StudyError(f"{path}: {NO_STUDY}")
    if "study" not in content:
        with told_of(path):
            return of_plan(path.parent, content)
    from dualcam.design_file import read_design  # the reader of design files reads plans by this module

    design = read_design(path)
    for warning in design.warnings:
        warnings.warn(DualcamWarning(f"{path}: {warning}"), stacklevel=3)
    with told_of(path):
        return of_design(design)


def content_of(path: Path) -> dict[str, Any]:
    """The tables of a file. StudyError for one that is no TOML."""
    try:
        content = tables_of(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise StudyError(f"{path} cannot be read as TOML: {error}") from error
    if content is None:
        raise StudyError(f"{path} is no study: tables or lists are nested too deeply")
    return content


def _is_design(content: Tables) -> bool:
    """Whether a file without [study] is a design file, and no plan with a slip."""
    if not {"fmu", "plan"}.isdisjoint(content):
        return False
    from dualcam.design_file.schema import known_keys

    return any(name in known_keys() for name in content if name != "scenario")


def parameters_of(context: Context, content: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """Start values, with the texts of real variables as numbers in the unit of the variable."""
    findings, found = Findings(), dict(content)
    for name, value in content.items():
        unit = context.units.get(name)
        if isinstance(value, str) and unit not in (None, STRING):
            number = findings.attempt(in_unit, f"parameters: {name}", value, str(unit))
            found[name] = value if number is None else number
    findings.refuse()
    return found


def _study(
    context: Context, table: Tables, scenario: Scenario | None, parameters: Mapping[str, Scalar]
) -> Study:
    """The study of a table that keeps the schema; `scenario` where the table has none. StudyError with all
    that is wrong with the values, or else with all that the FMU does not have or allow."""
    findings = Findings()
    fixed = findings.attempt(parameters_of, context, parameters)
    plan = findings.attempt(plan_of, context, table["plan"])
    if "scenario" in table:
        scenario = findings.attempt(scenario_of, context, table["scenario"])
    elif scenario is None:
        findings.note(f"the study {NO_SCENARIO}")
    if scenario is not None:  # results are read at instants of it
        names = plan.names if plan else [name for key in NAMED for name in table["plan"].get(key, ())]
        findings.attempt(Readings, table["results"], scenario.stop, names)
    findings.refuse()
    assert fixed is not None and plan is not None and scenario is not None
    if plan.kind != "table":  # the reader of tables knows the units in the header, and warns
        for text in unit_warnings_of(plan, _with_written_units(table["plan"])):
            warnings.warn(UnitWarning(text), stacklevel=5)
    study = Study(context.fmu, plan, scenario, table["results"], fixed, table.get("plots", ()))
    refuse(problems_with_fmu(context.variables, plan, study.job(), study.readings.used))
    refuse(problems_of_columns(study.plots, plan, study.readings))
    return study


def _with_written_units(plan: Tables) -> set[str]:
    """Names whose values are texts, thus have a unit."""
    found = set()
    for name, each in plan.get("vary", {}).items():
        given = [each.get(key) for key in ("from", "to", "mean", "std")]
        given += [*each.get("values", ()), *each.get("arguments", {}).values()]
        if any(isinstance(value, str) for value in given):
            found.add(name)
    return found


def _study_of_plan(folder: Path, content: Tables) -> Study:
    check_schema(model_of("StudyPlan"), content, "the file")
    return _study(Context.of(folder, content["fmu"]), content, None, content.get("parameters", {}))


def study_of_design(design: DesignFile) -> Study:
    """The study of the section [study] of a design: its runs begin with the design's values."""
    table = design.study or {}
    check_schema(model_of("StudySection"), table, "study")
    varied = {*table["plan"].get("vary", {}), *table["plan"].get("derived", {})}
    fixed = {name: value for name, value in design.parameters_for().items() if name not in varied}
    return _study(Context.of(design.path.parent, design.model), table, design.scenario, fixed)
