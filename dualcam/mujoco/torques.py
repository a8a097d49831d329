"""The torques of all shafts over one step, solved together with the motion at the end of the step.

Without the shafts' torques the end of shaft i at the joint would reach the angle p_i and the speed w_i
(`FreeMotion`). Torques T_j on the cams, which oppose the joints, change both:

    theta_i = p_i - h^2 sum_j A_ij T_j        omega_i = w_i - h sum_j A_ij T_j

with the mobility A, the joints' accelerations per torque, seen from the cams. Each shaft answers with

    T_i = clamp(K_i (theta_i - x_i) + D_i (omega_i - x_i'),  lower_i, upper_i)

where x_i is the cam's angle. So T_i is that of the backward Euler method, which is stable for every
stiffness K_i. `ShaftLaw` holds that law with theta_i and omega_i put in:

    (1 + c_i A_ii + d_i) T_i = b_i - c_i sum_(j != i) A_ij T_j,   then the clamp;   c_i = K_i h^2 + D_i h

and d_i is the same for the motion that T_i gives the cam itself. A is symmetric and positive definite, so the
Gauss-Seidel method with the clamp after each row converges (R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear
Complementarity Problem, 1992, section 5.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from dualcam.reals import Array

SWEEPS = 200  # most sweeps of the Gauss-Seidel method
TOLERANCE = 1e-13  # of the largest torque, for the change in a sweep


class FreeMotion(NamedTuple):
    """The ends of the shafts at the joints after a step without the shafts' torques, seen from the cams.

    Parameters
    ----------
    angle, speed : ndarray, shape (count, n)
        Angles [rad] and speeds [rad/s] at the end of the step.
    mobility : ndarray, shape (count, n, n)
        Accelerations per torque [rad/s2 per N.m].
    """

    angle: Array
    speed: Array
    mobility: Array


class ShaftLaw(NamedTuple):
    """The law of one shaft over one step, arrays of shape (count,).

    Parameters
    ----------
    source : ndarray
        Torque if neither the joint nor the cam gave way to torques [N.m].
    coupling : ndarray or float
        c of the module's text [N.m.s2/rad].
    compliance : ndarray or float
        d of the module's text [1].
    lower, upper : ndarray or float
        Bounds of the torque [N.m].
    """

    source: Array
    coupling: Array | float
    compliance: Array | float
    lower: Array | float
    upper: Array | float


def shaft_torques(laws: Sequence[ShaftLaw], mobility: Array, start: Array) -> Array:
    """The torques that satisfy all laws at once.

    Parameters
    ----------
    laws : sequence of ShaftLaw, length n
        The shafts.
    mobility : ndarray, shape (count, n, n)
        Accelerations per torque [rad/s2 per N.m].
    start : ndarray, shape (count, n)
        Where the iteration starts: the torques of the last step [N.m].

    Returns
    -------
    ndarray, shape (count, n)
        Torques of the shafts on the cams [N.m].
    """
    if len(laws) == 1:
        return _torque(laws[0], mobility[:, 0, 0], 0.0)[:, None]
    torques = start.copy()
    for _ in range(SWEEPS):
        before = torques.copy()
        for i, law in enumerate(laws):
            own = mobility[:, i, i]
            others = np.einsum("nj,nj->n", mobility[:, i], torques) - own * torques[:, i]
            torques[:, i] = _torque(law, own, law.coupling * others)
        if np.abs(torques - before).max() <= TOLERANCE * np.abs(torques).max():
            break
    return torques


def _torque(law: ShaftLaw, mobility: Array, others: Array | float) -> Array:
    free = (law.source - others) / (1.0 + law.coupling * mobility + law.compliance)
    return np.minimum(np.maximum(free, law.lower), law.upper)
