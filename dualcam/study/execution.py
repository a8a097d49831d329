"""Where runs are made: in this process, in processes of this machine, or by the workers of a Dask cluster.

Each way gives blocks of results as they come, and keeps only a few chunks in flight, so that memory does
not grow with the number of runs. A chunk whose worker dies is made again, by itself; if it kills again it
is halved until the run that kills is found, which becomes a failed run."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Generator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from multiprocessing.connection import Connection, wait
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from dualcam.fmu import Array
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError
from dualcam.study.runner import Block, Job, Runner, run_rows

AHEAD = 2  # chunks in flight for each worker: one that is computed, one that waits
GRACE = 2.0  # s, for a process that is sent home in the middle of something
UNREACHABLE_AFTER = "10s"
NO_WORKERS_FOR = 30  # s, after that a cluster is given up
DIED = "the process that made this run ended without a word (crashed or killed), also when it was alone"
Blocks = Generator[tuple[range, Block], None, None]


def in_this_process(runner: Runner, plan: Plan, chunks: list[range]) -> Blocks:
    for runs in chunks:
        yield runs, runner.run(plan.rows(runs.start, runs.stop))


class _Died(Exception):
    """The worker did not live to the end of these rows."""


def _alone(attempt: Callable[[Array], Block], rows: Array, width: int) -> Block:
    """These rows, whatever it takes."""
    try:
        return attempt(rows)
    except _Died:
        if len(rows) == 1:
            return Block.lost(width, DIED)
    half = len(rows) // 2
    return Block.joined(_alone(attempt, rows[:half], width), _alone(attempt, rows[half:], width))


# ---- this machine ----


class _Worker:
    """A process that makes runs, and the two pipes to it, which nobody else has: whatever it is doing when it
    dies, or when this process is interrupted, can hold up nobody.

    Not concurrent.futures: Ctrl-C within its submit(), or a process that dies meanwhile, may leave an
    executor that is waited for without end (CPython 3.11)."""

    def __init__(self, job: Job) -> None:
        context = multiprocessing.get_context("spawn")
        orders, self._orders = context.Pipe(duplex=False)
        self.answers, answers = context.Pipe(duplex=False)
        self._process = context.Process(target=_serve, args=(job, orders, answers), daemon=True)
        self._process.start()
        orders.close()
        answers.close()
        self.lives = False
        self.given: deque[range] = deque()

    def give(self, runs: range, rows: Array) -> None:
        self.given.append(runs)
        with suppress(OSError):  # it is dead, and its answer will say so
            self._orders.send(rows)

    def receive(self) -> tuple[range, Block] | None:
        """The first runs given and their block, which may take its time; None, which comes once before, says
        that it lives. _Died if it does no more."""
        try:
            answer = self.answers.recv()
        except (EOFError, OSError) as error:
            raise _Died from error
        if isinstance(answer, Exception):
            raise answer
        self.lives = True
        return (self.given.popleft(), answer) if isinstance(answer, Block) else None

    def dismiss(self) -> None:
        """One that has nothing to do ends by itself, one that has as it finds its pipe closed."""
        if not self.given:
            with suppress(OSError):
                self._orders.send(None)
        self._orders.close()

    def join(self) -> None:
        self._process.join(2.0 * GRACE)
        self._process.kill()
        self._process.join()
        self.answers.close()


def _serve(job: Job, orders: Connection, answers: Connection) -> None:
    """In a worker: its end tidies up, as the FMU's own does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches it too, but its study sends it home
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(1))
    waiting: SimpleQueue[Array | None] = SimpleQueue()
    threading.Thread(target=_listen, args=(orders, waiting), daemon=True).start()
    answers.send(None)
    while (rows := waiting.get()) is not None:
        try:
            answer: Block | Exception = run_rows(job, rows)
        except Exception as error:
            answer = error
        answers.send(answer)


def _listen(orders: Connection, waiting: SimpleQueue[Array | None]) -> None:
    """In a worker: orders are taken while it computes. Ends it where the study is over or its process
    was killed."""
    with suppress(EOFError, OSError):
        while True:
            waiting.put(rows := orders.recv())
            if rows is None:
                return
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(GRACE)
    os._exit(1)


def locally(job: Job, plan: Plan, chunks: list[range], workers: int) -> Blocks:
    _check_sendable(job)
    left = deque(chunks)
    team: list[_Worker] = []
    try:
        for _ in range(workers if chunks else 0):
            team.append(_Worker(job))  # one by one, so that those which began are sent home
        while left or any(worker.given for worker in team):
            for worker in team:
                _occupy(worker, plan, left, AHEAD if len(left) > len(team) else 1)
            yield from _answers(job, plan, left, team)
    finally:
        _send_home(team)


def _occupy(worker: _Worker, plan: Plan, left: deque[range], most: int) -> None:
    while left and len(worker.given) < most:
        worker.give(left[0], plan.rows(left[0].start, left[0].stop))
        left.popleft()


def _answers(job: Job, plan: Plan, left: deque[range], team: list[_Worker]) -> Blocks:
    """Those that are there, once one is."""
    ready = wait([worker.answers for worker in team if worker.given])
    for place, worker in enumerate(team):
        if worker.answers not in ready:
            continue
        try:
            made = worker.receive()
        except _Died:
            team[place] = _Worker(job)
            _send_home([worker])
            runs, *others = worker.given
            left.extendleft(reversed(others))
            rows = plan.rows(runs.start, runs.stop)
            made = runs, _alone(partial(_attempt_locally, job), rows, len(job.results))
        if made is not None:
            yield made


def _attempt_locally(job: Job, rows: Array) -> Block:
    worker = _Worker(job)
    try:
        worker.give(range(len(rows)), rows)
        made = worker.receive() or worker.receive()
    except _Died as error:
        if worker.lives:
            raise
        raise StudyError(
            "processes die as they start. A script is read by each of them: what starts a study there "
            'belongs under `if __name__ == "__main__":`; or use workers = 0'
        ) from error
    finally:
        _send_home([worker])
    assert made is not None
    return made[1]


def _send_home(team: list[_Worker]) -> None:
    for worker in team:
        worker.dismiss()
    for worker in team:
        worker.join()


def _check_sendable(job: Job) -> None:
    try:
        pickle.dumps(job)
    except Exception as error:  # pickle has several for it
        raise StudyError(
            f"this study cannot be sent to other processes: {error}: let a function of a module make the "
            "controller, or use workers = 0"
        ) from error


# ---- a cluster ----


def _distributed() -> Any:  # noqa: ANN401
    try:
        return importlib.import_module("distributed")
    except ImportError:
        raise StudyError("a scheduler needs dask.distributed: pip install distributed") from None


def _in_cluster(name: str, rows: Array) -> Block:
    """In a Dask worker: the job is the one that the plugin brought."""
    return run_rows(_distributed().get_worker().plugins[name].job, rows)


def on_cluster(job: Job, plan: Plan, chunks: list[range], scheduler: str) -> Blocks:
    """The FMU travels with the job; the workers need dualcam installed. Chunks of a worker that dies are
    made again by the others, which is Dask's doing, and results are written here only, so no run is lost
    and none is twice."""
    distributed = _distributed()
    try:
        client = distributed.Client(scheduler, timeout=UNREACHABLE_AFTER)
    except (OSError, ValueError, TimeoutError) as error:
        raise StudyError(f"no Dask scheduler answers at {scheduler}: {error}. Nothing was run") from error
    name = f"dualcam-study-{job.token}"
    try:
        travelling = replace(job, content=Path(job.path).read_bytes())
        _send(client, _plugin(distributed, travelling), name)
        client.wait_for_workers(1, timeout=NO_WORKERS_FOR)
        yield from _gather(distributed, client, name, plan, chunks, len(job.results))
    except (OSError, TimeoutError, distributed.CancelledError) as error:
        raise StudyError(
            f"the Dask cluster at {scheduler} does not answer any more, or has no workers: {error}. The runs "
            "written before are kept: give the same command again"
        ) from error
    finally:
        if client.status == "running":  # else the cluster is gone, and nothing is left to tidy up
            with suppress(Exception):
                client.unregister_worker_plugin(name)
        client.close(timeout=2)


def _send(client: Any, plugin: Any, name: str) -> None:  # noqa: ANN401
    try:
        client.register_plugin(plugin, name=name)
    except OSError:  # of the cluster
        raise
    except Exception as error:  # whatever a worker says of what it cannot unpack
        raise StudyError(
            f"the Dask workers cannot take this study: {error}. They need the same version of dualcam, and "
            "the module of its controller"
        ) from error


def _plugin(distributed: Any, job: Job) -> Any:  # noqa: ANN401
    plugin = distributed.WorkerPlugin()
    plugin.job = job
    return plugin


def _gather(
    distributed: Any,  # noqa: ANN401
    client: Any,  # noqa: ANN401
    name: str,
    plan: Plan,
    chunks: list[range],
    width: int,
) -> Blocks:
    killed = distributed.KilledWorker

    def submit(rows: Array) -> Any:  # noqa: ANN401
        return client.submit(_in_cluster, name, rows, pure=False)

    def attempt(rows: Array) -> Block:
        future = submit(rows)
        _finished(distributed, client, [future])
        try:
            block: Block = future.result()
        except killed as error:
            raise _Died from error
        return block

    left = deque(chunks)
    flying: dict[Any, range] = {}
    while left or flying:
        room = AHEAD * max(1, sum(client.nthreads().values()))
        while left and len(flying) < room:
            runs = left.popleft()
            future = submit(plan.rows(runs.start, runs.stop))
            flying[future] = runs
        for future in _finished(distributed, client, list(flying)):
            runs = flying.pop(future)
            try:
                block = future.result()
            except killed:
                block = _alone(attempt, plan.rows(runs.start, runs.stop), width)
            yield runs, block


def _finished(distributed: Any, client: Any, futures: list[Any]) -> Any:  # noqa: ANN401
    """Those that are, at least one. TimeoutError if there has been no worker for a while: one that comes back
    is given the work anew."""
    while True:
        with suppress(TimeoutError):
            return distributed.wait(futures, NO_WORKERS_FOR, return_when="FIRST_COMPLETED").done
        client.wait_for_workers(1, timeout=NO_WORKERS_FOR)
