"""`dualcam study`: plans in TOML files, run and drawn."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from rich.console import Console

from dualcam.study.description import read_study
from dualcam.study.problem import StudyError
from dualcam.study.store import FORMATS, read_results
from dualcam.study.study import Study, say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("plans", nargs="+", type=Path, metavar="plan.toml")
    parser.add_argument(
        "--out", type=Path, default=Path("build/study"), help="folder of folders, one per plan"
    )
    parser.add_argument(
        "--workers", type=int, help="processes of this machine, 0: in this one (one per processor)"
    )
    parser.add_argument("--scheduler", help="address of a Dask scheduler to be used instead, tcp://host:8786")
    parser.add_argument("--format", choices=FORMATS, help="of the results (parquet if pyarrow is installed)")
    parser.add_argument(
        "--figure", type=Path, help="one picture of all plots (each plan's own, beside its results)"
    )
    parser.add_argument("--chunk", type=int, help="runs in a file of results")


def run(arguments: argparse.Namespace, console: Console) -> None:
    """StudyError says what is wrong. What is written is complete, and the same command goes on from there."""
    from dualcam.study import plots

    studies = [(read_study(plan), arguments.out / plan.stem) for plan in arguments.plans]
    if len({folder for _, folder in studies}) < len(studies):
        raise StudyError("two plans of the same name would share a folder: rename one")
    for study, _ in studies:
        plots.check(study)
    if arguments.figure:
        plots.check_file([study for study, _ in studies], arguments.figure)
    for study, folder in studies:
        say(console, f"{folder.name}: {study.plan.count:,} runs, {study.plan.kind}")
        begun = time.perf_counter()
        study.run_to_files(
            folder, arguments.workers, arguments.scheduler, arguments.format, arguments.chunk, console=console
        )
        _tell(study, folder, time.perf_counter() - begun, console)
    if arguments.figure:
        _draw(studies, arguments.figure, console)
        return
    for study, folder in studies:
        if study.plots:
            _draw([(study, folder)], folder / f"{folder.name}.png", console)


def _draw(studies: list[tuple[Study, Path]], path: Path, console: Console) -> None:
    from dualcam.study import plots

    plots.draw(studies, path)
    say(console, f"drawn: {path}")


def _tell(study: Study, folder: Path, seconds: float, console: Console) -> None:
    messages = read_results(folder, ["message"])["message"]
    failed = messages[messages != ""]
    say(console, f"{len(messages):,} runs in {folder}, {seconds:.1f} s now")
    if len(failed):
        kinds, counts = np.unique(failed.astype(str), return_counts=True)
        first = kinds[np.argmax(counts)]
        say(console, f"{len(failed):,} failed, such as: {first}")
