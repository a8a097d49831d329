"""documentation/index.html of an exported FMU: the page of the original with name, start values and figures
of this design."""

from __future__ import annotations

import re
from collections.abc import Mapping
from html import escape

from dualcam.errors import ExportError
from dualcam.export.description import AGAIN, Description, VariableTag, number_text
from dualcam.fmi.model_description import Scalar

FIGURES = """\
<div class="figures" id="figures">
{figures}</div>"""
REFERENCE = """\
<p id="reference"><b>Reference result.</b> <code>extra/reference</code> holds inputs and the result of this
FMU itself, and a README.txt that says how to compare. <b>Licence:</b> BSD-2-Clause,
<a href="licenses/license.txt">license.txt</a>.</p>"""


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
    page = _replaced(
        page, r'()<div class="figures" id="figures">.*?</div>()', FIGURES.format(figures=figures)
    )
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
