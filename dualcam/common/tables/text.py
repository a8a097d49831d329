"""The text of a file of numbers, and its lines."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from dualcam.common.tables.kinds import TableError

LARGEST = 2**30  # bytes
MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}  # first bytes of an encoding
ZIP = b"PK\x03\x04"
EMPTY = ";, \t\"'"  # what a line without content has
# A comment stands alone in its line, or behind a number: the # of a text such as "run #1" is none.
COMMENT_BEHIND = re.compile(r"""((?:^|[;,\t ])["']?[+-]?[\d.,]+(?:[eE][+-]?\d+)?["']?[;,\t ]*)#.*""")


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
