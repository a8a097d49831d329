"""Tables from files: columns by quantity in SI units, and columns by name."""

import re
import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dualcam.common.arrays import Array
from dualcam.common.tables.header import (
    Column,
    Header,
    columns_of,
    find_header,
    without_separator_line,
    words_above_numbers,
)
from dualcam.common.tables.rows import (
    Lines,
    cells_of,
    decoded_text,
    has_decimal_comma,
    likely_thousand,
    lines_of,
    name_of,
    numbers_of,
    refuse_faults,
    separator_of,
)
from dualcam.common.tables.units import UNITS, TableKind, in_unit, is_fmu_text
from dualcam.common.unit_guards import unit_warning
from dualcam.errors import TableError, UnitWarning

NAME_AND_UNIT = re.compile(r"(\S.*?)\s+[\[(]\s*([^\])]+?)\s*[\])]")  # der(x) and x[1] have no unit
Columns = Mapping[str, Column]
NamedColumns = dict[str, Array | list[str]]
Converter = Callable[[str, str, Array], Array]  # name, unit, values in the unit -> values


@dataclass(frozen=True, eq=False)
class HumanTable:
    """The columns of a file, and how the file was understood."""

    columns: Mapping[str, Array]  # by quantity, shape (n,), in SI units
    lines: np.ndarray  # of the file, from 1
    heads: Mapping[str, str]  # by quantity, as in the file
    units: Mapping[str, str]  # by quantity, "" for a name without unit
    notes: tuple[str, ...]  # what was guessed, in words
    warnings: tuple[str, ...]  # values that look like another unit, or had points between thousands
    _text: str
    _is_utf8: bool

    def is_for_the_fmu(self, headers: Collection[str]) -> bool:
        """Whether the FMU can read the file as it is, with one of its headers."""
        return self._is_utf8 and is_fmu_text(self._text, headers)


def read_table(
    path: Path, kind: TableKind, separator: str | None = None, decimal: str | None = None
) -> HumanTable:
    """The columns of a table in a file, as docs/tables.md describes. `separator`, `decimal`: None is guessed.

    The kind's error, with line and column, where something is wrong."""
    try:
        text, is_utf8 = decoded_text(path, kind.what)
    except TableError as error:
        raise kind.error(str(error)) from None
    try:
        return _understood(text, is_utf8, kind, separator, decimal)
    except TableError as error:
        raise kind.error(f"{path}: {error}") from None


def _understood(
    text: str, is_utf8: bool, kind: TableKind, separator: str | None, decimal: str | None
) -> HumanTable:
    lines, comments, separator = _lines(text, separator, kind.example)
    header = find_header(lines, comments, kind, separator)
    columns, rows = columns_of(header, kind), lines.since(header.first)
    places = {name: column.place for name, column in columns.items()}
    cells, sign = _cells(rows, header, places.values(), separator, decimal)
    numbers, comma = _numbers(rows, header, cells, places.values(), sign, decimal)
    _check_count(len(rows), kind)
    in_file = {name: numbers[place] for name, place in places.items()}
    _check_order(rows, in_file, columns, kind)
    return HumanTable(
        {name: in_unit(values, columns[name].factor) for name, values in in_file.items()},
        np.array(rows.numbers),
        {name: header.heads[place] for name, place in places.items()},
        {name: column.unit for name, column in columns.items()},
        _notes(lines, header, None if separator else sign, comma and decimal is None),
        (*_unit_warnings(in_file, columns, kind), *_thousands(cells, header, places, sign)),
        text,
        is_utf8,
    )


def read_columns(
    path: Path, what: str, texts: Collection[str] = (), converted: Converter | None = None
) -> NamedColumns:
    """All columns of a table in a file, by the names in its header; those in `texts` hold texts.

    `converted` takes name, unit and values of a column with a unit; None: units are refused. TableError with
    line and column. UnitWarning for a column without unit that looks like another unit."""
    text, _ = decoded_text(path, what)
    try:
        return _named_columns(text, texts, converted)
    except TableError as error:
        raise TableError(f"{path}: {error}") from None


def _named_columns(text: str, texts: Collection[str], converted: Converter | None) -> NamedColumns:
    lines, comments, separator = _lines(text, None, "spring.preload,cam1.friction")
    header = words_above_numbers(lines, comments, separator)
    if header is None:
        raise TableError("there is no header: add a first line with the names of the columns")
    matches = [NAME_AND_UNIT.fullmatch(head) for head in header.heads]
    names = [match[1] if match else head for match, head in zip(matches, header.heads, strict=True)]
    if twice := {name for name in names if names.count(name) > 1}:
        raise TableError(f"two columns {', '.join(sorted(twice))}: allowed is one")
    rows = lines.since(header.first)
    places = [place for place, name in enumerate(names) if name not in texts]
    cells, sign = _cells(rows, header, places, separator, None)
    numbers, _ = _numbers(rows, header, cells, places, sign, None)
    found: NamedColumns = {}
    for place, (name, match) in enumerate(zip(names, matches, strict=True)):
        if name in texts:
            found[name] = [cell.strip() for cell in cells[place :: len(names)]]
        elif match is None:
            found[name] = numbers[place]
            if len(rows) and (doubt := unit_warning(name, _farthest(numbers[place]))):
                warnings.warn(UnitWarning(doubt), stacklevel=3)
        elif converted is None:
            raise TableError(f"column {match[0]!r}: allowed are values in the FMU's units, without unit")
        else:
            found[name] = converted(name, match[2], numbers[place])
    return found


def _lines(text: str, separator: str | None, example: str) -> tuple[Lines, Lines, str | None]:
    """Lines with content, comments, and the separator that is given or that a first line gives."""
    lines, comments = lines_of(text.replace("\u2212", "-"))  # the minus sign of word processors
    written, left = without_separator_line(lines)
    if not len(left) and not len(comments):
        raise TableError(f"the file is empty: line 1 must be a header such as {example}")
    return left, comments, separator or written


def _cells(
    rows: Lines, header: Header, places: Collection[int], separator: str | None, decimal: str | None
) -> tuple[list[str], str]:
    """The cells, row after row, and the separator. `places`: the columns of numbers."""
    width = len(header.heads)
    sign = separator or separator_of(rows, width, places, header.separator)
    return cells_of(rows, width, sign, decimal), sign


def _numbers(
    rows: Lines,
    header: Header,
    cells: Sequence[str],
    places: Collection[int],
    separator: str,
    decimal: str | None,
) -> tuple[dict[int, Array], bool]:
    """Numbers by place of the column, and whether the decimal sign is a comma."""
    columns = {place: cells[place :: len(header.heads)] for place in places}
    comma = has_decimal_comma(columns.values(), separator) if decimal is None else decimal == ","
    numbers = {place: numbers_of(column, comma) for place, column in columns.items()}
    refuse_faults(rows, header.heads, {place: (columns[place], numbers[place]) for place in places}, comma)
    return numbers, comma


def _check_count(count: int, kind: TableKind) -> None:
    if not kind.least <= count <= (kind.most or count):
        allowed = f"{kind.least} or more" if count < kind.least else f"up to {kind.most:,}"
        lines = "line" if count == 1 else "lines"
        raise TableError(f"{count:,} {lines} of numbers: allowed are {allowed}")


def _check_order(rows: Lines, values: Mapping[str, Array], columns: Columns, kind: TableKind) -> None:
    for name, column in values.items():
        order = kind.quantities[name].order
        steps = np.diff(column)
        bad = steps <= 0.0 if order == "rises" else steps < 0.0
        if not order or not bad.any():
            continue
        k, unit = int(np.argmax(bad)), columns[name].unit
        before, value = (f"{number:.9g} {unit}".strip() for number in column[k : k + 2])
        allowed = "more than" if order == "rises" else "at least"
        raise TableError(
            f"line {rows.numbers[k + 1]}, column {columns[name].place + 1}: {name} = {value}: allowed is"
            f" {allowed} {before}, the value of line {rows.numbers[k]}. Sort the lines, and leave out"
            " repeated ones"
        )


def _notes(lines: Lines, header: Header, guessed: str | None, comma: bool) -> tuple[str, ...]:
    notes = []
    if above := lines.above(header.line.number):
        notes.append(f"lines {above[0].number} to {above[-1].number} above the header were left out")
    if guessed not in (None, ","):
        notes.append(f"columns are separated by {name_of(guessed)}")
    if comma:
        notes.append("the decimal sign is a comma")
    return tuple(notes)


def _unit_warnings(values: Mapping[str, Array], columns: Columns, kind: TableKind) -> Sequence[str]:
    """Warnings of columns in SI units with values that look as if they were in another unit."""
    found = []
    for name, column in values.items():
        quantity = kind.quantities[name]
        if columns[name].unit in ("", next(iter(UNITS[quantity.kind]))):
            found.append(unit_warning(quantity.rule, _farthest(column), name))
    return [text for text in found if text]


def _thousands(cells: Sequence[str], header: Header, places: Mapping[str, int], separator: str) -> list[str]:
    """A warning where all points may separate thousands."""
    columns = (cells[place :: len(header.heads)] for place in places.values())
    number = likely_thousand(columns, separator)
    text = f"{number} was read with a decimal point. If the points separate thousands, write "
    return [text + number.replace(".", "")] if number else []


def _farthest(values: Array) -> float:
    return float(values[np.argmax(np.abs(values))])
