"""What is fitted: names of parameters, one value for both cams, and zero errors of the sensors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from dualcam.design_file import DesignFile
from dualcam.errors import IdentificationError
from dualcam.variables import SettableVariable, parameters_of

DEFAULT = ("friction", "spring.preload", "spring.stiffness")
TORQUE_OFFSET, ANGLE_OFFSET = "torque_offset", "angle_offset"
SENSORS = {TORQUE_OFFSET: "N.m", ANGLE_OFFSET: "rad"}
CAMS = ("cam1", "cam2")
WITHOUT_EFFECT = ("wear", "table")  # of a cam; the torque does not depend on these
GROUPS = (*CAMS, "spring", "damper", "inertia", "shaft")
ELASTIC = "shaft.stiffness"  # the torque then depends on the past


@dataclass(frozen=True)
class Unknown:
    """One number that is fitted.

    Attributes
    ----------
    name : str
        As the user writes it: `spring.preload`; `friction` for one value of both cams; `torque_offset`.
    keys : tuple of str
        The FMU's parameters that have this value; empty for the zero error of a sensor.
    unit : str
        As the FMU writes it, "1" without a unit.
    start, least, greatest : float
        Value of the design, and allowed values.
    """

    name: str
    keys: tuple[str, ...]
    unit: str
    start: float
    least: float
    greatest: float


def fitted_names() -> dict[str, tuple[str, ...]]:
    """All names that can be fitted, and the parameters of the FMU behind each."""
    known = [name for name, variable in parameters_of("inverse").items() if _can_be_fitted(variable)]
    names: dict[str, tuple[str, ...]] = {name: (name,) for name in known}
    for name in known:
        group, _, last = name.partition(".")
        if group == CAMS[0] and f"{CAMS[1]}.{last}" in names:
            names[last] = (name, f"{CAMS[1]}.{last}")
    return names | {name: () for name in SENSORS}


def _can_be_fitted(variable: SettableVariable) -> bool:
    group, _, last = variable.name.partition(".")
    real = variable.kind is float and last not in WITHOUT_EFFECT
    has_choice = variable.least < variable.greatest
    return real and has_choice and group in GROUPS and variable.name != ELASTIC


def unknowns_of(design: DesignFile, names: Sequence[str] = DEFAULT) -> list[Unknown]:
    """The numbers to be fitted, with the values of the design as start.

    Parameters
    ----------
    design : DesignFile
        Start values.
    names : sequence of str
        Names of parameters, such as `spring.preload`; `friction` and the like for one value of both cams;
        `torque_offset` [N.m] and `angle_offset` [rad] for the zero errors of the sensors.

    Returns
    -------
    list of Unknown

    Raises
    ------
    IdentificationError
        For no name, an unknown one, or a parameter that is named twice.
    """
    if isinstance(names, str):
        names = [names]
    if not names:
        raise IdentificationError("no parameter to fit: name one or more, such as friction, spring.preload")
    known = fitted_names()
    owner: dict[str, str] = {}
    found = []
    for name in names:
        if name not in known:
            raise IdentificationError(_unknown(name, known))
        for key in known[name] or (name,):
            if key in owner:
                both = f"{owner[key]} and {name}" if owner[key] != name else f"{name} twice"
                raise IdentificationError(f"{both} name {key}: allowed is to name a parameter once")
            owner[key] = name
        found.append(_unknown_of(design, name, known[name]))
    return found


def _unknown_of(design: DesignFile, name: str, keys: tuple[str, ...]) -> Unknown:
    if not keys:
        return Unknown(name, (), SENSORS[name], 0.0, -math.inf, math.inf)
    variables: Mapping[str, SettableVariable] = parameters_of("inverse")
    first = variables[keys[0]]
    start = sum(float(design.value(key)) for key in keys) / len(keys)
    return Unknown(name, keys, first.unit, start, first.least, first.greatest)


def _unknown(name: str, known: Mapping[str, object]) -> str:
    near = get_close_matches(name, known, n=3, cutoff=0.5)
    guess = f"did you mean {' or '.join(near)}? Allowed" if near else "allowed"
    return f"{name!r} cannot be fitted: {guess} are {', '.join(known)}"
