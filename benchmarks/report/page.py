"""The page docs/performance.md: all sections, and the circumstances of their measurements."""

from __future__ import annotations

import os
from pathlib import Path

from benchmarks.harness.circumstances import FACTS
from benchmarks.harness.markdown import prose, read, table
from benchmarks.harness.repository import DOCS
from benchmarks.report.friction_cost import friction_cost
from benchmarks.report.others import growth, loop, skipping
from benchmarks.report.platform_cost import platform_cost
from benchmarks.report.precision import precision
from benchmarks.report.step_cost import step_cost
from benchmarks.report.summary import summary
from benchmarks.report.worst_step import worst_step

FILES = ("work_precision", "step_cost", "worst_step", "skipping", "growth", "loop")


# Not a part of `./build.sh run bench`, which also runs where valgrind, wine and qemu are missing.
OPTIONAL = {"friction_cost": friction_cost, "platform_cost": platform_cost}


def measured(folder: Path) -> list[str]:
    """Those of OPTIONAL that have results."""
    return [name for name in OPTIONAL if (folder / f"{name}.csv").exists()]


def circumstances(folder: Path) -> str:
    cells = []
    for name in (*FILES, *measured(folder)):
        row = read(folder, name)[0]
        cells.append([f"`{name}.csv`", *(row[fact] for fact in FACTS)])
    return "## Circumstances\n\n" + table(["file", *FACTS], cells)


def integrators(place: Path) -> str:
    """The result of a study that was made once. The link to its picture is written from docs/."""
    text = Path(__file__).with_name("integrators.md").read_text(encoding="utf-8").rstrip()
    return text.replace("integrators.png", Path(os.path.relpath(DOCS / "integrators.png", place)).as_posix())


def page(results: Path, place: Path) -> str:
    """The text of the page. `place`: its folder, from which the pictures are linked."""

    def picture(name: str) -> str:
        return Path(os.path.relpath(results / f"{name}.png", place)).as_posix()

    return (
        "\n\n".join(
            [
                "# How fast, and how near to the limit",
                summary(results),
                prose(
                    """`python -m benchmarks.report` writes this page at the end of `./build.sh run bench`
                    (about seven minutes) from `benchmarks/results/*.csv`, which have the spreads too. Every
                    part has a command of its own, which the last table names."""
                ),
                precision(results, picture("work_precision")),
                step_cost(results, picture("step_cost")),
                *(OPTIONAL[name](results) for name in measured(results)),
                worst_step(results, picture("worst_step")),
                skipping(results, picture("skipping")),
                growth(results, picture("growth")),
                loop(results),
                integrators(place),
                circumstances(results),
            ]
        )
        + "\n"
    )
