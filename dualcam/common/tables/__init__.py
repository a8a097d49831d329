"""The one reader of tables that people write: recordings, torques, grooves, friction and runs of studies.

docs/tables.md says what the reader takes.

TableKind, ColumnKind     what a table is for: its columns, their names, units and order
read_table              columns of such a table in SI units, from a file
read_columns            columns by the names in the header, as plans of studies have them
fmu_text, is_fmu_text   the one format that the FMU reads
"""

from dualcam.common.tables.reader import Converter, HumanTable, read_columns, read_table
from dualcam.common.tables.units import (
    ANGLE_NAMES,
    FRICTION_HEADERS,
    GROOVE_HEADER,
    TORQUE_NAMES,
    UNITS,
    ColumnKind,
    TableKind,
    fmu_text,
    in_unit,
    is_fmu_text,
)
from dualcam.errors import TableError

__all__ = [
    "ANGLE_NAMES", "FRICTION_HEADERS", "GROOVE_HEADER", "TORQUE_NAMES", "UNITS", "ColumnKind", "Converter",
    "HumanTable", "TableError", "TableKind", "fmu_text", "in_unit", "is_fmu_text", "read_columns",
    "read_table",
]  # fmt: skip
