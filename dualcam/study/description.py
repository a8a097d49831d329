"""Studies described by TOML files."""

from __future__ import annotations

import importlib
import math
import tomllib
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dualcam.errors import DualcamWarning
from dualcam.library import MODELS
from dualcam.study.entries import NUMBER, QUANTITY, SWITCH, TABLE, TEXT, VALUES, WHOLE, Kind, entries
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError
from dualcam.study.quantities import Units, fixed, number, units_of_designs, units_of_fmu
from dualcam.study.sampling.vary import Vary
from dualcam.study.scenario import Controller, History, Scenario
from dualcam.study.study import Study

FILE = {
    "fmu": TEXT,
    "plan": TABLE,
    "scenario": TABLE,
    "results": TEXT.listed(),
    "parameters": TABLE,
    "plots": Kind("[[plots]] tables", lambda value: isinstance(value, list) and all(map(TABLE.suits, value))),
}
STUDY = {name: FILE[name] for name in ("plan", "results", "plots")}  # in the section [study] of a design file
PLAN = {"kind": TEXT, "runs": WHOLE, "seed": WHOLE, "vary": TABLE, "table": TEXT}
SAME_AS = {"same_as": TEXT}
VARY = {"from": QUANTITY, "to": QUANTITY, "count": WHOLE, "log": SWITCH, "values": VALUES}
SCENARIO = {"stop": NUMBER, "step": NUMBER, "tolerance": NUMBER, "inputs": TABLE, "controller": TABLE}
HISTORY = {"time": NUMBER.listed(), "value": NUMBER.listed(), "shape": TEXT, "derivative_of": TEXT}
CONTROLLER = {"create_law": TEXT, "period": NUMBER, "reads": TEXT.listed(), "writes": TEXT.listed()}
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
        The file describes no study.
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
    try:
        if "study" in content:
            return _study_of_design(path)
        if _is_design(content):
            raise StudyError(NO_STUDY)
        table = entries(content, "the file", FILE, ("fmu", "plan", "scenario", "results"))
        fmu = table["fmu"] if table["fmu"] in MODELS else path.parent / table["fmu"]
        units = units_of_fmu(fmu)
        return Study(
            fmu,
            read_plan(table["plan"], path.parent, units),
            _scenario(table["scenario"]),
            table["results"],
            fixed(table.get("parameters", {}), units),
            table.get("plots", ()),
        )
    except StudyError as error:
        raise StudyError(f"{path}: {error}") from error


def _is_design(content: Mapping[str, Any]) -> bool:
    """Whether a file without [study] is a design file, and no plan with a slip."""
    if not {"fmu", "plan"}.isdisjoint(content):
        return False
    from dualcam.design_file.schema import known_keys

    return any(name in known_keys() for name in content if name != "scenario")


def _study_of_design(path: Path) -> Study:
    """The study in the section [study] of a design file: its runs begin with the design's values."""
    from dualcam.design_file import read_design  # the reader of design files reads plans by this module

    design = read_design(path)
    for warning in design.warnings:
        warnings.warn(DualcamWarning(f"{path}: {warning}"), stacklevel=3)
    table = entries(design.study, "study", STUDY, ("plan", "results"))
    if design.scenario is None:
        raise StudyError("the study needs a [scenario]: what is done in each run, for example stop = 1.0")
    plan = read_plan(table["plan"], path.parent)
    others = {name: value for name, value in design.parameters_for().items() if name not in plan.names}
    return Study(
        design.model,
        plan,
        design.scenario,
        table["results"],
        others,
        table.get("plots", ()),
    )


def read_plan(content: Mapping[str, Any], folder: Path, units: Units = units_of_designs) -> Plan:
    """The plan of a table. `folder`: of the file; `units`: those into which texts such as "40 deg" go."""
    table = entries(content, "plan", PLAN)
    if "table" in table:
        entries(content, "plan of a table", {"kind": TEXT, "table": TEXT})
        if table.get("kind", "table") != "table":
            raise StudyError(f"plan has a table and is of kind {table['kind']}: allowed is one of them")
        return Plan.from_csv(folder / table["table"])
    entries(content, "plan", PLAN, ("kind",))
    varied = table.get("vary", {})
    same_as = {
        name: entries(each, f"plan: {name}", SAME_AS)["same_as"]
        for name, each in varied.items()
        if TABLE.suits(each) and "same_as" in each
    }
    vary = {name: _vary(name, each, units) for name, each in varied.items() if name not in same_as}
    return Plan(table["kind"], vary, table.get("runs", 0), table.get("seed", 0), same_as=same_as)


def _vary(name: str, content: Mapping[str, Any], units: Units) -> Vary:
    where = f"plan: {name}"
    table = entries(content, where, VARY)
    if "values" in table:
        entries(content, f"{where} of values", {"values": VARY["values"]})
        return Vary(values=tuple(number(f"{where}: values", name, each, units) for each in table["values"]))
    low, high = (number(f"{where}: {key}", name, table.get(key, math.nan), units) for key in ("from", "to"))
    return Vary(low, high, table.get("count", 0), table.get("log", False))


def _scenario(content: Mapping[str, Any]) -> Scenario:
    table = entries(content, "scenario", SCENARIO, ("stop",))
    histories = {
        name: History(**entries(each, f"scenario: {name}", HISTORY))
        for name, each in table.get("inputs", {}).items()
    }
    control = _controller(table["controller"]) if "controller" in table else None
    return Scenario(float(table["stop"]), histories, table.get("step"), table.get("tolerance"), control)


def _controller(content: Mapping[str, Any]) -> Controller:
    table = entries(content, "controller", CONTROLLER, CONTROLLER)
    module, _, function = table["create_law"].partition(":")
    try:
        create_law = getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError, ValueError) as error:
        raise StudyError(
            f"controller: create_law = {table['create_law']!r}: allowed is module:function: {error}"
        ) from error
    return Controller(create_law, table["period"], table["reads"], table["writes"])
