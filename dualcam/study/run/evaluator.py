"""Results of rows that are asked for one after another, as an optimiser asks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import real_array
from dualcam.common.mistakes import StudyError
from dualcam.study.run.chunk import Task, varied_columns
from dualcam.study.run.first_runs import check
from dualcam.study.run.processes import workers_for
from dualcam.study.run.runner import Block

if TYPE_CHECKING:
    from distributed import Client

    from dualcam.study.study import Study

SHARES = 4  # of the rows for each worker, so that a slow one does not hold up the others


class Evaluator:
    """Makes runs of a study for any rows of values: f(rows) -> results. The workers stay between the calls.

    Parameters
    ----------
    study : FMU, scenario, results and fixed parameters. Of the plan only `names` and limits are used.
    workers : Processes of this machine. 0: in this process.
    scheduler : Dask workers are used instead: address of the scheduler, or a client.

    Raises
    ------
    StudyError
        The study is wrong.

    Examples
    --------
    >>> from dualcam.study import Evaluator, Plan, Scenario, Study, Vary
    >>> plan = Plan("latin", {"spring.preload": Vary(40.0, 80.0)}, runs=1)  # N
    >>> with Evaluator(Study("forward", plan, Scenario(0.1), ["torque_load"])) as evaluate:
    ...     evaluate([[50.0], [60.0]]).values.round(4).tolist()  # N.m
    [[0.6628], [0.7953]]
    """

    def __init__(self, study: Study, workers: int = 0, scheduler: str | Client | None = None) -> None:
        if workers < 0:
            raise StudyError(f"workers = {workers}: allowed is 0 or more")
        job = study.job()
        self.names = list(job.names)
        self.results = list(study.readings.columns)
        self._readings, self._texts = study.readings, study.plan.texts
        runner = check(job, study.plan, study.readings.used)
        self._workers = workers_for(Task(job), runner, workers, scheduler)

    def __enter__(self) -> Evaluator:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Send the workers home."""
        self._workers.close()

    def __call__(self, rows: ArrayLike) -> Block:
        """Make one run for each row of `rows`, shape (runs, names): values in the FMU's units, columns in the
        order of `names`.

        `values` of the block, shape (runs, results), have columns in the order of `results`; NaN where a run
        failed. A series has a column for each instant. `messages` are place and reason of the runs that
        failed. StudyError: the rows have another shape, or the workers cannot go on.
        """
        table = real_array(rows, "rows", StudyError)
        if table.ndim != 2 or table.shape[1] != len(self.names):
            raise StudyError(f"rows of shape {table.shape}: allowed is (runs, {len(self.names)})")
        varied = varied_columns(self.names, table, self._texts)
        if len(table) == 0:
            return Block(self._readings.table(np.empty((0, len(self._readings.raw))), varied), {})
        count = self._workers.count()
        size = math.ceil(len(table) / (SHARES * count)) if count > 1 else len(table)
        orders = [table[start : start + size] for start in range(0, len(table), size)]
        blocks = cast(dict[int, Block], dict(self._workers.answers(orders)))
        joined = Block.joined([blocks[place] for place in range(len(orders))])
        return Block(self._readings.table(joined.values, varied, list(joined.messages)), joined.messages)
