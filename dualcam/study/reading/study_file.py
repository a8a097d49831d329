"""Studies described by TOML files."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dualcam.design_file.toml_text import tables_of
from dualcam.errors import DualcamWarning
from dualcam.fmi.library import MODELS
from dualcam.fmi.model_description import Scalar
from dualcam.study.checking import Parts, Variables
from dualcam.study.problem import Findings, StudyError
from dualcam.study.reading.context import Context
from dualcam.study.reading.parts import check_plots, check_together, parameters_of, readings_of
from dualcam.study.reading.plan_table import plan_of
from dualcam.study.reading.scenario_table import scenario_of
from dualcam.study.reading.tables import validated
from dualcam.study.scenario import Scenario
from dualcam.study.study import Study

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile

NO_STUDY = """this design file has no section [study]. Add one, such as
[study]
results = ["efficiency", "theta"]
[study.plan]
kind = "grid"
vary."cam1.lead_angle" = {from = "35 deg", to = "50 deg", count = 4}
docs/use-studies.md explains the keys; `dualcam study --help` has an example"""
NO_SCENARIO = "needs a [scenario]: what is done in each run, for example stop = 1.0"


def read_study(path: str | Path) -> Study:
    """The study that a TOML file describes.

    Parameters
    ----------
    path : str or Path
        A plan, or a design file with a section [study]. Paths in the file are relative to the file.

    Returns
    -------
    Study
        Its `run` makes the runs.

    Raises
    ------
    StudyError
        The file describes no study: all mistakes at once, also names that the FMU does not have and ranges
        that the FMU does not allow.
    DesignFileError
        The file is a design file with errors.

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
    path = Path(path)
    content = content_of(path)
    if "study" in content:
        return _study_of_design(path)
    if _is_design(content):
        raise StudyError(f"{path}: {NO_STUDY}")
    return _study_of_plan(path, content)


def content_of(path: Path) -> dict[str, Any]:
    """The tables of a file. StudyError for one that is no TOML."""
    try:
        content = tables_of(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise StudyError(f"{path} cannot be read as TOML: {error}") from error
    if content is None:
        raise StudyError(f"{path} is no study: tables or lists are nested too deeply")
    return content


def _is_design(content: Mapping[str, Any]) -> bool:
    """Whether a file without [study] is a design file, and no plan with a slip."""
    if not {"fmu", "plan"}.isdisjoint(content):
        return False
    from dualcam.design_file.schema import known_keys

    return any(name in known_keys() for name in content if name != "scenario")


def context_of(folder: Path, fmu: str | None, findings: Findings) -> Context:
    """Of a file in this folder that names this FMU."""
    if fmu is None:
        return Context(folder, None, None, findings)
    path = fmu if fmu in MODELS else folder / fmu
    found = findings.attempt(("fmu",), Variables.of_fmu, path)
    return Context(folder, path, found, findings)


def _study_of_plan(path: Path, content: Mapping[str, Any]) -> Study:
    from dualcam.study.reading.schema import plan_model

    findings = Findings()
    table = validated(plan_model(), content, "the file", findings)
    context = context_of(path.parent, table.get("fmu"), findings)
    parts = _parts(context, table, content, None, parameters_of(context, table.get("parameters", {})))
    findings.refuse(str(path))
    return _study(context, table, parts)


def _study(context: Context, table: Mapping[str, Any], parts: Parts) -> Study:
    """The study of parts in which nothing is wrong."""
    assert context.fmu is not None and parts.plan is not None and parts.scenario is not None
    plots = table.get("plots", ())
    return Study(context.fmu, parts.plan, parts.scenario, table["results"], parts.parameters, plots)


def _parts(
    context: Context,
    table: Mapping[str, Any],
    content: Mapping[str, Any],
    scenario: Scenario | None,
    parameters: Mapping[str, Scalar],
) -> Parts:
    """Plan, scenario and results of a table, checked; `scenario` where the table has none.

    `content` is the table with what the schema refuses."""
    plan = plan_of(context, table.get("plan"))
    scenario = scenario_of(context, table.get("scenario")) or scenario
    readings = readings_of(context, table.get("results"), plan, scenario)
    used = readings.used if readings else ()
    parts = Parts(plan, scenario, readings.raw if readings else None, parameters, used)
    check_together(context, parts, content)
    check_plots(context, table.get("plots", ()), plan, readings)
    return parts


def _study_of_design(path: Path) -> Study:
    """The study in the section [study] of a design file: its runs begin with the design's values."""
    from dualcam.design_file import read_design  # the reader of design files reads plans by this module

    design = read_design(path)
    for warning in design.warnings:
        warnings.warn(DualcamWarning(f"{path}: {warning}"), stacklevel=3)
    context = context_of(path.parent, design.model, Findings())
    parts = _parts_of_section(context, design)
    context.findings.refuse(str(path))
    return _study(context, design.study or {}, parts)


def _parts_of_section(context: Context, design: DesignFile) -> Parts:
    from dualcam.study.reading.schema import section_model

    section = design.study or {}
    table = validated(section_model(), section, "study", context.findings)
    scenario = scenario_of_design(context, design, "the study")
    return _parts(context, table, section, scenario, _fixed_of(design, table))


def scenario_of_design(context: Context, design: DesignFile, whose: str) -> Scenario | None:
    """The scenario of the design, where the section has none. None, with a note, if there is none at all."""
    if "scenario" in (design.study or {}):
        return None
    if design.scenario is None and context.findings.is_sound("scenario"):
        context.findings.note(("scenario",), f"{whose} {NO_SCENARIO}")
    return design.scenario


def _fixed_of(design: DesignFile, table: Mapping[str, Any]) -> dict[str, Scalar]:
    """The design's values but those that get another value in each run."""
    plan = table.get("plan", {})
    varied = {*plan.get("vary", {}), *plan.get("derived", {})}
    return {name: value for name, value in design.parameters_for().items() if name not in varied}


def context_of_design(design: DesignFile, is_scenario_refused: bool) -> Context:
    """For the check of a section: what the FMU refuses may follow from another mistake of the design."""
    findings = Findings()
    if is_scenario_refused:
        findings.spoil("scenario")
    context = context_of(design.path.parent, design.model, findings)
    return replace(context, tries_runs=False)


def check_section(design: DesignFile, is_scenario_refused: bool) -> None:
    """StudyError with all mistakes of the section [study] of a design file.

    The rest of the design may have mistakes, too; `is_scenario_refused`: also its scenario."""
    context = context_of_design(design, is_scenario_refused)
    _parts_of_section(context, design)
    refuse_section(context.findings)


def refuse_section(findings: Findings) -> None:
    """StudyError with all problems. A design may lack a scenario and nothing else."""
    if not all(problem.endswith(NO_SCENARIO) for problem in findings.problems):
        findings.refuse()
