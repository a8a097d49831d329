"""Dual cylindrical cam: its FMUs from Python, and as plants of python-control.

    Fmu, ContinuousFmu          one instance of an FMU: co-simulation, model exchange
    fmu_path                    where this package's FMUs are
    to_nonlinear_io_system      the forward FMU as a control.NonlinearIOSystem, continuous or sampled
    linearize                   its linear model about an operating point, a control.StateSpace
    CamHysteresis               its friction hysteresis for describing function analysis
    dualcam.design              best lead angles, and grooves that give a wanted torque
    dualcam.systems             motor, loads, motions and controllers for closed loops with the cam
    dualcam.study               parameter studies

All errors are DualcamErrors, which are ValueErrors. Every name is loaded at its first use: `import dualcam`
alone loads no other package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dualcam import design, study, systems
    from dualcam.bridge import to_nonlinear_io_system
    from dualcam.continuous_fmu import ContinuousFmu
    from dualcam.errors import DesignError, DualcamError, FmuError, UnitWarning, UnknownVariableError
    from dualcam.fmu import Fmu, RepeatedStart
    from dualcam.handle import FmuState
    from dualcam.hysteresis import CamHysteresis
    from dualcam.library import fmu_path
    from dualcam.linear import OperatingPoint, OperatingPointError, linearize
    from dualcam.model_description import ModelDescription, Variable, read_model_description
    from dualcam.reals import Reals
    from dualcam.study.problem import StudyError

    __version__: str

__all__ = [
    "CamHysteresis",
    "ContinuousFmu",
    "DesignError",
    "DualcamError",
    "Fmu",
    "FmuError",
    "FmuState",
    "ModelDescription",
    "OperatingPoint",
    "OperatingPointError",
    "Reals",
    "RepeatedStart",
    "StudyError",
    "UnitWarning",
    "UnknownVariableError",
    "Variable",
    "__version__",
    "design",
    "fmu_path",
    "linearize",
    "read_model_description",
    "study",
    "systems",
    "to_nonlinear_io_system",
]

_MODULE_OF = {
    "CamHysteresis": "hysteresis",
    "ContinuousFmu": "continuous_fmu",
    "DesignError": "errors",
    "DualcamError": "errors",
    "Fmu": "fmu",
    "FmuError": "errors",
    "FmuState": "handle",
    "ModelDescription": "model_description",
    "OperatingPoint": "linear",
    "OperatingPointError": "linear",
    "Reals": "reals",
    "RepeatedStart": "fmu",
    "StudyError": "study.problem",
    "UnitWarning": "errors",
    "UnknownVariableError": "errors",
    "Variable": "model_description",
    "__version__": "version",
    "fmu_path": "library",
    "linearize": "linear",
    "read_model_description": "model_description",
    "to_nonlinear_io_system": "bridge",
}
_SUBPACKAGES = ("design", "study", "systems")

if not TYPE_CHECKING:  # type checkers see the imports above, and report other names

    def __getattr__(name: str) -> object:
        from importlib import import_module

        if name in _SUBPACKAGES:
            return import_module(f"dualcam.{name}")
        if name not in _MODULE_OF:
            raise AttributeError(f"module 'dualcam' has no attribute {name!r}; it has {', '.join(__all__)}")
        value = globals()[name] = getattr(import_module(f"dualcam.{_MODULE_OF[name]}"), name)
        return value

    def __dir__() -> list[str]:
        return sorted(__all__)
