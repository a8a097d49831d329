"""The robot's elbow as a task: move an arm with an unknown payload to an angle, and hold it there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array
from dualcam.gym.task import (
    MoveTask,
    Quantity,
    Range,
    Scene,
    check_range,
    highest_speed,
    spread,
    torque_entry,
)
from dualcam.systems.blocks.axis import CamGear
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.machines import elbow

ENDS = (elbow.CLEARANCE, elbow.RANGE - elbow.CLEARANCE)  # rad, of start and target
SCENE = ("payload", "friction", "start", "target")
MOST_PAYLOAD = 3.0  # kg, the robot's rated payload
MOST_FRICTION = 0.3


@dataclass(frozen=True)
class ElbowTask(MoveTask):
    """Move the arm from a random angle to another one and hold it there. Payload and friction are unknown.

    `energy_weight`, `error_weight`, `impact_weight`: as in `Task`. `payload`: least and largest payload [kg].
    `friction`: least and largest Coulomb coefficient of both contacts [1].
    """

    payload: Range = (0.5, 2.5)
    friction: Range = (0.10, 0.18)

    motor = AK80_6
    gear = CamGear()
    periods = 10
    draws = len(SCENE)
    told = SCENE

    def __post_init__(self) -> None:
        super().__post_init__()
        check_range("payload", self.payload, 0.0, MOST_PAYLOAD, "kg")
        check_range("friction", self.friction, 0.0, MOST_FRICTION, "")

    @property
    def observations(self) -> tuple[Quantity, ...]:
        cam = elbow.design_cam().with_friction_scaled(MOST_FRICTION / elbow.HELIX.friction[0])
        torque = self.motor.peak_torque + elbow.horizontal_torque(MOST_PAYLOAD) + cam.band(elbow.RANGE)[1]
        speed = highest_speed(torque, elbow.RANGE, elbow.inertia(0.0))
        return (
            Quantity("angle", "rad", 0.0, elbow.RANGE),
            Quantity("speed", "rad/s", -speed, speed),
            Quantity("target", "rad", *ENDS),
            torque_entry(self.motor),
        )

    def parameters(self) -> dict[str, float | int]:
        return elbow.plant_parameters(elbow.design_cam(), elbow.DESIGN_PAYLOAD)

    def draw(self, numbers: Array) -> Scene:
        """Payload [kg], friction [1], start and target [rad]."""
        ranges = (self.payload, self.friction, ENDS, ENDS)
        return {name: spread(numbers[:, i], ranges[i]) for i, name in enumerate(SCENE)}

    def start_values(self, scene: Scene) -> dict[str, Array]:
        return {
            "inertia.shaft": elbow.inertia(scene["payload"]),
            "cam1.friction": scene["friction"],
            "cam2.friction": scene["friction"],
        }

    def load_torque(self, scene: Scene, angle: Array, period: NDArray[np.int64]) -> Array:
        return elbow.weight(scene["payload"]).torque(angle)
