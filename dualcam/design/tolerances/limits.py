"""Allowed values of a quantity, and the yield against them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from dualcam.common.arrays import real_array
from dualcam.design.statics import Array
from dualcam.design.tolerances.sampled_mechanism import QUANTITIES, UNITS
from dualcam.errors import DesignError

Bound = float | Sequence[float] | Array | Callable[[Array], Array | float]


@dataclass(frozen=True)
class Limit:
    """Allowed values of one quantity at all angles.

    `quantity`: a quantity of the analysis, one of "load", "release", "efficiency", "z", "backlash". `least`,
    `most`: bounds in the quantity's unit: one number, a value for each angle, shape (n,), or a function of
    the angles [rad]; None: none. DesignError: another quantity, no bound, or a least value above the most.

    Examples
    --------
    >>> from dualcam.design.tolerances import Limit
    >>> Limit("load", most=12.0).label
    'load <= 12 N.m'
    """

    quantity: str
    least: Bound | None = None
    most: Bound | None = None

    def __post_init__(self) -> None:
        check_quantity(self.quantity)
        if self.least is None and self.most is None:
            raise DesignError(f"limit of {self.quantity}: allowed is a bound: least, most, or both")
        numbers = [bound for bound in (self.least, self.most) if isinstance(bound, float | int | np.number)]
        if len(numbers) == 2 and not numbers[0] <= numbers[1]:
            raise DesignError(
                f"limit of {self.quantity}: least = {numbers[0]:.6g} and most = {numbers[1]:.6g}: allowed is"
                " least <= most"
            )

    @property
    def label(self) -> str:
        """The limit in words."""
        bounds = ((">=", self.least), ("<=", self.most))
        unit = "" if UNITS[self.quantity] == "1" else f" {UNITS[self.quantity]}"
        words = [f"{sign} {_shown(bound, unit)}" for sign, bound in bounds if bound is not None]
        return f"{self.quantity} {' and '.join(words)}"

    def holds(self, values: Array, theta: Array) -> NDArray[np.bool_]:
        """Which samples are inside the limit at all angles, shape (samples,).

        `values`: the quantity, shape (samples, n). `theta`: angles [rad], shape (n,). DesignError: a bound
        that is no number at some angle, or has another shape.
        """
        good = ~np.isnan(values)
        if self.least is not None:
            good &= values >= self._at(self.least, theta, "least")
        if self.most is not None:
            good &= values <= self._at(self.most, theta, "most")
        return np.asarray(good.all(axis=1))

    def _at(self, bound: Bound, theta: Array, name: str) -> Array:
        try:
            found = real_array(bound(theta) if callable(bound) else bound, name)
            found = np.broadcast_to(found, theta.shape)
        except Exception as error:  # whatever a user's function raises
            raise DesignError(
                f"limit of {self.quantity}: {name} = {bound!r:.60} ({type(error).__name__}: {error}): allowed"
                f" is a number, {len(theta)} numbers, or a function of an array of angles"
            ) from error
        if np.isnan(found).any():
            raise DesignError(
                f"limit of {self.quantity}: {name} is NaN at theta = {theta[np.isnan(found)][0]:.4g} rad"
            )
        return found


def _shown(bound: Bound, unit: str) -> str:
    if callable(bound):
        return "a function of theta"
    return f"{bound:.6g}{unit}" if isinstance(bound, float | int | np.number) else "given values"


@dataclass(frozen=True)
class Yield:
    """How many mechanisms are good.

    Attributes
    ----------
    label : Which limit.
    good, samples : Samples inside the limit, and all samples.
    interval
        Where the share of good mechanisms is with the probability `confidence`, by Clopper and Pearson.
    confidence : Probability of the interval.
    """

    label: str
    good: int
    samples: int
    interval: tuple[float, float]
    confidence: float

    @property
    def share(self) -> float:
        """Share of good samples, 0 to 1."""
        return self.good / self.samples

    def __str__(self) -> str:
        low, high = (f"{100.0 * end:.4g}" for end in self.interval)
        return (
            f"{self.label}: {100.0 * self.share:.4g} % of {self.samples} samples"
            f" ({100.0 * self.confidence:g} % interval {low} to {high} %)"
        )


def yield_of(good: NDArray[np.bool_], label: str, confidence: float = 0.95) -> Yield:
    """The share of good mechanisms with its interval.

    `good`: which independent samples are good, shape (samples,). `label` of the limit. `confidence`:
    probability of the interval. Source: C. J. Clopper, E. S. Pearson, Biometrika 26 (1934);
    `scipy.stats.binomtest`.
    """
    count = int(np.sum(good))
    found = binomtest(count, len(good)).proportion_ci(confidence, method="exact")
    return Yield(label, count, len(good), (float(found.low), float(found.high)), confidence)


def check_quantity(name: str) -> None:
    """DesignError for a quantity that the analysis does not have."""
    if name not in QUANTITIES:
        raise DesignError(f"quantity {name!r}: allowed are {', '.join(QUANTITIES)}")
