"""What the first runs show before a study starts: values, tables and scenarios that the FMU refuses."""

import math
import time
import warnings
from collections.abc import Collection, Iterator

import numpy as np

from dualcam.common.groove_laws import TABLE
from dualcam.common.mistakes import refuse
from dualcam.errors import DualcamWarning
from dualcam.fmi.reals import Array
from dualcam.scenario.history import numbers_in
from dualcam.scenario.scenario import SAME_TIME
from dualcam.study.plan.plan import Plan
from dualcam.study.run.fmu_check import Variables, percent, problems_with_fmu
from dualcam.study.run.runner import Job, Runner

SAMPLE = 32  # runs by which the time of a study is estimated
LOOKED_AT = 1000  # runs, for what cannot be known of all
PROFILES = {"cam1.table": "cam1.profile", "cam2.table": "cam2.profile"}


def check(job: Job, plan: Plan, used: Collection[str] = ()) -> Runner:
    """A runner for the job, made here and now, so that what concerns every run is refused before any.

    `used`: names that formulas of results use. StudyError with all that the FMU refuses."""
    variables = Variables.of_fmu(job.path)
    refuse(problems_with_fmu(variables, plan, job, used))
    runner = Runner(job)
    try:
        rows = plan.rows(0, LOOKED_AT)
        doubts = [*_unused_tables(variables, plan, job), *_uneven_periods(job, rows)]
        problems = _problems_of_texts(runner, job, rows)
        if failed := runner.steps.groups(rows)[1] if job.scenario.names else {}:
            share = "all" if len(failed) == len(rows) else percent(len(failed) / len(rows))
            place, text = next(iter(failed.items()))
            said = f"{share} of the first {len(rows):,} runs are refused, such as run {place}: {text}"
            (problems if share == "all" else doubts).append(said)
        for text in doubts:
            warnings.warn(DualcamWarning(text), stacklevel=4)
        refuse(problems)
    except BaseException:
        runner.close()
        raise
    return runner


def takes_less_than(limit: float, runner: Runner, plan: Plan, left: int) -> bool:
    """Whether `left` runs take less than `limit` [s] in this process, as a few first runs tell. The very
    first run takes longer than others: its time counts only where the run is long."""
    for tried in (1, SAMPLE):
        begun = time.perf_counter()
        runner.run(plan.rows(0, min(tried, plan.count)))
        seconds = time.perf_counter() - begun
        if seconds > limit / SAMPLE:
            break
    return seconds / min(tried, plan.count) * left < limit


def _unused_tables(variables: Variables, plan: Plan, job: Job) -> Iterator[str]:
    """Groove tables that vary, and that no run reads: one text each."""
    for table, profile in PROFILES.items():
        if table not in plan.names or profile not in variables.by_name or profile in plan.names:
            continue
        value = job.parameters.get(profile, variables.by_name[profile].start)
        if value != TABLE.number:
            yield (
                f"plan: {table} varies, and no run reads the tables: {profile} = {value}. Give "
                f'"{profile}" = {TABLE.number} in parameters'
            )


def _uneven_periods(job: Job, rows: Array) -> Iterator[str]:
    """A text where the controller's last period does not end with the run."""
    scenario = job.scenario
    if scenario.controller is None:
        return
    columns = dict(zip(job.names, rows.T, strict=True))
    period = numbers_in(scenario.controller.period, columns, len(rows))
    stop = numbers_in(scenario.stop, columns, len(rows))
    with np.errstate(all="ignore"):  # of runs that are no scenario
        count = stop / period
        uneven = np.flatnonzero(np.abs(count - np.round(count)) > SAME_TIME * count)
    if not len(uneven):
        return
    run = uneven[0]
    where = "" if len(uneven) == len(rows) else f", {percent(len(uneven) / len(rows))}, such as run {run}"
    fault = "is longer than" if count[run] < 1.0 else "does not divide"
    last = math.floor(count[run]) * period[run]
    yield (
        f"scenario{where}: controller.period = {period[run]:.6g} s {fault} the run of {stop[run]:.6g} s."
        f" The law is asked for the last time at {last:.6g} s, {stop[run] - last:.6g} s before the end"
    )


def _problems_of_texts(runner: Runner, job: Job, rows: Array) -> list[str]:
    """The texts, such as tables, that the FMU refuses in the first run that has them."""
    found = []
    for name, texts in job.texts.items():
        if name not in runner.columns:
            continue
        chosen, first = np.unique(rows[:, list(job.names).index(name)].astype(int), return_index=True)
        messages = runner.run(rows[first]).messages
        found += [
            f"plan: {name} = {texts[int(chosen[place])]!r}: {text}"
            for place, text in messages.items()
            if name in text
        ]
    return found
