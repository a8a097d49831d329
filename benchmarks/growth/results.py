"""Rows, table and picture of the growth."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.table import Table

from benchmarks.growth.measure import START_UP
from benchmarks.harness import pictures
from benchmarks.harness import results as harness

Found = dict[tuple[str, str, float], list[tuple[float, float]]]  # what, unit, size -> seconds, bytes per unit


def rows_of(found: Found) -> list[dict[str, str]]:
    rows: list[dict[str, str]] = []
    smallest: dict[str, list[float]] = {}
    for (what, unit, size), values in found.items():
        times = [seconds for seconds, _ in values]
        first = smallest.setdefault(what, times)
        ratio = statistics.median(a / b for a, b in zip(times, first, strict=True))
        largest = max(gained for _, gained in values)  # of the first round: later ones reuse the memory
        rows.append(
            {
                "what": what,
                "size": f"{size:g}",
                "us_per_unit": f"{1e6 * statistics.median(times):.4g}",
                "unit": unit,
                "ratio_to_smallest": f"{ratio:.4g}",
                "bytes_per_unit": f"{largest:.0f}" if largest == largest else "",
            }
        )
    return rows


def table_of(rows: Sequence[Mapping[str, str]]) -> Table:
    table = harness.table(
        "Growth", "what", "size", "us per unit", "unit", "to the smallest", "bytes per unit"
    )
    for row in rows:
        ratio = f"{float(row['ratio_to_smallest']):.3g}"
        table.add_row(row["what"], row["size"], row["us_per_unit"], row["unit"], ratio, row["bytes_per_unit"])
    return table


PANELS = (
    ("Instances", ("instances: instantiate", "instances: initialise", "instances: step")),
    ("Steps", ("steps",)),
    ("Table points", ("table points: initialise", "table points: step", "table points: knot passed")),
)


def picture(rows: Sequence[Mapping[str, str]], facts: Mapping[str, str], path: Path) -> None:
    """Time per unit over the number of units, start-up beside it."""
    figure, panels = pictures.blank(13.0, 8.2, rows=2, columns=2)
    for panel, (title, whats) in zip(panels, PANELS, strict=False):
        for number, what in enumerate(whats):
            found = [row for row in rows if row["what"] == what]
            sizes, times = ([float(row[name]) for row in found] for name in ("size", "us_per_unit"))
            label = f"{what.split(': ')[-1].removesuffix('s')}, per {found[0]['unit']}"
            if float(found[-1]["bytes_per_unit"] or 0.0) > 1.0:
                label += f", {float(found[-1]['bytes_per_unit']):.0f} bytes"
            panel.loglog(sizes, times, "o-", color=f"C{number}", ms=4, label=label)
        panel.set_title(title, fontsize=11, pad=10)
        panel.set_xlabel(f"number of {title.lower()}")
        panel.set_ylabel("time per unit [us]")
        low, high = panel.get_ylim()
        panel.set_ylim(low / 2.0, high * 4.0)  # a flat cost must look flat, and the legend needs room
        panel.legend(loc="upper left", frameon=False, fontsize=9, ncol=2)
    bar, left = panels[-1], 0.0
    for number, name in enumerate(START_UP):
        time = next(float(row["us_per_unit"]) for row in rows if row["what"] == f"start-up: {name}")
        bar.barh(0, time, 0.5, left=left, color=f"C{number}", label=f"{name}, {time:.0f} us")
        left += time
    bar.set_ylim(-1.0, 1.4)
    bar.set_yticks([])
    bar.grid(False, axis="y")
    bar.set_xlabel("time [us]")
    bar.set_title(f"From nothing to the end of the first step: {left:.0f} us", fontsize=11, pad=10)
    bar.legend(loc="upper center", ncol=2, frameon=False, fontsize=9)
    pictures.finish(figure, facts, path)
