"""Dual cylindrical cam: its FMUs from Python, and as plants of python-control.

    Fmu, ContinuousFmu          one instance of an FMU: co-simulation, model exchange
    fmu_path                    where this package's FMUs are
    to_nonlinear_io_system      the forward FMU as a control.NonlinearIOSystem, continuous or sampled
    linearize                   its linear model about an operating point, a control.StateSpace
    CamHysteresis               its friction hysteresis: describing functions, limit cycles of position loops
    read_design, check_design   a design from a TOML file, and whether the design works
    identify                    friction, spring and losses from a recording of time, angle and torque
    simulate, export_fmu        its scenario over time, and an FMU with its values
    write_report, export_ssp    a page about the design, and an SSP package
    Fleet                       thousands of instances, stepped by one call
    write_view                  a page in which the design moves
    PlantCoupling               an own plant in Python on the FMU
    dualcam.design              best lead angles, and grooves that give a wanted torque
    dualcam.systems             motor, loads, motions and controllers for closed loops with the cam
    dualcam.study               parameter studies
    dualcam.gradient            gradients of runs through stick and slip, in JAX, PyTorch or NumPy
    dualcam.gym                 elbow, knee and car door as environments of gymnasium
    dualcam.mujoco              the cam on joints of a MuJoCo model

All errors are DualcamErrors, which are ValueErrors. Every name is loaded at its first use: `import dualcam`
alone loads no other package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from dualcam.common.moved import find_moved_modules

if TYPE_CHECKING:
    from dualcam import (
        checking,
        coupling,
        design,
        design_file,
        export,
        gradient,
        gym,  # noqa: F401  not in __all__
        identification,
        mujoco,  # noqa: F401
        plots,
        report,
        simulation,
        ssp,
        study,
        systems,
        view,
    )
    from dualcam.checking import Verdict, check_design
    from dualcam.common.mistakes import StudyError
    from dualcam.control.bridge import to_nonlinear_io_system
    from dualcam.control.harmonic_balance import LimitCycle
    from dualcam.control.hysteresis import CamHysteresis
    from dualcam.control.limit_cycles import LimitCycles
    from dualcam.control.linear import OperatingPoint, OperatingPointError, linearize
    from dualcam.control.sampled_loop import LoopMotion
    from dualcam.coupling import PlantCoupling
    from dualcam.design_file import DesignFile, DesignFileError, read_design
    from dualcam.errors import (
        CouplingError,
        DesignError,
        DualcamError,
        DualcamWarning,
        ExportError,
        FileError,
        FleetError,
        FmuError,
        IdentificationError,
        LimitCycleWarning,
        MujocoError,
        TaskError,
        UnitWarning,
        UnknownVariableError,
        UnstableCouplingWarning,
    )
    from dualcam.export import export_fmu
    from dualcam.fleet import Fleet, FleetState
    from dualcam.fmi.continuous_fmu import ContinuousFmu
    from dualcam.fmi.fmu import Fmu, RepeatedStart
    from dualcam.fmi.handle import FmuState
    from dualcam.fmi.library import fmu_path
    from dualcam.fmi.model_description import ModelDescription, Variable, read_model_description
    from dualcam.fmi.reals import Reals
    from dualcam.identification import Identification, identify
    from dualcam.report import write_report
    from dualcam.simulation import Trajectory, simulate
    from dualcam.ssp import export_ssp
    from dualcam.view import write_view

    __version__: str

__all__ = [
    "CamHysteresis",
    "ContinuousFmu",
    "CouplingError",
    "DesignError",
    "DesignFile",
    "DesignFileError",
    "DualcamError",
    "DualcamWarning",
    "ExportError",
    "FileError",
    "Fleet",
    "FleetError",
    "FleetState",
    "Fmu",
    "FmuError",
    "FmuState",
    "Identification",
    "IdentificationError",
    "LimitCycle",
    "LimitCycleWarning",
    "LimitCycles",
    "LoopMotion",
    "ModelDescription",
    "MujocoError",
    "OperatingPoint",
    "OperatingPointError",
    "PlantCoupling",
    "Reals",
    "RepeatedStart",
    "StudyError",
    "TaskError",
    "Trajectory",
    "UnitWarning",
    "UnknownVariableError",
    "UnstableCouplingWarning",
    "Variable",
    "Verdict",
    "__version__",
    "check_design",
    "checking",
    "coupling",
    "design",
    "design_file",
    "export",
    "export_fmu",
    "export_ssp",
    "fmu_path",
    "gradient",
    "identification",
    "identify",
    "linearize",
    "plots",
    "read_design",
    "read_model_description",
    "report",
    "simulate",
    "simulation",
    "ssp",
    "study",
    "systems",
    "to_nonlinear_io_system",
    "view",
    "write_report",
    "write_view",
]

_MODULE_OF = {
    "CamHysteresis": "control.hysteresis",
    "ContinuousFmu": "fmi.continuous_fmu",
    "CouplingError": "errors",
    "DesignError": "errors",
    "DesignFile": "design_file",
    "DesignFileError": "design_file",
    "DualcamError": "errors",
    "DualcamWarning": "errors",
    "ExportError": "errors",
    "FileError": "errors",
    "Fleet": "fleet",
    "FleetError": "errors",
    "FleetState": "fleet",
    "Fmu": "fmi.fmu",
    "FmuError": "errors",
    "FmuState": "fmi.handle",
    "Identification": "identification",
    "IdentificationError": "errors",
    "LimitCycle": "control.harmonic_balance",
    "LimitCycleWarning": "errors",
    "LimitCycles": "control.limit_cycles",
    "LoopMotion": "control.sampled_loop",
    "ModelDescription": "fmi.model_description",
    "MujocoError": "errors",
    "OperatingPoint": "control.linear",
    "OperatingPointError": "control.linear",
    "PlantCoupling": "coupling",
    "Reals": "fmi.reals",
    "RepeatedStart": "fmi.fmu",
    "StudyError": "common.mistakes",
    "TaskError": "errors",
    "Trajectory": "simulation",
    "UnitWarning": "errors",
    "UnknownVariableError": "errors",
    "UnstableCouplingWarning": "errors",
    "Variable": "fmi.model_description",
    "Verdict": "checking",
    "__version__": "common.version",
    "check_design": "checking",
    "export_fmu": "export",
    "export_ssp": "ssp",
    "fmu_path": "fmi.library",
    "identify": "identification",
    "linearize": "control.linear",
    "read_design": "design_file",
    "read_model_description": "fmi.model_description",
    "simulate": "simulation",
    "to_nonlinear_io_system": "control.bridge",
    "write_report": "report",
    "write_view": "view",
}
_MODULES = (
    "checking",
    "coupling",
    "design",
    "design_file",
    "export",
    "gradient",
    "gym",  # needs the extra of its name, and so is not in __all__
    "identification",
    "mujoco",  # as gym
    "plots",
    "report",
    "simulation",
    "ssp",
    "study",
    "systems",
    "view",
)

find_moved_modules()

if not TYPE_CHECKING:  # type checkers see the imports above, and report other names

    def __getattr__(name: str) -> object:
        from importlib import import_module

        if name in _MODULES:
            return import_module(f"dualcam.{name}")
        if name not in _MODULE_OF:
            from dualcam.common.moved import MOVED, moved_module

            if name in MOVED:
                return moved_module(name, stacklevel=2)
            from difflib import get_close_matches

            near = get_close_matches(name, __all__, n=3)
            hint = f"did you mean {' or '.join(near)}?" if near else "dir(dualcam) lists the names"
            raise AttributeError(f"module 'dualcam' has no attribute {name!r}: {hint}")
        value = globals()[name] = getattr(import_module(f"dualcam.{_MODULE_OF[name]}"), name)
        return value

    def __dir__() -> list[str]:
        return sorted(__all__)
