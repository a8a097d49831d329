"""What the benchmarks' pictures have in common."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

INK, PALE, ACCENT = "0.15", "0.72", "C0"


def blank(
    width: float, height: float, rows: int = 1, columns: int = 1, **options: object
) -> tuple[Figure, list]:
    """A figure and its panels in a row."""
    figure, axes = plt.subplots(
        rows, columns, figsize=(width, height), layout="constrained", squeeze=False, **options
    )
    for panel in axes.flat:
        panel.spines[["top", "right"]].set_visible(False)
        panel.grid(True, which="major", alpha=0.25)
        panel.set_axisbelow(True)
    return figure, list(axes.flat)


def finish(figure: Figure, facts: Mapping[str, str], path: Path) -> None:
    """Writes it with the circumstances below."""
    first = f"{facts['command']}    commit {facts['commit']}    {facts['date']}"
    figure.supxlabel(
        f"{first}\n{facts['machine']}\n{facts['versions']}", fontsize=7, color="0.45", x=0.01, ha="left"
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)
