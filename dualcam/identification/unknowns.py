"""What is fitted: names of parameters, one value for both cams, and zero errors of the sensors."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from dualcam.common.groove_laws import LAWS, laws_with
from dualcam.design_file import DesignFile
from dualcam.errors import IdentificationError
from dualcam.fmi.variables import SettableVariable, parameters_of

DEFAULT = ("friction", "spring.preload", "spring.stiffness")
TORQUE_OFFSET, ANGLE_OFFSET = "torque_offset", "angle_offset"
SENSORS = {TORQUE_OFFSET: "N.m", ANGLE_OFFSET: "rad"}
CAMS = ("cam1", "cam2")
WITHOUT_EFFECT = ("wear", "table")  # of a cam; the torque does not depend on these
GROUPS = (*CAMS, "spring", "damper", "inertia", "shaft")
MENTIONED = (*DEFAULT, "friction_peak", "friction_viscous", "inertia.shaft", TORQUE_OFFSET, ANGLE_OFFSET)
ELASTIC = "shaft.stiffness"  # the torque then depends on the past


@dataclass(frozen=True)
class Unknown:
    """One number that is fitted."""

    name: str  # as the user writes it: `spring.preload`; `friction` for both cams; `torque_offset`
    keys: tuple[str, ...]  # the FMU's parameters that have this value; empty for the zero error of a sensor
    unit: str  # as the FMU writes it, "1" without a unit
    start: float  # value of the design
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


def names_without_effect(design: DesignFile) -> dict[str, str]:
    """Names that cannot act on the torque of this design, each with the reason, the end of a sentence."""
    reasons = {key: reason for key in fitted_names() if (reason := _reason(design, key))}
    for name, keys in fitted_names().items():
        if len(keys) > 1 and all(key in reasons for key in keys):
            reasons[name] = reasons[keys[0]]
    return reasons


def _reason(design: DesignFile, key: str) -> str:
    """Why a parameter of a cam cannot act, or nothing."""
    cam, _, last = key.partition(".")
    if cam not in CAMS:
        return ""
    law, users = LAWS[int(design.value(f"{cam}.profile"))], laws_with(last)
    if law not in users:
        words = " or ".join(f'"{user.word}"' for user in users)
        return (
            f'acts for {cam}.profile = {words} only, and {design.path.name} has {cam}.profile = "{law.word}"'
        )
    exponent = f"{cam}.friction_load_exponent"
    if last == "friction_load" and not design.value(exponent):
        return f"does not act with {exponent} = 0"
    return ""


def _can_be_fitted(variable: SettableVariable) -> bool:
    group, _, last = variable.name.partition(".")
    real = variable.kind is float and last not in WITHOUT_EFFECT
    has_choice = variable.least < variable.greatest
    return real and has_choice and group in GROUPS and variable.name != ELASTIC


def unknowns_of(design: DesignFile, names: Sequence[str] = DEFAULT) -> list[Unknown]:
    """The numbers to be fitted, with the values of the design as start. `friction` and the like are one value
    of both cams. IdentificationError for names that cannot be fitted."""
    names = _listed(names)
    if not names:
        raise IdentificationError("no parameter to fit: name one or more, such as friction, spring.preload")
    known = fitted_names()
    refused = names_without_effect(design)
    owner: dict[str, str] = {}
    found = []
    for name in names:
        if name not in known:
            raise IdentificationError(_unknown(name, [one for one in known if one not in refused]))
        if name in refused:
            raise IdentificationError(f"{name} cannot be fitted: {name} {refused[name]}")
        for key in known[name] or (name,):
            if key in owner:
                if owner[key] == name:
                    raise IdentificationError(f"{name} is given twice: give {name} once")
                raise IdentificationError(
                    f"{owner[key]} and {name} both set {key}: allowed is one of the two names"
                )
            owner[key] = name
        found.append(_unknown_of(design, name, known[name]))
    return found


def _listed(names: object) -> list[str]:
    """`names` as a list. IdentificationError unless they are texts."""
    listed: list[Any] = [names] if isinstance(names, str) or not isinstance(names, Iterable) else [*names]
    for name in listed:
        if not isinstance(name, str):
            raise IdentificationError(
                f"fit: {name!r} is no name: allowed are texts, such as friction, spring.preload"
            )
    return listed


def _unknown_of(design: DesignFile, name: str, keys: tuple[str, ...]) -> Unknown:
    if not keys:
        return Unknown(name, (), SENSORS[name], 0.0, -math.inf, math.inf)
    variables: Mapping[str, SettableVariable] = parameters_of("inverse")
    first = variables[keys[0]]
    start = sum(float(design.value(key)) for key in keys) / len(keys)
    return Unknown(name, keys, first.unit, start, first.least, first.greatest)


def _unknown(name: str, known: Sequence[str]) -> str:
    parts = name.split()
    if len(parts) > 1:
        return f"{name!r} cannot be fitted: separate the names by commas, {','.join(parts)}"
    near = get_close_matches(name, known, n=3, cutoff=0.5)
    if near:
        return f"{name!r} cannot be fitted: did you mean {' or '.join(near)}?"
    return (
        f"{name!r} cannot be fitted: allowed are {', '.join(MENTIONED)}, and other real parameters of"
        f" {', '.join(GROUPS)} (page Variables of the documentation)"
    )
