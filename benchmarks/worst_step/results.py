"""Rows, tables and the picture of the worst steps."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from benchmarks.harness import instructions, pictures
from benchmarks.harness import results as harness
from benchmarks.worst_step.bound import bound, bound_rows
from benchmarks.worst_step.history import plural
from benchmarks.worst_step.study import Study

CHANGES = (0, 1, 2, 3, 6, 11, 21, 41, math.inf)  # mode changes of a step, in groups
QUANTILES = (0.5, 0.9, 0.99, 0.999, 0.9999, 1.0)


def rows_of(made: Study) -> Iterator[dict[str, str]]:
    """Quantiles of the time, then the largest cost of each kind of step and of each number of mode
    changes."""

    def row(what: str, mask: NDArray[np.bool_], happens: str = "") -> dict[str, str]:
        times = made.seconds[mask]
        return {
            "scene": made.scene.name,
            "what": what,
            "steps": str(int(mask.sum())),
            "ns_median": f"{1e9 * np.median(times):.0f}" if len(times) else "",
            "ns_worst": f"{1e9 * times.max():.0f}" if len(times) else "",
            "instructions_worst": f"{n}" if (n := made.counted(mask)) else "",
            "instructions_per_change_worst": f"{n}" if (n := made.counted_per_change(mask)) else "",
            "happens": happens,
            "limit": "",
        }

    everything = np.ones(len(made.seconds), dtype=bool)
    yield row("not counted", made.uncounted)
    yield row("all", everything, made.history.story(int(made.chosen[made.worst])))
    for q in QUANTILES:
        at_least = made.seconds >= np.quantile(made.seconds, q, method="higher")
        yield {
            **row(f"quantile {q:g}", at_least),
            "ns_median": f"{1e9 * float(np.quantile(made.seconds, q)):.0f}",
        }
    for kind, mask in made.history.kinds().items():
        yield row(kind, mask)
    for low, high in pairwise(CHANGES):
        mask = (made.history.changes >= low) & (made.history.changes < high)
        name = (
            f"{low}" if high == low + 1 else f"{low} to {high - 1}" if high < math.inf else f"{low} and more"
        )
        yield row(plural(1) if name == "1" else f"{name} mode changes", mask)


def rows_of_bound() -> Iterator[dict[str, str]]:
    measured = ("steps", "ns_median", "ns_worst", "instructions_worst", "instructions_per_change_worst")
    for what, number, why in bound_rows():
        empty = dict.fromkeys(measured, "")
        yield {"scene": "bound", "what": what, **empty, "happens": why, "limit": f"{number:.6g}"}


COLOURS = ("C0", "C3", "C2", "C1")


def picture(studies: list[Study], facts: Mapping[str, str], path: Path) -> None:
    figure, (spread, relation) = pictures.blank(12.5, 5.2, columns=2)
    for made, colour in zip(studies, COLOURS, strict=False):
        seconds = np.sort(made.seconds)[::-1]
        share = np.arange(1, len(seconds) + 1) / len(seconds)
        keep = np.unique(np.geomspace(1, len(seconds), 600).astype(int)) - 1
        spread.loglog(1e6 * seconds[keep], share[keep], color=colour, lw=1.8, label=made.scene.name)
        spread.plot(1e6 * seconds[0], share[0], "o", color=colour, ms=6)
        times = 1e6 * made.seconds[made.chosen]
        if not made.instructions.any():
            continue
        relation.loglog(times, made.instructions, ".", color=colour, ms=3, alpha=0.5)
        w = made.worst
        relation.plot(times[w], int(made.instructions[w]), "o", color=colour, ms=7, label=made.scene.name)
    spread.set_xlabel("time of a step [us]")
    spread.set_ylabel("share of steps that take longer")
    spread.set_title(f"{len(studies[0].seconds):,} steps of 1 ms", fontsize=11)
    spread.legend(frameon=False)
    relation.set_xlabel("time of a step [us]")
    relation.set_ylabel("instructions")
    relation.set_title("Counted steps, with the worst of each run", fontsize=11)
    if any(made.instructions.any() for made in studies):
        relation.legend(frameon=False)
    else:
        relation.text(0.5, 0.5, instructions.WITHOUT, ha="center", transform=relation.transAxes)
    pictures.finish(figure, facts, path)


def report(studies: list[Study], console: Console) -> None:
    for made in studies:
        table = harness.table(
            f"{made.scene.name}: {made.scene.description}",
            "steps",
            "number",
            "ns, median",
            "ns, worst",
            "instructions, worst",
        )
        for row in rows_of(made):
            table.add_row(
                *(row[name] for name in ("what", "steps", "ns_median", "ns_worst", "instructions_worst"))
            )
        console.print(table)
        worst = int(made.chosen[made.worst])
        console.print(
            f"Worst: step {worst}, {made.instructions[made.worst]} instructions,"
            f" {1e6 * made.seconds[worst]:.2f} us: {made.history.story(worst)}",
            highlight=False,
        )
        missing = [kind for kind, mask in made.history.kinds().items() if not mask.any()]
        if missing:
            console.print(f"not met in this run: {', '.join(missing)}", highlight=False)
    b = bound()
    console.print(
        f"Bound: {b.evaluations_per_step:.2g} evaluations of the balance of forces in a step,"
        f" {b.evaluations_per_segment:.2g} per segment of it.",
        highlight=False,
    )
