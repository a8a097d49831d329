"""The forward FMU as a motor-driven axis: a closed loop of controller, current loop, load and cam.

    with Fmu("forward") as fmu:
        axis = CamAxis(fmu)
        axis.start({"inertia.shaft": 0.2, **cam.parameters()}, angle=0.1)
        record = simulate_closed_loop(axis, load, controller, CurrentLoop(motor), motion.sample(time))

The result is a `Record` of the motor and of the cam over time.
"""

import time as clock
from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

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
        """The torque of the load [N.m], + in the direction of theta. `theta`: angle of the axis [rad]."""
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
        """The torque of the motor at the output [N.m] for the coming period.

        `angle`, `speed`: measured state [rad, rad/s]. `reference`, `next_reference`: planned angle [rad] and
        speed [rad/s] at the beginning and at the end of the period.
        """
        ...


class CamGear(NamedTuple):
    """How an axis drives the cam: theta = ratio (angle - offset), tau = torque/ratio.

    With ratio < 0 the cam turns against the axis. All methods take one float or an array. `ratio`: angle of
    the cam over that of the axis [1], not 0. `offset`: angle of the axis at theta = 0 [rad].

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
        """The angle theta of the cam [rad] at an `angle` of the axis [rad]."""
        return self.ratio * (angle - self.offset)

    def cam_torque(self, torque: Number) -> Number:
        """The torque tau on the cam [N.m] of a `torque` on the axis [N.m]."""
        return torque / self.ratio

    def angle(self, theta: Number) -> Number:
        """The angle of the axis [rad] at an angle `theta` of the cam [rad]."""
        return self.offset + theta / self.ratio


@also_called(size="step")
def angle_amid(angle: Number, speed: Number, step: float) -> Number:
    """The angle [rad] at half of a step, at which a load acts that is held over the step.

    `angle`, `speed`: state at the beginning of the step [rad, rad/s]. `step`: length of the step [s].
    """
    return angle + 0.5 * step * speed


class CamAxis:
    """The forward FMU as an axis with its own angle: theta = ratio (angle - offset).

    A torque on the axis acts as tau = torque/ratio on the cam. With ratio < 0 the cam turns against the axis.
    `fmu`: the forward FMU. `ratio`: angle of the cam over that of the axis [1], not 0. `offset`: angle of the
    axis at theta = 0 [rad].

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

        `parameters`: start values of the FMU. `angle`, `speed`: state of the axis [rad, rad/s]. FmuError: the
        FMU refuses a value.
        """
        state = {"initial.theta": self.gear.cam_angle(angle)}
        if speed != 0.0:
            state["initial.omega"] = self.gear.ratio * speed
        self.fmu.start({**parameters, **state})
        self._read_state()

    @also_called(size="step")
    def step(self, torque: float, load: Load, step: float) -> float:
        """Advance by a step under the motor's torque and the load. Returns the torque of the load [N.m].

        Both torques are held over the step, the load's at the angle that the axis reaches at half of the
        step. `torque` of the motor on the axis [N.m]. `load` on the axis. `step`: length of the step [s].
        FmuError: the FMU refuses the step.
        """
        load_torque = load.torque(angle_amid(self.angle, self.speed, step))
        self.set_torque(torque + load_torque)
        self.advance(step)
        return load_torque

    def set_torque(self, torque: float) -> None:
        """Set the `torque` on the axis [N.m] from now on."""
        self._tau.values[0] = self.gear.cam_torque(torque)
        self._tau.write()

    def acceleration(self) -> float:
        """The angular acceleration of the axis now [rad/s2]."""
        return self._alpha.read()[0] / self.gear.ratio

    @also_called(size="step")
    def advance(self, step: float, derivatives: tuple[float, ...] = ()) -> None:
        """Advance by a step. The torque is held, or a polynomial of time.

        `step`: length of the step [s]. `derivatives`: first, second and third time derivative of the torque
        at the beginning of the step [N.m/s, N.m/s2, N.m/s3], as many as there are. Empty: the torque is held.
        FmuError: the FMU refuses the step.
        """
        for order, derivative in enumerate(derivatives, start=1):
            self._tau.write_derivatives(order, [self.gear.cam_torque(derivative)])
        self.fmu.step(step)
        self._read_state()

    def ledger(self) -> Array:
        """The FMU's energy accounts since the start [J], in LEDGER's order; valid until the next call."""
        self._ledger.read()
        return self._ledger.values

    def largest_pin_force(self) -> float:
        """The largest normal force at one pin of cam 1 since the start [N]."""
        return self.fmu.real("peak.reaction1")

    def _read_state(self) -> None:
        theta, omega = self._state.read()
        self.angle, self.speed = self.gear.angle(theta), omega / self.gear.ratio


class Recorder:
    """Collects a Record period by period.

    `periods`: number of control periods of the run. `period`: control period [s].
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

        `axis`: the axis at the end of the period. `command`: torque asked of the motor [N.m]. `motor`: what
        the motor did. `load_torque`: torque of the load [N.m]. `before`: angle of the axis at the beginning
        of the period [rad].
        """
        advance = axis.angle - before
        self._rows[self._count] = (  # in the order of the fields of Record
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
        """The run so far. `reference`: planned angle at the ends of the periods [rad], shape (n,)."""
        wall_time = clock.perf_counter() - self._begin
        time = self._period * np.arange(1, self._count + 1, dtype=float)
        rest: list[Any] = [*self._rows.T, dict(zip(LEDGER, self._ledger.T, strict=True)), wall_time]
        return Record(self._period, time, reference, *rest)


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
    axis : The axis, started.
    load : The load on the axis.
    controller : Is asked once per control period.
    current_loop : The motor under its current loop; gives the control period.
    reference
        Angle [rad] and speed [rad/s] at the beginning of each control period and at the end of the last one,
        shape (n + 1,) each.
    mean_speed
        Whether the current loop gets the measured speed plus half the planned change, the mean of the period.
        With the measured speed alone, energies from the supply are off by O(period).

    Returns
    -------
    One entry per control period.

    Raises
    ------
    FmuError : The FMU refuses a step.

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
