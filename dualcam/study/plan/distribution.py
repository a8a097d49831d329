"""Distributions of scipy.stats by name, whole or truncated."""

import math
from collections.abc import Mapping
from difflib import get_close_matches
from functools import cached_property
from typing import Any

import numpy as np

from dualcam.common.mistakes import StudyError
from dualcam.fmi.reals import Array

USUAL = {"normal": "norm", "gaussian": "norm", "lognormal": "lognorm", "exponential": "expon"}
WORDS = {"mean": "loc", "std": "scale"}  # of the normal distribution


def names() -> list[str]:
    """The names of all distributions of scipy.stats with numbers as values, and `normal`."""
    from scipy import stats

    kinds = (stats.rv_continuous, stats.rv_discrete)
    own = [name for name, each in vars(stats).items() if isinstance(each, kinds) and not name.startswith("_")]
    return sorted({*own, "normal"})


class Distribution:
    """A distribution of scipy.stats with its arguments by their names there, `mean` and `std` of "normal",
    truncated to a range, whose ends are NaN where there is none. StudyError for what is no such
    distribution."""

    def __init__(
        self, name: str, arguments: Mapping[str, float], low: float = math.nan, high: float = math.nan
    ) -> None:
        from scipy import stats

        if name not in names() and name not in USUAL:
            close = get_close_matches(name.lower(), sorted({*names(), *USUAL}), n=3, cutoff=0.6)
            hint = f": did you mean {' or '.join(close)}?" if close else "."
            raise StudyError(
                f"distribution = {name!r} is no distribution of scipy.stats{hint} Allowed are for example "
                "normal, lognorm, weibull_min, triang, beta, gamma"
            )
        self.name = name
        kind = getattr(stats, USUAL.get(name, name))
        self.is_discrete = isinstance(kind, stats.rv_discrete)
        self._frozen = self._made(kind, arguments)
        self._is_whole = float(arguments.get("loc", 0.0)).is_integer()
        ends = [float(end) for end in self._frozen.support()]
        self.low = ends[0] if math.isnan(low) else max(low, ends[0])
        self.high = ends[1] if math.isnan(high) else min(high, ends[1])
        if not self.low < self.high or not self._mass > 0.0:
            raise StudyError(
                f"from {low:g} to {high:g}: the distribution {name} has no probability there: allowed is a "
                f"range within {ends[0]:g} to {ends[1]:g}, the first number below the second"
            )

    def _made(self, kind: Any, arguments: Mapping[str, float]) -> Any:  # noqa: ANN401
        given = {WORDS.get(word, word) if kind.name == "norm" else word: v for word, v in arguments.items()}
        shapes = [each.strip() for each in kind.shapes.split(",")] if kind.shapes else []
        allowed = [*shapes, "loc"] if self.is_discrete else [*shapes, "loc", "scale"]
        needed = shapes if kind.name != "norm" else ["loc", "scale"]
        words = ["mean", "std"] if kind.name == "norm" else allowed
        before, after = f"distribution {self.name}", f"allowed are {', '.join(words)}"
        if unknown := sorted(set(given) - set(allowed)):
            raise StudyError(f"{before} has no argument {', '.join(unknown)}: {after}")
        if lacking := [name for name in needed if name not in given]:
            back = {"loc": "mean", "scale": "std"} if kind.name == "norm" else {}
            raise StudyError(f"{before} lacks {', '.join(back.get(n, n) for n in lacking)}: {after}")
        if strange := [f"{name} = {value}" for name, value in given.items() if not math.isfinite(value)]:
            raise StudyError(f"{before}: {', '.join(strange)}: allowed are finite numbers")
        with np.errstate(all="ignore"):
            frozen = kind(**given)
            middle = frozen.ppf(0.5)
        if not np.isfinite(middle):
            shown = ", ".join(f"{name} = {value:g}" for name, value in arguments.items())
            raise StudyError(f"{before} with {shown}: scipy.stats allows no such values")
        return frozen

    @property
    def is_whole(self) -> bool:
        """Whether all values are whole numbers."""
        return self.is_discrete and self._is_whole

    @cached_property
    def _is_upper(self) -> bool:
        """Whether the range lies above the median: shares are then counted from above, which is exact."""
        return not self.is_discrete and self.low > float(self._frozen.ppf(0.5))

    @cached_property
    def _ends(self) -> tuple[float, float]:
        """Probability up to the ends of the range, of the whole distribution; from above if `_is_upper`."""
        if self._is_upper:
            return float(self._frozen.sf(self.high)), float(self._frozen.sf(self.low))
        below = math.ceil(self.low) - 1.0 if self.is_discrete and math.isfinite(self.low) else self.low
        return float(self._frozen.cdf(below)), float(self._frozen.cdf(self.high))

    @property
    def _mass(self) -> float:
        return self._ends[1] - self._ends[0]

    def at(self, share: Array) -> Array:
        """Quantiles of the truncated distribution at shares in [0, 1]; infinite where there is no end."""
        low, mass = self._ends[0], self._mass
        if self._is_upper:
            found = self._frozen.isf(low + (1.0 - share) * mass)
        else:
            found = self._frozen.ppf(low + share * mass)
        return np.clip(np.asarray(found, float), self.low, self.high)

    def share_below(self, value: float, inclusive: bool = True) -> float:
        """Share of the truncated distribution up to a value, which counts if `inclusive`."""
        at = value if inclusive or not self.is_discrete else math.ceil(value) - 1.0
        if at >= self.high:
            return 1.0
        if at < self.low:
            return 0.0
        if self._is_upper:
            return 1.0 - (float(self._frozen.sf(at)) - self._ends[0]) / self._mass
        return (float(self._frozen.cdf(at)) - self._ends[0]) / self._mass

    def share_above(self, value: float) -> float:
        """Share of the truncated distribution above a value, also where the share is below 1e-16."""
        if value >= self.high:
            return 0.0
        if value < self.low:
            return 1.0
        if self._is_upper:
            return (float(self._frozen.sf(value)) - self._ends[0]) / self._mass
        return max(float(self._frozen.sf(value)) - float(self._frozen.sf(self.high)), 0.0) / self._mass
