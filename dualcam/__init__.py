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

    dualcam.control             operating points and limit cycles, as linearize and CamHysteresis give them
    dualcam.fmi                 arrays of variables, repeated starts, model descriptions
    dualcam.errors              all errors and warnings

All errors are DualcamErrors, which are ValueErrors. Every name is loaded at its first use: `import dualcam`
alone loads no other package.
"""

from typing import TYPE_CHECKING

from dualcam.common.moved import find_moved_modules

if TYPE_CHECKING:
    from dualcam import (
        control,  # noqa: F401  not in __all__
        coupling,
        design,
        design_file,
        errors,
        fleet,
        fmi,
        gradient,
        gym,  # noqa: F401
        identification,
        mujoco,  # noqa: F401
        plots,
        ssp,
        study,
        systems,
    )
    from dualcam.checking import Verdict, check_design
    from dualcam.control import CamHysteresis, linearize, to_nonlinear_io_system
    from dualcam.coupling import PlantCoupling
    from dualcam.design_file import DesignFile, read_design
    from dualcam.export import export_fmu
    from dualcam.fleet import Fleet
    from dualcam.fmi import ContinuousFmu, Fmu, fmu_path
    from dualcam.identification import Identification, identify
    from dualcam.report import write_report
    from dualcam.simulation import Trajectory, simulate
    from dualcam.ssp import export_ssp
    from dualcam.view import write_view

    __version__: str

_NAMES = {  # names of this package by the module that has them
    "checking": "Verdict check_design",
    "common.version": "__version__",
    "control": "CamHysteresis linearize to_nonlinear_io_system",
    "coupling": "PlantCoupling",
    "design_file": "DesignFile read_design",
    "export": "export_fmu",
    "fleet": "Fleet",
    "fmi": "ContinuousFmu Fmu fmu_path",
    "identification": "Identification identify",
    "report": "write_report",
    "simulation": "Trajectory simulate",
    "ssp": "export_ssp",
    "view": "write_view",
}
_MODULE_OF = {name: module for module, names in _NAMES.items() for name in names.split()}
_NAMED_AS_PACKAGES = {  # rooms that are not in __all__, so that * hides no package -> the package they need
    "control": "control",
    "gym": "gymnasium",
    "mujoco": "mujoco",
}
_INNER = ("checking", "export", "report", "simulation", "view")  # whose names are those of this package

__all__ = [
    "CamHysteresis",
    "ContinuousFmu",
    "DesignFile",
    "Fleet",
    "Fmu",
    "Identification",
    "PlantCoupling",
    "Trajectory",
    "Verdict",
    "__version__",
    "check_design",
    "coupling",
    "design",
    "design_file",
    "errors",
    "export_fmu",
    "export_ssp",
    "fleet",
    "fmi",
    "fmu_path",
    "gradient",
    "identification",
    "identify",
    "linearize",
    "plots",
    "read_design",
    "simulate",
    "ssp",
    "study",
    "systems",
    "to_nonlinear_io_system",
    "write_report",
    "write_view",
]

find_moved_modules()

if not TYPE_CHECKING:  # type checkers see the imports above, and report other names

    def __getattr__(name: str) -> object:
        from importlib import import_module

        from dualcam.common import moved

        if name in _MODULE_OF:
            value = globals()[name] = getattr(import_module(f"dualcam.{_MODULE_OF[name]}"), name)
            return value
        if name in (*__all__, *_NAMED_AS_PACKAGES, *_INNER):
            return import_module(f"dualcam.{name}")
        if name in moved.MOVED:
            return moved.moved_module(name, stacklevel=2)
        if name in moved.NEW_PLACES:
            return moved.moved_name("dualcam", name, moved.NEW_PLACES[name], stacklevel=2)
        from difflib import get_close_matches

        near = moved.GUESSES.get(name) or " or ".join(get_close_matches(name, __all__, n=3))
        hint = f"did you mean {near}?" if near else "dir(dualcam) lists the names"
        raise AttributeError(f"module 'dualcam' has no attribute {name!r}: {hint}")

    def __dir__() -> list[str]:
        """Without the rooms whose package is not installed."""
        from importlib.util import find_spec

        return sorted([*__all__, *(room for room, needed in _NAMED_AS_PACKAGES.items() if find_spec(needed))])
