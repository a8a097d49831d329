"""What one row of a plan means for its run.

The way from a plan to a run:

1. `Plan.rows(start, stop)` gives an array, one row for each run, one column for each of `Plan.names`. Numbers
   are in the FMU's units. The column of a String has places in the list `Plan.texts[name]`.
2. A column whose name is a variable of the FMU is a start value of the FMU.
3. Any column, one of the FMU or not, is a value for the formulas of the scenario and of the controller's
   arguments: `Scenario.at(values)`.
4. A row that violates one of `Plan.constraints` is not run; its message says which constraint."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import Array, real_array
from dualcam.common.mistakes import StudyError
from dualcam.scenario.formula import Formula, formula
from dualcam.study.plan.texts import Texts


def in_order(derived: Mapping[str, str]) -> list[tuple[str, Formula]]:
    """Derived names with their formulas, each after those that it uses. StudyError for a circle."""
    left = {name: formula(text) for name, text in derived.items()}
    done: list[tuple[str, Formula]] = []
    while left:
        ready = [name for name, each in left.items() if not set(each.names) & set(left)]
        if not ready:
            raise StudyError(f"derived: {', '.join(left)} use each other in a circle: break it")
        done += [(name, left.pop(name)) for name in ready]
    return done


def violating(constraints: Mapping[str, str], columns: Mapping[str, Array], count: int) -> NDArray[np.bool_]:
    """Which of `count` runs violate a constraint. `columns` has their values by name, shape (count,) each."""
    kept = [formula(text).truth(columns, count) for text in constraints.values()]
    return ~np.all([np.ones(count, bool), *kept], axis=0)


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
