"""Times of whole studies, and of their parts."""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import distributed
import numpy as np

from benchmarks.harness import core
from benchmarks.harness.processes import processor_seconds
from benchmarks.study_rate.study import study
from dualcam.study import History, Plan, Scenario, Study, Vary
from dualcam.study.run import cluster
from dualcam.study.run.chunk import Task, Written, name_of
from dualcam.study.run.processes import Processes
from dualcam.study.run.runner import Runner
from dualcam.study.run.workers import Workers
from dualcam.study.store.store import Store

FILE = 10_000  # runs
TABLES, TABLE_RUNS = 100, 10_000


def cluster_of(count: int) -> distributed.LocalCluster:
    return distributed.LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None)


def throughput(
    make: Callable[[Task], Workers], files: int, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Runs per second of a study of this many files. Starting the workers does not count: a first small study
    starts them."""
    whole = study(runs=files * FILE)
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:
        store = Store(folder, whole.facts(), whole.plan, whole.readings, FILE, "parquet")
        with closing(store), make(Task(whole.job(), store.files())) as workers:
            chunks = store.missing()
            warm = [range(first, first + 100) for first in range(0, 100 * 4 * workers.count(), 100)]
            for _ in workers.answers(warm):
                pass
            begun = clock()
            for place, written in workers.answers(chunks):
                assert isinstance(written, Written) and written.failed == 0
                store.accept(chunks[place], written)
            return files * FILE / (clock() - begun)


def processor_time(count: int, files: int) -> float:
    """Seconds of processors for a run, of the study and of its processes together. Other programs on the
    machine matter less than in the time that passes."""
    return 1.0 / throughput(on_processes(count), files * count, processor_seconds)


def on_processes(count: int) -> Callable[[Task], Workers]:
    return lambda task: Processes(task, count)


def on_dask(client: distributed.Client) -> Callable[[Task], Workers]:
    return lambda task: cluster.Cluster(task, client)


@dataclass(frozen=True)
class Costs:
    """Of one file of FILE runs [s], and its size [bytes]."""

    rows: float
    runs: float
    encode: float
    write: float
    study_by_pipe: float
    study_by_dask: float
    size: int

    @property
    def worker(self) -> float:
        return self.rows + self.runs + self.encode + self.write


def costs(rounds: int) -> Costs:
    """Medians of the processor's time; of writing the time that passes."""
    whole = study(runs=10 * FILE)
    chunk = range(0, FILE)
    with (
        tempfile.TemporaryDirectory(dir=Path.cwd()) as folder,
        closing(Runner(whole.job())) as runner,
        closing(Store(folder, whole.facts(), whole.plan, whole.readings, FILE, "parquet")) as store,
    ):
        files = store.files()
        rows = whole.plan.rows(0, FILE)
        block = runner.run(rows)
        content = files.content(chunk, rows, block)
        name = name_of(chunk, "parquet")
        return Costs(
            median(lambda: whole.plan.rows(0, FILE), rounds),
            median(lambda: runner.run(rows), rounds),
            median(lambda: files.content(chunk, rows, block), rounds),
            median(lambda: files.storage.write(name, content), rounds, time.perf_counter),
            by_pipe(rounds),
            by_dask(rounds),
            len(content),
        )


def median(work: Callable[[], Any], rounds: int, clock: Callable[[], float] = time.process_time) -> float:
    taken = []
    for _ in range(rounds):
        begun = clock()
        work()
        taken.append(clock() - begun)
    return statistics.median(taken)


class Nothing(Task):
    """Answers at once: what is left is the study's own work for an order."""

    def made(self, order: Any, run: Any = None) -> Callable[[], Written]:  # noqa: ANN401
        return lambda: Written(1, "00000000", 0)


def own_work(workers: Workers, orders: int) -> float:
    """Seconds of this process for an order."""
    chunks = [range(k, k + 1) for k in range(orders)]
    for _ in workers.answers(chunks[: orders // 10]):
        pass
    begun = time.process_time()
    assert len(list(workers.answers(chunks))) == orders
    return (time.process_time() - begun) / orders


def by_pipe(rounds: int) -> float:
    with Processes(Nothing(study().job()), 2) as workers:
        return statistics.median(own_work(workers, 2000) for _ in range(rounds))


def by_dask(rounds: int) -> float:
    """Of the study and of the scheduler, which are one process here, for an order that travels alone."""
    with (
        cluster_of(2) as machine,
        distributed.Client(machine) as client,
        patch.object(cluster, "GROUP_MAX", 1),
        cluster.Cluster(Nothing(study().job()), client) as workers,
    ):
        return statistics.median(own_work(workers, 500) for _ in range(rounds))


# ---- groove tables ----


def over_tables(count: int, folder: Path) -> float:
    """Seconds of TABLE_RUNS runs over so many tables, with the results on disk, in one process."""
    psi = np.linspace(0.0, 1.6, 41)
    paths = []
    for k in range(count):
        z = 0.02 * psi * (1.0 + 0.003 * k * psi * (1.6 - psi))
        path = folder / f"table{k:03d}.csv"
        lines = [f"{a!r},{b!r}" for a, b in zip(psi.tolist(), z.tolist(), strict=True)]
        path.write_text("\n".join(["psi_rad,z_m", *lines]))
        paths.append(str(path))
    vary = {"cam1.friction": Vary(0.08, 0.2), "cam1.table": Vary(values=paths)}
    push = Scenario(0.4, {"tau": History([0.0, 0.2, 0.2], [8.0, 8.0, 0.0])})
    whole = Study(
        core.fmu_path(core.FORWARD),
        Plan("latin", vary, TABLE_RUNS),
        push,
        ["theta@0.2", "energy.work_in"],
        {"cam1.profile": 3},
    )
    begun = time.process_time()
    whole.run_to_files(folder / f"over{count}-{os.urandom(4).hex()}", workers=0)
    return time.process_time() - begun
