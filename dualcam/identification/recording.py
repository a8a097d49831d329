"""Recordings of a bench: time, angle and torque from a CSV file, or from arrays."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.arrays import REAL, TIME, real_array
from dualcam.design.groove_files import decoded_text
from dualcam.errors import IdentificationError
from dualcam.paths import path_of
from dualcam.unit_guards import TORQUE_UNITS

Array = NDArray[np.float64]

LEAST_ROWS = 20
DEGREE = math.pi / 180.0
# Quantity -> words that name its column, and its units with their factors to SI. A column that has the FMU's
# own name needs no unit.
NAMES = {
    "time": ("time", "t"),
    "theta": ("theta", "angle", "position"),
    "tau": ("tau", "torque", "moment"),
    "omega": ("omega", "speed", "velocity"),
    "F_ext": ("f_ext", "fext", "force"),
}
UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "theta": {"rad": 1.0, "deg": DEGREE, "mrad": 1e-3, "turn": 2.0 * math.pi},
    "tau": TORQUE_UNITS,
    "omega": {"rad/s": 1.0, "deg/s": DEGREE, "rpm": 2.0 * math.pi / 60.0},
    "F_ext": {"N": 1.0, "kN": 1e3},
}
SPELLINGS = {"°": "deg", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad", "µs": "us"}
NEEDED = ("time", "theta", "tau")
EXAMPLE = "time_s,theta_deg,tau_Nm"
SIGNS = {";": "semicolons", "\t": "tabs", ",": "commas"}
MOST_LISTED = 3  # lines with a fault in one message


@dataclass(frozen=True, eq=False)
class Recording:
    """Samples of a measured motion and torque in SI units.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Increasing times [s]; steps may be uneven.
    theta : ndarray, shape (n,)
        Angle of cam 2 [rad], zero where the design has its zero.
    tau : ndarray, shape (n,)
        Torque on cam 2 [N.m], positive in the loading direction.
    omega : ndarray, shape (n,), optional
        Measured angular velocity [rad/s]. None: found from `theta`.
    F_ext : ndarray, shape (n,), optional
        Axial force on the follower [N], positive against loading. None: zero.
    source : str
        Where the samples come from, for reports.
    notes : tuple of str
        How a file was understood.
    torque_unit : str
        Unit of the torque in the file.
    """

    time: Array
    theta: Array
    tau: Array
    omega: Array | None = None
    F_ext: Array | None = None
    source: str = "arrays"
    notes: tuple[str, ...] = ()
    torque_unit: str = "N.m"

    def __len__(self) -> int:
        return len(self.time)

    @classmethod
    def from_arrays(
        cls,
        time: ArrayLike,
        theta: ArrayLike,
        tau: ArrayLike,
        omega: ArrayLike | None = None,
        F_ext: ArrayLike | None = None,
    ) -> Recording:
        """A recording of arrays of one shape (n,), n >= 20, in SI units.

        Parameters
        ----------
        time, theta, tau, omega, F_ext : array_like, shape (n,)
            As the attributes. Durations, such as timedelta64 of NumPy or pandas, are allowed for `time`.

        Returns
        -------
        Recording

        Raises
        ------
        IdentificationError
            For another shape, a value that is not finite, or times that do not increase.
        """
        given = {"time": time, "theta": theta, "tau": tau, "omega": omega, "F_ext": F_ext}
        columns = {name: _column(name, values) for name, values in given.items() if values is not None}
        count = len(columns["time"])
        for name, values in columns.items():
            if len(values) != count:
                raise IdentificationError(
                    f"{name} has {len(values)} samples, time has {count}: allowed is one {name} per time"
                )
        _check(columns, [f"sample {k}" for k in range(count)])
        return cls(
            columns["time"], columns["theta"], columns["tau"], columns.get("omega"), columns.get("F_ext")
        )


def _column(name: str, values: ArrayLike) -> Array:
    column = real_array(values, name, IdentificationError, kinds=TIME if name == "time" else REAL).copy()
    if column.ndim != 1:
        raise IdentificationError(f"{name} has shape {column.shape}: allowed is (n,)")
    return column


def read_recording(path: str | Path) -> Recording:
    """Read a recording from a CSV file.

    Parameters
    ----------
    path : str or Path
        File with a header whose columns have a name and a unit, such as `time_s,theta_deg,tau_Nm` or
        `t [ms]; angle [rad]; torque [N.mm]`. Columns of the angular velocity (`omega_rad/s`) and of the axial
        force (`F_ext_N`) are optional. Other columns are left out. Columns are separated by commas,
        semicolons or tabs. The decimal sign may be a comma unless commas separate the columns. Lines that
        begin with # are comments. The files of `dualcam simulate` can be read too.

    Returns
    -------
    Recording

    Raises
    ------
    IdentificationError
        With line and column of the first faults, and what is allowed.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "bench.csv"
    ...     rows = [f"{10 * k};{0.5 * k};{2000 + k}" for k in range(30)]
    ...     _ = path.write_text("\\n".join(["t [ms];angle [deg];torque [N.mm]", *rows]))
    ...     recording = read_recording(path)
    >>> len(recording), float(recording.theta[-1].round(4)), float(recording.tau[0])  # rad, N.m
    (30, 0.2531, 2.0)
    """
    path = path_of(path, "the recording")
    text, _ = decoded_text(path, "recording")
    try:
        return _parsed(text, path.name)
    except IdentificationError as error:
        raise IdentificationError(f"{path}: {error}") from None


def _parsed(text: str, source: str) -> Recording:
    numbered = [(number, line) for number, line in enumerate(text.splitlines(), 1) if _has_content(line)]
    if not numbered:
        raise IdentificationError(f"the file is empty: its first line must be a header such as {EXAMPLE}")
    (_, header), *rows = numbered
    sign = max(SIGNS, key=lambda sign: (header.count(sign), sign == ";"))
    heads = [cell.strip().strip("\"'").strip() for cell in header.split(sign)]
    if rows and not _is_numeric(rows[0][1], sign) and len(rows[0][1].split(sign)) == len(heads):
        units = rows.pop(0)[1].split(sign)  # a line of units below the line of names
        heads = [f"{head} {unit.strip()}".strip() for head, unit in zip(heads, units, strict=True)]
    places = _places(heads)
    if len(rows) < LEAST_ROWS:
        raise IdentificationError(f"{len(rows)} lines of numbers: allowed are {LEAST_ROWS} or more")
    columns = _numbers(rows, places, len(heads), sign)
    _check(columns, [f"line {number}" for number, _ in rows])
    read = ", ".join(f"{name} from {heads[place]!r}" for name, (place, _) in places.items())
    optional = columns.get("omega"), columns.get("F_ext")
    return Recording(
        columns["time"],
        columns["theta"],
        columns["tau"],
        *optional,
        source=source,
        notes=(f"read {read}",),
        torque_unit=_quantity(heads[places["tau"][0]])[1] or "N.m",
    )


def _has_content(line: str) -> bool:
    return bool(line.strip(";, \t\"'")) and not line.lstrip().startswith("#")


def _is_numeric(line: str, sign: str) -> bool:
    return bool(re.search(r"\d", line.partition(sign)[0]))


# ---- header ----


def _places(heads: Sequence[str]) -> dict[str, tuple[int, float]]:
    """Quantity -> number of its column, and the factor to SI."""
    found: dict[str, tuple[int, float]] = {}
    unknown: dict[str, str] = {}  # quantity -> what is wrong with its column
    for place, head in enumerate(heads):
        quantity, unit = _quantity(head)
        if quantity is None:
            continue
        factor = 1.0 if head == quantity else UNITS[quantity].get(unit)
        if factor is None:
            what = f"unit {unit!r} is not known" if unit else "no unit"
            unknown[quantity] = f"column {head!r}: {what}; units of {quantity} are {_listed(quantity)}"
        elif quantity in found:
            raise IdentificationError(
                f"the columns {heads[found[quantity][0]]!r} and {head!r} are both {quantity}: allowed is one"
            )
        else:
            found[quantity] = place, factor
    lacking = [quantity for quantity in NEEDED if quantity not in found]
    if lacking:
        reasons = [unknown.get(quantity, f"no column of {quantity}") for quantity in lacking]
        raise IdentificationError(
            f"header {', '.join(heads)!r}: {'; '.join(reasons)}. Allowed is a header such as {EXAMPLE}, with"
            f" the names {', '.join('/'.join(NAMES[quantity]) for quantity in NEEDED)}"
        )
    return found


def _listed(quantity: str) -> str:
    return ", ".join(UNITS[quantity])


def _quantity(head: str) -> tuple[str | None, str]:
    """The quantity that a column's name begins with, and its unit as the tables write the unit."""
    if head in NAMES:
        return head, ""
    for quantity, words in NAMES.items():
        for word in words:
            match = re.fullmatch(rf"{word}(?:[\s_\[(/:,]+(.*?)[\])\s]*)?", head, re.IGNORECASE)
            if match:
                return quantity, _unit(quantity, match[1] or "")
    return None, ""


def _unit(quantity: str, written: str) -> str:
    plain = SPELLINGS.get(written.lower(), written)
    bare = re.sub(r"[\s._*·⋅/]|per", "", plain)
    return next((unit for unit in UNITS[quantity] if re.sub(r"[./]", "", unit) == bare), plain)


# ---- numbers ----


def _numbers(
    rows: Sequence[tuple[int, str]], places: Mapping[str, tuple[int, float]], width: int, sign: str
) -> dict[str, Array]:
    values: dict[str, list[float]] = {name: [] for name in places}
    faults: list[str] = []
    for number, line in rows:
        cells = line.split(sign)
        if sign == "," and len(cells) > width and any(cell.strip() for cell in cells[width:]):
            raise IdentificationError(
                f"line {number}: {len(cells)} values for {width} columns. Is the decimal sign a comma? Then"
                " put semicolons between the columns"
            )
        for name, (place, factor) in places.items():
            written = cells[place].strip().strip("\"'") if place < len(cells) else ""
            value = _number(written, sign)
            if not math.isfinite(value):
                shown = repr(written) if written else "nothing"
                faults.append(f"line {number}, column {place + 1} ({name}): {shown}")
            values[name].append(value * factor)
    if faults:
        more = f" and {len(faults) - MOST_LISTED} more" if len(faults) > MOST_LISTED else ""
        raise IdentificationError(
            f"{'; '.join(faults[:MOST_LISTED])}{more}: allowed is a finite number. Leave out lines that lack"
            " a value"
        )
    return {name: np.array(column) for name, column in values.items()}


def _number(text: str, sign: str) -> float:
    try:
        return float(text.replace(",", ".") if sign != "," else text)
    except ValueError:
        return math.nan


def _check(columns: Mapping[str, Array], labels: Sequence[str]) -> None:
    """IdentificationError for too few samples, values that are not finite, and times that do not increase."""
    count = len(columns["time"])
    if count < LEAST_ROWS:
        raise IdentificationError(f"{count} samples: allowed are {LEAST_ROWS} or more")
    for name, values in columns.items():
        if not np.isfinite(values).all():
            k = int(np.argmin(np.isfinite(values)))
            raise IdentificationError(f"{labels[k]}: {name} = {values[k]}: allowed is a finite number")
    time = columns["time"]
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        k = int(back[0])
        raise IdentificationError(
            f"{labels[k + 1]}: time {time[k + 1]:.9g} s is not after {time[k]:.9g} s ({labels[k]}): allowed"
            " are times that increase. Sort the lines by time, and leave out repeated times"
        )
    if not columns["tau"].any():
        raise IdentificationError("tau is 0 N.m in all samples: allowed is a recorded torque")
    if np.ptp(columns["theta"]) == 0.0:
        raise IdentificationError(
            f"theta is {columns['theta'][0]:g} rad in all samples: allowed is a recording in which cam 2"
            " moves"
        )
