"""The command: judges all scenes in processes of their own and writes their outcomes."""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from benchmarks.harness import results
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import VERIFICATION
from benchmarks.harness.results import say
from verification import stress
from verification.processes import Lost, in_processes
from verification.stress.drive import Libraries, prepare
from verification.stress.families import ROWS, collect
from verification.stress.judges import judge
from verification.stress.mechanisms import Tables
from verification.stress.scene import Scene, Verdict
from verification.stress.table import HEAD, Row, describe, published

HANG = 300.0  # s, after which a process is ended


def judge_in_process(paths: Libraries) -> Callable[[Scene], Verdict]:
    """The work of a process that judges scenes."""
    np.seterr(all="ignore")
    warnings.simplefilter("ignore")  # of a reference at the end of its range, which then counts as none
    libraries = paths.load()

    def judged(scene: Scene) -> Verdict:
        try:
            return judge(scene, libraries)
        except Exception:
            return Verdict(problems=["the test itself failed: " + traceback.format_exc(limit=-3)])

    return judged


def verdicts(scenes: Sequence[Scene], paths: Libraries, workers: int) -> Iterator[tuple[Scene, Verdict]]:
    for scene, found in in_processes(scenes, partial(judge_in_process, paths), workers, HANG):
        yield scene, Verdict(problems=[found.reason]) if isinstance(found, Lost) else found


def judge_all(
    scenes: Sequence[Scene], workers: int, with_notes: bool, console: Console
) -> tuple[list[Row], list[str]]:
    """The rows of the table, and the details of every wrong scene. `with_notes`: of the others too."""
    details: list[str] = []
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as progress:
        counts = Counter(scene.row for scene in scenes)
        tasks = {name: progress.add_task(name, total=count) for name, count in counts.items()}
        rows = {name: Row(name) for name in tasks}
        for scene, verdict in verdicts(scenes, prepare(), workers):
            rows[scene.row].add(scene, verdict)
            progress.advance(tasks[scene.row])
            if verdict.problems:
                text = f"{scene.row}: {scene.label}: " + "; ".join(verdict.problems)
                say(console, text[:500])
                details.append(f"{text}\n{describe(scene)}\n")
            elif verdict.note and with_notes:
                details.append(f"({scene.row}: {scene.label}: {verdict.note})\n")
    return list(rows.values()), details


def main() -> int:
    parser = results.options(stress.__doc__, "stress", folder=VERIFICATION / "results")
    parser.add_argument("--rows", default=",".join(ROWS), help="names, with commas between")
    parser.add_argument(
        "--fuzz",
        type=int,
        default=3000,
        help="scenes at random of each such row (default 3000); of fuzz_loads an eighth",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the scenes at random")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--details", type=Path, help="write every wrong scene, in full, to this file")
    arguments = parser.parse_args()
    names = arguments.rows.split(",")
    unknown = sorted(set(names) - set(ROWS))
    if unknown:
        parser.error(f"no such rows: {', '.join(unknown)}; there are {', '.join(ROWS)}")
    console, facts = Console(), circumstances("stress", "scipy", "numpy")
    with tempfile.TemporaryDirectory() as folder:
        scenes = collect(names, arguments.fuzz, Tables(Path(folder)), arguments.seed)
        rows, details = judge_all(scenes, arguments.workers, bool(arguments.details), console)
    say(console, " | ".join(HEAD), *(" | ".join(row.cells()) for row in rows))
    results.publish([published(row) for row in rows], facts, arguments.output, console)
    if arguments.details:
        arguments.details.write_text("\n".join(details))
    return 1 if any(row.wrong for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
