"""The docstrings of public functions and classes: their examples run, their sections name every argument."""

import doctest
import importlib
import inspect
import pkgutil
import re

import pytest

import dualcam
import dualcam.design.tolerances
import dualcam.gym
import dualcam.mujoco
import dualcam.study
import dualcam.systems

SYSTEMS = tuple(module.name for module in pkgutil.walk_packages(dualcam.systems.__path__, "dualcam.systems."))
MODULES = tuple(
    module.name
    for module in pkgutil.walk_packages(dualcam.__path__, "dualcam.")
    if not module.name.endswith("__main__")
)
# Public modules of which every public function, class and method is checked besides dualcam.__all__.
WHOLE = (
    *("dualcam.design.statics", "dualcam.design.mechanism", "dualcam.design.torque"),
    *("dualcam.design.hertz", "dualcam.design.roller", "dualcam.design.helical_spring"),
    *("dualcam.design.spring_steel", "dualcam.design.spring_search", "dualcam.design.groove_wear"),
    *SYSTEMS,
    *("dualcam.gym.task", "dualcam.gym.batch", "dualcam.gym.environment", "dualcam.gym.vector"),
    *("dualcam.mujoco.cam_joint", "dualcam.mujoco.simulation", "dualcam.mujoco.ur3e_elbow"),
    *("dualcam.gradient.rollout", "dualcam.gradient.with_jax", "dualcam.gradient.with_torch"),
)
# Results of functions: users make none.
RETURNED = (
    *("FleetState", "FmuState", "ModelDescription", "OperatingPoint", "Variable"),
    *("DesignFile", "Identification", "Trajectory", "Verdict"),
    *("LimitCycle", "LimitCycles", "LoopMotion"),
)
SECTION = re.compile(r"^(\w[\w ]*)\n-+$", re.MULTILINE)
ENTRY = re.compile(r"^(\*?\*?\w[\w, *]*?)(?: :.*)?$", re.MULTILINE)


def public_names():
    """Public functions and classes by a name that a failed test shows."""
    found = {name: getattr(dualcam, name) for name in dualcam.__all__}
    found |= {f"dualcam.study.{name}": getattr(dualcam.study, name) for name in dualcam.study.__all__}
    tolerances = dualcam.design.tolerances
    found |= {f"{tolerances.__name__}.{name}": getattr(tolerances, name) for name in tolerances.__all__}
    for module in map(importlib.import_module, WHOLE):
        own = {name: thing for name, thing in vars(module).items() if not name.startswith("_")}
        found |= {
            f"{module.__name__}.{name}": thing
            for name, thing in own.items()
            if getattr(thing, "__module__", "") == module.__name__
        }
    return {
        name: thing
        for name, thing in found.items()
        if inspect.isfunction(thing) or (inspect.isclass(thing) and not issubclass(thing, Exception))
    }


def methods_of(thing):
    """Public methods, also inherited ones of this package."""
    listed = inspect.getmembers(thing, inspect.isfunction) if inspect.isclass(thing) else []
    return {
        name: method
        for name, method in listed
        if not name.startswith("_") and method.__module__.startswith("dualcam")
    }


PUBLIC = public_names()
METHODS = {f"{name}.{method}": f for name, thing in PUBLIC.items() for method, f in methods_of(thing).items()}


def sections(thing):
    """Text of each section of a docstring by the section's name."""
    parts = SECTION.split(inspect.cleandoc(thing.__doc__))
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def named(section):
    """Names of the entries of a section, such as `theta, omega : float`."""
    return [name.strip(" *") for match in ENTRY.finditer(section) for name in match[1].split(",")]


def arguments_of(thing):
    listed = inspect.signature(thing).parameters
    return [name for name in listed if name not in ("self", "args", "kwargs")]


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name):
    result = doctest.testmod(importlib.import_module(name))
    assert result.failed == 0


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_its_sections(name):
    """A function: arguments, result, example. A class: its arguments or attributes, and an example if users
    make instances of it."""
    thing = PUBLIC[name]
    found = sections(thing)
    is_result = name in RETURNED or (inspect.isclass(thing) and "Attributes" in found)
    if not is_result and arguments_of(thing):
        assert set(named(found["Parameters"])) == set(arguments_of(thing))
    if inspect.isfunction(thing):
        assert "Returns" in found or inspect.signature(thing).return_annotation in (None, "None")


@pytest.mark.parametrize("name", [name for name in PUBLIC if name in dualcam.__all__])
def test_what_a_user_calls_has_an_example(name):
    thing = PUBLIC[name]
    if inspect.isclass(thing) and issubclass(thing, UserWarning):
        return
    assert name in RETURNED or "Examples" in sections(thing)


@pytest.mark.parametrize("name", METHODS)
def test_a_public_method_has_its_sections(name):
    """Arguments by name and, if there is more than a short result, the result."""
    method = METHODS[name]
    assert method.__doc__, name
    found, arguments = sections(method), arguments_of(method)
    if arguments:
        assert set(named(found["Parameters"])) == set(arguments)
        assert "Returns" in found or inspect.signature(method).return_annotation in (None, "None")
