"""`dualcam study`: many runs of an FMU by a plan."""

from pathlib import Path
from typing import Any

import click

from dualcam.cli.options import FILE, anyway, example, open_design

FORMATS = ("parquet", "csv")


PLAN = """fmu = "forward"
  results = ["efficiency", "theta@0.2"]   # at the end, and at 0.2 s
  [plan]
  kind = "grid"
  [plan.vary]
  "cam1.lead_angle" = {from = "35 deg", to = "50 deg", count = 4}
  "cam1.friction" = {values = [0.08, 0.14]}
  [scenario]
  stop = 0.4
  inputs.tau = {time = [0.0, 0.2, 0.4], value = [0.0, 8.0, 0.0]}"""


@click.command(
    epilog=example("dualcam study plan.toml", "dualcam study my.toml   (a design file with [study])")
    + f"\n\n\b\nA small plan.toml (docs/use-studies.md explains all keys):\n  {PLAN}"
)
@click.argument("plans", nargs=-1, required=True, type=FILE, metavar="PLAN.toml...")
@click.option(
    "--out",
    default="study_results",
    show_default=True,
    help="Folder of folders, one per plan; or URL of a store, such as s3://bucket/folder.",
)
@click.option(
    "--workers",
    type=click.IntRange(0),
    help="Processes of this machine; 0: in this one. Default: one per core; 0 if all take less than 2 s.",
)
@click.option("--scheduler", help="Address of a Dask scheduler to be used instead, such as tcp://host:8786.")
@click.option("--format", "file_format", type=click.Choice(FORMATS), help="Of the results.")
@click.option(
    "--figure",
    type=FILE,
    help="Picture of all plots (.png, .svg or .pdf). Default: one per plan, beside the results.",
)
@click.option("--runs-per-file", type=click.IntRange(1), help="Runs in a file of results.")
@anyway
def command(plans: tuple[Path, ...], out: str, anyway: bool, **options: Any) -> None:  # noqa: ANN401
    """Make all runs of a plan and draw the results.

    An interrupted study continues: the same command makes the runs that are missing.
    """
    from rich.console import Console

    from dualcam.study.command import read_all, run
    from dualcam.study.file.study_file import content_of
    from dualcam.study.study import Study

    found = read_all(plans)
    for path, task in found.items():
        if isinstance(task, Study) and "study" in content_of(path):  # an optimisation judges its own designs
            open_design(path, anyway)
    run(found, out, Console(), **options)
