"""All that is wrong with an optimisation, at once."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from dualcam.study.checking import is_meant
from dualcam.study.entries import hint, is_whole
from dualcam.study.plan_check import problem_of_same
from dualcam.study.problem import Findings, StudyError
from dualcam.study.sampling.formula import formula

if TYPE_CHECKING:
    from dualcam.study.optimisation.task import Optimisation

METHODS = ("slsqp", "evolution", "nsga2")
DIRECTIONS = ("minimise", "maximise")
WHOLES = {"budget": 1, "population": 0, "starts": 1, "seed": 0, "samples": 2}  # with the least value
LEAST_POPULATION = 5


def check_task(task: Optimisation, findings: Findings) -> None:
    """Notes what is wrong with a task, each message with the value and what is allowed.

    What depends on a place that is not sound is left out. The places are those of a plan."""
    _check_search(task, findings)
    _check_design(task, findings)
    _check_start(task, findings)
    _check_parts(task, findings)
    _check_objectives(task, findings)
    _check_limits(task, findings)
    _check_formulas(task, findings)


def _note(findings: Findings, key: str, text: str, *within: str) -> None:
    findings.note(("optimise", key, *within), f"optimise: {text}")


def _check_search(task: Optimisation, findings: Findings) -> None:
    for name, least in WHOLES.items():
        value = getattr(task, name)
        if findings.is_sound("optimise", name) and not (is_whole(value) and value >= least):
            _note(findings, name, f"{name} = {value!r}: allowed is a whole number, {least} or more")
    if is_whole(task.population) and 0 < task.population < LEAST_POPULATION:
        text = f"population = {task.population}: allowed is {LEAST_POPULATION} or more"
        _note(findings, "population", text)
    if not 0.0 < task.percentile < 100.0:
        _note(findings, "percentile", f"percentile = {task.percentile:g}: allowed is between 0 and 100 %")
    if not 0.0 < task.difference <= 0.1:
        _note(findings, "difference", f"difference = {task.difference:g}: allowed is above 0, at most 0.1")
    if not (findings.is_sound("optimise", "method") and findings.is_sound("optimise", "objectives")):
        return
    if task.method and task.method not in METHODS:
        _note(findings, "method", f"method = {task.method!r}{hint(task.method, METHODS)}")
    elif len(task.objectives) > 1 and task.method_used != "nsga2":
        _note(
            findings,
            "method",
            f"method {task.method} has one objective, here are {len(task.objectives)}: allowed is "
            'method = "nsga2"; or make one formula of them, or limit all but one in constraints',
        )


def _check_design(task: Optimisation, findings: Findings) -> None:
    if not task.designed and findings.is_sound("plan", "vary"):
        text = "optimise: nothing is designed: name at least one variable with bounds in vary"
        findings.note(("plan", "vary"), text)
    for name, vary in task.vary.items():
        place = ("plan", "vary", name)
        if findings.is_sound(*place):
            findings.note(place, *(f"optimise: {name}: {problem}" for problem in vary.problems(False)))
    for name, other in task.same_as.items():
        place = ("plan", "vary", name)
        if not findings.is_sound(*place):
            continue
        problem = (
            "it varies by itself" if name in task.vary else problem_of_same(other, task.vary, task.same_as)
        )
        if problem:
            findings.note(place, f"optimise: {name} is the same as {other}: {problem}")
    if task.method_used != "slsqp" or not findings.is_sound("optimise", "method"):
        return
    for name, vary in task.designed.items():
        if vary.is_list and findings.is_sound("plan", "vary", name):
            text = (
                f"{name} has values to choose from, and slsqp follows gradients: allowed are from and to; or "
                'method = "evolution"'
            )
            _note(findings, "method", text, name)


def _check_start(task: Optimisation, findings: Findings) -> None:
    from dualcam.study.optimisation.shown import shown, shown_bounds
    from dualcam.study.optimisation.task import is_within

    if not findings.is_sound("fmu"):
        return
    for name, value in task.start.items():
        if not findings.is_sound("optimise", "start", name) or is_meant(name, findings):
            continue
        if name not in task.designed:
            _note(findings, "start", f"start: {name} is not designed{hint(name, task.designed)}", name)
        elif findings.is_sound("plan", "vary", name) and not is_within(task.designed[name], value):
            text = f"start: {name} = {shown(task, name, value)}: allowed is {shown_bounds(task, name)}"
            _note(findings, "start", text, name)


def _check_parts(task: Optimisation, findings: Findings) -> None:
    """Parts as made: tolerances and correlations."""
    for name, deviation in task.tolerances.items():
        if not findings.is_sound("optimise", "tolerances", name):
            continue
        problems = deviation.problems()
        if name in task.same_as:
            other = task.same_as[name]
            problems.append(f"the same as {other}: give the tolerance of {other}")
        if name in task.vary and findings.is_sound("plan", "vary", name):
            if task.vary[name].is_list:
                problems.append("has values to choose from, which are exact")
            if name in task.chance:
                problems.append("has a distribution: allowed is one of both")
        for problem in problems:
            _note(findings, "tolerances", f"tolerances: {name}: {problem}", name)
    for number, each in enumerate(task.correlations):
        place = ("plan", "correlation", number)
        if not findings.is_sound(*place):
            continue
        designed = [name for name in (each.first, each.second) if name in task.designed]
        problems = [f"{name} is designed: allowed are names with a distribution" for name in designed]
        if all(findings.is_sound("plan", "vary", name) for name in (each.first, each.second)):
            problems = problems or each.problems(task.chance)
            findings.note(place, *(f"optimise: correlation: {problem}" for problem in problems))


def _check_objectives(task: Optimisation, findings: Findings) -> None:
    if not task.objectives and findings.is_sound("optimise", "objectives"):
        text = 'there is no objective: name at least one result, such as "efficiency" = "maximise"'
        _note(findings, "objectives", text)
    for text, direction in task.objectives.items():
        if direction not in DIRECTIONS and findings.is_sound("optimise", "objectives", text):
            _note(findings, "objectives", f"{text} = {direction!r}{hint(direction, DIRECTIONS)}", text)


def _check_limits(task: Optimisation, findings: Findings) -> None:
    for text, (least, most) in task.constraints.items():
        if not findings.is_sound("optimise", "constraints", text):
            continue
        limits = [limit for limit in (least, most) if limit is not None]
        if not limits or not all(math.isfinite(limit) for limit in limits):
            _note(
                findings, "constraints", f"constraint {text}: allowed are finite limits, at least one", text
            )
        elif least is not None and most is not None and least > most:
            problem = f"from {least:g} to {most:g}: the first must not be above the second"
            _note(findings, "constraints", f"constraint {text} {problem}", text)


def _check_formulas(task: Optimisation, findings: Findings) -> None:
    texts = {name for name, vary in task.designed.items() if vary.texts is not None and vary.is_list}
    for text in dict.fromkeys([*task.objectives, *task.constraints]):
        place = ("optimise", "formulas", text)
        try:
            names = formula(text).names
        except StudyError as error:
            findings.note(place, f"optimise: {error}")
            continue
        if not names:
            findings.note(place, f"optimise: {text!r} is a constant: name a result")
        findings.note(
            place, *(f"optimise: {text!r} uses {name}, which is a text" for name in names if name in texts)
        )
