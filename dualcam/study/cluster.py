"""Workers of a Dask cluster."""

from __future__ import annotations

import importlib
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dualcam.fmu import Array
from dualcam.study.chunk import Task
from dualcam.study.execution import AHEAD, Answer, Answers, Died, Order, Workers
from dualcam.study.problem import StudyError
from dualcam.study.runner import Block

if TYPE_CHECKING:
    from distributed import Client

UNREACHABLE_AFTER = "10s"
NO_WORKERS_FOR = 30  # s, after that a cluster is given up


def _distributed() -> Any:  # noqa: ANN401
    try:
        return importlib.import_module("distributed")
    except ImportError:
        raise StudyError('a scheduler needs dask.distributed: pip install "dualcam[study]"') from None


def _in_cluster(name: str, order: Order) -> Answer:
    """In a Dask worker: the task is the one that the plugin brought."""
    task: Task = _distributed().get_worker().plugins[name].task
    return task.perform(order)


class Cluster(Workers):
    """The workers that a Dask scheduler has, which may come and go. They need dualcam installed; the FMU
    travels with the task. Orders of a worker that dies are given to others, which is Dask's doing."""

    def __init__(self, task: Task, scheduler: str | Client) -> None:
        super().__init__(task)
        self._distributed = _distributed()
        self._is_own = isinstance(scheduler, str)
        client: Any = scheduler
        self._client = self._connected(client) if self._is_own else client
        if self._client.asynchronous:
            raise StudyError("scheduler: an asynchronous Client: allowed is one with asynchronous = False")
        self._name = f"dualcam-study-{task.job.token}"
        self._is_sent = False

    def _connected(self, scheduler: str) -> Any:  # noqa: ANN401
        try:
            return self._distributed.Client(scheduler, timeout=UNREACHABLE_AFTER, set_as_default=False)
        except (OSError, ValueError, TypeError, TimeoutError) as error:
            raise StudyError(f"no Dask scheduler answers at {scheduler}: {error}. Nothing was run") from error

    def _where(self) -> str:
        scheduler = self._client.scheduler
        return str(scheduler.address) if scheduler else "an unknown address"

    def count(self) -> int:
        return max(1, sum(self._client.nthreads().values()))

    def close(self) -> None:
        if self._client.status == "running" and self._is_sent:  # else nothing is left to tidy up
            with suppress(Exception):
                self._client.unregister_worker_plugin(self._name)
        if self._is_own:
            self._client.close(timeout=2)

    def answers(self, orders: Iterable[Order]) -> Answers:
        left = deque(enumerate(orders))
        flying: dict[Any, tuple[int, Order]] = {}
        try:
            self._send_task()
            self._client.wait_for_workers(1, timeout=NO_WORKERS_FOR)
            while left or flying:
                room = AHEAD * self.count()
                while left and len(flying) < room:
                    place, order = left.popleft()
                    flying[self._submit(order)] = place, order
                for future in self._finished(list(flying)):
                    place, order = flying.pop(future)
                    yield place, self._answer(future, order)
        except (OSError, TimeoutError, self._distributed.CancelledError) as error:
            raise StudyError(
                f"the Dask cluster at {self._where()} does not answer any more, or has no workers: {error}. "
                "The runs written before are kept: give the same command again"
            ) from error
        finally:
            with suppress(Exception):
                self._client.cancel(list(flying))

    def _send_task(self) -> None:
        if self._is_sent:
            return
        job = replace(self.task.job, content=Path(self.task.job.path).read_bytes())
        plugin = self._distributed.WorkerPlugin()
        plugin.task = replace(self.task, job=job)
        try:
            self._client.register_plugin(plugin, name=self._name)
        except OSError:  # of the cluster
            raise
        except Exception as error:  # whatever a worker says of what it cannot unpack
            raise StudyError(
                f"the Dask workers cannot take this study: {error}. They need the same version of dualcam, "
                "and the module of its controller"
            ) from error
        self._is_sent = True

    def _submit(self, order: Order) -> Any:  # noqa: ANN401
        return self._client.submit(_in_cluster, self._name, order, pure=False)

    def _answer(self, future: Any, order: Order) -> Answer:  # noqa: ANN401
        try:
            answer: Answer = future.result()
        except self._distributed.KilledWorker:
            return self._alone(self._attempt, order)
        return answer

    def _attempt(self, rows: Array) -> Block:
        future = self._submit(rows)
        self._finished([future])
        try:
            block: Block = future.result()
        except self._distributed.KilledWorker as error:
            raise Died from error
        return block

    def _finished(self, futures: list[Any]) -> Any:  # noqa: ANN401
        """Those that are, at least one. TimeoutError if there has been no worker for a while: one that comes
        back is given the work anew."""
        while True:
            with suppress(TimeoutError), self._client.as_current():
                return self._distributed.wait(futures, NO_WORKERS_FOR, return_when="FIRST_COMPLETED").done
            self._client.wait_for_workers(1, timeout=NO_WORKERS_FOR)
