"""Where runs are made: in this process, in processes of this machine, or by the workers of a Dask cluster.

Each way takes orders, chunks of a study or rows of values, and gives answers as they come. It keeps only a
few orders in flight, so that memory does not grow with the number of runs. An order whose worker dies is made
again, by itself; if it kills again it is halved until the run that kills is found, which becomes a failed
run."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable

from dualcam.fmi.fmu import Array
from dualcam.study.run.chunk import Answer, Order, Task
from dualcam.study.run.runner import Block, Runner

AHEAD = 3  # orders in flight for each worker: one whose file is written, one that is computed, one that waits
DIED = "the process that made this run ended without a word (crashed or killed), also when it was alone"
Answers = Generator[tuple[int, Answer], None, None]  # with the places of the orders


class Died(Exception):
    """The worker did not live to the end of an order."""


class Workers(ABC):
    """Those that make the runs of one task, and are sent home at the end of the context."""

    def __init__(self, task: Task) -> None:
        self.task = task

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @abstractmethod
    def answers(self, orders: Iterable[Order]) -> Answers:
        """The answers to all orders, as they come."""

    @abstractmethod
    def count(self) -> int:
        """How many can work at the same time now."""

    @abstractmethod
    def close(self) -> None:
        """They are not needed any more."""

    def _alone(self, attempt: Callable[[Array], Block], order: Order) -> Answer:
        """The answer to an order whose worker has died, whatever it takes."""
        rows = self.task.rows(order)
        block = _halved(attempt, rows, len(self.task.job.results))
        return self.task.finish(order, rows, block)()


def _halved(attempt: Callable[[Array], Block], rows: Array, width: int) -> Block:
    try:
        return attempt(rows)
    except Died:
        if len(rows) == 1:
            return Block.lost(width, DIED)
    half = len(rows) // 2
    return Block.joined([_halved(attempt, part, width) for part in (rows[:half], rows[half:])])


class InThisProcess(Workers):
    """No other process: the runs are made when their answers are asked for."""

    def __init__(self, task: Task, runner: Runner) -> None:
        super().__init__(task)
        self._runner = runner

    def answers(self, orders: Iterable[Order]) -> Answers:
        for place, order in enumerate(orders):
            yield place, self.task.made(order, self._runner.run)()

    def count(self) -> int:
        return 1

    def close(self) -> None:
        self._runner.close()
