"""Figures as SVG inside an HTML page."""

from __future__ import annotations

import io
import re
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NO_METADATA = dict.fromkeys(("Date", "Creator", "Format", "Type"))


def figure_element(picture: Figure, title: str, caption: str = "") -> str:
    """An HTML element `figure`: the picture as SVG, whose ids begin with the title, and an HTML caption."""
    from matplotlib import rc_context

    text = io.StringIO()
    with rc_context({"svg.hashsalt": title, "svg.fonttype": "none", "font.family": "sans-serif"}):
        picture.savefig(text, format="svg", metadata=NO_METADATA)
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :].rstrip()
    mark = re.sub(r"\W+", "-", title.lower())
    svg = re.sub(r'\bid="', f'id="{mark}-', svg)
    svg = re.sub(r'(href="#|url\(#)', rf"\g<1>{mark}-", svg)
    svg = svg.replace("<svg", f'<svg role="img" aria-label="{escape(title)}"', 1)
    words = f"\n<figcaption>{caption}</figcaption>\n" if caption else ""
    return f"<figure>{svg}{words}</figure>\n"
