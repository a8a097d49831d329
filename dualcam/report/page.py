"""One HTML file about a design: inputs, findings, curves, simulation and energy balance.

The file needs no network: pictures are SVG inside the page, and the page has no script.
"""

from html import escape
from pathlib import Path

import numpy as np

import dualcam
from dualcam.checking import Verdict, check_design
from dualcam.common.html_page import figure_element, page, table
from dualcam.common.paths import page_path_of, write_text
from dualcam.design import Mechanism, TorqueBand, torque_band
from dualcam.design.band import locking_words, span
from dualcam.design_file import DesignFile, DesignSource, as_design
from dualcam.errors import DualcamError
from dualcam.plots.design import plot_band, plot_simulation, plot_strength
from dualcam.report.durability import durability_sections
from dualcam.report.inputs import input_tables
from dualcam.report.summary import (
    energy_scale,
    energy_words,
    largest_loads,
    reaction_words,
    residual_words,
    span_words,
)
from dualcam.simulation.run import ENERGIES, Trajectory, simulate

F_EXT = "F_ext is an external axial force on the follower, positive against loading."
LABELS = {
    "energy.work_in": "work of the torque at the shaft",
    "energy.work_ext": "work against F_ext",
    "energy.spring": "spring",
    "energy.kinetic": "motion",
    "energy.heat_cam1": "friction heat at cam 1",
    "energy.heat_cam2": "friction heat at cam 2",
    "energy.heat_damper": "heat in the damper",
    "energy.heat_shaft": "heat at the shaft",
    "energy.heat_stop": "heat at the end stops",
    "energy.residual": "residual: the error of the balance",
}


def write_report(design: DesignSource, path: str | Path) -> Path:
    """Write a report about a design. A design that does not work is no error: the report says why.

    Parameters
    ----------
    design : DesignFile, str or Path
        The design, from `read_design`, or the path of its file. Without a scenario there is no simulation.
    path : The HTML file.

    Returns
    -------
    Path
        The written file.

    Raises
    ------
    DualcamError
        For another ending than .html, or a file that cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.design_file import write_template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     design = write_template("minimal", Path(folder) / "my.toml")
    ...     write_report(design, Path(folder) / "my_report.html").name
    'my_report.html'
    """
    path = page_path_of(path, "the report")
    write_text(path, report_page(as_design(design, shows_findings=True)))
    return path


def report_page(design: DesignFile) -> str:
    """The report as the text of an HTML page."""
    verdict = check_design(design)
    sections = [_findings(verdict)]
    try:
        sections += _curves(design, verdict)
    except DualcamError as error:
        sections.append(f'<p class="error">No curves: {escape(str(error))}</p>')
    sections.append(_inputs(design))
    words = f"<p>{escape(design.description)}</p>\n" if design.description else ""
    lead = f"Dual cylindrical cam, report by dualcam {dualcam.__version__} from {design.path.name}"
    return page(design.title or design.name, "dual cam report", lead, words + "".join(sections))


def _findings(verdict: Verdict) -> str:
    if verdict.good:
        head = '<p class="good"><b>The design works.</b> The FMU starts with these values.</p>'
    else:
        head = '<p class="error"><b>The design does not work.</b></p>'
    items = "".join(
        f'<li class="{finding.severity}"><b>{finding.severity}:</b> {escape(finding.text)}</li>\n'
        for finding in verdict.findings
    )
    return f"<h2>Findings</h2>\n{head}\n" + (f"<ul>\n{items}</ul>\n" if items else "")


def _curves(design: DesignFile, verdict: Verdict) -> list[str]:
    """Torque band, reactions, what lasts and, where there is a scenario, the simulation."""
    mechanism = design.mechanism()
    band = torque_band(mechanism, 361)
    sections = [_band(design, band, verdict), _reactions(design, mechanism)]
    sections += durability_sections(design, mechanism)
    if verdict.good and design.scenario is not None:
        sections.append(_simulation(simulate(design), band))
    return sections


def _band(design: DesignFile, band: TorqueBand, verdict: Verdict) -> str:
    rows = [
        ("torque to load", "infinite: the mechanism jams" if band.jams else f"{span(band.load)} N.m"),
        ("torque given back", f"{span(band.release)} N.m"),
        ("efficiency: given back over loaded", span_words(100.0 * band.efficiency, "%")),
        ("self-locking", locking_words(band.locked)),
        ("range of theta", f"{np.degrees(band.theta[0]):.4g} to {np.degrees(band.theta[-1]):.4g} deg"),
        ("stroke of the follower", f"{1e3 * (band.z[-1] - band.z[0]):.4g} mm"),
    ]
    if verdict.numbers is not None:
        rows.append(("motion under friction", verdict.numbers.friction_words()))
    text = "Between the two edges friction holds the cam at rest. Slow motion, without damper and F_ext."
    text = " ".join(filter(None, [text, design.friction_note()]))
    return (
        f"<h2>Torque over the angle</h2>\n<p>{text} {F_EXT}</p>\n"
        + table(("what", "value"), rows)
        + figure_element(plot_band(band), "Torque band and efficiency over the angle")
    )


def _reactions(design: DesignFile, mechanism: Mechanism) -> str:
    loads = largest_loads(mechanism, None)
    rows = [("largest reaction", reaction_words(loads.reaction, mechanism.contacts))]
    text = "The larger one of slow loading and releasing, without F_ext, as the normal force of one contact."
    if design.pin is None:
        text += " A section [pin] in the design file adds the contact pressure."
    picture = figure_element(plot_strength(mechanism, None), "Reactions over the angle")
    return f"<h2>Reactions</h2>\n<p>{text}</p>\n" + table(("what", "value"), rows) + picture


def _simulation(trajectory: Trajectory, band: TorqueBand) -> str:
    last = {name: trajectory[name][-1] for name in trajectory.names}
    scale = energy_scale(trajectory)
    accounts = [name for name in ENERGIES if name in last and name != "energy.residual"]
    rows = [(LABELS[name], energy_words(last[name], scale)) for name in accounts]
    heat = sum(last[name] for name in accounts if name.startswith("energy.heat"))
    rows.append(("all heat of this run", energy_words(heat, scale)))
    rows.append((LABELS["energy.residual"], residual_words(trajectory)))
    return (
        "<h2>Simulation</h2>\n"
        + figure_element(plot_simulation(trajectory, band), "The scenario over time")
        + f"<h2>Energy balance of the run, at {last['time']:g} s</h2>\n<p>{F_EXT}</p>\n"
        + table(("account", "energy"), rows)
    )


def _inputs(design: DesignFile) -> str:
    text = "Values in the units of the FMU (SI) and, beside them, in the usual unit."
    tables = "".join(
        f"<h3>{escape(head)}</h3>\n" + table(("key", "value", "unit", "usual unit"), rows)
        for head, rows in input_tables(design).items()
    )
    return f"<h2>Inputs</h2>\n<p>{text}</p>\n{tables}"
