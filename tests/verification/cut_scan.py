"""How many random scenes depend on how an interval is cut into steps? Scenes are drawn as
tests/test_properties.py draws them, and judged as there (tests/support/cut_dependence.py); a finding does not
end the scan.

    ./build.sh run fuzz-cuts [--minutes N] [--seed N]    # results: tests/verification/results/cut_scan.csv
    ./build.sh run fuzz-cuts --replay FOLDER             # one finding again

Findings come into build/cuts, one folder each.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from rich.console import Console
from rich.progress import Progress

from benchmarks.harness import core, results
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.oracles import cut_dependence, driver, random_scenes
from benchmarks.harness.repository import VERIFICATION
from verification.stress.drive import shipped_library

FINDINGS = core.BUILD / "cuts"
BATCH = 200  # scenes of one call of hypothesis
ROWS = ("Coulomb", "over the speed", "over the load")  # friction
Outcome = cut_dependence.Outcome
Counts = Counter[tuple[str, str]]  # of scenes, by row and outcome
Make = Callable[[], Any]  # of a Driver


def row_of(scene: Any) -> str:
    """The row of the table that the scene's friction laws belong to."""
    values = scene.parameters
    if any(
        values.get(f"cam{i}.{law}") for law in ("friction_load_exponent", "friction_table") for i in (1, 2)
    ):
        return ROWS[2]
    viscous = any(values.get(f"cam{i}.friction_viscous") for i in (1, 2))
    falling = any(values.get(f"cam{i}.friction_peak", 1.0) > 1.0 for i in (1, 2))
    return ROWS[1] if viscous or falling else ROWS[0]


@contextmanager
def instances(library: Any) -> Iterator[Make]:
    """Makes instances, which are freed at the end."""
    made: list[Any] = []

    def make() -> Any:
        made.append(driver.Driver(library))
        return made[-1]

    try:
        yield make
    finally:
        for fmu in made:
            fmu.free()


def keep(scene: Any, verdict: Any, name: str) -> None:
    """A folder of the finding, with copies of its tables."""
    folder = FINDINGS / name
    folder.mkdir(parents=True, exist_ok=True)
    parameters: dict[str, Any] = dict(scene.parameters)
    for key, value in parameters.items():
        if key.endswith("table") and value:
            shutil.copy(value, folder / f"{key}.csv")
            parameters[key] = f"{key}.csv"
    text = {"finding": verdict.text, "parameters": parameters, "curves": scene.curves, "cuts": scene.cuts}
    (folder / "scene.json").write_text(json.dumps(text, indent=1) + "\n", encoding="utf-8")


def kept(folder: Path) -> Any:
    """The scene of a finding."""
    text = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    files = {name: folder / f"{name}.csv" for name in text["parameters"]}
    tables = {name: str(path) for name, path in files.items() if path.exists()}
    return cut_dependence.Scene(text["parameters"] | tables, text["curves"], text["cuts"])


def play_batch(number: int, binary: Path) -> tuple[Counts, list[str]]:
    """The outcomes of one batch of scenes, and its findings."""
    counts: Counts = Counter()
    texts: list[str] = []
    library = driver.load(binary)
    with tempfile.TemporaryDirectory() as tables:

        @seed(number)
        @settings(
            max_examples=BATCH,
            phases=[Phase.generate],
            deadline=None,
            database=None,
            suppress_health_check=list(HealthCheck),
        )
        @given(random_scenes.EXTREME, random_scenes.CURVES, random_scenes.CUTS, st.data())
        def play(drawn: Any, curves: Any, cuts: list[float], data: st.DataObject) -> None:
            parameters = random_scenes.general_with_laws(data, drawn, Path(tables))
            scene = cut_dependence.Scene(parameters, curves, sorted(cuts))
            with instances(library) as make:
                verdict = cut_dependence.judge(make, scene)
            counts[row_of(scene), verdict.outcome] += 1
            if verdict.outcome is Outcome.DEPENDS:
                name = f"{number}-{len(texts)}"
                texts.append(f"{name}: {verdict.text}")
                keep(scene, verdict, name)

        play()
    return counts, texts


def findings(counts: Counts) -> int:
    return sum(counts[row, Outcome.DEPENDS] for row in ROWS)


def scan(minutes: float, first: int, binary: Path, console: Console) -> Counts:
    """Batches on all processors until the time is over. `first`: the seed of the first batch."""
    counts: Counts = Counter()
    workers, seconds = os.cpu_count() or 1, 60.0 * minutes
    start, number = time.monotonic(), first + 2 * workers
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context) as pool, Progress(console=console) as progress:
        bar = progress.add_task("", total=seconds)
        running = [pool.submit(play_batch, first + i, binary) for i in range(2 * workers)]
        while running:
            found, texts = running.pop(0).result()
            counts += found
            results.say(console, *texts)
            passed = time.monotonic() - start
            if passed < seconds:
                running.append(pool.submit(play_batch, number, binary))
                number += 1
            text = f"{counts.total()} scenes, {findings(counts)} findings"
            progress.update(bar, completed=min(passed, seconds), description=text)
    return counts


def rows_of(counts: Counts) -> list[dict[str, str]]:
    """The table: a row for each kind of friction."""
    rows = []
    for row in ROWS:
        cells = {str(outcome): counts[row, outcome] for outcome in Outcome}
        numbers = {"scenes": sum(cells.values()), **cells}
        rows.append({"friction": row, **{name: str(n) for name, n in numbers.items()}})
    return rows


def report(rows: Sequence[Mapping[str, str]], console: Console) -> None:
    shown = results.table("Random scenes, played in whole intervals and in cut ones", *rows[0])
    for row in rows:
        shown.add_row(*row.values())
    console.print(shown)


def replay(folder: Path, binary: Path, console: Console) -> bool:
    """Whether the scene of that folder still is a finding."""
    with instances(driver.load(binary)) as make:
        verdict = cut_dependence.judge(make, kept(folder))
    results.say(console, f"{verdict.outcome}: {verdict.text}".rstrip(": "))
    return verdict.outcome is Outcome.DEPENDS


def main() -> int:
    parser = results.options(__doc__, "cut_scan", folder=VERIFICATION / "results")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0, help="of the first batch (0)")
    parser.add_argument("--replay", type=Path, help="the folder of a finding, which is played again")
    arguments = parser.parse_args()
    console, binary = results.new_console(), shipped_library()
    if arguments.replay:
        return int(replay(arguments.replay, binary, console))
    counts = scan(arguments.minutes, arguments.seed, binary, console)
    rows = rows_of(counts)
    report(rows, console)
    results.publish(rows, circumstances("fuzz cuts"), arguments.output, console)
    return int(findings(counts) > 0)


if __name__ == "__main__":
    sys.exit(main())
