"""Paragraphs and tables of the page."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np

from dualcam.design.statics import Array


def paragraph(text: str) -> str:
    """A paragraph in lines of at most 110 characters."""
    return textwrap.fill(" ".join(text.split()), 110, break_on_hyphens=False, break_long_words=False) + "\n"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    assert all(len(line) == len(head) for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def span(values: Sequence[float] | Array, digits: int = 2) -> str:
    """From the 5th to the 95th percentile."""
    low, high = np.quantile(np.asarray(values), [0.05, 0.95])
    return f"{low:.{digits}f} to {high:.{digits}f}"


def percent(value: float, digits: int = 1) -> str:
    """A share in percent."""
    return f"{100.0 * value:.{digits}f} %"
