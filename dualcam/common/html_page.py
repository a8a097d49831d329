"""Pages in HTML that hold all they show: no script, no network."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLE = """\
:root { color-scheme: light dark; --line: #d0d7de; --soft: #57606a; --bad: #cf222e; --warn: #9a6700;
  --good: #1a7f37 }
@media (prefers-color-scheme: dark) {
  :root { --line: #3d444d; --soft: #9198a1; --bad: #ff7b72; --warn: #d29922; --good: #3fb950 } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 46rem; margin: 0 auto; padding: 1rem }
h1 { margin-bottom: 0 } h2 { margin-top: 2.2rem; border-bottom: 1px solid var(--line) }
p.lead, caption { color: var(--soft) }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem } caption { text-align: left }
th, td { text-align: left; vertical-align: top; padding: 0.25rem 0.6rem 0.25rem 0;
  border-bottom: 1px solid var(--line) }
td { overflow-wrap: anywhere; font-variant-numeric: tabular-nums } td:first-child { overflow-wrap: normal }
.numbers td { overflow-wrap: normal; white-space: nowrap }
h3 { margin: 1.4rem 0 0.3rem; font-size: 1rem }
.scroll { overflow-x: auto }
.error { color: var(--bad) } .warning { color: var(--warn) } .good { color: var(--good) }
figure { margin: 1rem 0; background: #fff; border-radius: 6px; padding: 0.4rem; max-width: 34rem }
figure svg { width: 100%; height: auto }
"""
NO_METADATA = dict.fromkeys(("Date", "Creator", "Format", "Type"))


def page(title: str, kind: str, lead: str, content: str) -> str:
    """An HTML page. `content` is HTML; the other texts are plain; `kind` is in the window's title."""
    return f"""\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}: {escape(kind)}</title>
<style>
{STYLE}</style>
</head>
<body>
<h1>{escape(title)}</h1>
<p class="lead">{escape(lead)}</p>
{content}
</body>
</html>
"""


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of plain texts, which scrolls on a narrow screen."""
    head = "".join(f"<th>{escape(name)}</th>" for name in heads)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>\n" for row in rows)
    return f'<div class="scroll"><table>\n<tr>{head}</tr>\n{body}</table></div>\n'


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
