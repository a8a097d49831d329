"""One episode at a time: the tasks as environments of gymnasium."""

from typing import Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import Array, real_array
from dualcam.errors import TaskError
from dualcam.gym.batch import TERMS, Batch, Outcome
from dualcam.gym.car_door_task import CarDoorTask
from dualcam.gym.elbow_task import ElbowTask
from dualcam.gym.knee_task import KneeTask
from dualcam.gym.task import Range, Task


def observation_space(task: Task) -> gymnasium.Space[Array]:
    """The space of a `task`'s observations, in the units of `task.observations`, shape (entries,)."""
    low = np.array([quantity.low for quantity in task.observations])
    high = np.array([quantity.high for quantity in task.observations])
    return gymnasium.spaces.Box(low, high, dtype=np.float64)


def action_space() -> gymnasium.Space[Array]:
    """The space of all tasks' actions: the torque asked of the motor over its peak torque, shape (1,)."""
    return gymnasium.spaces.Box(-1.0, 1.0, (1,), dtype=np.float64)


def checked_actions(actions: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Actions as an array of that shape, cut at -1 and 1, or a TaskError."""
    given = real_array(actions, "action", TaskError, shape)
    if not np.isfinite(given).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(given))[0])
        raise TaskError(f"action{list(place)} = {given[place]}: allowed are finite numbers from -1 to 1")
    return np.clip(given, -1.0, 1.0)


def terms_of(outcome: Outcome) -> dict[str, Array]:
    """The terms of the reward of an `outcome` by name, shape (count,) each, for the infos of a step."""
    return {name: getattr(outcome, name) for name in TERMS}


class TaskEnv(gymnasium.Env[NDArray[np.float64], NDArray[np.float64]]):
    """A task as an environment. `gymnasium.make` makes one by its id.

    Parameters
    ----------
    render_mode : There is no rendering.
    **options : Weights and ranges of the task.

    Attributes
    ----------
    task : The task.
    batch : The task's only instance.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}  # type: ignore[misc]
    task_type: ClassVar[type[Task]]

    def __init__(self, render_mode: None = None, **options: float | Range) -> None:
        self.task = self.task_type(**options)  # type: ignore[arg-type]
        self.batch = Batch(self.task, 1)
        self.observation_space = observation_space(self.task)
        self.action_space = action_space()
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode. Returns observation, shape (entries,), and loads and frictions by name.

        `seed` of the random loads. Default: the next ones of the sequence. `options`: not used.
        """
        super().reset(seed=seed)
        seen = self.batch.reset(self.np_random.random((1, self.task.draws)))
        return seen[0], {name: float(self.batch.scene[name][0]) for name in self.task.told}

    def step(self, action: ArrayLike) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """One step. Returns observation, reward, terminated, truncated, and the terms of the reward by name.

        `action`: torque asked of the motor over its peak torque [1], shape (1,); larger ones than 1 are cut.
        TaskError: a wrong shape, or an action that is not finite.
        """
        torque = self.task.motor.peak_torque * checked_actions(action, (1,))
        seen, outcome = self.batch.step(torque)
        terms = {name: float(value[0]) for name, value in terms_of(outcome).items()}
        return seen[0], float(outcome.reward[0]), bool(outcome.is_over[0]), False, terms

    def close(self) -> None:
        """Free the FMU."""
        self.batch.close()


class ElbowEnv(TaskEnv):
    """The task `ElbowTask`, "dualcam/Elbow-v0", with the arguments of `TaskEnv`."""

    task_type = ElbowTask


class KneeEnv(TaskEnv):
    """The task `KneeTask`, "dualcam/Knee-v0", with the arguments of `TaskEnv`."""

    task_type = KneeTask


class CarDoorEnv(TaskEnv):
    """The task `CarDoorTask`, "dualcam/CarDoor-v0", with the arguments of `TaskEnv`."""

    task_type = CarDoorTask
