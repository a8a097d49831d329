"""The text of a TOML file: its content, the lines of its keys, and the likely cause of an error of syntax."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dualcam.common.paths import near_names
from dualcam.design_file.findings import ERROR, Finding
from dualcam.errors import DesignFileError

LARGEST = 4 * 1024 * 1024  # bytes
DEEPEST = 50  # tables and lists inside one another: readers call themselves for each level
KEY = r"""(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')"""
DOTTED = rf"{KEY}(?:\s*\.\s*{KEY})*"
HEADER = re.compile(rf"\s*\[\[?\s*({DOTTED})\s*\]\]?")
ENTRY = re.compile(rf"\s*({DOTTED})\s*=")
# What stands on a line that TOML refuses, and what to write instead.
CAUSES = (
    (r"=\s*[+-]?\d+,\d+\s*(#.*)?$", "a decimal comma? Write a decimal point: 1.5, not 1,5"),
    (r"=\s*\"[^\"]*\\", "a path with backslashes? Write / or single quotes: 'C:\\grooves\\cam.csv'"),
    (r"=\s*[+-]?\d[\d.]*\s*[A-Za-z°%]", 'a unit without quotes? Write the value in quotes: "45 deg"'),
    (r"=\s*[+-]?\.\d", "a number without a digit before the point? Write 0.5, not .5"),
    (r"=\s*[+-]?\d+\.(\s|$|#|[eE])", "a number without a digit after the point? Write 5.0, not 5."),
    (r"=\s*[+-]?0\d", "a number that begins with 0? Write 7, not 07"),
    (r"=\s*(True|False|yes|no|on|off)\b", "a switch? Write true or false in small letters"),
    (r"=\s*[\u201c\u201d\u201e\u2018\u2019]", 'curly quotes? Write straight ones: ".."'),
    (r"=\s*[A-Za-z/\\.]", 'text without quotes? Write text in quotes: "groove.csv"'),
    (r"=\s*(#.*)?$", "a key without a value? Write the value after ="),
    (rf"^\s*{DOTTED}\s*:", "a colon after the key? Write key = value"),
    (r"^\s*(;|//)", "a comment? Comments begin with #"),
    (rf"^\s*{DOTTED}\s+[^=\s]", "a missing = ? Write key = value"),
    (r"^\s*\[[^\]]*$", "a missing ] ? Write [cam1]"),
    (r"=\s*(\"[^\"]*|'[^']*)$", "a missing quote at the end of the text?"),
)


def read_text(path: Path) -> str:
    """The text of a file in UTF-8, with or without byte order mark. DesignFileError if there is none."""

    def refused(text: str) -> DesignFileError:
        return DesignFileError(path, [Finding(ERROR, "", None, text)])

    if path.is_dir():
        raise refused("this is a folder: give the path of a design file, such as my.toml")
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except FileNotFoundError:
        raise refused(f"there is no such file{_similar(path)}; `dualcam new {path}` makes one") from None
    except (OSError, ValueError) as error:  # ValueError: a zero character in the path
        raise refused(f"the file cannot be read: {error}") from None
    if len(content) > LARGEST:
        raise refused(f"the file is larger than {LARGEST:,} bytes: this is no design file")
    if content.startswith(b"PK\x03\x04"):
        raise refused("this is an FMU or another zip archive: give the design file (.toml)")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise refused('the file is in UTF-16: save the file as "UTF-8" in the editor')
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        words = 'the text is not UTF-8: save the file as "UTF-8" in the editor'
        raise DesignFileError(path, [Finding(ERROR, "", None, words, line=line)]) from None


def _similar(path: Path) -> str:
    """Files in the same folder that could be meant."""
    try:
        names = [other.name for other in path.parent.iterdir() if other.suffix == ".toml"]
    except OSError:
        return ""
    close = near_names(path.name, names)
    return f": did you mean {close[0]}?" if close else ""


def parse(path: Path, text: str) -> dict[str, Any]:
    """The content of TOML text. DesignFileError with line and likely cause if the text is no TOML."""
    try:
        content = tables_of(text)
    except tomllib.TOMLDecodeError as error:
        raise DesignFileError(path, [_syntax_finding(str(error), text)]) from None
    except ValueError as error:  # a whole number with thousands of digits
        raise DesignFileError(path, [Finding(ERROR, "", None, f"this is no TOML: {error}")]) from None
    if content is None:
        finding = Finding(ERROR, "", None, "this is no design file: tables or lists are nested too deeply")
        raise DesignFileError(path, [finding])
    return content


def tables_of(text: str) -> dict[str, Any] | None:
    """The content of TOML text; None if tables or lists are nested too deeply. ValueError if the text is no
    TOML."""
    try:
        content = tomllib.loads(text)
    except RecursionError:
        return None
    level: list[Any] = [content]
    for _ in range(DEEPEST):
        inside = (one for outer in level for one in (outer.values() if isinstance(outer, dict) else outer))
        level = [one for one in inside if isinstance(one, dict | list)]
    return None if level else content


def _syntax_finding(message: str, text: str) -> Finding:
    lines = text.split("\n")
    place = re.search(r" \(at (?:line (\d+), column \d+|end of document)\)$", message)
    number = int(place[1]) if place and place[1] else len(lines)
    reason = message[: place.start()] if place else message
    written = lines[min(number, len(lines)) - 1].strip()
    shown = f" in {written[:60]!r}" if written else ""
    cause = next((words for pattern, words in CAUSES if re.search(pattern, written)), "")
    if "overwrite" in reason.lower() or "twice" in reason:
        cause = "the same key or table twice? Keep one of them"
        if table := HEADER.match(written):
            name = f"[{table[1]}]"
            cause = f"the table {name} twice? Put all its lines below one {name}, and no key twice"
    hint = f". {cause[0].upper()}{cause[1:]}" if cause else ""
    return Finding(ERROR, "", None, f"this is no TOML: {reason}{shown}{hint}", line=number)


def lines_of_keys(text: str) -> Mapping[tuple[str, ...], int]:
    """Line, from 1, at which each key or table first stands."""
    found: dict[tuple[str, ...], int] = {}
    table: tuple[str, ...] = ()
    for number, line in enumerate(text.split("\n"), 1):
        if header := HEADER.match(line):
            table = _parts(header[1])
            found.setdefault(table, number)
        elif entry := ENTRY.match(line):
            key = (*table, *_parts(entry[1]))
            for depth in range(len(table) + 1, len(key) + 1):
                found.setdefault(key[:depth], number)
    return found


def line_of(lines: Mapping[tuple[str, ...], int], key: tuple[str, ...]) -> int | None:
    """The line of a key, or of the nearest table around the key."""
    for depth in range(len(key), 0, -1):
        if key[:depth] in lines:
            return lines[key[:depth]]
    return None


def _parts(dotted: str) -> tuple[str, ...]:
    return tuple(part.strip("\"'") for part in re.findall(KEY, dotted))
