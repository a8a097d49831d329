"""The picture of the comparison: run time against error, one panel per scene."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from matplotlib.axes import Axes

from benchmarks.harness import pictures
from benchmarks.work_precision.lines import OURS, SCIPY
from benchmarks.work_precision.study import Setting, Study

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
