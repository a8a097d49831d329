"""Where runs are made: in this process, in processes of this machine, or by the workers of a Dask cluster.

Each way gives blocks of results as they come, and keeps only a few chunks in flight, so that memory does
not grow with the number of runs. A chunk whose worker dies is made again, by itself; if it kills again it
is halved until the run that kills is found, which becomes a failed run."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import pickle
import threading
from collections import deque
from collections.abc import Callable, Generator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from dualcam.fmu import Array
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError
from dualcam.study.runner import Block, Job, Runner, run_rows

AHEAD = 2  # chunks in flight for each worker: one that is computed, one that waits
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


def _pool(workers: int) -> ProcessPoolExecutor:
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(workers, mp_context=context, initializer=_end_with_parent)


def _end_with_parent() -> None:
    """In a worker: it would wait for work for ever if the study's process is killed."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def locally(job: Job, plan: Plan, chunks: list[range], workers: int) -> Blocks:
    _check_sendable(job)
    left = deque(chunks)
    while left:
        flying: dict[Future[Block], range] = {}
        try:
            with _pool(workers) as pool:
                try:
                    yield from _flow(pool, job, plan, left, flying, workers)
                except GeneratorExit:
                    pool.shutdown(wait=False, cancel_futures=True)
                    raise
        except BrokenProcessPool:
            _check_start()
            for runs in flying.values():
                rows = plan.rows(runs.start, runs.stop)
                yield runs, _alone(lambda rows: _attempt_locally(job, rows), rows, len(job.results))


def _flow(
    pool: ProcessPoolExecutor,
    job: Job,
    plan: Plan,
    left: deque[range],
    flying: dict[Future[Block], range],
    workers: int,
) -> Blocks:
    while left or flying:
        while left and len(flying) < AHEAD * workers:
            rows = plan.rows(left[0].start, left[0].stop)
            flying[pool.submit(run_rows, job, rows)] = left[0]
            left.popleft()
        done, _ = wait(flying, return_when=FIRST_COMPLETED)
        for future in done:
            block = future.result()
            yield flying.pop(future), block


def _check_sendable(job: Job) -> None:
    try:
        pickle.dumps(job)
    except Exception as error:  # pickle has several for it
        raise StudyError(
            f"this study cannot be sent to other processes: {error}: let a function of a module make the "
            "controller, or use workers = 0"
        ) from error


def _check_start() -> None:
    """Whether it is the process that cannot live, rather than the run."""
    try:
        with _pool(1) as pool:
            pool.submit(os.getpid).result()
    except BrokenProcessPool as error:
        raise StudyError(
            "processes die as they start. A script is read by each of them: what starts a study there "
            'belongs under `if __name__ == "__main__":`; or use workers = 0'
        ) from error


def _attempt_locally(job: Job, rows: Array) -> Block:
    with _pool(1) as pool:
        try:
            return pool.submit(run_rows, job, rows).result()
        except BrokenProcessPool as error:
            raise _Died from error


# ---- a cluster ----


def _distributed() -> Any:  # noqa: ANN401
    try:
        return importlib.import_module("distributed")
    except ImportError:
        raise StudyError("a scheduler needs dask.distributed: pip install 'dualcam[study]'") from None


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
