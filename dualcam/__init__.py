"""Dual cylindrical cam: its FMUs from Python, and as plants of python-control.

    Fmu, ContinuousFmu          one instance of an FMU: co-simulation, model exchange
    to_nonlinear_io_system      the forward FMU as a control.NonlinearIOSystem, continuous or sampled
    linearize                   its linear model about an operating point, a control.StateSpace
    CamHysteresis               its friction hysteresis for describing function analysis
    dualcam.design              best lead angles, and grooves that give a wanted torque
    dualcam.systems             motor, loads, motions and controllers for closed loops with the cam
    dualcam.study               parameter studies

The names that need python-control are loaded at their first use: that import takes a second or two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dualcam.fmu import ContinuousFmu, Fmu, FmuError, FmuState, Reals, UnknownVariableError

if TYPE_CHECKING:
    from dualcam.bridge import to_nonlinear_io_system
    from dualcam.hysteresis import CamHysteresis
    from dualcam.linear import OperatingPoint, OperatingPointError, linearize

__all__ = [
    "CamHysteresis",
    "ContinuousFmu",
    "Fmu",
    "FmuError",
    "FmuState",
    "OperatingPoint",
    "OperatingPointError",
    "Reals",
    "UnknownVariableError",
    "linearize",
    "to_nonlinear_io_system",
]

_LOADED_AT_FIRST_USE = {
    "CamHysteresis": "dualcam.hysteresis",
    "OperatingPoint": "dualcam.linear",
    "OperatingPointError": "dualcam.linear",
    "linearize": "dualcam.linear",
    "to_nonlinear_io_system": "dualcam.bridge",
}


def __getattr__(name: str) -> Any:  # noqa: ANN401
    if name not in _LOADED_AT_FIRST_USE:
        raise AttributeError(f"module 'dualcam' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_LOADED_AT_FIRST_USE[name]), name)
