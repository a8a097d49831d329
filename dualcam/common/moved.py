"""Modules that have moved and names that have changed: for one release the old ones still work, and warn."""

from __future__ import annotations

import sys
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from dualcam.errors import DualcamError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from importlib.machinery import ModuleSpec
    from types import ModuleType

P = ParamSpec("P")
R = TypeVar("R")

_ROOMS = {  # new place -> names of the modules that kept their names
    "common": "archive arrays html_page module_calls paths process_bound unit_guards version",
    "control": "bridge forward harmonic_balance hysteresis limit_cycles linear sampled_loop swing",
    "coupling": "held_feedback plant",
    "design_file": "durability",
    "fmi": "binary continuous_fmu fmi2 fmi3 fmu handle instance library model_description reals variables",
    "report": "summary",
    "systems.blocks": "systems.axis systems.axis_bank systems.current_loop systems.elementwise"
    " systems.elliptical_cam systems.grease systems.gravity systems.helical_cam systems.impedance"
    " systems.motions systems.motor systems.motor_bank systems.path_integral systems.pendulum"
    " systems.position_controller systems.radau_grid systems.record systems.slow_motion"
    " systems.speed_controller systems.thermal_network",
    "systems.machines": "systems.car_door systems.clamp systems.elbow systems.elbow_controllers systems.gait"
    " systems.knee systems.payload_filter systems.robot_arm systems.swing",
}
MOVED = {  # old path -> new path, both below dualcam
    old: f"{room}.{old.rpartition('.')[2]}" for room, names in _ROOMS.items() for old in names.split()
} | {
    "durability_plots": "plots.design",
    "platforms": "fmi.binary",
    "report_durability": "report.durability",
    "report_inputs": "report.inputs",
    "svg": "common.html_page",
}

NEW_PLACES = {  # old name in dualcam -> its place below dualcam
    name: f"{room}.{name}"
    for room, names in {
        "control": "LimitCycle LimitCycles LoopMotion OperatingPoint",
        "errors": "CouplingError DesignError DesignFileError DualcamError DualcamWarning ExportError"
        " FileError FleetError FmuError IdentificationError LimitCycleWarning MujocoError"
        " OperatingPointError StudyError TaskError UnitWarning UnknownVariableError UnstableCouplingWarning",
        "fleet": "FleetState",
        "fmi": "FmuState ModelDescription Reals RepeatedStart Variable read_model_description",
    }.items()
    for name in names.split()
}
GUESSES = {"nlsys": "to_nonlinear_io_system", "ss": "linearize"}  # names of python-control


def moved_module(old: str, stacklevel: int) -> ModuleType:
    """The module whose old path below `dualcam` this is. `stacklevel` is that of warnings.warn."""
    import warnings
    from importlib import import_module

    text = f"dualcam.{old} has moved: import dualcam.{MOVED[old]}. The old path goes with the next release"
    warnings.warn(text, DeprecationWarning, stacklevel=stacklevel + 1)
    return import_module(f"dualcam.{MOVED[old]}")


def moved_name(module: str, old: str, new: str, stacklevel: int) -> object:
    """What an old name of `module` means, with a warning. `new`: `room.name`, or a name in `module`."""
    import warnings
    from importlib import import_module

    room, _, name = new.rpartition(".")
    place = f"dualcam.{room}" if room else module
    text = f"{module}.{old} is now {place}.{name}. The old name goes with the next release"
    warnings.warn(text, DeprecationWarning, stacklevel=stacklevel + 1)
    return getattr(import_module(place), name)


def old_names(module: str, now: dict[str, str]) -> Callable[[str], object]:
    """A `__getattr__` for a module in which names have changed. `now`: as `moved_name` takes them."""

    def __getattr__(name: str) -> object:
        if name not in now:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        return moved_name(module, name, now[name], stacklevel=2)

    return __getattr__


def also_called(**now: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """The function or class takes an argument by another keyword, too. `now`: other keyword = its name."""

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        if isinstance(function, type):
            function.__init__ = decorated(function.__init__)  # type: ignore[misc]
            return function

        @wraps(function)
        def call(*arguments: Any, **named: Any) -> R:  # noqa: ANN401
            for other in now.keys() & named.keys() if named else ():
                if now[other] in named:
                    raise DualcamError(f"{now[other]} and {other} mean the same: allowed is one of them")
                named[now[other]] = named.pop(other)
            return function(*arguments, **named)

        return call

    return decorated


class _OldPaths:
    """Finds and loads modules by their old paths, after all other finders."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: object = None) -> ModuleSpec | None:
        if name.removeprefix("dualcam.") not in MOVED or not name.startswith("dualcam."):
            return None
        from importlib.machinery import ModuleSpec

        return ModuleSpec(name, self)  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        name = module.__name__
        sys.modules[name] = moved_module(name.removeprefix("dualcam."), stacklevel=2)


def find_moved_modules() -> None:
    """From now on `import` knows the old paths."""
    sys.meta_path.append(_OldPaths())
