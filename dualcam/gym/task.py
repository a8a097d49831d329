"""What a task is: a mechanism with a motor, a load that is drawn anew for each episode, and a cost.

All values of a task are arrays with one entry per instance, shape (count,).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dualcam.errors import TaskError
from dualcam.fmi.reals import Array
from dualcam.systems.blocks.axis import CamGear
from dualcam.systems.blocks.motor import Motor

OVERSHOOT = 1.05  # of the peak torque: room for rounding, and for the current after a limit of the voltage
Scene = dict[str, Array]
Range = tuple[float, float]


class Quantity(NamedTuple):
    """One entry of an observation.

    Parameters
    ----------
    name : str
        Name of the quantity.
    unit : str
        Its unit; 1 where there is none.
    low, high : float
        Bounds of its values, in the unit.
    """

    name: str
    unit: str
    low: float
    high: float


def torque_entry(motor: Motor) -> Quantity:
    """The motor's torque as an entry of an observation.

    Parameters
    ----------
    motor : Motor
        The motor.

    Returns
    -------
    Quantity
        The peak torque and OVERSHOOT bound its values.

    Examples
    --------
    >>> from dualcam.gym.task import torque_entry
    >>> from dualcam.systems.blocks.motor import AK80_6
    >>> torque_entry(AK80_6).name, torque_entry(AK80_6).unit
    ('torque', 'N.m')
    """
    bound = OVERSHOOT * motor.peak_torque
    return Quantity("torque", "N.m", -bound, bound)


class Motion(NamedTuple):
    """The axis and its motor at the end of a step, arrays of shape (count,).

    Parameters
    ----------
    angle, speed : ndarray
        State of the axis [rad, rad/s].
    torque : ndarray
        Torque of the motor, mean of the last control period [N.m].
    period : ndarray of int
        Control periods since the begin of the episode.
    """

    angle: Array
    speed: Array
    torque: Array
    period: NDArray[np.int64]


@dataclass(frozen=True)
class Task(ABC):
    """A mechanism with a motor, its random loads, and the cost of an episode.

    Parameters
    ----------
    energy_weight : float
        Cost of energy drawn from the supply [1].
    error_weight : float
        Cost of the squared error of the angle over time [J/(rad2.s)].
    impact_weight : float
        Cost of heat at the end stops [1].
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
        """Begin episodes.

        Parameters
        ----------
        numbers : ndarray, shape (count, draws)
            Random numbers, uniform over [0, 1).

        Returns
        -------
        dict of str to ndarray, shape (count,) each
            What the episodes differ in, by name. "start" is the angle of the axis [rad].
        """

    @abstractmethod
    def start_values(self, scene: Scene) -> dict[str, Array]:
        """Start values of the FMU that follow from the drawn scene, without the angle.

        Parameters
        ----------
        scene : dict of str to ndarray
            From `draw`.

        Returns
        -------
        dict of str to ndarray, shape (count,) each
            By name, in SI units.
        """

    @abstractmethod
    def load_torque(self, scene: Scene, angle: Array, period: NDArray[np.int64]) -> Array:
        """The torque of the load on the axis.

        Parameters
        ----------
        scene : dict of str to ndarray
            From `draw`.
        angle : ndarray, shape (count,)
            Angle of the axis in the middle of the control period [rad].
        period : ndarray of int, shape (count,)
            Number of the control period, from 0.

        Returns
        -------
        ndarray, shape (count,)
            Torque [N.m], + in the direction of the angle.
        """

    @abstractmethod
    def wanted(self, scene: Scene, period: NDArray[np.int64]) -> Array:
        """The angle that the axis should have.

        Parameters
        ----------
        scene : dict of str to ndarray
            From `draw`.
        period : ndarray of int, shape (count,)
            Control periods since the begin of the episode.

        Returns
        -------
        ndarray, shape (count,)
            Angle [rad].
        """

    @abstractmethod
    def observe(self, scene: Scene, motion: Motion) -> Array:
        """What a policy sees.

        Parameters
        ----------
        scene : dict of str to ndarray
            From `draw`.
        motion : Motion
            The axis and its motor.

        Returns
        -------
        ndarray, shape (count, entries)
            In the order of `observations`.
        """

    def is_over(self, scene: Scene, period: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the task has come to its own end. Default: never.

        Parameters
        ----------
        scene : dict of str to ndarray
            From `draw`.
        period : ndarray of int, shape (count,)
            Control periods since the begin of the episode.

        Returns
        -------
        ndarray of bool, shape (count,)
            Where the episode is over.
        """
        return np.zeros(len(period), bool)


def spread(number: Array, over: Range) -> Array:
    """A random number from [0, 1) over a range.

    Parameters
    ----------
    number : ndarray
        Random numbers, uniform over [0, 1).
    over : tuple of float
        Lowest and highest value.

    Returns
    -------
    ndarray
        Uniform over the range.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.gym.task import spread
    >>> spread(np.array([0.0, 0.5]), (1.0, 2.0)).tolist()
    [1.0, 1.5]
    """
    return over[0] + (over[1] - over[0]) * number


def check_range(name: str, over: object, least: float, most: float, unit: str) -> None:
    """Refuse what is no range of a random value.

    Parameters
    ----------
    name : str
        Name of the range, for the message.
    over : object
        The range: lowest and highest value.
    least, most : float
        What is allowed.
    unit : str
        The unit, for the message.

    Raises
    ------
    TaskError
        The range is refused.

    Examples
    --------
    >>> from dualcam.gym.task import check_range
    >>> check_range("payload", (0.5, 2.5), 0.0, 3.0, "kg")
    """
    allowed = f"(low, high) with {least:g} <= low <= high <= {most:g} {unit}".rstrip()
    ends = list(over) if isinstance(over, tuple | list) else []
    are_numbers = all(isinstance(end, int | float) and not isinstance(end, bool) for end in ends)
    if len(ends) != 2 or not are_numbers or not least <= ends[0] <= ends[1] <= most:  # also where one is NaN
        raise TaskError(f"{name} = {over!r}: allowed is {allowed}")


def highest_speed(torque: float, travel: float, inertia: float) -> float:
    """A speed that an axis between two end stops cannot exceed.

    Parameters
    ----------
    torque : float
        Bound of the magnitude of all torques together [N.m].
    travel : float
        Distance between the stops [rad].
    inertia : float
        Least inertia [kg.m2].

    Returns
    -------
    float
        Speed [rad/s]: the axis turns back at zero speed, so that all energy comes from one way of `travel`.

    Examples
    --------
    >>> from dualcam.gym.task import highest_speed
    >>> highest_speed(torque=10.0, travel=0.2, inertia=1.0)
    2.0
    """
    return math.sqrt(2.0 * torque * travel / inertia)
