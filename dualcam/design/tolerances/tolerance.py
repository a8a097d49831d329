"""A parameter that is known as a distribution only."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from dualcam.common.entries import is_whole
from dualcam.common.unit_guards import unit_warning
from dualcam.design.statics import Array, is_number
from dualcam.errors import DesignError, UnitWarning

SHARE_OUTSIDE = 1e-9  # of a distribution that may lie outside the allowed values: no sample falls there
LEAST_SHARE = 2.0**-54  # of a distribution below a sample: a normal one has no value at 0
MOST_SAMPLES = 10_000_000  # 80 MB of memory for each tolerance
RARE = 1e-6  # share of a distribution without an end that counts as beyond its values
ROUND_OFF = 1e-12  # relative: limits that are worked out may miss the nominal value by so much
SIGMAS = 3.0  # half-widths of a normal distribution between its limits, in standard deviations
SHAPES = ("normal", "uniform", "triangular")


@dataclass(frozen=True)
class Tolerance:
    """The distribution of one parameter, or of several that always have the same value.

    Parameters
    ----------
    name
        Parameter, such as `"cam1.friction"`. Several names share each value: `("cam1.friction",
        "cam2.friction")` are two contacts with one grease.
    distribution
        Frozen distribution of scipy.stats, such as `scipy.stats.norm(0.14, 0.01)`, in the parameter's unit.

    Raises
    ------
    DesignError
        No name, something that is no distribution, or a distribution without a mean or a standard deviation.

    Examples
    --------
    >>> from scipy.stats import norm
    >>> from dualcam.design.tolerances import Tolerance
    >>> grease = Tolerance(("cam1.friction", "cam2.friction"), norm(0.14, 0.01))
    >>> grease.mean, grease.standard_uncertainty
    (0.14, 0.01)
    """

    name: str | Sequence[str]
    distribution: Any

    def __post_init__(self) -> None:
        names = self.names if isinstance(self.name, str | Sequence) else ()
        if not names or not all(isinstance(name, str) and name for name in names):
            raise DesignError(f"name = {self.name!r}: allowed is a name, or a sequence of different names")
        if len(set(names)) < len(names):
            raise DesignError(f"name = {self.name!r}: a name stands there twice")
        if not isinstance(self.distribution, stats.distributions.rv_frozen):
            raise DesignError(
                f"{self.label}: distribution = {self.distribution!r}: allowed is a distribution of"
                " scipy.stats with its numbers, such as scipy.stats.norm(0.14, 0.01);"
                " Tolerance.within(name, low, high) makes one from limits"
            )
        if np.ndim(self.distribution.mean()) > 0:
            raise DesignError(
                f"{self.label}: the distribution has arrays as numbers: allowed are single numbers"
            )
        for what, value in (("mean", self.mean), ("standard deviation", self.standard_uncertainty)):
            if not math.isfinite(value):
                raise DesignError(
                    f"{self.label}: the {what} of the distribution is {value}: allowed is a finite number"
                )

    @classmethod
    def named(cls, name: str | Sequence[str], distribution: str, **numbers: float) -> Tolerance:
        """A tolerance by the name of a distribution of scipy.stats.

        `name`: parameter, or parameters that share each value. `distribution`: name of a continuous
        distribution of scipy.stats, such as "norm", "uniform", "lognorm". `**numbers`: its numbers by SciPy's
        names, such as `loc` and `scale`. DesignError: an unknown distribution, or numbers that this
        distribution does not have.

        Examples
        --------
        >>> from dualcam.design.tolerances import Tolerance
        >>> Tolerance.named("spring.preload", "norm", loc=50.0, scale=2.0).mean
        50.0
        """
        found = getattr(stats, distribution, None) if isinstance(distribution, str) else None
        if not isinstance(found, stats.rv_continuous):
            known = [key for key, value in vars(stats).items() if isinstance(value, stats.rv_continuous)]
            near = get_close_matches(str(distribution), known, n=3)
            guess = f"did you mean {' or '.join(near)}?" if near else "common ones are norm, uniform, triang"
            raise DesignError(
                f"distribution = {distribution!r}: no continuous distribution of scipy.stats; {guess}"
            )
        try:
            frozen = found(**numbers)
            low, high = frozen.support()
        except TypeError as error:
            words = [*(found.shapes or "").replace(",", " ").split(), "loc", "scale"]
            raise DesignError(
                f"distribution {distribution} with {numbers}: allowed are the numbers {', '.join(words)}"
            ) from error
        if math.isnan(low) or math.isnan(high):
            raise DesignError(f"distribution {distribution} with {numbers}: there is no such distribution")
        return cls(name, frozen)

    @classmethod
    def within(cls, name: str | Sequence[str], low: float, high: float, shape: str = "normal") -> Tolerance:
        """A tolerance from the limits on a drawing.

        `name`: parameter, or parameters that share each value. `low`, `high`: least and greatest value of the
        parameter, in its unit. Not deviations: 20 mm +- 0.02 mm has the limits 0.01998 and 0.02002. `shape`:
        "normal": the limits are three standard deviations from the middle; parts beyond them are sorted out.
        "uniform": nothing but the limits is known. "triangular": the middle is more likely. DesignError:
        limits that are no numbers or do not grow, or another shape. Source: JCGM 100:2008 (GUM), 4.3.7 and
        4.3.9: the standard uncertainty of half-width a is a/sqrt(3) for "uniform" and a/sqrt(6) for
        "triangular".

        Examples
        --------
        >>> from dualcam.design.tolerances import Tolerance
        >>> radius = Tolerance.within("cam1.radius", 0.01995, 0.02005, "uniform")
        >>> f"{radius.standard_uncertainty:.3e}"  # m
        '2.887e-05'
        """
        for limit in (low, high):
            if not is_number(limit):
                raise DesignError(
                    f"{name}: limit {limit!r}: allowed is a number in the unit of the parameter, such as"
                    " 0.01998 for 19.98 mm"
                )
        if not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise DesignError(
                f"{name}: limits {low} and {high}: allowed are two finite numbers that grow; limits are"
                " values, not deviations from the nominal value"
            )
        middle, width = 0.5 * (low + high), high - low
        if shape == "normal":
            return cls(name, stats.truncnorm(-SIGMAS, SIGMAS, middle, 0.5 * width / SIGMAS))
        if shape == "uniform":
            return cls(name, stats.uniform(low, width))
        if shape == "triangular":
            return cls(name, stats.triang(0.5, low, width))
        raise DesignError(f"{name}: shape = {shape!r}: allowed are {', '.join(SHAPES)}")

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters."""
        return (self.name,) if isinstance(self.name, str) else tuple(self.name)

    @property
    def label(self) -> str:
        """The parameters in words: `cam1.friction = cam2.friction` for two that share each value."""
        return " = ".join(map(str, self.names))

    @property
    def mean(self) -> float:
        """Mean of the distribution."""
        return float(self.distribution.mean())

    @property
    def standard_uncertainty(self) -> float:
        """Standard deviation of the distribution."""
        return float(self.distribution.std())

    def require_inside(self, least: float, greatest: float, allowed: str) -> None:
        """DesignError for a distribution of which more than a share of 1e-9 lies outside the allowed values.

        `least`, `greatest`: allowed values. `allowed`: the allowed values in words.
        """
        below = float(self.distribution.cdf(np.nextafter(least, -np.inf))) if math.isfinite(least) else 0.0
        above = float(self.distribution.sf(greatest)) if math.isfinite(greatest) else 0.0
        if below + above > SHARE_OUTSIDE:
            low, high = (float(self.distribution.ppf(share)) for share in (0.001, 0.999))
            looks = (unit_warning(self.names[0], self.mean) or "").partition(": ")[2]
            if looks:
                hint = f"the mean, {self.mean:.6g}: {looks}"
            elif all(map(math.isfinite, self.distribution.support())):
                hint = "limits are values of the parameter, not deviations from the nominal value"
            else:
                hint = "Tolerance.within(name, low, high) has no values outside its limits"
            raise DesignError(
                f"{self.label}: {100.0 * (below + above):.3g} % of the distribution is outside the allowed"
                f" values: allowed is {allowed}. 99.8 % of it are from {low:.6g} to {high:.6g}; {hint}"
            )

    def warn_without(self, name: str, nominal: float) -> None:
        """Warn if the nominal value of a parameter is no value of the distribution.

        `name`: one of the parameters. `nominal`: value of the design.

        Warns
        -----
        UnitWarning : With both, and the likely unit.
        """
        low, high = map(float, self.distribution.support())
        low = low if math.isfinite(low) else float(self.distribution.ppf(RARE))
        high = high if math.isfinite(high) else float(self.distribution.isf(RARE))
        slack = ROUND_OFF * max(abs(low), abs(high))
        if low - slack <= nominal <= high + slack:
            return
        looks = (unit_warning(name, self.mean) or "").partition(": ")[2]
        text = (
            f"{name}: the tolerance has values from {low:.6g} to {high:.6g}, the design has {nominal:.6g}:"
            f" {looks or 'limits are values of the parameter in its SI unit, not deviations'}"
        )
        warnings.warn(UnitWarning(text), stacklevel=4)


def draw(tolerances: Sequence[Tolerance], samples: int, seed: int) -> dict[str, Array]:
    """Independent values of all parameters by name, shape (samples,), whatever tolerances come later.

    By the inverse of the distribution function (JCGM 101:2008, C.2), a seed gives the same values with every
    SciPy.
    """
    check_names(tolerances)
    if not is_whole(samples) or not 2 <= samples <= MOST_SAMPLES:
        raise DesignError(f"samples = {samples!r}: allowed is a whole number from 2 to {MOST_SAMPLES}")
    if not is_whole(seed) or seed < 0:
        raise DesignError(f"seed = {seed!r}: allowed is a whole number, 0 or more")
    found: dict[str, Array] = {}
    for place, tolerance in enumerate(tolerances):
        random = np.random.default_rng([seed, place])
        share = np.maximum(random.random(samples), LEAST_SHARE)
        values = np.asarray(tolerance.distribution.ppf(share), dtype=float)
        found |= dict.fromkeys(tolerance.names, values)
    return found


def means(tolerances: Sequence[Tolerance]) -> dict[str, float]:
    """Means of all parameters by name."""
    return {name: one.mean for one in tolerances for name in one.names}


def complex_steps(tolerances: Sequence[Tolerance], step: float) -> dict[str, NDArray[Any]]:
    """The means by name; in row j tolerance j has the imaginary part `step` times its uncertainty."""
    found = {name: np.full(len(tolerances), mean, complex) for name, mean in means(tolerances).items()}
    for row, tolerance in enumerate(tolerances):
        for name in tolerance.names:
            found[name][row] += 1j * step * tolerance.standard_uncertainty
    return found


def check_names(tolerances: Sequence[Tolerance]) -> None:
    """DesignError for no tolerances, other things than tolerances, and a name in two tolerances."""
    if isinstance(tolerances, Mapping | str) or not isinstance(tolerances, Sequence) or not tolerances:
        raise DesignError(f"tolerances = {tolerances!r:.60}: allowed is a list of Tolerance, at least one")
    strange = [one for one in tolerances if not isinstance(one, Tolerance)]
    if strange:
        raise DesignError(f"tolerances: {strange[0]!r:.60} is no Tolerance")
    names = [name for one in tolerances for name in one.names]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DesignError(f"tolerances: {', '.join(twice)} stands in two tolerances: allowed is one for each")
