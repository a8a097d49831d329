"""What the handles for co-simulation and model exchange share: variables by name, derivatives, states."""

import difflib
import math
import weakref
from collections.abc import Iterable, Mapping, Sequence
from ctypes import c_double, c_uint, c_void_p
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import Array, number_of, real_array
from dualcam.common.entries import repeated
from dualcam.common.process_bound import ProcessBound
from dualcam.common.unit_guards import warn_units
from dualcam.errors import DualcamError, FmuError, UnknownVariableError
from dualcam.fmi.binary import Use, interface_of
from dualcam.fmi.fmi2 import Fmi2Instance
from dualcam.fmi.fmi3 import Fmi3Instance
from dualcam.fmi.instance import START_FAILED, Instance, References
from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import Interface, Kind, Scalar, Variable, read_model_description
from dualcam.fmi.reals import Reals

INSTANCES: dict[int, type[Instance]] = {2: Fmi2Instance, 3: Fmi3Instance}
DOUBLES = ("Real", "Float64")  # types of variables that a group can hold
OWN_NAMES = {"cam1.lead_angle", "cam2.lead_angle", "spring.stiffness"}  # only the dual cam's FMUs have all
Names = Sequence[str]
NAMES_LISTED = 12  # most names in a message about an unknown variable


class FmuState(ProcessBound):
    """The whole state of an instance, from `save_state`. The state is freed with the last reference to it."""

    _instead = "restore it into its own FMU"

    def __init__(self, instance: Instance, address: int, time: float) -> None:
        self._instance, self._address, self._time = instance, address, time
        weakref.finalize(self, instance.free_state, address)

    def __repr__(self) -> str:
        return f"<FmuState at {self._time:g} s>"


class Handle(ProcessBound):
    """The common part of Fmu and ContinuousFmu.

    Attributes
    ----------
    path : The file.
    description : What the FMU says about itself.
    parameters : Start values of the last `start`.
    """

    _use: Use
    _instead = "open a new one there from its `path`, and call start with its `parameters`"

    def __init__(self, source: str | Path, fmi: int | None = None) -> None:
        self.path = source_path(source, fmi)
        self.description = read_model_description(self.path)
        version = self.description.fmi_major
        if fmi is not None and fmi != version:
            raise FmuError(f"{self.path} is of FMI {version}.0: allowed is fmi = {version}, or None")
        self._variables = {variable.name: variable for variable in self.description.variables}
        self._instance = INSTANCES[version](self.path, self.description, self._use)
        self._close = weakref.finalize(self, self._instance.free)
        self._is_dual_cam = set(self._variables) >= OWN_NAMES
        self._is_new = True
        self.parameters: dict[str, Scalar] = {}
        self._time = 0.0

    def __enter__(self) -> Self:
        self._instance.require_open()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        what = f"{self.description.model_name}, FMI {self.description.fmi_version}, {self._use}"
        if not self._instance.is_open:
            state = "closed"
        else:
            state = "not started" if self._instance.refusal else f"at {self._time:g} s"
        return f"<{type(self).__name__} {what}, {state}>"

    def close(self) -> None:
        """Free the instance, unload the library, delete the unpacked files. Any later call is an FmuError."""
        self._close()

    def abandon(self) -> None:
        """Instead of `close`, after FMI's status Fatal: FMI allows no further call."""
        self._instance.abandon()

    @property
    def time(self) -> float:
        """Present time [s], at which the next step begins. The times of many equal steps add up rounding
        errors, which assigning the exact time removes."""
        self._instance.require_open()
        return self._time

    @time.setter
    def time(self, time: float) -> None:
        self._instance.require_open()
        self._time = number_of(time, "time")

    @property
    def interface(self) -> Interface:
        """What the FMU can do in this handle's use."""
        return interface_of(self.path, self.description, self._use)

    def _begin(self, parameters: Mapping[str, Scalar], time: float, tolerance: float | None) -> None:
        """Up to initialization mode."""
        if not (isinstance(parameters, Mapping) and all(isinstance(name, str) for name in parameters)):
            raise FmuError(f"start({parameters!r}): allowed is a dict of names and values, or nothing")
        time = number_of(time, "time")
        if tolerance is not None:
            tolerance = number_of(tolerance, "tolerance", "a finite number > 0, or None")
        instance = self._instance
        if not self._is_new:
            instance.call(instance.RESET)
        self._is_new = False
        instance.refuse_calls(START_FAILED)
        if self._is_dual_cam:
            warn_units({name: (name, value) for name, value in parameters.items()}, stacklevel=4)
        for name, value in parameters.items():
            self._set_start(name, value)
        for name, arguments in instance.initialization_calls(tolerance, time):
            instance.call(name, *arguments)
        self.parameters = dict(parameters)
        self._time = time

    @property
    def names(self) -> list[str]:
        """Names of all variables."""
        return list(self._variables)

    def variable(self, name: str, *kinds: Kind) -> Variable:
        """The description of the variable `name`. FmuError where the variable is of another kind.

        `kinds`: allowed kinds, of "real", "integer", "boolean" and "string"; where none is given, all.
        """
        if not isinstance(name, str):
            raise UnknownVariableError(f"variable {name!r}: allowed is the name of one variable, a text")
        if (variable := self._variables.get(name)) is None:
            raise UnknownVariableError(unknown_variable(name, self.names, self.description.model_name))
        if kinds and variable.kind not in kinds:
            allowed = " or ".join(kind.capitalize() for kind in kinds)
            raise FmuError(f"{name} is {variable.type}: allowed is {allowed}")
        return variable

    def reals(self, *names: str) -> Reals:
        """A group of real variables that is read or written often, with its own buffer. FmuError where one of
        `names` is of another kind, or stands twice.
        """
        return Reals(self._instance, names, self._references(names_of(names, "names")))

    def get(self, name: str) -> Scalar:
        """The value of the variable `name` of any kind, in its unit, for use outside the loop."""
        variable = self.variable(name)
        self._instance.require_calls_allowed()
        return self._instance.get(variable)

    def real(self, name: str) -> float:
        """As `get`, for a real variable alone: FmuError where `name` is of another kind."""
        self.variable(name, "real")
        return float(self.get(name))

    def set(self, name: str, value: Scalar) -> None:
        """Set one variable of any kind, for use outside the loop: inputs and tunable parameters. Start values
        go into `start`.

        `name` of the variable. `value`: in the variable's unit. FmuError where the value does not suit the
        variable's type.
        """
        self.variable(name)
        self._instance.require_calls_allowed()
        self._set(name, value)

    def _set(self, name: str, value: Scalar) -> None:
        variable = self.variable(name)
        self._instance.set(variable, suitable_value(variable, value))

    def _set_start(self, name: str, value: Scalar) -> None:
        """Set a start value. The error for a state names the parameter of its start."""
        try:
            self._set(name, value)
        except FmuError as error:
            if (initial := f"initial.{name}") in self._variables:
                raise FmuError(f"{error}; {initial} sets the start") from None
            raise

    def jacobian(self, unknowns: Names, knowns: Names) -> Array:
        """Partial derivatives at the present point, shape (n, m), in the unit of the unknown per unit of the
        known. FmuError where the FMU has no such derivative.

        `unknowns`: n outputs and derivatives of states (`alpha`). `knowns`: m inputs, states (`theta`,
        `omega`) and tunable parameters.
        """
        unknowns, knowns = names_of(unknowns, "unknowns"), names_of(knowns, "knowns")
        columns = [self.directional_derivative(unknowns, [known], [1.0]) for known in knowns]
        return np.reshape(columns, (len(knowns), len(unknowns))).T

    def directional_derivative(self, unknowns: Names, knowns: Names, seed: ArrayLike) -> Array:
        """Product of the partial derivatives with a direction: jacobian(unknowns, knowns) @ seed, shape (n,).

        `unknowns`, `knowns`, errors: as in `jacobian`. `seed`: the direction, in the units of the knowns,
        shape (m,).
        """
        unknowns, knowns = names_of(unknowns, "unknowns"), names_of(knowns, "knowns")
        rows, columns = self._references(unknowns), self._references(knowns)
        self._instance.require_calls_allowed()
        if not self.interface.provides_directional_derivatives:
            raise FmuError(f"{self.path} provides no directional derivatives")
        direction = (c_double * len(knowns))(*real_array(seed, "seed", FmuError, (len(knowns),)))
        product = (c_double * len(unknowns))()
        self._instance.directional_derivative(rows, columns, direction, product)
        return np.array(product)

    def _references(self, names: Names) -> References:
        variables = [self.variable(name, "real") for name in names]
        for variable in variables:
            if variable.type not in DOUBLES or variable.is_array:
                what = "an array" if variable.is_array else variable.type
                raise FmuError(f"{variable.name} is {what}: allowed is {' or '.join(DOUBLES)}, a scalar")
        return (c_uint * len(names))(*(variable.value_reference for variable in variables))

    def save_state(self) -> FmuState:
        """The whole state of the instance now, for `restore_state`. FmuError where the FMU cannot save it."""
        self._instance.require_calls_allowed()
        if not self.interface.can_save_state:
            raise FmuError(f"{self.path} cannot save its state: canGetAndSetFMUstate is not set")
        return FmuState(self._instance, self._instance.save_state(), self._time)

    def restore_state(self, state: FmuState) -> None:
        """Go back to `state` of `save_state` of this instance, with its `time`. FmuError for another one."""
        if not isinstance(state, FmuState):
            raise FmuError(f"restore_state({state!r}): allowed is a state from save_state")
        if state._instance is not self._instance:
            raise FmuError("this state is of another instance: allowed are those that this one gave")
        self._instance.call(self._instance.SET_STATE, c_void_p(state._address))
        self._instance.allow_calls()
        self._time = state._time


def names_of(names: Names, argument: str) -> list[str]:
    """`names` as a list. FmuError for one text, for what is no sequence, and for a name that stands twice."""
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise FmuError(f"{argument} = {names!r}: allowed is a list of names of variables")
    found = list(names)
    if repeated(found):
        raise FmuError(f"{argument} = {found}: allowed is each variable once")
    return found


def unknown_variable(name: str, names: list[str], model: str) -> str:
    """A message with names near the unknown one."""
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    group = name.split(".")[0]
    listed = [other for other in names if other.split(".")[0] == group] if "." in name else []
    listed = listed or [other for other in names if "." not in other]
    more = f" and {len(names) - NAMES_LISTED} more" if len(listed) > NAMES_LISTED else ""
    guess = f"did you mean {' or '.join(near)}? Allowed" if near else "allowed"
    return f"{model} has no variable {name!r}: {guess} are {', '.join(listed[:NAMES_LISTED])}{more}"


def suitable_value(variable: Variable, value: object) -> Scalar:
    """`value` as the kind of the variable. FmuError if it is something else."""
    if variable.kind == "string":
        if not isinstance(value, str):
            raise FmuError(f"{variable.name} = {value!r}: allowed is text")
        return value
    if variable.kind == "boolean":
        if not np.isscalar(value) or value not in (0, 1):
            raise FmuError(f"{variable.name} = {value!r}: allowed are True and False")
        return bool(value)
    if type(value) is int and variable.kind == "integer":  # a float does not hold all integers of 64 bits
        return value
    try:
        number = float(real_array(value, variable.name, shape=()))  # type: ignore[arg-type]
    except DualcamError:
        raise FmuError(f"{variable.name} = {value!r}: allowed is a number ({variable.type})") from None
    if variable.kind != "integer":
        return number
    if not (math.isfinite(number) and number == int(number)):
        raise FmuError(f"{variable.name} = {value!r}: allowed are whole numbers")
    return int(number)
