"""`dualcam study` for files with a section [optimise]: search, files, page."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from dualcam.common.mistakes import StudyError, refuse
from dualcam.study.optimisation.design_files import fits_design_file, write_design
from dualcam.study.optimisation.designs import FmuRuns
from dualcam.study.optimisation.optimum import Optimum
from dualcam.study.optimisation.page import front_rows, write_page
from dualcam.study.optimisation.run import optimise
from dualcam.study.optimisation.task import Optimisation, in_words
from dualcam.study.store.encoding import encoded
from dualcam.study.study import say

if TYPE_CHECKING:
    from rich.console import Console

PAGE, BEST, FRONT_DESIGNS = "optimum.html", "best.toml", "front_designs"
FRONT, DESIGNS = "front.csv", "designs.csv"


def run(
    tasks: Mapping[str, Optimisation], folder: Path, workers: int, scheduler: str | None, console: Console
) -> None:
    """Search for the optima of tasks, and write what was found into folders of their names below this one.
    StudyError, after all searches, where no design keeps all constraints."""
    found = [_search(task, folder / name, workers, scheduler, console) for name, task in tasks.items()]
    refuse([text for one in found for text in _shortfall(one)])


def _shortfall(found: Optimum) -> list[str]:
    """What to say where no design keeps all constraints."""
    if found.feasible or found.folder is None:
        return []
    nearest = found.folder / (BEST if fits_design_file(found.task) else PAGE)
    said = f"{found.folder.name}: none of {found.evaluated:,} designs keeps all constraints"
    return [f"{said}. The nearest one, {nearest}, misses: {'; '.join(found.violated)}"]


def _search(
    task: Optimisation, folder: Path, workers: int, scheduler: str | None, console: Console
) -> Optimum:
    say(console, f"{folder.name}: {task.method_used}, at most {task.budget:,} designs")
    found = optimise(task, folder, workers, scheduler, console)
    write_files(found, folder, folder.name)
    for line in [*summary(found), *_refusals(found)]:
        say(console, line)
    say(console, f"page: {folder / PAGE}")
    return found


def _refusals(found: Optimum) -> list[str]:
    """What `dualcam check` refuses in the best design of a design file; a plan has no [limits] to be kept."""
    from dualcam.checking import check_design

    model = found.task.model
    if not (found.folder and isinstance(model, FmuRuns) and model.sections and fits_design_file(found.task)):
        return []
    best = found.folder / BEST
    return [f"{best}: `dualcam check` refuses this design: {error}" for error in check_design(best).errors]


def summary(found: Optimum) -> list[str]:
    """The optimum in lines."""
    task = found.task
    goals = found.objectives.items()
    lines = [f"{text} = {in_words(task, text, value)} ({task.objectives[text]})" for text, value in goals]
    lines += [f"  {name} = {in_words(task, name, value)}" for name, value in found.design.items()]
    lines += [f"  active: {text}" for text in found.holding]
    lines += [f"  {text}" for text in found.idle_words()]
    count = f"{found.evaluated:,} designs evaluated, {found.infeasible:,} of them infeasible"
    if found.failed:
        text = max(found.messages, key=lambda text: found.messages[text])
        count += f", {found.failed:,} of these failed, such as: {text}"
    return [*lines, count]


def write_files(found: Optimum, folder: Path, title: str) -> None:
    """Page, table of the front, and design files."""
    try:
        for name, table in ((FRONT, found.front), (DESIGNS, found.designs)):
            (folder / name).write_bytes(encoded(table, "csv", ""))
        if fits_design_file(found.task):
            _write_designs(found, folder, title)
        write_page(found, folder / PAGE, title)
    except OSError as error:
        raise StudyError(f"cannot write into {folder}: {error.strerror or error}") from error


def _write_designs(found: Optimum, folder: Path, title: str) -> None:
    values = ", ".join(f"{text} = {value:.6g}" for text, value in found.objectives.items())
    head = "\n".join([f"Best design of {title}: {values}", *found.idle_words()])
    write_design(folder / BEST, found.task, found.design, head)
    if len(found.task.objectives) < 2:
        return
    (folder / FRONT_DESIGNS).mkdir(exist_ok=True)
    for k in front_rows(found):
        design = {name: found.front[name].tolist()[k] for name in found.design}
        words = ", ".join(f"{text} = {found.front[text][k]:.6g}" for text in found.task.objectives)
        path = folder / FRONT_DESIGNS / f"design_{k + 1:04d}.toml"
        write_design(path, found.task, design, f"Design {k + 1} of the front of {title}: {words}")
