"""What is wrong or strange in a design, found without the FMU: findings with a key of the design file.

The geometry and the strength are those of dualcam.design.assess. Here their findings get the keys, and the
keys whose change can help.
"""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from dualcam.checking.durability import durability
from dualcam.checking.trouble import Remedy, Trouble, shown_beside, trouble, value_of, with_value
from dualcam.common.groove_laws import CYCLOID, LAWS, PARAMETERS, GrooveLaw
from dualcam.design import Limits, Mechanism, torque_band
from dualcam.design.grooves import ClosedForm
from dualcam.design.strength import LimitViolation, examine
from dualcam.design_file import DesignFile, Finding
from dualcam.design_file.findings import ERROR, WARNING
from dualcam.errors import DesignError

OF_GROOVES = ("jam", "level", "self-locking", "lead angle", "undercut", "contact pressure")  # kinds
EQUAL_RADII = "equal radii"  # a kind, also of nearly equal ones: a design that is run only may have them
SAME_RADIUS = 1e-9  # relative difference of radii below which both count as equal
SAMPLES = 5  # angles at which torques of two designs are compared
WITHIN_POINTS = 'Closer points, or shape = "linear", keep the curve in the range of its points'
STOP_ROUNDING = 1e-9  # share of the range by which the inverse FMU lets theta pass a stop


def swap_warning(design: DesignFile, errors: Iterable[str]) -> Finding | None:
    """A warning if all errors are of grooves and go where the grooves, without radii, are exchanged."""
    if not all(kind.startswith(OF_GROOVES) for kind in errors):
        return None
    grooves = ("profile", *PARAMETERS)
    names = [f"cam{i}.{name}" for i in (1, 2) for name in grooves]
    others = [f"cam{3 - i}.{name}" for i in (1, 2) for name in grooves]
    exchanged = {name: design.value(other) for name, other in zip(names, others, strict=True)}
    swapped = replace(design, parameters=design.parameters | exchanged)
    if any(one.finding.severity == ERROR for one in troubles(swapped)):
        return None
    text = "with the grooves of cam 1 and cam 2 exchanged there is no error: are cam 1 and cam 2 swapped?"
    return Finding(WARNING, "cam1", None, text, kind="swapped")


def troubles(design: DesignFile, locate: bool = True) -> list[Trouble]:
    """All errors, and warnings about the geometry. Without `locate` faster, with angles of a coarse grid."""
    if early := _stops(design):
        return early
    try:
        mechanism = design.mechanism()
    except DesignError as error:
        return [_impossible(design, error)]
    limits = design.limits or Limits()
    _, failures = examine(mechanism, design.pin, limits, locate=locate)
    found = [_trouble(design, mechanism, failure) for failure in failures]
    more = (_solid_length, _start, _imposed, _pin_in_cam, _overlapping_walls)
    found += [one for rule in more for one in rule(design, mechanism)]
    return [*found, *durability(design, mechanism, propose=locate)]


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
    return [trouble(design, "stops", "stop.upper", text, hint=hint)]


def _impossible(design: DesignFile, error: DesignError) -> Trouble:
    """A groove that its class refuses, such as an ellipse that starts vertical."""
    steep = [f"cam{i}.lead_angle" for i in (1, 2) if "lead_angle" in _law(design, i).parameters]
    remedies = [Remedy(key, 0.1) for key in steep if value_of(design, key) > 0.1]
    return trouble(design, "groove", remedies[0].key if remedies else "", str(error), ERROR, *remedies)


def _trouble(design: DesignFile, mechanism: Mechanism, failure: LimitViolation) -> Trouble:
    what, text = failure.what, failure.text
    if what.endswith(" ends"):
        return _groove_end(design, mechanism, failure)
    if what == "spring force":
        remedy = Remedy("spring.preload", 1e3 * (1.0 + abs(failure.value)))
        hint = "Is the sign of spring.preload wrong?" if design.value("spring.preload") < 0.0 else ""
        return trouble(design, "spring force", "spring.preload", text, ERROR, remedy, hint=hint)
    if what.startswith("both grooves level"):
        laws = _law(design, 1), _law(design, 2)
        hint = "Two cycloids need stop.lower and initial.theta > 0, or another groove law on one cam"
        key, hint = f"cam1.{laws[0].parameters[0]}", hint if laws == (CYCLOID, CYCLOID) else ""
        remedies = *_steeper(mechanism, 1, 0.8), *_shorter(failure)
        return trouble(design, "level", key, text, ERROR, *remedies, hint=hint)
    if what.startswith("jam"):
        return _jam(design, mechanism, text)
    if what in design.parameters:
        return trouble(design, "limit", what, text)
    return _of_groove(design, mechanism, failure, 2 if what.endswith("2") else 1)


def _groove_end(design: DesignFile, mechanism: Mechanism, failure: LimitViolation) -> Trouble:
    """A groove that ends before a stop."""
    upper = failure.theta > 0.0 or mechanism.lower >= 0.0
    stop = "stop.upper" if upper else "stop.lower"
    remedy = Remedy(stop, 0.5 * failure.theta)
    return trouble(design, "groove end", stop, f"{stop}: {failure.text}", ERROR, remedy)


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
    return trouble(design, "jam", key, text, ERROR, *remedies)


def _of_groove(design: DesignFile, mechanism: Mechanism, failure: LimitViolation, i: int) -> Trouble:
    what, text = failure.what, failure.text
    key, friction = f"cam{i}.{_law(design, i).parameters[0]}", f"cam{i}.friction"
    shorter = _shorter(failure)
    if what.startswith("self-locking"):
        remedies = _steeper(mechanism, i, 1.2)
        hint = "If locking is meant, write self_locking = true below [limits]"
        if not design.value(f"cam{i}.friction_table"):
            remedies.append(Remedy(friction, 0.0))
        return trouble(design, f"self-locking {i}", key, text, ERROR, *remedies, *shorter, hint=hint)
    if what.startswith("lead angle"):
        low, high = (design.limits or Limits()).lead_angle
        remedies = _steeper(mechanism, i, 0.5 * (low + high))
        severity = WARNING if design.limits is None else ERROR
        return trouble(design, f"lead angle {i}", key, text, severity, *remedies, *shorter)
    if what.startswith("undercut"):
        return trouble(design, f"undercut {i}", "pin.radius", text, ERROR, Remedy("pin.radius", 1e-6))
    if ("limits", "pressure") not in design.lines and (
        design.limits or Limits()
    ).pressure == Limits().pressure:
        text += "; this limit is the default of limits.pressure"
    remedies = [Remedy("pin.width", 0.2), Remedy("spring.preload", 0.0)]
    return trouble(design, f"contact pressure {i}", "pin.width", text, ERROR, *remedies, *shorter)


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
    return [trouble(design, "solid length", "stop.upper", text, ERROR, *remedies)]


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
    return [trouble(design, "pin in cam", "pin.radius", text, ERROR, Remedy("pin.radius", 1e-6))]


def _overlapping_walls(design: DesignFile, mechanism: Mechanism) -> list[Trouble]:
    """Cams whose walls, each half the pin's width below and above the radius, overlap."""
    inner, outer = sorted(mechanism.radius)
    width = design.pin.width if design.pin else 0.0
    is_equal = outer - inner <= SAME_RADIUS * outer
    if not is_equal and outer - inner >= width - SAME_RADIUS * outer:
        return []
    first, second = (f"{1e3 * radius:.6g} mm" for radius in mechanism.radius)
    given = f"cam1.radius = {first} and cam2.radius = {second} cannot be built"
    if is_equal:
        given = f"cam1.radius = cam2.radius = {first}: equal radii cannot be built"
    walls, apart = ["cam 1", "cam 2"], "the pin's width"
    if design.pin:
        ends = [[1e3 * (radius + side * width) for side in (-0.5, 0.5)] for radius in mechanism.radius]
        walls = [f"cam {i} (radius {low:.6g} to {high:.6g} mm)" for i, (low, high) in enumerate(ends, 1)]
        apart = f"pin.width = {1e3 * width:.6g} mm"
    text = (
        f"{given}, because the walls of {' and '.join(walls)} overlap and the cams cannot stand inside one"
        f" another. Give the cams radii that differ by wall and clearance, at least {apart}"
        f"{_nested_radii(design, mechanism)}"
    )
    return [trouble(design, EQUAL_RADII, "cam2.radius", text, WARNING)]


def _nested_radii(design: DesignFile, mechanism: Mechanism) -> str:
    """A sentence with radii, one twice the other, of the same torque and stroke; empty where torque or stroke
    would change, or the walls would still overlap."""
    inner = 1.5 / sum(1.0 / radius for radius in mechanism.radius)
    if design.pin and inner < design.pin.width:
        return ""
    nested = with_value(with_value(design, "cam1.radius", inner), "cam2.radius", 2.0 * inner)
    with np.errstate(all="ignore"):  # grooves that jam or end early
        try:
            before, after = (torque_band(one, SAMPLES) for one in (mechanism, nested.mechanism()))
        except DesignError:
            return ""
    for name in ("z", "load", "release"):
        if not np.allclose(getattr(after, name), getattr(before, name), rtol=1e-6, atol=0.0, equal_nan=True):
            return ""
    radii = f"{1e3 * inner:.4g} and {2e3 * inner:.4g} mm"
    return f". These grooves have the same torque and stroke with radii of {radii}"


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
    return [trouble(design, "start", "initial.theta", text, ERROR, Remedy("initial.theta", middle))]


def _imposed(design: DesignFile, mechanism: Mechanism) -> list[Trouble]:
    """The inverse model follows its imposed angle between the stops."""
    history = design.scenario.inputs.get("theta") if design.scenario else None
    if history is None or not len(history.value):
        return []
    rounding = STOP_ROUNDING * (mechanism.upper - mechanism.lower)
    low, high = mechanism.lower - rounding, mechanism.upper + rounding
    outside = [extreme for extreme in history.extremes if not low <= extreme[1] <= high]
    if not outside:
        return []
    time, far = max(outside, key=lambda extreme: abs(extreme[1]))
    stop = mechanism.upper if far > mechanism.upper else mechanism.lower
    between = far not in history.value
    text = (
        f"scenario.inputs.theta reaches {shown_beside(far, stop, 6)} rad"
        f"{f' at {time:.4g} s, between its points' if between else ''}: allowed is stop.lower ="
        f" {mechanism.lower:.6g} rad to stop.upper = {mechanism.upper:.6g} rad"
    )
    remedy = Remedy("stop.upper" if far > 0.0 else "stop.lower", 1.001 * far)
    finding = Finding(ERROR, "scenario.inputs.theta", far, text, kind="imposed angle")
    return [Trouble(finding, (remedy,), hint=WITHIN_POINTS if between else "")]
