"""The values of one thing that varies: a range, a distribution, or a list."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from dualcam.common.arrays import TRUTH, Array, real_array
from dualcam.common.entries import is_whole
from dualcam.common.mistakes import StudyError
from dualcam.study.plan.distribution import Distribution
from dualcam.study.plan.texts import GivenTexts, Texts


@dataclass(frozen=True)
class Vary:
    """The values of one variable: a range, a distribution, or a list.

    Parameters
    ----------
    low, high : float
        Ends of the range, in the FMU's unit. With `distribution`: ends to which the distribution is
        truncated; one of them or both may be left out.
    count : int
        Of a grid: values from `low` to `high`, both included, 2 or more. With `distribution`: the middles of
        so many parts of equal probability.
    log : Whether the values are spread evenly in the logarithm.
    values : These values, instead of a range. Texts are those of a String parameter.
    distribution : "normal", or the name of a distribution of scipy.stats.
    arguments : mapping of str to float
        Arguments of the distribution: `mean` and `std` of "normal"; others by their names in scipy.stats.
    weights : Of `values`: how often each is drawn, relative to the others; equally often if not given.
    unit : Of a name that is no variable of the FMU: for labels.

    Examples
    --------
    >>> from dualcam.study import Vary
    >>> Vary(0.5, 1.0, count=3).points().tolist()
    [0.5, 0.75, 1.0]
    >>> Vary(values=[0.08, 0.14]).size()
    2
    >>> friction = Vary(distribution="normal", arguments={"mean": 0.14, "std": 0.02}, low=0.08, high=0.2)
    >>> friction.limits()
    (0.08, 0.2)
    """

    low: float = math.nan
    high: float = math.nan
    count: int = 0
    log: bool = False
    values: Sequence[float] | Sequence[str] | Texts = ()
    distribution: str = ""
    arguments: Mapping[str, float] = field(default_factory=dict)
    weights: Sequence[float] = ()
    unit: str = ""

    def problems(self, in_grid: bool) -> list[str]:
        """All that is wrong with the values.

        Parameters
        ----------
        in_grid : Whether the plan is a grid, which needs a count.

        Returns
        -------
        list of str
            What is given and what is allowed.
        """
        if self.is_list:
            return self._problems_of_list()
        found = self._problems_of_distribution() if self.distribution else self._problems_of_range()
        if len(self.weights) > 0:
            found.append("weights without values: allowed are weights of a list of values")
        is_given = bool(self.distribution) or not math.isnan(self.low + self.high)
        has_count = is_whole(self.count) and self.count >= (1 if self.distribution else 2)
        if in_grid and is_given and not has_count:
            found.append(f"count = {self.count!r}: a grid needs a whole number, 2 or more, or values")
        return found

    def _problems_of_distribution(self) -> list[str]:
        log = f"distribution {self.distribution} with log = true: allowed is log for a range alone"
        found = [log] if self.log else []
        try:
            self.spread  # noqa: B018  made here for its checks
        except StudyError as error:
            found.append(str(error))
        return found

    def _problems_of_range(self) -> list[str]:
        if self.arguments:
            given = ", ".join(self.arguments)
            return [f"{given} without distribution: give for example distribution = 'normal'"]
        if lacking := [word for word, end in (("from", self.low), ("to", self.high)) if math.isnan(end)]:
            return [f"lacks {' and '.join(lacking)}: allowed are from and to, values, or a distribution"]
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            allowed = "allowed are finite numbers, the first below the second, or values"
            return [f"from {self.low:g} to {self.high:g}: {allowed}"]
        if self.log and self.low <= 0.0:
            return [f"from {self.low:g} on a logarithmic scale: allowed is above 0"]
        return []

    def _problems_of_list(self) -> list[str]:
        found = []
        if self.distribution:
            found.append(f"values and distribution {self.distribution}: allowed is one of them")
        try:
            numbers, weights = self._numbers, real_array(self.weights, "weights", StudyError)
        except StudyError as error:
            return [*found, str(error)]
        if not np.all(np.isfinite(numbers)):
            strange = next(value for value in numbers if not math.isfinite(value))
            found.append(f"values with {strange}: allowed are finite numbers")
        if len(self.weights) == 0:
            return found
        if len(weights) != len(self.values):
            found.append(f"{len(weights)} weights of {len(self.values)} values: allowed is one for each")
        if not (np.all(np.isfinite(weights)) and np.all(weights >= 0.0) and weights.sum() > 0.0):
            found.append(f"weights = {weights.tolist()}: allowed are finite numbers, 0 or more, not all 0")
        return found

    # ---- what it is ----

    @property
    def is_list(self) -> bool:
        """Whether the values are given one by one."""
        return len(self.values) > 0

    @cached_property
    def texts(self) -> Texts | None:
        """The texts of a String parameter; None for numbers."""
        if isinstance(self.values, Texts):
            return self.values
        is_text = any(isinstance(value, str) for value in self.values)
        return GivenTexts.of([str(value) for value in self.values]) if is_text else None

    @cached_property
    def _numbers(self) -> Array:
        """The values; of texts their places."""
        if self.texts is not None:
            return np.arange(float(len(self.values)))
        return real_array(self.values, "values", StudyError, kinds=TRUTH)  # type: ignore[arg-type]

    @cached_property
    def spread(self) -> Distribution:
        """The distribution. StudyError if the distribution cannot be."""
        return Distribution(self.distribution, self.arguments, self.low, self.high)

    @property
    def is_whole(self) -> bool:
        """Whether all values are whole numbers."""
        if self.is_list:
            return self.texts is None and bool(np.all(self._numbers == np.round(self._numbers)))
        return bool(self.distribution) and self.spread.is_whole

    def limits(self) -> tuple[float, float]:
        """Least and greatest value, in the FMU's unit; infinite for a distribution without an end. Of texts:
        first and last place."""
        if self.is_list:
            return float(self._numbers.min()), float(self._numbers.max())
        if self.distribution:
            return self.spread.low, self.spread.high
        return float(self.low), float(self.high)

    def share_outside(self, least: float, most: float) -> float:
        """Share of the values that lie outside of a range.

        Parameters
        ----------
        least, most : Ends of the range, which count as inside.

        Returns
        -------
        float
            From 0 to 1; of a list by its weights.
        """
        if self.distribution:
            below = self.spread.share_below(least, inclusive=False) if math.isfinite(least) else 0.0
            return below + (self.spread.share_above(most) if math.isfinite(most) else 0.0)
        if self.is_list:
            outside = (self._numbers < least) | (self._numbers > most)
            weights = np.asarray(self.weights, float) if len(self.weights) else None
            return float(np.average(outside, weights=weights))
        low, high = self.limits()
        if self.log:
            low, high, least, most = (math.log(x) if x > 0.0 else -math.inf for x in (low, high, least, most))
        inside = max(min(high, most) - max(low, least), 0.0)
        return 1.0 - inside / (high - low)

    # ---- values ----

    def at(self, share: Array) -> Array:
        """Values at shares of the way through the range, or of the probability.

        Parameters
        ----------
        share : Shares in [0, 1], shape (n,).

        Returns
        -------
        ndarray, shape (n,)
            Values, in the FMU's unit. Of texts: their places.
        """
        if self.is_list:
            return self._numbers[self._place(share)]
        if self.distribution:
            return self.spread.at(share)
        low, high = self.low, self.high
        grown = low * (high / low) ** share if self.log else low + (high - low) * share
        return np.clip(grown, low, high)  # rounding must not leave the range

    def _place(self, share: Array) -> Any:  # noqa: ANN401
        count = len(self.values)
        if len(self.weights) == 0:
            return np.minimum((share * count).astype(int), count - 1)
        ends = np.cumsum(self.weights) / np.sum(self.weights)
        last = int(np.flatnonzero(np.asarray(self.weights))[-1])
        return np.minimum(np.searchsorted(ends, share, side="right"), last)

    def size(self) -> int:
        """How many values there are in a grid."""
        return len(self.values) or self.count

    def points(self) -> Array:
        """The values in a grid, in the FMU's unit."""
        if self.is_list:
            return self._numbers
        if self.distribution:
            return self.at((np.arange(self.count) + 0.5) / self.count)
        return self.at(np.linspace(0.0, 1.0, self.count))

    def facts(self) -> list[Any]:
        """What makes two of these the same, as plain data."""
        values: Any = [float(x) for x in self._numbers] if self.texts is None else self.texts.facts()
        old = [self.low, self.high, self.count, self.log, values]
        if not (self.distribution or len(self.weights)):
            return old  # as versions before wrote them: their studies can go on
        arguments = {name: float(value) for name, value in self.arguments.items()}
        return [*old, self.distribution, arguments, [float(weight) for weight in self.weights]]
