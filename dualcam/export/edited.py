"""Start values in a modelDescription.xml that are not those in the binary, from which the FMU starts."""

from __future__ import annotations

from pathlib import Path

from dualcam.errors import DualcamError
from dualcam.export.start_block import StartValues, read_start_values
from dualcam.fmi.model_description import ModelDescription, Variable
from dualcam.fmi.platforms import own_binary


def edited_start_values(path: Path, description: ModelDescription) -> list[str]:
    """One sentence for each start value in the XML that is not that of the binary for this machine."""
    try:
        binary = own_binary(path, description)
        block = None if binary is None else read_start_values(binary)
        return [] if block is None else _differences(description, block)
    except (DualcamError, IndexError) as error:
        return [f"the start values in the binary cannot be read: {error}"]


def _differences(description: ModelDescription, block: StartValues) -> list[str]:
    return [
        f"{variable.name}: modelDescription.xml says {variable.start!r}, but the FMU starts from"
        f" {_in_words(variable, used)}, the value in its binary: change the design file and export again"
        for variable in description.variables
        if variable.start is not None
        and (used := block.value(variable.value_reference, variable.kind == "string")) != variable.start
    ]


def _in_words(variable: Variable, value: float | str) -> str:
    """The value by the variable's type."""
    if isinstance(value, str) or variable.kind == "real":
        return repr(value)
    return repr(bool(value) if variable.kind == "boolean" else int(value))
