"""Tables, verdicts, the CSV file and the picture of the comparison."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from pathlib import Path

from matplotlib.axes import Axes
from rich.console import Console
from rich.table import Table

from benchmarks.harness import pictures
from benchmarks.harness import results as harness
from benchmarks.harness.results import say
from benchmarks.harness.timing import Ratio
from benchmarks.work_precision.lines import OURS, SCIPY
from benchmarks.work_precision.study import Setting, Study

LEVELS = [1e-2, 1e-4, 1e-6, 1e-8, 1e-10]
TARGETS = (("SciPy", 1000.0), ("CVode on our ME", 100.0), ("scikit-sundae", 100.0), ("PythonFMU", 1000.0))
TARGET_LEVEL = 1e-8


def cell(made: Study, line: str, level: float) -> str:
    ratio = made.ratio(line, level)
    if ratio is not None:
        return f"{ratio.median:.3g}"
    return "no" if made.best(line, level) is None else "we: no"


def table_of(made: Study) -> Table:
    table = harness.table(
        f"{made.scene.name}: {made.scene.description}",
        "times as long, at error",
        *(f"{level:g}" for level in LEVELS),
        "least error",
        "failed",
    )
    table.add_row(
        "FMU from C, us per simulated s",
        *(f"{1e6 * s.time:.3g}" if (s := made.best(OURS, level)) else "no" for level in LEVELS),
        f"{min(s.error for s in made.usable(OURS)):.1e}",
        str(sum(1 for s in made.settings if s.line == OURS and s.failure)),
    )
    for line in made.lines:
        if line != OURS:
            failed = sum(1 for s in made.settings if s.line == line and s.failure)
            least = min((s.error for s in made.usable(line)), default=math.nan)
            table.add_row(line, *(cell(made, line, level) for level in LEVELS), f"{least:.1e}", str(failed))
    return table


def against(made: Study, prefix: str) -> float | None:
    """The least ratio at TARGET_LEVEL of the lines whose names start so. None if no such line reaches the
    error."""
    ratios = [made.ratio(line, TARGET_LEVEL) for line in made.lines if line.startswith(prefix)]
    return min((r.median for r in ratios if r), default=None)


def verdicts(studies: list[Study]) -> list[str]:
    found = []
    for prefix, target in TARGETS:
        for made in studies:
            least = against(made, prefix)
            if not any(line.startswith(prefix) for line in made.lines):
                result = "not measured"
            elif least is None:
                result = "does not get there"
            else:
                result = f"{least:.4g} {'met' if least >= target else 'MISSED'}"
            found.append(f"{prefix}, {made.scene.name}, error {TARGET_LEVEL:g}: >= {target:g}: {result}")
    wins = [
        f"{line} at {level:g} in {made.scene.name} ({1.0 / ratio.median:.2f} times as fast)"
        for made in studies
        for line in made.lines
        for level in LEVELS
        if not line.startswith("FMU")
        if (ratio := made.ratio(line, level)) and ratio.median < 1.0
    ]
    found.append(
        "A peer wins: " + ("; ".join(wins) + " MISSED" if wins else "nowhere, at none of the levels")
    )
    return found


def report(studies: list[Study], console: Console) -> None:
    for made in studies:
        console.print(table_of(made))
        say(console, *(f"reference against {name}: {error:.1e}" for name, error in made.checks))
        say(console, *(f"failed: {s.line}, {s.name}: {s.failure}" for s in made.settings if s.failure))
        console.print()
    for line in verdicts(studies):
        console.print(line, highlight=False, markup=False, soft_wrap=True)


def write(path: Path, studies: list[Study], facts: Mapping[str, str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            [
                *("scene", "line", "setting", "error_theta", "error_omega", "error_energy"),
                *("us_per_simulated_s", "ratio_to_best_fmu_from_c_at_least_as_exact", "failure"),
            ]
        )
        for made in studies:
            for s in made.settings:
                ours = made.best(OURS, s.error) if s.times else None
                ratio = f"{Ratio.of(s.times, ours.times).median:.4g}" if ours else ""
                seconds = s.time if s.times else s.first / made.scene.duration
                cost = f"{1e6 * seconds:.4g}" if s.run else ""
                errors = [f"{e:.2e}" if e == e else "" for e in s.errors]
                writer.writerow([made.scene.name, s.line, s.name, *errors, cost, ratio, s.failure])
            for name, error in made.checks:
                writer.writerow([made.scene.name, "reference", name, f"{error:.2e}", "", "", "", "", ""])
        for name, value in facts.items():
            writer.writerow([f"# {name}: {value}"])


STYLES: dict[str, tuple[str, str, str]] = {  # colour, marker, line
    OURS: ("black", "o", "-"),
    "FMU with ledger": ("0.45", "o", "-"),
    "FMU from FMPy": ("0.45", "o", ":"),
    **{f"SciPy {m}": (c, "s", "-") for m, c in zip(SCIPY, ("C0", "C9", "C2", "C4"), strict=True)},
    **{f"tanh, {m}": (c, "x", ":") for m, c in zip(SCIPY, ("C0", "C9", "C2", "C4"), strict=True)},
    "CVode on our ME": ("C3", "D", "-"),
    "scikit-sundae": ("C1", "v", "-"),
    "PythonFMU": ("C5", "P", "-"),
    "hand-written FMU": ("C6", "^", "--"),
}


def front(settings: list[Setting]) -> list[Setting]:
    """The settings that are clearly more exact than all faster ones."""
    kept: list[Setting] = []
    for s in sorted(settings, key=lambda s: (s.time, s.error)):
        if not kept or s.error < 0.8 * kept[-1].error:
            kept.append(s)
    return kept


def draw(panel: Axes, made: Study) -> None:
    for line in made.lines:
        colour, marker, style = STYLES[line]
        best = front(made.usable(line))
        panel.loglog(
            [max(s.error, 1e-16) for s in best],
            [s.time for s in best],
            style,
            marker=marker,
            ms=8 if line == OURS else 5,
            lw=2.6 if line == OURS else 1.1,
            color=colour,
            label=line,
        )
        if line == OURS:  # the same time for any larger error
            panel.loglog([1.0, best[0].error], [best[0].time] * 2, "--", color=colour, lw=1.0)
    panel.set_title(made.scene.name, fontsize=11)
    panel.set_xlim(1.0, 1e-16)
    panel.grid(True, which="major", alpha=0.3)


def picture(studies: list[Study], facts: Mapping[str, str], path: Path) -> None:
    figure = pictures.sheet(13.0, 10.0)
    axes = figure.subplots(2, 2, sharex=True)
    for panel, made in zip(axes.flat, studies, strict=True):
        draw(panel, made)
    for panel in axes[:, 0]:
        panel.set_ylabel("run time per simulated second [s]")
    for panel in axes[1]:
        panel.set_xlabel("largest error of angle, speed and energy, relative")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncol=5, fontsize=10)
    figure.suptitle(
        "Run time against error: each line's best settings, lower and further right is better", fontsize=13
    )
    pictures.finish(figure, facts, path)
