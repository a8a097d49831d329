"""`dualcam check`: does this design work?"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dualcam.cli.options import as_json, design_file, example
from dualcam.cli.output import MARKS, count, print_json, say

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
        _tell(verdict, design_file, design.friction_note())
    return 0 if verdict.good else 1


def _tell(verdict: Verdict, file: Path, friction_note: str) -> None:
    for note in verdict.notes:
        say(f"- {note}")
    tell_findings(verdict)
    if verdict.numbers is not None:
        for line in verdict.numbers.lines():
            say(f"  {line}")
        if friction_note:
            say(f"  {friction_note}")
    say(f"{file}: {_conclusion(verdict)}")


def tell_findings(verdict: Verdict) -> None:
    """One line for each finding, after a line about the units that may be the cause of errors."""
    if verdict.strange_units and verdict.errors:
        say(f"Check the units first: {_units(verdict)}. The errors below can come from there.")
    for finding in verdict.findings:
        say(f"{MARKS[finding.severity]} {finding.severity}: {finding}")


def _conclusion(verdict: Verdict) -> str:
    warnings = len(verdict.warnings)
    if verdict.good and verdict.strange_units:
        return f"the FMU starts, but {_units(verdict)}: see the warnings."
    if verdict.good:
        more = f", {count(warnings, 'warning')}" if warnings else ""
        return f"the design works, the FMU starts{more}."
    starts = "starts" if verdict.starts else "does not start"
    return f"the design does not work, {count(len(verdict.errors), 'error')}. The FMU {starts}."


def _units(verdict: Verdict) -> str:
    strange = len(verdict.strange_units)
    return "1 value looks like another unit" if strange == 1 else f"{strange} values look like other units"
