"""Payload and friction of the robot's elbow from an encoder: a particle filter over instances of the FMU."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dualcam.design.statics import Array
from dualcam.errors import DualcamError
from dualcam.systems.blocks.axis_bank import AxisBank
from dualcam.systems.blocks.helical_cam import HelicalCam
from dualcam.systems.machines import elbow

Range = tuple[float, float]

ANGLE_GAIN = 0.4  # share of a difference to the encoder that corrects the angle
SPEED_GAIN = 2.0 * (2.0 - ANGLE_GAIN) - 4.0 * math.sqrt(
    1.0 - ANGLE_GAIN
)  # Kalata: optimal to that angle gain
DEVIATION = 3.0  # counts of the encoder: standard deviation of the differences, errors of the model included
LEAST_SHARE = 0.5  # of the particles that must be effective, else they are drawn anew
SHRINKAGE = 0.98  # Liu and West: how far the drawn particles keep their distance from the mean
EVOLUTION = (0.03, 0.003)  # kg, 1: least standard deviation that is added when particles are drawn anew


class Belief(NamedTuple):
    """States of the arm with payload and friction, one entry per hypothesis.

    `angle`, `speed`: state [rad, rad/s], shape (count,). `payload` [kg], shape (count,). `friction`: Coulomb
    coefficient of both contacts [1], shape (count,).
    """

    angle: Array
    speed: Array
    payload: Array
    friction: Array

    def start_values(self) -> dict[str, Array]:
        """Payload and friction as start values of the FMU, by name."""
        friction = {f"cam{i}.friction": self.friction for i in (1, 2)}
        return {"inertia.shaft": elbow.inertia(self.payload), **friction}


def systematic_draw(weights: Array, count: int, random: np.random.Generator) -> NDArray[np.intp]:
    """Numbers drawn by their weights, shape (count,), with one random number for all of them.

    Number i comes count weights[i] times, rounded up or down. `weights` with the sum 1, shape (n,). `count`:
    how many to draw. `random`: where the random number comes from.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.machines.payload_filter import systematic_draw
    >>> systematic_draw(np.array([0.5, 0.0, 0.5]), 4, np.random.default_rng(1)).tolist()
    [0, 0, 2, 2]
    """
    places = (np.arange(count) + random.random()) / count
    return np.minimum(np.searchsorted(np.cumsum(weights), places, side="right"), len(weights) - 1)


class PayloadFilter:
    """Which payload and friction explain what the encoder shows, while the arm moves and while it sticks.

    Each particle is a payload and a friction with an instance of the forward FMU. In each period every
    instance moves by one step under the torque of the motor and its own weight. The difference d to the
    encoder corrects the state of the particle (an alpha-beta filter), and weighs the particle:

        angle + 0.4 d     speed + 0.102 d/period     weight times exp(-(d/(3 counts))^2/2)

    A wrong payload makes d large period after period. When few particles have most of the weight, all are
    drawn anew by weight (J. Liu and M. West, 2001): the drawn ones shrink towards the mean and get noise, so
    that mean and covariance stay. A little more noise than that is added here. One direction of motion alone
    hardly tells payload and friction apart; without the noise the filter would be sure too early.

    Parameters
    ----------
    cam : The cam; its friction is not used.
    payload, friction : Least and largest value [kg, 1]. Equal values: they are known.
    angle : Angle at which the arm rests at the beginning [rad].
    count : Number of particles.
    period : Period of the encoder's readings [s].
    resolution : One count of the encoder [rad].
    random : Where the random numbers come from.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.machines import elbow
    >>> from dualcam.systems.blocks.axis_bank import AxisBank
    >>> from dualcam.systems.machines.payload_filter import PayloadFilter
    >>> cam, random = elbow.design_cam(), np.random.default_rng(1)
    >>> ranges = {"payload": (0.5, 2.5), "friction": (0.10, 0.18)}
    >>> known = {"angle": 0.9, "period": 0.01, "resolution": 2.6e-4}  # rad, s, rad
    >>> believed = PayloadFilter(cam, **ranges, **known, count=64, random=random)
    >>> true = np.array([2.0])  # kg
    >>> with AxisBank(1, elbow.plant_parameters(cam, 2.0) | {"initial.theta": 0.9}) as arm:
    ...     for torque in [5.0] * 15 + [-9.0] * 40:  # N.m: lower and lift
    ...         arm.step(np.array([torque]), elbow.weight(true), 0.01)
    ...         believed.update(torque, 2.6e-4 * round(float(arm.angle[0]) / 2.6e-4))
    >>> mean = believed.mean()
    >>> bool(abs(mean.payload[0] - 2.0) < 0.1 and abs(mean.friction[0] - 0.14) < 0.01)
    True
    """

    def __init__(
        self,
        cam: HelicalCam,
        payload: Range,
        friction: Range,
        angle: float,
        count: int,
        period: float,
        resolution: float,
        random: np.random.Generator,
    ) -> None:
        self._ranges = np.array([payload, friction])
        self._period, self._resolution, self._random = period, resolution, random
        self._values = random.uniform(
            self._ranges[:, :1], self._ranges[:, 1:], (2, count)
        )  # payloads, frictions
        self._state = np.array([np.full(count, angle), np.zeros(count)])
        self._log_weights = np.zeros(count)
        self._bank = AxisBank(count, elbow.plant_parameters(cam, elbow.DESIGN_PAYLOAD))

    @property
    def weights(self) -> Array:
        """Weights of the particles, with the sum 1, shape (count,)."""
        weights = np.exp(self._log_weights - np.max(self._log_weights))
        return weights / np.sum(weights)

    def close(self) -> None:
        """Free all instances. Any later call of `update` is an error."""
        self._bank.close()

    def update(self, torque: float, measured: float) -> None:
        """Take in one reading of the encoder.

        `torque`: mean torque of the motor since the last reading [N.m]. `measured`: angle that the encoder
        shows [rad]. DualcamError: a value is not finite: the filter stays as it is.
        """
        for name, value in (("torque", torque), ("measured", measured)):
            if not math.isfinite(value):
                raise DualcamError(f"{name} = {value}: allowed is a finite number")
        bank, particles = self._bank, Belief(*self._state, *self._values)
        inside = np.clip(particles.angle, 0.0, elbow.RANGE)
        bank.start(inside, particles.speed, particles.start_values())
        bank.step(np.full(inside.size, torque), elbow.weight(particles.payload), self._period)
        difference = measured - bank.angle
        rests = (bank.speed == 0.0) & (np.abs(difference) < self._resolution)  # and the encoder agrees
        correction = np.where(rests, 0.0, difference)
        self._state[0] = bank.angle + ANGLE_GAIN * correction
        self._state[1] = bank.speed + SPEED_GAIN / self._period * correction
        self._log_weights -= 0.5 * (difference / (DEVIATION * self._resolution)) ** 2
        weights = self.weights
        if 1.0 / float(weights @ weights) < LEAST_SHARE * weights.size:
            self._draw_anew(weights)

    def _draw_anew(self, weights: Array) -> None:
        mean = self._values @ weights
        deviation = self._values - mean[:, None]
        spread = (1.0 - SHRINKAGE**2) * (deviation * weights) @ deviation.T + np.diag(np.square(EVOLUTION))
        drawn = systematic_draw(weights, weights.size, self._random)
        noise = np.linalg.cholesky(spread) @ self._random.standard_normal((2, weights.size))
        moved = mean[:, None] + SHRINKAGE * deviation[:, drawn] + noise
        self._values = np.clip(moved, *self._ranges.T[:, :, None])
        self._state = self._state[:, drawn]
        self._log_weights[:] = 0.0

    def mean(self) -> Belief:
        """The mean of all particles, of shape (1,); the arm rests where it does for most of the weight."""
        weights = self.weights
        angle, speed = self._state @ weights
        payload, friction = self._values @ weights
        if weights @ (self._state[1] == 0.0) > 0.5:
            speed = 0.0
        return Belief(*(np.array([value]) for value in (angle, speed, payload, friction)))

    def draw(self, count: int) -> Belief:
        """As many particles as `count`, drawn by weight: arrays of shape (count,)."""
        chosen = systematic_draw(self.weights, count, self._random)
        return Belief(*self._state[:, chosen], *self._values[:, chosen])
