"""A whole study: plan, scenario and results of one FMU, run into a folder."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn
from rich.progress import Task as Shown
from rich.text import Text

from dualcam.common.mistakes import StudyError
from dualcam.fmi.library import MODELS, source_path
from dualcam.fmi.model_description import Scalar
from dualcam.scenario.scenario import Scenario
from dualcam.study.plan.plan import Plan
from dualcam.study.run.chunk import Task, Written
from dualcam.study.run.first_runs import check, takes_less_than
from dualcam.study.run.processes import in_a_daemon, workers_for
from dualcam.study.run.readings import Readings
from dualcam.study.run.runner import Job, Runner
from dualcam.study.store.results import Results, read_results
from dualcam.study.store.store import Store

if TYPE_CHECKING:
    from distributed import Client

CHUNK_MAX = 10_000  # runs: a third of a second of computing, and a file that is worth opening
NUMBERS_MAX = 2_000_000  # that the runs of a file are read for: 16 MB
RUNS_PER_TEXT = 20  # in a file: to read a groove table takes as long as two runs
START_UP = 2.0  # s: processes have started and imported what they need
CHUNKS_MIN = 40  # of a small study, so that its progress is seen and its end does not wait for one worker


@dataclass(frozen=True)
class Study:
    """Many runs of one co-simulation FMU: plan, scenario and results.

    Parameters
    ----------
    fmu : "forward", "inverse", or the path of an FMU of FMI 2.0 or FMI 3.0.
    plan : Which values the runs have.
    scenario : What is done in each run.
    results : sequence of str
        What is read in each run, such as "theta", at the end, "theta@0.2", at 0.2 s, or
        "top = max(theta, every=0.01)". docs/use-study-results.md, "What can be read", lists all kinds.
    parameters : Start values that are the same in every run.
    plots : Pictures for `dualcam study`, as in the section [[plots]] of a plan.

    Raises
    ------
    StudyError
        `results` is no list of names.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.study import History, Plan, Scenario, Study, Vary
    >>> plan = Plan("grid", {"cam1.friction": Vary(values=[0.1, 0.2])})
    >>> push = Scenario(0.4, {"tau": History([0.0, 0.2, 0.2], [8.0, 8.0, 0.0])})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     table = Study("forward", plan, push, ["efficiency", "theta@0.2"]).run(folder, workers=0)
    >>> table["efficiency"].round(3).tolist()
    [0.617, 0.503]
    """

    fmu: str | Path
    plan: Plan
    scenario: Scenario
    results: Sequence[str]
    parameters: Mapping[str, Scalar] = field(default_factory=dict)
    plots: Sequence[Mapping[str, Any]] = ()

    def __post_init__(self) -> None:
        if isinstance(self.results, str) or not all(isinstance(name, str) for name in self.results):
            raise StudyError(f"results = {self.results!r}: allowed is a list of names")
        _ = self.readings  # what is wrong with them is said here

    @property
    def path(self) -> Path:
        """The file of the FMU."""
        return source_path(self.fmu)

    @cached_property
    def readings(self) -> Readings:
        """What the results are made of."""
        return Readings(self.results, self.scenario.stop, self.plan.names)

    def job(self) -> Job:
        """What a worker needs for the runs."""
        return Job(
            str(self.path),
            self.plan.names,
            dict(self.parameters),
            self.scenario,
            self.readings.raw,
            self.plan.texts,
            dict(self.plan.constraints),
        )

    def run(
        self,
        folder: str | Path,
        workers: int | None = None,
        scheduler: str | Client | None = None,
        file_format: str | None = None,
        runs_per_file: int | None = None,
        console: Console | None = None,
    ) -> Results:
        """Make the runs that a folder does not hold yet, and read all of them.

        Parameters
        ----------
        folder : str or Path
            Folder of the results; made if it is missing. Also the URL of a store that fsspec knows, such as
            s3://bucket/folder.
        workers : int, optional
            Processes of this machine. 0: in this process. None: as many as there are processors; in this
            process where all runs of an FMU of this package take less than 2 s, or where this process is a
            worker of multiprocessing.Pool.
        scheduler : A Dask cluster is used instead: address of its scheduler, or a client.
        file_format : "parquet" or "csv". None: "parquet" if pyarrow is installed.
        runs_per_file : Most runs in a file of results.
        console : Shows the progress.

        Returns
        -------
        Results
            As of `read_results`.

        Raises
        ------
        StudyError
            The study is wrong or cannot go on; the message says what to do.
        """
        self.run_to_files(folder, workers, scheduler, file_format, runs_per_file, console)
        return read_results(folder)

    def run_to_files(
        self,
        folder: str | Path,
        workers: int | None = None,
        scheduler: str | Client | None = None,
        file_format: str | None = None,
        runs_per_file: int | None = None,
        console: Console | None = None,
        on_file_written: Callable[[], None] = lambda: None,
    ) -> None:
        """Make the runs as `run` does, without reading them.

        Parameters
        ----------
        folder, workers, scheduler, file_format, runs_per_file, console
            As in `run`.
        on_file_written : Is called without arguments after each file of results.

        Raises
        ------
        StudyError
            As in `run`.
        """
        for name, number, least in (("workers", workers, 0), ("runs_per_file", runs_per_file, 1)):
            if number is not None and number < least:
                raise StudyError(f"{name} = {number}: allowed is {least} or more")
        job = self.job()
        runner = check(job, self.plan, self.readings.used)
        self.plan.rows(0, 1)  # what is too much for the memory is so before anything is written
        size = runs_per_file or self._runs_per_file()
        with (
            closing(runner),
            closing(Store(folder, self.facts(), self.plan, self.readings, size, file_format)) as store,
        ):
            missing = store.missing()
            if console and store.damaged:
                say(console, f"damaged, made again: {', '.join(store.damaged)}")
            left = sum(len(runs) for runs in missing)
            wanted = self._processes(runner, left) if workers is None else workers
            count = min(wanted, max(1, len(missing)))
            with (
                workers_for(Task(job, store.files()), runner, count, scheduler) as team,
                closing(team.answers(missing)) as answers,
                _progress(console, self.plan.count, self.plan.count - left) as advance,
            ):
                for place, written in answers:
                    assert isinstance(written, Written)
                    store.accept(missing[place], written)
                    advance(len(missing[place]), written.failed)
                    on_file_written()

    def _processes(self, runner: Runner, left: int) -> int:
        """0 where the runs take less time in this process than the others take to start. The FMU of another
        project could end this process, so it gets others, where this process may start some."""
        is_short = self.fmu in MODELS and takes_less_than(START_UP, runner, self.plan, left)
        return 0 if is_short or in_a_daemon() else os.cpu_count() or 1

    def _runs_per_file(self) -> int:
        most = min(CHUNK_MAX, max(1, NUMBERS_MAX // self.readings.width))
        texts = math.prod(map(len, self.plan.texts.values())) if self.plan.texts else 0
        return min(most, max(math.ceil(self.plan.count / CHUNKS_MIN), RUNS_PER_TEXT * texts))

    def facts(self) -> dict[str, Any]:
        """What makes two studies the same: their results could be mixed."""
        return {
            "fmu": hashlib.sha256(self.path.read_bytes()).hexdigest(),
            "plan": self.plan.facts(),
            "scenario": self.scenario.facts(),
            "results": list(self.results),
            "parameters": dict(self.parameters),
        }


# ---- progress ----


def say(console: Console, text: str) -> None:
    """Print a line as it is: paths and the FMU's words hold brackets, and are to be copied."""
    console.print(text, highlight=False, markup=False, soft_wrap=True)


class _Rate(ProgressColumn):
    """Over all of this call, the start of the workers included."""

    def render(self, task: Shown) -> Text:
        made = task.completed - task.fields["before"]
        return Text(f"{made / task.elapsed:,.0f} runs/s" if made and task.elapsed else "")


@contextmanager
def _progress(console: Console | None, total: int, done: int) -> Iterator[Any]:
    if console is None:
        yield lambda runs, failed: None
        return
    text = TextColumn("{task.completed:,.0f} of {task.total:,.0f} runs, {task.fields[failed]:,} failed")
    with Progress(BarColumn(), text, _Rate(), TimeRemainingColumn(), console=console) as progress:
        task = progress.add_task("runs", total=total, completed=done, before=done, failed=0)

        def advance(runs: int, failed: int) -> None:
            progress.update(task, advance=runs, failed=progress.tasks[0].fields["failed"] + failed)

        yield advance
