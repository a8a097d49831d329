"""Draws modelDescription/model.png, the icon of both FMUs:

    python fmu_src/tools/draw_icon.py

Not part of the build: what matplotlib draws depends on its version, so the file is committed.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ICON = Path(__file__).resolve().parent.parent.parent / "modelDescription/model.png"
SIZE = 192  # pixels
STEEL, DARK, GROOVE_1, GROOVE_2 = "#d5dce3", "#57606a", "#0969da", "#bc4c00"


def draw(path: Path) -> None:
    """Cam 1 below, cam 2 above, each with its groove, the pin where they meet, the spring on top."""
    figure = plt.figure(figsize=(2, 2), dpi=SIZE / 2)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(-1, 1), ylim=(-1, 1))
    axes.axis("off")
    axes.add_patch(plt.Rectangle((-0.62, -0.92), 1.24, 1.2, facecolor=STEEL, edgecolor=DARK, linewidth=2.5))
    turn = np.linspace(-1.15, 1.15, 100)  # angle on the cylinder; the visible half
    for sign, colour in ((1, GROOVE_1), (-1, GROOVE_2)):
        axes.plot(0.62 * np.sin(turn), -0.32 + sign * 0.4 * turn, color=colour, linewidth=7, alpha=0.9)
    coil = np.linspace(0, 1, 200)
    axes.plot(0.36 * np.sin(9 * np.pi * coil), 0.3 + 0.58 * coil, color=DARK, linewidth=3.5)
    axes.plot([-0.62, 0.62], [0.92, 0.92], color=DARK, linewidth=5, solid_capstyle="round")
    axes.plot([0, 0], [-0.32, 0.3], color=DARK, linewidth=4)
    axes.plot(0, -0.32, "o", markersize=17, markerfacecolor="white", markeredgecolor=DARK, markeredgewidth=3)
    figure.savefig(path, transparent=True, metadata={"Software": None})


if __name__ == "__main__":
    draw(ICON)
