"""Model predictive path integral control (MPPI): a plan is improved by the costs of random plans around it.

Sources: G. Williams, A. Aldrich, E. A. Theodorou, Journal of Guidance, Control, and Dynamics 40 (2017), for
weights and update; Z. Yi et al., CoVO-MPC, L4DC (2024), for noise shaped by the curvature of the cost.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from dualcam.design.statics import Array
from dualcam.errors import DualcamError

TEMPERATURES = (1e-9, 1e9)  # of the range of the costs, between which the temperature lies


def path_integral_weights(costs: Array, temperature: float) -> Array:
    """The weights of plans, exp(-cost/temperature) with the sum 1, shape (count,).

    `costs` of the plans, shape (count,). `temperature`: in the unit of the costs, > 0.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.blocks.path_integral import path_integral_weights
    >>> path_integral_weights(np.array([3.0, 3.0 + np.log(4.0)]), 1.0).round(6).tolist()
    [0.8, 0.2]
    """
    weights = np.exp((np.min(costs) - costs) / temperature)
    return weights / np.sum(weights)


def effective_size(weights: Array) -> float:
    """How many plans of equal weight would average as much, 1 to count: 1/sum(weights^2) (Kish).

    `weights` with the sum 1, shape (count,).

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.blocks.path_integral import effective_size
    >>> effective_size(np.full(4, 0.25))
    4.0
    """
    return 1.0 / float(weights @ weights)


def temperature_of(costs: Array, size: float) -> float:
    """The temperature, in the unit of the costs, at which the weights have an effective `size`.

    It is an end of a wide range where no temperature gives that size. `costs` of the plans, shape (count,).

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.blocks.path_integral import effective_size, path_integral_weights, temperature_of
    >>> costs = np.array([1.0, 2.0, 4.0, 8.0])
    >>> round(effective_size(path_integral_weights(costs, temperature_of(costs, 2.5))), 6)
    2.5
    """
    span = float(np.max(costs) - np.min(costs))
    if span == 0.0:
        return 1.0
    low, high = np.log(span * np.array(TEMPERATURES))

    def excess(logarithm: float) -> float:
        return effective_size(path_integral_weights(costs, float(np.exp(logarithm)))) - size

    if excess(low) >= 0.0:
        return float(np.exp(low))
    return float(np.exp(high if excess(high) <= 0.0 else brentq(excess, low, high, xtol=1e-9)))


def spline_basis(horizon: int, knots: int) -> Array:
    """Cubic splines at the periods of a plan, shape (horizon, knots): column i is 1 at knot i, 0 at the
    others.

    `horizon`: periods of the plan. `knots`: number of knots, evenly spread from the first period to the last.

    Examples
    --------
    >>> from dualcam.systems.blocks.path_integral import spline_basis
    >>> spline_basis(horizon=5, knots=3)[::2].tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    places = np.linspace(0.0, horizon - 1.0, knots)
    return CubicSpline(places, np.eye(knots))(np.arange(horizon))


def shaped_basis(basis: Array, curvature: Array) -> Array:
    """A basis, shape (horizon, knots), whose normally distributed coefficients all cost the same on average.

    Where the cost is quadratic, each column adds 1/2 with unit coefficients, and no two columns share a cost.
    `basis` of the noise, shape (horizon, knots). `curvature`: second derivative of the cost by the plan,
    positive definite, shape (horizon, horizon).

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.blocks.path_integral import shaped_basis
    >>> shaped_basis(np.eye(2), np.diag([4.0, 25.0])).tolist()
    [[0.5, 0.0], [0.0, 0.2]]
    """
    lower = np.linalg.cholesky(basis.T @ curvature @ basis)
    return basis @ np.linalg.inv(lower).T


class Noise(NamedTuple):
    """Random deviations of plans: each is a normal draw of coefficients times a scale of its own.

    `basis`: what the coefficients multiply, shape (horizon, knots). `scales`: scale of each deviation, shape
    (count,).
    """

    basis: Array
    scales: Array

    def draw(self, random: np.random.Generator) -> Array:
        """Random deviations, shape (count, horizon). `random`: where the random numbers come from."""
        coefficients = random.standard_normal((len(self.scales), self.basis.shape[1]))
        return (self.scales[:, None] * coefficients) @ self.basis.T


class PathIntegralPlanner:
    """A plan of inputs over a horizon, improved by random plans around it.

    The random plans come in pairs, plan + deviation and plan - deviation: a pair of equal costs does not move
    the plan. The temperature follows from the wanted effective size, so no scale of the costs has to be
    guessed.

    Parameters
    ----------
    noises : Deviations, all over the same horizon.
    limit : Largest magnitude of an input.
    size : Effective number of plans in the mean.
    random : Where the random numbers come from.

    Attributes
    ----------
    plan : The inputs by period, shape (horizon,).

    Raises
    ------
    DualcamError : A limit or a size that is not allowed.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.blocks.path_integral import Noise, PathIntegralPlanner
    >>> noise = Noise(np.eye(3), np.geomspace(1e-3, 1.0, 32))
    >>> planner = PathIntegralPlanner([noise], limit=2.0, size=3.0, random=np.random.default_rng(1))
    >>> for _ in range(100):  # the cheapest plan is (1, 1, 1)
    ...     plans = planner.candidates()
    ...     planner.update(plans, np.sum((plans - 1.0) ** 2, axis=1))
    >>> bool(np.abs(planner.plan - 1.0).max() < 1e-2)
    True
    """

    def __init__(
        self, noises: Sequence[Noise], limit: float, size: float, random: np.random.Generator
    ) -> None:
        if not (0.0 < limit < np.inf):
            raise DualcamError(f"limit = {limit}: allowed is a finite number > 0")
        if not (1.0 < size < np.inf):
            raise DualcamError(f"size = {size}: allowed is a finite number > 1")
        self.plan = np.zeros(len(noises[0].basis))
        self._noises, self._limit, self._size, self._random = tuple(noises), limit, size, random

    @property
    def count(self) -> int:
        """Number of candidates."""
        return 1 + 2 * sum(len(noise.scales) for noise in self._noises)

    def shift(self) -> None:
        """Go on by one period: the first input is gone, the last one is repeated."""
        self.plan = np.append(self.plan[1:], self.plan[-1])

    def candidates(self) -> Array:
        """The plan, in row 0, and random plans around it, shape (count, horizon)."""
        drawn = np.concatenate([noise.draw(self._random) for noise in self._noises])
        around = np.concatenate([np.zeros((1, len(self.plan))), drawn, -drawn])
        return np.clip(self.plan + around, -self._limit, self._limit)

    def update(self, candidates: Array, costs: Array) -> None:
        """Replace the plan by the weighted mean of the candidates.

        `candidates`: plans, shape (count, horizon). `costs`: their costs, shape (count,). DualcamError: a
        cost is missing or not finite: the plan stays.
        """
        if costs.shape != (len(candidates),):
            raise DualcamError(
                f"costs has shape {costs.shape}: allowed is ({len(candidates)},), one per plan"
            )
        wrong = np.flatnonzero(~np.isfinite(costs))
        if wrong.size:
            raise DualcamError(f"costs[{wrong[0]}] = {costs[wrong[0]]}: allowed are finite numbers")
        self.plan = path_integral_weights(costs, temperature_of(costs, self._size)) @ candidates
