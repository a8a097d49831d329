"""A table of the report as HTML."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from dualcam.report_inputs import Row


def table(heads: Row, rows: Sequence[Row]) -> str:
    """The table with that row of heads."""
    head = "".join(f"<th>{escape(name)}</th>" for name in heads)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>\n" for row in rows)
    return f'<div class="scroll"><table>\n<tr>{head}</tr>\n{body}</table></div>\n'
