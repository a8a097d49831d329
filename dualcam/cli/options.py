"""Arguments and options that several commands have."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from dualcam.cli.output import count, warn
from dualcam.errors import DesignFileError

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile

Command = TypeVar("Command", bound=Callable[..., Any])

FILE = click.Path(path_type=Path)  # each reader has its own message for a missing file

design_file = click.argument("design_file", type=FILE, metavar="DESIGN.toml")
anyway = click.option(
    "--anyway", is_flag=True, help="Go on with a design that `dualcam check` refuses, and say so first."
)
as_json = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON, for programs.")
fmi_version = click.option(
    "--fmi", type=click.Choice(["2", "3"]), default="2", show_default=True, help="Version of FMI."
)


def output_file(what: str, required: bool = True) -> Callable[[Command], Command]:
    """The option -o of a command that writes a file."""
    return click.option("-o", "--output", type=FILE, required=required, help=what)


def open_design(path: Path, anyway: bool, as_json: bool = False) -> DesignFile:
    """The design of a file, judged by `judge`."""
    from dualcam.design_file import read_design

    design = read_design(path)
    judge(design, anyway, as_json)
    return design


def judge(design: DesignFile, anyway: bool, as_json: bool = False) -> None:
    """DesignFileError with the errors of `dualcam check`; `anyway` prints them, beside JSON on stderr."""
    from dualcam.checking import check_design

    verdict = check_design(design)
    for finding in verdict.warnings:
        warn(f"{design.path}: {finding}")
    if verdict.good:
        return
    if not anyway:
        only = "" if verdict.starts else " in commands that do not start the FMU, such as band and report"
        raise DesignFileError(design.path, verdict.errors, f"--anyway goes on with this design{only}")
    head = f"{design.path}: {count(len(verdict.errors), 'error')}; --anyway goes on"
    click.echo("\n".join([head, *(f"  {finding}" for finding in verdict.errors)]), err=as_json)


def example(*lines: str) -> str:
    """The end of a command's help: lines to copy."""
    return "\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)
