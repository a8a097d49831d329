"""Sections of a design file that another room owns. That room uses designs, and so lies above this one: it is
named here, and loaded where a file has its section."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dualcam.design_file.design import DesignFile

OWNERS = {"study": "dualcam.study.section"}  # key of the file -> module with a function check_section


def check_section(key: str, design: DesignFile) -> None:
    """An error of the owner, with all mistakes of the section."""
    import_module(OWNERS[key]).check_section(design)
