"""The result of an identification as one HTML page."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import dualcam
from dualcam.common.html_page import figure_element, page, table
from dualcam.common.paths import page_path_of, write_text
from dualcam.identification.doubts import doubts_of
from dualcam.identification.picture import plot_identification
from dualcam.identification.result import HEADS, OPEN, rows_of

if TYPE_CHECKING:
    from dualcam.identification.result import Fit

CAPTION = (
    "Where the cam slips, the residual is the fitted torque minus the measured one. At rest friction can"
    " carry any torque of the stick band: there the residual is the distance from the band, less twice the"
    " noise."
)


def write_page(found: Fit, path: str | Path) -> Path:
    """Write the page. DualcamError for another ending than .html."""
    path = page_path_of(path, "the report")
    write_text(path, _page(found))
    return path


def _page(found: Fit) -> str:
    design, recording = found.design, found.recording
    lead = (
        f"Identification by dualcam {dualcam.__version__} from {recording.source}, start values from"
        f" {design.path.name}"
    )
    doubts = "".join(f'<li class="warning">{escape(text)}</li>\n' for text in doubts_of(found))
    content = [
        "<h2>Fitted values</h2>\n",
        _numbers(table(HEADS, rows_of(found))),
        "".join(f"<p>{escape(line)}.</p>\n" for line in found.summary()),
        f"<h2>Doubts</h2>\n<ul>\n{doubts}</ul>\n" if doubts else "",
        "<h2>Torque and residuals</h2>\n",
        figure_element(plot_identification(found), "Torque and residuals", escape(CAPTION)),
        "<h2>Correlation of the fitted values</h2>\n",
        _correlation(found),
        "<h2>How the recording was read</h2>\n",
        "".join(f"<p>{escape(note)}.</p>\n" for note in recording.notes or (f"given as {recording.source}",)),
    ]
    return page(design.title or design.name, "dual cam identification", lead, "".join(content))


def _correlation(found: Fit) -> str:
    names = [parameter.name for parameter in found.parameters]
    rows = [
        [name, *(f"{value:+.3f}" for value in row)]
        for name, row in zip(names, found.correlation.tolist(), strict=True)
    ]
    open_names = [one.name for one in found.parameters if one.status == OPEN]
    remark = (
        f"<p>{escape(' and '.join(open_names))}: not determined. Their correlations say along which direction"
        " the recording leaves them open, not how well they are known.</p>\n"
        if open_names
        else ""
    )
    return _numbers(table(["", *names], rows)) + remark


def _numbers(content: str) -> str:
    """A table whose numbers stay in one line."""
    return f'<div class="numbers">{content}</div>'
