"""What concerns many runs is told before the first one: names, types and values that the FMU does not have or
allow, and which share of the runs it would refuse."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dualcam.errors import DualcamWarning, FmuError
from dualcam.handle import unknown_variable
from dualcam.library import source_path
from dualcam.model_description import Kind, Scalar, Variable, read_model_description
from dualcam.study.entries import hint
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError, refuse
from dualcam.study.runner import Job, Runner
from dualcam.study.sampling.formula import formula
from dualcam.study.scenario import Scenario, instants

NUMERIC: tuple[Kind, ...] = ("real", "integer", "boolean")
RUNS_REFUSED = 0.01  # expected number of them, from which on a distribution is refused
LOOKED_AT = 1000  # runs, for what cannot be known of all


@dataclass(frozen=True)
class Variables:
    """The variables of an FMU by name."""

    by_name: Mapping[str, Variable]
    model: str

    @classmethod
    def of_fmu(cls, fmu: str | Path) -> Variables:
        """Those of "forward", "inverse", or of the file of an FMU."""
        description = read_model_description(source_path(fmu))
        return cls({each.name: each for each in description.variables}, description.model_name)

    def variable(self, name: str, *kinds: Kind) -> Variable:
        """The variable. FmuError if there is none of that name, or of these kinds."""
        variable = self.by_name.get(name)
        if variable is None:
            raise FmuError(unknown_variable(name, list(self.by_name), self.model))
        if kinds and variable.kind not in kinds:
            allowed = " or ".join(kind.capitalize() for kind in kinds)
            raise FmuError(f"{name} is {variable.type}: allowed is {allowed}")
        return variable


def check(job: Job, plan: Plan) -> Runner:
    """A runner for the job, made here and now, so that what concerns every run is refused before any.

    StudyError with all that is wrong at once."""
    variables = Variables.of_fmu(job.path)
    refuse(problems_of_study(variables, plan, job.scenario, job.results, job.parameters))
    runner = Runner(job)
    try:
        _check_first_runs(runner, job, plan)
    except BaseException:
        runner.close()
        raise
    return runner


def problems_of_study(
    variables: Variables,
    plan: Plan | None,
    scenario: Scenario | None,
    results: Sequence[str] | None,
    parameters: Mapping[str, Scalar],
) -> list[str]:
    """What of a study the FMU does not have or allow, one text each. A part that is None is left out."""
    problems: list[str] = []
    if plan is not None:
        problems += problems_of_names(plan, scenario, variables.by_name)
        problems += _problems_of_start_values(variables, plan, parameters)
    if results is not None:
        problems += _problems_of_results(variables, results, scenario)
    if scenario is not None:
        taken = [*(plan.names if plan else ()), *parameters]
        problems += _problems_of_inputs(variables, scenario, taken)
    return problems


def _attempt(problems: list[str], function: Callable[..., Any], *arguments: object) -> Any:  # noqa: ANN401
    """What the function gives; None, and a problem more, if the call is refused."""
    try:
        return function(*arguments)
    except FmuError as error:
        problems.append(str(error))
        return None


def problems_of_names(plan: Plan, scenario: Scenario | None, known: Collection[str]) -> list[str]:
    """Names that are no variables of the FMU serve formulas; formulas use names that vary."""
    used = set(scenario.names) if scenario else set()
    for text in [*plan.derived.values(), *plan.constraints.values()]:
        used |= set(formula(text).names)
    found = [
        f"plan: {name} is no variable of the FMU, and no formula uses {name}{hint(name, known)}"
        for name in plan.names
        if name not in known and name not in used
    ]
    for name in scenario.names if scenario else ():
        if name not in plan.names:
            found.append(f"scenario: a formula uses {name}, which does not vary{hint(name, plan.names)}")
        elif name in plan.texts and name not in _law_texts(scenario, plan):
            found.append(f"scenario: a formula uses {name}, which is a text: allowed are numbers")
    return found


def _law_texts(scenario: Scenario | None, plan: Plan) -> set[str]:
    """Texts that the law gets as they are."""
    control = scenario.controller if scenario else None
    return {each for each in control.arguments.values() if each in plan.texts} if control else set()


def _problems_of_start_values(
    variables: Variables, plan: Plan, parameters: Mapping[str, Scalar]
) -> list[str]:
    problems: list[str] = []
    if twice := {name for name in plan.names if plan.names.count(name) > 1}:
        problems.append(f"{', '.join(twice)} is named twice: allowed is once")
    for name in [*(name for name in plan.names if name in variables.by_name), *parameters]:
        variable = _attempt(problems, variables.variable, name)
        if variable is None:
            continue
        if not _is_start_value(variable):
            problems.append(
                f"{name} is {variable.causality}, it cannot be set: allowed are parameters, inputs, and what "
                "starts from a value that is exact"
            )
        elif name in plan.names:
            problems += _problems_of_varied(variable, plan, name in parameters)
    return problems


def _problems_of_varied(variable: Variable, plan: Plan, is_fixed: bool) -> list[str]:
    name = variable.name
    found = [f"{name} varies and is fixed too: allowed is one of them"] if is_fixed else []
    if variable.kind == "string":
        if name not in plan.texts:
            found.append(f'plan: {name} is a String: allowed are values = ["...", "..."]')
        return found
    if name in plan.texts:
        return [*found, f"plan: {name} is {variable.type}: allowed are numbers, given are texts"]
    found += _problem_of_range(variable, plan)
    if variable.kind != "real" and not plan.is_whole(name):
        found.append(f"plan: {name} is {variable.type}: allowed are values = [whole numbers]")
    return found


def _is_start_value(variable: Variable) -> bool:
    """FMI 2.0, section 2.2.7: may be set in initialization mode."""
    exact = variable.initial == "exact" and variable.variability != "constant"
    return exact or variable.causality in ("parameter", "input")


def _problem_of_range(variable: Variable, plan: Plan) -> list[str]:
    """With the share of the runs that the FMU would refuse."""
    name = variable.name
    least = -math.inf if variable.min is None else float(variable.min)
    most = math.inf if variable.max is None else float(variable.max)
    if variable.kind == "boolean":
        least, most = 0.0, 1.0
    share = plan.share_outside(name, least, most)
    source = plan.vary.get(plan.same_as.get(name, name))
    allowed = f"the FMU allows {least:g} to {most:g}"
    if name in plan.derived:
        if share == 0.0:
            return []
        rows = plan.rows(0, 10_000)[:, plan.names.index(name)]
        return [
            f"plan: {name}, derived, is {rows.min():g} to {rows.max():g}: {allowed}; {_percent(share)} of "
            "the runs would be refused. Change the formula, or add a constraint"
        ]
    if source is not None and source.distribution and plan.kind != "table":
        if share * plan.count < RUNS_REFUSED:
            return []
        ends = [("from", least, "-inf"), ("to", most, "inf")]
        give = " and ".join(f"{word} = {end:g}" for word, end, none in ends if f"{end:g}" != none)
        return [
            f"plan: {name}, distribution {source.distribution}: {_percent(share)} of the runs would be "
            f"refused: {allowed}. Truncate: give {give}"
        ]
    low, high = plan.limits()[name]
    if low < least or high > most:
        refused = f"; {_percent(share)} of the runs would be refused" if share > 0.0 else ""
        return [f"plan: {name} from {low:g} to {high:g}: {allowed}{refused}"]
    return []


def _percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"


def _problems_of_results(
    variables: Variables, results: Sequence[str], scenario: Scenario | None
) -> list[str]:
    problems = [] if results else ["the study reads nothing: name at least one result"]
    if twice := {name for name in results if list(results).count(name) > 1}:
        problems.append(f"{', '.join(twice)} is named twice: allowed is once")
    for result in results:
        _attempt(problems, variables.variable, result.partition("@")[0], *NUMERIC)
        if scenario is not None and not isinstance(scenario.stop, str):  # else each run has its own end
            _attempt(problems, instants, [result], scenario.stop)
    return problems


def _problems_of_inputs(variables: Variables, scenario: Scenario, taken: Collection[str]) -> list[str]:
    problems: list[str] = []
    control = scenario.controller
    for name in [*scenario.inputs, *(control.writes if control else ())]:
        variable = _attempt(problems, variables.variable, name, "real")
        if variable is None:
            continue
        if variable.causality != "input":
            problems.append(f"scenario: {name} is {variable.causality}: allowed are inputs")
        if name in taken:
            problems.append(f"{name} has a history and a value of its own: allowed is one of them")
    for name in control.reads if control else ():
        _attempt(problems, variables.variable, name, "real")
    return problems


# ---- what the first runs show ----


def _check_first_runs(runner: Runner, job: Job, plan: Plan) -> None:
    rows = plan.rows(0, LOOKED_AT)
    if job.scenario.names:
        _check_scenarios(runner, rows)
    for name in job.texts:
        if name in runner.columns:
            _check_texts(runner, job, name, rows)


def _check_scenarios(runner: Runner, rows: np.ndarray[Any, Any]) -> None:
    """StudyError if the numbers of no run are a scenario, a warning if some are not."""
    failed = runner.steps.groups(rows)[1]
    if not failed:
        return
    place, text = next(iter(failed.items()))
    if len(failed) == len(rows):
        raise StudyError(f"all of the first {len(rows):,} runs are refused, such as run {place}: {text}")
    share = _percent(len(failed) / len(rows))
    warnings.warn(
        DualcamWarning(f"{share} of the first {len(rows):,} runs are refused, such as run {place}: {text}"),
        stacklevel=5,
    )


def _check_texts(runner: Runner, job: Job, name: str, rows: np.ndarray[Any, Any]) -> None:
    """StudyError with the texts, such as tables, that the FMU refuses in the first run that has them."""
    texts, column = job.texts[name], list(job.names).index(name)
    chosen, first = np.unique(rows[:, column].astype(int), return_index=True)
    messages = runner.run(rows[first]).messages
    refuse(
        [
            f"plan: {name} = {texts[int(chosen[place])]!r}: {text}"
            for place, text in messages.items()
            if name in text
        ]
    )
