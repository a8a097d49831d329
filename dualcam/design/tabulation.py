"""The table of a designed groove.

Its samples are found by halving: where the FMU's curve through the samples misses the wanted torque by more
than the tolerance, the samples are set twice as close.
"""

import numpy as np

from dualcam.design.design import Design
from dualcam.design.groove_equation import GrooveProblem, GrooveSolution
from dualcam.design.grooves import Groove, Table
from dualcam.design.mechanism import Mechanism
from dualcam.design.statics import Array
from dualcam.errors import DesignError

FIRST_INTERVALS = 48
CLOSEST = 1e-9  # rad between samples; closer ones would have slopes of rounding errors
MOST_SAMPLES = 20_000


def tabulate(problem: GrooveProblem, solution: GrooveSolution, contacts: int, tolerance: float) -> Design:
    """The design whose table gives the torque to the tolerance. DesignError if no table does."""
    theta = np.unique([*np.linspace(0.0, problem.upper, FIRST_INTERVALS + 1), *problem.kinks])
    while True:
        design, error = _attempt(problem, solution, theta, contacts)
        if design.largest_error <= tolerance:
            return design
        close = np.diff(design.table.psi) < CLOSEST
        coarse = error > tolerance
        # a sample's slope comes from two intervals on either side
        for _ in range(2):
            coarse |= np.append(coarse[1:], False) | np.insert(coarse[:-1], 0, False)
        if len(theta) > MOST_SAMPLES or (close[: len(coarse)] & coarse).any():
            raise DesignError(
                f"{problem.where(design.largest_error_at)}: no table gives the torque there to {tolerance:g},"
                f" at {len(theta)} samples the torque is missed by {design.largest_error:.3g}: the torque"
                " must be continuous (measured samples: smooth or thin them), the angles of its kinks must be"
                " given as kinks, and the grooves must not get near level or upright"
            )
        theta = np.sort(np.append(theta, 0.5 * (theta[:-1] + theta[1:])[coarse]))


def _attempt(
    problem: GrooveProblem, solution: GrooveSolution, theta: Array, contacts: int
) -> tuple[Design, Array]:
    """The design with samples at theta, and the largest error in each interval between them."""
    state = solution(theta)
    psi, z = (0.5 * theta, state) if problem.groove2 is None else (theta - state, problem.height(state))
    # slightly beyond the upper stop, so that rounding does not put the stop behind the groove's end
    psi, z = np.append(psi[:-1], psi[-1] * (1.0 + 1e-13)), np.maximum.accumulate(z)
    table = Table(problem.radius[0], psi, z)
    second: Groove = table if problem.groove2 is None else problem.groove2
    mechanism = Mechanism((table, second), problem.friction, problem.spring, problem.upper, contacts)
    share = np.array([0.0, 0.12, 0.31, 0.5, 0.69, 0.88])
    angles = theta[:-1, None] + share * np.diff(theta)[:, None]
    angles = np.append(angles.ravel(), theta[-1])
    design = Design(mechanism, problem.direction, problem.wanted, 0.0, 0.0)
    error = np.abs(design.error(angles))
    largest = int(np.argmax(error))
    found = Design(
        mechanism, problem.direction, problem.wanted, float(error[largest]), float(angles[largest])
    )
    by_interval = np.maximum(error[:-1].reshape(-1, len(share)).max(axis=1), 0.0)
    by_interval[-1] = max(by_interval[-1], error[-1])
    return found, by_interval
