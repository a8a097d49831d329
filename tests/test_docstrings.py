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
# Rooms of which every public name is checked besides dualcam.__all__.
ROOMS = (
    *(dualcam.design, dualcam.design.tolerances, dualcam.study, dualcam.gym, dualcam.mujoco, dualcam.fmi),
    *(dualcam.gradient, dualcam.coupling, dualcam.identification, dualcam.fleet, dualcam.control),
)
# Results of functions: users make none.
RETURNED = (
    *("FleetState", "FmuState", "ModelDescription", "OperatingPoint", "Variable"),
    *("DesignFile", "Identification", "Trajectory", "Verdict"),
    *("LimitCycle", "LimitCycles", "LoopMotion"),
    *("Assessment", "LimitViolation"),
)
SECTION = re.compile(r"^(\w[\w ]*)\n-+$", re.MULTILINE)
ENTRY = re.compile(r"^(\*?\*?\w[\w, *]*?)(?: :.*)?$", re.MULTILINE)


def public_names():
    """Public functions and classes by a name that a failed test shows."""
    found = {name: getattr(dualcam, name) for name in dualcam.__all__}
    for room in ROOMS:
        found |= {f"{room.__name__}.{name}": getattr(room, name) for name in room.__all__}
    for module in map(importlib.import_module, SYSTEMS):
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
    """Public methods, also inherited ones of this package; of overrides the method that they replace."""
    if not inspect.isclass(thing):
        return {}
    own = [base for base in inspect.getmro(thing) if base.__module__.startswith("dualcam")]
    methods = {name: getattr(f, "__func__", f) for base in own for name, f in vars(base).items()}
    return {name: f for name, f in methods.items() if inspect.isfunction(f) and not name.startswith("_")}


PUBLIC = public_names()
METHODS = {f"{name}.{method}": f for name, thing in PUBLIC.items() for method, f in methods_of(thing).items()}


def sections(thing):
    """Text of each section of a docstring by the section's name."""
    parts = SECTION.split(inspect.cleandoc(thing.__doc__))
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def named(section):
    """Names of the entries of a section, such as `theta, omega : float`."""
    return [name.strip(" *") for match in ENTRY.finditer(section) for name in match[1].split(",")]


def undocumented(thing):
    """Arguments neither in the section Parameters nor, as `name`, in the text before the sections."""
    if inspect.isclass(thing) and not {"__init__", "__new__"} & set(vars(thing)):
        return set()  # they are those of the base class
    text = SECTION.split(inspect.cleandoc(thing.__doc__))[0]
    listed = {*named(sections(thing).get("Parameters", "")), *re.findall(r"`(?:\*\*)?(\w+)`", text)}
    return set(arguments_of(thing)) - listed


def has_result(thing):
    """A docstring with Parameters has Returns, too; in others the text says what comes back."""
    found, result = sections(thing), inspect.signature(thing).return_annotation
    return "Parameters" not in found or "Returns" in found or result in (None, "None")


def arguments_of(thing):
    listed = inspect.signature(thing).parameters
    return [name for name in listed if name not in ("self", "cls", "args", "kwargs")]


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name):
    result = doctest.testmod(importlib.import_module(name))
    assert result.failed == 0


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_its_sections(name):
    """A function: arguments and result. A class: its arguments, or attributes if users make none."""
    thing = PUBLIC[name]
    if not (thing.__name__ in RETURNED or (inspect.isclass(thing) and "Attributes" in sections(thing))):
        assert undocumented(thing) == set()
    assert set(named(sections(thing).get("Parameters", ""))) <= set(arguments_of(thing))
    assert inspect.isclass(thing) or has_result(thing)


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
    assert undocumented(method) == set()
    assert has_result(method)
