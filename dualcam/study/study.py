"""A whole study: plan, scenario and results of one FMU, run into a folder; and its description in TOML."""

from __future__ import annotations

import hashlib
import importlib
import math
import os
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from dualcam.fmu import Scalar
from dualcam.study import execution
from dualcam.study.plan import Plan, Vary
from dualcam.study.problem import StudyError
from dualcam.study.runner import Job, check
from dualcam.study.scenario import Controller, History, Scenario
from dualcam.study.store import Column, Store, read

CHUNK_MAX = 10_000  # runs: a third of a second of computing, and a file that is worth opening
CHUNKS_MIN = 40  # of a small study, so that its progress is seen and its end does not wait for one worker


@dataclass(frozen=True)
class Study:
    """`parameters` are start values that no run changes. `results` are variables at the end of the scenario,
    or, as `name@time`, at that time [s]."""

    fmu: str | Path
    plan: Plan
    scenario: Scenario
    results: Sequence[str]
    parameters: Mapping[str, Scalar] = field(default_factory=dict)
    plots: Sequence[Mapping[str, Any]] = ()

    def job(self) -> Job:
        return Job(str(self.fmu), self.plan.names, dict(self.parameters), self.scenario, list(self.results))

    def run(
        self,
        folder: str | Path,
        workers: int | None = None,
        scheduler: str | None = None,
        form: str | None = None,
        chunk: int | None = None,
        console: Console | None = None,
    ) -> dict[str, Column]:
        """Makes the runs that `folder` does not hold yet, and reads all of them.

        `workers`: processes of this machine (0: in this one; None: as many as it has processors);
        `scheduler`: the address of a Dask scheduler, to be used instead. `form`: parquet (the default if
        pyarrow is there) or csv. `console`: shows progress there. StudyError if the study is wrong or
        cannot go on."""
        self.make(folder, workers, scheduler, form, chunk, console)
        return read(folder)

    def make(
        self,
        folder: str | Path,
        workers: int | None = None,
        scheduler: str | None = None,
        form: str | None = None,
        chunk: int | None = None,
        console: Console | None = None,
        each: Callable[[], None] = lambda: None,
    ) -> None:
        """As `run`, without reading the results back. `each` is called after every chunk that is written."""
        for name, number, least in (("workers", workers, 0), ("chunk", chunk, 1)):
            if number is not None and number < least:
                raise StudyError(f"{name} = {number}: allowed is {least} or more")
        job = self.job()
        runner = check(job, self.plan)
        size = chunk or min(CHUNK_MAX, math.ceil(self.plan.count / CHUNKS_MIN))
        store = Store(folder, self.facts(), self.plan.count, size, form)
        missing = store.missing()
        count = (os.cpu_count() or 1) if workers is None else workers
        if scheduler:
            blocks = execution.on_cluster(job, self.plan, missing, scheduler)
        elif count == 0:
            blocks = execution.in_this_process(runner, self.plan, missing)
        else:
            blocks = execution.locally(job, self.plan, missing, min(count, max(1, len(missing))))
        left = sum(len(runs) for runs in missing)
        with _progress(console, self.plan.count, self.plan.count - left) as advance:
            for runs, block in blocks:
                rows = self.plan.rows(runs.start, runs.stop)
                store.write(runs, self.plan.names, rows, self.results, block)
                advance(len(runs), len(block.messages))
                each()
        runner.close()

    def facts(self) -> dict[str, Any]:
        """What makes two studies the same: their results could be mixed."""
        scenario = asdict(self.scenario)
        if control := self.scenario.controller:
            scenario["controller"] |= {"make": f"{control.make.__module__}.{control.make.__qualname__}"}
        return {
            "fmu": hashlib.sha256(Path(self.fmu).read_bytes()).hexdigest(),
            "plan": self.plan.facts(),
            "scenario": scenario,
            "results": list(self.results),
            "parameters": dict(self.parameters),
        }


# ---- progress ----


class _Rate(ProgressColumn):
    """Over all of this call, the start of the workers included."""

    def render(self, task: Task) -> Text:
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


# ---- TOML ----


def load(path: str | Path) -> Study:
    """The study that a TOML file describes; paths in it are relative to the file. StudyError if it is
    none."""
    path = Path(path)
    try:
        content = tomllib.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise StudyError(f"{path} cannot be read as TOML: {error}") from error
    try:
        known = ("fmu", "plan", "scenario", "results", "parameters", "plots")
        table = _only(content, "the file", *known)
        return Study(
            path.parent / _need(table, "the file", "fmu"),
            _plan(_need(table, "the file", "plan"), path.parent),
            _scenario(_need(table, "the file", "scenario")),
            _need(table, "the file", "results"),
            table.get("parameters", {}),
            table.get("plots", ()),
        )
    except StudyError as error:
        raise StudyError(f"{path}: {error}") from error
    except (TypeError, AttributeError, ValueError) as error:
        raise StudyError(f"{path}: a value of the wrong type: {error}") from error


def _only(table: Mapping[str, Any], where: str, *known: str) -> dict[str, Any]:
    if not isinstance(table, dict):
        raise StudyError(f"{where} is {table!r}: allowed is a table with {', '.join(known)}")
    if unknown := sorted(set(table) - set(known)):
        raise StudyError(f"{where} has {', '.join(unknown)}: allowed are {', '.join(known)}")
    return table


def _need(table: Mapping[str, Any], where: str, name: str) -> Any:  # noqa: ANN401
    if name not in table:
        raise StudyError(f"{where} lacks {name}")
    return table[name]


def _plan(content: Mapping[str, Any], folder: Path) -> Plan:
    table = _only(content, "plan", "kind", "runs", "seed", "vary", "table")
    if "table" in table:
        _only(content, "plan of a table", "kind", "table")
        if table.get("kind", "table") != "table":
            raise StudyError(f"plan has a table and is of kind {table['kind']}: allowed is one of them")
        return Plan.from_csv(folder / table["table"])
    same = {name: each["same"] for name, each in table.get("vary", {}).items() if "same" in each}
    vary = {name: _vary(name, each) for name, each in table.get("vary", {}).items() if name not in same}
    return Plan(_need(table, "plan", "kind"), vary, table.get("runs", 0), table.get("seed", 0), same=same)


def _vary(name: str, content: Mapping[str, Any]) -> Vary:
    table = _only(content, f"plan: {name}", "from", "to", "count", "log", "values")
    low, high = float(table.get("from", math.nan)), float(table.get("to", math.nan))
    return Vary(
        low, high, table.get("count", 0), table.get("log", False), tuple(map(float, table.get("values", ())))
    )


def _scenario(content: Mapping[str, Any]) -> Scenario:
    table = _only(content, "scenario", "stop", "step", "tolerance", "inputs", "controller")
    names = [each.name for each in fields(History)]
    histories = {
        name: History(**_only(each, f"scenario: {name}", *names))
        for name, each in table.get("inputs", {}).items()
    }
    control = _controller(table["controller"]) if "controller" in table else None
    return Scenario(
        float(_need(table, "scenario", "stop")), histories, table.get("step"), table.get("tolerance"), control
    )


def _controller(content: Mapping[str, Any]) -> Controller:
    table = _only(content, "controller", "make", "period", "reads", "writes")
    module, _, function = str(_need(table, "controller", "make")).partition(":")
    try:
        make = getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError, ValueError) as error:
        raise StudyError(
            f"controller: make = {table['make']!r}: allowed is module:function: {error}"
        ) from error
    return Controller(make, *(_need(table, "controller", name) for name in ("period", "reads", "writes")))
