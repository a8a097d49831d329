"""One HTML file about a design: inputs, findings, curves, simulation and energy balance.

The file needs no network: pictures are SVG inside the page, and the page has no script.
"""

from __future__ import annotations

import io
import re
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import dualcam
from dualcam.checking import Verdict, check_design
from dualcam.design import TorqueBand, torque_band
from dualcam.design_file import as_design
from dualcam.errors import DualcamError
from dualcam.module_calls import explain_call_of
from dualcam.paths import path_of
from dualcam.plots import plot_band, plot_simulation, plot_strength
from dualcam.simulation import ENERGIES, Trajectory, simulate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from dualcam.design import Mechanism
    from dualcam.design_file import DesignFile, DesignSource
    from dualcam.fmu import Scalar

STYLE = """\
:root { color-scheme: light dark; --line: #d0d7de; --soft: #57606a; --bad: #cf222e; --warn: #9a6700;
  --good: #1a7f37 }
@media (prefers-color-scheme: dark) {
  :root { --line: #3d444d; --soft: #9198a1; --bad: #ff7b72; --warn: #d29922; --good: #3fb950 } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 46rem; margin: 0 auto; padding: 1rem }
h1 { margin-bottom: 0 } h2 { margin-top: 2.2rem; border-bottom: 1px solid var(--line) }
p.lead, caption { color: var(--soft) }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem } caption { text-align: left }
th, td { text-align: left; padding: 0.25rem 0.6rem 0.25rem 0; border-bottom: 1px solid var(--line) }
td.number { text-align: right; font-variant-numeric: tabular-nums }
.scroll { overflow-x: auto }
.error { color: var(--bad) } .warning { color: var(--warn) } .good { color: var(--good) }
figure { margin: 1rem 0; background: #fff; border-radius: 6px; padding: 0.4rem }
figure svg { width: 100%; height: auto }
"""
NO_METADATA = dict.fromkeys(("Date", "Creator", "Format", "Type"))
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
    """Write a report about a design.

    Parameters
    ----------
    design : DesignFile, str or Path
        The design, from `read_design`, or the path of its file. Without a scenario the report has no
        simulation.
    path : str or Path
        The HTML file.

    Returns
    -------
    Path
        The written file.

    Raises
    ------
    DualcamError
        For another ending than .html. A design that does not work is no error: the report says why.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.design_file import write_template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     design = write_template("minimal", Path(folder) / "my.toml")
    ...     write_report(design, Path(folder) / "my_report.html").name
    'my_report.html'
    """
    path = path_of(path, "the report")
    if path.suffix.lower() not in (".html", ".htm"):
        raise DualcamError(f"{path}: allowed are names that end in .html")
    path.write_text(report_page(as_design(design, shows_findings=True)), encoding="utf-8")
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
    return f"""\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(design.name)}: dual cam report</title>
<style>
{STYLE}</style>
</head>
<body>
<h1>{escape(design.name)}</h1>
<p class="lead">Dual cylindrical cam, report by dualcam {escape(dualcam.__version__)} from
{escape(design.path.name)}</p>
{"".join(sections)}
</body>
</html>
"""


def _findings(verdict: Verdict) -> str:
    if verdict.good:
        head = '<p class="good"><b>The design works.</b> The FMU starts with these values.</p>'
    else:
        head = '<p class="error"><b>The design does not work.</b></p>'
    items = "".join(
        f'<li class="{finding.severity}"><b>{finding.severity}:</b> {escape(finding.text)}</li>\n'
        for finding in verdict.findings
    )
    return f"<h2>Findings</h2>\n{head}\n<ul>\n{items}</ul>\n" if items else f"<h2>Findings</h2>\n{head}\n"


def _curves(design: DesignFile, verdict: Verdict) -> list[str]:
    """Torque band, reactions and, where there is a scenario, the simulation."""
    mechanism = design.mechanism()
    band = torque_band(mechanism, 361)
    sections = [_band(design, band), _strength(design, mechanism)]
    if verdict.good and design.scenario is not None:
        sections.append(_simulation(simulate(design), band))
    return sections


def _band(design: DesignFile, band: TorqueBand) -> str:
    share = 100.0 * band.efficiency
    rows = [
        ("largest torque to load", f"{_largest(band.load):.4g} N.m"),
        ("largest torque given back", f"{_largest(band.release):.4g} N.m"),
        (
            "efficiency: given back over loaded",
            f"{np.nanmin(share):.3g} to {np.nanmax(share):.3g} %",
        ),
        ("self-locking", "yes: the spring cannot turn the cam back" if band.self_locking else "no"),
        ("range of theta", f"{np.degrees(band.theta[0]):.4g} to {np.degrees(band.theta[-1]):.4g} deg"),
        ("stroke of the follower", f"{1e3 * (band.z[-1] - band.z[0]):.4g} mm"),
    ]
    text = "Between the two edges friction holds the cam at rest. Slow motion, without damper and F_ext."
    return (
        f"<h2>Torque over the angle</h2>\n<p>{text}</p>\n"
        + _table(("what", "value"), rows)
        + _picture(plot_band(band, design.name), "Torque band and efficiency over the angle")
    )


def _strength(design: DesignFile, mechanism: Mechanism) -> str:
    text = "The larger reaction of slow loading and releasing, per contact."
    if design.pin is None:
        text += " A section [pin] in the design file adds the contact pressure."
    picture = plot_strength(mechanism, design.pin)
    return f"<h2>Reactions</h2>\n<p>{text}</p>\n" + _picture(picture, "Reactions over the angle")


def _simulation(trajectory: Trajectory, band: TorqueBand) -> str:
    last = {name: trajectory[name][-1] for name in trajectory.names}
    rows = [(LABELS[name], f"{last[name]:.6g} J") for name in ENERGIES if name in last]
    return (
        "<h2>Simulation</h2>\n"
        + _picture(plot_simulation(trajectory, band), "The scenario over time")
        + f"<h2>Energy balance at {last['time']:g} s</h2>\n"
        + _table(("account", "energy"), rows)
    )


def _inputs(design: DesignFile) -> str:
    rows = [(name, _value(value)) for name, value in sorted(design.parameters.items())]
    text = "In the units of the FMU (SI). Parameters that are not listed have the FMU's default."
    return f"<h2>Inputs</h2>\n<p>{text}</p>\n" + _table(("parameter", "value"), rows)


def _value(value: Scalar) -> str:
    return (
        Path(value).name
        if isinstance(value, str)
        else f"{value:.9g}"
        if isinstance(value, float)
        else str(value)
    )


def _largest(values: np.ndarray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.max()) if len(finite) else float("nan")


def _table(heads: tuple[str, str], rows: list[tuple[str, str]]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in heads)
    body = "".join(
        f'<tr><td>{escape(name)}</td><td class="number">{escape(value)}</td></tr>\n' for name, value in rows
    )
    return f'<div class="scroll"><table>\n<tr>{head}</tr>\n{body}</table></div>\n'


def _picture(picture: Figure, title: str) -> str:
    """The figure as SVG inside the page; equal figures give equal text."""
    import matplotlib

    text = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": title, "svg.fonttype": "none", "font.family": "sans-serif"}):
        picture.savefig(text, format="svg", metadata=NO_METADATA)
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    # each picture has names of its own: an id is unique in the page
    mark = re.sub(r"\W+", "-", title.lower())
    svg = re.sub(r'\bid="', f'id="{mark}-', svg)
    svg = re.sub(r'(href="#|url\(#)', rf"\g<1>{mark}-", svg)
    return f'<figure role="img" aria-label="{escape(title)}">{svg}</figure>\n'


explain_call_of(__name__)
