"""Pictures of a design, of its simulation, and of what lasts. Each function returns a matplotlib Figure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dualcam.common.paths import check_picture, whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from dualcam.design import Fatigue, HelicalSpring, Mechanism, Pin, TorqueBand, Wear, WornMechanism
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
ALONG = "angle along the groove, psi [deg]"
STYLES = ((BLUE, "-"), (ORANGE, "--"))  # both cams often carry the same, and both grooves are often equal
MEGA, MILLI = 1e6, 1e3  # Pa -> MPa, m -> mm


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
    finite = _finite(band.load)
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
    for i, (colour, style) in enumerate(STYLES):
        axes[0].plot(angle, found.load[i], style, color=colour, label=f"cam {i + 1}")
        if pin:
            axes[1].plot(angle, found.pressure[i] / MEGA, style, color=colour, label=f"cam {i + 1}")
    axes[0].set_ylabel("reaction\nof one contact [N]")
    if pin:
        axes[1].set_ylabel("contact pressure [MPa]")
    for plot in axes:
        finish(plot, ANGLE)
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
    """Write a figure to a file whose name ends in .png, .svg or .pdf. DualcamError for another ending."""
    check_picture(Path(path))
    with whole_file(Path(path)) as unfinished:
        picture.savefig(unfinished, dpi=200)


def plot_contact(mechanism: Mechanism, pin: Pin, limit: float) -> Figure:
    """Largest pressure along each groove with its limit, and the shear stress below the surface."""
    picture, (pressure, shear) = figure(2, 2.6)
    draw_contact(pressure, shear, mechanism, pin, limit)
    return picture


def draw_contact(pressure: Axes, shear: Axes, mechanism: Mechanism, pin: Pin, limit: float) -> None:
    """Both curves of `plot_contact`."""
    from dualcam.design import line_contact
    from dualcam.design.strength import strength

    found = strength(mechanism, pin, np.linspace(*mechanism.reach(), 181))
    psi = np.degrees(mechanism.configuration(found.theta).psi)
    for i, (colour, style) in enumerate(STYLES):
        contact = line_contact(found.load[i], pin, found.curvature[i])
        pressure.plot(psi[i], found.pressure[i] / MEGA, style, color=colour, label=f"groove {i + 1}")
        shear.plot(psi[i], contact.shear / MEGA, style, color=colour, label=f"groove {i + 1}")
    if limit <= 3.0 * np.max(found.pressure):
        pressure.axhline(limit / MEGA, color=GREY, lw=0.9, ls=":", label="allowed")
    pressure.set_ylabel("largest pressure [MPa]")
    shear.set_ylabel("largest shear stress\nbelow the surface [MPa]")
    for axes in (pressure, shear):
        finish(axes, ALONG)


def plot_wear(wear: Wear, worn: WornMechanism | None, cycles: float) -> Figure:
    """Depth of wear along each groove after that many cycles and, of a mechanism that works, the torque."""
    picture, axes = figure(2 if worn else 1, 2.8)
    for i, (colour, style) in enumerate(STYLES):
        psi = np.degrees(wear.psi[i])
        axes[0].plot(psi, cycles * MILLI * wear.depth[i], style, color=colour, label=f"groove {i + 1}")
    deepest = float(wear.pin_depth(cycles).max())
    if deepest > 0.0:
        axes[0].axhline(MILLI * deepest, color=GREY, ls=":", label="pin")
    axes[0].set_ylabel("depth of wear [mm]")
    finish(axes[0], ALONG)
    if worn is not None:
        angle = np.degrees(worn.theta)
        for new, old, colour, name in (
            (worn.new_load, worn.load, ORANGE, "to load"),
            (worn.new_release, worn.release, BLUE, "given back"),
        ):
            axes[1].plot(angle, _finite(new), color=colour, label=f"{name}, new")
            axes[1].plot(angle, _finite(old), "--", color=colour, label=f"{name}, worn")
        axes[1].set_ylabel("torque [N.m]")
        finish(axes[1], ANGLE)
    return picture


def plot_goodman(spring: HelicalSpring, cycle: Fatigue, limit: float) -> Figure:
    """The Goodman diagram: amplitude over mean stress, the line of the wire, and the point of the spring."""
    picture, (axes,) = figure(1, 3.2)
    means = np.array([0.0, cycle.knee, cycle.shear_strength]) / MEGA
    amplitudes = np.array([cycle.strength, cycle.strength, 0.0]) / MEGA
    axes.plot(means, amplitudes, color=ORANGE, label="Goodman line")
    axes.plot(means / limit, amplitudes / limit, "--", color=GREY, label=f"allowed: {limit:g}")
    mean, amplitude = cycle.mean / MEGA, cycle.amplitude / MEGA
    axes.plot([0.0, mean * cycle.safety], [0.0, amplitude * cycle.safety], color=GREY, lw=0.8)
    good = cycle.safety >= limit
    label = f"this spring: {cycle.safety:.3g}"
    axes.plot(mean, amplitude, "o", color=GREEN if good else RED, label=label)
    axes.set_ylabel("amplitude of the\nshear stress [MPa]")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("mean shear stress [MPa]")
    axes.grid(alpha=0.3)
    legend_above(axes)
    return picture


def finish(axes: Axes, label: str) -> None:
    """The label below, a grid, 0 on the y axis, and the legend."""
    axes.set_xlabel(label)
    axes.grid(alpha=0.3)
    axis_from_zero(axes)
    legend_above(axes)
