"""What is to be optimised, what is wrong with that, and its values in the units of its file."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from dualcam.common.entries import hint, is_whole
from dualcam.common.mistakes import StudyError, refuse
from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import read_model_description
from dualcam.scenario.formula import Formula, formula
from dualcam.study.optimisation.designs import Deviation, FmuRuns, Function, Range, choices, is_within
from dualcam.study.plan.correlation import Correlation
from dualcam.study.plan.fields import problem_of_same
from dualcam.study.plan.vary import Vary
from dualcam.study.run.readings import column_of, is_series

METHODS = ("slsqp", "evolution", "nsga2")
DIRECTIONS = ("minimise", "maximise")
WHOLES = {"budget": 1, "population": 0, "starts": 1, "seed": 0, "samples": 2}  # with the least value
LEAST_POPULATION = 5
DIGITS = 6
# Of the search, as files and records have them.
NUMBERS = ("method", "budget", "population", "starts", "seed", "percentile", "samples", "difference")


@dataclass(frozen=True)
class Optimisation:
    """The search for the best design.

    Parameters
    ----------
    model : FmuRuns or callable
        Runs of an FMU; or a function of a module that gets one design, a dict of values by name, and returns
        results by name. What the function refuses with a DualcamError is no design.
    vary : mapping of str to Vary
        What is designed: bounds, or values to choose from. What has a distribution is not chosen but happens,
        differently in each part as made.
    objectives : "minimise" or "maximise" for each result, or formula over results and varied values.
    constraints : Least and greatest value of results or formulas; None: no limit on this side.
    method : {"slsqp", "evolution", "nsga2"}, optional
        SLSQP with gradients, differential evolution, or NSGA-II, which is the one for several objectives.
        Default: "evolution" for one objective, "nsga2" for several.
    budget : Most designs that are evaluated, those for gradients included.
    population : Designs in a generation. Default: ten for each varied value, at least 20 and at most 100.
    starts : Of "slsqp": searches from different designs.
    start : Design with which the search begins. Default: the model's own, else the middle of the bounds.
    seed : Start of the random numbers, 0 or more.
    tolerances : mapping of str to Deviation
        Of varied values and of fixed ones. With these, and with distributions in `vary`, an objective is a
        percentile over parts as made.
    percentile : Share of the parts [%] that are as good as the objective says, and keep each constraint.
    samples : Parts made of each design; all designs have the same deviations.
    difference : Step of the gradients' differences, as a share of the bounds' distance.
    same_as : Variables that get the value of another one, which varies.
    correlations : Of what has a distribution.
    results : sequence of str
        Results to be shown beside those in objectives and constraints, as those of `Study` but for series;
        objectives and constraints may use their names.
    units : mapping of str to str
        Units in which the command and its messages show values, by the name or by the text of a constraint;
        without one the FMU's unit.

    Raises
    ------
    StudyError
        All that is wrong, at once.

    Examples
    --------
    >>> from dualcam.study import FmuRuns, Optimisation, Scenario, Vary
    >>> angles = {"cam1.lead_angle": Vary(0.4, 1.2), "cam2.lead_angle": Vary(0.4, 1.2)}
    >>> task = Optimisation(FmuRuns("forward", Scenario(0.001)), angles, {"efficiency": "maximise"})
    >>> task.method_used
    'evolution'
    """

    model: FmuRuns | Function
    vary: Mapping[str, Vary]
    objectives: Mapping[str, str]
    constraints: Mapping[str, Range] = field(default_factory=dict)
    method: str = ""
    budget: int = 2000
    population: int = 0
    starts: int = 4
    start: Mapping[str, float | str] = field(default_factory=dict)
    seed: int = 0
    tolerances: Mapping[str, Deviation] = field(default_factory=dict)
    percentile: float = 95.0
    samples: int = 64
    difference: float = 1e-3
    same_as: Mapping[str, str] = field(default_factory=dict)
    correlations: Sequence[Correlation] = ()
    results: Sequence[str] = ()
    units: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        refuse(f"optimise: {problem}" for problem in problems_of_task(self))

    @cached_property
    def designed(self) -> dict[str, Vary]:
        """What is chosen."""
        return {name: vary for name, vary in self.vary.items() if not vary.distribution}

    @cached_property
    def chance(self) -> dict[str, Vary]:
        """What happens."""
        return {name: vary for name, vary in self.vary.items() if vary.distribution}

    @property
    def is_robust(self) -> bool:
        """Whether parts as made differ from their design."""
        return bool(self.chance or self.tolerances)

    @property
    def method_used(self) -> str:
        """The method, if none was named the one for this number of objectives."""
        return self.method or ("evolution" if len(self.objectives) == 1 else "nsga2")

    @property
    def signs(self) -> list[float]:
        """Of each objective: 1 where less is better, else -1."""
        return [1.0 if way == "minimise" else -1.0 for way in self.objectives.values()]

    @property
    def population_used(self) -> int:
        """Designs in a generation."""
        return min(self.population or min(max(10 * len(self.designed), 20), 100), self.budget)

    @cached_property
    def formulas(self) -> dict[str, Formula]:
        """Those of objectives and constraints by their text."""
        return {text: formula(text) for text in [*self.objectives, *self.constraints]}

    @cached_property
    def fmu_units(self) -> dict[str, str]:
        """Unit by variable of the FMU, without "1"; nothing is known of a function."""
        if not isinstance(self.model, FmuRuns):
            return {}
        variables = read_model_description(source_path(self.model.fmu)).variables
        return {each.name: each.unit for each in variables if each.unit and each.unit != "1"}

    @cached_property
    def read(self) -> list[str]:
        """What is read of the model: variables in formulas, then the results that are shown."""
        derived = self.model.derived if isinstance(self.model, FmuRuns) else {}
        known = {*self.vary, *self.same_as, *derived, *map(column_of, self.results)}
        wanted = [name for each in self.formulas.values() for name in each.names if name not in known]
        return list(dict.fromkeys([*wanted, *self.results]))

    @property
    def columns(self) -> list[str]:
        """The names of what is read."""
        return [column_of(text) for text in self.read]


# ---- checks ----


def problems_of_task(task: Optimisation) -> Iterator[str]:
    """What is wrong with a task, each text with the value and what is allowed."""
    yield from _of_search(task)
    yield from _of_design(task)
    yield from _of_tolerances(task)
    yield from _of_goals(task)
    yield from _of_formulas(task)
    for text in filter(is_series, task.results):
        yield f"result {text!r}: a series is not shown: allowed are results with one value"


def _of_search(task: Optimisation) -> Iterator[str]:
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
        found = f"method {task.method} has one objective, here are {len(task.objectives)}"
        remedy = "or make one formula of them, or limit all but one in constraints"
        yield f'{found}: allowed is method = "nsga2"; {remedy}'


def _of_design(task: Optimisation) -> Iterator[str]:
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
            yield f"start: {name} = {in_words(task, name, start)}: allowed is {bounds_in_words(task, name)}"
    for name in task.start:
        if name not in task.designed:
            yield f"start: {name} is not designed{hint(name, task.designed)}"
    for name, other in task.same_as.items():
        problem = problem_of_same(other, task.vary, task.same_as, {})
        if name in task.vary:
            problem = "it varies by itself"
        if problem:
            yield f"{name} is the same as {other}: {problem}"


def _of_tolerances(task: Optimisation) -> Iterator[str]:
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


def _of_goals(task: Optimisation) -> Iterator[str]:
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


def _of_formulas(task: Optimisation) -> Iterator[str]:
    texts = [name for name, vary in task.designed.items() if vary.texts is not None]
    for text in dict.fromkeys([*task.objectives, *task.constraints]):
        try:
            names = formula(text).names
        except StudyError as error:
            yield str(error)
            continue
        if not names:
            yield f"{text!r} is a constant: name a result"
        yield from (f"{text!r} uses {name}, which is a text" for name in names if name in texts)


# ---- units ----


def unit_of(task: Optimisation, name: str) -> str:
    """The FMU's unit of a variable, or of a variable at a time; none of a formula, or without an FMU."""
    return task.fmu_units.get(name.partition("@")[0], "")


def in_words(task: Optimisation, name: str, value: float | str, digits: int = DIGITS) -> str:
    """A value of a name or of a formula, with the unit of the file, else with the FMU's unit."""
    if isinstance(value, str):
        return value
    own = unit_of(task, name)
    given = task.units.get(name) or task.units.get(task.same_as.get(name, ""))
    if given:
        return f"{value / _factor(given, own):.{digits}g} {given}"
    return f"{value:.{digits}g} {own}".strip()


def bounds_in_words(task: Optimisation, name: str) -> str:
    """What a designed value may be."""
    vary = task.designed[name]
    if vary.is_list:
        return f"one of {', '.join(in_words(task, name, each) for each in choices(vary))}"
    return " to ".join(in_words(task, name, end) for end in vary.limits())


def _factor(given: str, own: str) -> float:
    """One of the given unit, in the FMU's unit; where the FMU has none, in the SI unit."""
    from dualcam.common.written_units import quantity, si_number

    return quantity(f"1 {given}", own) if own else si_number(f"1 {given}")
