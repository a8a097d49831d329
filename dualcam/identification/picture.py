"""The picture of an identification: torque over the angle, and residuals over angle, sliding speed and
time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dualcam.plots.design import ANGLE, BLUE, GREY, ORANGE, figure, legend_above

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from dualcam.identification.result import Fit

DIRECTIONS = ((1, "loading", ORANGE), (-1, "releasing", BLUE), (0, "at rest or reversing", GREY))
MARK = 8.0  # points: a mark of the legend
MOST_DOTS = 4000  # more make an SVG slow


def plot_identification(found: Fit) -> Figure:
    """Four plots, one below the other, of the samples by direction."""
    from matplotlib.lines import Line2D

    picture, (torque, angle, speed, time) = figure(4, 2.6)
    shown = np.zeros(len(found.time), dtype=bool)
    shown[:: max(1, -(-len(found.time) // MOST_DOTS))] = True
    theta = np.degrees(found.motion.theta)
    _draw(torque, found, theta, found.measured, shown)
    label = "fitted"
    for direction in (1, -1):
        chosen = np.flatnonzero(found.motion.direction == direction)
        if len(chosen):
            order = chosen[np.argsort(theta[chosen])]
            torque.plot(theta[order], found.low[order], "k.", ms=1.0, label=label)
            label = ""
    torque.set_ylabel("torque [N.m]")
    torque.set_xlabel(ANGLE)
    legend_above(torque)
    if legend := torque.get_legend():
        for mark in legend.legend_handles:
            if isinstance(mark, Line2D):
                mark.set_markersize(MARK)
                mark.set_alpha(1.0)
    _draw(angle, found, theta, found.residual, shown)
    angle.set_xlabel(ANGLE)
    _draw(speed, found, 1e3 * found.sliding_speed, found.residual, shown & found.slips)
    speed.set_xlabel("sliding speed of the faster contact [mm/s]")
    _draw(time, found, found.time, found.residual, shown)
    time.set_xlabel("time [s]")
    for axes in (angle, speed, time):
        axes.axhline(0.0, color=GREY, lw=0.8)
        axes.set_ylabel("fitted - measured\n[N.m]")
    for axes in (torque, angle, speed, time):
        axes.grid(alpha=0.3)
    return picture


def _draw(
    axes: Axes,
    found: Fit,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    shown: NDArray[np.bool_],
) -> None:
    for direction, label, colour in DIRECTIONS:
        chosen = shown & (found.motion.direction == direction)
        if chosen.any():
            axes.plot(x[chosen], y[chosen], ".", ms=3.0, color=colour, alpha=0.5, label=label)
