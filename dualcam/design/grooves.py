"""Groove laws z = g(psi) as the FMU has them (fmu_src/geometry/groove.h), for arrays, with the curvature
of the unwrapped groove (x = r psi, z).

A `Table` lays the very curve through its samples that the FMU lays (fmu_src/geometry/groove_table.h)."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import real_array
from dualcam.common.paths import write_text
from dualcam.common.tables import GROOVE_HEADER, fmu_text
from dualcam.common.unit_guards import table_warnings, unit_warning, units_checked_before, warn_units
from dualcam.design.groove_files import read_groove
from dualcam.design.statics import Array
from dualcam.errors import DesignError, UnitWarning

VERTICAL = 1e-10  # of S: an elliptical groove ends that much before it is vertical, as in the FMU
STENCIL = 5  # samples that a table's slope at a sample comes from

Numbers = float | NDArray[Any]


class Point(NamedTuple):
    """A groove law at one angle or at many.

    Attributes
    ----------
    z : ndarray
        Height [m], of the shape of psi.
    slope : ndarray
        dz/dpsi [m/rad].
    d2z_dpsi2 : ndarray
        Second derivative [m/rad2].
    """

    z: Array
    slope: Array
    d2z_dpsi2: Array


class Groove(Protocol):
    """A groove law: its cam's radius [m], the range of angles where the law holds [rad], its values."""

    @property
    def radius(self) -> float: ...
    @property
    def range(self) -> tuple[float, float]: ...
    def at(self, psi: ArrayLike) -> Point:
        """The law at psi; beyond its range, its value at that end."""
        ...

    def parameters(self) -> dict[str, float | int]:
        """The FMU's parameters after `cam1.` or `cam2.`, the file of a table apart."""
        ...


def curvature(groove: Groove, psi: ArrayLike) -> Array:
    """Curvature of the unwrapped path of the pin's centre: (g''/r^2)/(1 + (g'/r)^2)^(3/2).

    Parameters
    ----------
    groove : Groove
        The groove law z = g(psi) on a cam of radius r.
    psi : array_like
        Angle of the pin along the groove [rad].

    Returns
    -------
    ndarray
        Curvature [1/m], + where the groove steepens, of the shape of `psi`.

    Examples
    --------
    >>> from dualcam.design import Helix, curvature
    >>> float(curvature(Helix(radius=0.02, lead_angle=0.7854), 0.3))  # a helix unwraps to a straight line
    0.0
    """
    point, r = groove.at(psi), groove.radius
    return point.d2z_dpsi2 / r**2 / (1.0 + (point.slope / r) ** 2) ** 1.5


def _check(what: str, value: float, good: bool, allowed: str) -> None:
    if not good:
        raise DesignError(f"{what} = {value}: allowed is {allowed}")


def _check_radius(radius: float) -> None:
    _check("radius", radius, 0.0 < radius < math.inf, "a finite number > 0 in m")


def _check_lead_angle(value: float) -> None:
    hint = unit_warning("cam1.lead_angle", value, "lead_angle") or ""
    likely = f"; {hint.partition(': ')[2]}" if hint else ""
    _check("lead_angle", value, 0.0 <= value < 0.5 * math.pi, f"[0, pi/2) in rad{likely}")


@dataclass(frozen=True)
class Helix:
    """A groove of constant lead angle: z = r tan(lambda) psi.

    Parameters
    ----------
    radius : float
        Radius r of the cam [m], > 0.
    lead_angle : float
        Lead angle lambda [rad], from 0 to less than pi/2.

    Raises
    ------
    DesignError
        A value outside its range.

    Notes
    -----
    Source: docs/mechanism.md, section 2.

    Examples
    --------
    >>> import math
    >>> from dualcam.design import Helix
    >>> groove = Helix(radius=0.02, lead_angle=math.radians(45))
    >>> round(float(groove.at(0.5).z), 6)  # m, at psi = 0.5 rad
    0.01
    """

    radius: float
    lead_angle: float

    def __post_init__(self) -> None:
        _check_radius(self.radius)
        _check_lead_angle(self.lead_angle)
        warn_units({"radius": ("cam1.radius", self.radius)})

    @property
    def range(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def at(self, psi: ArrayLike) -> Point:
        angle = real_array(psi, "psi", DesignError)
        gain = self.radius * math.tan(self.lead_angle)
        return Point(gain * angle, np.full(angle.shape, gain), np.zeros(angle.shape))

    def parameters(self) -> dict[str, float | int]:
        return {"profile": 1, "radius": self.radius, "lead_angle": self.lead_angle}


def ellipse_law(
    psi: NDArray[Any], radius: Numbers, start: Numbers, a: Numbers, b: Numbers, bending: int
) -> Point:
    """The groove that unwraps to an arc of an ellipse, for arrays that broadcast, also of complex numbers.

    Parameters
    ----------
    psi : ndarray
        Angle of the pin along the groove [rad], inside the range of the law.
    radius : float or ndarray
        Radius of the cam [m].
    start : float or ndarray
        S at psi = 0: sin(atan(a/b tan(lead angle))) [1].
    a, b : float or ndarray
        Semi-axes along the circumference and along z [m].
    bending : {1, -1}
        +1: the groove steepens. -1: the groove flattens.

    Returns
    -------
    Point

    Notes
    -----
    Source: docs/mechanism.md, section 2.
    """
    rate = bending * radius / a
    u = rate * psi
    S, C0 = start + u, np.sqrt(1.0 - start**2)
    rise = u * (start + S)  # C0^2 - C^2
    C = np.sqrt(C0**2 - rise)
    gain = radius * b / a
    return Point(bending * b * rise / (C0 + C), gain * S / C, gain * rate / C**3)


@dataclass(frozen=True)
class Ellipse:
    """A groove that unwraps to an arc of an ellipse.

    Parameters
    ----------
    radius : float
        Radius of the cam [m], > 0.
    lead_angle : float
        Lead angle at psi = 0 [rad], from 0 to less than pi/2.
    a, b : float
        Semi-axes along the circumference and along z [m], > 0.
    bending : {1, -1}
        +1: the groove steepens. -1: the groove flattens. The FMU's `ellipse_curvature`.

    Raises
    ------
    DesignError
        A value outside its range.

    Notes
    -----
    Source: docs/mechanism.md, section 2.

    Examples
    --------
    >>> from dualcam.design import Ellipse
    >>> groove = Ellipse(radius=0.02, lead_angle=0.6, a=0.05, b=0.05)
    >>> low, high = groove.range  # rad, where the law holds
    >>> low < 0.0 < 1.0 < high
    True
    """

    radius: float
    lead_angle: float
    a: float
    b: float
    bending: int = -1

    def __post_init__(self) -> None:
        _check_radius(self.radius)
        _check_lead_angle(self.lead_angle)
        _check("a", self.a, 0.0 < self.a < math.inf, "a finite number > 0 in m")
        _check("b", self.b, 0.0 < self.b < math.inf, "a finite number > 0 in m")
        _check("bending", self.bending, self.bending in (-1, 1), "+1 (steepens) or -1 (flattens)")
        starts = self._start <= 1.0 - VERTICAL
        _check("lead_angle", self.lead_angle, starts, "less: this elliptical groove would start vertical")
        lengths = {"radius": "cam1.radius", "a": "cam1.ellipse_a", "b": "cam1.ellipse_b"}
        warn_units({name: (rule, getattr(self, name)) for name, rule in lengths.items()})

    @property
    def _start(self) -> float:
        return math.sin(math.atan(self.a / self.b * math.tan(self.lead_angle)))

    @property
    def range(self) -> tuple[float, float]:
        ends = [(S - self._start) * self.a / self.radius * self.bending for S in (0.0, 1.0 - VERTICAL)]
        return min(ends), max(ends)

    def at(self, psi: ArrayLike) -> Point:
        angle = np.clip(real_array(psi, "psi", DesignError), *self.range)
        return ellipse_law(angle, self.radius, self._start, self.a, self.b, self.bending)

    def parameters(self) -> dict[str, float | int]:
        return {
            "profile": 2,
            "radius": self.radius,
            "lead_angle": self.lead_angle,
            "ellipse_a": self.a,
            "ellipse_b": self.b,
            "ellipse_curvature": self.bending,
        }


@dataclass(frozen=True, eq=False)
class Table:
    """Samples (psi [rad], z [m]), shape (n,), n >= 4: psi increases and includes 0, z does not decrease.
    `notes` say how a file was understood."""

    radius: float
    psi: Array
    z: Array
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _check_radius(self.radius)
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
        path : str or Path
            File with columns of the angle psi of the pin along the groove, and the height z of the pin.
        radius : float
            Radius of the cam [m].
        units : (str, str), optional
            Units of angle and height: "rad", "deg", "mrad" or "turn", and "m", "mm", "cm", "um" or "in".
            Without them the header must name the units, such as psi_rad,z_m or "psi [deg];z [mm]".
        delimiter : str, optional
            Between the columns: ",", ";", " " or a tab; guessed from the lines if not given.
        decimal : str, optional
            Decimal sign, "." or ","; guessed from the lines if not given.

        Returns
        -------
        Table
            Its `notes` say what was guessed.

        Raises
        ------
        DesignError
            With file, line, column and value, for a file that cannot be understood.

        Warns
        -----
        UnitWarning
            Numbers that look as if they were in another unit.

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
        """To a CSV file for the FMU's `cam1.table` or `cam2.table`, with all digits."""
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
        point = self._curve(np.clip(real_array(psi, "psi", DesignError), *self.range))
        return point._replace(z=point.z - self._origin)

    def parameters(self) -> dict[str, float | int]:
        return {"profile": 3, "radius": self.radius}


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


def both_parameters(grooves: Sequence[Groove]) -> dict[str, float | int]:
    """Parameters of both cams under their full names."""
    return {f"cam{i}.{name}": v for i, g in enumerate(grooves, 1) for name, v in g.parameters().items()}
