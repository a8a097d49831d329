"""The flywheel as a slave: exact steps of one size under polynomial inputs."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm

from benchmarks.coupling.scenes import Scene

ANGLE, SPEED = slice(2, 5), slice(5, 8)  # theta and omega with their derivatives in the flywheel's state
SINE, COSINE, ONE = 8, 9, 10


class Flywheel:
    """Steps of one size. The state is phi, phi' and all that comes in, each with its linear equation."""

    def __init__(self, scene: Scene, step: float) -> None:
        self.step_size, self.circular = step, 2.0 * math.pi * scene.frequency
        torque = np.zeros(11)
        torque[0], torque[1] = scene.stiffness, scene.damping
        torque[ANGLE.start], torque[SPEED.start] = -scene.stiffness, -scene.damping
        rates = np.zeros((11, 11))
        rates[0, 1] = 1.0
        rates[1] = -torque
        rates[1, 1] -= scene.bearing
        rates[1, SINE], rates[1, ONE] = scene.amplitude, scene.mean
        rates[1] /= scene.inertia
        for polynomial in (ANGLE, SPEED):
            for i in range(polynomial.start, polynomial.stop - 1):
                rates[i, i + 1] = 1.0
        rates[SINE, COSINE], rates[COSINE, SINE] = self.circular, -self.circular
        self.propagator = expm(rates * step)
        self.torques = np.array([torque, torque @ rates, torque @ rates @ rates])
        self.state = np.zeros(11)
        self.state[0], self.state[ONE] = scene.angle + scene.twist, 1.0

    def take_inputs(self, t: float, motion: list[list[float]]) -> None:
        """Takes theta and omega and their derivatives at the time t [s]. Derivatives that are not given are
        zero."""
        self.state[ANGLE.start : SPEED.stop] = 0.0
        for i, (angle, speed) in enumerate(motion):
            self.state[ANGLE.start + i], self.state[SPEED.start + i] = angle, speed
        self.state[SINE], self.state[COSINE] = math.sin(self.circular * t), math.cos(self.circular * t)

    def torque(self, order: int) -> list[float]:
        """tau and its derivatives up to `order`."""
        return (self.torques[: order + 1] @ self.state).tolist()

    def step(self) -> None:
        self.state = self.propagator @ self.state


def expanded(derivatives: list[float], shift: float) -> list[float]:
    """The same polynomial about a point `shift` later: value and derivatives."""
    return [
        sum(d * shift**j / math.factorial(j) for j, d in enumerate(derivatives[i:]))
        for i in range(len(derivatives))
    ]
