"""Values that are allowed, but look as if they were given in another unit.

All rules are in the table RULES. A rule only warns: nothing is refused that could be meant. The same
rules serve design files, the classes of dualcam.design, and files of groove tables.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from dualcam.errors import UnitWarning

FULL_TURN = 2.0 * math.pi
STEEPEST = math.radians(85.0)  # lead angle of a table; steeper grooves can hardly be made
TORQUE_UNITS = {"N.m": 1.0, "N.mm": 1e-3, "N.cm": 1e-2, "mN.m": 1e-3, "kN.m": 1e3}  # in N.m
FOREIGN = 20.0  # measured over expected torque, from which the unit is doubtful
ALIKE = 2.5  # a factor up to which two torques are the same but for their unit
LONGEST = 1.0  # m: radius of a cam, height of a groove


@dataclass(frozen=True)
class Rule:
    """When a value looks strange, and what could be meant.

    `likely` completes the sentence "this looks like ..."."""

    unit: str
    is_strange: Callable[[float], bool]
    likely: Callable[[float], str]

    def message(self, name: str, value: float) -> str:
        """The warning for a variable of that name."""
        unit = f" {self.unit}" if self.unit else ""
        return f"{name} = {value:.6g}{unit}: this looks like {self.likely(value)}"


def _millimetres(value: float) -> str:
    return f"millimetres; {value:.6g} mm is {value / 1e3:.6g} m"


def _degrees(value: float) -> str:
    return f"degrees; {value:.6g} deg is {math.radians(value):.6g} rad"


def _newtons_per_millimetre(value: float) -> str:
    return f"N/mm; {value:.6g} N/mm is {value * 1e3:.6g} N/m"


def _friction(value: float) -> str:
    if value >= 90.0:
        return f"percent; {value:.6g} % is {value / 100.0:.6g}"
    angle = math.tan(math.radians(value))
    return f"percent or an angle; {value:.6g} % is {value / 100.0:.6g}, {value:.6g} deg has tan = {angle:.4g}"


def _millimetres_per_second(value: float) -> str:
    return f"mm/s; {value:.6g} mm/s is {value / 1e3:.6g} m/s"


def _cubic_millimetres(value: float) -> str:
    return f"mm3/(N.m); {value:.6g} mm3/(N.m) is {value / 1e9:.6g} m3/(N.m)"


def _grams(value: float) -> str:
    return f"grams; {value:.6g} g is {value / 1e3:.6g} kg"


def _small_inertia(value: float) -> str:
    return f"kg.cm2 or kg.mm2; {value:.6g} kg.cm2 is {value / 1e4:.6g} kg.m2"


def _pressure(value: float) -> str:
    if value < 1e3:
        return f"GPa; {value:.6g} GPa is {value * 1e9:.6g} Pa"
    return f"MPa; {value:.6g} MPa is {value * 1e6:.6g} Pa"


def _milliseconds(value: float) -> str:
    return f"milliseconds; {value:.6g} ms is {value / 1e3:.6g} s"


def _megapascals(value: float) -> str:
    return f"MPa; {value:.6g} MPa is {value * 1e6:.6g} Pa"


def _above(limit: float) -> Callable[[float], bool]:
    return lambda value: abs(value) > limit


def _between_zero_and(limit: float) -> Callable[[float], bool]:
    return lambda value: 0.0 < value < limit


ANGLE = Rule("rad", _above(FULL_TURN), _degrees)
LENGTH = Rule("m", _above(LONGEST), _millimetres)
INERTIA = Rule("kg.m2", _above(1e3), _small_inertia)
# By the name of the variable, cam1 and cam2 as cam.
RULES: dict[str, Rule] = {
    "cam.radius": LENGTH,
    # an arc of a large ellipse is nearly straight, which can be meant
    "cam.ellipse_a": Rule("m", _above(5.0), _millimetres),
    "cam.ellipse_b": Rule("m", _above(5.0), _millimetres),
    "cam.lead_angle": Rule("rad", _above(0.5 * math.pi), _degrees),
    "cam.friction": Rule("", _above(1.0), _friction),
    # 1 mm/s to 0.2 m/s in measurements
    "cam.stribeck_velocity": Rule("m/s", _above(0.9), _millimetres_per_second),
    "cam.wear": Rule("m3/(N.m)", _above(1e-9), _cubic_millimetres),
    # 0 is meant: a spring of preload alone, or of stiffness2 and stiffness3
    "spring.stiffness": Rule("N/m", _between_zero_and(100.0), _newtons_per_millimetre),
    "spring.free_length": LENGTH,
    "spring.solid_length": LENGTH,
    "stop.lower": ANGLE,
    "stop.upper": ANGLE,
    "initial.theta": ANGLE,
    "scenario.inputs.theta": ANGLE,
    "scenario.stop": Rule("s", _above(100.0), _milliseconds),
    "inertia.shaft": INERTIA,
    "inertia.follower": INERTIA,
    "inertia.follower_mass": Rule("kg", _above(100.0), _grams),
    "pin.radius": Rule("m", _above(0.2), _millimetres),
    "pin.width": Rule("m", _above(0.5), _millimetres),
    "pin.modulus": Rule("Pa", _between_zero_and(1e6), _pressure),
    "pin.cam_modulus": Rule("Pa", _between_zero_and(1e6), _pressure),
    "pin.wear": Rule("m3/(N.m)", _above(1e-9), _cubic_millimetres),
    "helical_spring.wire_diameter": Rule("m", _above(0.1), _millimetres),
    "helical_spring.coil_diameter": LENGTH,
    "helical_spring.tensile_strength": Rule("Pa", _between_zero_and(1e6), _megapascals),
    "helical_spring.fatigue_strength": Rule("Pa", _between_zero_and(1e6), _megapascals),
    "helical_spring.shear_modulus": Rule("Pa", _between_zero_and(1e6), _pressure),
    "roller.bearing_radius": Rule("m", _above(0.2), _millimetres),
    "roller.lever_arm": Rule("m", _above(0.002), _millimetres),
    "limits.wear_depth": Rule("m", _above(0.01), _millimetres),
    "limits.pressure": Rule("Pa", _between_zero_and(1e5), _megapascals),
    "limits.lead_angle": Rule("rad", _above(0.5 * math.pi), _degrees),
    "table.psi": ANGLE,
    "table.z": LENGTH,
    "table.theta": ANGLE,
    "table.v": Rule("m/s", _above(5.0), _millimetres_per_second),
    "table.mu": Rule("", _above(1.0), _friction),
}


def unit_warning(name: str, value: object, shown: str = "") -> str | None:
    """The warning for one value, or None.

    Parameters
    ----------
    name : str
        Name of the FMU's parameter or key of the design file, such as `cam1.radius`.
    value : object
        Its value in the FMU's unit; anything but a finite number gets no warning.
    shown : str
        The name in the message, if another one.

    Returns
    -------
    str or None
        A sentence with the likely unit and the converted value.

    Examples
    --------
    >>> unit_warning("cam1.radius", 18)
    'cam1.radius = 18 m: this looks like millimetres; 18 mm is 0.018 m'
    """
    rule = RULES.get(re.sub(r"^cam[12]\.", "cam.", name))
    if rule is None or isinstance(value, bool) or not isinstance(value, int | float | np.number):
        return None
    number = float(value)
    if not (math.isfinite(number) and rule.is_strange(number)):
        return None
    return rule.message(shown or name, number)


def unit_warnings(parameters: Mapping[str, Any]) -> list[str]:
    """Warnings for parameters that look as if they were given in another unit.

    Parameters
    ----------
    parameters : Mapping[str, Any]
        Names of the FMU's parameters, or keys of the design file, with values in the FMU's units.

    Returns
    -------
    list of str
        One sentence per strange value: name, value, likely unit, converted value.

    Examples
    --------
    >>> unit_warnings({"stop.upper": 75.0, "spring.stiffness": 32.0, "cam1.friction": 0.14})[0]
    'stop.upper = 75 rad: this looks like degrees; 75 deg is 1.309 rad'
    """
    found = (unit_warning(name, value) for name, value in parameters.items())
    return [text for text in found if text]


def table_warnings(psi: ArrayLike, z: ArrayLike, radius: float | None = None) -> list[str]:
    """Warnings for the samples of a groove table.

    Parameters
    ----------
    psi : array_like, shape (n,)
        Angles [rad].
    z : array_like, shape (n,)
        Heights [m].
    radius : float, optional
        Radius of the cam [m]: with the radius the lead angle is checked too.

    Returns
    -------
    list of str
        One sentence per strange property.
    """
    psi, z = np.asarray(psi, dtype=float), np.asarray(z, dtype=float)
    farthest, highest = psi[np.argmax(np.abs(psi))], z[np.argmax(np.abs(z))]
    found = [
        unit_warning("table.psi", float(farthest), "psi"),
        unit_warning("table.z", float(highest), "z"),
    ]
    slope = float(np.max(np.diff(z) / np.diff(psi)))
    if radius is not None and radius > 0.0 and math.atan(slope / radius) > STEEPEST and not any(found):
        lead = math.degrees(math.atan(slope / radius))
        found.append(
            f"the lead angle of the table reaches {lead:.4g} deg on the radius {radius:.6g} m: z looks like"
            f" millimetres; {highest:.6g} mm is {highest / 1e3:.6g} m"
        )
    return [text for text in found if text]


def torque_factor_warnings(factor: float, unit: str = "N.m") -> list[str]:
    """A warning where measured torques are so far from expected ones that another unit is likely.

    Parameters
    ----------
    factor : float
        Measured over expected torque.
    unit : str
        Unit from which the measured torques were read.

    Returns
    -------
    list of str
        Nothing, or one sentence with the likely unit.

    Examples
    --------
    >>> torque_factor_warnings(0.0112, "N.cm")
    ['The torque is 0.0112 times that of the start values: the column of the torque looks like N.m, not N.cm']
    """
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
    """A UnitWarning for each strange value of an object that is being made.

    `values`: by the name in the message, the name in RULES and the value. `stacklevel` is that of
    warnings.warn; 4 is the caller of a dataclass that calls this function in __post_init__."""
    for shown, (name, value) in values.items():
        if text := unit_warning(name, value, shown):
            warnings.warn(UnitWarning(text), stacklevel=stacklevel)
