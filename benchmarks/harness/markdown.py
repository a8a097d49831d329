"""Markdown of the pages that are written from results."""

from __future__ import annotations

import csv
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path

Row = dict[str, str]


def read(folder: Path, name: str) -> list[Row]:
    """The rows of a CSV file. Lines "# fact: value" at its end become columns of every row."""
    path = folder / f"{name}.csv"
    if not path.exists():
        raise SystemExit(f"{path} is missing: run ./build.sh run bench")
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    facts = {}
    for row in rows:
        first = next(iter(row.values()))
        if first.startswith("# "):
            key, _, value = first[2:].partition(": ")
            facts[key] = value
    return [{**row, **facts} for row in rows if not next(iter(row.values())).startswith("# ")]


def row_of(rows: Sequence[Row], **wanted: str) -> Row:
    """The first row with these values."""
    return next(row for row in rows if all(row[key] == value for key, value in wanted.items()))


def prose(text: str) -> str:
    """A paragraph, or an item of a list, in lines of at most 118 characters."""
    hang = "  " if text.startswith("- ") else ""
    line = " ".join(text.split())
    return textwrap.fill(line, 118, subsequent_indent=hang, break_long_words=False, break_on_hyphens=False)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def rounded(text: str, digits: int = 3) -> str:
    """A number with three significant digits, without an exponent below 10^6. Empty stays empty."""
    if not text:
        return ""
    value = float(text)
    if value == 0.0:
        return "0"
    if abs(value) >= 1e6:
        return f"{value:.{digits}g}".replace("e+0", "e").replace("e+", "e")
    return f"{float(f'{value:.{digits}g}'):,.10g}"
