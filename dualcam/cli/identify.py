"""`dualcam identify`: parameters of a design from a recording."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dualcam.cli.commands import DONE, REFUSED
from dualcam.cli.options import FILE, anyway, as_json, design_file, example, open_design, output_file
from dualcam.cli.output import (
    keep_files_of,
    print_json,
    print_table,
    refusal_for_json,
    refuse_to_overwrite,
    require_folder_of,
    say,
    say_written,
    warn,
)
from dualcam.errors import DualcamError, IdentificationError

if TYPE_CHECKING:
    from dualcam.identification import Identification

SILENT = 5.0  # s without a line of progress
DEFAULT = "friction,spring.preload,spring.stiffness"


@click.command(
    epilog=example(
        "dualcam identify bench.csv my.toml -o fitted.toml --report bench.html",
        "dualcam identify bench.csv my.toml --fit friction,friction_peak,stribeck_velocity,spring.preload",
    )
)
@click.argument("data", type=FILE, metavar="DATA.csv")
@design_file
@click.option(
    "--fit",
    default=DEFAULT,
    show_default=True,
    metavar="A,B,...",
    help="What is fitted: names of parameters; friction, friction_peak and the like for one value of both"
    " cams; torque_offset and angle_offset for the zero errors of the sensors.",
)
@output_file("Design file with the fitted values (.toml).", required=False)
@click.option("--report", type=FILE, help="One HTML page with values, doubts and residuals.")
@click.option("--plot", type=FILE, help="Picture of torque and residuals (.png, .svg or .pdf).")
@click.option(
    "--motion",
    type=click.Choice(["auto", "quasi-static", "dynamic"]),
    default="auto",
    show_default=True,
    help="Whether the acceleration counts. auto: where the acceleration stands out of its noise.",
)
@click.option(
    "--window",
    type=float,
    metavar="SECONDS",
    help="Window in which the angle is smoothed. Default: that of the least error of prediction.",
)
@click.option("--force", is_flag=True, help="Replace an existing design file.")
@anyway
@as_json
def command(
    data: Path,
    design_file: Path,
    fit: str,
    output: Path | None,
    report: Path | None,
    plot: Path | None,
    motion: str,
    window: float | None,
    force: bool,
    anyway: bool,
    as_json: bool,
) -> int:
    """Fit friction, spring and losses of a design to a recording of time, angle and torque.

    DATA.csv has a header with units, such as time_s,theta_deg,tau_Nm. The torque is positive in the loading
    direction. Columns of the angular velocity (omega_rad/s) and of the axial force (F_ext_N) are optional.
    The table shows the fitted values with 95 % intervals. Warnings say what the data cannot tell apart.
    """
    from dualcam.common.paths import check_picture, page_path_of
    from dualcam.identification import identify
    from dualcam.identification.unknowns import unknowns_of
    from dualcam.plots.design import save

    if output is not None and output.resolve() != design_file.resolve():  # which is refused in any case
        refuse_to_overwrite(output, force)
    require_folder_of(report, plot)
    if report is not None:
        page_path_of(report, "the report")
    if plot is not None:
        check_picture(plot)
    names = [name.strip() for name in fit.split(",") if name.strip()]
    design = open_design(design_file, anyway, as_json)
    keep_files_of(design, report, plot, output if output != design_file else None, data=data)
    try:
        unknowns_of(design, names)
    except IdentificationError as error:
        raise click.BadParameter(str(error), param_hint="--fit") from None
    found = identify(data, design, names, motion=motion, window=window, progress=_progress(as_json))
    refusal = None if output is None else _refusal(found, output)
    written = None if refusal else output
    if report is not None:
        found.write_report(report)
    if plot is not None:
        save(found.plot(), plot)
    if as_json:
        files = {"design": written, "report": report, "plot": plot}
        refused = refusal_for_json(refusal) if refusal else {}
        named = {what: path for what, path in files.items() if path}
        print_json({**refused, **found.as_dict(), "files": named})
        return REFUSED if refusal else DONE
    _tell(found)
    say_written(written, report, plot)
    if refusal:
        raise refusal
    return DONE


def _refusal(found: Identification, output: Path) -> DualcamError | None:
    """Writes the fitted design; the error, for after the result, where it must not be written."""
    try:
        found.write_design(output)
    except DualcamError as error:
        return error
    return None


def _progress(quiet: bool) -> Callable[[str], None]:
    """Tells the stage on the error output, once the work has lasted for some seconds."""
    begin = last = time.monotonic()

    def told(stage: str) -> None:
        nonlocal last
        now = time.monotonic()
        if not quiet and now - begin > SILENT and now - last > SILENT:
            last = now
            click.echo(f"dualcam: {stage}, {now - begin:.0f} s", err=True)

    return told


def _tell(found: Identification) -> None:
    from dualcam.identification.result import HEADS, rows_of

    print_table(HEADS, rows_of(found))
    for line in found.summary():
        say(line)
    for text in found.warnings():
        warn(text)
