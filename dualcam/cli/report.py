"""`dualcam report`: one HTML page about a design."""

from pathlib import Path

import click

from dualcam.cli.options import anyway, as_json, design_file, example, open_design, output_file
from dualcam.cli.output import print_json, require_folder_of, say_written


@click.command(epilog=example("dualcam report my.toml -o my_report.html"))
@design_file
@output_file("Name of the page (.html).")
@anyway
@as_json
def command(design_file: Path, output: Path, anyway: bool, as_json: bool) -> None:
    """Write one HTML page: findings, torque and reactions over the angle, simulation, energy balance.

    The page holds its pictures and needs no network.
    """
    from dualcam.report.page import write_report

    require_folder_of(output)
    written = write_report(open_design(design_file, anyway, as_json), output)
    if as_json:
        print_json({"report": written})
        return
    say_written(written)
