"""Makes an environment of fmugym from the forward FMU and lets gymnasium check it; argument: the FMU."""

import sys

import numpy as np
from fmugym import FMUGym, FMUGymConfig, VarSpace
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

Array = NDArray[np.float32]

TORQUE, ANGLE, SPEED = 10.0, 2.0, 1e3  # N.m, rad, rad/s: limits of the spaces


class Cam(FMUGym):
    """The torque as action, angle and speed as observation, for a held angle of 0.7 rad."""

    def _get_obs(self) -> Array:
        return super()._get_obs().astype(np.float32)

    def _process_action(self, action: Array) -> Array:
        return action

    def _process_reward(self, observation: Array, action: Array, info: object) -> float:
        return self.compute_reward(observation[0], 0.7, info)

    def compute_reward(self, achieved_goal: float, desired_goal: float, info: object) -> float:
        return -float((achieved_goal - desired_goal) ** 2)

    def _noisy_init(self) -> dict[int, float]:
        return {}


def space(name: str, **limits: float) -> VarSpace:
    """Variables between -limit and limit."""
    variables = VarSpace(name)
    for variable, limit in limits.items():
        variables.add_var_box(variable, -limit, limit)
    return variables


configuration = FMUGymConfig(
    fmu_path=sys.argv[1],
    stop_time=1.0,
    inputs=space("inputs", tau=TORQUE),
    outputs=space("outputs", theta=ANGLE, omega=SPEED),
    random_vars=VarSpace("none"),
)
check_env(Cam(configuration), skip_render_check=True)
