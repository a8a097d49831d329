"""`dualcam band`: torque band, self-locking and efficiency over the angle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from dualcam.cli.options import FILE, as_json, design_file, example, open_design
from dualcam.cli.output import print_json, print_table, require_folder_of, say

if TYPE_CHECKING:
    from dualcam.design import TorqueBand

SHOWN = ("theta [deg]", "z [mm]", "load [N.m]", "release [N.m]", "efficiency [%]")
SHOWN_COLUMNS = (0, 2, 4, 3, 5)
HEADS = (
    "theta_deg",
    "theta_rad",
    "z_mm",
    "release_N.m",
    "load_N.m",
    "efficiency_%",
    "lead1_deg",
    "lead2_deg",
)


@click.command(epilog=example("dualcam band my.toml --plot band.png", "dualcam band my.toml -o band.csv"))
@design_file
@click.option("-o", "--output", type=FILE, help="CSV file for the table.")
@click.option("--plot", type=FILE, help="Picture of the band (.png, .svg or .pdf).")
@click.option(
    "--points", type=click.IntRange(2, 100_000), default=9, show_default=True, help="Number of angles."
)
@as_json
def command(design_file: Path, output: Path | None, plot: Path | None, points: int, as_json: bool) -> None:
    """Show the torque band over the angle, and the efficiency.

    Above `load` the torque turns the cam and loads the spring. Below `release` the spring turns the cam
    back. Between both the cam rests. The efficiency is release/load. Below 0 the mechanism
    locks itself.
    """
    from dualcam.design import torque_band
    from dualcam.plots import check_picture, plot_band, save

    for path in (output, plot):
        if path is not None:
            require_folder_of(path)
    if plot is not None:
        check_picture(plot)
    design = open_design(design_file)
    mechanism = design.mechanism()
    band, fine = torque_band(mechanism, points), torque_band(mechanism, max(points, 361))
    rows = _rows(band)
    if output is not None:
        lines = [",".join(HEADS), *(",".join(map(repr, row)) for row in rows.tolist())]
        output.write_text("\n".join(lines) + "\n", encoding="utf-8")
    if plot is not None:
        save(plot_band(fine, design.name), plot)
    if as_json:
        columns = dict(zip(HEADS, rows.T, strict=True))
        print_json({"self_locking": fine.self_locking, "columns": columns})
        return
    print_table(SHOWN, [[f"{row[k]:.4g}" for k in SHOWN_COLUMNS] for row in rows])
    say(_summary(fine))
    for path in (output, plot):
        if path is not None:
            say(f"{path} written")


def _rows(band: TorqueBand) -> np.ndarray:
    lead1, lead2 = np.degrees(band.lead_angle)
    return np.column_stack(
        [
            np.degrees(band.theta),
            band.theta,
            1e3 * band.z,
            band.release,
            band.load,
            100.0 * band.efficiency,
            lead1,
            lead2,
        ]
    )


def _summary(band: TorqueBand) -> str:
    if not np.isfinite(band.load).all():
        angle = np.degrees(band.theta[~np.isfinite(band.load)][0])
        return f"Jam: at theta = {angle:.4g} deg no torque can load the mechanism."
    if band.self_locking:
        angle = np.degrees(band.theta[band.efficiency <= 0.0][0])
        return f"Self-locking from theta = {angle:.4g} deg: the spring cannot turn the cam back."
    share = 100.0 * band.efficiency
    return f"Not self-locking. Efficiency {np.nanmin(share):.3g} % to {np.nanmax(share):.3g} %."
