"""The record of a motor-driven axis in a closed loop: motor, load and cam over time."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from dualcam.design.statics import Array

LEDGER = ("work_in", "spring", "kinetic", "heat_cam1", "heat_cam2", "heat_damper", "heat_stop", "residual")


@dataclass(frozen=True)
class Record:
    """A run of the closed loop, one entry per control period.

    States and ledger are those at the end of the period, all else is over the period.

    Attributes
    ----------
    period : Control period [s].
    time : Time at the end of the period [s], shape (n,).
    reference : Planned angle [rad], shape (n,).
    angle : Angle [rad], shape (n,).
    speed : Speed [rad/s], shape (n,).
    command : Torque asked of the motor [N.m], shape (n,).
    motor_torque : Torque of the motor, mean of the period [N.m], shape (n,).
    peak_torque : Torque of the motor, largest magnitude [N.m], shape (n,).
    motor_heat : Heat in the motor's winding [J], shape (n,).
    supply_energy : Energy from the supply [J], shape (n,).
    motor_work : Work of the motor on the axis [J], shape (n,).
    load_work : Work of the load on the axis [J], shape (n,).
    ledger : The FMU's energy accounts since the start [J], shape (n,).
    wall_time : Computing time of the loop [s].
    """

    period: float
    time: Array
    reference: Array
    angle: Array
    speed: Array
    command: Array
    motor_torque: Array
    peak_torque: Array
    motor_heat: Array
    supply_energy: Array
    motor_work: Array
    load_work: Array
    ledger: dict[str, Array]
    wall_time: float

    def last(self, duration: float) -> Record:
        """The last `duration` [s] of the run, with accounts since then; the whole run if it is shorter."""
        begin = len(self.time) - round(duration / self.period)
        if begin <= 0:
            return self
        arrays = {f.name: getattr(self, f.name) for f in fields(self)}
        cut: dict[str, Any] = {
            name: values[begin:] for name, values in arrays.items() if isinstance(values, np.ndarray)
        }
        ledger = {name: values[begin:] - values[begin - 1] for name, values in self.ledger.items()}
        return replace(self, **cut, ledger=ledger)

    @property
    def error(self) -> Array:
        """Tracking error [rad], shape (n,)."""
        return self.angle - self.reference

    @property
    def rms_error(self) -> float:
        """RMS tracking error [rad]."""
        return math.sqrt(float(np.mean(self.error**2)))

    @property
    def max_error(self) -> float:
        """Largest tracking error [rad]."""
        return float(np.max(np.abs(self.error)))

    @property
    def heat(self) -> float:
        """Heat in the motor's winding [J]."""
        return float(np.sum(self.motor_heat))

    @property
    def net_energy(self) -> float:
        """Energy from the supply, energy that the motor gives back deducted [J]."""
        return float(np.sum(self.supply_energy))

    @property
    def largest_torque(self) -> float:
        """Largest torque of the motor at the output [N.m]."""
        return float(np.max(self.peak_torque))

    @property
    def friction_heat(self) -> float:
        """Friction heat of both contacts [J]."""
        return float(self.ledger["heat_cam1"][-1] + self.ledger["heat_cam2"][-1])

    @property
    def cam_heat(self) -> float:
        """Heat in contacts and damper [J]."""
        return self.friction_heat + float(self.ledger["heat_damper"][-1])

    @property
    def transferred_energy(self) -> float:
        """Energy through cam 2 in either direction [J]: the scale of the ledger's residual."""
        return float(np.sum(np.abs(self.motor_work)) + np.sum(np.abs(self.load_work)))
