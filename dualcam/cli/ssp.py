"""`dualcam ssp`: an SSP package with the FMU of a design."""

from pathlib import Path

import click

from dualcam.cli.options import anyway, as_json, design_file, example, open_design, output_file
from dualcam.cli.output import print_json, require_folder_of, say, say_where_it_runs


@click.command(epilog=example("dualcam ssp my.toml -o MyCam.ssp"))
@design_file
@output_file("Name of the package (.ssp). The FMU inside gets the same name.")
@click.option(
    "--step",
    type=click.FloatRange(0.0, min_open=True),
    default=1e-3,
    show_default=True,
    help="Communication step in s that the package proposes.",
)
@click.option("--ports", is_flag=True, help="The system gets the ports of the cam.")
@anyway
@as_json
def command(design_file: Path, output: Path, step: float, ports: bool, anyway: bool, as_json: bool) -> None:
    """Make an SSP package (SSP 1.0) with the FMU of a design.

    The package has one component, `cam`, and the parameters of the design as parameter set `start`. The
    torque of the scenario is no part of the package. ecos and libcosim load the package only without
    --ports, FMPy only with --ports.
    """
    from dualcam.fmi.library import fmu_path
    from dualcam.ssp import export_ssp

    require_folder_of(output)
    design = open_design(design_file, anyway, as_json)
    written = export_ssp(design, output, step, ports=ports)
    if as_json:
        print_json({"ssp": written, "step": step})
        return
    say(f"{written} written: component cam, communication step {step:g} s")
    say_where_it_runs(fmu_path(design.model))
