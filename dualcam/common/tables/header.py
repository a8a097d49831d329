"""The header of a table: where it is, and which column is which quantity."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

from dualcam.common.tables.rows import LONGEST, SEPARATORS, Line, Lines, is_number, split
from dualcam.common.tables.units import (
    KINDS,
    UNITS,
    ColumnKind,
    Head,
    TableKind,
    head_of,
    known_unit,
)
from dualcam.errors import TableError

FIRST_LINES = 200  # among which the header is
SEPARATOR_LINE = re.compile(r"\W*sep=(.)?\W*", re.IGNORECASE)  # a first line that spreadsheets write
COMMENT_OF_HEADER = re.compile(r"\s#\s.*")
BRACKETS = "[](){}"


@dataclass(frozen=True)
class Header:
    """A header and where the rows begin."""

    line: Line
    heads: list[str]  # with the units of a row of units below
    separator: str
    first: int  # of the lines: the first row


class Column(NamedTuple):
    """The column of a quantity."""

    place: int
    unit: str  # "" for a name that needs none
    factor: float  # to the SI unit


def without_separator_line(lines: Lines) -> tuple[str | None, Lines]:
    """The separator that a first line `sep=;` gives, and the other lines."""
    found = SEPARATOR_LINE.fullmatch(lines[0].text) if lines else None
    return (found[1], lines.since(1)) if found else (None, lines)


def find_header(lines: Lines, comments: Lines, kind: TableKind, separator: str | None) -> Header:
    """The first line, or comment above all rows, that names all needed columns. TableError without one."""
    for header in _candidates(lines, comments, separator):
        try:
            columns = columns_of(header, kind)
        except TableError:
            continue
        if not _has_rows_above(header, lines, columns):
            return header
    words = words_above_numbers(lines, comments, separator)
    if words is None:
        if not kind.needs_header:
            return Header(lines[0], list(kind.quantities), separator or ",", 0)
        text = f"there is no header, so the units are not known: add a first line such as {kind.example}"
        raise TableError(text)
    columns_of(words, kind)
    raise TableError(f"line {words.line.number}: there are rows above the header: write one table in a file")


def _candidates(lines: Lines, comments: Lines, separator: str | None) -> Iterator[Header]:
    for k, line in enumerate(islice(lines, FIRST_LINES)):
        if re.search(r"[^\W\d]|°", line.text):
            yield from _headers(lines, line, k + 1, separator)
    for line in _comments_above(lines, comments):
        yield from _headers(lines, line, 0, separator)


def _comments_above(lines: Lines, comments: Lines) -> list[Line]:
    return comments.above(lines[0].number) if len(lines) else list(comments)


def _headers(lines: Lines, line: Line, first: int, separator: str | None) -> Iterator[Header]:
    for text in dict.fromkeys((line.text, COMMENT_OF_HEADER.sub("", line.text))):
        for sign in [separator] if separator else SEPARATORS:
            heads = _heads(text, sign)
            below = _heads(lines[first].text, sign) if first < len(lines) else []
            if len(below) == len(heads) and _are_units(below):
                heads = [f"{head} [{unit.strip(BRACKETS)}]" for head, unit in zip(heads, below, strict=True)]
                yield Header(line, heads, sign, first + 1)
            else:
                yield Header(line, heads, sign, first)


def _heads(text: str, separator: str) -> list[str]:
    if separator == " ":
        text = re.sub(r"\s+(?=[\[(/])|(?<=/)\s+", "", text.strip())
    heads = [cell.strip().strip("\"'").strip() for cell in split(text, separator)]
    while heads and not heads[-1]:
        heads.pop()  # a spreadsheet's empty columns
    return heads


def _are_units(cells: Sequence[str]) -> bool:
    """Whether cells are a row of units: each a unit, in brackets, or empty."""
    bare = [cell.strip(BRACKETS + " ") for cell in cells]
    units = [cell for cell, text in zip(cells, bare, strict=True) if cell != text or known_unit(text)]
    return any(cell not in ("1", "-") for cell in units) and all(cell in units or not cell for cell in cells)


def _has_rows_above(header: Header, lines: Lines, columns: Mapping[str, Column]) -> bool:
    """Whether there are numbers in the columns above the header, as in a file of two tables."""
    rows = [split(line.text, header.separator) for line in lines.above(header.line.number)]
    return any(
        len(row) == len(header.heads) and all(is_number(row[column.place]) for column in columns.values())
        for row in rows
    )


def words_above_numbers(lines: Lines, comments: Lines, separator: str | None) -> Header | None:
    """The line above the first line of numbers, or the first line where none has numbers."""
    rows = (k for k, line in enumerate(islice(lines, FIRST_LINES)) if _has_numbers(line.text))
    first = next(rows, 1)
    if first == 0:
        above = _comments_above(lines, comments)
        return _widest(_headers(lines, above[-1], 0, separator)) if above else None
    found = _widest(_headers(lines, lines[first - 1], first, separator))
    with_units = _widest(_headers(lines, lines[first - 2], first - 1, separator)) if first > 1 else found
    return with_units if with_units.first == first else found


def _widest(headers: Iterator[Header]) -> Header:
    return max(headers, key=lambda header: len(header.heads))


def _has_numbers(text: str) -> bool:
    """Whether half of a line's cells or more are numbers."""
    rows = [split(text, separator) for separator in SEPARATORS]
    return any(2 * sum(map(is_number, cells)) >= len(cells) for cells in rows)


def columns_of(header: Header, kind: TableKind) -> dict[str, Column]:
    """The column of each quantity: by its name, or as the only one with a unit of its kind; or TableError."""
    heads = [head_of(text) for text in header.heads]
    found: dict[str, Column] = {}
    for name, quantity in kind.quantities.items():
        columns = _named(heads, name, kind) or (_of_kind(heads, quantity, kind) if quantity.needed else [])
        if len(columns) > 1:
            both = " and ".join(repr(header.heads[column.place]) for column in columns)
            raise TableError(
                f"line {header.line.number}: the columns {both} are both {name}: allowed is one. Leave out or"
                " rename the others"
            )
        if columns:
            found[name] = columns[0]
    if not found and not kind.needs_header and len(heads) == len(kind.units):
        return {
            name: Column(k, unit, UNITS[kind.quantities[name].kind][unit])
            for k, (name, unit) in enumerate(kind.units.items())
        }
    lacking = [name for name, quantity in kind.quantities.items() if quantity.needed and name not in found]
    if lacking:
        raise TableError(_what_lacks(header, heads, lacking, kind))
    return found


def _named(heads: Sequence[Head], name: str, kind: TableKind) -> list[Column]:
    """Columns with a name of the quantity, whose unit is known."""
    quantity = kind.quantities[name]
    places = [place for place, head in enumerate(heads) if head.name in quantity.words]
    columns = (_column(place, heads[place], name, kind) for place in places)
    return [column for column in columns if column]


def _column(place: int, head: Head, name: str, kind: TableKind) -> Column | None:
    quantity = kind.quantities[name]
    unit = kind.units.get(name, head.unit)
    if unit in UNITS[quantity.kind]:
        return Column(place, unit, UNITS[quantity.kind][unit])
    is_ratio = quantity.kind == "ratio" and not unit and not head.unknown
    needs_none = is_ratio or head.text == quantity.bare_name
    return Column(place, "", 1.0) if needs_none else None


def _of_kind(heads: Sequence[Head], quantity: ColumnKind, kind: TableKind) -> list[Column]:
    """Columns with a unit of the quantity's kind, without the name of another quantity."""
    alike = (other for other in kind.quantities.values() if other.kind == quantity.kind)
    names = {word for other in alike for word in other.words}
    return [
        Column(place, head.unit, UNITS[quantity.kind][head.unit])
        for place, head in enumerate(heads)
        if KINDS.get(head.unit) == quantity.kind and head.name not in names
    ]


def _what_lacks(header: Header, heads: Sequence[Head], lacking: Sequence[str], kind: TableKind) -> str:
    reasons = []
    for name in lacking:
        words = kind.quantities[name].words
        named = [place for place, head in enumerate(heads) if head.name in words]
        wrong = [_what_is_wrong(header.heads[place], heads[place], name) for place in named]
        reasons += wrong or [f"no column of {name}"]
    reasons += [
        f"column {text!r}: unit {head.unknown!r} is not known"
        for text, head in zip(header.heads, heads, strict=True)
        if head.unknown and not any(head.name in quantity.words for quantity in kind.quantities.values())
    ]
    units = (f"units of {name} are {', '.join(UNITS[kind.quantities[name].kind])}" for name in lacking)
    return (
        f"line {header.line.number}, header {', '.join(header.heads)[:LONGEST]!r}: {'; '.join(reasons)}."
        f" Allowed is a header such as {kind.example}; {'; '.join(units)}"
    )


def _what_is_wrong(text: str, head: Head, name: str) -> str:
    if head.unknown:
        return f"column {text!r}: unit {head.unknown!r} is not known"
    return f"column {text!r}: " + (f"{head.unit} is no unit of {name}" if head.unit else "no unit")
