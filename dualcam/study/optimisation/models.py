"""Models: what gives the results of designs."""

from __future__ import annotations

import math
import multiprocessing
import pickle
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from functools import partial
from typing import Any, Protocol

import numpy as np

from dualcam.errors import DualcamError
from dualcam.library import source_path
from dualcam.model_description import read_model_description
from dualcam.reals import Array
from dualcam.study.optimisation.task import FmuRuns, Function, Optimisation
from dualcam.study.plan import Plan, Vary
from dualcam.study.problem import StudyError
from dualcam.study.runner import Block, Job, check

REFUSALS = (DualcamError, ArithmeticError, ValueError)  # of a function: this design is none


class Model(Protocol):
    """Gives results, shape (designs, results), for rows of values."""

    def run(self, rows: Array) -> Block: ...

    def close(self) -> None: ...


def open_model(task: Optimisation, names: Sequence[str], workers: int = 0) -> Model:
    """The task's model for rows of these values. StudyError for what concerns every design."""
    if isinstance(task.model, FmuRuns):
        return _fmu_model(task, task.model, names)
    return FunctionModel(task.model, names, task.read, workers)


def nominal_values(task: Optimisation) -> dict[str, float]:
    """Values that do not vary and have a tolerance, and the model's own values of those that vary, where
    these are known."""
    model, wanted = task.model, [*task.tolerances, *task.vary]
    if not isinstance(model, FmuRuns):
        if unknown := [name for name in task.tolerances if name not in task.vary]:
            raise StudyError(
                f"optimise: tolerances: {', '.join(unknown)} does not vary: a function gets what varies only"
            )
        return {}
    starts = {each.name: each.start for each in read_model_description(source_path(model.fmu)).variables}
    if unknown := [name for name in wanted if name not in starts]:
        raise StudyError(f"optimise: {', '.join(unknown)}: no variable of the FMU")
    found = {}
    for name in wanted:
        with suppress(TypeError, ValueError):  # no start value, or one that is no number
            found[name] = float(model.parameters.get(name, starts[name]))  # type: ignore[arg-type]
    return found


def _fmu_model(task: Optimisation, model: FmuRuns, names: Sequence[str]) -> Model:
    nominal = nominal_values(task)
    vary = dict(task.vary)
    for name, deviation in task.tolerances.items():
        if name in vary:
            continue
        if name not in nominal:
            raise StudyError(
                f"optimise: tolerances: {name} has no number as its value: fix one in parameters"
            )
        vary[name] = Vary(nominal[name] - deviation.plus_minus, nominal[name] + deviation.plus_minus)
    plan = Plan("latin", vary, runs=1, same_as=task.same_as)
    fixed = {name: value for name, value in model.parameters.items() if name not in names}
    job = Job(str(source_path(model.fmu)), list(names), fixed, model.scenario, task.read)
    return check(job, plan)


class FunctionModel:
    """Calls a function for each design, here or in processes."""

    def __init__(
        self, function: Function, names: Sequence[str], results: Sequence[str], workers: int = 0
    ) -> None:
        self._function, self._names, self._results = function, list(names), list(results)
        self._processes: ProcessPoolExecutor | None = None
        if workers > 0:
            _check_sendable(function)
            self._processes = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"))

    def run(self, rows: Array) -> Block:
        designs = [dict(zip(self._names, row, strict=True)) for row in rows.tolist()]
        attempt = partial(_attempt, self._function)
        values = np.full((len(rows), len(self._results)), math.nan)
        messages: dict[int, str] = {}
        try:
            given = list((self._processes.map if self._processes else map)(attempt, designs))
        except BrokenProcessPool as error:
            raise StudyError(
                "a process of the model ended without a word (crashed or killed). What was evaluated before "
                "is kept in the folder: give the same command again. A script that starts processes needs "
                'if __name__ == "__main__":'
            ) from error
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
            raise StudyError(
                f"the model gives no {', '.join(lacking)}: allowed are {', '.join(map(str, given))}, and "
                "what varies"
            )
        return [float(given[name]) for name in self._results]

    def close(self) -> None:
        if self._processes is not None:
            self._processes.shutdown(cancel_futures=True)


def _attempt(function: Function, design: dict[str, float]) -> Any:  # noqa: ANN401
    """What the function returns, or why it refuses the design."""
    try:
        given = function(design)
    except REFUSALS as error:
        return str(error) or type(error).__name__
    return None if isinstance(given, str) else given


def _check_sendable(function: Function) -> None:
    try:
        pickle.dumps(function)
    except Exception as error:  # pickle has several for it
        raise StudyError(
            f"the model cannot be sent to other processes: {error}: allowed is a function of a module; or "
            "use workers = 0"
        ) from error
