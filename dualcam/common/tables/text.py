"""The text of a file of numbers, and its lines."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from dualcam.common.tables.kinds import TableError

LARGEST = 2**30  # bytes
MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}  # first bytes of an encoding
ZIP = b"PK\x03\x04"
EMPTY = ";, \t\"'"  # what a line without content has
# A comment stands alone in its line, or behind a number: the # of a text such as "run #1" is none.
COMMENT_BEHIND = re.compile(
    r"""((?:^|[;,\t ])["']?[+-]?[\d.,]+(?:[eE][+-]?\d+)?["']?[;,\t ]*)#.*"""
)


class Line(NamedTuple):
    """A line of a file with content."""

    number: int  # from 1
    text: str


def decoded_text(path: Path, what: str) -> tuple[str, bool]:
    """The text of a file of numbers, and whether the text is in UTF-8. TableError, which calls the file
    `what`, for a file that cannot be read."""
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


def lines_of(text: str) -> tuple[list[Line], list[Line]]:
    """Lines with content, and lines that are comments, without their sign."""
    plain = text.replace("\r\n", "\n").replace("\r", "\n")
    numbered = [Line(number, line) for number, line in enumerate(plain.split("\n"), 1) if line.strip(EMPTY)]
    if "#" not in plain:
        return numbered, []
    comments = [Line(number, line.lstrip("# \t")) for number, line in numbered if _is_comment(line)]
    lines = [
        Line(number, COMMENT_BEHIND.sub(r"\1", line) if "#" in line else line)
        for number, line in numbered
        if not _is_comment(line)
    ]
    return lines, comments


def _is_comment(line: str) -> bool:
    return line.lstrip(EMPTY).startswith("#")
