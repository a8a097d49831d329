"""What is wrong with a design, found without the FMU: each rule gives findings with a key of the design file.

The geometry and the strength are those of dualcam.design.assess. Here their findings get the keys, and the
keys whose change can help.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from dualcam.checking.durability import durability
from dualcam.checking.trouble import ERROR, WARNING, Remedy, Trouble, finding_of
from dualcam.checking.values import value_of
from dualcam.common.groove_laws import CYCLOID, LAWS, PARAMETERS, GrooveLaw
from dualcam.design import Limits, Mechanism
from dualcam.design.grooves import ClosedForm
from dualcam.design.strength import LimitViolation, examine
from dualcam.design_file import DesignFile, Finding
from dualcam.errors import DesignError

OF_GROOVES = ("jam", "level", "self-locking", "lead angle", "undercut", "contact pressure")  # kinds


def swap_warning(design: DesignFile, errors: Iterable[str]) -> Finding | None:
    """A warning if exchanging the grooves of both cams, without radius and friction, removes all errors.

    None where an error, of these kinds, is not about the grooves, such as one of stops or spring."""
    if not all(kind.startswith(OF_GROOVES) for kind in errors):
        return None
    grooves = ("profile", *PARAMETERS)
    names = [f"cam{i}.{name}" for i in (1, 2) for name in grooves]
    others = [f"cam{3 - i}.{name}" for i in (1, 2) for name in grooves]
    exchanged = {name: design.value(other) for name, other in zip(names, others, strict=True)}
    swapped = replace(design, parameters=design.parameters | exchanged)
    if any(trouble.finding.severity == ERROR for trouble in troubles(swapped)):
        return None
    text = "with the grooves of cam 1 and cam 2 exchanged there is no error: are cam 1 and cam 2 swapped?"
    return Finding(WARNING, "cam1", None, text, kind="swapped")


def troubles(design: DesignFile, locate: bool = True) -> list[Trouble]:
    """All errors, and warnings about the geometry, of a design. Without `locate` in less time, the angles in
    the texts being those of a coarse grid."""
    if early := _stops(design):
        return early
    try:
        mechanism = design.mechanism()
    except DesignError as error:
        return [_impossible(design, error)]
    limits = design.limits or Limits()
    _, failures = examine(mechanism, design.pin, limits, locate=locate)
    found = [_trouble(design, mechanism, failure) for failure in failures]
    more: tuple[Callable[[DesignFile, Mechanism], list[Trouble]], ...] = (
        _solid_length,
        _start,
        _imposed,
        _pin_in_cam,
    )
    found += [trouble for rule in more for trouble in rule(design, mechanism)]
    return [*found, *durability(design, mechanism, propose=locate)]


# ---- stops and what cannot be a mechanism ----


def _stops(design: DesignFile) -> list[Trouble]:
    low, high = design.value("stop.lower"), design.value("stop.upper")
    if low < high:
        return []
    text = (
        f"stop.upper = {high:.6g} rad ({math.degrees(high):.4g} deg): allowed is more than stop.lower ="
        f" {low:.6g} rad ({math.degrees(low):.4g} deg)"
    )
    is_negative = high < 0.0 and -high > low
    hint = f"Is the sign of stop.upper wrong: {-high:.6g} rad?" if is_negative else "Are the stops exchanged?"
    return [Trouble(finding_of(design, "stops", "stop.upper", text), hint=hint)]


def _impossible(design: DesignFile, error: DesignError) -> Trouble:
    """A groove that its class refuses, such as an ellipse that starts vertical."""
    steep = [f"cam{i}.lead_angle" for i in (1, 2) if "lead_angle" in _law(design, i).parameters]
    remedies = tuple(Remedy(key, 0.1) for key in steep if value_of(design, key) > 0.1)
    return Trouble(finding_of(design, "groove", remedies[0].key if remedies else "", str(error)), remedies)


# ---- failures of the assessment ----


def _trouble(design: DesignFile, mechanism: Mechanism, failure: LimitViolation) -> Trouble:
    what, text = failure.what, failure.text
    if what.endswith(" ends"):
        return _groove_end(design, mechanism, failure)
    if what == "spring force":
        remedies = [Remedy("spring.preload", 1e3 * (1.0 + abs(failure.value)))]
        hint = "Is the sign of spring.preload wrong?" if design.value("spring.preload") < 0.0 else ""
        return Trouble(finding_of(design, "spring force", "spring.preload", text), tuple(remedies), hint)
    if what.startswith("both grooves level"):
        laws = _law(design, 1), _law(design, 2)
        hint = "Two cycloids need stop.lower and initial.theta > 0, or another groove law on one cam"
        finding = finding_of(design, "level", f"cam1.{laws[0].parameters[0]}", text)
        steeper = (*_steeper(mechanism, 1, 0.8), *_shorter(failure))
        return Trouble(finding, steeper, hint if laws == (CYCLOID, CYCLOID) else "")
    if what.startswith("jam"):
        return _jam(design, mechanism, text)
    if what in design.parameters:
        return Trouble(finding_of(design, "limit", what, text))
    return _of_groove(design, mechanism, failure, 2 if what.endswith("2") else 1)


def _groove_end(design: DesignFile, mechanism: Mechanism, failure: LimitViolation) -> Trouble:
    """A groove that ends before a stop."""
    upper = failure.theta > 0.0 or mechanism.lower >= 0.0
    stop = "stop.upper" if upper else "stop.lower"
    finding = finding_of(design, "groove end", stop, f"{stop}: {failure.text}")
    return Trouble(finding, (Remedy(stop, 0.5 * failure.theta),))


def _shorter(failure: LimitViolation) -> tuple[Remedy, ...]:
    """A range that ends before the angle of the failure."""
    return (Remedy("stop.upper", 0.5 * failure.theta),) if failure.theta > 0.01 else ()


def _law(design: DesignFile, i: int) -> GrooveLaw:
    return LAWS[design.value(f"cam{i}.profile")]


def _steeper(mechanism: Mechanism, i: int, lead: float) -> list[Remedy]:
    """What moves the lead angle of cam i's groove towards `lead` [rad]; nothing for a table."""
    groove = mechanism.grooves[i - 1]
    if not isinstance(groove, ClosedForm):
        return []
    return [Remedy(f"cam{i}.{groove.law.steepness}", groove.steepness(lead))]


def _jam(design: DesignFile, mechanism: Mechanism, text: str) -> Trouble:
    steep = sorted((1, 2), key=lambda i: -design.value(f"cam{i}.friction"))
    remedies = [Remedy(f"cam{i}.friction", 0.0) for i in steep if not design.value(f"cam{i}.friction_table")]
    remedies += [one for i in (1, 2) for one in _steeper(mechanism, i, 0.1)]
    key = remedies[0].key if remedies else f"cam{steep[0]}.friction_table"
    return Trouble(finding_of(design, "jam", key, text), tuple(remedies))


def _of_groove(design: DesignFile, mechanism: Mechanism, failure: LimitViolation, i: int) -> Trouble:
    what, text = failure.what, failure.text
    law, friction = _law(design, i), f"cam{i}.friction"
    key = f"cam{i}.{law.steepness or law.parameters[0]}"
    shorter = _shorter(failure)
    if what.startswith("self-locking"):
        remedies = _steeper(mechanism, i, 1.2)
        hint = "If locking is meant, write self_locking = true below [limits]"
        finding = finding_of(design, f"self-locking {i}", key, text)
        if not design.value(f"cam{i}.friction_table"):
            remedies.append(Remedy(friction, 0.0))
        return Trouble(finding, (*remedies, *shorter), hint)
    if what.startswith("lead angle"):
        low, high = (design.limits or Limits()).lead_angle
        remedies = _steeper(mechanism, i, 0.5 * (low + high))
        severity = WARNING if design.limits is None else ERROR
        finding = finding_of(design, f"lead angle {i}", key, text, severity)
        return Trouble(finding, (*remedies, *shorter))
    if what.startswith("undercut"):
        finding = finding_of(design, f"undercut {i}", "pin.radius", text)
        return Trouble(finding, (Remedy("pin.radius", 1e-6),))
    if ("limits", "pressure") not in design.lines and (
        design.limits or Limits()
    ).pressure == Limits().pressure:
        text += "; this limit is the default of limits.pressure"
    finding = finding_of(design, f"contact pressure {i}", "pin.width", text)
    return Trouble(finding, (Remedy("pin.width", 0.2), Remedy("spring.preload", 0.0), *shorter))


# ---- spring, start, imposed motion ----


def _solid_length(design: DesignFile, mechanism: Mechanism) -> list[Trouble]:
    """The spring's deflection, preload/stiffness + z, must stay below free length - solid length."""
    if design.spring_limits is None:
        return []
    free, solid = design.spring_limits
    spring = mechanism.spring
    before = spring.preload / spring.stiffness if spring.stiffness > 0.0 else 0.0
    z = float(mechanism.configuration(np.asarray(mechanism.reach()[1])).z)
    if before + z < free - solid:
        return []
    text = (
        f"spring at solid length: at stop.upper = {mechanism.upper:.6g} rad its deflection is"
        f" preload/stiffness + z = {1e3 * (before + z):.4g} mm: allowed is less than free_length -"
        f" solid_length = {1e3 * (free - solid):.4g} mm"
    )
    remedies = (Remedy("stop.upper", max(mechanism.lower, 0.0) + 0.01), Remedy("spring.preload", 0.0))
    return [Trouble(finding_of(design, "solid length", "stop.upper", text), remedies)]


def _pin_in_cam(design: DesignFile, mechanism: Mechanism) -> list[Trouble]:
    """A pin thicker than the cam in whose groove it runs."""
    pin, radius = design.pin, min(mechanism.radius)
    if pin is None or pin.radius < radius:
        return []
    cam = 1 + mechanism.radius.index(radius)
    text = (
        f"pin.radius = {1e3 * pin.radius:.6g} mm: allowed is less than cam{cam}.radius ="
        f" {1e3 * radius:.6g} mm; is the unit of one of both wrong?"
    )
    return [Trouble(finding_of(design, "pin in cam", "pin.radius", text), (Remedy("pin.radius", 1e-6),))]


def _start(design: DesignFile, mechanism: Mechanism) -> list[Trouble]:
    """The forward model starts between the stops."""
    theta = design.value("initial.theta")
    if design.model != "forward" or mechanism.lower <= theta <= mechanism.upper:
        return []
    text = (
        f"initial.theta = {theta:.6g} rad: allowed is stop.lower = {mechanism.lower:.6g} rad to stop.upper ="
        f" {mechanism.upper:.6g} rad"
    )
    middle = 0.5 * (mechanism.lower + mechanism.upper)
    return [Trouble(finding_of(design, "start", "initial.theta", text), (Remedy("initial.theta", middle),))]


def _imposed(design: DesignFile, mechanism: Mechanism) -> list[Trouble]:
    """The inverse model follows its imposed angle between the stops."""
    history = design.scenario.inputs.get("theta") if design.scenario else None
    if history is None or not len(history.value):
        return []
    outside = [value for value in history.value if not mechanism.lower <= value <= mechanism.upper]
    if not outside:
        return []
    far = max(outside, key=abs)
    text = (
        f"scenario.inputs.theta reaches {far:.6g} rad: allowed is stop.lower = {mechanism.lower:.6g} rad to"
        f" stop.upper = {mechanism.upper:.6g} rad"
    )
    key = "scenario.inputs.theta"
    remedy = Remedy("stop.upper" if far > 0.0 else "stop.lower", 1.001 * far)
    return [Trouble(finding_of(design, "imposed angle", key, text, value=far), (remedy,))]
