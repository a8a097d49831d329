"""Many episodes at a time: the tasks as vector environments of gymnasium, by one fleet."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import Array
from dualcam.errors import TaskError
from dualcam.fleet.values import whole_number
from dualcam.gym.batch import Batch
from dualcam.gym.car_door_task import CarDoorTask
from dualcam.gym.elbow_task import ElbowTask
from dualcam.gym.environment import action_space, checked_actions, observation_space, terms_of
from dualcam.gym.knee_task import KneeTask
from dualcam.gym.task import Range, Task

Flags = NDArray[np.bool_]
Infos = dict[str, Any]


class TaskVectorEnv(VectorEnv[Array, Array, NDArray[Any]]):
    """Many instances of a task as a vector environment. `gymnasium.make_vec` makes one by the task's id.

    Instance i of a vector environment with the seed s moves bit for bit as an environment with the seed
    s + i.

    Parameters
    ----------
    num_envs : Number of instances, > 0.
    max_episode_steps : Steps after which an episode is truncated. None: never.
    autoreset_mode : When a new episode begins where one has ended: "NextStep", "SameStep" or "Disabled".
    threads : Threads that share the instances, 1 to 256.
    **options : Weights and ranges of the task.

    Attributes
    ----------
    task : The task.
    batch : The instances.
    """

    task_type: ClassVar[type[Task]]

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        threads: int = 1,
        **options: float | Range,
    ) -> None:
        self.task = self.task_type(**options)  # type: ignore[arg-type]
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            allowed = ", ".join(f'"{mode.value}"' for mode in AutoresetMode)
            raise TaskError(f"autoreset_mode = {autoreset_mode!r}: allowed are {allowed}") from None
        self.metadata = {"render_modes": [], "autoreset_mode": self.autoreset_mode}
        self.batch = Batch(self.task, num_envs, threads)
        self.num_envs = num_envs
        if max_episode_steps is not None:
            whole_number(max_episode_steps, "max_episode_steps", "a whole number > 0, or None", math.inf)
        self.max_episode_steps = max_episode_steps
        self.single_observation_space = observation_space(self.task)
        self.single_action_space = action_space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._randoms: list[np.random.Generator] = []
        self._steps = np.zeros(num_envs, np.int64)
        self._ended = np.zeros(num_envs, bool)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Array, Infos]:
        """Begin episodes. Returns observations, shape (num_envs, entries), and new loads and frictions by
        name.

        `seed`: instance i gets the seed `seed` + i, or the i-th one. Default: each goes on with its own
        sequence. `options`: "reset_mask", a bool array of shape (num_envs,): the instances that begin anew.
        Default: all. TaskError: a wrong number of seeds, or a wrong mask.
        """
        chosen = self._chosen((options or {}).get("reset_mask"))
        self._seed(seed, chosen)
        seen = self._begin(chosen)
        return seen, self._told(chosen)

    def step(self, actions: ArrayLike) -> tuple[Array, Array, Flags, Flags, Infos]:
        """One step of all instances. Returns observations, rewards, terminations, truncations, and infos: the
        terms of the reward by name, and loads and frictions of episodes that have begun in this call.

        `actions`: torque asked of each motor over its peak torque [1], shape (num_envs, 1); larger ones than
        1 are cut. TaskError: a wrong shape, an action that is not finite, or an episode that has ended where
        `autoreset_mode` is "Disabled": no instance made the step.
        """
        torque = self.task.motor.peak_torque * checked_actions(actions, (self.num_envs, 1))[:, 0]
        begins = self._ended.copy()
        if begins.any() and self.autoreset_mode is AutoresetMode.DISABLED:
            raise TaskError(
                f"the episode of instance {np.flatnonzero(begins)[0]} has ended: call reset with"
                ' options={"reset_mask": terminations | truncations}'
            )
        seen, outcome = self.batch.step(torque)
        self._steps += 1
        most = self.max_episode_steps
        truncated = np.zeros(self.num_envs, bool) if most is None else self._steps >= most
        terminated, rewards = outcome.is_over, outcome.reward
        infos = masked(terms_of(outcome), ~begins)
        if begins.any():  # these made no step of their episode: they begin one
            seen = self._begin(begins)
            rewards = np.where(begins, 0.0, rewards)
            terminated, truncated = terminated & ~begins, truncated & ~begins
            infos |= self._told(begins)
        self._ended = terminated | truncated
        if self._ended.any() and self.autoreset_mode is AutoresetMode.SAME_STEP:
            ended = self._ended.copy()
            infos = final_infos(seen, infos, ended)
            seen = self._begin(ended)
            infos |= self._told(ended)
        return seen, rewards, terminated, truncated, infos

    def close_extras(self, **options: object) -> None:
        """Free the FMUs. `**options`: not used."""
        self.batch.close()

    # ---- episodes ----

    def _begin(self, chosen: Flags) -> Array:
        """Begin an episode of each chosen instance with random numbers of its own sequence."""
        numbers = np.zeros((self.num_envs, self.task.draws))
        for i in np.flatnonzero(chosen):
            numbers[i] = self._randoms[i].random(self.task.draws)
        self._steps[chosen] = 0
        self._ended[chosen] = False
        return self.batch.reset(numbers, chosen)

    def _told(self, chosen: Flags) -> Infos:
        return masked({name: self.batch.scene[name] for name in self.task.told}, chosen)

    def _seed(self, seed: int | Sequence[int | None] | None, chosen: Flags) -> None:
        seeds: Sequence[int | None]
        if seed is None or isinstance(seed, int | np.integer):
            seeds = [None if seed is None else int(seed) + i for i in range(self.num_envs)]
        else:
            seeds = list(seed)
        if len(seeds) != self.num_envs:
            raise TaskError(
                f"seed has {len(seeds)} entries: allowed is one number, or {self.num_envs} of them"
            )
        if not self._randoms:
            self._randoms = [seeding.np_random(one)[0] for one in seeds]
            return
        for i in np.flatnonzero(chosen):
            if seeds[i] is not None:
                self._randoms[i] = seeding.np_random(seeds[i])[0]

    def _chosen(self, mask: object) -> Flags:
        if mask is None:
            return np.ones(self.num_envs, bool)
        given = np.asarray(mask)
        if given.shape != (self.num_envs,) or given.dtype != bool or not given.any():
            raise TaskError(
                f"options['reset_mask'] = {mask!r}: allowed are {self.num_envs} booleans, at least one of"
                " them True"
            )
        return given


def masked(values: Mapping[str, Array], chosen: Flags) -> Infos:
    """The infos of the chosen instances, 0 for the others; "_" and the name: who has it."""
    if not chosen.any():
        return {}
    infos: Infos = {}
    for name, value in values.items():
        infos[name], infos[f"_{name}"] = np.where(chosen, value, 0.0), chosen.copy()
    return infos


def final_infos(seen: Array, infos: Infos, ended: Flags) -> Infos:
    """Infos of a step after which `ended` episodes begin anew, with "final_obs" and "final_info"."""
    last = np.full(len(ended), None, dtype=object)
    for i in np.flatnonzero(ended):
        last[i] = seen[i].copy()
    values = {name: value for name, value in infos.items() if not name.startswith("_")}
    return {
        **masked(values, ~ended),
        "final_obs": last,
        "_final_obs": ended.copy(),
        "final_info": masked(values, ended),
        "_final_info": ended.copy(),
    }


class ElbowVectorEnv(TaskVectorEnv):
    """Many instances of `ElbowTask`, "dualcam/Elbow-v0", with the arguments of `TaskVectorEnv`."""

    task_type = ElbowTask


class KneeVectorEnv(TaskVectorEnv):
    """Many instances of `KneeTask`, "dualcam/Knee-v0", with the arguments of `TaskVectorEnv`."""

    task_type = KneeTask


class CarDoorVectorEnv(TaskVectorEnv):
    """Many instances of `CarDoorTask`, "dualcam/CarDoor-v0", with the arguments of `TaskVectorEnv`."""

    task_type = CarDoorTask
