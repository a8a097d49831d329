"""`dualcam study`: plans in TOML files, run and drawn."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from dualcam.common.mistakes import StudyError
from dualcam.errors import DualcamError
from dualcam.study.file.study_file import read_study
from dualcam.study.optimisation.task import Optimisation
from dualcam.study.store.results import read_results
from dualcam.study.store.storage import is_url
from dualcam.study.study import Study, say


@dataclass(frozen=True)
class Settings:
    """How the studies are run, and where their results go.

    `folder`, or URL of a store, gets one folder for each plan. `workers`: processes of this machine; 0: in
    this one; None: one per core, for short studies and optimisations this one. `scheduler`: address of a Dask
    scheduler to be used instead. `file_format`: "parquet" or "csv"; None: parquet where pyarrow is installed.
    `figure`: one picture of all plots; None: one for each plan, beside its results."""

    folder: str | Path
    workers: int | None = None
    scheduler: str | None = None
    file_format: str | None = None
    figure: Path | None = None
    runs_per_file: int | None = None


def run(found: Mapping[Path, Study | Optimisation], settings: Settings, console: Console) -> None:
    """Run the studies and optimisations that `read_all` found.

    Raises
    ------
    StudyError
        What is wrong. All files that are written are complete: the same command goes on from there.
    """
    from dualcam.study import plots
    from dualcam.study.optimisation import command as optimisation

    tasks = {plan.stem: each for plan, each in found.items() if not isinstance(each, Study)}
    plans = [plan for plan in found if plan.stem not in tasks]
    studies = [
        (each, _below(settings.folder, plan.stem)) for plan, each in found.items() if isinstance(each, Study)
    ]
    for study, _ in studies:
        plots.check(study)
    if settings.figure and studies:
        plots.check_file([study for study, _ in studies], settings.figure)
    for plan, (study, folder) in zip(plans, studies, strict=True):
        say(console, f"{plan.stem}: {study.plan.count:,} runs, {study.plan.kind}")
        _tell_violations(study, console)
        begun = time.perf_counter()
        study.run_to_files(
            folder,
            settings.workers,
            settings.scheduler,
            settings.file_format,
            settings.runs_per_file,
            console=console,
        )
        _tell(study, folder, time.perf_counter() - begun, console)
    if settings.figure and studies:
        _draw(studies, settings.figure, console)
    else:
        _draw_each(plans, studies, console)
    if tasks:
        folder, workers = _local(settings.folder), settings.workers or 0
        optimisation.run(tasks, folder, workers, settings.scheduler, console)


def read_all(paths: Sequence[Path]) -> dict[Path, Study | Optimisation]:
    """What each file describes: plans, or design files with a section [study].

    Raises
    ------
    StudyError
        The mistakes of all files at once, or two files of one name.
    DesignFileError
        The only file is a design file with errors.
    """
    from dualcam.study.optimisation.file import asks_for_optimum, read_optimisation

    if len({path.stem for path in paths}) < len(paths):
        raise StudyError("two plans of the same name would share a folder: rename one")
    found: dict[Path, Study | Optimisation] = {}
    errors = []
    for path in paths:
        try:
            found[path] = read_optimisation(path) if asks_for_optimum(path) else read_study(path)
        except DualcamError as error:
            errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    if errors:
        raise StudyError("\n".join(map(str, errors)), [str(error) for error in errors])
    return found


def _draw_each(plans: Sequence[Path], studies: Sequence[tuple[Study, str | Path]], console: Console) -> None:
    """One picture for each study, beside its results."""
    for plan, (study, folder) in zip(plans, studies, strict=True):
        if study.plots:
            beside = Path() if is_url(folder) else Path(folder)
            _draw([(study, folder)], beside / f"{plan.stem}.png", console)


def _tell_violations(study: Study, console: Console) -> None:
    """How many runs the constraints concern."""
    if not study.plan.constraints:
        return
    bad, looked, then = study.plan.sampler.violating()
    runs = f"{looked:,}" if looked == study.plan.count else f"the first {looked:,}"
    if bad:
        say(console, f"{bad:,} of {runs} runs violate a constraint: {then}")


def _below(folder: str | Path, name: str) -> str | Path:
    return f"{str(folder).rstrip('/')}/{name}" if is_url(folder) else Path(folder) / name


def _local(folder: str | Path) -> Path:
    """StudyError for the URL of a store."""
    if is_url(folder):
        raise StudyError(f"--out {folder}: an optimisation writes into a folder: give a folder")
    return Path(folder)


def _draw(studies: list[tuple[Study, str | Path]], path: Path, console: Console) -> None:
    from dualcam.study import plots

    plots.draw(studies, path)
    say(console, f"drawn: {path}")


def _tell(study: Study, folder: str | Path, seconds: float, console: Console) -> None:
    messages = read_results(folder, ["message"])["message"]
    failed = messages[messages != ""]
    say(console, f"{len(messages):,} runs in {folder}, {seconds:.1f} s now")
    if len(failed):
        kinds, counts = np.unique(failed.astype(str), return_counts=True)
        first = kinds[np.argmax(counts)]
        say(console, f"{len(failed):,} failed, such as: {first}")
