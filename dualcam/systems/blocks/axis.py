"""The forward FMU as a motor-driven axis: a closed loop of controller, current loop, load and cam.

    with Fmu("forward") as fmu:
        axis = CamAxis(fmu)
        axis.start({"inertia.shaft": 0.2, **cam.parameters()}, angle=0.1)
        record = simulate_closed_loop(axis, load, controller, CurrentLoop(motor), motion.sample(time))

The result is a `Record` of the motor and of the cam over time.
"""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from dualcam.common.moved import also_called, old_names
from dualcam.design.statics import Array
from dualcam.fmi.fmu import Fmu, Scalar
from dualcam.systems.blocks.current_loop import CurrentLoop, MotorPeriod
from dualcam.systems.blocks.elementwise import Number
from dualcam.systems.blocks.record import LEDGER, Record


class Load(Protocol):
    """A load by its angle."""

    def torque(self, theta: float, /) -> float:
        """The torque of the load.

        Parameters
        ----------
        theta : float
            Angle of the axis [rad].

        Returns
        -------
        float
            Torque [N.m], + in the direction of theta.
        """
        ...


class AxisController(Protocol):
    """A controller that follows a reference motion."""

    def torque(
        self,
        angle: float,
        speed: float,
        reference: tuple[float, float],
        next_reference: tuple[float, float],
        /,
    ) -> float:
        """The motor's torque for the coming period.

        Parameters
        ----------
        angle, speed : float
            Measured state [rad, rad/s].
        reference : tuple of float
            Planned angle [rad] and speed [rad/s] at the beginning of the period.
        next_reference : tuple of float
            Planned angle and speed at the end of the period.

        Returns
        -------
        float
            Torque of the motor at the output [N.m].
        """
        ...


class CamGear(NamedTuple):
    """How an axis drives the cam: theta = ratio (angle - offset), tau = torque/ratio.

    With ratio < 0 the cam turns against the axis. All methods take one float or an array.

    Parameters
    ----------
    ratio : float
        Angle of the cam over that of the axis [1], not 0.
    offset : float
        Angle of the axis at theta = 0 [rad].

    Examples
    --------
    >>> from dualcam.systems.blocks.axis import CamGear
    >>> gear = CamGear(ratio=2.0, offset=0.5)
    >>> gear.cam_angle(0.75), gear.angle(0.5), gear.cam_torque(3.0)
    (0.5, 0.75, 1.5)
    """

    ratio: float = 1.0
    offset: float = 0.0

    def cam_angle(self, angle: Number) -> Number:
        """The angle of the cam.

        Parameters
        ----------
        angle : float or ndarray
            Angle of the axis [rad].

        Returns
        -------
        float or ndarray
            theta [rad].
        """
        return self.ratio * (angle - self.offset)

    def cam_torque(self, torque: Number) -> Number:
        """The torque on the cam.

        Parameters
        ----------
        torque : float or ndarray
            Torque on the axis [N.m].

        Returns
        -------
        float or ndarray
            tau [N.m].
        """
        return torque / self.ratio

    def angle(self, theta: Number) -> Number:
        """The angle of the axis.

        Parameters
        ----------
        theta : float or ndarray
            Angle of the cam [rad].

        Returns
        -------
        float or ndarray
            Angle [rad].
        """
        return self.offset + theta / self.ratio


def angle_amid(angle: Number, speed: Number, step: float) -> Number:
    """The angle at half of a step, at which a load acts that is held over the step.

    Parameters
    ----------
    angle, speed : float or ndarray
        State at the beginning of the step [rad, rad/s].
    step : float
        Length of the step [s].

    Returns
    -------
    float or ndarray
        Angle [rad].

    Examples
    --------
    >>> from dualcam.systems.blocks.axis import angle_amid
    >>> angle_amid(0.5, 2.0, 0.25)
    0.75
    """
    return angle + 0.5 * step * speed


class CamAxis:
    """The forward FMU as an axis with its own angle: theta = ratio (angle - offset).

    A torque on the axis acts as tau = torque/ratio on the cam. With ratio < 0 the cam turns against the axis.

    Parameters
    ----------
    fmu : Fmu
        The forward FMU.
    ratio : float
        Angle of the cam over that of the axis [1], not 0.
    offset : float
        Angle of the axis at theta = 0 [rad].

    Examples
    --------
    >>> from dualcam import Fmu
    >>> from dualcam.systems.blocks.axis import CamAxis
    >>> with Fmu("forward") as fmu:
    ...     axis = CamAxis(fmu, ratio=2.0)
    ...     axis.start({}, angle=0.1)
    ...     axis.set_torque(20.0)
    ...     axis.advance(0.01)
    ...     print(f"{axis.angle:.4f} rad, {axis.speed:.3f} rad/s")
    0.1974 rad, 18.941 rad/s
    """

    def __init__(self, fmu: Fmu, ratio: float = 1.0, offset: float = 0.0) -> None:
        self.fmu, self.gear = fmu, CamGear(ratio, offset)
        self._tau = fmu.reals("tau")
        self._state = fmu.reals("theta", "omega")
        self._alpha = fmu.reals("alpha")
        self._ledger = fmu.reals(*(f"energy.{name}" for name in LEDGER))
        self.angle = self.speed = 0.0  # rad, rad/s, of the axis

    def start(self, parameters: Mapping[str, Scalar], angle: float, speed: float = 0.0) -> None:
        """Begin a run.

        Parameters
        ----------
        parameters : mapping of str to float, int, bool or str
            Start values of the FMU.
        angle, speed : float
            State of the axis [rad, rad/s].

        Raises
        ------
        FmuError
            The FMU refuses a value.
        """
        state = {"initial.theta": self.gear.cam_angle(angle)}
        if speed != 0.0:
            state["initial.omega"] = self.gear.ratio * speed
        self.fmu.start({**parameters, **state})
        self._read_state()

    @also_called(size="step")
    def step(self, torque: float, load: Load, step: float) -> float:
        """Advance by a step under the motor's torque and the load.

        Both torques are held over the step, the load's at the angle that the axis reaches at half of the
        step.

        Parameters
        ----------
        torque : float
            Torque of the motor on the axis [N.m].
        load : Load
            The load on the axis.
        step : float
            Length of the step [s].

        Returns
        -------
        float
            Torque of the load [N.m].

        Raises
        ------
        FmuError
            The FMU refuses the step.
        """
        load_torque = load.torque(angle_amid(self.angle, self.speed, step))
        self.set_torque(torque + load_torque)
        self.advance(step)
        return load_torque

    def set_torque(self, torque: float) -> None:
        """Set the torque on the axis from now on.

        Parameters
        ----------
        torque : float
            Torque [N.m].
        """
        self._tau.values[0] = self.gear.cam_torque(torque)
        self._tau.write()

    def acceleration(self) -> float:
        """The angular acceleration of the axis now.

        Returns
        -------
        float
            Acceleration [rad/s2].
        """
        return self._alpha.read()[0] / self.gear.ratio

    @also_called(size="step")
    def advance(self, step: float, derivatives: tuple[float, ...] = ()) -> None:
        """Advance by a step. The torque is held, or a polynomial of time.

        Parameters
        ----------
        step : float
            Length of the step [s].
        derivatives : tuple of float
            First, second and third time derivative of the torque at the beginning of the step [N.m/s, N.m/s2,
            N.m/s3], as many as there are. Empty: the torque is held.

        Raises
        ------
        FmuError
            The FMU refuses the step.
        """
        for order, derivative in enumerate(derivatives, start=1):
            self._tau.write_derivatives(order, [self.gear.cam_torque(derivative)])
        self.fmu.step(step)
        self._read_state()

    def ledger(self) -> Array:
        """The FMU's energy accounts since the start.

        Returns
        -------
        ndarray, shape (8,)
            Accounts [J] in the order of LEDGER; valid until the next call.
        """
        self._ledger.read()
        return self._ledger.values

    def largest_pin_force(self) -> float:
        """The largest normal force at one pin of cam 1 since the start.

        Returns
        -------
        float
            Force [N].
        """
        return self.fmu.real("peak.reaction1")

    def _read_state(self) -> None:
        theta, omega = self._state.read()
        self.angle, self.speed = self.gear.angle(theta), omega / self.gear.ratio


class Recorder:
    """Collects a Record period by period.

    Parameters
    ----------
    periods : int
        Number of control periods of the run.
    period : float
        Control period [s].
    """

    def __init__(self, periods: int, period: float) -> None:
        self._period = period
        self._rows = np.empty((periods, 9))
        self._ledger = np.empty((periods, len(LEDGER)))
        self._count = 0
        self._begin = clock.perf_counter()

    def add(
        self, axis: CamAxis, command: float, motor: MotorPeriod, load_torque: float, before: float
    ) -> None:
        """Add a period.

        Parameters
        ----------
        axis : CamAxis
            The axis at the end of the period.
        command : float
            Torque asked of the motor [N.m].
        motor : MotorPeriod
            What the motor did.
        load_torque : float
            Torque of the load [N.m].
        before : float
            Angle of the axis at the beginning of the period [rad].
        """
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
        """The run so far.

        Parameters
        ----------
        reference : ndarray, shape (n,)
            Planned angle at the ends of the periods [rad].

        Returns
        -------
        Record
            One entry per period.
        """
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
    controller: AxisController,
    current_loop: CurrentLoop,
    reference: tuple[Array, Array],
    *,
    mean_speed: bool = False,
) -> Record:
    """Run the closed loop from the axis' present state along a reference motion.

    Parameters
    ----------
    axis : CamAxis
        The axis, started.
    load : Load
        The load on the axis.
    controller : AxisController
        Is asked once per control period.
    current_loop : CurrentLoop
        The motor under its current loop; gives the control period.
    reference : tuple of two ndarray, shape (n + 1,) each
        Angle [rad] and speed [rad/s] at the beginning of each control period and at the end of the last one.
    mean_speed : bool
        Whether the current loop gets the measured speed plus half the planned change, the mean of the period.
        With the measured speed alone, energies from the supply are off by O(period).

    Returns
    -------
    Record
        One entry per control period.

    Raises
    ------
    FmuError
        The FMU refuses a step.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam import Fmu
    >>> from dualcam.systems.machines import elbow
    >>> from dualcam.systems.blocks.axis import CamAxis, simulate_closed_loop
    >>> from dualcam.systems.blocks.current_loop import CurrentLoop
    >>> cam, angles, speeds = elbow.design_cam(), *elbow.reference_motion()
    >>> with Fmu("forward") as fmu:
    ...     axis = CamAxis(fmu)
    ...     axis.start(elbow.plant_parameters(cam, 1.5), angle=float(angles[0]))
    ...     loop = CurrentLoop(elbow.AK80_6)
    ...     plan = angles[:2001], speeds[:2001]  # the first 2 s
    ...     record = simulate_closed_loop(axis, elbow.weight(1.5), elbow.controller(cam, 1.5), loop, plan)
    >>> record.max_error < 1e-3  # rad
    True
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


if not TYPE_CHECKING:  # type checkers report the old names
    __getattr__ = old_names(__name__, {"Controller": "AxisController"})
