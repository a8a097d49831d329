"""Rows of a table: separators, decimal commas, numbers."""

from __future__ import annotations

import csv
import math
import re
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

from dualcam.common.arrays import Array
from dualcam.errors import TableError

SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "spaces"}
NUMBER = re.compile(r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?")
THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[.,]\d{3})+(?:[.,]\d*)?")
THOUSAND = re.compile(r"[+-]?[1-9]\d{0,2}\.\d{3}")  # or a number with three decimals
WHOLE_PART, DECIMALS = re.compile(r"\s*[+-]?\d+"), re.compile(r"\d+(?:[eE][+-]?\d+)?\s*")
FIRST_ROWS = 50  # that tell the separator
MOST_LISTED = 3  # faults in one message
LONGEST = 60  # characters of a line in a message
LARGEST = 2**30  # bytes
MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}  # first bytes of an encoding
ZIP = b"PK\x03\x04"
EMPTY = ";, \t\"'"  # what a line without content has
# A comment stands alone in its line, or behind a number: the # of a text such as "run #1" is none.
COMMENT_BEHIND = re.compile(r"""((?:^|[;,\t ])["']?[+-]?[\d.,]+(?:[eE][+-]?\d+)?["']?[;,\t ]*)#.*""")


def name_of(separator: str) -> str:
    """A separator in words."""
    return SEPARATORS.get(separator, repr(separator))


def split(text: str, separator: str) -> list[str]:
    """The cells of a line."""
    if '"' in text:
        return next(csv.reader([text], delimiter=separator, skipinitialspace=True))
    return text.split() if separator == " " else text.split(separator)


def is_number(cell: str) -> bool:
    """Whether a cell looks like a number, with a decimal point or comma."""
    return NUMBER.fullmatch(cell.strip("\"' \t")) is not None


def separator_of(rows: Lines, width: int, places: Iterable[int], usual: str) -> str:
    """The separator with which most of the first rows have `width` cells and numbers at `places`, or `usual`.

    For another one all cells must be numbers: blanks and decimal commas look alike around a text."""
    order = [";", "\t", usual, ",", " "]
    needed = {separator: tuple(places) if separator == usual else range(width) for separator in order}

    def good_rows(separator: str) -> int:
        first = (_without_empty_end(split(text, separator), width) for text in rows.texts[:FIRST_ROWS])
        whole = (cells for cells in first if len(cells) == width)
        return sum(all(is_number(cells[place]) for place in needed[separator]) for cells in whole)

    most = max(map(good_rows, order))
    return next(separator for separator in order if good_rows(separator) == most) if most else usual


def cells_of(rows: Lines, width: int, separator: str, decimal: str | None) -> list[str]:
    """The cells of all rows, row after row, `width` in each. TableError for a row with more, or with fewer
    between blanks: elsewhere cells that lack at the end of a row are empty."""
    joined = separator.join(rows.texts)
    is_plain = separator != " " and '"' not in joined
    if is_plain and {text.count(separator) for text in rows.texts} == {width - 1}:
        return joined.split(separator)
    cells = [_without_empty_end(split(text, separator), width) for text in rows.texts]
    least = width if separator == " " else 0
    strange = next((k for k, row in enumerate(cells) if not least <= len(row) <= width), None)
    if strange is not None:
        if separator != "," or decimal == "." or "." in joined:
            _refuse_row(rows[strange], len(cells[strange]), width, separator)
        cells = [_joined(row, width) for row in rows]
    return [cell for row in cells for cell in (*row, *[""] * (width - len(row)))]


def _refuse_row(row: Line, count: int, width: int, separator: str) -> NoReturn:
    hint = ". Is the decimal sign a comma? Then put semicolons between the columns"
    raise TableError(
        f"line {row.number}, {row.text[:LONGEST]!r}: {count} values between {name_of(separator)}, {width}"
        f" columns in the header: allowed is one value for each column{hint if separator == ',' else ''}"
    )


def _without_empty_end(cells: list[str], width: int) -> list[str]:
    """The cells without the empty ones that a spreadsheet adds behind the last column."""
    while len(cells) > width and not cells[-1].strip():
        cells = cells[:-1]
    return cells


def _joined(row: Line, width: int) -> list[str]:
    """The cells of a row whose commas separate and are decimal signs. TableError unless just one way fits."""
    parts = _without_empty_end(row.text.split(","), 2 * width)
    joins = [bool(WHOLE_PART.fullmatch(a) and DECIMALS.fullmatch(b)) for a, b in pairwise(parts)]
    # ways[k][n]: in how many ways the parts from k on make n cells
    ways = [[0] * (width + 1) for _ in range(len(parts) + 2)]
    ways[len(parts)][0] = 1
    for k in reversed(range(len(parts))):
        joins_here = k + 1 < len(parts) and joins[k]
        for n in range(1, width + 1):
            ways[k][n] = ways[k + 1][n - 1] + (ways[k + 2][n - 1] if joins_here else 0)
    if ways[0][width] != 1:
        raise TableError(
            f"line {row.number}, {row.text[:LONGEST]!r}: {len(parts)} values between commas, {width} columns"
            " in the header: the comma seems to be separator and decimal sign, and this line can be read in"
            f" {ways[0][width] or 'no'} ways. Put semicolons between the columns, or write decimal points"
        )
    cells, k = [], 0
    for n in range(width, 0, -1):
        taken = 1 if ways[k + 1][n - 1] else 2
        cells.append(",".join(parts[k : k + taken]))
        k += taken
    return cells


def has_decimal_comma(columns: Iterable[Sequence[str]], separator: str) -> bool:
    """Whether the comma is the decimal sign. Between commas "1,331" may be a quoted number with thousands."""
    with_comma = [cell.strip("\"' \t") for column in columns for cell in column if "," in cell]
    if separator != ",":
        return bool(with_comma)
    return not all(THOUSANDS.fullmatch(cell) for cell in with_comma)


def likely_thousand(columns: Iterable[Sequence[str]], separator: str) -> str:
    """A number such as 1.145 whose point may separate thousands; empty where any number tells otherwise."""
    dotted = [cell.strip("\"' \t") for column in columns for cell in column if "." in cell]
    may_be = separator == ";" and all(THOUSAND.fullmatch(cell) for cell in dotted)
    return dotted[0] if may_be and dotted else ""


def numbers_of(cells: Sequence[str], comma: bool) -> Array:
    """The numbers of a column; NaN where a cell is none. `comma`: whether the decimal sign is a comma."""
    foreign = "._" if comma else ",_"
    joined = "".join(cells)
    if not any(sign in joined for sign in foreign):
        try:
            return np.array(list(map(float, [cell.replace(",", ".") for cell in cells] if comma else cells)))
        except ValueError:
            pass
    return np.array([_number(cell, comma) for cell in cells])


def _number(cell: str, comma: bool) -> float:
    plain = cell.strip("\"' \t")
    if not NUMBER.fullmatch(plain) or ("." if comma else ",") in plain:
        return math.nan
    return float(plain.replace(",", "."))


def refuse_faults(
    rows: Lines, heads: Sequence[str], columns: dict[int, tuple[Sequence[str], Array]], comma: bool
) -> None:
    """TableError with the first cells that are no finite numbers. `columns`: cells and numbers by place."""
    faults = [
        (int(k), place, cells[k].strip())
        for place, (cells, values) in columns.items()
        for k in np.flatnonzero(~np.isfinite(values))[: MOST_LISTED + 1]
    ]
    if not faults:
        return
    count = sum(int((~np.isfinite(values)).sum()) for _, values in columns.values())
    shown = [
        f"line {rows.numbers[k]}, column {place + 1} ({heads[place]}): "
        + (repr(cell[:LONGEST]) if cell else "no value")
        for k, place, cell in sorted(faults)[:MOST_LISTED]
    ]
    more = f" and {count - MOST_LISTED} more" if count > MOST_LISTED else ""
    sign = "comma" if comma else "point"
    raise TableError(
        f"{'; '.join(shown)}{more}: allowed is a finite number with a decimal"
        f" {sign}{_hint(sorted(faults)[0][2], comma)}"
    )


def _hint(cell: str, comma: bool) -> str:
    """What may help with a cell that is no number."""
    foreign = "." if comma else ","
    if THOUSANDS.fullmatch(cell.strip("\"'")) and foreign in cell:
        return f"; thousands are not separated: write {cell.replace(foreign, '')}"
    return "" if cell else ". Leave out lines that lack a value"


class Line(NamedTuple):
    """A line of a file."""

    number: int  # from 1
    text: str


@dataclass(frozen=True)
class Lines:
    """Lines of a file with content, in columns: a table may have millions."""

    numbers: Sequence[int]
    texts: Sequence[str]

    def __len__(self) -> int:
        return len(self.texts)

    def __getitem__(self, place: int) -> Line:
        return Line(self.numbers[place], self.texts[place])

    def __iter__(self) -> Iterator[Line]:
        return map(Line, self.numbers, self.texts)

    def since(self, first: int) -> Lines:
        """The lines from a place on."""
        return Lines(self.numbers[first:], self.texts[first:])

    def above(self, number: int) -> list[Line]:
        """The lines above the line of that number."""
        return [self[place] for place in range(bisect_left(self.numbers, number))]


def decoded_text(path: Path, what: str) -> tuple[str, bool]:
    """The text of the file `what`, and whether it is in UTF-8. TableError for a file that cannot be read."""
    if path.is_dir():
        raise TableError(f"{path} is a folder: allowed is a file with a {what}")
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except FileNotFoundError:
        raise TableError(f"there is no {what} {path}: check folder and name") from None
    except (OSError, ValueError) as error:
        raise TableError(f"{what} {path} cannot be read: {error}") from None
    if len(content) > LARGEST:
        raise TableError(f"{what} {path} is larger than {LARGEST:,} bytes: leave out lines")
    if content.startswith(ZIP):
        raise TableError(f"{what} {path} is a workbook of a spreadsheet: save the sheet as CSV")
    encoding = MARKS.get(content[:2]) or _without_mark(content[:2])
    try:
        return content.decode(encoding), encoding == "utf-8-sig"
    except UnicodeDecodeError:
        # a degree sign of an old spreadsheet; the numbers are the same
        return content.decode("latin-1"), False


def _without_mark(begin: bytes) -> str:
    """The encoding of a text without a byte order mark, from its first two bytes."""
    if len(begin) == 2 and begin[1] == 0:
        return "utf-16-le"
    return "utf-16-be" if begin[:1] == b"\0" else "utf-8-sig"


def lines_of(text: str) -> tuple[Lines, Lines]:
    """Lines with content, and lines that are comments, without their sign."""
    texts = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    numbers = [number for number, text in enumerate(texts, 1) if text.strip(EMPTY)]
    texts = [texts[number - 1] for number in numbers]
    if "#" not in text:
        return Lines(numbers, texts), Lines([], [])
    numbered = list(zip(numbers, texts, strict=True))
    comments = [(number, text.lstrip(f"{EMPTY}#")) for number, text in numbered if _is_comment(text)]
    lines = [(number, COMMENT_BEHIND.sub(r"\1", text)) for number, text in numbered if not _is_comment(text)]
    return _in_columns(lines), _in_columns(comments)


def _in_columns(lines: Sequence[tuple[int, str]]) -> Lines:
    return Lines([number for number, _ in lines], [text for _, text in lines])


def _is_comment(text: str) -> bool:
    return text.lstrip(EMPTY).startswith("#")
