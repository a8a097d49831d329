"""Numbers in plans: numbers in the FMU's units, or texts with a unit such as "40 deg"."""

from __future__ import annotations

from collections.abc import Mapping

from dualcam.common.mistakes import StudyError
from dualcam.errors import DesignError

Units = Mapping[str, str | None]  # unit by variable, "1" for a plain number; None: no real
STRING = "String"  # in place of the unit of a String


def number(where: str, name: str, value: float | str, units: Units) -> float:
    """A number, or the number of a text with a unit, in the unit of the variable.

    `where` begins the message of the StudyError for a text that is no such quantity."""
    if not isinstance(value, str):
        return float(value)
    if name not in units:  # a number for formulas
        return in_si(where, value)
    unit = units[name]
    if unit is None or unit == STRING:
        raise StudyError(f"{where} = {value!r}: {name} is no real variable: allowed is a number without unit")
    return in_unit(where, value, unit)


def in_si(where: str, text: str) -> float:
    """The number of a text in the base unit of the SI. `where` begins the message of the StudyError."""
    from dualcam.common.written_units import si_number

    try:
        return si_number(text)
    except DesignError as error:
        raise StudyError(f"{where} = {text!r}: {error}") from None


def in_unit(where: str, text: str, unit: str) -> float:
    """The number of a text in a unit. `where` begins the message of the StudyError."""
    from dualcam.common.written_units import quantity  # loads pydantic and pint, which few plans need

    try:
        return quantity(text, unit)
    except DesignError as error:
        raise StudyError(f"{where} = {text!r}: {error}") from None
    except Exception:  # pint has many, for units of FMUs of others
        raise StudyError(
            f"{where} = {text!r}: texts cannot be converted to the FMU's unit {unit!r}: allowed is a number"
        ) from None


def unit_in(value: object) -> str:
    """The unit that a text has; none of a number."""
    from dualcam.common.written_units import written_unit

    return written_unit(value) if isinstance(value, str) else ""


def are_of_one_kind(one: str, other: str) -> bool:
    """Whether numbers in one unit can be converted to the other; not where a unit is not known."""
    from dualcam.common.written_units import quantity

    try:
        quantity(f"1 {one}", other)
    except Exception:  # pint has many
        return False
    return True
