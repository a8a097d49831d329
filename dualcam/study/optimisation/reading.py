"""Optimisations described by TOML files: a plan with a section [optimise], or a design file with
[study.optimise]."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from dualcam.library import MODELS
from dualcam.model_description import Scalar
from dualcam.study.checking import Variables, problems_of_study
from dualcam.study.entries import (
    NUMBER,
    QUANTITIES_BY_NAME,
    QUANTITY,
    TABLE,
    TEXT,
    WHOLE,
    Kind,
    entries,
    hint,
)
from dualcam.study.optimisation.formula import result_formula
from dualcam.study.optimisation.task import Deviation, FmuRuns, Optimisation, Range
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError, refuse
from dualcam.study.quantities import Units, fixed, number, units_of_fmu
from dualcam.study.reading import Reading
from dualcam.study.scenario import Scenario

TEXTS_BY_NAME = Kind(
    "a table of texts",
    lambda value: isinstance(value, Mapping) and all(isinstance(each, str) for each in value.values()),
)
OPTIMISE = {
    "objectives": TEXTS_BY_NAME,
    "constraints": TABLE,
    "tolerances": TABLE,
    "start": QUANTITIES_BY_NAME,
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
STUDY = {name: FILE[name] for name in ("plan", "scenario", "results", "plots", "optimise")}
ARRANGEMENT = ("kind", "runs", "seed", "levels", "second_order", "on_violation")  # of the runs of a study
REST = Scenario(1.0)  # instead of one that is refused, so that the rest can be checked


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
    return _of_design(path) if "study" in content else _of_plan(path, content)


def _of_plan(path: Path, content: Mapping[str, Any]) -> Optimisation:
    table = entries(content, "the file", FILE, ("fmu", "plan", "scenario", "optimise"))
    fmu = table["fmu"] if table["fmu"] in MODELS else path.parent / table["fmu"]
    reading = _Reading(path, fmu)
    scenario = reading.scenario_of(table["scenario"])
    parameters = reading.attempt(fixed, table.get("parameters", {}), reading.units)
    return reading.whole(table, scenario, parameters or {})


def _of_design(path: Path) -> Optimisation:
    from dualcam.design_file import read_design

    design = read_design(path)
    study = entries(design.study, "study", STUDY, ("plan", "optimise"))
    reading = _Reading(path, design.model)
    scenario = design.scenario
    if "scenario" in study:
        scenario = reading.scenario_of(study["scenario"])
    elif scenario is None:
        reading.note(["an optimisation needs a [scenario]: what is done in each run, such as stop = 1.0"])
    return reading.whole(study, scenario, design.parameters_for())


class _Reading(Reading):
    """One reading of a file. What is refused is left out, and the rest is read on."""

    def __init__(self, path: Path, fmu: str | Path) -> None:
        super().__init__(path.parent)
        self._path, self._fmu = path, fmu
        self.units = units_of_fmu(fmu)

    def whole(
        self, table: Mapping[str, Any], scenario: Scenario | None, parameters: Mapping[str, Scalar]
    ) -> Optimisation:
        """The optimisation of all parts. StudyError with all mistakes, also names that the FMU has not."""
        plan = self._plan_of(table["plan"])
        goals = self._goals(table["optimise"])
        results = table.get("results", ())
        task: Optimisation | None = None
        if plan is not None:
            model = FmuRuns(self._fmu, scenario or REST, parameters, plan.derived, plan.constraints)
            task = self.attempt(_task, model, plan, goals, results)
        names = plan.names if plan else ()
        others = {name: value for name, value in parameters.items() if name not in names}
        read = task.read if task else [*results, *_results_in(goals["objectives"], names)]
        self.note(problems_of_study(Variables.of_fmu(self._fmu), plan, scenario, read, others))
        refuse(self.problems, str(self._path))
        assert task is not None
        return task

    def scenario_of(self, content: Mapping[str, Any]) -> Scenario | None:
        """The scenario of a table."""
        from dualcam.study.schema import SCENARIO  # loads pydantic

        table = self.validated(SCENARIO, content, "scenario", ("scenario",))
        return self.scenario(table, self.units)

    def _plan_of(self, content: Mapping[str, Any]) -> Plan | None:
        """What varies. A plan of any kind will do: how its runs are arranged does not matter here."""
        from dualcam.study.schema import PLAN

        if "table" in content:
            self.note(["a plan of a table has no bounds: an optimisation needs plan.vary"])
            return None
        table = self.validated(PLAN, content, "plan", ("plan",))
        kept = {name: value for name, value in table.items() if name not in ARRANGEMENT}
        return self.plan(kept | {"kind": "latin", "runs": 1}, self.units)

    def _goals(self, content: Mapping[str, Any]) -> dict[str, Any]:
        """Arguments of Optimisation."""
        unknown = [key for key in content if key not in OPTIMISE]
        self.note([f"optimise has {key}{hint(key, OPTIMISE)}" for key in unknown])
        wrong = {key for key in content if key in OPTIMISE and not OPTIMISE[key].suits(content[key])}
        self.note(
            [f"optimise: {key} = {content[key]!r}: allowed is {OPTIMISE[key].words}" for key in sorted(wrong)]
        )
        table = {key: value for key, value in content.items() if key in OPTIMISE and key not in wrong}
        found: dict[str, Any] = {name: table[name] for name in NUMBERS if name in table}
        found["objectives"] = table.get("objectives", {})
        for part, read in PARTS.items():
            made = {
                name: self.attempt(read, name, value, self.units)
                for name, value in table.get(part, {}).items()
            }
            found[part] = {name: value for name, value in made.items() if value is not None}
        return found


def _results_in(texts: Iterable[str], varied: Collection[str]) -> list[str]:
    """Results in formulas, of which those that are none are told elsewhere."""
    found: list[str] = []
    for text in texts:
        with suppress(StudyError):
            found += [name for name in result_formula(text).names if name not in varied]
    return found


def _task(model: FmuRuns, plan: Plan, goals: Mapping[str, Any], results: Any) -> Optimisation:  # noqa: ANN401
    return Optimisation(
        model, plan.vary, same_as=plan.same_as, correlations=plan.correlations, results=results, **goals
    )


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


PARTS: dict[str, Callable[..., Any]] = {
    "constraints": _range,
    "tolerances": _deviation,
    "start": _start,
}
