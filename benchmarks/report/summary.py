"""The first lines of the page: the numbers that most readers look for, with links to their sections."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.harness.markdown import Row, prose, read, rounded, row_of
from benchmarks.report.precision import LEVELS, best_time
from benchmarks.report.worst_step import Found


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
