"""Position control of a joint with the cam: LQI with feed-forward, and rest inside the stick band.

Friction asks two things of the controller. While the joint moves, the controller adds the edge of the stick
band that belongs to the planned direction. At rest any torque inside the band holds the same angle. There
integral action only costs current: the integral winds through the band until the joint breaks loose, and
back again. So at rest the controller drops its integral, and asks for the smallest torque that keeps the load
well inside the band. For most loads that torque is zero.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dualcam.common.moved import also_called
from dualcam.systems.blocks.gravity import GravityLoad
from dualcam.systems.blocks.helical_cam import HelicalCam, holding_torque


class Gains(NamedTuple):
    """Gains of the position controller, as acceleration per error.

    `angle`: of the angle's error [1/s2]. `speed`: of the speed's error [1/s]. `integral`: of the integral of
    the angle's error [1/s3].
    """

    angle: float
    speed: float
    integral: float


@also_called(dt="period")
def lqi_gains(bandwidth: float, period: float) -> Gains:
    """Gains of a double integrator theta'' = u, sampled, for every inertia M: torque = M u.

    `bandwidth`: radius of the poles over 2 pi [Hz], the whole tuning. `period` of the controller [s].

    Notes
    -----
    LQI: the state is extended by the integral of the error, so that a constant disturbance leaves no error.
    One linear quadratic problem gives all three gains. Only the integral is weighted, q integral^2 + u^2. In
    continuous time the optimum is then a third-order Butterworth pattern of radius w = q^(1/6), with the
    gains 2 w^2, 2 w, w^3. The bandwidth is w/(2 pi).

    Examples
    --------
    >>> from dualcam.systems.blocks.position_controller import lqi_gains
    >>> gains, w = lqi_gains(bandwidth=8.0, period=1e-5), 6.283185 * 8.0
    >>> [round(gain, 2) for gain in (gains.angle / w**2, gains.speed / w, gains.integral / w**3)]
    [2.0, 2.0, 1.0]
    """
    import control  # here, because that import takes seconds

    w = 2.0 * math.pi * bandwidth
    plant = np.array([[1.0, period], [0.0, 1.0]])
    drive = np.array([[0.5 * period**2], [period]])
    # Scaled time w t keeps the Riccati equation's entries near 1: angle, speed/w, integral w.
    scale = np.diag([1.0, 1.0 / w])
    plant = scale @ plant @ np.linalg.inv(scale)
    drive = scale @ drive * w**2
    gains, _, _ = control.dlqr(
        plant, drive, np.diag([0.0, 0.0, 1.0]), np.eye(1), integral_action=np.array([[w * period, 0.0]])
    )
    angle, speed, integral = gains[0]
    return Gains(float(angle) * w**2, float(speed) * w, float(integral) * w**3)


@dataclass(frozen=True)
class RestLimits:
    """When the controller lets the joint rest in the stick band.

    `tolerance`: largest error of the angle [rad]; twice that once the joint rests. `speed`: largest speed
    [rad/s]. `margin`: share of the band's half width between a held load and the band's edge [1].
    """

    tolerance: float
    speed: float
    margin: float


@also_called(dt="period")
@dataclass(eq=False)
class PositionController:
    """LQI with feed-forward, and rest inside the stick band, from a model of the joint.

    Parameters
    ----------
    inertia : Inertia of the joint [kg.m2].
    load : The load.
    cam : The cam.
    torque_limit : Largest torque of the motor at the output [N.m].
    gains : Feedback.
    rest : When the joint may rest.
    period : Period of the controller [s].
    """

    inertia: float
    load: GravityLoad
    cam: HelicalCam
    torque_limit: float
    gains: Gains
    rest: RestLimits
    period: float

    def __post_init__(self) -> None:
        self.integral = 0.0  # rad.s
        self.resting = False

    def torque(
        self, angle: float, speed: float, reference: tuple[float, float], next_reference: tuple[float, float]
    ) -> float:
        """The motor's torque [N.m] for the coming period, as `AxisController.torque`.

        `angle`, `speed`: measured state [rad, rad/s]. `reference`, `next_reference`: planned angle [rad] and
        speed [rad/s] at the beginning and at the end of the period.
        """
        error, rate = angle - reference[0], speed - reference[1]
        advance = next_reference[0] - reference[0]
        if self._may_rest(error, speed, advance, angle):
            self.integral = 0.0
            return self._rest_torque(angle)
        feedback = self.gains.angle * error + self.gains.speed * rate + self.gains.integral * self.integral
        acceleration = (next_reference[1] - reference[1]) / self.period - feedback
        middle = reference[0] + 0.5 * advance
        direction = advance if advance != 0.0 else -error  # the plan rests: towards the target
        wanted = self.inertia * acceleration + self.cam.torque(middle, direction) - self.load.torque(middle)
        torque = min(max(wanted, -self.torque_limit), self.torque_limit)
        if torque == wanted:  # at a limit the integral stands still, else it would wind up
            self.integral += error * self.period
        return torque

    def _may_rest(self, error: float, speed: float, advance: float, angle: float) -> bool:
        """Whether the joint may rest now: the plan rests, and error and speed are small."""
        release, load = self.cam.band(angle)
        tolerance = 2.0 * self.rest.tolerance if self.resting else self.rest.tolerance
        self.resting = (
            advance == 0.0 and load > release and abs(error) < tolerance and abs(speed) < self.rest.speed
        )
        return self.resting

    def _rest_torque(self, angle: float) -> float:
        """The smallest torque that keeps the load inside the band, with a margin for errors of the model."""
        release, load = self.cam.band(angle)
        margin = self.rest.margin * 0.5 * (load - release)
        return holding_torque((release, load), self.load.torque(angle), margin)
