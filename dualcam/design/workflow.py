"""From a torque in a file, or a number, to the table of a groove in a file: what `dualcam design` does."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dualcam.design.design import Design
from dualcam.design.groove_files import decoded_text
from dualcam.design.grooves import Groove
from dualcam.design.mechanism import Spring
from dualcam.design.statics import Array, DesignError
from dualcam.design.synthesis import synthesize

ANGLE_UNITS = {"deg": math.pi / 180.0, "rad": 1.0}  # rad
TORQUE_UNITS = {"N.m": 1.0, "N.mm": 1e-3, "mN.m": 1e-3, "kN.m": 1e3}  # N.m
LEAST_ROWS = 4  # a cubic spline joins the samples
SPELLINGS = {"°": "deg", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad"}


@dataclass(frozen=True, eq=False)
class TorqueCurve:
    """Samples of a torque over the angle, from a file.

    Attributes
    ----------
    theta : ndarray, shape (n,)
        Angles [rad].
    torque : ndarray, shape (n,)
        Torques [N.m].
    angle_unit, torque_unit : str
        Units in the file, as its header has them.
    """

    theta: Array
    torque: Array
    angle_unit: str
    torque_unit: str

    @classmethod
    def read(cls, path: str | Path) -> TorqueCurve:
        """From a CSV file whose header names the units.

        Parameters
        ----------
        path : str or Path
            File with one column of angles and one of torques, in any order, others are left out. The header
            has units, as in `theta_deg,torque_Nm` or `angle [rad]; torque [N.mm]`. Columns are separated by a
            semicolon, a tab or a comma; the decimal sign may be a comma if the columns are separated by
            another sign.

        Returns
        -------
        TorqueCurve

        Raises
        ------
        DesignError
            If the file cannot be read, the header lacks a unit, or a line has no two numbers. The message has
            the line and what is allowed.
        """
        path = Path(path)
        text, _ = decoded_text(path, "torque file")
        lines = text.splitlines()
        numbered = [(number, line) for number, line in enumerate(lines, 1) if line.strip()]
        if not numbered:
            raise DesignError(f"torque file {path} is empty: allowed is a header and at least 4 lines")
        header = numbered[0][1]
        sign = next((sign for sign in (";", "\t") if sign in header), ",")
        angle, angle_unit = _column(path, header.split(sign), ANGLE_UNITS, "angle", "theta_deg")
        torque, torque_unit = _column(path, header.split(sign), TORQUE_UNITS, "torque", "torque_Nm")
        rows = [
            [_number(path, number, line.split(sign), column, sign) for column in (angle, torque)]
            for number, line in numbered[1:]
        ]
        if 0 < len(rows) < LEAST_ROWS:
            raise DesignError(
                f"torque file {path} has {len(rows)} rows of numbers: allowed are {LEAST_ROWS} or more"
            )
        samples = np.reshape(np.array(rows, dtype=float), (-1, 2))
        return cls(
            samples[:, 0] * ANGLE_UNITS[angle_unit],
            samples[:, 1] * TORQUE_UNITS[torque_unit],
            angle_unit,
            torque_unit,
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

    Parameters
    ----------
    torque : float, str, Path or TorqueCurve
        A number: the same torque [N.m] at each angle. A path: a CSV file, see `TorqueCurve.read`.
    spring : Spring
        Force of the spring over z.
    upper : float or None
        End of the range of theta [rad]. None: the last angle of the file.
    table : str, Path or None
        CSV file to write, for the FMU's parameter `cam1.table`. None: none is written.
    direction, groove2, friction, radius, contacts
        As in `synthesize`.

    Returns
    -------
    Design

    Raises
    ------
    DesignError
        As `synthesize` and `TorqueCurve.read` do, and if a number comes without `upper`.

    Examples
    --------
    >>> design = design_groove(5.0, Spring(preload=400.0, stiffness=10e3), upper=1.2)
    >>> design.torque(0.6).round(4)
    np.float64(5.0)
    """
    curve = TorqueCurve.read(torque) if isinstance(torque, str | Path) else torque
    if isinstance(curve, TorqueCurve):
        if len(curve.theta) == 0:
            raise DesignError("torque: the file has no samples: allowed are at least 4")
        end = float(curve.theta[-1]) if upper is None else upper
    elif upper is None:
        raise DesignError(f"torque = {torque} N.m without upper: allowed is the end of the range [rad]")
    else:
        end = upper
    wanted = (curve.theta, curve.torque) if isinstance(curve, TorqueCurve) else curve
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


def _column(
    path: Path, names: list[str], units: dict[str, float], what: str, example: str
) -> tuple[int, str]:
    """Number of the one column whose name has one of these units, and the unit."""
    found = [(number, unit) for number, name in enumerate(names) if (unit := _unit(name)) in units]
    if len(found) != 1:
        shown = ", ".join(name.strip() for name in names)
        raise DesignError(
            f"torque file {path}: header {shown!r} has {len(found)} columns with a unit of {what}: allowed is"
            f" one, such as {example}; units are {', '.join(units)}"
        )
    return found[0]


def _unit(name: str) -> str:
    """The unit at the end of a column's name, in the spelling of the tables of units; "" if there is none."""
    plain = name.replace("·", ".").replace("*", ".")
    words = [word for word in re.split(r"[\s_\[\]()/\"]+", plain) if word] or [""]
    last = words[-1].lower()
    if last in ANGLE_UNITS or last in SPELLINGS:
        return SPELLINGS.get(last, last)
    joined = "".join(words[-2:]) if words[-1] in ("m", "mm") else words[-1]
    return next((unit for unit in TORQUE_UNITS if unit.replace(".", "") == joined.replace(".", "")), "")


def _number(path: Path, line: int, cells: list[str], column: int, sign: str) -> float:
    text = cells[column].strip() if column < len(cells) else ""
    try:
        return float(text.replace(",", ".") if sign != "," else text)
    except ValueError:
        raise DesignError(
            f"torque file {path}, line {line}: {text!r} in column {column + 1}: allowed is a number"
        ) from None
