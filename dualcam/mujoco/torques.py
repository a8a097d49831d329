"""The torques of all shafts over one step, solved together with the motion at the end of the step.

Without the shafts' torques the end of shaft i at the joint would reach the angle p_i and the speed w_i
(`FreeMotion`). Torques T_j on the cams, which oppose the joints, change both:

    theta_i = p_i - h^2 sum_j A_ij T_j        omega_i = w_i - h sum_j A_ij T_j

with the mobility A, the joints' accelerations per torque, seen from the cams. Each shaft answers with

    T_i = K_i (theta_i - x_i) + D_i (omega_i - x_i')

where x_i is the cam's angle at the end of the step. So T_i is that of the backward Euler method, which is
stable for every stiffness K_i. With theta_i and omega_i put in,

    (1 + c_i A_ii) T_i = b_i - c_i sum_(j != i) A_ij T_j - K_i x_i - D_i x_i',   c_i = K_i h^2 + D_i h

`CamLaw` and `DriveLaw` add how x_i follows T_i. A is symmetric and positive definite and x_i does not fall as
T_i rises, so the Gauss-Seidel method, which solves row by row, converges (R. W. Cottle, J.-S. Pang, R. E.
Stone, The Linear Complementarity Problem, 1992, section 5.2).
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from dualcam.common.arrays import Array

SWEEPS = 200  # most sweeps of the Gauss-Seidel method
TOLERANCE = 1e-13  # of the largest torque, for the change in a sweep


class FreeMotion(NamedTuple):
    """The ends of the shafts at the joints after a step without the shafts' torques, seen from the cams."""

    angle: Array  # at the end of the step [rad], shape (count, n)
    speed: Array  # at the end of the step [rad/s], shape (count, n)
    mobility: Array  # accelerations per torque [rad/s2 per N.m], shape (count, n, n)


class ShaftLaw(Protocol):
    """The law of one shaft over one step."""

    @property
    def coupling(self) -> float:
        """c of the module's text [N.m.s2/rad]."""
        ...

    def torque(self, mobility: Array, given: Array | float) -> Array:
        """The torque on the cam [N.m], shape (count,), of a mobility A_ii [rad/s2 per N.m] and c_i times the
        sum over the other shafts, `given` [N.m]."""
        ...


class CamLaw(NamedTuple):
    """Friction holds the cam at x while the torque is inside the stick band; at an edge the cam slips."""

    source: Array  # K (p - x), the torque if the joint did not give way [N.m], shape (count,)
    coupling: float  # c of the module's text [N.m.s2/rad]
    lower: Array  # edge of the stick band at x [N.m], shape (count,); infinite where a stop carries the cam
    upper: Array  # likewise

    def torque(self, mobility: Array, given: Array | float) -> Array:
        """The torque on the cam, as `ShaftLaw.torque`."""
        free = (self.source - given) / (1.0 + self.coupling * mobility)
        return np.minimum(np.maximum(free, self.lower), self.upper)


class DriveLaw(NamedTuple):
    """A cam with the inertia J slides on, or rests while the torques of shaft and motor are inside its stick
    band, or breaks away from rest. All arrays have the shape (count,).

    Within a step the law takes one of the three. A cam that comes to rest during a step moves a little
    beyond what the law says, up to h omega/2.
    """

    stiffness: float  # K of the shaft [N.m/rad]
    damping: float  # D of the shaft [N.m.s/rad]
    step: float  # h [s]
    angle: Array  # p minus the angle of the cam now [rad]
    speed: Array  # w minus the speed of the cam now [rad/s]
    omega: Array  # of the cam now [rad/s]
    alpha: Array  # of the cam without the shaft's torque if it slides [rad/s2]
    inertia: Array  # J [kg.m2]
    motor: Array  # N.m
    lower: Array  # edges of the stick band [N.m]
    upper: Array

    @property
    def coupling(self) -> float:
        """c of the module's text [N.m.s2/rad]."""
        return self.stiffness * self.step**2 + self.damping * self.step

    def torque(self, mobility: Array, given: Array | float) -> Array:
        """The torque on the cam, as `ShaftLaw.torque`."""
        h, stiffness, damping = self.step, self.stiffness, self.damping
        held = 1.0 + self.coupling * mobility
        yields = (stiffness * h**2 / 2.0 + damping * h) / self.inertia  # -d(K x + D x')/dT of a sliding cam
        at_rest = stiffness * self.angle + damping * (self.speed + self.omega) - given
        sliding = at_rest - stiffness * h * self.omega - damping * self.omega
        sliding = (sliding - self.inertia * yields * self.alpha) / (held + yields)
        slides_on = self.omega * (self.omega + h * (self.alpha + sliding / self.inertia)) > 0.0
        resting = at_rest / held
        edge = np.minimum(np.maximum(resting, self.lower - self.motor), self.upper - self.motor)
        breaking_away = (at_rest + yields * edge) / (held + yields)  # `resting` where that is inside the band
        return np.where(slides_on, sliding, breaking_away)


def shaft_torques(laws: Sequence[ShaftLaw], mobility: Array, start: Array) -> Array:
    """The torques of the shafts on the cams [N.m], shape (count, n), that satisfy all laws at once, iterated
    from `start`. `mobility`: accelerations per torque [rad/s2 per N.m], shape (count, n, n)."""
    if len(laws) == 1:
        return laws[0].torque(mobility[:, 0, 0], 0.0)[:, None]
    torques = start.copy()
    going = np.ones(len(torques), bool)  # each instance stops by itself, so that it moves as if it were alone
    for _ in range(SWEEPS):
        swept = torques.copy()
        for i, law in enumerate(laws):
            others = sum((mobility[:, i, j] * swept[:, j] for j in range(len(laws)) if j != i), np.zeros(1))
            swept[:, i] = law.torque(mobility[:, i, i], law.coupling * others)
        change = np.abs(swept - torques).max(axis=1)
        torques[going] = swept[going]
        going &= change > TOLERANCE * np.abs(swept).max(axis=1)
        if not going.any():
            break
    return torques
