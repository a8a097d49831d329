"""Grooves by samples."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import real_array
from dualcam.common.groove_laws import TABLE
from dualcam.common.paths import write_text
from dualcam.common.tables import GROOVE_HEADER, fmu_text
from dualcam.common.unit_guards import table_warnings, units_checked_before
from dualcam.design.groove_files import read_groove
from dualcam.design.grooves.groove import Point, check_radius
from dualcam.design.statics import Array
from dualcam.errors import DesignError, UnitWarning

STENCIL = 5  # samples that a table's slope at a sample comes from


@dataclass(frozen=True, eq=False)
class Table:
    """Samples `psi` [rad] and `z` [m] on a cam of a `radius` [m], shape (n,), n >= 4. psi increases and
    includes 0, z does not decrease. `notes` say how a file was understood."""

    radius: float
    psi: Array
    z: Array
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_radius(self.radius)
        psi, z = real_array(self.psi, "psi", DesignError), real_array(self.z, "z", DesignError)
        if psi.ndim != 1 or psi.shape != z.shape or len(psi) < 4:
            raise DesignError(f"samples of shapes {psi.shape} and {z.shape}: allowed are (n,) twice, n >= 4")
        if not (np.isfinite(psi).all() and np.isfinite(z).all() and (np.diff(psi) > 0.0).all()):
            raise DesignError("samples: psi must increase, and all numbers must be finite")
        if (np.diff(z) < 0.0).any():
            worst = int(np.argmax(np.diff(z) < 0.0))
            raise DesignError(f"samples: z decreases after psi = {psi[worst]:.6g} rad, where it must not")
        if not psi[0] <= 0.0 <= psi[-1]:
            raise DesignError(
                f"samples: psi goes from {psi[0]:.6g} to {psi[-1]:.6g} rad: psi = 0 must be among them"
            )
        object.__setattr__(self, "psi", psi)
        object.__setattr__(self, "z", z)
        for text in table_warnings(psi, z):
            warnings.warn(UnitWarning(f"Table: {text}"), stacklevel=3)

    @classmethod
    def read(
        cls,
        path: str | Path,
        radius: float,
        *,
        units: Sequence[str] | None = None,
        delimiter: str | None = None,
        decimal: str | None = None,
    ) -> Table:
        """The groove of a table file.

        Parameters
        ----------
        path : File with columns of the angle psi of the pin along the groove, and the height z of the pin.
        radius : Radius of the cam [m].
        units
            Units of angle and height: "rad", "deg", "mrad" or "turn", and "m", "mm", "cm", "um" or "in".
            Without them the header must name the units, such as psi_rad,z_m or "psi [deg];z [mm]".
        delimiter : Between the columns: ",", ";", " " or a tab; guessed from the lines if not given.
        decimal : Decimal sign, "." or ","; guessed from the lines if not given.

        Returns
        -------
        The table. Its `notes` say what was guessed.

        Raises
        ------
        DesignError : With file, line, column and value, for a file that cannot be understood.

        Warns
        -----
        UnitWarning : Numbers that look as if they were in another unit.

        Examples
        --------
        >>> import tempfile
        >>> from pathlib import Path
        >>> from dualcam.design import Table
        >>> lines = ["psi [deg];z [mm]", "0;0", "20;4,2", "40;8,6", "60;13,5"]
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = Path(folder) / "groove.csv"
        ...     _ = path.write_text("\\n".join(lines))
        ...     table = Table.read(path, radius=0.02, delimiter=";", decimal=",")
        >>> table.z.tolist()  # m
        [0.0, 0.0042, 0.0086, 0.0135]
        """
        file = read_groove(path, units, delimiter, decimal)
        try:
            with units_checked_before():
                table = cls(radius, file.psi, file.z, file.notes)
        except DesignError as error:
            raise DesignError(f"{path}: {error}") from None
        for text in table_warnings(table.psi, table.z, radius):
            warnings.warn(UnitWarning(f"{path}: {text}"), stacklevel=2)
        return table

    def write(self, path: str | Path) -> None:
        """To a CSV file at `path` for the FMU's `cam1.table` or `cam2.table`, with all digits."""
        write_text(Path(path), fmu_text(GROOVE_HEADER, self.psi, self.z))

    @property
    def range(self) -> tuple[float, float]:
        return float(self.psi[0]), float(self.psi[-1])

    @cached_property
    def _slope_coefficients(self) -> Array:
        """Bernstein coefficients of the slope between samples [m/rad], shape (5, n - 1)."""
        width, chord = np.diff(self.psi), np.diff(self.z) / np.diff(self.psi)
        slope, second = _sample_derivatives(self.psi, self.z)
        flat = np.concatenate([[False], chord == 0.0]) | np.concatenate([chord == 0.0, [False]])
        slope = np.where(flat, 0.0, np.maximum(slope, 0.0))
        second = np.where(flat, 0.0, second)
        second[:-1] = np.maximum(second[:-1], -4.0 * slope[:-1] / width)
        second[1:] = np.minimum(second[1:], 4.0 * slope[1:] / width)
        ends = _end_sum(width, slope, second)
        shrink = np.where(ends > 0.0, np.minimum(1.0, 5.0 * chord / np.where(ends > 0.0, ends, 1.0)), 1.0)
        least = np.minimum(np.append(1.0, shrink), np.append(shrink, 1.0))
        slope, second = slope * least, second * least
        return np.stack(
            [
                slope[:-1],
                np.maximum(slope[:-1] + second[:-1] * width / 4.0, 0.0),
                np.maximum(5.0 * chord - _end_sum(width, slope, second), 0.0),
                np.maximum(slope[1:] - second[1:] * width / 4.0, 0.0),
                slope[1:],
            ]
        )

    @cached_property
    def _origin(self) -> float:
        return float(self._curve(np.zeros(())).z)

    def _curve(self, psi: Array) -> Point:
        j = np.clip(np.searchsorted(self.psi, psi, side="right") - 1, 0, len(self.psi) - 2)
        width = self.psi[j + 1] - self.psi[j]
        t = (psi - self.psi[j]) / width
        u, b = 1.0 - t, self._slope_coefficients[:, j]
        slope = sum(w * b[k] * t**k * u ** (4 - k) for k, w in enumerate((1, 4, 6, 4, 1)))
        second = (
            4.0 / width * sum(w * (b[k + 1] - b[k]) * t**k * u ** (3 - k) for k, w in enumerate((1, 3, 3, 1)))
        )
        total = np.cumsum(b, axis=0)
        rise = sum(w * total[k] * t ** (k + 1) * u ** (4 - k) for k, w in enumerate((5, 10, 10, 5, 1))) / 5.0
        return Point(self.z[j] + width * rise, np.asarray(slope), np.asarray(second))

    def at(self, psi: ArrayLike) -> Point:
        """The law at `psi` [rad], as `Groove.at`."""
        point = self._curve(np.clip(real_array(psi, "psi", DesignError), *self.range))
        return point._replace(z=point.z - self._origin)

    def parameters(self) -> dict[str, float | int]:
        """The FMU's parameters, as `Groove.parameters`."""
        return {"profile": TABLE.number, "radius": self.radius}


def _end_sum(width: Array, slope: Array, second: Array) -> Array:
    """s in step (3) of the rule in groove_table.h."""
    return 2.0 * (slope[:-1] + slope[1:]) + (second[:-1] - second[1:]) * width / 4.0


def _sample_derivatives(psi: Array, z: Array) -> tuple[Array, Array]:
    """First and second derivative at each sample of the polynomial through the nearest five (or all four), by
    divided differences that begin at the sample."""
    count, n = len(psi), min(len(psi), STENCIL)
    begin = np.clip(np.arange(count) - 2, 0, count - n)
    # the sample itself, then the others of its stencil
    others = [np.where(begin + k < np.arange(count), begin + k, begin + k + 1) for k in range(n - 1)]
    index = np.stack([np.arange(count), *others])
    x, difference = psi[index], z[index]
    for k in range(1, n):
        difference[k:] = (difference[k:] - difference[k - 1 : -1]) / (x[k:] - x[:-k])
    first, half_second = np.ones(count), np.zeros(count)
    slope, second = difference[1].copy(), np.zeros(count)
    for k in range(2, n):
        half_second = half_second * (x[0] - x[k - 1]) + first
        first = first * (x[0] - x[k - 1])
        slope += difference[k] * first
        second += 2.0 * difference[k] * half_second
    return slope, second
