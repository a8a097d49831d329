"""`dualcam band`: torque band, self-locking and efficiency over the angle."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from dualcam.cli.options import FILE, anyway, as_json, design_file, example, open_design
from dualcam.cli.output import (
    keep_files_of,
    keep_other_tables,
    print_json,
    print_table,
    require_folder_of,
    say,
    say_written,
)

if TYPE_CHECKING:
    from dualcam.design import TorqueBand
    from dualcam.design_file import DesignFile
    from dualcam.report.summary import Largest, LargestLoads

SHOWN = ("theta [deg]", "z [mm]", "load [N.m]", "release [N.m]", "efficiency [%]")
SHOWN_COLUMNS = (0, 2, 4, 3, 5)
HEADS = (
    *("theta_deg", "theta_rad", "z_mm", "release_N.m", "load_N.m"),
    *("efficiency_%", "lead1_deg", "lead2_deg"),
)


@click.command(epilog=example("dualcam band my.toml --plot band.png", "dualcam band my.toml -o band.csv"))
@design_file
@click.option("-o", "--output", type=FILE, help="CSV file for the table.")
@click.option("--plot", type=FILE, help="Picture of the band (.png, .svg or .pdf).")
@click.option(
    "--points", type=click.IntRange(2, 100_000), default=9, show_default=True, help="Number of angles."
)
@anyway
@as_json
def command(
    design_file: Path, output: Path | None, plot: Path | None, points: int, anyway: bool, as_json: bool
) -> None:
    """Show the torque band over the angle, and the efficiency.

    Above `load` the torque turns the cam and loads the spring. Below `release` the spring turns the cam
    back. Between both the cam rests. The efficiency is release/load. Below 0 the mechanism
    locks itself. The last lines are the largest reaction and, with [pin], the largest contact pressure.
    """
    from dualcam.common.paths import check_picture, write_text
    from dualcam.design import torque_band
    from dualcam.plots.design import plot_band, save
    from dualcam.report.summary import largest_loads

    require_folder_of(output, plot)
    if plot is not None:
        check_picture(plot)
    design = open_design(design_file, anyway, as_json)
    keep_files_of(design, output, plot)
    if output is not None:
        keep_other_tables(output, ",".join(HEADS))
    mechanism = design.mechanism()
    band, fine = torque_band(mechanism, points), torque_band(mechanism, max(points, 361))
    rows, loads = _rows(band), largest_loads(mechanism, design.pin)
    if output is not None:
        lines = [",".join(HEADS), *(",".join(map(repr, row)) for row in rows.tolist())]
        write_text(output, "\n".join(lines) + "\n")
    if plot is not None:
        save(plot_band(fine, design.title or design.name), plot)
    if as_json:
        columns = dict(zip(HEADS, rows.T, strict=True))
        largest = _largest_for_json(loads, design)
        print_json({"self_locking": fine.self_locking, "columns": columns, **largest})
        return
    print_table(SHOWN, [[f"{row[k]:.4g}" for k in SHOWN_COLUMNS] for row in rows])
    say(_summary(fine))
    if note := design.friction_note():
        say(note)
    _tell_loads(loads, design)
    say_written(output, plot)


def _largest_for_json(loads: LargestLoads, design: DesignFile) -> dict[str, Any]:
    """In the units of the table's columns."""

    def of(unit: str, largest: Largest, size: float) -> dict[str, Any]:
        return {unit: largest.value / size, "theta_deg": math.degrees(largest.theta), "cams": largest.cams}

    pressure = {} if loads.pressure is None else {"largest_pressure": of("MPa", loads.pressure, 1e6)}
    reaction = {"largest_reaction": of("N", loads.reaction, 1.0)}
    return {**reaction, "contacts": design.value("contacts"), **pressure}


def _tell_loads(loads: LargestLoads, design: DesignFile) -> None:
    from dualcam.report.summary import material_words, pressure_words, reaction_words

    say(f"Largest reaction: {reaction_words(loads.reaction, design.value('contacts'))}.")
    if design.pin is None or loads.pressure is None:
        say("Contact pressure: not known, the design has no section [pin].")
        return
    say(f"Largest contact pressure (Hertz): {pressure_words(loads.pressure)}.")
    say(f"Young's moduli: {material_words(design.pin)}.")


def _rows(band: TorqueBand) -> np.ndarray:
    torques = band.release, band.load, 100.0 * band.efficiency
    angles = np.degrees(band.theta), band.theta, 1e3 * band.z
    return np.column_stack([*angles, *torques, *np.degrees(band.lead_angle)])


def _summary(band: TorqueBand) -> str:
    from dualcam.design.band import LOCKING, NOT_LOCKING, range_words
    from dualcam.report.summary import span_words

    if not np.isfinite(band.load).all():
        angle = np.degrees(band.theta[~np.isfinite(band.load)][0])
        return f"Jam: at theta = {angle:.4g} deg no torque can load the mechanism."
    if band.self_locking:
        return f"Self-locking {range_words(band.locked, 'deg')}: {LOCKING}."
    return f"Not self-locking: {NOT_LOCKING}. Efficiency {span_words(100.0 * band.efficiency, '%')}."
