"""Optimisations described by TOML files: a plan with a section [optimise], or a design file with
[study.optimise]."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from dualcam.library import MODELS
from dualcam.study.entries import NUMBER, QUANTITY, TABLE, TEXT, WHOLE, Kind, entries
from dualcam.study.optimisation.task import Deviation, FmuRuns, Optimisation, Range
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError, refuse
from dualcam.study.quantities import Units, fixed, number, units_of_fmu
from dualcam.study.reading import read_plan, read_scenario

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
LISTS = Kind("a list of tables", lambda value: isinstance(value, list))
CONSTRAINT = {"from": QUANTITY, "to": QUANTITY}
TOLERANCE = {"plus_minus": QUANTITY, "shape": TEXT}
FILE = {
    "fmu": TEXT,
    "plan": TABLE,
    "scenario": TABLE,
    "results": TEXT.listed(),
    "parameters": TABLE,
    "plots": LISTS,
    "optimise": TABLE,
}
STUDY = {name: FILE[name] for name in ("plan", "results", "plots", "optimise")}
ARRANGEMENT = ("kind", "runs", "seed", "levels", "second_order", "on_violation")  # of the runs of a study
T = TypeVar("T")


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
    pieces = _Pieces()
    scenario = pieces.read(read_scenario, table["scenario"], folder, units)
    parameters = pieces.read(fixed, table.get("parameters", {}), units)
    plan = pieces.read(_plan, table["plan"], folder, units)
    goals = pieces.read(_goals, table["optimise"], units)
    if scenario is not None and parameters is not None and plan is not None and goals is not None:
        model = FmuRuns(fmu, scenario, parameters, plan.derived, plan.constraints)
        return _task(model, plan, goals, table.get("results", ()))
    raise pieces.error()


def _of_design(path: Path) -> Optimisation:
    from dualcam.design_file import read_design

    design = read_design(path)
    if design.scenario is None:
        raise StudyError(
            "an optimisation needs a [scenario]: what is done in each run, for example stop = 1.0"
        )
    study = entries(design.study, "study", STUDY, ("plan", "optimise"))
    units, pieces = units_of_fmu(design.model), _Pieces()
    plan = pieces.read(_plan, study["plan"], path.parent, units)
    goals = pieces.read(_goals, study["optimise"], units)
    if plan is not None and goals is not None:
        parameters = design.parameters_for()
        model = FmuRuns(design.model, design.scenario, parameters, plan.derived, plan.constraints)
        return _task(model, plan, goals, study.get("results", ()))
    raise pieces.error()


class _Pieces:
    """Parts of a file that are read one by one, so that all mistakes are told at once."""

    def __init__(self) -> None:
        self._problems: list[str] = []

    def read(self, function: Callable[..., T], *arguments: object) -> T | None:
        """What the function gives; None if the part has mistakes."""
        try:
            return function(*arguments)
        except StudyError as error:
            self._problems += error.problems
            return None

    def error(self) -> StudyError:
        """All mistakes so far."""
        try:
            refuse(self._problems)
        except StudyError as error:
            return error
        raise AssertionError("no part was refused")


def _plan(content: Mapping[str, Any], folder: Path, units: Units) -> Plan:
    """What varies. A plan of another kind will do: how its runs are arranged does not matter here."""
    table = {name: value for name, value in content.items() if name not in ARRANGEMENT}
    if "table" in table:
        raise StudyError("a plan of a table has no bounds: an optimisation needs plan.vary")
    return read_plan(table | {"kind": "latin", "runs": 1}, folder, units)


def _goals(content: Mapping[str, Any], units: Units) -> dict[str, Any]:
    """Arguments of Optimisation."""
    table = entries(content, "optimise", OPTIMISE)
    pieces = _Pieces()
    found: dict[str, Any] = {name: table[name] for name in NUMBERS if name in table}
    found["objectives"] = pieces.read(_free, table, "objectives", TEXT)
    for part, (kind, read) in PARTS.items():
        given = pieces.read(_free, table, part, kind)
        found[part] = {name: pieces.read(read, name, value, units) for name, value in (given or {}).items()}
    if pieces._problems:
        raise pieces.error()
    return found


def _task(model: FmuRuns, plan: Plan, goals: Mapping[str, Any], results: Any) -> Optimisation:  # noqa: ANN401
    return Optimisation(
        model, plan.vary, same_as=plan.same_as, correlations=plan.correlations, results=results, **goals
    )


def _free(table: Mapping[str, Any], part: str, kind: Kind) -> dict[str, Any]:
    """A table whose keys are free and whose values are of one kind."""
    found = table.get(part, {})
    return dict(entries(found, f"optimise: {part}", dict.fromkeys(found, kind)))


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


def _start(name: str, value: float | str, units: Units) -> float | str:
    if units().get(name) is None:  # a text to choose from, or a whole number
        return value
    return number(f"optimise: start: {name}", name, value, units)


PARTS: dict[str, tuple[Kind, Callable[..., Any]]] = {
    "constraints": (TABLE, _range),
    "tolerances": (TABLE, _deviation),
    "start": (QUANTITY, _start),
}
