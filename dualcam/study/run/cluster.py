"""Workers of a Dask cluster."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from dualcam.common.mistakes import StudyError, optional_module
from dualcam.fmi.fmu import Array
from dualcam.study.run.chunk import Answer, Order, Task
from dualcam.study.run.runner import Block
from dualcam.study.run.workers import Answers, Died, Workers

if TYPE_CHECKING:
    from distributed import Client

UNREACHABLE_AFTER = "10s"
NO_WORKERS_FOR = 30  # s, after that a cluster is given up
COUNTED_EVERY = 1.0  # s
GROUP_SECONDS = 1.0  # of orders that travel together: a message takes about a thousandth
GROUP_MAX = 50  # orders
Orders = list[tuple[int, Order]]  # with their places
AHEAD = 2  # groups in flight for each worker: one that is made, one that waits


def _distributed() -> Any:  # noqa: ANN401
    return optional_module("distributed", 'a scheduler needs dask.distributed: pip install "dualcam[study]"')


def _in_cluster(name: str, orders: Sequence[Order]) -> tuple[list[Answer], float]:
    """In a Dask worker: the answers of the task that the plugin brought, and their seconds."""
    task: Task = _distributed().get_worker().plugins[name].task
    begun = time.perf_counter()
    futures: list[Future[Answer]] = []
    with ThreadPoolExecutor(1) as writer:  # a file is written while the runs of the next one are made
        for order in orders:
            finish = task.made(order)
            if len(futures) > 1:
                futures[-2].result()  # so that memory does not grow where writing takes longer
            futures.append(writer.submit(finish))
    return [future.result() for future in futures], time.perf_counter() - begun


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
        self._count, self._counted = 1, -math.inf

    def _connected(self, scheduler: str) -> Any:  # noqa: ANN401
        try:
            return self._distributed.Client(scheduler, timeout=UNREACHABLE_AFTER, set_as_default=False)
        except (OSError, ValueError, TypeError, TimeoutError) as error:
            raise StudyError(f"no Dask scheduler answers at {scheduler}: {error}. Nothing was run") from error

    def _where(self) -> str:
        scheduler = self._client.scheduler
        return str(scheduler.address) if scheduler else "an unknown address"

    def count(self) -> int:
        """Threads of all workers, as of a second ago at most: asking takes a message."""
        if time.monotonic() - self._counted > COUNTED_EVERY:
            self._count = max(1, sum(self._client.nthreads().values()))
            self._counted = time.monotonic()
        return self._count

    def close(self) -> None:
        if self._client.status == "running" and self._is_sent:  # else nothing is left to tidy up
            with suppress(Exception):
                self._client.unregister_worker_plugin(self._name)
        if self._is_own:
            self._client.close(timeout=2)

    def answers(self, orders: Iterable[Order]) -> Answers:
        left = deque(enumerate(orders))
        flying: dict[Any, Orders] = {}
        done: SimpleQueue[Any] = SimpleQueue()
        seconds = math.inf  # of an order
        try:
            self._send_task()
            self._client.wait_for_workers(1, timeout=NO_WORKERS_FOR)
            while left or flying:
                flying |= self._submitted(left, self._room(len(flying)), seconds, done)
                future = self._next(done)
                group = flying.pop(future)
                if (found := self._group_answers(future, group)) is None:
                    flying |= {self._submit([one], done): [one] for one in group}
                    continue
                answers, taken = found
                seconds = taken / len(group)
                yield from zip((place for place, _ in group), answers, strict=True)
        except (OSError, TimeoutError, self._distributed.CancelledError) as error:
            raise StudyError(
                f"the Dask cluster at {self._where()} does not answer any more, or has no workers: {error}. "
                "The runs written before are kept: give the same command again"
            ) from error
        finally:
            with suppress(Exception):
                self._client.cancel(list(flying))

    def _room(self, flying: int) -> int:
        """Groups to submit now: some at a time, which takes one message."""
        most = AHEAD * self.count()
        room = most - flying
        return room if room >= most // 4 else 0

    def _submitted(
        self, left: deque[tuple[int, Order]], room: int, seconds: float, done: SimpleQueue[Any]
    ) -> dict[Any, Orders]:
        """Groups of orders on their way, each long enough for its messages not to matter."""
        groups: list[Orders] = []
        while left and len(groups) < room:
            fair = len(left) // (2 * AHEAD * self.count())  # so that all workers have something to the end
            size = max(1, min(fair, int(GROUP_SECONDS / max(seconds, 1e-6)), GROUP_MAX))
            groups.append([left.popleft() for _ in range(min(size, len(left)))])
        return {self._submit(group, done): group for group in groups}

    def _group_answers(self, future: Any, group: Orders) -> tuple[list[Answer], float] | None:  # noqa: ANN401
        """Answers and seconds. None if the group is to be made order by order, since its workers died."""
        try:
            found: tuple[list[Answer], float] = future.result()
        except self._distributed.KilledWorker:
            if len(group) > 1:
                return None
            return [self._alone(self._attempt, group[0][1])], math.inf
        return found

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

    def _submit(self, group: Orders, done: SimpleQueue[Any]) -> Any:  # noqa: ANN401
        orders = [order for _, order in group]
        future = self._client.submit(_in_cluster, self._name, orders, pure=False)
        future.add_done_callback(done.put)
        return future

    def _attempt(self, rows: Array) -> Block:
        done: SimpleQueue[Any] = SimpleQueue()
        future = self._submit([(0, rows)], done)
        self._next(done)
        try:
            block: Block = future.result()[0][0]
        except self._distributed.KilledWorker as error:
            raise Died from error
        return block

    def _next(self, done: SimpleQueue[Any]) -> Any:  # noqa: ANN401
        """The next future that is done. TimeoutError if there has been no worker for a while."""
        while True:
            with suppress(Empty):
                return done.get(timeout=NO_WORKERS_FOR)
            self._client.wait_for_workers(1, timeout=NO_WORKERS_FOR)
