"""What a table is for: the quantities of its columns."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from dualcam.errors import DualcamError

# Names of columns in small letters
ANGLE_NAMES = ("theta", "psi", "angle", "position", "winkel")
TORQUE_NAMES = ("tau", "torque", "moment", "drehmoment")
GROOVE_HEADER = "psi_rad,z_m"
FRICTION_HEADERS = ("v_m_s,mu", "v_m_s,R_N,mu")
PLAIN = r"[ \t\r]*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?[ \t\r]*"


class TableError(DualcamError):
    """A table cannot be understood; the message names line, column and what is allowed."""


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
