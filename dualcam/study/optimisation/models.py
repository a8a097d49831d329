"""Models: what gives the results of designs."""

from __future__ import annotations

import math
import multiprocessing
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from dualcam.common.entries import hint
from dualcam.common.mistakes import StudyError, refuse
from dualcam.errors import DualcamError
from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import read_model_description
from dualcam.fmi.reals import Array
from dualcam.study.optimisation.designs import Design, FmuRuns, Function
from dualcam.study.optimisation.task import Optimisation
from dualcam.study.plan.plan import Plan
from dualcam.study.plan.rows import values_of
from dualcam.study.run.evaluator import Evaluator
from dualcam.study.run.processes import check_processes
from dualcam.study.run.runner import Block
from dualcam.study.study import Study

if TYPE_CHECKING:
    from distributed import Client

REFUSALS = (DualcamError, ArithmeticError, ValueError)  # of a function: this design is none


def plan_of(task: Optimisation) -> Plan:
    """What a row of values is: designed values, chance, values that have a tolerance alone; then what follows
    from these. A plan of one run, for its `names`, `completed` and `texts`."""
    nominal = own_values(task)
    vary = {**task.designed, **task.chance}
    for name, deviation in task.tolerances.items():
        if name not in vary:
            vary[name] = deviation.distribution(nominal[name])
    model = task.model
    formulas: Any = {}
    if isinstance(model, FmuRuns):
        formulas = {"derived": model.derived, "constraints": model.conditions, "on_violation": "mark"}
    return Plan("latin", vary, runs=1, same_as=task.same_as, **formulas)


def open_model(
    task: Optimisation, plan: Plan, workers: int = 0, scheduler: str | Client | None = None
) -> Evaluator | FunctionModel:
    """The task's model for rows of these values. StudyError for what concerns every design."""
    if isinstance(task.model, FmuRuns):
        fixed = {name: value for name, value in task.model.parameters.items() if name not in plan.names}
        study = Study(source_path(task.model.fmu), plan, task.model.scenario, task.read, fixed)
        return Evaluator(study, workers, scheduler)
    if scheduler is not None:
        raise StudyError("a scheduler makes runs of an FMU: a function as the model has workers alone")
    return FunctionModel(task.model, plan, task.read, workers)


def own_values(task: Optimisation) -> dict[str, float]:
    """The model's own values of what is designed, where these are numbers, and of what has a tolerance."""
    needed = [name for name in task.tolerances if name not in task.vary]
    if not isinstance(task.model, FmuRuns):
        unknown = "does not vary: a function gets what varies only"
        refuse(f"optimise: tolerances: {name} {unknown}" for name in needed)
        return {}
    variables = read_model_description(source_path(task.model.fmu)).variables
    starts = {each.name: each.start for each in variables}
    found: dict[str, float] = {}
    for name in [*task.designed, *needed]:
        with suppress(TypeError, ValueError):  # no start value, or one that is no number
            found[name] = float(task.model.parameters.get(name, starts.get(name)))  # type: ignore[arg-type]
    lacking = [name for name in needed if name not in found]
    refuse(f"optimise: tolerances: {name} is no number of the FMU{hint(name, starts)}" for name in lacking)
    return found


class FunctionModel:
    """Calls a function for each design, here or in processes."""

    def __init__(self, function: Function, plan: Plan, results: Sequence[str], workers: int = 0) -> None:
        self._function, self._plan, self._results = function, plan, list(results)
        self._processes: ProcessPoolExecutor | None = None
        if workers > 0:
            check_processes(function, "the model", "give a function of a module")
            self._processes = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"))

    def __call__(self, rows: Array) -> Block:
        attempt = partial(_attempt, self._function)
        designs = [values_of(self._plan.names, row, self._plan.texts) for row in rows]
        try:
            given = list((self._processes.map if self._processes else map)(attempt, designs))
        except BrokenProcessPool as error:
            raise StudyError(
                "a process of the model ended without a word (crashed or killed). What was evaluated before "
                "is kept in the folder: give the same command again. A script that starts processes needs "
                'if __name__ == "__main__":'
            ) from error
        values = np.full((len(rows), len(self._results)), math.nan)
        messages: dict[int, str] = {}
        for place, one in enumerate(given):
            if isinstance(one, str):
                messages[place] = one
            else:
                values[place] = self._chosen(one)
        return Block(values, messages)

    def _chosen(self, given: object) -> list[float]:
        if not isinstance(given, Mapping):
            raise StudyError(f"the model returned {given!r:.60}: allowed is a dict of results by name")
        if lacking := [name for name in self._results if name not in given]:
            allowed = ", ".join(map(str, given))
            raise StudyError(
                f"the model gives no {', '.join(lacking)}: allowed are {allowed}, and what varies"
            )
        return [float(given[name]) for name in self._results]

    def close(self) -> None:
        if self._processes is not None:
            self._processes.shutdown(cancel_futures=True)


def _attempt(function: Function, design: Design) -> Any:  # noqa: ANN401
    """What the function returns, or why it refuses the design."""
    try:
        given = function(design)
    except REFUSALS as error:
        return str(error) or type(error).__name__
    return None if isinstance(given, str) else given
