"""One value of a design by its key, read and replaced."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from dualcam.design_file import DesignFile
from dualcam.variables import all_parameters


def value_of(design: DesignFile, key: str) -> Any:  # noqa: ANN401
    """The value of a parameter or of the pin; None for another key."""
    table, _, name = key.partition(".")
    if table == "pin":
        return getattr(design.pin, name)
    return design.value(key) if key in all_parameters() else None


def with_value(design: DesignFile, key: str, value: float) -> DesignFile:
    """The design with another value of a parameter or of the pin."""
    table, _, name = key.partition(".")
    if table == "pin" and design.pin is not None:
        return replace(design, pin=replace(design.pin, **{name: value}))
    return replace(design, parameters=design.parameters | {key: value})
