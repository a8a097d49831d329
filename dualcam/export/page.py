"""documentation/index.html of an exported FMU: the page of the original with name, start values and figures
of this design."""

from __future__ import annotations

import re
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from dualcam.common.html_page import figure_element
from dualcam.errors import ExportError
from dualcam.export.description import AGAIN, Description, VariableTag, number_text
from dualcam.export.reference import Array, Reference, SlowMotionCurves
from dualcam.fmi.model_description import Scalar
from dualcam.plots.design import ANGLE, BLUE, GREY, ORANGE, figure, finish

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FIGURES = """\
<div class="figures" id="figures">
{}</div>"""
REFERENCE = """\
<p id="reference"><b>Reference result.</b> <code>extra/reference</code> holds inputs and the result of this
FMU itself, and a README.txt that says how to compare. <b>Licence:</b> BSD-2-Clause,
<a href="licenses/license.txt">license.txt</a>.</p>"""
HEIGHT = 3.2  # inches of each figure
CAMS = (BLUE, ORANGE)  # colours of cam 1 and cam 2
TORQUE = """\
The edges of the stick band in slow motion without <i>F</i><sub>ext</sub>: between them friction holds the
cam. The grey line is the reference result, a run of 1 s with inertia, under a force <i>F</i><sub>ext</sub>
of up to {force:g} N. The force raises both edges, so the grey line may lie above
<i>T</i><sub>release</sub> on its way back. A line has a gap where the mechanism jams or a value is
infinite."""
EFFICIENCY = "Efficiency of slow motion: <i>T</i><sub>release</sub> / <i>T</i><sub>load</sub>."
REACTION = (
    "Normal reaction of one contact in slow motion, loading and releasing, without <i>F</i><sub>ext</sub>."
)
GROOVES = "The part of both grooves in which the pin runs, unrolled."


def exported_page(
    page: str,
    original: Description,
    names: Mapping[str, str],
    start: Mapping[str, Scalar],
    figures: str,
    scenario: str,
) -> str:
    """The page of an exported FMU. `names`: name, identifier, description. `figures`, `scenario`: HTML."""
    heading = escape(names["name"])
    old = original.root.attributes["description"]
    page = _replaced(page, r"(<head>.*?<title>).*?(</title>)", heading)
    page = _replaced(page, r"(<h1>).*?(</h1>)", heading)
    page = page.replace(escape(old), escape(names["description"]), 1)
    page = page.replace(f"-o {original.identifier}.so", f"-o {names['identifier']}.so")
    page = _replaced(page, r'()<div class="figures" id="figures">.*?</div>()', FIGURES.format(figures))
    page = _replaced(page, r'()<p id="reference">.*?</p>()', f"{scenario}\n{REFERENCE}".lstrip())
    for name, value in start.items():
        cell = rf'(<tr><td><code>{re.escape(name)}</code></td><td>[^<]*</td><td class="number">)[^<]*(</td>)'
        page = _replaced(page, cell, escape(_shown(original, original.variables[name], value)))
    return page


def _replaced(page: str, pattern: str, content: str) -> str:
    """`content` between the two groups of the one match of `pattern`."""
    page, count = re.subn(pattern, lambda match: match[1] + content + match[2], page, flags=re.DOTALL)
    if count != 1:
        raise ExportError(f"page of the FMU without {pattern!r}: {AGAIN}")
    return page


def _shown(description: Description, variable: VariableTag, value: Scalar) -> str:
    """A start value; in brackets the value in the unit that a tool shows."""
    if isinstance(value, bool | str):
        return number_text(value)
    name, factor = description.display_units.get(variable.unit or "", ("", 1.0))
    return f"{value:.6g} [{value * factor:.6g} {name}]" if name and value else f"{value:.6g}"


def figures(curves: SlowMotionCurves, reference: Reference) -> str:
    """Four figures as HTML. The bytes depend on the numbers and on the version of Matplotlib."""
    theta = np.degrees(curves.theta)
    found = ""
    for title, caption, x_name, y_name, draw in (
        ("Torque", TORQUE.format(force=reference.largest_force()), ANGLE, "torque tau [N.m]", _draw_torque),
        ("Efficiency", EFFICIENCY, ANGLE, "efficiency [1]", _draw_efficiency),
        ("Reactions", REACTION, ANGLE, "reaction of one contact [N]", _draw_reactions),
        ("Grooves", GROOVES, "angle about the axis [deg]", "height z [mm]", _draw_grooves),
    ):
        picture, (axes,) = figure(1, HEIGHT)
        draw(axes, theta, curves, reference)
        axes.set_ylabel(y_name)
        finish(axes, x_name)
        found += figure_element(picture, title, caption)
    return found


def _draw_torque(axes: Axes, theta: Array, curves: SlowMotionCurves, reference: Reference) -> None:
    """The stick band, and the loop of the reference result."""
    angle, tau = reference.loop()
    axes.plot(np.degrees(angle), tau, color=GREY, linewidth=1.0, label="reference, with F_ext")
    axes.plot(theta, curves.values["torque_load"], color=ORANGE, label="T_load")
    axes.plot(theta, curves.values["torque_release"], color=BLUE, label="T_release")


def _draw_efficiency(axes: Axes, theta: Array, curves: SlowMotionCurves, _: Reference) -> None:
    axes.plot(theta, curves.values["efficiency"], color=BLUE)


def _draw_reactions(axes: Axes, theta: Array, curves: SlowMotionCurves, _: Reference) -> None:
    """Each line has its own style, since both cams often carry the same."""
    for direction, styles in (("loading", ("-", "--")), ("releasing", ("-.", ":"))):
        for i, (colour, style) in enumerate(zip(CAMS, styles, strict=True)):
            values = curves.reactions[direction][i]
            axes.plot(theta, values, style, color=colour, label=f"cam {i + 1}, {direction}")


def _draw_grooves(axes: Axes, theta: Array, curves: SlowMotionCurves, _: Reference) -> None:
    """Both grooves where the pin goes: z over gamma, and over theta - gamma."""
    gamma, z = np.degrees(curves.values["gamma"]), 1e3 * curves.values["z"]
    axes.plot(gamma, z, "-", color=CAMS[0], label="cam 1")
    axes.plot(theta - gamma, z, "--", color=CAMS[1], label="cam 2")
