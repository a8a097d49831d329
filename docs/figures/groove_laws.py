"""Draws docs/groove_laws.svg for docs/use-grooves.md: a helix, an ellipse and a cycloid of the same rise.

Run by `./build.sh run figures`."""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

from dualcam.design import Cycloid, Ellipse, Helix
from dualcam.plots.design import BLUE, GREEN, ORANGE

DOCS = Path(__file__).resolve().parents[1]
RADIUS, RISE, ANGLE = 0.02, 0.015, 1.2  # m, m, rad
PARTS = {"z [mm]": 1e3, "dz/dψ [mm/rad]": 1e3, "d²z/dψ² [mm/rad²]": 1e3}


def ellipse() -> Ellipse:
    """The ellipse of that rise which flattens until it is level: its lead angle follows from a = b."""

    def arc(lead: float) -> Ellipse:
        axis = ANGLE * RADIUS / np.sin(lead)
        return Ellipse(RADIUS, lead, axis, axis)

    lead = brentq(lambda angle: float(arc(angle).at(ANGLE).z) - RISE, 0.1, 1.5)
    return arc(lead)


def draw() -> Figure:
    """z, slope and second derivative over the angle, each law with a level dwell beside both ends."""
    laws = {
        "helix": (Helix(RADIUS, np.arctan(RISE / RADIUS / ANGLE)), BLUE),
        "ellipse": (ellipse(), ORANGE),
        "cycloid": (Cycloid(RADIUS, RISE, ANGLE), GREEN),
    }
    picture = Figure(figsize=(9.0, 2.8), layout="constrained")
    psi = np.linspace(0.0, ANGLE, 200)
    beside = np.array([-0.25, 0.0]), np.array([ANGLE, ANGLE + 0.25])
    axes = picture.subplots(1, 3)
    for place, (axis, (label, scale)) in enumerate(zip(axes, PARTS.items(), strict=True)):
        for name, (groove, color) in laws.items():
            before, after = (np.full(2, height if place == 0 else 0.0) for height in (0.0, RISE))
            values = np.concatenate([before, groove.at(psi)[place], after])
            axis.plot(np.concatenate([beside[0], psi, beside[1]]), scale * values, color=color, label=name)
        axis.set(xlabel="ψ [rad]", title=label)
        axis.grid(alpha=0.3)
    axes[0].legend()
    return picture


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=DOCS)
    folder = parser.parse_known_args()[0].output
    with mpl.rc_context({**mpl.rcParamsDefault, "svg.hashsalt": "dualcam"}):
        draw().savefig(folder / "groove_laws.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
