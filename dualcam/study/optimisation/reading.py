"""Optimisations described by TOML files: a plan with a section [optimise], or a design file with
[study.optimise]."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dualcam.library import MODELS
from dualcam.study import description
from dualcam.study.entries import NUMBER, QUANTITY, TABLE, TEXT, WHOLE, entries
from dualcam.study.optimisation.task import Deviation, FmuRuns, Optimisation, Range
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError
from dualcam.study.quantities import Units, fixed, number, units_of_fmu

OPTIMISE = {
    "objectives": TABLE,
    "constraints": TABLE,
    "tolerances": TABLE,
    "start": TABLE,
    "method": TEXT,
    "budget": WHOLE,
    "population": WHOLE,
    "starts": WHOLE,
    "seed": WHOLE,
    "percentile": NUMBER,
    "samples": WHOLE,
    "difference": NUMBER,
}
NUMBERS = ("method", "budget", "population", "starts", "seed", "percentile", "samples", "difference")
CONSTRAINT = {"from": QUANTITY, "to": QUANTITY}
TOLERANCE = {"plus_minus": QUANTITY, "shape": TEXT}
FILE = {name: description.FILE[name] for name in ("fmu", "plan", "scenario", "results", "parameters")} | {
    "optimise": TABLE
}
PLAN = {"vary": TABLE}


def asks_for_optimum(path: Path) -> bool:
    """Whether a file has a section [optimise] or [study.optimise]; False for one that cannot be read."""
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError):
        return False
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
        The file describes no optimisation; all mistakes at once.
    DesignFileError
        The file is a design file with errors.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from dualcam.study import read_optimisation
    >>> text = '''
    ... fmu = "forward"
    ... [plan.vary]
    ... "cam1.lead_angle" = {from = "20 deg", to = "70 deg"}
    ... [scenario]
    ... stop = 0.001
    ... [optimise]
    ... objectives.efficiency = "maximise"
    ... constraints.torque_load = {from = "0.6 N.m"}
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "best.toml"
    ...     _ = path.write_text(text)
    ...     task = read_optimisation(path)
    >>> task.method_used, task.constraints
    ('evolution', {'torque_load': (0.6, None)})
    """
    path = Path(path)
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise StudyError(f"{path} cannot be read as TOML: {error}") from error
    try:
        return _of_design(path) if "study" in content else _of_plan(content, path.parent)
    except StudyError as error:
        raise StudyError(f"{path}: {error}") from error


def _of_plan(content: Mapping[str, Any], folder: Path) -> Optimisation:
    table = entries(content, "the file", FILE, ("fmu", "plan", "scenario", "optimise"))
    fmu = table["fmu"] if table["fmu"] in MODELS else folder / table["fmu"]
    units = units_of_fmu(fmu)
    parameters = fixed(table.get("parameters", {}), units)
    model = FmuRuns(fmu, description._scenario(table["scenario"]), parameters)
    return _task(model, table["plan"], table["optimise"], table.get("results", ()), folder, units)


def _of_design(path: Path) -> Optimisation:
    from dualcam.design_file import read_design

    design = read_design(path)
    if design.scenario is None:
        raise StudyError(
            "an optimisation needs a [scenario]: what is done in each run, for example stop = 1.0"
        )
    study, units = design.study or {}, units_of_fmu(design.model)
    plan = _plan(study["plan"], path.parent, units)
    others = {name: value for name, value in design.parameters_for().items() if name not in plan.names}
    model = FmuRuns(design.model, design.scenario, others)
    start = {name: value for name, value in design.parameters_for().items() if name in plan.vary}
    return _task(
        model,
        study["plan"],
        study["optimise"],
        study.get("results", ()),
        path.parent,
        units,
        start,
    )


def _plan(content: Mapping[str, Any], folder: Path, units: Units) -> Plan:
    table = entries(content, "plan", PLAN, ("vary",))
    return description.read_plan({"kind": "latin", "runs": 1, "vary": table["vary"]}, folder, units)


def _task(
    model: FmuRuns,
    plan_table: Mapping[str, Any],
    content: Mapping[str, Any],
    results: Any,  # noqa: ANN401
    folder: Path,
    units: Units,
    own: Mapping[str, Any] | None = None,
) -> Optimisation:
    plan = _plan(plan_table, folder, units)
    table = entries(content, "optimise", OPTIMISE)
    start = {
        name: number(f"optimise: start: {name}", name, value, units)
        for name, value in entries_of(table, "start", QUANTITY).items()
    }
    inside = {
        name: float(value)
        for name, value in (own or {}).items()
        if plan.vary[name].limits()[0] <= float(value) <= plan.vary[name].limits()[1]
    }
    return Optimisation(
        model,
        plan.vary,
        entries_of(table, "objectives", TEXT),
        {text: _range(text, each, units) for text, each in entries_of(table, "constraints", TABLE).items()},
        start=inside | start,
        tolerances={
            name: _deviation(name, each, units)
            for name, each in entries_of(table, "tolerances", TABLE).items()
        },
        same_as=plan.same_as,
        results=results,
        **{name: table[name] for name in NUMBERS if name in table},
    )


def entries_of(table: Mapping[str, Any], name: str, kind: Any) -> dict[str, Any]:  # noqa: ANN401
    """A table whose keys are free and whose values are of one kind."""
    found = table.get(name, {})
    return dict(entries(found, f"optimise: {name}", dict.fromkeys(found, kind)))


def _range(text: str, content: Mapping[str, Any], units: Units) -> Range:
    where = f"optimise: constraint {text}"
    table = entries(content, where, CONSTRAINT)
    name = text.partition("@")[0]
    least, most = (
        number(f"{where}: {key}", name, table[key], units) if key in table else None for key in ("from", "to")
    )
    return least, most


def _deviation(name: str, content: Mapping[str, Any], units: Units) -> Deviation:
    where = f"optimise: tolerances: {name}"
    table = entries(content, where, TOLERANCE, ("plus_minus",))
    half = number(f"{where}: plus_minus", name, table["plus_minus"], units)
    return Deviation(half, table.get("shape", "normal"))
