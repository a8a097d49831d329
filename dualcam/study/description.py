"""Studies described by TOML files."""

from __future__ import annotations

import tomllib
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dualcam.errors import DualcamWarning
from dualcam.library import MODELS
from dualcam.study.checking import Variables, problems_of_names, problems_of_study
from dualcam.study.plan import Plan
from dualcam.study.plot_keys import columns_to_draw, problems_of_plots
from dualcam.study.problem import StudyError, refuse
from dualcam.study.quantities import fixed, units_of_designs, units_of_fmu
from dualcam.study.reading import Reading
from dualcam.study.readings import Readings
from dualcam.study.scenario import Scenario
from dualcam.study.study import Study

NO_STUDY = """this design file has no section [study]. Add one, such as
[study]
results = ["efficiency", "theta"]
[study.plan]
kind = "grid"
vary."cam1.lead_angle" = {from = "35 deg", to = "50 deg", count = 4}
docs/use-studies.md explains the keys; `dualcam study --help` has an example"""


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
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise StudyError(f"{path} cannot be read as TOML: {error}") from error
    if "study" in content:
        return _study_of_design(path)
    if _is_design(content):
        raise StudyError(f"{path}: {NO_STUDY}")
    return _study_of_plan(path, content)


def _is_design(content: Mapping[str, Any]) -> bool:
    """Whether a file without [study] is a design file, and no plan with a slip."""
    if not {"fmu", "plan"}.isdisjoint(content):
        return False
    from dualcam.design_file.schema import known_keys

    return any(name in known_keys() for name in content if name != "scenario")


def _study_of_plan(path: Path, content: Mapping[str, Any]) -> Study:
    from dualcam.study.schema import plan_model

    reading = Reading(path.parent)
    table = reading.validated(plan_model(), content, "the file")
    named = table.get("fmu")
    fmu = None if named is None else named if named in MODELS else path.parent / named
    variables = None if fmu is None else reading.attempt(Variables.of_fmu, fmu)
    units = _no_units if variables is None else units_of_fmu(fmu or "")
    parameters = reading.attempt(fixed, table.get("parameters", {}), units) or {}
    plan, scenario = reading.plan(table.get("plan"), units), reading.scenario(table.get("scenario"), units)
    if variables is not None:
        raw = _check_results(reading, table, plan, scenario)
        reading.note(problems_of_study(variables, plan, scenario, raw, parameters))
    refuse(reading.problems, str(path))
    assert fmu is not None and plan is not None and scenario is not None
    return Study(fmu, plan, scenario, table["results"], parameters, table.get("plots", ()))


def _check_results(
    reading: Reading, table: Mapping[str, Any], plan: Plan | None, scenario: Scenario | None
) -> Sequence[str] | None:
    """Notes what is wrong with results and pictures. What the FMU is asked for; None where a result is
    refused."""
    results, plots = table.get("results", []), table.get("plots", ())
    if not results or scenario is None:
        return None
    readings = reading.attempt(Readings, results, scenario.stop, plan.names if plan else ())
    if readings is None:
        return None
    if plan is not None and plots:
        kind = table["plan"].get("kind", plan.kind)
        reading.note(problems_of_plots(plots, kind, columns_to_draw(plan, readings)))
    return list(readings.raw)


def _no_units() -> Mapping[str, str | None]:
    """Of an FMU that cannot be read."""
    return {}


def _study_of_design(path: Path) -> Study:
    """The study in the section [study] of a design file: its runs begin with the design's values."""
    from dualcam.design_file import read_design  # the reader of design files reads plans by this module

    design = read_design(path)
    for warning in design.warnings:
        warnings.warn(DualcamWarning(f"{path}: {warning}"), stacklevel=3)
    reading = Reading(path.parent)
    section = design.study or {}
    plan, scenario = _section(reading, section)
    if scenario is None and "scenario" not in section:
        scenario = design.scenario
    if scenario is None:
        reading.note(["the study needs a [scenario]: what is done in each run, for example stop = 1.0"])
    fixed_values = design.parameters_for()
    if plan is not None:
        fixed_values = {name: value for name, value in fixed_values.items() if name not in plan.names}
    variables = Variables.of_fmu(design.model)
    raw = _check_results(reading, section, plan, scenario)
    reading.note(problems_of_study(variables, plan, scenario, raw, fixed_values))
    refuse(reading.problems, str(path))
    assert plan is not None and scenario is not None
    return Study(design.model, plan, scenario, section["results"], fixed_values, section.get("plots", ()))


def _section(reading: Reading, content: Mapping[str, Any]) -> Any:  # noqa: ANN401
    from dualcam.study.schema import section_model

    table = reading.validated(section_model(), content, "study")
    plan = reading.plan(table.get("plan"), units_of_designs)
    return plan, reading.scenario(table.get("scenario"), units_of_designs)


def check_section(content: Mapping[str, Any], folder: Path, design_scenario: Scenario | None) -> None:
    """StudyError with all mistakes of the section [study] of a design file in this folder."""
    reading = Reading(folder)
    plan, scenario = _section(reading, content)
    if plan is not None:
        scenario = scenario if "scenario" in content else design_scenario
        reading.note(problems_of_names(plan, scenario, units_of_designs()))
    refuse(reading.problems)
