"""The torque that the inverse FMU needs for a recorded motion, as a function of its parameters."""

import math
from collections.abc import Sequence
from typing import Self

import numpy as np

from dualcam.common.arrays import Array
from dualcam.common.unit_guards import units_checked_before
from dualcam.design_file import DesignFile
from dualcam.errors import IdentificationError
from dualcam.fmi.fmu import Fmu, RepeatedStart
from dualcam.identification.motion import MeasuredMotion
from dualcam.identification.unknowns import ANGLE_OFFSET, ELASTIC, TORQUE_OFFSET, Unknown

ANGLE_MARGIN = 2.0  # standard deviations of the angle's noise by which a measured angle at rest may be off
BEYOND = 0.02  # of the range of theta: as far a measured angle may be beyond a stop


class TorqueModel:
    """Torque of the FMU at the samples of a motion.

    Where the cam slips, the motion determines the torque. At rest, and so near to a reversal that the
    direction is not known, any torque of the stick band keeps the motion: the torque has two limits.

    `force`: axial force on the follower [N], shape (n,). `unknowns`: whose values `limits` takes, shape (p,).
    IdentificationError: the angle leaves the range between the stops, or the design has an elastic shaft.
    """

    def __init__(
        self, design: DesignFile, motion: MeasuredMotion, force: Array, unknowns: Sequence[Unknown]
    ) -> None:
        if design.value(ELASTIC):
            raise IdentificationError(
                f"{ELASTIC} = {design.value(ELASTIC):g} N.m/rad: allowed is a rigid shaft, {ELASTIC} = 0."
                " Take the twist of the shaft, torque over stiffness, from the angle of the recording"
            )
        self.lower, self.upper = (float(design.value(f"stop.{end}")) for end in ("lower", "upper"))
        _check_range(motion, self.lower, self.upper, design)
        self.motion, self.force = motion, force
        self._names = [unknown.name for unknown in unknowns]
        self._sizes = [len(unknown.keys) for unknown in unknowns]
        keys = [key for unknown in unknowns for key in unknown.keys]
        self._fmu = Fmu("inverse")
        start = design.parameters_for("inverse") | {"ledger": False}
        with units_checked_before():
            self._runs = RepeatedStart(self._fmu, start, keys)
        self._inputs = self._fmu.reals("theta", "omega", "alpha", "F_ext")
        self._torque = self._fmu.reals("tau")
        self._torques = self._fmu.reals("tau", "torque_release", "torque_load")
        self._speeds = self._fmu.reals("cam1.sliding_speed", "cam2.sliding_speed")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self._fmu.close()

    def limits(self, values: Array, shift: float = 0.0) -> tuple[Array, Array]:
        """The least and the largest torque at each sample [N.m], alike where the cam slips. `shift`: of all
        angles [rad]."""
        rows, offset = self._started(values, shift)
        motion = self.motion
        low, high = np.empty(len(rows)), np.empty(len(rows))
        inputs, torque = self._inputs, self._torque
        buffer = inputs.values
        for k, (row, direction) in enumerate(zip(rows.tolist(), motion.direction.tolist(), strict=True)):
            if direction:
                buffer[:] = row
                inputs.write()
                low[k] = high[k] = torque.read()[0]
            else:
                low[k], high[k] = self._band(row)
        return low + offset, high + offset

    def sliding_speeds(self, values: Array) -> Array:
        """Sliding speed of both contacts at each sample [m/s], shape (n, 2)."""
        rows, _ = self._started(values)
        found = np.empty((len(rows), 2))
        for k, row in enumerate(rows.tolist()):
            self._inputs.values[:] = row
            self._inputs.write()
            found[k] = self._speeds.read()
        return found

    def _started(self, values: Array, shift: float = 0.0) -> tuple[Array, float]:
        """Begins a run; the FMU's inputs at each sample, and the zero error of the torque."""
        given = dict(zip(self._names, values.tolist(), strict=True))
        self._runs.start(np.repeat(values, self._sizes).tolist())
        theta = np.clip(self.motion.theta + shift - given.get(ANGLE_OFFSET, 0.0), self.lower, self.upper)
        rows = np.column_stack([theta, self.motion.omega, self.motion.alpha, self.force])
        return rows, given.get(TORQUE_OFFSET, 0.0)

    def _band(self, row: list[float]) -> tuple[float, float]:
        """Limits of the torque at rest: the stick band, and slow slip in both directions, which is as likely.
        There is none beyond a stop, which carries the torque."""
        theta, omega, alpha, force = row
        slack = ANGLE_MARGIN * self.motion.theta_noise
        if theta - slack <= self.lower or theta + slack >= self.upper:
            return -math.inf, math.inf
        speed = max(abs(omega), self.motion.slowest)
        inputs = self._inputs
        buffer = inputs.values
        buffer[:] = theta, speed, alpha, force
        inputs.write()
        loading, release, load = self._torques.read()
        buffer[1] = -speed
        inputs.write()
        (releasing,) = self._torque.read()
        return min(loading, releasing, release, load), max(loading, releasing, release, load)


def _check_range(motion: MeasuredMotion, lower: float, upper: float, design: DesignFile) -> None:
    """IdentificationError for angles that the design does not have."""
    least, greatest = float(motion.theta.min()), float(motion.theta.max())
    slack = BEYOND * (upper - lower)
    if lower - slack <= least and greatest <= upper + slack:
        return
    hint = "Give the angle from the zero of the design"
    if greatest - least > 10.0 * (upper - lower):
        hint = "Is the angle in degrees? Then name the column theta_deg"
    raise IdentificationError(
        f"the recording has angles from {least:.4g} to {greatest:.4g} rad, and the stops of"
        f" {design.path.name} are at stop.lower = {lower:g} rad and stop.upper = {upper:g} rad: allowed are"
        f" angles between the stops. {hint}"
    )
