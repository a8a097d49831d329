"""The section on run time against error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.harness.markdown import Row, prose, read, rounded, row_of, table

LEVELS = (1e-4, 1e-8)


def best_time(rows: Sequence[Row], scene: str, line: str, level: float) -> float | None:
    """The least time of a setting with at most that error [us per simulated s]."""
    times = [
        float(row["us_per_simulated_s"])
        for row in rows
        if row["scene"] == scene and row["line"] == line and row["us_per_simulated_s"]
        if not row["failure"] and worst_error(row) <= level
    ]
    return min(times, default=None)


def precision(folder: Path, picture: str) -> str:
    rows = read(folder, "work_precision")
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    lines = [line for line in dict.fromkeys(row["line"] for row in rows) if line != "reference"]

    def best(scene: str, line: str, level: float) -> float | None:
        return best_time(rows, scene, line, level)

    def cell(scene: str, line: str, level: float) -> str:
        time, own = best(scene, line, level), best(scene, "FMU from C", level)
        if time is None or own is None:
            return "no"
        return f"{rounded(str(time))} us" if line == "FMU from C" else rounded(str(time / own))

    parts = [
        "## Run time against error",
        f"![Run time against error]({picture})",
        prose(
            """There are four scenes. The error is the largest of the errors in angle, speed and dissipated
            energy, each relative to the largest size of its quantity. Two methods agree on the references.
            Every way to simulate runs at the best of its settings for the error. The FMU is stepped from C
            without its ledger, because no other way keeps one. The row "FMU from C" gives the run time per
            simulated second. All other rows give the run time divided by that of the FMU. "no": the error is
            not reached in one second of computing."""
        ),
    ]
    for level in LEVELS:
        parts.append(f"At an error of at most {level:g}:")
        cells = [[line, *(cell(scene, line, level) for scene in scenes)] for line in lines]
        parts.append(table(["", *scenes], cells))
    return "\n\n".join([*parts, *why_not_more(folder, best)])


def why_not_more(folder: Path, best: Callable[[str, str, float], float | None]) -> list[str]:
    """The limit of the ratio to SciPy: its evaluations of the equations at the price of C."""
    price = 1e-3 * float(row_of(read(folder, "step_cost"), scene="evaluation")["ns_per_step"])
    cells = []
    for row in read(folder, "evaluations"):
        number, own = float(row["evaluations_per_simulated_s"]), best(row["scene"], "FMU from C", LEVELS[-1])
        bare = price * number
        cells.append(
            [
                row["scene"],
                f"{row['line'].removeprefix('SciPy ')}, {row['setting']}",
                rounded(row["us_per_simulated_s"]),
                rounded(row["evaluations_per_simulated_s"]),
                rounded(row["us_per_evaluation"]),
                rounded(str(bare)),
                rounded(str(float(row["us_per_simulated_s"]) / bare)),
                rounded(str(own)) if own else "",
            ]
        )
    return [
        prose(
            f"""SciPy's time consists of evaluations of the equations in Python. The table has its fastest
            setting with an error of at most {LEVELS[-1]:g}. An evaluation in C takes {
                rounded(str(1e3 * price))
            } ns, in elliptical grooves with every force. The column "us per s, in C" is the time of as
            many evaluations at that price, without step control, search for events and implicit solution.
            "factor" is SciPy's time divided by that time. A larger ratio to SciPy needs fewer evaluations, as
            the closed form has them. The last column is the time of the FMU, with all that it does."""
        ),
        table(
            [
                "scene",
                "SciPy",
                "us per s",
                "evaluations per s",
                "us each",
                "us per s, in C",
                "factor",
                "FMU, us per s",
            ],
            cells,
        ),
    ]


def worst_error(row: Row) -> float:
    return max(float(row[f"error_{name}"] or "inf") for name in ("theta", "omega", "energy"))
