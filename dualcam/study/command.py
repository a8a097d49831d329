"""`dualcam study`: plans in TOML files, run and drawn."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console

from dualcam.common.mistakes import StudyError
from dualcam.errors import DualcamError
from dualcam.study.file.study_file import content_of, read_study
from dualcam.study.optimisation.task import Optimisation
from dualcam.study.store.results import read_results
from dualcam.study.store.storage import is_url
from dualcam.study.study import Study, say


def read_all(paths: Sequence[Path]) -> dict[Path, Study | Optimisation]:
    """What each file describes: plans, or design files with a section [study]. StudyError, or DesignFileError
    for the only file, with the mistakes of all files."""
    from dualcam.study.optimisation.file import is_search, read_optimisation

    if len({path.stem for path in paths}) < len(paths):
        raise StudyError("two plans of the same name would share a folder: rename one")
    found: dict[Path, Study | Optimisation] = {}
    errors = []
    for path in paths:
        try:
            found[path] = read_optimisation(path) if is_search(content_of(path)) else read_study(path)
        except DualcamError as error:
            errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    if errors:
        raise StudyError("\n".join(map(str, errors)), [str(error) for error in errors])
    return found


def run(
    found: Mapping[Path, Study | Optimisation],
    out: str,
    console: Console,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    file_format: str | None = None,
    figure: Path | None = None,
    runs_per_file: int | None = None,
) -> None:
    """Run the studies and optimisations of `read_all`. StudyError for what goes wrong: the same command then
    goes on from the files that are written.

    `out`, a folder or the URL of a store, gets one folder for each plan. `workers`, `scheduler`,
    `file_format` and `runs_per_file` are those of `Study.run`. `figure`: one picture of all plots; None: one
    for each study, beside its results."""
    from dualcam.study.optimisation import command as optimisation

    tasks = {plan.stem: each for plan, each in found.items() if isinstance(each, Optimisation)}
    studies = {plan.stem: each for plan, each in found.items() if isinstance(each, Study)}
    if tasks and is_url(out):
        raise StudyError(f"--out {out}: an optimisation writes into a folder: give a folder")
    if figure and studies:
        from dualcam.study import plots

        plots.check_file(list(studies.values()), figure)
    pairs = {
        name: (study, f"{out.rstrip('/')}/{name}" if is_url(out) else Path(out) / name)
        for name, study in studies.items()
    }
    for name, (study, folder) in pairs.items():
        say(console, f"{name}: {study.plan.count:,} runs, {study.plan.kind}")
        _tell_violations(study, console)
        begun = time.perf_counter()
        study.run_to_files(folder, workers, scheduler, file_format, runs_per_file, console)
        _tell(folder, time.perf_counter() - begun, console)
    if figure and studies:
        _draw([*pairs.values()], figure, console)
    else:
        for name, (study, folder) in pairs.items():
            if study.plots:
                beside = folder if isinstance(folder, Path) else Path()
                _draw([(study, folder)], beside / f"{name}.png", console)
    if tasks:
        optimisation.run(tasks, Path(out), workers or 0, scheduler, console)


def _tell_violations(study: Study, console: Console) -> None:
    """How many runs the constraints concern."""
    if not study.plan.constraints:
        return
    bad, looked, then = study.plan.sampler.violating()
    runs = f"{looked:,}" if looked == study.plan.count else f"the first {looked:,}"
    if bad:
        say(console, f"{bad:,} of {runs} runs violate a constraint: {then}")


def _draw(studies: Sequence[tuple[Study, str | Path]], path: Path, console: Console) -> None:
    from dualcam.study import plots

    plots.draw(studies, path)
    say(console, f"drawn: {path}")


def _tell(folder: str | Path, seconds: float, console: Console) -> None:
    messages = read_results(folder, ["message"])["message"]
    failed = messages[messages != ""]
    say(console, f"{len(messages):,} runs in {folder}, {seconds:.1f} s now")
    if len(failed):
        kinds, counts = np.unique(failed.astype(str), return_counts=True)
        say(console, f"{len(failed):,} failed, such as: {kinds[np.argmax(counts)]}")
