"""A finding of the check with what can help, and the values of keys."""

from dataclasses import dataclass, replace
from typing import Any

from dualcam.design_file import DesignFile, Finding
from dualcam.design_file.findings import ERROR
from dualcam.fmi.variables import all_parameters

TABLES = ("pin", "roller", "helical_spring", "limits")  # of the design file, each an object


@dataclass(frozen=True)
class Remedy:
    """A key whose value, moved towards `bound`, can make a finding disappear."""

    key: str
    bound: float


@dataclass(frozen=True)
class Trouble:
    """A finding, and what can help, the first remedy first; `hint` is a further sentence."""

    finding: Finding
    remedies: tuple[Remedy, ...] = ()
    hint: str = ""


def trouble(
    design: DesignFile, kind: str, key: str, text: str, severity: str = ERROR, *mend: Remedy, hint: str = ""
) -> Trouble:
    """A finding about the value of a key, with what can help."""
    value = value_of(design, key) if key else None
    return Trouble(Finding(severity, key, value, text, kind=kind), mend, hint)


def value_of(design: DesignFile, key: str) -> Any:  # noqa: ANN401
    """The value of a parameter, or of a key of the TABLES; None for another key."""
    table, _, name = key.partition(".")
    if table in TABLES:
        return getattr(getattr(design, table), name, None)
    return design.value(key) if key in all_parameters() else None


def with_value(design: DesignFile, key: str, value: float) -> DesignFile:
    """The design with another value of a parameter or of the pin."""
    table, _, name = key.partition(".")
    if table == "pin" and design.pin is not None:
        pin = replace(design.pin, **{name: value})
        roller = replace(design.roller, radius=pin.radius) if design.roller else None
        return replace(design, pin=pin, roller=roller)
    return replace(design, parameters=design.parameters | {key: value})


def shown_beside(value: float, limit: float, digits: int = 3) -> str:
    """A value with so many digits that it does not look like the limit that it misses."""
    while digits < 17 and float(f"{value:.{digits}g}") == float(f"{limit:.{digits}g}") and value != limit:
        digits += 1
    return f"{value:.{digits}g}"
