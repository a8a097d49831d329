"""`dualcam export`: an FMU of a design, with its own name and start values."""

from dataclasses import replace
from pathlib import Path

import click

from dualcam.cli.options import anyway, as_json, design_file, example, fmi_version, judge, output_file
from dualcam.cli.output import print_json, require_folder_of, say, say_where_it_runs


@click.command(
    epilog=example("dualcam export my.toml -o MyCam.fmu", "dualcam export my.toml -o MyCam.fmu --fmi 3")
)
@design_file
@output_file("Name of the FMU. The model gets the same name.")
@fmi_version
@click.option(
    "--model",
    type=click.Choice(["forward", "inverse"]),
    help="forward: torque in, motion out. inverse: motion in, torque out. Default: as the scenario says.",
)
@anyway
@as_json
def command(
    design_file: Path, output: Path, fmi: str, model: str | None, anyway: bool, as_json: bool
) -> None:
    """Make an FMU whose start values are those of the design.

    The FMU holds binaries, the groove tables, the scenario as a file of inputs, a documentation page and the
    C sources. The binaries are for Linux, Windows and macOS if dualcam comes from the wheel or after
    `./build.sh run all`; after `./build.sh` they are for this machine's system alone, and the command says
    so. No compiler is needed. Start values edited in a
    modelDescription.xml do nothing by themselves: the binaries hold the start values. Change the design file
    and export again.
    """
    from dualcam.design_file import read_design
    from dualcam.export import export_fmu
    from dualcam.export.scenario import FILE, scenario_for
    from dualcam.fmi.binary import folders_of

    require_folder_of(output)
    design = read_design(design_file)
    judge(replace(design, model=model or design.model), anyway, as_json)
    written = export_fmu(design, output, int(fmi), model)
    size = written.stat().st_size
    if as_json:
        facts = {"fmu": written, "fmi": int(fmi), "model": model or design.model, "bytes": size}
        print_json({**facts, "platforms": folders_of(written)})
        return
    say(f"{written} written: FMI {fmi}.0, {model or design.model} dynamics, {size / 1e6:.0f} MB")
    say_where_it_runs(written)
    if scenario_for(design.scenario, model or design.model):
        say(f"{FILE} in the FMU holds the scenario; documentation/index.html shows how to play the scenario")
