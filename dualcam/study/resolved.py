"""What one row of a plan means for its run.

The way from a plan to a run:

1. `Plan.rows(start, stop)` gives an array, one row for each run, one column for each of `Plan.names`. Numbers
   are in the FMU's units. The column of a String has places in the list `Plan.texts[name]`.
2. A column whose name is a variable of the FMU is a start value of the FMU.
3. Any column, one of the FMU or not, is a value for the formulas of the scenario and of the controller's
   arguments: `Scenario.at(values)`.
4. A row that violates one of `Plan.constraints` is not run; its message says which constraint.

`resolve` does this for one row, plainly. The runner does the same for many rows, faster."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from dualcam.common.arrays import real_array
from dualcam.fmi.model_description import Scalar
from dualcam.study.problem import StudyError
from dualcam.study.sampling.formula import formula
from dualcam.study.sampling.texts import Texts
from dualcam.study.scenario import Scenario


@dataclass(frozen=True)
class ResolvedRun:
    """What one run gets.

    Attributes
    ----------
    start_values : dict of str to float or str
        Start values of the FMU by the name of the variable; texts for Strings.
    scenario : Scenario
        Without formulas. The arguments of its controller are numbers or texts.
    law_arguments : dict of str to float or str
        Arguments of the controller's `create_law`; none without a controller.
    violated : tuple of str
        Messages of the constraints that the row violates: the run is not made if there are any.
    """

    start_values: dict[str, Scalar]
    scenario: Scenario
    law_arguments: dict[str, float | str]
    violated: tuple[str, ...]


def resolve(
    names: Sequence[str],
    row: ArrayLike,
    scenario: Scenario,
    variables: Collection[str],
    texts: Mapping[str, Texts] | None = None,
    constraints: Mapping[str, str] | None = None,
) -> ResolvedRun:
    """What one run gets.

    Parameters
    ----------
    names : sequence of str
        Names of the columns: `Plan.names`.
    row : array_like, shape (names,)
        A row of `Plan.rows`.
    scenario : Scenario
        With or without formulas.
    variables : collection of str
        Names of the FMU's variables.
    texts : mapping of str to Texts, optional
        `Plan.texts`.
    constraints : mapping of str to str, optional
        `Plan.constraints`.

    Returns
    -------
    ResolvedRun
        Start values, scenario and arguments.

    Raises
    ------
    StudyError
        The numbers of this row are no scenario.
    """
    values = values_of(names, row, texts or {})
    violated = violated_by(constraints or {}, values)
    numbers = scenario.at(values)
    law_arguments = dict(numbers.controller.arguments) if numbers.controller else {}
    start_values = {name: value for name, value in values.items() if name in variables}
    return ResolvedRun(start_values, numbers, law_arguments, violated)


def values_of(names: Sequence[str], row: ArrayLike, texts: Mapping[str, Texts]) -> dict[str, float | str]:
    """The values of a row by name, with the texts themselves."""
    numbers = dict(zip(names, real_array(row, "row", StudyError).tolist(), strict=True))
    return numbers | {name: texts[name][round(numbers[name])] for name in texts if name in numbers}


def violated_by(constraints: Mapping[str, str], values: Mapping[str, float | str]) -> tuple[str, ...]:
    """A message for each constraint that the values violate."""
    found = []
    for name, text in constraints.items():
        if not formula(text).truth(values, 1)[0]:
            used = ", ".join(f"{each} = {values[each]:g}" for each in formula(text).names)
            found.append(f"constraint {name}: {text} is not true for {used}")
    return tuple(found)
