"""What tables are for: their quantities, and units as people write them, with their factors to SI."""

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import Array
from dualcam.common.unit_guards import TORQUE_UNITS
from dualcam.errors import DualcamError

DEGREE = math.pi / 180.0  # rad
# By kind: the units with their factors to SI, the SI unit first.
UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "angle": {"rad": 1.0, "deg": DEGREE, "mrad": 1e-3, "turn": 2.0 * math.pi, "gon": math.pi / 200.0},
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 0.0254},
    "torque": TORQUE_UNITS,
    "force": {"N": 1.0, "kN": 1e3},
    "angular velocity": {"rad/s": 1.0, "deg/s": DEGREE, "rpm": 2.0 * math.pi / 60.0},
    "velocity": {"m/s": 1.0, "mm/s": 1e-3},
    "ratio": {"1": 1.0, "%": 1e-2},
}
TIMES = r"[\s.·⋅*_-]*"  # between the factors of a product
PER = r"\s*(?:/|_|\bper\b)\s*"
SECOND = r"(?:s|sec|seconds?)"
DEGREES = r"(?:deg|degrees?|°|º|grad|grados?|gradi|degr[ée]s?)"  # Grad are degrees in German
RADIANS = r"(?:rad|radians?|radiant)"
METRE = r"met(?:re|er)s?"
SPELLINGS = {
    "s": r"s|secs?|seconds?|sekunden?",
    "ms": r"ms|msec|milliseconds?|millisekunden?",
    "us": r"[uµμ]s|microseconds?",
    "min": r"min|minutes?|minuten?",
    "rad": RADIANS,
    "deg": DEGREES,
    "mrad": r"mrad|milliradians?",
    "gon": r"gon",
    "turn": r"turns?|revolutions?|umdrehung(?:en)?",
    "m": rf"m|{METRE}",
    "mm": rf"mm|milli{METRE}",
    "cm": rf"cm|centi{METRE}|zenti{METRE}",
    "um": rf"[uµμ]m|micro{METRE}|mikro{METRE}",
    "in": r"in|inch(?:es)?",
    "N.m": rf"N{TIMES}m|newton{TIMES}{METRE}",
    "N.mm": rf"N{TIMES}mm|newton{TIMES}milli{METRE}",
    "N.cm": rf"N{TIMES}cm|newton{TIMES}(?:c|z)enti{METRE}",
    "mN.m": rf"mN{TIMES}m|millinewton{TIMES}{METRE}",
    "kN.m": rf"kN{TIMES}m|kilonewton{TIMES}{METRE}",
    "N": r"N|newtons?",
    "kN": r"kN|kilonewtons?",
    "rad/s": rf"{RADIANS}(?:{PER}|\s+){SECOND}",
    "deg/s": rf"{DEGREES}(?:{PER}|\s+){SECOND}",
    "rpm": rf"rpm|(?:1|u|rev){PER}min",
    "m/s": rf"(?:m|{METRE}){PER}{SECOND}",
    "mm/s": rf"(?:mm|milli{METRE}){PER}{SECOND}",
    "1": r"1|-",
    "%": r"%|percent|prozent",
}
MEGA = re.compile(r"MN")  # capitals are as good as small letters but here: MN.m is no mN.m
KINDS = {unit: kind for kind, units in UNITS.items() for unit in units}
BRACKETS = re.compile(r"[\[({]\s*([^\])}]*?)\s*[\])}]")
JOINT = re.compile(r"(?:[\s_/,:.]|\bin)+$", re.IGNORECASE)  # between name and unit
# Names of columns in small letters
ANGLE_NAMES = ("theta", "psi", "angle", "position", "winkel")
TORQUE_NAMES = ("tau", "torque", "moment", "drehmoment")
GROOVE_HEADER = "psi_rad,z_m"
FRICTION_HEADERS = ("v_m_s,mu", "v_m_s,R_N,mu")
PLAIN = r"[ \t\r]*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?[ \t\r]*"


class Head(NamedTuple):
    """The head of a column."""

    text: str
    name: str  # in small letters, without unit
    unit: str  # key of KINDS; "" for none that is known
    unknown: str  # what stands in brackets, where that is no known unit


@cache
def known_unit(text: str) -> str:
    """The unit that a text is; "" for none."""
    if MEGA.match(text):
        return ""
    return next((unit for unit, words in SPELLINGS.items() if re.fullmatch(words, text, re.IGNORECASE)), "")


@cache
def head_of(text: str) -> Head:
    """Name and unit of a column, such as of `t [ms]`, `torque_Ncm` or `Winkel in Grad`."""
    bracketed = [found for found in BRACKETS.findall(text) if found]
    unit = next(filter(None, map(known_unit, bracketed)), "")
    name = BRACKETS.sub("", text).strip()
    last = _last_unit(name)
    if last and unit in ("", known_unit(last["unit"])):
        name, unit = name[: last.start()], known_unit(last["unit"])
    unknown = bracketed[0] if bracketed and not unit else ""
    return Head(text, JOINT.sub("", name).strip().lower(), unit, unknown)


def _last_unit(text: str) -> re.Match[str] | None:
    """The longest unit at the end of a text."""
    found = (
        re.search(rf"(?:^|[\s_/,:.])(?P<unit>{words})$", text, re.IGNORECASE)
        for unit, words in SPELLINGS.items()
        if unit != "1"
    )
    good = [match for match in found if match and not MEGA.match(match["unit"])]
    return max(good, key=lambda match: len(match["unit"]), default=None)


def in_unit(values: Array, factor: float) -> Array:
    """Values times a factor, rounded once where the factor is a short decimal: 4.1 mm is 0.0041 m exactly."""
    exact = Decimal(repr(factor)).normalize()
    digits, exponent = exact.as_tuple()[1:]
    if factor == 1.0 or len(digits) > 3:
        return values * factor
    whole = int(exact.scaleb(-int(exponent)))
    with np.errstate(over="ignore"):
        billionths = np.rint(values * 1e9)
    are_short = (billionths / 1e9 == values).all() and np.abs(billionths).max(initial=0.0) * whole < 1e15
    if are_short:  # all numbers here are whole, but for the last division
        return billionths * whole / 10.0 ** (9 - int(exponent))
    return np.array([float(Decimal(repr(value)) * exact) for value in values.tolist()])


@dataclass(frozen=True)
class ColumnKind:
    """One column of a table."""

    kind: str  # key of `units.UNITS`, such as "angle"
    words: tuple[str, ...]  # names of the column in headers, in small letters
    needed: bool = True  # a table without the column is refused
    order: str = ""  # "rises", "never falls", or "" for any
    bare_name: str = ""  # a name whose values are in the SI unit without a unit; "" for none
    rule: str = ""  # key of `unit_guards.RULES` for values in the SI unit; "" for none


@dataclass(frozen=True)
class TableKind:
    """What a table is for."""

    what: str  # the file in messages, such as "groove table"
    quantities: Mapping[str, ColumnKind]
    example: str  # a good header
    error: type[DualcamError]  # raised for a file that cannot be understood
    least: int = 1  # number of rows
    most: int = 0  # 0: any number
    units: Mapping[str, str] = field(default_factory=dict)  # of the caller, before the header

    @property
    def needs_header(self) -> bool:
        """Whether the caller leaves units open, which the header must then give."""
        return set(self.units) != set(self.quantities)


def fmu_text(header: str, *columns: ArrayLike) -> str:
    """The text of a table for the FMU, with all digits. `columns`: of shape (n,), in SI units."""
    rows = zip(*(np.asarray(column, dtype=float).tolist() for column in columns), strict=True)
    return "".join([f"{header}\n", *(f"{','.join(map(repr, row))}\n" for row in rows)])


def is_fmu_text(text: str, headers: Collection[str]) -> bool:
    """Whether the FMU reads this text, which was in UTF-8, as it is."""
    first, *rows = text.removeprefix("\ufeff").rstrip(" \t\r\n").split("\n")
    header = first.strip(" \t\r")
    row = re.compile(",".join([PLAIN] * (header.count(",") + 1)), re.ASCII)
    return header in headers and all(map(row.fullmatch, rows))
