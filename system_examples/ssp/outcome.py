"""Rows of the tables of docs/use-ssp.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from system_examples.ssp.coupling import Columns


@dataclass(frozen=True)
class Outcome:
    """A row of a table of the page."""

    cells: tuple[str, ...]
    wrong: bool = False


def largest_difference(found: Columns, expected: Columns, names: Sequence[str]) -> float:
    """The largest difference over all rows; infinite where a number is missing."""
    if any(name not in found or len(found[name]) != len(expected[name]) for name in names):
        return float("inf")
    differences = [np.abs(found[name] - expected[name]) for name in names]
    return float(np.max(np.where(np.isnan(differences), np.inf, differences)))


def table(head: Sequence[str], outcomes: Sequence[Outcome]) -> list[str]:
    """A table in Markdown, with columns of even width."""
    rows = [head, *(o.cells for o in outcomes)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(head))]
    lines = [" | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    lines.insert(1, " | ".join("-" * width for width in widths))
    return [f"| {line} |" for line in lines]
