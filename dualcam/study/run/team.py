"""The workers that a study asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dualcam.study.run.chunk import Task
from dualcam.study.run.cluster import Cluster
from dualcam.study.run.processes import Processes
from dualcam.study.run.runner import Runner
from dualcam.study.run.workers import InThisProcess, Workers

if TYPE_CHECKING:
    from distributed import Client


def workers_for(task: Task, runner: Runner, count: int, scheduler: str | Client | None = None) -> Workers:
    """`count` processes, or this process with its `runner` for 0; or those of a Dask scheduler."""
    if scheduler is None and count == 0:
        return InThisProcess(task, runner)
    runner.close()
    if scheduler is not None:
        return Cluster(task, scheduler)
    return Processes(task, count)
