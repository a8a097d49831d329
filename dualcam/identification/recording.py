"""Recordings of a bench: time, angle and torque from a CSV file, or from arrays."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import REAL, TIME, Array, real_array
from dualcam.common.paths import path_of
from dualcam.common.tables import ANGLE_NAMES, TORQUE_NAMES, ColumnKind, TableKind, read_table
from dualcam.errors import IdentificationError, UnitWarning

LEAST_ROWS = 20
RECORDING = TableKind(
    what="recording",
    quantities={
        "time": ColumnKind("time", ("time", "t", "zeit"), order="rises", bare_name="time"),
        "theta": ColumnKind("angle", ANGLE_NAMES, bare_name="theta", rule="table.theta"),
        "tau": ColumnKind("torque", TORQUE_NAMES, bare_name="tau"),
        "omega": ColumnKind(
            "angular velocity", ("omega", "speed", "velocity"), needed=False, bare_name="omega"
        ),
        "F_ext": ColumnKind("force", ("f_ext", "fext", "force"), needed=False, bare_name="F_ext"),
    },
    example="time_s,theta_deg,tau_Nm",
    error=IdentificationError,
    least=LEAST_ROWS,
)


@dataclass(frozen=True, eq=False)
class Recording:
    """Samples of a measured motion and torque in SI units.

    Attributes
    ----------
    time : Increasing times [s], shape (n,); steps may be uneven.
    theta : Angle of cam 2 [rad], zero where the design has its zero, shape (n,).
    tau : Torque on cam 2 [N.m], positive in the loading direction, shape (n,).
    omega : Measured angular velocity [rad/s], shape (n,). None: found from `theta`.
    F_ext : Axial force on the follower [N], positive against loading, shape (n,). None: zero.
    source : Where the samples come from, for reports.
    notes : How a file was understood.
    torque_unit : Unit of the torque in the file.
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

        `time`, `theta`, `tau`, `omega`, `F_ext`: as the attributes, shape (n,). Durations, such as
        timedelta64 of NumPy or pandas, are allowed for `time`. IdentificationError: for another shape, a
        value that is not finite, or times that do not increase.
        """
        given = {"time": time, "theta": theta, "tau": tau, "omega": omega, "F_ext": F_ext}
        columns = {name: _column(name, values) for name, values in given.items() if values is not None}
        count = len(columns["time"])
        for name, values in columns.items():
            if len(values) != count:
                raise IdentificationError(
                    f"{name} has {len(values)} samples, time has {count}: allowed is one {name} per time"
                )
        _check(columns)
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

    `path`: file with a header whose columns have a name and a unit, such as `time_s,theta_deg,tau_Nm` or
    `t [ms]; angle [rad]; torque [N.mm]`; docs/tables.md says what else is read. Columns of the angular
    velocity (`omega_rad/s`) and of the axial force (`F_ext_N`) are optional. Other columns are left out. The
    files of `dualcam simulate` can be read too. IdentificationError: with line and column of the first
    faults, and what is allowed.

    Warns
    -----
    UnitWarning : Numbers that look as if they were in another unit.

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
    table = read_table(path, RECORDING)
    columns = table.columns
    try:
        _check_motion(columns)
    except IdentificationError as error:
        raise IdentificationError(f"{path}: {error}") from None
    for text in table.warnings:
        warnings.warn(UnitWarning(f"{path}: {text}"), stacklevel=2)
    read = ", ".join(f"{name} from {head!r}" for name, head in table.heads.items())
    return Recording(
        **columns,
        source=path.name,
        notes=(f"read {read}", *table.notes),
        torque_unit=table.units["tau"] or "N.m",
    )


def _check(columns: Mapping[str, Array]) -> None:
    """IdentificationError for too few samples, values that are not finite, times that do not increase, and
    samples without torque or motion."""
    count = len(columns["time"])
    if count < LEAST_ROWS:
        raise IdentificationError(f"{count} samples: allowed are {LEAST_ROWS} or more")
    for name, values in columns.items():
        if not np.isfinite(values).all():
            k = int(np.argmin(np.isfinite(values)))
            raise IdentificationError(f"sample {k}: {name} = {values[k]}: allowed is a finite number")
    time = columns["time"]
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        k = int(back[0])
        raise IdentificationError(
            f"sample {k + 1}: time {time[k + 1]:.9g} s is not after {time[k]:.9g} s (sample {k}): allowed are"
            " times that increase. Sort the samples by time, and leave out repeated times"
        )
    _check_motion(columns)


def _check_motion(columns: Mapping[str, Array]) -> None:
    """IdentificationError for samples without torque, and for samples in which cam 2 stands still."""
    if not columns["tau"].any():
        raise IdentificationError("tau is 0 N.m in all samples: allowed is a recorded torque")
    if np.ptp(columns["theta"]) == 0.0:
        raise IdentificationError(
            f"theta is {columns['theta'][0]:g} rad in all samples: allowed is a recording in which cam 2"
            " moves"
        )
