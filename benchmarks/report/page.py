"""The page docs/performance.md: summary, all sections, and the circumstances of their measurements."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.harness.circumstances import FACTS
from benchmarks.harness.markdown import Row, prose, read, rounded, row_of, table
from benchmarks.harness.repository import DOCS
from benchmarks.report.friction_cost import friction_cost
from benchmarks.report.others import growth, loop, platform_cost, skipping
from benchmarks.report.precision import LEVELS, best_time, precision
from benchmarks.report.step_cost import step_cost
from benchmarks.report.worst_step import Found, worst_step

FILES = ("work_precision", "step_cost", "worst_step", "skipping", "growth", "loop")


def in_us(row: Row) -> str:
    return rounded(str(1e-3 * float(row["ns_per_step"])))


def times_of_fmu(rows: Sequence[Row], scene: str, lines: Sequence[str], level: float) -> float | None:
    """Run time of the fastest of these lines over that of the FMU from C."""
    own = best_time(rows, scene, "FMU from C", level)
    times = [time for line in lines if (time := best_time(rows, scene, line, level)) is not None]
    return min(times) / own if own is not None and times else None


def span(ratios: Iterable[float | None]) -> str:
    known = [ratio for ratio in ratios if ratio is not None]
    return f"{rounded(str(min(known)))} to {rounded(str(max(known)))} times" if known else "not measured"


def summary(folder: Path) -> str:
    steps, rows, worst = read(folder, "step_cost"), read(folder, "work_precision"), Found(folder)
    helices, ellipses = (in_us(row_of(steps, scene=scene)) for scene in ("slip undamped", "ellipses"))
    longest = ", ".join(f"{worst.in_us(scene, 'all', 'ns_worst')} us ({scene})" for scene in worst.scenes)
    scenes = dict.fromkeys(row["scene"] for row in rows)
    solvers = [line for line in dict.fromkeys(row["line"] for row in rows) if line.startswith("SciPy ")]
    scipy = ", ".join(
        f"{span(times_of_fmu(rows, scene, solvers, level) for scene in scenes)} (error at most {level:g})"
        for level in LEVELS
    )
    through_fmpy = span(times_of_fmu(rows, scene, ["FMU from FMPy"], LEVELS[0]) for scene in scenes)
    per_turn = rounded(row_of(read(folder, "loop"), way="cam")["us"])
    items = [
        f"""- [One step](#one-step) of 1 ms in slip, called from C, takes {helices} us in helices and
        {ellipses} us in ellipses.""",
        f"""- [The worst step](#the-worst-step) of {rounded(worst.whole(worst.scenes[0])["steps"])} steps
        takes {longest}.""",
        f"""- [SciPy's best solver](#run-time-against-error) takes a multiple of the FMU's run time from C:
        {scipy}. Each range is that of four scenes. SciPy evaluates the equations in Python.""",
        f"""- Through FMPy the FMU itself takes {through_fmpy} as long as from C, since FMPy's calls cost more
        than short steps. One turn of a [control loop](#a-control-loop-in-python) in Python takes {per_turn}
        us.""",
    ]
    return "\n".join(prose(item) for item in items)


# Not a part of `./build.sh run bench`, which also runs where valgrind, wine and qemu are missing.
OPTIONAL = {"friction_cost": friction_cost, "platform_cost": platform_cost}


def measured(folder: Path) -> list[str]:
    """Those of OPTIONAL that have results."""
    return [name for name in OPTIONAL if (folder / f"{name}.csv").exists()]


def circumstances(folder: Path) -> str:
    cells = []
    for name in (*FILES, *measured(folder)):
        row = read(folder, name)[0]
        cells.append([f"`benchmarks/results/{name}.csv`", *(row[fact] for fact in FACTS)])
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
