"""The sheet of the benchmarks' pictures: panels, and a footer with the circumstances of the measurement."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure
from numpy.typing import NDArray

PALE, ACCENT = "0.72", "C0"
FOOTER = 0.5  # inches


def sheet(width: float, height: float) -> SubFigure:
    """The part of a new figure above its footer. `width`, `height`: of this part, in inches."""
    figure = plt.figure(figsize=(width, height + FOOTER), layout="constrained")
    parts: NDArray[Any] = figure.subfigures(2, 1, height_ratios=[height, FOOTER])  # type: ignore[assignment]
    return parts[0]


def blank(width: float, height: float, rows: int = 1, columns: int = 1) -> tuple[SubFigure, list[Axes]]:
    """A sheet and its panels, row by row. `width`, `height`: inches."""
    body = sheet(width, height)
    panels = list(body.subplots(rows, columns, squeeze=False).flat)
    for panel in panels:
        panel.spines[["top", "right"]].set_visible(False)
        panel.grid(True, which="major", alpha=0.25)
        panel.set_axisbelow(True)
    return body, panels


def finish(body: SubFigure, facts: Mapping[str, str], path: Path) -> None:
    """Writes the footer and saves the figure. `facts`: of circumstances.circumstances()."""
    figure = body.get_figure(root=True)
    first = f"{facts['command']}    commit {facts['commit']}    {facts['date']}"
    words = f"{first}\n{facts['machine']}\n{facts['versions']}"
    figure.subfigs[1].text(0.01, 0.5, words, fontsize=7, color="0.45", ha="left", va="center")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)
