"""Files with sampled grooves, as people have them: any delimiter and decimal sign, degrees and millimetres.

What is not given is taken from the header or from the numbers, and said in `notes`. The FMU itself reads
one format only: the header psi_rad,z_m, then lines with a comma between the numbers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path

import numpy as np

from dualcam.design.statics import Array, DesignError

HEADER = "psi_rad,z_m"
USUAL = "psi_deg,z_mm"  # the header of most people's tables
ANGLES = {"rad": 1.0, "deg": math.pi / 180.0, "mrad": 1e-3, "turn": 2.0 * math.pi}  # rad
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 0.0254}  # m
WORDS = {  # of a header, in small letters
    **{word: "rad" for word in ("rad", "radian", "radians")},
    **{word: "deg" for word in ("deg", "degree", "degrees", "°", "grad", "grado", "grados", "gradi")},
    **{word: "m" for word in ("m", "metre", "meter", "metres", "meters")},
    **{word: "mm" for word in ("mm", "millimetre", "millimeter", "millimetres", "millimeters")},
    **{word: word for word in ("mrad", "turn", "cm")},
    **{word: "in" for word in ("inch", "inches")},
    **{word: "um" for word in ("um", "µm", "μm")},
}
SIGN_LINE = re.compile(r"\W*sep=([;,]?)\W*", re.IGNORECASE)  # a first line that spreadsheets write
THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[.,]\d{3})+(?:[.,]\d*)?")
DELIMITERS = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "spaces"}
NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?")
PLAIN = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
FMU_ROW = re.compile(rf"[ \t\r]*{PLAIN}[ \t\r]*,[ \t\r]*{PLAIN}[ \t\r]*", re.ASCII)
LARGEST = 16 * 1024 * 1024  # bytes, as for the FMU
MOST = 100_000  # samples, as for the FMU


@dataclass(frozen=True, eq=False)
class GrooveFile:
    """The samples of a file in SI units, and how the file was understood.

    Attributes
    ----------
    psi, z : ndarray, shape (n,)
        Angle of the pin along the groove [rad], and height [m].
    units : tuple of str
        Units in the file, such as ("deg", "mm").
    notes : tuple of str
        What was guessed, in words.
    is_fmu_format : bool
        Whether the FMU can read the file as it is.
    """

    psi: Array
    z: Array
    units: tuple[str, str]
    notes: tuple[str, ...]
    is_fmu_format: bool


def read_groove(
    path: str | Path,
    units: Sequence[str] | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
) -> GrooveFile:
    """Read a file of two columns, angle and height. The parameters are those of `Table.read`.

    DesignError, with file, line, column and value, for a file that cannot be understood."""
    path = Path(path)
    _check_arguments(units, delimiter, decimal)
    text, is_utf8 = decoded_text(path, "groove table")
    try:
        groove = _parsed(text, None if units is None else (units[0], units[1]), delimiter, decimal)
    except DesignError as error:
        raise DesignError(f"{path}: {error}") from None
    return groove if is_utf8 else replace(groove, is_fmu_format=False)


def _check_arguments(units: Sequence[str] | None, delimiter: str | None, decimal: str | None) -> None:
    if units is not None and not (
        not isinstance(units, str) and len(units) == 2 and units[0] in ANGLES and units[1] in LENGTHS
    ):
        raise DesignError(
            f"units = {units!r}: allowed are an angle ({', '.join(ANGLES)}) and a length"
            f' ({", ".join(LENGTHS)}), such as ("deg", "mm")'
        )
    if delimiter is not None and delimiter not in DELIMITERS:
        raise DesignError(f"delimiter = {delimiter!r}: allowed are ';', ',', ' ' and a tab")
    if decimal not in (None, ".", ","):
        raise DesignError(f"decimal = {decimal!r}: allowed are '.' and ','")
    if decimal == "," and delimiter == ",":
        raise DesignError("delimiter and decimal are both a comma: allowed is one of them")


def decoded_text(path: Path, what: str) -> tuple[str, bool]:
    """The text of a file of numbers, and whether the text is in UTF-8. DesignError, which calls the file
    `what`, for a file that cannot be read."""
    if path.is_dir():
        raise DesignError(f"{path} is a folder: allowed is a file with a {what}")
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except FileNotFoundError:
        raise DesignError(f"there is no {what} {path}: check folder and name") from None
    except (OSError, ValueError) as error:
        raise DesignError(f"{what} {path} cannot be read: {error}") from None
    if len(content) > LARGEST:
        raise DesignError(f"{path} is larger than {LARGEST:,} bytes: allowed are up to {MOST:,} samples")
    is_utf16 = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        return content.decode("utf-16" if is_utf16 else "utf-8-sig"), not is_utf16
    except UnicodeDecodeError:
        # a degree sign of an old spreadsheet; the numbers are the same
        return content.decode("latin-1"), False


# ---- lines ----


@dataclass(frozen=True)
class _Line:
    number: int  # in the file, from 1
    text: str


def _lines(text: str) -> list[_Line]:
    """Lines with content: without comments and blank lines."""
    plain = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    stripped = [(number, line.partition("#")[0].strip()) for number, line in enumerate(plain, 1)]
    return [_Line(number, line) for number, line in stripped if line.strip(";, \t\"'")]


def _is_header(line: _Line) -> bool:
    """Whether a line has words. The exponent of 1e-3 is no word."""
    return bool(re.search(r"[^\W\d_]", NUMBER.sub("", line.text)))


def _parsed(
    text: str, units: tuple[str, str] | None, delimiter: str | None, decimal: str | None
) -> GrooveFile:
    lines = _lines(text)
    if lines and (sign_line := SIGN_LINE.fullmatch(lines[0].text)):
        delimiter, lines = delimiter or sign_line[1] or None, lines[1:]
    if not lines:
        raise DesignError(f"the file is empty: its first line must be a header such as {HEADER} or {USUAL}")
    header, numbers = (lines[0], lines[1:]) if _is_header(lines[0]) else (None, lines)
    if header is not None and header.text.startswith(f"{HEADER},"):
        numbers = [_Line(line.number, ",".join(line.text.split(",")[:2])) for line in numbers]
    if not numbers:
        raise DesignError(f"there is no line of numbers below the header {header.text if header else ''!r}")
    if len(numbers) > MOST:
        raise DesignError(f"{len(numbers):,} samples: allowed are up to {MOST:,}")
    notes: list[str] = []
    separator, comma = _separators(numbers, delimiter, decimal)
    if delimiter is None and separator != ",":
        notes.append(f"columns are separated by {DELIMITERS[separator]}")
    if decimal is None and comma:
        notes.append("the decimal sign is a comma")
    samples = np.array([_sample(line, separator, comma) for line in numbers])
    found = units or _units(header, notes)
    psi, z = samples[:, 0] * ANGLES[found[0]], _metres(samples[:, 1], found[1])
    _check_order(numbers, samples, found)
    return GrooveFile(psi, z, found, tuple(notes), found == ("rad", "m") and _is_exact(text))


def _metres(values: Array, unit: str) -> Array:
    """Lengths in metres, rounded once: 4.1 mm is 0.0041 m to the last digit."""
    factor = Decimal(str(LENGTHS[unit]))
    return np.array([float(Decimal(repr(value)) * factor) for value in values.tolist()])


def _is_exact(text: str) -> bool:
    """Whether the FMU reads this text: header first, two plain numbers on each line, nothing else."""
    first, *rows = text.removeprefix("\ufeff").rstrip(" \t\r\n").split("\n")
    return first.strip(" \t\r") == HEADER and all(FMU_ROW.fullmatch(row) for row in rows)


# ---- columns and decimal sign ----


def _separators(lines: Sequence[_Line], delimiter: str | None, decimal: str | None) -> tuple[str, bool]:
    """The delimiter, and whether the decimal sign is a comma."""
    if delimiter is None:
        delimiter = next((sign for sign in ";\t" if all(sign in line.text for line in lines)), None)
    if delimiter is None:
        spaced = all(re.search(r"\S[ ]+\S", line.text.replace(", ", ",")) for line in lines)
        if spaced or decimal == ",":
            delimiter = " "
    if delimiter is None:
        delimiter = ","
        most = max(line.text.count(",") for line in lines)
        if decimal is None and most >= 2 and not any("." in line.text for line in lines):
            raise DesignError(
                f"line {lines[0].number}, {lines[0].text[:60]!r}: the comma is decimal sign and delimiter:"
                " write a decimal point, or put a semicolon between the columns"
            )
    if decimal is not None:
        return delimiter, decimal == ","
    return delimiter, delimiter != "," and any("," in line.text for line in lines)


def _sample(line: _Line, delimiter: str, comma: bool) -> tuple[float, float]:
    """Both numbers of a line."""
    cells = line.text.split() if delimiter == " " else [cell.strip() for cell in line.text.split(delimiter)]
    cells = [cell.strip("\"' ") for cell in cells]
    while len(cells) > 2 and not cells[-1]:
        cells.pop()  # a spreadsheet's empty columns
    if len(cells) != 2:
        raise DesignError(
            f"line {line.number}, {line.text[:60]!r}: {len(cells)} columns between {DELIMITERS[delimiter]}:"
            " allowed are 2, angle and height"
        )
    return _number(line, 1, cells[0], comma), _number(line, 2, cells[1], comma)


def _number(line: _Line, column: int, cell: str, comma: bool) -> float:
    plain = cell.replace(",", ".") if comma else cell
    good = NUMBER.fullmatch(plain) is not None and "," not in plain and not (comma and "." in cell)
    value = float(plain) if good else math.nan
    if not cell:
        raise DesignError(
            f"line {line.number}, column {column}, {line.text[:60]!r}: the value is missing: allowed are two"
            " numbers on each line"
        )
    if not math.isfinite(value):
        sign = "comma" if comma else "point"
        raise DesignError(
            f"line {line.number}, column {column}: {cell[:40]!r}: allowed is a finite number with a decimal"
            f" {sign}{_without_thousands(cell, comma)}"
        )
    return value


def _without_thousands(cell: str, comma: bool) -> str:
    """A hint if the number seems to have signs between its thousands."""
    separator = "." if comma else ","
    if not THOUSANDS.fullmatch(cell) or separator not in cell:
        return ""
    return f"; thousands are not separated: write {cell.replace(separator, '')}"


# ---- units ----


def _units(header: _Line | None, notes: list[str]) -> tuple[str, str]:
    """Angle and length from the header's words."""
    if header is None:
        raise DesignError(
            "there is no header, so the units are not known: add a first line such as"
            f" {USUAL} (degrees and millimetres) or {HEADER} (radians and metres)"
        )
    words = [WORDS[word] for word in re.findall(r"[^\W\d_]+|°", header.text.lower()) if word in WORDS]
    words = list(dict.fromkeys(words))
    angles = [word for word in words if word in ANGLES]
    lengths = [word for word in words if word in LENGTHS]
    if len(angles) != 1 or len(lengths) != 1:
        unknown = "".join(f"unit {word!r} is not known; " for word in _unknown_units(header.text))
        raise DesignError(
            f"line {header.number}, {header.text[:60]!r}: {unknown}the header must have one unit of angle"
            f" (deg or rad) and one unit of length (mm or m): write {USUAL} for degrees and millimetres, or"
            f" {HEADER} for radians and metres"
        )
    if words.index(angles[0]) > words.index(lengths[0]):
        raise DesignError(
            f"line {header.number}, {header.text[:60]!r}: the height comes before the angle: allowed is the"
            " angle psi in column 1 and the height z in column 2"
        )
    if (angles[0], lengths[0]) != ("rad", "m"):
        notes.append(f"the header says {angles[0]} and {lengths[0]}")
    return angles[0], lengths[0]


def _unknown_units(header: str) -> list[str]:
    """Words in brackets that are no unit."""
    bracketed = re.findall(r"[\[(]\s*([^\])]*?)\s*[\])]", header)
    return [word for word in bracketed if word and word.lower() not in WORDS]


# ---- order ----


def _check_order(lines: Sequence[_Line], samples: Array, units: tuple[str, str]) -> None:
    psi, z = samples.T
    if len(psi) < 4:
        raise DesignError(f"{len(psi)} samples: allowed are 4 or more")
    for column, name, values, bad, allowed in (
        (1, "psi", psi, np.diff(psi) <= 0.0, "more than"),
        (2, "z", z, np.diff(z) < 0.0, "at least"),
    ):
        if bad.any():
            k, unit = int(np.argmax(bad)), units[column - 1]
            raise DesignError(
                f"line {lines[k + 1].number}, column {column}: {name} = {values[k + 1]:.9g} {unit}: allowed"
                f" is {allowed} {values[k]:.9g} {unit}, the value of line {lines[k].number}"
            )
    if not psi[0] <= 0.0 <= psi[-1]:
        raise DesignError(
            f"psi goes from {psi[0]:.9g} to {psi[-1]:.9g} {units[0]}: psi = 0 must be among them,"
            " where the pin is at theta = 0"
        )
