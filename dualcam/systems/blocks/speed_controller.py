"""Speed control of a load that a cam can hold: PI on speed with feed-forward, and no current at rest."""

import math
from dataclasses import dataclass
from typing import Protocol

from dualcam.common.moved import also_called
from dualcam.systems.blocks.gravity import GravityLoad
from dualcam.systems.blocks.helical_cam import holding_torque


class HoldingCam(Protocol):
    """A cam that holds a load, by the load's angle [rad] and as torque about the load's axis [N.m]."""

    def band(self, angle: float) -> tuple[float, float]:
        """The lower and upper edge of the stick band [N.m] at an `angle` of the load [rad]."""
        ...

    def torque(self, angle: float, speed: float) -> float:
        """The torque [N.m] that keeps the load moving at an `angle` [rad] and a `speed` [rad/s]."""
        ...


@also_called(dt="period")
@dataclass(eq=False)
class SpeedController:
    """PI on speed with feed-forward of inertia, load, friction and damper, from a model of the plant. The
    integral part is the distance to the planned angle. The motor is off where the cam holds the load.

    Parameters
    ----------
    inertia : Inertia of the load [kg.m2].
    load : The weight.
    cam : The cam.
    torque_limit : Largest torque of the motor [N.m].
    bandwidth : Of both poles, critically damped [Hz].
    rest_speed : Speed below which the load may rest [rad/s].
    rest_margin : Share of the stick band between a held load and the band's edge [1].
    period : Period of the controller [s].
    """

    inertia: float
    load: GravityLoad
    cam: HoldingCam
    torque_limit: float
    bandwidth: float
    rest_speed: float
    rest_margin: float
    period: float

    def __post_init__(self) -> None:
        w = 2.0 * math.pi * self.bandwidth
        self.proportional, self.integral = 2.0 * w, w**2  # 1/s, 1/s2: s^2 + Kp s + Ki = (s + w)^2
        self.distance = 0.0  # rad, integral of the error of the speed

    def torque(
        self, angle: float, speed: float, reference: tuple[float, float], next_reference: tuple[float, float]
    ) -> float:
        """The motor's torque [N.m] for the coming period.

        `angle`, `speed`: of the load [rad, rad/s]. `reference`, `next_reference`: planned angle [rad] and
        speed [rad/s] at the beginning and at the end of the period; both angles are not used.
        """
        weight = self.load.torque(angle)
        low, high = self.cam.band(angle)
        if reference[1] == next_reference[1] == 0.0 and abs(speed) < self.rest_speed and high > low:
            self.distance = 0.0
            return holding_torque((low, high), weight, self.rest_margin * (high - low))
        mean = 0.5 * (reference[1] + next_reference[1])
        acceleration = (next_reference[1] - reference[1]) / self.period
        acceleration += self.proportional * (reference[1] - speed) + self.integral * self.distance
        wanted = self.inertia * acceleration + self.cam.torque(angle, mean) - weight
        torque = min(max(wanted, -self.torque_limit), self.torque_limit)
        if torque == wanted:  # at a limit the integral stands still, else it would wind up
            self.distance += (mean - speed) * self.period
        return torque
