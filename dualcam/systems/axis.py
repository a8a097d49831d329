"""The forward FMU as a motor-driven axis: a closed loop of controller, current loop, load and cam.

    with Fmu("forward") as fmu:
        axis = CamAxis(fmu)
        axis.start({"inertia.shaft": 0.2, **cam.parameters()}, angle=0.1)
        record = simulate_closed_loop(axis, load, controller, CurrentLoop(motor), motion.sample(time))

The result is a `Record` of the motor and of the cam over time.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from dualcam.design.statics import Array
from dualcam.fmu import Fmu, Scalar
from dualcam.systems.current_loop import CurrentLoop, MotorPeriod

LEDGER = ("work_in", "spring", "kinetic", "heat_cam1", "heat_cam2", "heat_damper", "heat_stop", "residual")


class Load(Protocol):
    """A load by its angle."""

    def torque(self, theta: float, /) -> float:
        """Torque [N.m] at theta [rad], + in the direction of theta."""
        ...


class Controller(Protocol):
    """A controller that follows a reference motion."""

    def torque(
        self,
        angle: float,
        speed: float,
        reference: tuple[float, float],
        next_reference: tuple[float, float],
        /,
    ) -> float:
        """Motor torque [N.m] for the coming period, from the state [rad, rad/s] and the planned (angle,
        speed) at the beginning and at the end of the period."""
        ...


class CamAxis:
    """The forward FMU as an axis with its own angle: theta = ratio (angle - offset).

    A torque on the axis acts as tau = torque/ratio on the cam. With ratio < 0 the cam turns against the axis.
    """

    def __init__(self, fmu: Fmu, ratio: float = 1.0, offset: float = 0.0) -> None:
        """`ratio`: angle of the cam over that of the axis; `offset` [rad]: the axis' angle at theta = 0."""
        self.fmu, self.ratio, self.offset = fmu, ratio, offset
        self._tau = fmu.reals("tau")
        self._state = fmu.reals("theta", "omega")
        self._alpha = fmu.reals("alpha")
        self._ledger = fmu.reals(*(f"energy.{name}" for name in LEDGER))
        self.angle = self.speed = 0.0  # rad, rad/s, of the axis

    def start(self, parameters: Mapping[str, Scalar], angle: float, speed: float = 0.0) -> None:
        """Begin a run at this angle [rad] and speed [rad/s] of the axis, with these start values of the FMU.
        FmuError if the FMU refuses a value."""
        state = {"initial.theta": self.ratio * (angle - self.offset)}
        if speed != 0.0:
            state["initial.omega"] = self.ratio * speed
        self.fmu.start({**parameters, **state})
        self._read_state()

    def step(self, torque: float, load: Load, size: float) -> float:
        """Advance by `size` [s] under `torque` [N.m] on the axis and the load; returns the load's torque.

        Both torques are held over the step, the load's at the angle that the axis reaches at half of it.
        """
        load_torque = load.torque(self.angle + 0.5 * size * self.speed)
        self.set_torque(torque + load_torque)
        self.advance(size)
        return load_torque

    def set_torque(self, torque: float) -> None:
        """Set the torque on the axis [N.m] from now on."""
        self._tau.values[0] = torque / self.ratio
        self._tau.write()

    def acceleration(self) -> float:
        """Angular acceleration of the axis [rad/s2] now."""
        return self._alpha.read()[0] / self.ratio

    def advance(self, size: float, derivatives: tuple[float, ...] = ()) -> None:
        """Advance by `size` [s]. The torque is a polynomial of time with these first, second (and third) time
        derivatives [N.m/s, N.m/s2, N.m/s3] at the beginning of the step; none: the torque is held."""
        for order, derivative in enumerate(derivatives, start=1):
            self._tau.write_derivatives(order, [derivative / self.ratio])
        self.fmu.step(size)
        self._read_state()

    def ledger(self) -> Array:
        """The FMU's energy accounts since the start [J] in the order of LEDGER, shape (8,); valid until the
        next call."""
        self._ledger.read()
        return self._ledger.values

    def largest_pin_force(self) -> float:
        """Largest normal force at one pin of cam 1 since the start [N]."""
        return self.fmu.real("peak.reaction1")

    def _read_state(self) -> None:
        theta, omega = self._state.read()
        self.angle, self.speed = self.offset + theta / self.ratio, omega / self.ratio


@dataclass(frozen=True)
class Record:
    """A run of the closed loop. Arrays have shape (n,), one entry per control period: states and ledger at
    its end, all else over the period."""

    period: float  # s
    time: Array  # s
    reference: Array  # rad, planned angle
    angle: Array  # rad
    speed: Array  # rad/s
    command: Array  # N.m, asked of the motor
    motor_torque: Array  # N.m, mean
    peak_torque: Array  # N.m, largest magnitude
    motor_heat: Array  # J
    supply_energy: Array  # J
    motor_work: Array  # J, done on the axis
    load_work: Array  # J, done on the axis
    ledger: dict[str, Array]  # J, the FMU's energy accounts since the start
    wall_time: float  # s of computing time for the loop

    def last(self, duration: float) -> Record:
        """The last `duration` [s] of the run, with accounts since the beginning of that time."""
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


class Recorder:
    """Collects a Record period by period."""

    def __init__(self, periods: int, period: float) -> None:
        self._period = period
        self._rows = np.empty((periods, 9))
        self._ledger = np.empty((periods, len(LEDGER)))
        self._count = 0
        self._begin = clock.perf_counter()

    def add(
        self, axis: CamAxis, command: float, motor: MotorPeriod, load_torque: float, before: float
    ) -> None:
        """One period: the axis at its end, and its angle [rad] before."""
        advance = axis.angle - before
        self._rows[self._count] = (
            axis.angle,
            axis.speed,
            command,
            motor.torque,
            motor.peak_torque,
            motor.heat,
            motor.energy,
            motor.torque * advance,
            load_torque * advance,
        )
        self._ledger[self._count] = axis.ledger()
        self._count += 1

    def record(self, reference: Array) -> Record:
        """The run, with the planned angle [rad] at the ends of the periods, shape (n,)."""
        wall_time = clock.perf_counter() - self._begin
        return Record(
            period=self._period,
            time=self._period * np.arange(1, self._count + 1, dtype=float),
            reference=reference,
            angle=self._rows[:, 0],
            speed=self._rows[:, 1],
            command=self._rows[:, 2],
            motor_torque=self._rows[:, 3],
            peak_torque=self._rows[:, 4],
            motor_heat=self._rows[:, 5],
            supply_energy=self._rows[:, 6],
            motor_work=self._rows[:, 7],
            load_work=self._rows[:, 8],
            ledger={name: self._ledger[:, i] for i, name in enumerate(LEDGER)},
            wall_time=wall_time,
        )


def simulate_closed_loop(
    axis: CamAxis,
    load: Load,
    controller: Controller,
    current_loop: CurrentLoop,
    reference: tuple[Array, Array],
    *,
    mean_speed: bool = False,
) -> Record:
    """Run the closed loop from the axis' present state along a reference motion.

    reference    angle [rad] and speed [rad/s] at the beginning of each control period and at the end of the
                 last one, shape (n + 1,) each
    mean_speed   the current loop gets the measured speed plus half the planned change, the period's mean.
                 With the measured speed alone, energies from the supply are off by O(period).

    FmuError where the FMU refuses a step.
    """
    angles, speeds = reference
    planned = list(zip(angles.tolist(), speeds.tolist(), strict=True))
    period = current_loop.control_period
    recorder = Recorder(len(planned) - 1, period)
    for now, then in pairwise(planned):
        angle, speed = axis.angle, axis.speed
        command = controller.torque(angle, speed, now, then)
        motor = current_loop.run(command, speed + 0.5 * (then[1] - now[1]) if mean_speed else speed)
        load_torque = axis.step(motor.torque, load, period)
        recorder.add(axis, command, motor, load_torque, angle)
    return recorder.record(angles[1:])
