"""Values of a search in words, in the units of its file."""

from __future__ import annotations

from collections.abc import Mapping

from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import read_model_description
from dualcam.study.optimisation.fields import FmuRuns, TaskFields, choices

DIGITS = 6


def units_of(task: TaskFields) -> dict[str, str]:
    """Unit by variable of the FMU, without "1"; nothing is known of a function."""
    if not isinstance(task.model, FmuRuns):
        return {}
    variables = read_model_description(source_path(task.model.fmu)).variables
    return {each.name: each.unit for each in variables if each.unit and each.unit != "1"}


def unit_of(name: str, units: Mapping[str, str]) -> str:
    """The FMU's unit of a variable, or of a variable at a time; none of a formula."""
    return units.get(name.partition("@")[0], "")


def shown(task: TaskFields, name: str, value: float | str, digits: int = DIGITS) -> str:
    """A value of a name or of a formula, with the unit of the file, else with the FMU's unit."""
    if isinstance(value, str):
        return value
    own = unit_of(name, units_of(task))
    given = task.units.get(name) or task.units.get(task.same_as.get(name, ""))
    if given:
        return f"{value / _factor(given, own):.{digits}g} {given}"
    return f"{value:.{digits}g} {own}".strip()


def shown_bounds(task: TaskFields, name: str) -> str:
    """What a designed value may be."""
    vary = task.designed[name]
    if vary.is_list:
        return f"one of {', '.join(shown(task, name, each) for each in choices(vary))}"
    return " to ".join(shown(task, name, end) for end in vary.limits())


def _factor(given: str, own: str) -> float:
    """One of the given unit, in the FMU's unit; where the FMU has none, in the SI unit."""
    from dualcam.common.written_units import quantity, si_number

    return quantity(f"1 {given}", own) if own else si_number(f"1 {given}")
