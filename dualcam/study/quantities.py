"""Numbers in plans: numbers in the FMU's units, or texts with a unit such as "40 deg"."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from dualcam.errors import DesignError
from dualcam.library import source_path
from dualcam.model_description import Scalar, read_model_description
from dualcam.study.problem import StudyError

Units = Callable[[], Mapping[str, str | None]]  # unit by variable, "1" for a plain number; None: no real
STRING = "String"  # in place of the unit of a String


def units_of_designs() -> Mapping[str, str | None]:
    """Of the parameters and inputs that a design file can have."""
    from dualcam.variables import all_inputs, all_parameters

    known = {**all_parameters(), **all_inputs()}
    others: dict[type, str] = {str: STRING}
    return {
        name: variable.unit if variable.kind is float else others.get(variable.kind)
        for name, variable in known.items()
    }


def units_of_fmu(fmu: str | Path) -> Units:
    """Of all variables of an FMU, which is read when the units are asked for."""

    def units() -> Mapping[str, str | None]:
        known = read_model_description(source_path(fmu)).variables
        others = {"string": STRING}
        return {
            each.name: (each.unit or "1") if each.kind == "real" else others.get(each.kind) for each in known
        }

    return units


def number(where: str, name: str, value: float | str, units: Units) -> float:
    """A number, or the number of a text with a unit, in the unit of the variable.

    `where` begins the message of the StudyError for a text that is no such quantity."""
    if not isinstance(value, str):
        return float(value)
    known = units()
    if name not in known:  # a number for formulas
        return in_si(where, value)
    unit = known[name]
    if unit is None or unit == STRING:
        raise StudyError(f"{where} = {value!r}: {name} is no real variable: allowed is a number without unit")
    return in_unit(where, value, unit)


def in_si(where: str, text: str) -> float:
    """The number of a text in the base unit of the SI. `where` begins the message of the StudyError."""
    from dualcam.design_file.units import si_number

    try:
        return si_number(text)
    except DesignError as error:
        raise StudyError(f"{where} = {text!r}: {error}") from None


def in_unit(where: str, text: str, unit: str) -> float:
    """The number of a text in a unit. `where` begins the message of the StudyError."""
    from dualcam.design_file.units import quantity  # loads pydantic and pint, which few plans need

    try:
        return quantity(text, unit)
    except DesignError as error:
        raise StudyError(f"{where} = {text!r}: {error}") from None
    except Exception:  # pint has many, for units of FMUs of others
        raise StudyError(
            f"{where} = {text!r}: texts cannot be converted to the FMU's unit {unit!r}: allowed is a number"
        ) from None


def fixed(parameters: Mapping[str, Scalar], units: Units) -> dict[str, Scalar]:
    """Start values, with the texts of real variables as numbers in the unit of the variable."""
    texts = [name for name, value in parameters.items() if isinstance(value, str)]
    known = units() if texts else {}
    return {
        name: in_unit(f"parameters: {name}", str(value), unit)
        if name in texts and (unit := known.get(name)) not in (None, STRING)
        else value
        for name, value in parameters.items()
    }
