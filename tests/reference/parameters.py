"""Parameters of the mechanism, their start values, and names of modes and accounts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP, WEDGED = 1, 2, 3, 4, 5, 6
FLOWS = ("work_in", "work_ext", "heat_cam1", "heat_cam2", "heat_damper", "heat_shaft")  # integrated in time
HEATS = ("heat_cam1", "heat_cam2", "heat_damper", "heat_shaft", "heat_stop")
ENERGIES = ("work_in", "work_ext", "work_tuning", "spring", "kinetic", *HEATS, "residual")
PEAKS = ("torque", "omega", "reaction1", "reaction2")

Params = Mapping[str, Any]  # numbers, and paths of tables

DEFAULTS: dict[str, Any] = {
    **{
        f"cam{i}.{name}": value
        for i in (1, 2)
        for name, value in {
            "radius": 0.02,
            "profile": 1,
            "lead_angle": math.pi / 4,
            "ellipse_a": 0.05,
            "ellipse_b": 0.05,
            "ellipse_curvature": -1,
            "cycloid_rise": 0.02,
            "cycloid_angle": 1.3963,
            "table": "",
            "friction_table": "",
            "friction": 0.14,
            "friction_peak": 1.0,
            "stribeck_velocity": 0.01,
            "stribeck_exponent": 2,
            "friction_viscous": 0.0,
            "friction_load_exponent": 0.0,
            "friction_load": 100.0,
            "wear": 0.0,
        }.items()
    },
    "spring.preload": 50.0,
    "spring.stiffness": 50000.0,
    "spring.stiffness2": 0.0,
    "spring.stiffness3": 0.0,
    "damper.c_load": 0.0,
    "damper.q_load": 0.0,
    "damper.c_release": 0.0,
    "damper.q_release": 0.0,
    "inertia.shaft": 0.002,
    "inertia.follower_mass": 0.0,
    "inertia.follower": 0.0,
    "shaft.damping": 0.0,
    "stop.lower": 0.0,
    "stop.upper": 1.3963,
    "stop.restitution": 0.0,
    "initial.theta": 0.0,
    "initial.omega": 0.0,
    "contacts": 2,
}
CAM = [name.removeprefix("cam1.") for name in DEFAULTS if name.startswith("cam1.")]
INTEGERS = frozenset(
    name
    for name in DEFAULTS
    if name.endswith(("profile", "curvature", "stribeck_exponent")) or name == "contacts"
)


class Refused(ValueError):
    """The scene has no well-posed answer: loading jam, moving wedge, or no consistent flanks."""
