"""Values that are allowed, but look as if they were given in another unit.

All rules are in unit_guards.csv, which says how strange a value must be and how many of the likely unit make
one. A rule only warns: nothing is refused that could be meant. The same rules serve design files, the classes
of dualcam.design, files of groove tables, and the FMUs themselves (fmu_src/unit_guards.def).
"""

import csv
import math
import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from dualcam.errors import UnitWarning

STEEPEST = math.radians(85.0)  # lead angle of a table; steeper grooves can hardly be made
TORQUE_UNITS = {"N.m": 1.0, "N.mm": 1e-3, "N.cm": 1e-2, "mN.m": 1e-3, "kN.m": 1e3}  # in N.m
FOREIGN = 20.0  # measured over expected torque, from which the unit is doubtful
ALIKE = 2.5  # a factor up to which two torques are the same but for their unit


@dataclass(frozen=True)
class Rule:
    """When a value of `unit` looks strange, and the unit that is likely instead, a share of `unit`."""

    unit: str
    side: str  # above: strange is a magnitude above the limit; below: a value between 0 and the limit
    limit: float
    likely: str
    other_unit: str
    per_unit: float  # how many of the other unit make one

    def message(self, name: str, value: float) -> str:
        """The warning for a variable of that name; "" for a value that is not strange."""
        is_strange = abs(value) > self.limit if self.side == "above" else 0.0 < value < self.limit
        if not (is_strange and math.isfinite(value)):
            return ""
        unit, meant = "" if self.unit == "1" else f" {self.unit}", value / self.per_unit
        return (
            f"{name} = {value:.6g}{unit}: this looks like {self.likely}; {value:.6g} {self.other_unit} is"
            f" {meant:.6g}{unit}"
        )


def _rules() -> dict[str, list[Rule]]:
    found: dict[str, list[Rule]] = {}
    with Path(__file__).with_suffix(".csv").open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            name, unit, side, limit, likely, other, per_unit = row.values()
            found.setdefault(name, []).append(Rule(unit, side, float(limit), likely, other, float(per_unit)))
    return found


# By the name of the variable, cam1 and cam2 as cam. Of the rules of a name the first one that holds counts.
RULES = _rules()


def unit_warning(name: str, value: object, shown: str = "") -> str | None:
    """The warning for a value in the FMU's unit that looks like another unit, or None. `shown`: the name in
    it, if another one."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        return None
    rules = RULES.get(re.sub(r"^cam[12]\.", "cam.", name), ())
    found = (rule.message(shown or name, float(value)) for rule in rules)
    return next(filter(None, found), None)


def unit_warnings(parameters: Mapping[str, Any]) -> list[str]:
    """Warnings for parameters in the FMU's units, by name, that look as if they were in another unit."""
    found = (unit_warning(name, value) for name, value in parameters.items())
    return [text for text in found if text]


def table_warnings(psi: ArrayLike, z: ArrayLike, radius: float | None = None) -> list[str]:
    """Warnings for psi [rad] and z [m] of a groove table, shape (n,). The lead angle is checked, too, where
    the `radius` [m] of the cam is given."""
    psi, z = np.asarray(psi, dtype=float), np.asarray(z, dtype=float)
    farthest, highest = psi[np.argmax(np.abs(psi))], z[np.argmax(np.abs(z))]
    found = [unit_warning("table.psi", float(farthest), "psi"), unit_warning("table.z", float(highest), "z")]
    slope = float(np.max(np.diff(z) / np.diff(psi)))
    if radius is not None and radius > 0.0 and math.atan(slope / radius) > STEEPEST and not any(found):
        lead = math.degrees(math.atan(slope / radius))
        found.append(
            f"the lead angle of the table reaches {lead:.4g} deg on the radius {radius:.6g} m: z looks like"
            f" millimetres; {highest:.6g} mm is {highest / 1e3:.6g} m"
        )
    return [text for text in found if text]


def torque_factor_warnings(factor: float, unit: str = "N.m") -> list[str]:
    """A warning where measured over expected torque, a `factor`, makes another unit likely than `unit`, from
    which the measured torques were read."""
    if not factor > 0.0 or 1.0 / FOREIGN < factor < FOREIGN:
        return []
    # A torque that is read too large by this factor has a smaller unit.
    true = TORQUE_UNITS[unit] / factor if unit in TORQUE_UNITS else math.nan
    near = [name for name, size in TORQUE_UNITS.items() if 1.0 / ALIKE < true / size < ALIKE and name != unit]
    likely = (
        f"the column of the torque looks like {near[0]}, not {unit}" if near else f"is the torque in {unit}?"
    )
    return [f"The torque is {factor:.3g} times that of the start values: {likely}"]


@contextmanager
def units_checked_before() -> Iterator[None]:
    """No UnitWarning inside this context: the user's own values are checked before, and warned of once."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnitWarning)
        yield


def warn_units(values: Mapping[str, tuple[str, object]], stacklevel: int = 4) -> None:
    """A UnitWarning for each strange value of a new object: `values` is name shown -> (name in RULES, value).

    `stacklevel` 4 is the caller of a dataclass that calls this in __post_init__."""
    for shown, (name, value) in values.items():
        if text := unit_warning(name, value, shown):
            warnings.warn(UnitWarning(text), stacklevel=stacklevel)
