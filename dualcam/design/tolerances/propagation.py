"""Propagation of distributions through a function: Monte Carlo, and to first order beside it.

Monte Carlo: JCGM 101:2008. First order: the law of propagation of uncertainty for independent inputs,
JCGM 100:2008 (GUM), 5.1.2, at the means x of the inputs:

    u^2 = sum of (c_j u_j)^2     c_j = df/dx_j     contribution_j = (c_j u_j)^2/u^2

The sensitivities c_j come from a complex step, exact to rounding:

    f(x + i h u_j) = f(x) + i h u_j c_j + O(h^2)

Source: W. Squire, G. Trapp, Using complex variables to estimate derivatives of real functions, SIAM Review
40 (1998).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import norm

from dualcam.design.statics import Array
from dualcam.design.tolerances.tolerance import Tolerance, complex_steps, draw, means
from dualcam.errors import DesignError

STEP = 1e-30  # of the complex step, in standard uncertainties: its square vanishes beside 1
PERCENTILES = (2.5, 50.0, 97.5)

AnyArray = NDArray[Any]  # real or complex
Model = Callable[[Mapping[str, AnyArray]], ArrayLike]


@dataclass(frozen=True, eq=False)
class Budget:
    """First-order uncertainty budget, at the means of all tolerances.

    Attributes
    ----------
    names : The tolerances, shape (k,).
    value : The quantity at the means, shape (n,).
    sensitivity : Derivatives c_j of the quantity, in its unit over that of the tolerance, shape (k, n).
    part : Signed parts c_j u_j of the standard uncertainty, in the quantity's unit, shape (k, n).
    """

    names: tuple[str, ...]
    value: Array
    sensitivity: Array
    part: Array

    @property
    def standard_uncertainty(self) -> Array:
        """Combined standard uncertainty, shape (n,)."""
        return np.asarray(np.sqrt(np.sum(self.part**2, axis=0)))

    @property
    def contribution(self) -> Array:
        """Shares of the variance [%], shape (k, n); NaN where the uncertainty is zero."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(100.0 * self.part**2 / np.sum(self.part**2, axis=0))


@dataclass(frozen=True, eq=False)
class Propagation:
    """One quantity under tolerances.

    Attributes
    ----------
    values : The quantity in each sample of the Monte Carlo method, shape (samples, n).
    levels : Percentages of `percentiles`.
    percentiles : Percentiles of the values, shape (levels, n).
    budget : The same to first order.
    """

    values: Array
    levels: tuple[float, ...]
    percentiles: Array
    budget: Budget

    @property
    def mean(self) -> Array:
        """Mean of the values, shape (n,)."""
        return np.asarray(self.values.mean(axis=0))

    @property
    def standard_deviation(self) -> Array:
        """Standard deviation of the values, shape (n,)."""
        return np.asarray(self.values.std(axis=0, ddof=1))

    def percentile_interval(self, level: float, confidence: float = 0.95) -> tuple[Array, Array]:
        """The lower and upper end, shape (n,) each, of where the true percentile is.

        `level`: percentage, such as 97.5. `confidence`: probability that the interval, which a limited number
        of samples leaves, holds the true percentile. DesignError: a percentage outside 0 to 100, a confidence
        outside 0 to 1, or too few samples. By order statistics: the number of samples below the percentile is
        binomial for every distribution. Source: H. A. David, H. N. Nagaraja, Order Statistics (2003), section
        7.1.
        """
        from scipy.stats import binom

        check_levels((level,))
        check_confidence(confidence)
        count, tail = len(self.values), 0.5 * (1.0 - confidence)
        low = int(binom.ppf(tail, count, level / 100.0)) - 1
        high = int(binom.ppf(1.0 - tail, count, level / 100.0))
        if low < 0 or high >= count:
            raise DesignError(
                f"the {level:g} % percentile of {count} samples: more samples are needed for an interval,"
                f" about {math.ceil(4.0 * 100.0 / min(level, 100.0 - level))}"
            )
        ordered = np.sort(self.values, axis=0)
        return ordered[low], ordered[high]

    def agrees(self, digits: int = 1, coverage: float = 0.95) -> NDArray[np.bool_]:
        """Whether the first-order budget may be used instead of Monte Carlo, shape (n,).

        Both ends of the coverage interval are those of a normal distribution around the value at the means,
        within half a unit of the last digit that counts. `digits`: significant digits of the standard
        uncertainty that count. `coverage` probability of the interval that is compared. DesignError: no whole
        number of digits from 1 on, or a coverage outside 0 to 1. Source: JCGM 101:2008, 7.9.2 and clause 8.
        With 10,000 samples the ends of the interval are known to about 3 % of the standard uncertainty:
        enough for one digit, not for two.
        """
        if not isinstance(digits, int) or digits < 1:
            raise DesignError(f"digits = {digits!r}: allowed is a whole number, 1 or more")
        check_confidence(coverage, "coverage")
        uncertainty = self.budget.standard_uncertainty
        tails = 50.0 * (1.0 - coverage), 50.0 * (1.0 + coverage)
        low, high = np.percentile(self.values, tails, axis=0, method="inverted_cdf")
        half = float(norm.ppf(0.5 * (1.0 + coverage))) * uncertainty
        with np.errstate(divide="ignore"):
            last = np.floor(np.log10(np.where(uncertainty > 0.0, uncertainty, np.nan))) - (digits - 1)
        delta = np.where(uncertainty > 0.0, 0.5 * 10.0 ** np.nan_to_num(last), 0.0)
        value = self.budget.value
        return (np.abs(value - half - low) <= delta) & (np.abs(value + half - high) <= delta)


def propagate(
    model: Model,
    tolerances: Sequence[Tolerance],
    samples: int = 10_000,
    seed: int = 0,
    percentiles: Sequence[float] = PERCENTILES,
) -> Propagation:
    """Any function of parameters under tolerances.

    `model`: takes a dict of the parameters by name, each an array of shape (m,), and returns the quantity of
    shape (m,) or (m, n). NumPy operations that also take complex numbers; `abs`, `maximum` and comparisons of
    complex numbers have no derivative. `tolerances`: independent distributions. Any names, as the model has
    them. `samples` of the Monte Carlo method. `seed`: start of the random numbers. The same seed gives the
    same numbers. `percentiles`: percentages, 0 to 100. DesignError: bad arguments; a model that fails, that
    returns another shape, NaN, or no complex numbers for complex numbers.

    Examples
    --------
    >>> from scipy.stats import norm
    >>> from dualcam.design.tolerances import Tolerance, propagate
    >>> found = propagate(lambda x: 0.5 * x["force"], [Tolerance("force", norm(20.0, 0.1))])
    >>> found.budget.standard_uncertainty  # N.m: a lever of 0.5 m
    array([0.05])
    """
    levels = check_levels(percentiles)
    values = evaluate(model, draw(tolerances, samples, seed), samples)
    return summarize(values, first_order(model, tolerances), levels)


def summarize(values: Array, budget: Budget, levels: tuple[float, ...]) -> Propagation:
    """The result of values, shape (samples, n), and of their budget."""
    percentiles = np.percentile(values, levels, axis=0, method="inverted_cdf")  # also of infinite values
    return Propagation(values, levels, percentiles, budget)


def first_order(model: Model, tolerances: Sequence[Tolerance]) -> Budget:
    """The budget of a model at the means of the tolerances."""
    centre = {name: np.full(1, mean) for name, mean in means(tolerances).items()}
    value = evaluate(model, centre, 1)[0]
    steps = evaluate(model, complex_steps(tolerances, STEP), len(tolerances))
    return budget_of(tolerances, value, steps)


def budget_of(tolerances: Sequence[Tolerance], value: Array, steps: AnyArray) -> Budget:
    """The budget from the value at the means, shape (n,), and values at complex steps, shape (k, n)."""
    part = steps.imag / STEP
    uncertainties = np.array([one.standard_uncertainty for one in tolerances])
    return Budget(tuple(one.label for one in tolerances), value, part / uncertainties[:, None], part)


def evaluate(model: Model, parameters: Mapping[str, AnyArray], count: int) -> AnyArray:
    """The model's values, shape (count, n), real or complex as the parameters are."""
    is_complex = any(np.iscomplexobj(values) for values in parameters.values())
    try:
        found = np.asarray(model(parameters))
    except DesignError:
        raise
    except Exception as error:
        kind = "complex" if is_complex else "real"
        raise DesignError(
            f"the model fails for {kind} arrays ({type(error).__name__}: {error}): allowed is a function of a"
            " dict of arrays, made of NumPy operations that take complex numbers"
        ) from error
    if found.ndim not in (1, 2) or len(found) != count:
        raise DesignError(
            f"the model returns the shape {found.shape} for {count} values of each parameter: allowed are"
            f" ({count},) and ({count}, n)"
        )
    if is_complex and not np.iscomplexobj(found):
        raise DesignError(
            "the model returns real numbers for complex ones, so that its derivatives are unknown: allowed"
            " are NumPy operations that keep complex numbers"
        )
    bad = ~np.isfinite(found).reshape(count, -1).all(axis=1)
    if bad.any():
        first = {name: values[bad][0] for name, values in parameters.items()}
        raise DesignError(
            f"the model has no finite value for {int(bad.sum())} of {count} samples, the first: {first}"
        )
    return found.reshape(count, -1)


def check_levels(percentiles: Sequence[float]) -> tuple[float, ...]:
    """Percentages from 0 to 100, at least one."""
    try:
        levels = tuple(float(level) for level in percentiles)
    except (TypeError, ValueError):
        levels = ()
    if not levels or not all(0.0 <= level <= 100.0 for level in levels):
        raise DesignError(f"percentiles = {percentiles!r}: allowed are numbers from 0 to 100, at least one")
    if 0.0 < max(levels) <= 1.0:
        wanted = ", ".join(f"{100.0 * level:g}" for level in levels)
        raise DesignError(f"percentiles = {percentiles!r}: percentiles are in percent, such as ({wanted})")
    return levels


def check_confidence(value: float, name: str = "confidence") -> None:
    """A probability between 0 and 1, without both ends."""
    if not (isinstance(value, float | int) and 0.0 < value < 1.0):
        raise DesignError(f"{name} = {value!r}: allowed is a number between 0 and 1")
