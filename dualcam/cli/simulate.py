"""`dualcam simulate`: the scenario of a design file over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dualcam.cli.options import FILE, anyway, as_json, design_file, example, open_design, output_file
from dualcam.cli.output import (
    keep_files_of,
    keep_other_tables,
    print_json,
    require_folder_of,
    say,
    say_written,
)
from dualcam.errors import DualcamError

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile
    from dualcam.simulation.run import Trajectory

AT_END = {"theta": "rad", "omega": "rad/s", "tau": "N.m"}
SHOWN_FROM = 200_000  # samples from which a bar shows the progress


@click.command(epilog=example("dualcam simulate my.toml -o out.csv --plot out.png"))
@design_file
@output_file("Table of all samples (.csv or .parquet).")
@click.option("--plot", type=FILE, help="Picture of the run (.png, .svg or .pdf).")
@click.option(
    "--variables", default="", metavar="A,B,...", help="Variables to record. Default: the important ones."
)
@click.option("--fmu", type=FILE, help="Another FMU, such as an exported one. Default: that of this package.")
@anyway
@as_json
def command(
    design_file: Path,
    output: Path,
    plot: Path | None,
    variables: str,
    fmu: Path | None,
    anyway: bool,
    as_json: bool,
) -> None:
    """Run the scenario of a design file and write all samples.

    The file's [scenario] says how long, and which torque (or which motion) acts.
    """
    from dualcam.report.summary import residual_words
    from dualcam.simulation.run import VARIABLES, checked_format

    checked_format(output)
    require_folder_of(output, plot)
    design = open_design(design_file, anyway, as_json)
    keep_files_of(design, output, plot)
    names = [name.strip() for name in variables.split(",") if name.strip()]
    keep_other_tables(output, *(",".join(["time", *columns]) for columns in (names, *VARIABLES.values())))
    if plot is not None:
        _check_plot(plot, names)
    trajectory = _run(design, names, fmu, as_json)
    trajectory.write(output)
    if plot is not None:
        _draw(design, trajectory, plot)
    last = dict(zip(trajectory.names, trajectory.values[-1].tolist(), strict=True))
    if as_json:
        print_json({"output": output, "plot": plot, "samples": len(trajectory.values), "last": last})
        return
    say(f"{output} written: {len(trajectory.values):,} samples of {len(trajectory.names)} columns")
    say_written(plot)
    at_end = [f"{name} = {last[name]:.5g} {unit}" for name, unit in AT_END.items() if name in last]
    if "energy.residual" in last:
        at_end.append(f"residual of the energy balance {residual_words(trajectory)}")
    say(f"at {last['time']:g} s: {', '.join(at_end)}" if at_end else f"end at {last['time']:g} s")


def _run(design: DesignFile, names: list[str], fmu: Path | None, quiet: bool) -> Trajectory:
    from dualcam.design_file.design import sample_times
    from dualcam.simulation.run import simulate

    scenario = design.scenario
    samples = 0 if scenario is None else len(sample_times(scenario.stop, design.output_interval))
    if quiet or samples < SHOWN_FROM:
        return simulate(design, names, fmu=fmu)
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task("simulate", total=1.0)
        return simulate(design, names, fmu=fmu, progress=lambda share: progress.update(task, completed=share))


def _check_plot(path: Path, names: list[str]) -> None:
    """DualcamError, before the run, for a picture that cannot be drawn or written."""
    from dualcam.common.paths import check_picture

    check_picture(path)
    missing = [name for name in ("theta", "tau") if names and name not in names]
    if missing:
        text = f"--plot needs the variables theta and tau: add {', '.join(missing)} to --variables"
        raise DualcamError(text)


def _draw(design: DesignFile, trajectory: Trajectory, path: Path) -> None:
    from dualcam.design import torque_band
    from dualcam.plots.design import plot_simulation, save

    band = torque_band(design.mechanism(), 361)
    save(plot_simulation(trajectory, band, design.title or design.name), path)
