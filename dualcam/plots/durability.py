"""Pictures of what lasts: pressure and wear along each groove, and the Goodman diagram of the spring."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dualcam.plots.design import ANGLE, BLUE, GREEN, GREY, ORANGE, RED, axis_from_zero, figure, legend_above

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from dualcam.design import Fatigue, HelicalSpring, Mechanism, Pin, Wear, WornMechanism

ALONG = "angle along the groove, psi [deg]"
STYLES = ((BLUE, "-"), (ORANGE, "--"))  # both grooves are often equal
MEGA, MILLI = 1e6, 1e3  # Pa -> MPa, m -> mm


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
        _finish(axes, ALONG)


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
    _finish(axes[0], ALONG)
    if worn is not None:
        angle = np.degrees(worn.theta)
        for new, old, colour, name in (
            (worn.new_load, worn.load, ORANGE, "to load"),
            (worn.new_release, worn.release, BLUE, "given back"),
        ):
            axes[1].plot(angle, np.where(np.isfinite(new), new, np.nan), color=colour, label=f"{name}, new")
            worn_torque = np.where(np.isfinite(old), old, np.nan)
            axes[1].plot(angle, worn_torque, "--", color=colour, label=f"{name}, worn")
        axes[1].set_ylabel("torque [N.m]")
        _finish(axes[1], ANGLE)
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


def _finish(axes: Axes, label: str) -> None:
    axes.set_xlabel(label)
    axes.grid(alpha=0.3)
    axis_from_zero(axes)
    legend_above(axes)
