"""Many episodes of a task at once, arrays in and out."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import Array, real_array
from dualcam.errors import FleetError, TaskError
from dualcam.fleet import Fleet
from dualcam.gym.task import Motion, Scene, Task
from dualcam.systems.blocks.axis import angle_amid
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD
from dualcam.systems.blocks.motor_bank import MotorBank

OUTPUTS = ("theta", "omega", "energy.heat_stop")


class Outcome(NamedTuple):
    """What a step of all instances brought, arrays of shape (count,).

    Parameters
    ----------
    reward : Minus the cost of the step [J].
    error : Wanted minus actual angle at the end of the step [rad].
    squared_error : Integral of the squared error over the step [rad2.s].
    energy_drawn : Energy from the supply, summed over the control periods in which the motor draws [J].
    energy_returned
        Energy to the supply, summed over the other control periods [J]. The reward does not count it.
    motor_heat : Heat in the motor's winding [J].
    impact : Heat at the end stops [J].
    is_over : Whether the task has come to its own end.
    """

    reward: Array
    error: Array
    squared_error: Array
    energy_drawn: Array
    energy_returned: Array
    motor_heat: Array
    impact: Array
    is_over: NDArray[np.bool_]


TERMS = Outcome._fields[1:-1]


class Batch:
    """Many episodes of a task, stepped by one call: torques in, observations out.

    Parameters
    ----------
    task : The task.
    count : Number of instances, > 0.
    threads : Threads of the fleet, 1 to 256.

    Attributes
    ----------
    fleet : The FMU's instances.
    scene : What the present episodes differ in, shape (count,) each.
    step_size : Length of a step [s].

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.gym import Batch, ElbowTask
    >>> random = np.random.default_rng(1)
    >>> with Batch(ElbowTask(), 100) as batch:
    ...     seen = batch.reset(random.random((100, batch.task.draws)))
    ...     for _ in range(10):
    ...         angle, speed, target, torque = seen.T
    ...         seen, outcome = batch.step(20.0 * (target - angle) - 2.0 * speed)  # N.m
    >>> seen.shape, outcome.energy_drawn.shape
    ((100, 4), (100,))
    """

    def __init__(self, task: Task, count: int, threads: int = 1) -> None:
        self.task = task
        self.fleet = Fleet("forward", count, outputs=OUTPUTS, parameters=task.parameters(), threads=threads)
        self.count = count
        self.step_size = task.periods * CONTROL_PERIOD
        self.scene: Scene = {}
        self.motors = MotorBank(task.motor, count)
        self._outputs = np.zeros((count, len(OUTPUTS)))
        self._motion = Motion(np.zeros(count), np.zeros(count), np.zeros(count), np.zeros(count, np.int64))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Free all instances. Any later call is an error."""
        self.fleet.close()

    def reset(self, numbers: ArrayLike, chosen: ArrayLike | None = None) -> Array:
        """Begin new episodes. Returns the observations of all instances, shape (count, entries).

        `numbers`: random numbers in [0, 1), shape (count, task.draws), of which only the rows of the chosen
        instances count. `chosen`: bool, which instances begin anew, shape (count,). Default: all. TaskError:
        a wrong argument: no instance begins anew.
        """
        given = real_array(numbers, "numbers", TaskError)
        if given.shape != (self.count, self.task.draws):
            raise TaskError(
                f"numbers has shape {given.shape}: allowed is {(self.count, self.task.draws)}, one row per"
                " instance"
            )
        which = np.ones(self.count, bool) if chosen is None else np.asarray(chosen)
        if which.shape != (self.count,) or which.dtype != bool:
            raise TaskError(f"chosen = {chosen!r}: allowed are {self.count} booleans")
        if not self.scene and not which.all():
            raise TaskError("the first reset begins all instances: leave `chosen` out")
        inside = (given >= 0.0) & (given < 1.0)
        if not inside[which].all():
            raise TaskError("numbers: allowed are finite numbers with 0 <= number < 1")
        drawn = self.task.draw(np.where(which[:, None], given, 0.0))
        self.scene = {
            name: np.where(which, value, self.scene.get(name, value)) for name, value in drawn.items()
        }
        self._begin(which)
        return self.task.observe(self.scene, self._motion)

    def _begin(self, which: NDArray[np.bool_]) -> None:
        """Begin the drawn scenes."""
        gear, start = self.task.gear, self.scene["start"]
        speed = self.scene.get("start_speed", np.zeros(self.count))
        values = self.task.start_values(self.scene)
        values |= {"initial.theta": gear.cam_angle(start), "initial.omega": gear.ratio * speed}
        self.fleet.reset(which, values)
        before = self._motion
        self._motion = Motion(
            np.where(which, start, before.angle),
            np.where(which, speed, before.speed),
            np.where(which, 0.0, before.torque),
            np.where(which, 0, before.period),
        )
        self._outputs[which, 2] = 0.0
        self.motors.stop(which)

    def step(self, torque: ArrayLike) -> tuple[Array, Outcome]:
        """One step of all instances. Returns observations, shape (count, entries), and the Outcome.

        `torque` asked of each motor, constant over the step [N.m], shape (count,). The motor's peak torque
        limits it. TaskError: before the first reset, a wrong shape, or a torque that is not finite: no
        instance made the step. FleetError: the FMU refuses the step of an instance. All instances must then
        be reset.
        """
        wanted = self._checked(torque)
        size = CONTROL_PERIOD
        squared, drawn, returned, heat = (np.zeros(self.count) for _ in range(4))
        stop_heat = self._outputs[:, 2].copy()
        for _ in range(self.task.periods):
            angle, speed, _, period = self._motion
            motor = self.motors.run(wanted, speed)
            load = self.task.load_torque(self.scene, angle_amid(angle, speed, size), period)
            self._step_fleet(self.task.gear.cam_torque(motor.torque + load))
            reached = self.task.gear.angle(self._outputs[:, 0])
            # The current loop takes the speed as constant. The motor's work is that on the real way.
            energy = motor.energy + motor.torque * (reached - angle - size * speed)
            drawn += np.maximum(energy, 0.0)
            returned += np.maximum(-energy, 0.0)
            heat += motor.heat
            self._motion = Motion(
                reached, self._outputs[:, 1] / self.task.gear.ratio, motor.torque, period + 1
            )
            error = self.task.wanted(self.scene, period + 1) - reached
            squared += size * error**2
        impact = self._outputs[:, 2] - stop_heat
        task = self.task
        cost = task.energy_weight * drawn + task.error_weight * squared + task.impact_weight * impact
        over = task.is_over(self.scene, self._motion.period)
        outcome = Outcome(-cost, error, squared, drawn, returned, heat, impact, over)
        return task.observe(self.scene, self._motion), outcome

    def _step_fleet(self, tau: Array) -> None:
        try:
            self.fleet.step(tau[:, None], CONTROL_PERIOD, self._outputs)
        except FleetError:
            self.scene = {}  # the step of the task is not complete: only a reset of all instances goes on
            raise

    def _checked(self, torque: ArrayLike) -> Array:
        if not self.scene:
            raise TaskError("no episode has begun: call reset first")
        wanted = real_array(torque, "torque", TaskError)
        if wanted.shape != (self.count,):
            raise TaskError(f"torque has shape {wanted.shape}: allowed is {(self.count,)}, one per instance")
        wrong = np.flatnonzero(~np.isfinite(wanted))
        if wrong.size:
            raise TaskError(
                f"torque of instance {wrong[0]} = {wanted[wrong[0]]}: allowed are finite numbers [N.m];"
                " no instance was stepped"
            )
        return wanted
