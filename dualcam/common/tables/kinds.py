"""What a table is for: the quantities of its columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from dualcam.errors import DualcamError

# Names of columns in small letters
ANGLE_NAMES = ("theta", "psi", "angle", "position", "winkel")
TORQUE_NAMES = ("tau", "torque", "moment", "drehmoment")


@dataclass(frozen=True)
class ColumnKind:
    """One column of a table.

    Attributes
    ----------
    kind : str
        Key of `units.UNITS`, such as "angle".
    words : tuple of str
        Names of the column in headers, in small letters.
    needed : bool
        Whether a table without the column is refused.
    order : str
        "rises": each value is above the one before. "never falls": or equal to it. "": any order.
    bare_name : str
        The name that needs no unit: its values are in the SI unit. "" for none; a ratio never needs a unit.
    rule : str
        Rule of `unit_guards.RULES` for values in the SI unit; "" for none.
    """

    kind: str
    words: tuple[str, ...]
    needed: bool = True
    order: str = ""
    bare_name: str = ""
    rule: str = ""


@dataclass(frozen=True)
class TableKind:
    """What a table is for.

    Attributes
    ----------
    what : str
        The file in messages, such as "groove table".
    quantities : mapping of str to ColumnKind
        Columns by name.
    example : str
        A good header.
    error : type of DualcamError
        What is raised for a file that cannot be understood.
    least, most : int
        Numbers of rows; `most` = 0 for any.
    units : mapping of str to str
        Units that the caller gives, by quantity: they count more than the header.
    """

    what: str
    quantities: Mapping[str, ColumnKind]
    example: str
    error: type[DualcamError]
    least: int = 1
    most: int = 0
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def needs_header(self) -> bool:
        """Whether the caller leaves units open, which the header must then give."""
        return set(self.units) != set(self.quantities)
