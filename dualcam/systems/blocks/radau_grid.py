"""The grid of a plan by direct collocation: equal intervals, each with the nodes of Radau's rule."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import roots_jacobi

from dualcam.design.statics import Array


@dataclass(frozen=True)
class RadauGrid:
    """Radau IIA collocation: the last node of an interval is its end.

    Source: L. T. Biegler, Nonlinear Programming, SIAM 2010, chapter 10. `duration` of the plan [s].
    `intervals`: number of intervals. `nodes` in each interval.

    Examples
    --------
    >>> from dualcam.systems.blocks.radau_grid import RadauGrid
    >>> grid = RadauGrid(duration=0.6, intervals=2, nodes=2)
    >>> grid.time.round(6).tolist()  # s
    [0.0, 0.1, 0.3, 0.4, 0.6]
    """

    duration: float
    intervals: int
    nodes: int

    @property
    def interval(self) -> float:
        """Length of an interval [s]."""
        return self.duration / self.intervals

    @cached_property
    def shares(self) -> Array:
        """The nodes of an interval as shares of its length, shape (nodes,)."""
        inner = roots_jacobi(self.nodes - 1, 1.0, 0.0)[0] if self.nodes > 1 else np.array([])
        return np.append(0.5 * (1.0 + inner), 1.0)

    @property
    def time(self) -> Array:
        """The start and all nodes [s], shape (intervals*nodes + 1,)."""
        starts = np.arange(self.intervals)[:, np.newaxis]
        return np.append(0.0, self.interval * (starts + self.shares).ravel())

    @cached_property
    def slopes(self) -> Array:
        """States at start and nodes of an interval, times this matrix: their time derivatives at the nodes.

        Shape (nodes + 1, nodes) [1/s].
        """
        places = np.append(0.0, self.shares)
        powers = np.vander(places, increasing=True)
        order = np.arange(1, self.nodes + 1)
        derivatives = order * np.vander(self.shares, self.nodes, increasing=True)
        return np.linalg.solve(powers.T, np.vstack([np.zeros(self.nodes), derivatives.T])) / self.interval

    @cached_property
    def weights(self) -> Array:
        """The integral over an interval is the sum of these weights [s] times the values at the nodes."""
        order = np.arange(self.nodes)
        powers = np.vander(self.shares, increasing=True)
        return np.linalg.solve(powers.T, 1.0 / (order + 1.0)) * self.interval

    def derivatives_at_start(self, values: Array) -> Array:
        """Derivatives at each interval's start of the polynomial through `values` at the nodes.

        Both have the shape (intervals, nodes). Row i, column k: time derivative of order k at the start of
        interval i, in the values' unit per s^k.
        """
        powers = np.vander(self.shares, increasing=True)
        order = np.arange(self.nodes)
        scale = np.array([math.factorial(k) for k in order]) / self.interval**order
        found: Array = np.linalg.solve(powers, values.T).T * scale
        return found
