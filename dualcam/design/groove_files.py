"""Files with sampled grooves, as people have them: see docs/tables.md.

What is not given is taken from the header or from the numbers, and said in `notes`. The FMU itself reads
one format only: the header psi_rad,z_m, then lines with a comma between the numbers.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from dualcam.common.paths import path_of
from dualcam.common.tables import ANGLE_NAMES, GROOVE_HEADER, UNITS, ColumnKind, TableKind, read_table
from dualcam.design.statics import Array
from dualcam.errors import DesignError

DELIMITERS = (";", ",", " ", "\t")
GROOVE = TableKind(
    what="groove table",
    quantities={
        "psi": ColumnKind("angle", ANGLE_NAMES, order="rises"),
        "z": ColumnKind("length", ("z", "height", "lift", "hub"), order="never falls"),
    },
    example=f"psi_deg,z_mm (degrees and millimetres) or {GROOVE_HEADER} (radians and metres)",
    error=DesignError,
    least=4,
    most=100_000,  # as for the FMU
)


@dataclass(frozen=True, eq=False)
class GrooveFile:
    """The samples of a file in SI units, and how the file was understood."""

    psi: Array  # angle of the pin along the groove [rad], shape (n,)
    z: Array  # height of the pin [m], shape (n,)
    units: tuple[str, str]  # units in the file, such as ("deg", "mm")
    notes: tuple[str, ...]  # what was guessed, in words
    is_fmu_format: bool  # whether the FMU can read the file as it is


def read_groove(
    path: str | Path,
    units: Sequence[str] | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
) -> GrooveFile:
    """Read a file with columns of angle and height. The parameters are those of `Table.read`.

    DesignError, with file, line, column and value, for a file that cannot be understood."""
    _check_arguments(units, delimiter, decimal)
    given = {} if units is None else dict(zip(GROOVE.quantities, units, strict=True))
    path = path_of(path, "the groove table")
    table = read_table(path, replace(GROOVE, units=given), delimiter, decimal)
    psi, z, found = table.columns["psi"], table.columns["z"], (table.units["psi"], table.units["z"])
    if not psi[0] <= 0.0 <= psi[-1]:
        raise DesignError(
            f"{path}: psi goes from {psi[0]:.9g} to {psi[-1]:.9g} rad: psi = 0 must be among them, where the"
            " pin is at theta = 0"
        )
    said = [] if given or found == ("rad", "m") else [f"the header says {found[0]} and {found[1]}"]
    is_fmu_format = found == ("rad", "m") and table.is_for_the_fmu([GROOVE_HEADER])
    return GrooveFile(psi, z, found, (*table.notes, *said), is_fmu_format)


def _check_arguments(units: Sequence[str] | None, delimiter: str | None, decimal: str | None) -> None:
    angles, lengths = UNITS["angle"], UNITS["length"]
    if units is not None and not (
        not isinstance(units, str) and len(units) == 2 and units[0] in angles and units[1] in lengths
    ):
        raise DesignError(
            f"units = {units!r}: allowed are an angle ({', '.join(angles)}) and a length"
            f' ({", ".join(lengths)}), such as ("deg", "mm")'
        )
    if delimiter is not None and delimiter not in DELIMITERS:
        raise DesignError(f"delimiter = {delimiter!r}: allowed are ';', ',', ' ' and a tab")
    if decimal not in (None, ".", ","):
        raise DesignError(f"decimal = {decimal!r}: allowed are '.' and ','")
    if decimal == "," and delimiter == ",":
        raise DesignError("delimiter and decimal are both a comma: allowed is one of them")
