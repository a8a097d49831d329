"""The car's side door as a task: move a door of unknown weight, on an unknown slope, and let it stay."""

import math
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
from dualcam.systems.blocks.gravity import GravityLoad
from dualcam.systems.machines import car_door

ENDS = (math.radians(1.0), math.radians(65.0))  # rad, of start and target
SCENE = ("mass", "friction", "pitch", "roll", "start", "target")
MOST_MASS = 50.0  # kg
MOST_FRICTION = 0.3
STEEPEST = 0.3  # rad, of a slope


@dataclass(frozen=True)
class CarDoorTask(MoveTask):
    """Move the door from a random angle to another one and let it stay there. Its mass, the friction and the
    slope on which the car is parked are unknown.

    Parameters
    ----------
    energy_weight, error_weight, impact_weight : As in `Task`.
    mass : Least and largest mass of the door [kg].
    friction : Least and largest Coulomb coefficient of both contacts [1].
    pitch, roll
        Least and largest slope along and across the car [rad]; > 0 lifts the nose, or the door's side.
    """

    mass: Range = (0.95 * car_door.MASS, 1.05 * car_door.MASS)
    friction: Range = (0.17, 0.22)
    pitch: Range = (-car_door.PITCH, car_door.PITCH)
    roll: Range = (-car_door.ROLL, car_door.ROLL)

    motor = car_door.MOTOR
    gear = CamGear(-car_door.RATIO, car_door.OPEN)
    periods = 20
    draws = len(SCENE)
    told = SCENE

    def __post_init__(self) -> None:
        super().__post_init__()
        check_range("mass", self.mass, 10.0, MOST_MASS, "kg")
        check_range("friction", self.friction, 0.0, MOST_FRICTION, "")
        check_range("pitch", self.pitch, -STEEPEST, STEEPEST, "rad")
        check_range("roll", self.roll, -STEEPEST, STEEPEST, "rad")

    @property
    def observations(self) -> tuple[Quantity, ...]:
        cam = car_door.design().cam.with_friction_scaled(MOST_FRICTION / car_door.FRICTION)
        held = car_door.RATIO * max(abs(edge) for edge in cam.band(car_door.RATIO * car_door.OPEN))
        weight = MOST_MASS * car_door.ARM * 9.81
        inertia = inertia_of(np.array([10.0]))[0]
        speed = highest_speed(self.motor.peak_torque + held + weight, car_door.OPEN, inertia)
        return (
            Quantity("angle", "rad", 0.0, car_door.OPEN),
            Quantity("speed", "rad/s", -speed, speed),
            Quantity("target", "rad", *ENDS),
            torque_entry(self.motor),
        )

    def parameters(self) -> dict[str, float | int]:
        return dict(car_door.plant_parameters(car_door.design()))

    def draw(self, numbers: Array) -> Scene:
        """Mass [kg], friction [1], slopes, start and target [rad], and the
        equivalent pendulum of the weight: moment [kg.m], lean [rad] and gravity [m/s2]."""
        ranges = (self.mass, self.friction, self.pitch, self.roll, ENDS, ENDS)
        scene = {name: spread(numbers[:, i], ranges[i]) for i, name in enumerate(SCENE)}
        slopes = zip(scene["mass"].tolist(), scene["pitch"].tolist(), scene["roll"].tolist(), strict=True)
        weights = [car_door.weight_on_slope(*slope) for slope in slopes]
        scene["moment"] = np.array([weight.moment for weight in weights])
        scene["lean"] = np.array([weight.lean for weight in weights])
        return scene

    def start_values(self, scene: Scene) -> dict[str, Array]:
        return {
            "inertia.shaft": inertia_of(scene["mass"]) / car_door.RATIO**2,
            "cam1.friction": scene["friction"],
            "cam2.friction": scene["friction"],
        }

    def load_torque(self, scene: Scene, angle: Array, period: NDArray[np.int64]) -> Array:
        return GravityLoad(scene["moment"], scene["lean"]).torque(angle)


def inertia_of(mass: Array) -> Array:
    """The inertia about the hinge [kg.m2], with the rotor's, of a door of a `mass` [kg]."""
    return mass / car_door.MASS * car_door.DOOR_INERTIA + car_door.MOTOR.inertia
