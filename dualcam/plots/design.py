"""Pictures of a design and of its simulation. Each function returns a matplotlib Figure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dualcam.common.paths import whole_file
from dualcam.errors import DualcamError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from dualcam.design import Mechanism, Pin, TorqueBand
    from dualcam.simulation.run import Trajectory

Array = NDArray[np.float64]

BLUE, ORANGE, GREY, GREEN, RED = "#0969da", "#bc4c00", "#8c959f", "#1a7f37", "#cf222e"
WIDTH = 4.2  # inches: text of 10 points stays readable on a phone
ANGLE = "angle of cam 2, theta [deg]"
LEGEND = 9.0  # points
ENERGY_LABELS = {
    "energy.work_in": "work in",
    "energy.spring": "spring",
    "energy.kinetic": "kinetic",
    "energy.heat_cam1": "heat, cam 1",
    "energy.heat_cam2": "heat, cam 2",
    "energy.heat_damper": "heat, damper",
    "energy.heat_stop": "heat, stops",
}


def figure(rows: int, height: float, title: str = "") -> tuple[Figure, list[Axes]]:
    """A figure of `rows` plots one below the other, each `height` inches high, below the title."""
    from matplotlib.figure import Figure

    picture = Figure(figsize=(WIDTH, rows * height), layout="constrained")
    axes = picture.subplots(rows, 1, squeeze=False)[:, 0]
    if title:
        picture.suptitle(title)
    return picture, list(axes)


def legend_above(axes: Axes) -> None:
    """A legend above the axes in two columns, where it covers no line."""
    count = len(axes.get_legend_handles_labels()[0])
    if count:
        axes.legend(
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            borderaxespad=0.2,
            ncols=min(2, count),
            columnspacing=1.2,
            fontsize=LEGEND,
            frameon=False,
        )


def axis_from_zero(axes: Axes) -> None:
    """The y axis includes 0."""
    low, high = axes.get_ylim()
    if low > 0.0:
        axes.set_ylim(bottom=0.0)
    if high < 0.0:
        axes.set_ylim(top=0.0)


def plot_band(band: TorqueBand, title: str = "") -> Figure:
    """Torque band and efficiency over the angle; the title stands above both."""
    picture, (torque, share) = figure(2, 2.9, title)
    angle = np.degrees(band.theta)
    draw_band(torque, band)
    share.plot(angle, 100.0 * band.efficiency, color=GREEN)
    share.axhline(0.0, color=GREY, lw=0.8)
    share.set_xlabel(ANGLE)
    share.set_ylabel("efficiency,\nrelease/load [%]")
    for axes in (torque, share):
        axes.grid(alpha=0.3)
    return picture


def draw_band(axes: Axes, band: TorqueBand) -> None:
    """The band between both edges, over the angle in degrees."""
    angle = np.degrees(band.theta)
    finite = np.where(np.isfinite(band.load), band.load, np.nan)
    axes.fill_between(angle, band.release, finite, color=GREY, alpha=0.2, lw=0, label="stick: at rest")
    axes.plot(angle, finite, color=ORANGE, label="to load")
    axes.plot(angle, band.release, color=BLUE, label="given back")
    axes.axhline(0.0, color=GREY, lw=0.8)
    axes.set_xlabel(ANGLE)
    axes.set_ylabel("torque [N.m]")
    legend_above(axes)


def plot_strength(mechanism: Mechanism, pin: Pin | None, points: int = 181) -> Figure:
    """Reaction of each contact over the angle and, with a pin, the contact pressure."""
    from dualcam.design import Pin as AnyPin
    from dualcam.design.strength import strength

    found = strength(mechanism, pin or AnyPin(1e-3, 1e-2), mechanism.angles(points))
    picture, axes = figure(2 if pin else 1, 2.6)
    angle = np.degrees(found.theta)
    for i, (colour, style) in enumerate(((BLUE, "-"), (ORANGE, "--"))):  # both cams often carry the same
        axes[0].plot(angle, found.load[i], style, color=colour, label=f"cam {i + 1}")
        if pin:
            axes[1].plot(angle, found.pressure[i] / 1e6, style, color=colour, label=f"cam {i + 1}")
    axes[0].set_ylabel("reaction\nof one contact [N]")
    if pin:
        axes[1].set_ylabel("contact pressure [MPa]")
    for plot in axes:
        legend_above(plot)
        axis_from_zero(plot)
        plot.set_xlabel(ANGLE)
        plot.grid(alpha=0.3)
    return picture


def plot_simulation(trajectory: Trajectory, band: TorqueBand | None = None, title: str = "") -> Figure:
    """Angle, torque over time, torque over angle with the band, and energies; the title stands above all."""
    picture, (angle, torque, loop, energy) = figure(4, 2.8, title)
    time, theta = trajectory["time"], np.degrees(trajectory["theta"])
    angle.plot(time, theta, color=BLUE)
    angle.set_ylabel("angle theta [deg]")
    torque.plot(time, trajectory["tau"], color=BLUE, label="tau, acting")
    if "torque_load" in trajectory.names and "torque_release" in trajectory.names:
        edges = {"torque_load": "to load here", "torque_release": "given back here"}
        for (name, label), colour in zip(edges.items(), (ORANGE, GREEN), strict=True):
            torque.plot(time, _finite(trajectory[name]), color=colour, lw=0.9, ls="--", label=label)
    torque.set_ylabel("torque [N.m]")
    if band is not None:
        draw_band(loop, band)
    loop.plot(theta, trajectory["tau"], color="k", lw=1.2, label="simulation")
    loop.set_xlabel(ANGLE)
    loop.set_ylabel("torque [N.m]")
    _draw_energies(energy, trajectory)
    for axes in (angle, torque, energy):
        axes.set_xlabel("time [s]")
    for axes in (torque, loop, energy):
        legend_above(axes)
    for axes in (angle, torque, loop, energy):
        axes.grid(alpha=0.3)
    return picture


def _draw_energies(axes: Axes, trajectory: Trajectory) -> None:
    """Accounts that reach 1 % of the largest one; cam 2 dashed, as both cams often heat alike."""
    sizes = {name: np.abs(trajectory[name]).max() for name in ENERGY_LABELS if name in trajectory.names}
    for name, size in sizes.items():
        if size > 0.01 * max(sizes.values()):
            style = "--" if name == "energy.heat_cam2" else "-"
            axes.plot(trajectory["time"], trajectory[name], style, label=ENERGY_LABELS[name], lw=1.4)
    axes.set_ylabel("energy [J]")


def _finite(values: Array) -> Array:
    """`values` with gaps where they are infinite."""
    return np.where(np.isfinite(values), values, np.nan)


def save(picture: Figure, path: str | Path) -> None:
    """Write a figure to a file; the end of the name gives the format (png, svg, pdf).

    Raises
    ------
    DualcamError
        For a format that matplotlib cannot write.
    """
    check_picture(path)
    with whole_file(Path(path)) as unfinished:
        picture.savefig(unfinished, dpi=200)


def check_picture(path: str | Path) -> None:
    """DualcamError unless matplotlib can write a picture of this name."""
    from matplotlib.backend_bases import FigureCanvasBase

    if Path(path).suffix.lower().lstrip(".") not in FigureCanvasBase.get_supported_filetypes():
        raise DualcamError(f"{path}: allowed are names that end in .png, .svg or .pdf")
