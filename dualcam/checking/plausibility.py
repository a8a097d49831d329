"""What is strange in a design that works: its moment of inertia, and the torque and times of its scenario."""

import math

import numpy as np

from dualcam.checking.rules import WITHIN_POINTS
from dualcam.design import Mechanism, torque_band
from dualcam.design_file import DesignFile, Finding
from dualcam.design_file.findings import WARNING
from dualcam.errors import DesignError
from dualcam.fmi.variables import inputs_of
from dualcam.scenario.history import History

SLOWEST = 1.0  # s: a cam that takes longer from stop to stop, driven by the torque to load, is strange
SMALL_TORQUES = {"N.cm": 1e-2, "N.mm": 1e-3}  # N.m
LARGEST_TORQUE = 20.0  # times the largest torque to load
LARGEST_OVERSHOOT = 0.01  # of a smooth curve beyond its points, as a share of their range


def implausible(design: DesignFile) -> list[Finding]:
    """Warnings about the moment of inertia, and the torque and times of the scenario."""
    return [*_beside_torque(design), *_overshoots(design)]


def _beside_torque(design: DesignFile) -> list[Finding]:
    """What is strange beside the largest torque to load; nothing where there is no such torque."""
    try:
        mechanism = design.mechanism()
        torque = float(np.max(torque_band(mechanism, 61).load))
    except DesignError:
        return []
    if not 0.0 < torque < math.inf:
        return []
    found = [
        _inertia(design, torque, mechanism.upper - mechanism.lower),
        _torque(design, torque),
        _late(design),
        _still(design, mechanism),
    ]
    return [finding for finding in found if finding]


def _inertia(design: DesignFile, torque: float, angle: float) -> Finding | None:
    """A cam whose inertia makes it slow: t = sqrt(2 angle inertia/torque), from rest."""
    inertia = design.value("inertia.shaft")
    time = math.sqrt(2.0 * angle * inertia / torque)
    if time <= SLOWEST or "inertia.shaft" not in design.parameters:
        return None
    text = (
        f"inertia.shaft = {inertia:.6g} kg.m2: this looks like kg.cm2; {inertia:.6g} kg.cm2 is"
        f" {inertia / 1e4:.6g} kg.m2. The largest torque to load, {torque:.4g} N.m, would take {time:.3g} s"
        " to turn this inertia from stop to stop"
    )
    return Finding(WARNING, "inertia.shaft", inertia, text, kind="unit")


def _torque(design: DesignFile, torque: float) -> Finding | None:
    history = design.scenario.inputs.get("tau") if design.scenario else None
    far = max(history.value, key=abs, default=0.0) if history else 0.0
    if abs(far) <= LARGEST_TORQUE * torque:
        return None
    unit, factor = min(SMALL_TORQUES.items(), key=lambda entry: abs(math.log(abs(far) * entry[1] / torque)))
    text = (
        f"scenario.inputs.tau reaches {far:.6g} N.m: this looks like {unit}; {far:.6g} {unit} is"
        f" {far * factor:.6g} N.m. The largest torque to load is {torque:.4g} N.m"
    )
    return Finding(WARNING, "scenario.inputs.tau", far, text, kind="unit")


def _late(design: DesignFile) -> Finding | None:
    """Points of an input after the end of the scenario, which have no effect."""
    scenario = design.scenario
    for name, history in scenario.inputs.items() if scenario else ():
        if scenario and len(history.time) and history.time[-1] > scenario.stop * (1.0 + 1e-9):
            text = (
                f"scenario.inputs.{name} has points up to {history.time[-1]:.6g} s, and the scenario ends at"
                f" stop = {scenario.stop:.6g} s: the later points have no effect"
            )
            return Finding(WARNING, f"scenario.inputs.{name}", history.time[-1], text, kind="scenario")
    return None


def _still(design: DesignFile, mechanism: Mechanism) -> Finding | None:
    """A torque that stays inside the stick band of the start, where the cam is at rest."""
    scenario = design.scenario
    if scenario is None or set(scenario.inputs) != {"tau"} or design.value("initial.omega") != 0.0:
        return None
    history, start = scenario.inputs["tau"], design.value("initial.theta")
    if history.shape != "linear" or history.derivative_of:
        return None
    inside = [value for time, value in zip(history.time, history.value, strict=True) if time < scenario.stop]
    acting = [*inside, float(np.interp(scenario.stop, history.time, history.value))]
    release, load = (float(edge) for edge in mechanism.band(start))
    at_lower, at_upper = start <= mechanism.lower, start >= mechanism.upper
    if max(acting) > load and not at_upper:
        return None
    if min(acting) < release and not at_lower:
        return None
    text = (
        f"scenario.inputs.tau stays between {min(acting):.6g} and {max(acting):.6g} N.m: the cam never leaves"
        f" theta = {math.degrees(start):.4g} deg, where {load:.4g} N.m load and below {release:.4g} N.m the"
        " spring turns the cam back"
    )
    return Finding(WARNING, "scenario.inputs.tau", max(acting), text, kind="scenario")


def _overshoots(design: DesignFile) -> list[Finding]:
    """Smooth curves that leave the range of their points."""
    histories = design.scenario.inputs if design.scenario else {}
    found = [
        _overshoot(name, history, inputs_of(design.model)[name].unit)
        for name, history in histories.items()
        if history.shape == "smooth" and not history.derivative_of
    ]
    return [finding for finding in found if finding]


def _overshoot(name: str, history: History, unit: str) -> Finding | None:
    low, high = min(history.value), max(history.value)
    beyond = {extreme: max(low - extreme[1], extreme[1] - high) for extreme in history.extremes}
    outside = [extreme for extreme in beyond if beyond[extreme] > LARGEST_OVERSHOOT * (high - low)]
    if not outside:
        return None
    reached = " and ".join(f"{value:.4g} {unit} at {time:.4g} s" for time, value in outside)
    text = (
        f"scenario.inputs.{name}: the smooth curve reaches {reached}, and its points are between {low:.4g}"
        f" and {high:.4g} {unit}. {WITHIN_POINTS}"
    )
    _, far = max(outside, key=lambda extreme: beyond[extreme])
    return Finding(WARNING, f"scenario.inputs.{name}", far, text, kind="scenario")
