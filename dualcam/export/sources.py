"""The C sources in an exported FMU: they compile to a library with the same name, GUID and start values."""

from __future__ import annotations

import re
from collections.abc import Mapping

from dualcam.errors import ExportError
from dualcam.export.description import AGAIN
from dualcam.fmi.model_description import Scalar

FOLDER = "sources/"
VARIABLES = FOLDER + "variables.def"
NAMED = (FOLDER + "identity.h", FOLDER + "buildDescription.xml")  # these files name the model


def exported_sources(
    members: Mapping[str, bytes], names: Mapping[str, str], start: Mapping[str, Scalar]
) -> dict[str, bytes]:
    """The members below sources/ with other names and start values."""
    found = {name: content for name, content in members.items() if name.startswith(FOLDER)}
    for name in NAMED:
        if name in found:
            text = found[name].decode()
            for old, new in names.items():
                text = text.replace(old, new)
            found[name] = text.encode()
    found[VARIABLES] = _with_start_values(found[VARIABLES].decode(), start).encode()
    return found


def _with_start_values(rows: str, start: Mapping[str, Scalar]) -> str:
    """variables.def with other values in the column `start`, which is the fourth one after the name."""
    for name, value in start.items():
        row = rf'("{re.escape(name)}",\s*(?:PARAMETER|INPUT),\s*\w+,\s*\w+,\s*)("[^"]*"|[^,"]+)(?=,)'
        match = re.search(row, rows)
        if match is None:
            raise ExportError(f"{VARIABLES} without a row of {name}: {AGAIN}")
        rows = rows[: match.start(2)] + _literal(value) + rows[match.end(2) :]
    return rows


def _literal(value: Scalar) -> str:
    """A constant in C."""
    if isinstance(value, str):
        return f'"{value}"'
    return str(int(value)) if isinstance(value, bool) else repr(value)
