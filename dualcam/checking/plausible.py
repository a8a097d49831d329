"""Values that are strange beside the torque of the mechanism. Each rule only warns."""

from __future__ import annotations

import math

import numpy as np

from dualcam.checking.rules import WARNING
from dualcam.design import torque_band
from dualcam.design_file import DesignFile, Finding
from dualcam.errors import DesignError

SLOWEST = 1.0  # s: a cam that takes longer from stop to stop, driven by the torque to load, is strange
LARGEST_TORQUE = 20.0  # times the largest torque to load


def implausible(design: DesignFile) -> list[Finding]:
    """Warnings about the moment of inertia and the torque of the scenario, beside the torque to load."""
    try:
        mechanism = design.mechanism()
        torque = float(np.max(torque_band(mechanism, 61).load))
    except DesignError:
        return []
    if not 0.0 < torque < math.inf:
        return []
    found = [_inertia(design, torque, mechanism.upper - mechanism.lower), _torque(design, torque)]
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
    text = (
        f"scenario.inputs.tau reaches {far:.6g} N.m: this looks like N.cm or N.mm; {far:.6g} N.cm is"
        f" {far / 1e2:.6g} N.m. The largest torque to load is {torque:.4g} N.m"
    )
    return Finding(WARNING, "scenario.inputs.tau", far, text, kind="unit")
