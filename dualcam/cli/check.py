"""`dualcam check`: does this design work?"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dualcam.cli.options import as_json, design_file, example
from dualcam.cli.output import MARKS, print_json, say

if TYPE_CHECKING:
    from dualcam.checking import Verdict


@click.command(epilog=example("dualcam check my.toml", "dualcam check my.toml --json"))
@design_file
@as_json
def command(design_file: Path, as_json: bool) -> int:
    """Say whether a design works.

    The check looks at units, limits, grooves, friction, spring and strength. Then the check starts the FMU.
    The exit code is 0 if the design works, else 1. Warnings do not change the exit code.
    """
    from dualcam.checking import check_design
    from dualcam.design_file import read_design

    design = read_design(design_file)
    verdict = check_design(design)
    if as_json:
        print_json(verdict.to_json() | {"file": str(design_file)})
    else:
        _tell(verdict, design_file)
    return 0 if verdict.good else 1


def _tell(verdict: Verdict, file: Path) -> None:
    for note in verdict.notes:
        say(f"- {note}")
    for finding in verdict.findings:
        say(f"{MARKS[finding.severity]} {finding.severity}: {finding}")
    if verdict.good:
        say(f"{file}: the design works, the FMU starts.")
        return
    count = len(verdict.errors)
    errors = f"{count} error{'s' if count != 1 else ''}"
    starts = "starts" if verdict.starts else "does not start"
    say(f"{file}: the design does not work, {errors}. The FMU {starts}.")
