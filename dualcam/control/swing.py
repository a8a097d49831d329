"""The torque of an imposed swing of the cam, and its harmonics, with inertia, damping and friction law."""

import math
from typing import NamedTuple

import numpy as np

from dualcam.control.forward import CamAtState
from dualcam.control.linear import ITERATIONS
from dualcam.errors import OperatingPointError
from dualcam.fmi.reals import Array

FEW_NODES, MANY_NODES = 12, 48  # per half swing: for a search, and for a result
LAST_STEP = 1e-9  # of the torque, and of 1e-6 N.m: Newton's method has ended


class Harmonics(NamedTuple):
    """Of the torque over the amplitude A of the angle, at theta = middle + A sin(phase)."""

    mean: float  # N.m, of the torque itself
    first: complex  # N.m/rad, as the next ones: times A it is the phasor of the torque beside the angle's A
    second: complex
    third: complex


class ImposedSwing:
    """The forward FMU in a sinusoidal motion: the torque that the motion needs.

    Within one half of the swing the speed keeps its sign and the torque is smooth. At the turning points the
    torque jumps across the stick band. So the integrals over a half are Gauss-Legendre sums."""

    def __init__(self, cam: CamAtState, middle: float, F_ext: float) -> None:
        self.cam, self.middle, self.F_ext = cam, middle, F_ext

    def torque(self, theta: float, omega: float, alpha: float, guess: float) -> float:
        """The torque [N.m] of a motion, by Newton's method: alpha is affine in the torque while the flanks
        stay the same."""
        tau = guess
        for _ in range(ITERATIONS):
            self.cam.set_state(theta, omega, tau, self.F_ext)
            slope = float(self.cam.fmu.jacobian(["alpha"], ["tau"])[0, 0])
            if slope == 0.0 or not math.isfinite(slope):
                break
            last, tau = tau, tau - (self.cam.alpha - alpha) / slope
            if abs(tau - last) <= LAST_STEP * max(abs(last), 1e-6):
                return tau
        raise OperatingPointError(
            f"theta = {theta:g} rad, omega = {omega:g} rad/s: no torque gives the acceleration {alpha:g}"
            " rad/s2 there; a smaller amplitude or frequency, or less friction, may work"
        )

    def torques(self, amplitude: float, frequency: float, nodes: int) -> tuple[Array, Array, Array]:
        """Phases, torques [N.m] and weights of the sum over a period, shape (2 nodes,) each."""
        points, weights = np.polynomial.legendre.leggauss(nodes)
        phases = 0.5 * np.pi * np.concatenate([points, points + 2.0])
        torques, guess = np.empty(2 * nodes), 0.0
        for k, phase in enumerate(phases):
            theta = self.middle + amplitude * math.sin(phase)
            omega = amplitude * frequency * math.cos(phase)
            alpha = -amplitude * frequency**2 * math.sin(phase)
            torques[k] = guess = self.torque(theta, omega, alpha, guess)
        return phases, torques, 0.25 * np.concatenate([weights, weights])

    def harmonics(self, amplitude: float, frequency: float, nodes: int = MANY_NODES) -> Harmonics:
        """Of the torque, at an amplitude [rad] and an angular frequency [rad/s]."""
        phases, torques, weights = self.torques(amplitude, frequency, nodes)
        first, second, third = (
            complex(2j * np.sum(weights * torques * np.exp(-1j * k * phases)) / amplitude) for k in (1, 2, 3)
        )
        return Harmonics(float(np.sum(weights * torques)), first, second, third)
