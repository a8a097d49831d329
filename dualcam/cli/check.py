"""`dualcam check`: does this design work?"""

from __future__ import annotations

from pathlib import Path

import click

from dualcam.cli.options import as_json, design_file, example
from dualcam.cli.output import MARKS, print_json, say


@click.command(epilog=example("dualcam check my.toml", "dualcam check my.toml --json"))
@design_file
@as_json
def command(design_file: Path, as_json: bool) -> int:
    """Say whether a design works.

    The check looks at units, limits, grooves, friction, spring and strength. Then the check starts the FMU.
    The exit code is 0 if the design works, else 1. Warnings do not change the exit code.
    """
    from dualcam.check import check_design
    from dualcam.design_file import read_design

    design = read_design(design_file)
    verdict = check_design(design)
    if as_json:
        print_json(verdict.to_dict() | {"file": str(design_file)})
    else:
        for finding in verdict.findings:
            say(f"{MARKS.get(finding.severity, '-')} {finding.severity}: {finding.text}")
        errors = sum(finding.severity == "error" for finding in verdict.findings)
        say(
            f"{design_file}: the design works, the FMU starts."
            if verdict.good
            else f"{design_file}: the design does not work, {errors} error{'s' if errors > 1 else ''}."
        )
    return 0 if verdict.good else 1
