"""What an optimisation says: the model, what varies, and what is wanted."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from dualcam.common.entries import hint
from dualcam.fmi.model_description import Scalar
from dualcam.scenario.formula import Formula, formula
from dualcam.scenario.scenario import Scenario
from dualcam.study.plan.correlation import Correlation
from dualcam.study.plan.vary import Vary
from dualcam.study.run.results_wanted import column_of

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
    fmu : str or Path
        "forward", "inverse", or the path of an FMU of FMI 2.0 or FMI 3.0.
    scenario : Scenario
        What is done in each run.
    parameters : mapping of str to float, int, bool or str
        Start values that are the same in every run.
    derived : mapping of str to str
        Formulas over the varied values, by the name of what gets their value, as in `Plan`.
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
    plus_minus : float
        Half-width of the limits, in the unit of the parameter.
    shape : {"normal", "uniform", "triangular"}
        As in `dualcam.design.tolerances.Tolerance.within`.

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
        nominal : float
            Value of the design.

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


@dataclass(frozen=True)
class TaskFields:
    """The fields of an `Optimisation`, which may be wrong."""

    model: FmuRuns | Function
    vary: Mapping[str, Vary]
    objectives: Mapping[str, str]
    constraints: Mapping[str, Range] = field(default_factory=dict)
    method: str = ""
    budget: int = 2000
    population: int = 0
    starts: int = 4
    start: Mapping[str, float | str] = field(default_factory=dict)
    seed: int = 0
    tolerances: Mapping[str, Deviation] = field(default_factory=dict)
    percentile: float = 95.0
    samples: int = 64
    difference: float = 1e-3
    same_as: Mapping[str, str] = field(default_factory=dict)
    correlations: Sequence[Correlation] = ()
    results: Sequence[str] = ()
    units: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def designed(self) -> dict[str, Vary]:
        """What is chosen."""
        return {name: vary for name, vary in self.vary.items() if not vary.distribution}

    @cached_property
    def chance(self) -> dict[str, Vary]:
        """What happens."""
        return {name: vary for name, vary in self.vary.items() if vary.distribution}

    @property
    def is_robust(self) -> bool:
        """Whether parts as made differ from their design."""
        return bool(self.chance or self.tolerances)

    @property
    def method_used(self) -> str:
        """The method, if none was named the one for this number of objectives."""
        return self.method or ("evolution" if len(self.objectives) == 1 else "nsga2")

    @property
    def population_used(self) -> int:
        """Designs in a generation."""
        return min(self.population or min(max(10 * len(self.designed), 20), 100), self.budget)

    @cached_property
    def formulas(self) -> dict[str, Formula]:
        """Those of objectives and constraints by their text."""
        return {text: formula(text) for text in [*self.objectives, *self.constraints]}

    @cached_property
    def read(self) -> list[str]:
        """What is read of the model: variables in formulas, then the results that are shown."""
        derived = self.model.derived if isinstance(self.model, FmuRuns) else {}
        known = {*self.vary, *self.same_as, *derived, *map(column_of, self.results)}
        wanted = [name for each in self.formulas.values() for name in each.names if name not in known]
        return list(dict.fromkeys([*wanted, *self.results]))

    @property
    def columns(self) -> list[str]:
        """The names of what is read."""
        return [column_of(text) for text in self.read]


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
