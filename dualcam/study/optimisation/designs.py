"""Designs: the model that gives their results, deviations of made parts, and values between bounds."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dualcam.common.entries import hint
from dualcam.fmi.model_description import Scalar
from dualcam.scenario.scenario import Scenario
from dualcam.study.plan.vary import Vary

SHAPES = ("normal", "uniform", "triangular")  # as Tolerance.within, whose module loads scipy.stats
SIGMAS = 3.0  # half-widths of a normal distribution between its limits, in standard deviations
Design = dict[str, float | str]
Function = Callable[[Design], Mapping[str, float]]
Range = tuple[float | None, float | None]


@dataclass(frozen=True)
class FmuRuns:
    """A model whose results are those of an FMU at the end of a scenario, or at times in it.

    Parameters
    ----------
    fmu : "forward", "inverse", or the path of an FMU of FMI 2.0 or FMI 3.0.
    scenario : What is done in each run.
    parameters : Start values that are the same in every run.
    derived : Formulas over the varied values, by the name of what gets their value, as in `Plan`.
    conditions : mapping of str to str
        Formulas over the varied values that must be true, by a name of theirs: a design that violates one is
        not run.
    sections : mapping of str to object
        The tables of the design file that `parameters` come from: the files of the best designs keep them.

    Examples
    --------
    >>> from dualcam.study import FmuRuns, Scenario
    >>> FmuRuns("forward", Scenario(0.1)).scenario.stop
    0.1
    """

    fmu: str | Path
    scenario: Scenario
    parameters: Mapping[str, Scalar] = field(default_factory=dict)
    derived: Mapping[str, str] = field(default_factory=dict)
    conditions: Mapping[str, str] = field(default_factory=dict)
    sections: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Deviation:
    """How far one made part may lie from its design: limits on a drawing.

    Parameters
    ----------
    plus_minus : Half-width of the limits, in the unit of the parameter.
    shape : "normal", "uniform" or "triangular", as in `dualcam.design.tolerances.Tolerance.within`.

    Examples
    --------
    >>> from dualcam.study import Deviation
    >>> Deviation(0.02, "uniform").distribution().limits()
    (-0.02, 0.02)
    """

    plus_minus: float
    shape: str = "normal"

    def problems(self) -> list[str]:
        """All that is wrong: what is given and what is allowed."""
        found = []
        if self.shape not in SHAPES:
            found.append(f"shape = {self.shape!r}{hint(self.shape, SHAPES)}")
        if not (math.isfinite(self.plus_minus) and self.plus_minus > 0.0):
            found.append(f"plus_minus = {self.plus_minus:g}: allowed is a finite number above 0")
        return found

    def distribution(self, nominal: float = 0.0) -> Vary:
        """The values of parts as made.

        Parameters
        ----------
        nominal : Value of the design.

        Returns
        -------
        Vary
            Within the limits around `nominal`.
        """
        low, high = nominal - self.plus_minus, nominal + self.plus_minus
        if self.shape == "uniform":
            return Vary(low, high)
        if self.shape == "triangular":
            arguments = {"c": 0.5, "loc": low, "scale": high - low}
            return Vary(low, high, distribution="triang", arguments=arguments)
        arguments = {"mean": nominal, "std": self.plus_minus / SIGMAS}
        return Vary(low, high, distribution="normal", arguments=arguments)


def choices(vary: Vary) -> list[float | str]:
    """Values to choose from."""
    return [vary.values[place] for place in range(len(vary.values))]


def is_within(vary: Vary, value: float | str) -> bool:
    """Whether a design may have the value."""
    if vary.is_list:
        return value in choices(vary)
    return not isinstance(value, str) and vary.low <= value <= vary.high


def share_of(vary: Vary, value: float | str) -> float:
    """Where a value lies between the bounds: the inverse of `Vary.at`."""
    if vary.is_list:
        return (choices(vary).index(value) + 0.5) / len(vary.values)
    number = float(value)
    if vary.log:
        return math.log(number / vary.low) / math.log(vary.high / vary.low)
    return (number - vary.low) / (vary.high - vary.low)
