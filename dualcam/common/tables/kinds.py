"""What a table is for: the quantities of its columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from dualcam.errors import DualcamError

# Names of columns in small letters
ANGLE_NAMES = ("theta", "psi", "angle", "position", "winkel")
TORQUE_NAMES = ("tau", "torque", "moment", "drehmoment")


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
