"""Elbow, knee and car door as environments of gymnasium, single and vectorised.

    import gymnasium, dualcam.gym
    env = gymnasium.make("dualcam/Elbow-v0")
    envs = gymnasium.make_vec("dualcam/Elbow-v0", num_envs=1000)

ids          "dualcam/Elbow-v0", "dualcam/Knee-v0", "dualcam/CarDoor-v0"
Batch        the same tasks without gymnasium's words: torques in, observations and terms of the cost out
ElbowTask, KneeTask, CarDoorTask    what a task is made of, with its ranges and weights

Needs gymnasium: pip install "dualcam[gym]".

May import common, fmi, fleet, systems.blocks, systems.machines.
"""

try:
    import gymnasium
except ImportError:
    raise ImportError('dualcam.gym needs gymnasium: pip install "dualcam[gym]"') from None

from dualcam.gym.batch import Batch, Outcome
from dualcam.gym.car_door_task import CarDoorTask
from dualcam.gym.elbow_task import ElbowTask
from dualcam.gym.environment import CarDoorEnv, ElbowEnv, KneeEnv, TaskEnv
from dualcam.gym.knee_task import KneeTask
from dualcam.gym.task import Quantity, Task
from dualcam.gym.vector import CarDoorVectorEnv, ElbowVectorEnv, KneeVectorEnv, TaskVectorEnv

# Steps of an episode: 2 s of the elbow, 5 s of the door. The knee's episode is over at heel strike, after at
# most 105 steps, so that the limit is never met.
EPISODE_STEPS = {"Elbow": 200, "Knee": 120, "CarDoor": 250}

TASKS = {"Elbow": ElbowTask, "Knee": KneeTask, "CarDoor": CarDoorTask}

for _name, _steps in EPISODE_STEPS.items():
    gymnasium.register(
        id=f"dualcam/{_name}-v0",
        entry_point=f"dualcam.gym.environment:{_name}Env",
        vector_entry_point=f"dualcam.gym.vector:{_name}VectorEnv",
        max_episode_steps=_steps,
    )

__all__ = [
    "EPISODE_STEPS",
    "TASKS",
    "Batch",
    "CarDoorEnv",
    "CarDoorTask",
    "CarDoorVectorEnv",
    "ElbowEnv",
    "ElbowTask",
    "ElbowVectorEnv",
    "KneeEnv",
    "KneeTask",
    "KneeVectorEnv",
    "Outcome",
    "Quantity",
    "Task",
    "TaskEnv",
    "TaskVectorEnv",
]
