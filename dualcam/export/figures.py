"""Figures of a design for the page of its FMU: torque, efficiency, reactions and grooves over the angle."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from dualcam.export.curves import Curves
from dualcam.export.reference import Reference

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, ORANGE, GREY, GRID = "#0969da", "#bc4c00", "#8c959f", "#e6e9ed"
CAMS = (BLUE, ORANGE)  # colours of cam 1 and cam 2
# Text stays text, which a browser shows in its own font; the names in the SVG follow from the salt.
STYLE: dict[Any, Any] = {"svg.hashsalt": "dualcam", "svg.fonttype": "none", "font.size": 9.0}


def figures_svg(curves: Curves, reference: Reference) -> str:
    """Four figures as one SVG element. Its bytes depend on the numbers and on the version of Matplotlib."""
    from matplotlib import rc_context

    with rc_context(STYLE):
        text = io.StringIO()
        draw(curves, reference).savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    svg = text.getvalue()
    return svg[svg.index("<svg") :].rstrip()


def draw(curves: Curves, reference: Reference) -> Figure:
    """The four figures."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 6.6), layout="constrained")
    (torque, efficiency), (reaction, groove) = figure.subplots(2, 2)
    _draw_torque(torque, curves, reference)
    efficiency.plot(np.degrees(curves.theta), curves.values["efficiency"], color=BLUE)
    _draw_reactions(reaction, curves)
    _draw_grooves(groove, curves)
    for axes, x_name, y_name in (
        (torque, "theta / deg", "tau / (N·m)"),
        (efficiency, "theta / deg", "efficiency"),
        (reaction, "theta / deg", "reaction / N"),
        (groove, "angle about the axis / deg", "z / mm"),
    ):
        axes.set_xlabel(x_name)
        axes.set_ylabel(y_name)
        axes.grid(color=GRID)
        if len(axes.lines) > 1:
            axes.legend(frameon=False)
    return figure


def _draw_torque(axes: Axes, curves: Curves, reference: Reference) -> None:
    """The stick band, and the loop of the reference result."""
    theta, tau = reference.loop()
    degrees = np.degrees(curves.theta)
    axes.plot(np.degrees(theta), tau, color=GREY, linewidth=1.0, label="reference result")
    axes.plot(degrees, curves.values["torque_load"], color=ORANGE, label="T load")
    axes.plot(degrees, curves.values["torque_release"], color=BLUE, label="T release")


def _draw_reactions(axes: Axes, curves: Curves) -> None:
    for direction, style in (("loading", "-"), ("releasing", "--")):
        for i, colour in enumerate(CAMS):
            axes.plot(
                np.degrees(curves.theta),
                curves.reactions[direction][i],
                color=colour,
                linestyle=style,
                label=f"cam {i + 1}, {direction}",
            )


def _draw_grooves(axes: Axes, curves: Curves) -> None:
    """Both grooves where the pin goes: z over gamma, and over theta - gamma."""
    gamma, z = curves.values["gamma"], 1e3 * curves.values["z"]
    axes.plot(np.degrees(gamma), z, color=CAMS[0], label="cam 1")
    axes.plot(np.degrees(curves.theta - gamma), z, color=CAMS[1], label="cam 2")
