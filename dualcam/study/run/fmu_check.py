"""What an FMU does not have or allow, and which share of the runs it would refuse: told before the first."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from dualcam.common.entries import hint
from dualcam.common.mistakes import Findings
from dualcam.errors import FmuError
from dualcam.fmi.handle import suitable_value, unknown_variable
from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import Kind, Variable, read_model_description
from dualcam.scenario.formula import formula
from dualcam.scenario.scenario import instants
from dualcam.study.plan.plan import Plan
from dualcam.study.run.runner import Job

NUMERIC: tuple[Kind, ...] = ("real", "integer", "boolean")
RUNS_REFUSED = 0.01  # expected number of them, from which on a distribution is refused
LOOKED_AT = 10_000  # runs, for the range of a derived value


@dataclass(frozen=True)
class Variables:
    """The variables of an FMU by name."""

    by_name: dict[str, Variable]
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


def problems_with_fmu(variables: Variables, plan: Plan, job: Job, used: Collection[str]) -> list[str]:
    """What of a study the FMU does not have or allow. `used`: names in the formulas of results."""
    findings = Findings()
    findings.note(*_of_names(variables, plan, job, used))
    for name in plan.names:
        if name in variables.by_name:
            findings.note(*_of_varied(variables.by_name[name], plan))
    _check_parameters(variables, plan, job, findings)
    _check_results(variables, job, findings)
    _check_inputs(variables, plan, job, findings)
    return findings.problems


def _of_names(variables: Variables, plan: Plan, job: Job, used: Collection[str]) -> Iterator[str]:
    """Names that are no variables of the FMU serve formulas; formulas use names that vary."""
    scenario = job.scenario
    inner = [formula(text) for text in [*plan.derived.values(), *plan.constraints.values()]]
    known = {*variables.by_name, *used, *scenario.names, *(name for each in inner for name in each.names)}
    missing = [name for name in scenario.names if name not in plan.names]
    unknown = [name for name in plan.names if name not in known]
    for name in unknown:
        near = hint(name, [*missing, *variables.by_name])
        yield f"plan: {name} is no variable of the FMU, and no formula uses {name}{near}"
    control = scenario.controller
    for_law = set(control.arguments.values()) if control else set()
    for name in scenario.names:
        if name in missing and not get_close_matches(name, unknown, n=1, cutoff=0.6):
            yield f"scenario: a formula uses {name}, which does not vary{hint(name, plan.names)}"
        elif name in plan.texts and name not in for_law:
            yield f"scenario: a formula uses {name}, which is a text: allowed are numbers"


def _problem_of_start(variable: Variable) -> list[str]:
    """Why a variable has no start value. FMI 2.0, section 2.2.7: may be set in initialization mode."""
    exact = variable.initial == "exact" and variable.variability != "constant"
    if exact or variable.causality in ("parameter", "input"):
        return []
    allowed = "parameters, inputs, and what starts from a value that is exact"
    return [f"{variable.name} is {variable.causality}, it cannot be set: allowed are {allowed}"]


def _of_varied(variable: Variable, plan: Plan) -> list[str]:
    name = variable.name
    if problem := _problem_of_start(variable):
        return problem
    if variable.kind == "string":
        needed = f'plan: {name} is a String: allowed are values = ["...", "..."]'
        return [] if name in plan.texts else [needed]
    if name in plan.texts:
        return [f"plan: {name} is {variable.type}: allowed are numbers, given are texts"]
    found = _of_range(variable, plan)
    if variable.kind != "real" and not _is_whole(plan, name):
        found.append(f"plan: {name} is {variable.type}: allowed are values = [whole numbers]")
    return found


def _is_whole(plan: Plan, name: str) -> bool:
    """Whether a name gets whole numbers only."""
    source = plan.same_as.get(name, name)
    if source in plan.vary and plan.kind != "table":
        return plan.vary[source].is_whole
    values = plan.rows(0, LOOKED_AT)[:, plan.names.index(name)]
    return bool(np.all(values == np.round(values)))


def _range(variable: Variable) -> tuple[float, float]:
    """Least and greatest value that the FMU allows."""
    if variable.kind == "boolean":
        return 0.0, 1.0
    least = -math.inf if variable.min is None else float(variable.min)
    return least, math.inf if variable.max is None else float(variable.max)


def _of_range(variable: Variable, plan: Plan) -> list[str]:
    """With the share of the runs that the FMU would refuse."""
    name = variable.name
    least, most = _range(variable)
    allowed = f"the FMU allows {least:g} to {most:g}"
    share = plan.share_outside(name, least, most)
    refused = f"{percent(share)} of the runs would be refused"
    source = plan.vary.get(plan.same_as.get(name, name))
    if name in plan.derived:
        if share == 0.0:
            return []
        values = plan.rows(0, LOOKED_AT)[:, plan.names.index(name)]
        found = f"plan: {name}, derived, is {values.min():g} to {values.max():g}: {allowed}; {refused}"
        return [f"{found}. Change the formula, or add a constraint"]
    if source is not None and source.distribution and plan.kind != "table":
        if share * plan.count < RUNS_REFUSED:
            return []
        ends = (("from", least), ("to", most))
        give = " and ".join(f"{word} = {end:g}" for word, end in ends if math.isfinite(end))
        found = f"plan: {name}, distribution {source.distribution}: {refused}: {allowed}"
        return [f"{found}. Truncate: give {give}"]
    low, high = plan.limits()[name]
    if low < least or high > most:
        return [f"plan: {name} from {low:g} to {high:g}: {allowed}{f'; {refused}' if share > 0.0 else ''}"]
    return []


def percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"


def _check_parameters(variables: Variables, plan: Plan, job: Job, findings: Findings) -> None:
    for name, value in job.parameters.items():
        variable = findings.attempt(variables.variable, name)
        if variable is None:
            continue
        if name in plan.names:
            findings.note(f"{name} varies and is fixed too: allowed is one of them")
        elif problem := _problem_of_start(variable):
            findings.note(*problem)
        else:
            number = findings.attempt(suitable_value, variable, value)
            least, most = _range(variable)
            if number is not None and not isinstance(number, str) and not least <= float(number) <= most:
                findings.note(f"parameters: {name} = {value}: the FMU allows {least:g} to {most:g}")


def _check_results(variables: Variables, job: Job, findings: Findings) -> None:
    if not job.results:
        findings.note("the study reads nothing: name at least one result")
    for name in dict.fromkeys(result.partition("@")[0] for result in job.results):
        findings.attempt(variables.variable, name, *NUMERIC)
    stop = math.inf if isinstance(job.scenario.stop, str) else job.scenario.stop
    for result in job.results:
        findings.attempt(instants, [result], stop)


def _check_inputs(variables: Variables, plan: Plan, job: Job, findings: Findings) -> None:
    control = job.scenario.controller
    for name in [*job.scenario.inputs, *(control.writes if control else ())]:
        variable = findings.attempt(variables.variable, name, "real")
        if variable is None:
            continue
        if variable.causality != "input":
            findings.note(f"scenario: {name} is {variable.causality}: allowed are inputs")
        if name in (*plan.names, *job.parameters):
            findings.note(f"{name} has a history and a value of its own: allowed is one of them")
    for name in control.reads if control else ():
        findings.attempt(variables.variable, name, "real")
