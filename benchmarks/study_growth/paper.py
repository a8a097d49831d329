"""Throughput of many workers, from the costs of one file of runs."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.study_growth.measure import FILE, Costs
from dualcam.study.run.cluster import GROUP_SECONDS

WORKERS = (1, 2, 10, 30, 100, 300, 1000)
STORES = {"network folder": 1e9, "object store": 10e9}  # bytes per second that a store takes, assumed


@dataclass(frozen=True)
class Growth:
    """Runs per second of some workers, and what is busy all the time."""

    workers: int
    store: str
    travelling: str
    runs_per_second: float
    limit: str


def grown(costs: Costs) -> list[Growth]:
    """By the number of workers. The stage that works all the time is the limit: the workers, the study with
    Dask's scheduler, or the store."""
    alone, group = costs.study_by_dask, max(1.0, GROUP_SECONDS / costs.worker)
    found = []
    for store, rate in STORES.items():
        for travelling, study in (("each file alone", alone), (f"groups of {group:.0f}", alone / group)):
            for workers in WORKERS:
                files = {
                    "workers": workers / costs.worker,
                    "study and scheduler": 1.0 / study,
                    "store": rate / costs.size,
                }
                limit = min(files, key=lambda name: files[name])
                found.append(Growth(workers, store, travelling, FILE * files[limit], limit))
    return found


def most_workers(costs: Costs, store: str, group: bool) -> tuple[float, str]:
    """Workers at which the growth ends, and why."""
    size = max(1.0, GROUP_SECONDS / costs.worker) if group else 1.0
    ends = {
        "study and scheduler": costs.worker * size / costs.study_by_dask,
        "store": costs.worker * STORES[store] / costs.size,
    }
    limit = min(ends, key=lambda name: ends[name])
    return ends[limit], limit
