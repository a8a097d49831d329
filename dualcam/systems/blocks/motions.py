"""Reference motions: a pick-and-place cycle, and a periodic function given by its Fourier series."""

import math
from dataclasses import dataclass

import numpy as np

from dualcam.design.statics import Array


@dataclass(frozen=True)
class PickAndPlace:
    """A cycle: rest at `start`, move to `end`, rest there, move back.

    Both moves are of minimum jerk, a quintic in time: from rest to rest, with zero acceleration at both ends.

    Parameters
    ----------
    start : Angle of the first rest [rad].
    end : Angle of the second rest [rad].
    move : Duration of one move [s].
    dwell : Duration of one rest [s].

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.blocks.motions import PickAndPlace
    >>> angle, speed = PickAndPlace(0.0, 1.0, move=1.0, dwell=0.5).sample(np.array([0.5, 1.0]))
    >>> angle.tolist(), speed.tolist()  # rad, rad/s: beginning and middle of the first move
    ([0.0, 0.5], [0.0, 1.875])
    """

    start: float
    end: float
    move: float
    dwell: float

    @property
    def period(self) -> float:
        """Duration of a cycle [s]."""
        return 2.0 * (self.move + self.dwell)

    @property
    def peak_speed(self) -> float:
        """15/8 of a move's mean speed [rad/s]."""
        return 1.875 * abs(self.end - self.start) / self.move

    @property
    def peak_acceleration(self) -> float:
        """10/sqrt(3) of a move's length over its squared duration [rad/s2]."""
        return 10.0 / math.sqrt(3.0) * abs(self.end - self.start) / self.move**2

    def sample(self, time: np.ndarray) -> tuple[Array, Array]:
        """Angle [rad] and speed [rad/s] at each `time` [s], of the shape of `time`."""
        phase = np.mod(time, self.period)
        half = self.move + self.dwell
        outbound = phase < half
        s = np.clip((np.where(outbound, phase, phase - half) - self.dwell) / self.move, 0.0, 1.0)
        path = s**3 * (10.0 + s * (6.0 * s - 15.0))
        rate = 30.0 * s**2 * (1.0 - s) ** 2 / self.move
        length = self.end - self.start
        theta = np.where(outbound, self.start + length * path, self.end - length * path)
        omega = np.where(outbound, length * rate, -length * rate)
        return theta, omega


@dataclass(frozen=True)
class FourierSeries:
    """A periodic function of time as a Fourier series, with its derivatives.

    `coefficients`: mean, then cosine and sine of each harmonic. `period` [s].
    """

    coefficients: tuple[float, ...]
    period: float

    def sample(self, time: np.ndarray, order: int = 0) -> Array:
        """Time derivative of an `order` (0: the function) at each `time` [s], in its unit per s^order."""
        total = np.full_like(time, self.coefficients[0] if order == 0 else 0.0)
        pairs = zip(self.coefficients[1::2], self.coefficients[2::2], strict=True)
        for n, (cosine, sine) in enumerate(pairs, start=1):
            rate = 2.0 * math.pi * n / self.period
            angle = rate * time + 0.5 * math.pi * order  # a derivative shifts by a quarter and scales by rate
            total += rate**order * (cosine * np.cos(angle) + sine * np.sin(angle))
        return total
