"""The groove as a table of points in space, which is also a groove table for a design file."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dualcam.common.paths import write_text
from dualcam.common.tables import GROOVE_HEADER
from dualcam.common.unit_guards import units_checked_before
from dualcam.design.cut.groove_cut import GrooveCut
from dualcam.design.cut.sampling import MOST_POINTS, SHARES, places, wrapped
from dualcam.design.grooves import Table
from dualcam.design.statics import Array
from dualcam.errors import DesignError

INTERVALS = 128  # between the stops, at least
TABLE_ERROR = 1e-10  # m between the groove and the curve of the FMU through the points
SLOPE_ERROR = 1e-7  # of the slope, likewise
CLOSEST = 1e-5  # rad; closer points would have slopes of rounding errors
LINES = ("centre", "upper", "lower")
COLUMNS = (*GROOVE_HEADER.split(","), *(f"{line}_{axis}_m" for line in LINES for axis in "xyz"))


def write_csv(cut: GrooveCut, path: Path) -> None:
    """Write the points of the pin's first end. SI units; the columns are COLUMNS."""
    curves = wrapped(cut)
    psi = _close_enough(cut, places(cut, curves, intervals=INTERVALS))
    rows = np.column_stack([psi, cut.centre(psi).z, *curves(psi)])
    lines = [",".join(COLUMNS), *(",".join(map(repr, row)) for row in rows.tolist())]
    write_text(path, "\n".join(lines) + "\n")


def _close_enough(cut: GrooveCut, psi: Array) -> Array:
    """More places, such that the curve that the FMU lays through the points is the groove."""
    if not psi[0] <= 0.0 <= psi[-1]:
        return psi  # no table for the FMU: a table includes psi = 0
    while True:
        coarse = _table_errors(cut, psi) & (np.diff(psi) > 2.0 * CLOSEST)
        if not coarse.any():
            return psi
        if len(psi) > MOST_POINTS:
            raise DesignError(
                f"cam {cut.cam}: more than {MOST_POINTS:,} points are needed for a table of this groove: the"
                " groove bends too sharply"
            )
        for _ in range(2):  # a slope at a point comes from two intervals on either side
            coarse |= np.append(coarse[1:], False) | np.insert(coarse[:-1], 0, False)
        psi = np.sort(np.append(psi, 0.5 * (psi[:-1] + psi[1:])[coarse]))


def _table_errors(cut: GrooveCut, psi: Array) -> NDArray[np.bool_]:
    """Whether the curve through the points misses the groove, in each interval; shape (n - 1,)."""
    with units_checked_before():
        table = Table(cut.radius, psi, cut.centre(psi).z)
    between = psi[:-1, None] + SHARES * np.diff(psi)[:, None]
    found, wanted = table.at(between), cut.centre(between)
    scale = max(float(np.max(wanted.slope)), np.finfo(float).tiny)
    missed = np.abs(found.z - wanted.z) > TABLE_ERROR
    missed |= np.abs(found.slope - wanted.slope) > SLOPE_ERROR * scale
    return np.asarray(missed.any(axis=1))
