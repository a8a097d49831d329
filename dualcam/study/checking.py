"""What concerns many runs is told before the first one: names, types and values that the FMU does not have or
allow, and which share of the runs it would refuse."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from dualcam.errors import FmuError
from dualcam.fmi.handle import suitable_value, unknown_variable
from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import Kind, Scalar, Variable, read_model_description
from dualcam.study.entries import hint
from dualcam.study.plan import Plan
from dualcam.study.problem import Findings, Place
from dualcam.study.sampling.formula import CONSTANTS, formula, is_formula
from dualcam.study.scenario import Scenario, instants
from dualcam.study.sound_plan import names_known, place_of, sound_plan

NUMERIC: tuple[Kind, ...] = ("real", "integer", "boolean")
RUNS_REFUSED = 0.01  # expected number of them, from which on a distribution is refused
WITH_FORMULAS: tuple[Place, ...] = (
    ("plan", "derived"),
    ("plan", "constraints"),
    ("scenario", "stop"),
    ("scenario", "step"),
    ("scenario", "inputs"),
    ("scenario", "controller"),
)
LOOKED_AT = 10_000  # runs, for the range of a derived value


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


@dataclass(frozen=True)
class Parts:
    """The parts of a study, of which some may be refused; None for one that is missing.

    Attributes
    ----------
    plan, scenario
        May be unchecked.
    results
        What the FMU is asked for.
    parameters
        Start values that are the same in each run.
    used
        Names that other formulas use, such as those of results.
    """

    plan: Plan | None
    scenario: Scenario | None
    results: Sequence[str] | None
    parameters: Mapping[str, Scalar]
    used: Collection[str] = ()


def check_parts(variables: Variables, parts: Parts, findings: Findings) -> None:
    """Notes what of a study the FMU does not have or allow."""
    if parts.plan is not None:
        check_names(parts, variables.by_name, findings)
        _check_start_values(variables, parts.plan, findings)
    _check_parameters(variables, parts, findings)
    if parts.results is not None:
        _check_results(variables, parts.results, parts.scenario, findings)
    if parts.scenario is not None:
        _check_inputs(variables, parts, parts.scenario, findings)


# ---- names ----


def check_names(parts: Parts, known: Collection[str] | None, findings: Findings) -> None:
    """Names that are no variables of the FMU serve formulas; formulas use names that vary.

    `known`: the names of the FMU's variables; None: they are not known."""
    plan, scenario = parts.plan, parts.scenario
    if plan is None:
        return
    used = {*parts.used, *names_used(plan, scenario), *CONSTANTS}
    for name in plan.names:
        if known is None or name in known or name in used or _may_be_used(name, known, findings):
            continue
        referred = names_used(plan, scenario, with_references=True)
        nearest = [other for other in referred if is_meant(other, findings)]
        findings.note(
            place_of(plan, name),
            f"plan: {name} is no variable of the FMU, and no formula uses {name}"
            f"{hint(name, [*nearest, *known])}",
        )
    for name in scenario.names if scenario else ():
        if name not in plan.names:
            text = f"scenario: a formula uses {name}, which does not vary{hint(name, plan.names)}"
            findings.note(("scenario", "formulas", name), text)
        elif name in plan.texts and name not in _law_texts(scenario, plan):
            text = f"scenario: a formula uses {name}, which is a text: allowed are numbers"
            findings.note(("scenario", "formulas", name), text)


def _may_be_used(name: str, known: Collection[str], findings: Findings) -> bool:
    """Whether a name stands for another one; or where something with formulas is refused, which may use the
    name, unless the name is near that of a variable."""
    if is_meant(name, findings):
        return True
    is_whole = all(findings.is_sound(*place) for place in WITH_FORMULAS) and findings.is_told("scenario")
    return not is_whole and not get_close_matches(name, known, n=1, cutoff=0.6)


def is_meant(name: str, findings: Findings) -> bool:
    """Whether a name stands for one that the plan spells in another way."""
    return not findings.is_sound("meant", name)


def names_used(plan: Plan, scenario: Scenario | None, with_references: bool = False) -> set[str]:
    """Names in formulas of the plan and of the scenario; `with_references` also those of `same_as` and of
    correlations."""
    used = set(scenario.names) if scenario else set()
    for text in [*plan.derived.values(), *plan.constraints.values()]:
        used |= set(formula(text).names) if is_formula(text) else set()
    if with_references:
        used |= set(plan.same_as.values())
        used |= {name for each in plan.correlations for name in (each.first, each.second)}
    return used


def _law_texts(scenario: Scenario | None, plan: Plan) -> set[str]:
    """Texts that the law gets as they are."""
    control = scenario.controller if scenario else None
    return {each for each in control.arguments.values() if each in plan.texts} if control else set()


# ---- values ----


def _check_start_values(variables: Variables, plan: Plan, findings: Findings) -> None:
    rest = sound_plan(plan, findings)
    for name in plan.names:
        if name not in variables.by_name or rest is None or not names_known(plan, [name], findings):
            continue
        variable = variables.by_name[name]
        if not _is_start_value(variable):
            problems = [_not_set(variable)]
        else:
            problems = _problems_of_varied(variable, rest, plan, findings)
        findings.note(place_of(plan, name), *problems)


def _not_set(variable: Variable) -> str:
    return (
        f"{variable.name} is {variable.causality}, it cannot be set: allowed are parameters, inputs, and "
        "what starts from a value that is exact"
    )


def _is_start_value(variable: Variable) -> bool:
    """FMI 2.0, section 2.2.7: may be set in initialization mode."""
    exact = variable.initial == "exact" and variable.variability != "constant"
    return exact or variable.causality in ("parameter", "input")


def _problems_of_varied(variable: Variable, rest: Plan, plan: Plan, findings: Findings) -> list[str]:
    """`rest` is what is sound of the plan."""
    name = variable.name
    if variable.kind == "string":
        given = [] if name in rest.texts else ['allowed are values = ["...", "..."]']
        return [f"plan: {name} is a String: {text}" for text in given]
    if name in rest.texts:
        return [f"plan: {name} is {variable.type}: allowed are numbers, given are texts"]
    found = _problem_of_range(variable, rest, rest is plan, findings)
    if variable.kind != "real" and not rest.is_whole(name):
        found.append(f"plan: {name} is {variable.type}: allowed are values = [whole numbers]")
    return found


def _range(variable: Variable) -> tuple[float, float]:
    """Least and greatest value that the FMU allows."""
    if variable.kind == "boolean":
        return 0.0, 1.0
    least = -math.inf if variable.min is None else float(variable.min)
    return least, math.inf if variable.max is None else float(variable.max)


def _problem_of_range(variable: Variable, plan: Plan, is_whole: bool, findings: Findings) -> list[str]:
    """With the share of the runs that the FMU would refuse. `is_whole`: nothing of the plan is refused."""
    name = variable.name
    least, most = _range(variable)
    allowed = f"the FMU allows {least:g} to {most:g}"
    if name in plan.derived:
        return _problem_of_derived(plan, name, (least, most), is_whole)
    share = plan.share_outside(name, least, most)
    source = plan.vary.get(plan.same_as.get(name, name))
    if source is not None and source.distribution and plan.kind != "table":
        is_counted = findings.is_sound("plan", "runs") and findings.is_sound("plan", "kind")
        if share * (plan.count if is_counted else 1) < RUNS_REFUSED:
            return []
        ends = [("from", least, "-inf"), ("to", most, "inf")]
        give = " and ".join(f"{word} = {end:g}" for word, end, none in ends if f"{end:g}" != none)
        return [
            f"plan: {name}, distribution {source.distribution}: {percent(share)} of the runs would be "
            f"refused: {allowed}. Truncate: give {give}"
        ]
    low, high = plan.limits()[name]
    if low < least or high > most:
        refused = f"; {percent(share)} of the runs would be refused" if share > 0.0 else ""
        return [f"plan: {name} from {low:g} to {high:g}: {allowed}{refused}"]
    return []


def _problem_of_derived(plan: Plan, name: str, allowed: tuple[float, float], is_whole: bool) -> list[str]:
    """Where parts of the plan are refused, a derived value is wrong if it is so in each run."""
    share = plan.share_outside(name, *allowed)
    if share == 0.0 or not (is_whole or share == 1.0):
        return []
    values = plan.rows(0, LOOKED_AT)[:, plan.names.index(name)]
    return [
        f"plan: {name}, derived, is {values.min():g} to {values.max():g}: the FMU allows {allowed[0]:g} to "
        f"{allowed[1]:g}; {percent(share)} of the runs would be refused. Change the formula, or add a "
        "constraint"
    ]


def percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"


def _check_parameters(variables: Variables, parts: Parts, findings: Findings) -> None:
    varied = parts.plan.names if parts.plan else ()
    for name, value in parts.parameters.items():
        place = ("parameters", name)
        variable = findings.attempt(place, variables.variable, name)
        if variable is None:
            continue
        if name in varied and not is_meant(name, findings):
            findings.note(place, f"{name} varies and is fixed too: allowed is one of them")
        if not _is_start_value(variable):
            findings.note(place, _not_set(variable))
        elif findings.is_sound(*place):
            _check_value(variable, value, findings)


def _check_value(variable: Variable, value: Scalar, findings: Findings) -> None:
    place = ("parameters", variable.name)
    number = findings.attempt(place, suitable_value, variable, value)
    least, most = _range(variable)
    if number is not None and not isinstance(number, str) and not least <= float(number) <= most:
        text = f"parameters: {variable.name} = {value}: the FMU allows {least:g} to {most:g}"
        findings.note(place, text)


# ---- results and inputs ----


def _check_results(
    variables: Variables, results: Sequence[str], scenario: Scenario | None, findings: Findings
) -> None:
    if not results and findings.is_sound("results"):
        findings.note(("results",), "the study reads nothing: name at least one result")
    for name in dict.fromkeys(result.partition("@")[0] for result in results):
        findings.attempt(("results",), variables.variable, name, *NUMERIC)
    is_known = scenario is not None and findings.is_sound("scenario", "stop")
    stop = scenario.stop if scenario is not None and is_known else math.inf
    for result in results:
        findings.attempt(("results",), instants, [result], math.inf if isinstance(stop, str) else stop)


def _check_inputs(variables: Variables, parts: Parts, scenario: Scenario, findings: Findings) -> None:
    taken = [*(parts.plan.names if parts.plan else ()), *parts.parameters]
    control = scenario.controller
    places = {name: ("scenario", "inputs", name) for name in scenario.inputs}
    places |= {name: ("scenario", "controller", "writes") for name in (control.writes if control else ())}
    for name, place in places.items():
        variable = findings.attempt(place, variables.variable, name, "real")
        if variable is None:
            continue
        if variable.causality != "input":
            findings.note(place, f"scenario: {name} is {variable.causality}: allowed are inputs")
        if name in taken and not is_meant(name, findings):
            findings.note(place, f"{name} has a history and a value of its own: allowed is one of them")
    for name in control.reads if control else ():
        findings.attempt(("scenario", "controller", "reads"), variables.variable, name, "real")
