"""All that is wrong with an optimisation, at once."""

from __future__ import annotations

import math
from collections.abc import Iterator

from dualcam.common.entries import hint, is_whole
from dualcam.common.mistakes import StudyError
from dualcam.scenario.formula import formula
from dualcam.study.optimisation.fields import TaskFields, is_within
from dualcam.study.optimisation.units import shown, shown_bounds
from dualcam.study.plan.check import problem_of_same
from dualcam.study.run.results_wanted import is_series

METHODS = ("slsqp", "evolution", "nsga2")
DIRECTIONS = ("minimise", "maximise")
WHOLES = {"budget": 1, "population": 0, "starts": 1, "seed": 0, "samples": 2}  # with the least value
LEAST_POPULATION = 5


def problems_of_task(task: TaskFields) -> Iterator[str]:
    """What is wrong with a task, each text with the value and what is allowed."""
    yield from _of_search(task)
    yield from _of_design(task)
    yield from _of_tolerances(task)
    yield from _of_goals(task)
    yield from _of_formulas(task)
    for text in task.results:
        if is_series(text):
            yield f"result {text!r}: a series is not shown: allowed are results with one value"


def _of_search(task: TaskFields) -> Iterator[str]:
    for name, least in WHOLES.items():
        value = getattr(task, name)
        if not (is_whole(value) and value >= least):
            yield f"{name} = {value!r}: allowed is a whole number, {least} or more"
    if is_whole(task.population) and 0 < task.population < LEAST_POPULATION:
        yield f"population = {task.population}: allowed is {LEAST_POPULATION} or more"
    if not 0.0 < task.percentile < 100.0:
        yield f"percentile = {task.percentile:g}: allowed is between 0 and 100 %"
    if not 0.0 < task.difference <= 0.1:
        yield f"difference = {task.difference:g}: allowed is above 0, at most 0.1"
    if task.method and task.method not in METHODS:
        yield f"method = {task.method!r}{hint(task.method, METHODS)}"
    elif len(task.objectives) > 1 and task.method_used != "nsga2":
        yield (
            f"method {task.method} has one objective, here are {len(task.objectives)}: allowed is "
            'method = "nsga2"; or make one formula of them, or limit all but one in constraints'
        )


def _of_design(task: TaskFields) -> Iterator[str]:
    if not task.designed:
        yield "nothing is designed: name at least one variable with bounds in vary"
    for name, vary in task.vary.items():
        problems = vary.problems(in_grid=False)
        yield from (f"{name}: {problem}" for problem in problems)
        if vary.is_list and not vary.distribution and task.method_used == "slsqp":
            yield (
                f"{name} has values to choose from, and slsqp follows gradients: allowed are from and to; or "
                'method = "evolution"'
            )
        start = task.start.get(name)
        if start is not None and name in task.designed and not (problems or is_within(vary, start)):
            yield f"start: {name} = {shown(task, name, start)}: allowed is {shown_bounds(task, name)}"
    for name in task.start:
        if name not in task.designed:
            yield f"start: {name} is not designed{hint(name, task.designed)}"
    for name, other in task.same_as.items():
        problem = problem_of_same(other, task.vary, task.same_as, {})
        if name in task.vary:
            problem = "it varies by itself"
        if problem:
            yield f"{name} is the same as {other}: {problem}"


def _of_tolerances(task: TaskFields) -> Iterator[str]:
    """Parts as made: tolerances and correlations."""
    for name, deviation in task.tolerances.items():
        problems = deviation.problems()
        if name in task.same_as:
            problems.append(f"the same as {task.same_as[name]}: give the tolerance of {task.same_as[name]}")
        if name in task.designed and task.designed[name].is_list:
            problems.append("has values to choose from, which are exact")
        if name in task.chance:
            problems.append("has a distribution: allowed is one of both")
        yield from (f"tolerances: {name}: {problem}" for problem in problems)
    for each in task.correlations:
        designed = [name for name in (each.first, each.second) if name in task.designed]
        problems = [f"{name} is designed: allowed are names with a distribution" for name in designed]
        yield from (f"correlation: {problem}" for problem in problems or each.problems(task.chance))


def _of_goals(task: TaskFields) -> Iterator[str]:
    if not task.objectives:
        yield 'there is no objective: name at least one result, such as "efficiency" = "maximise"'
    for text, direction in task.objectives.items():
        if direction not in DIRECTIONS:
            yield f"{text} = {direction!r}{hint(direction, DIRECTIONS)}"
    for text, (least, most) in task.constraints.items():
        limits = [limit for limit in (least, most) if limit is not None]
        if not limits or not all(math.isfinite(limit) for limit in limits):
            yield f"constraint {text}: allowed are finite limits, at least one"
        elif limits[0] > limits[-1]:
            yield f"constraint {text} from {least:g} to {most:g}: the first must not be above the second"


def _of_formulas(task: TaskFields) -> Iterator[str]:
    texts = [name for name, vary in task.designed.items() if vary.is_list and vary.texts is not None]
    for text in dict.fromkeys([*task.objectives, *task.constraints]):
        try:
            names = formula(text).names
        except StudyError as error:
            yield str(error)
            continue
        if not names:
            yield f"{text!r} is a constant: name a result"
        yield from (f"{text!r} uses {name}, which is a text" for name in names if name in texts)
