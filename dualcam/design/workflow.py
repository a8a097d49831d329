"""From a torque in a file, or a number, to the table of a groove in a file: what `dualcam design` does."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from dualcam.common.paths import path_of
from dualcam.common.tables import ANGLE_NAMES, TORQUE_NAMES, ColumnKind, TableKind, read_table
from dualcam.common.unit_guards import units_checked_before
from dualcam.design.design import Design
from dualcam.design.grooves import Groove
from dualcam.design.mechanism import Spring
from dualcam.design.statics import Array
from dualcam.design.synthesis import synthesize
from dualcam.errors import DesignError, UnitWarning

TORQUE = TableKind(
    what="torque file",
    quantities={
        "theta": ColumnKind("angle", ANGLE_NAMES, order="rises", rule="table.theta"),
        "torque": ColumnKind("torque", TORQUE_NAMES),
    },
    example="theta_deg,torque_Nm",
    error=DesignError,
    least=4,  # a cubic spline joins the samples
)


@dataclass(frozen=True, eq=False)
class TorqueCurve:
    """Samples of a torque over the angle, from a file.

    `theta`: angles [rad], shape (n,). `torque`: torques [N.m], shape (n,). `angle_unit`, `torque_unit`: units
    in the file, as its header has them.
    """

    theta: Array
    torque: Array
    angle_unit: str
    torque_unit: str

    @classmethod
    def read(cls, path: str | Path) -> TorqueCurve:
        """From a CSV file whose header names the units.

        `path`: file with one column of increasing angles and one of torques, in any order; others are left
        out. The header has units, as in `theta_deg,torque_Nm` or `angle [rad]; torque [N.mm]`; docs/tables.md
        says what else is read. DesignError: if the file cannot be read, the header lacks a unit, a line has
        no two numbers, or an angle is not above the one before. The message has the line and what is allowed.

        Warns
        -----
        UnitWarning : Numbers that look as if they were in another unit.
        """
        path = path_of(path, "the torque file")
        table = read_table(path, TORQUE)
        for text in table.warnings:
            warnings.warn(UnitWarning(f"{path}: {text}"), stacklevel=2)
        return cls(
            table.columns["theta"], table.columns["torque"], table.units["theta"], table.units["torque"]
        )

    def __str__(self) -> str:
        return (
            f"{len(self.theta)} samples, angles read as {self.angle_unit}, torques as {self.torque_unit}:"
            f" theta = {self.theta.min():.4g} to {self.theta.max():.4g} rad, torque {self.torque.min():.4g}"
            f" to {self.torque.max():.4g} N.m"
        )


def design_groove(
    torque: float | str | Path | TorqueCurve,
    spring: Spring,
    upper: float | None = None,
    *,
    table: str | Path | None = None,
    direction: str = "loading",
    groove2: Groove | None = None,
    friction: Sequence[float] = (0.14, 0.14),
    radius: float = 0.02,
    contacts: int = 2,
) -> Design:
    """Design a groove for a torque, and write its table.

    `torque`: a number: the same torque [N.m] at each angle. A path: a CSV file, see `TorqueCurve.read`.
    `spring`: force of the spring over z. `upper`: end of the range of theta [rad]. None: the last angle of
    the file. `table`: CSV file to write, for the FMU's parameter `cam1.table`. None: none is written.
    `direction`, `groove2`, `friction`, `radius`, `contacts`: as in `synthesize`. DesignError: as `synthesize`
    and `TorqueCurve.read` do, and if a number comes without `upper`.

    Examples
    --------
    >>> design = design_groove(5.0, Spring(preload=400.0, stiffness=10e3), upper=1.2)
    >>> design.torque(0.6).round(4)
    np.float64(5.0)
    """
    curve = TorqueCurve.read(torque) if isinstance(torque, str | Path) else torque
    if isinstance(curve, TorqueCurve):
        if len(curve.theta) == 0:
            raise DesignError("torque: the curve has no samples: allowed are 4 or more")
        end = float(curve.theta[-1]) if upper is None else upper
    elif upper is None:
        raise DesignError(f"torque = {torque} N.m without upper: allowed is the end of the range [rad]")
    else:
        end = upper
    wanted = (curve.theta, curve.torque) if isinstance(curve, TorqueCurve) else curve
    is_read_here = isinstance(torque, str | Path)  # and warned of with the name of the file
    with units_checked_before() if is_read_here else nullcontext():
        design = synthesize(
            wanted,
            end,
            spring,
            direction=direction,
            groove2=groove2,
            friction=friction,
            radius=radius,
            contacts=contacts,
        )
    if table is not None:
        design.table.write(table)
    return design
