"""Design files: one TOML file with the parameters of a design, its scenario, pin, limits and study.

    read_design       the design of a file; DesignFileError lists all errors at once
    DesignFile        parameters in SI units, scenario, mechanism
    as_design         the design of an argument: a DesignFile, or the path of a file
    Finding           one error or warning, with the nearest value that works
    write_template    a commented design to begin with
    json_schema       the schema for editors

docs/design-file.md describes the keys.

May import common, fmi, design, scenario.
"""

from typing import TYPE_CHECKING

from dualcam.common.moved import old_names
from dualcam.design_file.design import DesignFile, SpringLimits
from dualcam.design_file.findings import Finding
from dualcam.design_file.reader import DesignSource, as_design, read_design
from dualcam.design_file.schema import json_schema
from dualcam.design_file.templates import TEMPLATES, write_template

__all__ = [
    "TEMPLATES",
    "DesignFile",
    "DesignSource",
    "Finding",
    "SpringLimits",
    "as_design",
    "json_schema",
    "read_design",
    "write_template",
]

if not TYPE_CHECKING:  # type checkers report the old names
    __getattr__ = old_names(__name__, {"DesignFileError": "errors.DesignFileError"})
