"""The design file that a command reads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile


def open_design(path: Path) -> DesignFile:
    """The design of the file. Its warnings and notes go to the error output."""
    from dualcam.design_file import read_design

    design = read_design(path)
    for note in design.notes:
        click.echo(f"dualcam: {note}", err=True)
    for finding in design.warnings:
        click.echo(f"dualcam: warning: {finding}", err=True)
    return design
