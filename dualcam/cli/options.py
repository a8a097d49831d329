"""Arguments and options that several commands have."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile

Command = TypeVar("Command", bound=Callable[..., Any])

FILE = click.Path(path_type=Path)  # each reader has its own message for a missing file

design_file = click.argument("design_file", type=FILE, metavar="DESIGN.toml")
as_json = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON, for programs.")
fmi_version = click.option(
    "--fmi", type=click.Choice(["2", "3"]), default="2", show_default=True, help="Version of FMI."
)


def output_file(what: str, required: bool = True) -> Callable[[Command], Command]:
    """The option -o of a command that writes a file."""
    return click.option("-o", "--output", type=FILE, required=required, help=what)


def open_design(path: Path) -> DesignFile:
    """The design of a file. Its warnings, such as a value that looks like another unit, go to stderr."""
    from dualcam.design_file import read_design

    design = read_design(path)
    for warning in design.warnings:
        click.echo(f"dualcam: warning: {path}: {warning}", err=True)
    return design


@contextmanager
def refusals_explained(design: DesignFile | None) -> Iterator[None]:
    """DesignFileError with the errors of `dualcam check` where the FMU refuses the design. None is the
    default mechanism, which the check does not know."""
    from dualcam.errors import FmuError

    try:
        yield
    except FmuError as error:
        from dualcam.checking import check_design
        from dualcam.design_file import DesignFileError

        errors = () if design is None else check_design(design).errors
        if design is None or not errors:
            raise
        raise DesignFileError(design.path, errors) from error


def example(*lines: str) -> str:
    """The end of a command's help: lines to copy."""
    return "\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)
