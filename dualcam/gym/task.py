"""What a task is: a mechanism with a motor, a load that is drawn anew for each episode, and a cost.

All values of a task are arrays with one entry per instance, shape (count,).
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array
from dualcam.errors import TaskError
from dualcam.systems.blocks.axis import CamGear
from dualcam.systems.blocks.motor import Motor

OVERSHOOT = 1.05  # of the peak torque: room for rounding, and for the current after a limit of the voltage
Scene = dict[str, Array]
Range = tuple[float, float]


class Quantity(NamedTuple):
    """One entry of an observation.

    `name` of the quantity. `unit`: its unit; 1 where there is none. `low`, `high`: bounds of its values, in
    the unit.
    """

    name: str
    unit: str
    low: float
    high: float


def torque_entry(motor: Motor) -> Quantity:
    """The torque of a `motor` as an entry of an observation, bounded by the peak torque and OVERSHOOT."""
    bound = OVERSHOOT * motor.peak_torque
    return Quantity("torque", "N.m", -bound, bound)


class Motion(NamedTuple):
    """The axis and its motor at the end of a step, arrays of shape (count,)."""

    angle: Array  # of the axis [rad]
    speed: Array  # of the axis [rad/s]
    torque: Array  # torque of the motor, mean of the last control period [N.m]
    period: NDArray[np.int64]  # control periods since the begin of the episode


@dataclass(frozen=True)
class Task(ABC):
    """A mechanism with a motor, its random loads, and the cost of an episode.

    `energy_weight`: cost of energy drawn from the supply [1]. `error_weight`: cost of the squared error of
    the angle over time [J/(rad2.s)]. `impact_weight`: cost of heat at the end stops [1].
    """

    energy_weight: float = 1.0
    error_weight: float = 100.0
    impact_weight: float = 10.0

    motor: ClassVar[Motor]
    gear: ClassVar[CamGear]
    periods: ClassVar[int]  # control periods in a step of the task
    draws: ClassVar[int]  # numbers drawn per episode
    told: ClassVar[tuple[str, ...]]  # what of a scene the infos of a reset tell; the policy does not see it

    def __post_init__(self) -> None:
        for name in ("energy_weight", "error_weight", "impact_weight"):
            weight = getattr(self, name)
            if not (isinstance(weight, int | float) and math.isfinite(weight) and weight >= 0.0):
                raise TaskError(f"{name} = {weight!r}: allowed is a finite number >= 0")

    @property
    @abstractmethod
    def observations(self) -> tuple[Quantity, ...]:
        """The entries of an observation."""

    @abstractmethod
    def parameters(self) -> dict[str, float | int]:
        """Start values of the FMU that are the same in all episodes, by name, in SI units."""

    @abstractmethod
    def draw(self, numbers: Array) -> Scene:
        """Begin episodes. Returns what they differ in by name, shape (count,); "start" is the axis' angle
        [rad].

        `numbers`: random numbers, uniform over [0, 1), shape (count, draws).
        """

    @abstractmethod
    def start_values(self, scene: Scene) -> dict[str, Array]:
        """Start values of the FMU by name, shape (count,), that follow from the `scene`, but the angle."""

    @abstractmethod
    def load_torque(self, scene: Scene, angle: Array, period: NDArray[np.int64]) -> Array:
        """The torque of the load on the axis [N.m], + along the angle, shape (count,), in a `scene` of
        `draw`.

        `angle` of the axis in the middle of the control period [rad], shape (count,). `period`: number of the
        control period, from 0, shape (count,).
        """

    @abstractmethod
    def wanted(self, scene: Scene, period: NDArray[np.int64]) -> Array:
        """The angle that the axis should have [rad], shape (count,), in a `scene` of `draw`.

        `period`: control periods since the begin of the episode, shape (count,).
        """

    @abstractmethod
    def observe(self, scene: Scene, motion: Motion) -> Array:
        """What a policy sees of `scene` and `motion`: the `observations` in order, shape (count, entries)."""

    def is_over(self, scene: Scene, period: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the task has come to its own end in a `scene` of `draw`, shape (count,). Default: never.

        `period`: control periods since the begin of the episode, shape (count,).
        """
        return np.zeros(len(period), bool)


class MoveTask(Task):
    """A task in which the axis moves from a drawn angle to the drawn angle "target", and rests there."""

    def wanted(self, scene: Scene, period: NDArray[np.int64]) -> Array:
        return scene["target"]

    def observe(self, scene: Scene, motion: Motion) -> Array:
        return np.column_stack([motion.angle, motion.speed, scene["target"], motion.torque])


def spread(number: Array, over: Range) -> Array:
    """A random number, uniform over a range, of a `number` from [0, 1)."""
    return over[0] + (over[1] - over[0]) * number


def check_range(name: str, over: object, least: float, most: float, unit: str) -> None:
    """Refuse with a TaskError what is no range of a random value from `least` to `most`."""
    allowed = f"(low, high) with {least:g} <= low <= high <= {most:g} {unit}".rstrip()
    ends = list(over) if isinstance(over, tuple | list) else []
    are_numbers = all(isinstance(end, int | float) and not isinstance(end, bool) for end in ends)
    if len(ends) != 2 or not are_numbers or not least <= ends[0] <= ends[1] <= most:  # also where one is NaN
        raise TaskError(f"{name} = {over!r}: allowed is {allowed}")


def highest_speed(torque: float, travel: float, inertia: float) -> float:
    """A speed [rad/s] that an axis between two end stops cannot exceed: it turns back at zero speed, so all
    energy comes from one way of `travel` [rad] under at most `torque` [N.m]. `inertia`: the least [kg.m2]."""
    return math.sqrt(2.0 * torque * travel / inertia)
