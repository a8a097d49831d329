"""One instance of an FMI 2.0 FMU from Python, with names instead of value references, the FMU's messages in
errors, and fast enough for a 1 kHz loop.

FMPy reads the description and loads the binary. This module adds buffers that are laid out once: reading or
writing a group of reals costs one call into the FMU and allocates only the returned floats.

    with Fmu("build/DualCamForward.fmu") as fmu:
        command, state = fmu.reals("tau"), fmu.reals("theta", "omega")
        fmu.start({"inertia.shaft": 0.2})
        command.values[0] = 1.5
        command.write()
        fmu.step(1e-3)
        theta, omega = state.read()

An instance must not be used from two threads at once; instances share nothing.
"""

from __future__ import annotations

import ctypes
import difflib
import weakref
import zipfile
from collections.abc import Mapping, Sequence
from ctypes import byref, c_char_p, c_double, c_int, c_uint, c_void_p
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2EventInfo
from fmpy.model_description import ModelDescription, ScalarVariable
from numpy.typing import ArrayLike, NDArray

from dualcam.errors import FmuError, UnknownVariableError
from dualcam.instance import OK_OR_WARNING, Instance

Scalar = float | int | bool | str
Array = NDArray[np.float64]

NAMES_LISTED = 12  # most names in a message about an unknown variable


# ---- groups of reals ----


class Reals:
    """A fixed group of n real variables with its own buffer `values`, shape (n,), in the order in which they
    were named and in the FMU's units."""

    def __init__(self, instance: Instance, names: Sequence[str], references: Sequence[int]) -> None:
        self.names = tuple(names)
        self.values = np.zeros(len(names))
        self._instance = instance
        self._count = len(names)
        self._references = (c_uint * self._count)(*references)
        # The same memory: ctypes passes it on as it is, and makes floats of it faster than NumPy.
        self._buffer = (c_double * self._count).from_buffer(self.values.data)
        self._rates = (c_double * self._count)()
        self._orders = {order: (c_int * self._count)(*[order] * self._count) for order in (1, 2, 3)}

    def read(self) -> list[float]:
        """Fetch the group from the FMU into `values`; return it as plain floats, fastest for scalar code."""
        instance = self._instance
        status = instance.get_real(instance.component, self._references, self._count, self._buffer)
        if status > OK_OR_WARNING:
            instance.check(status, "fmi2GetReal")
        return self._buffer[:]

    def write(self) -> None:
        """Send `values` to the FMU."""
        instance = self._instance
        status = instance.set_real(instance.component, self._references, self._count, self._buffer)
        if status > OK_OR_WARNING:
            instance.check(status, "fmi2SetReal")

    def read_derivatives(self, order: int) -> list[float]:
        """Time derivatives of that order (1 or 2) of the group, all of them outputs; n floats."""
        self._instance.call(
            "fmi2GetRealOutputDerivatives", self._references, self._count, self._order(order), self._rates
        )
        return self._rates[:]

    def write_derivatives(self, order: int, values: Sequence[float]) -> None:
        """Time derivatives of that order (1 to 3) of the group, all inputs, for the next step only."""
        self._rates[:] = list(values)
        self._instance.call(
            "fmi2SetRealInputDerivatives", self._references, self._count, self._order(order), self._rates
        )

    def _order(self, order: int) -> ctypes.Array[c_int]:
        if order not in self._orders:
            raise FmuError(f"derivative of order {order}: allowed are 1, 2 and, of inputs, 3")
        return self._orders[order]


# ---- handles ----


class FmuState:
    """The whole state of an instance, from `save_state`. The state is freed with the last reference to it."""

    def __init__(self, instance: Instance, address: int, time: float) -> None:
        self._instance, self._address, self._time = instance, address, time
        weakref.finalize(self, instance.free_state, address)


class Handle:
    """The common part of the handles for co-simulation and for model exchange."""

    _kind: type[FMU2Slave | FMU2Model]
    _use = ""

    def __init__(self, path: str | Path) -> None:
        """Loads the FMU at `path`. FmuError if that is no FMI 2.0 FMU, or none for this use or platform."""
        self.path = Path(path)
        self.description = _description(self.path)
        if getattr(self.description, self._use) is None:
            raise FmuError(f"{self.path} has no {self._use}: use one that has")
        self._variables = {variable.name: variable for variable in self.description.modelVariables}
        self._instance = Instance(self.path, self.description, self._kind)
        self._close = weakref.finalize(self, self._instance.free)
        self._fresh = True
        self.parameters: dict[str, Scalar] = {}  # those of the last start
        self.time = 0.0  # s

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free the instance, unload the library, delete the unpacked files. Any later call is an FmuError."""
        self._close()

    def abandon(self) -> None:
        """Instead of `close`, after fmi2Fatal: FMI allows no further call."""
        self._instance.abandon()

    def _begin(self, parameters: Mapping[str, Scalar], time: float, tolerance: float | None) -> None:
        """Up to initialization mode."""
        if not self._fresh:
            self._instance.call("fmi2Reset")
        self._fresh = False
        for name, value in parameters.items():
            self.set(name, value)
        self._instance.call("fmi2SetupExperiment", tolerance is not None, tolerance or 0.0, time, 0, 0.0)
        self._instance.call("fmi2EnterInitializationMode")
        self.parameters = dict(parameters)
        self.time = time

    # ---- variables ----

    @property
    def names(self) -> list[str]:
        """Names of all variables."""
        return list(self._variables)

    def variable(self, name: str, *types: str) -> ScalarVariable:
        """The description of a variable, which must be of one of `types` if any are given.
        UnknownVariableError with near matches if there is none of that name."""
        variable = self._variables.get(name)
        if variable is None:
            raise UnknownVariableError(_unknown(name, self.names, self.description.modelName))
        if types and variable.type not in types:
            raise FmuError(f"{name} is {variable.type}: allowed is {' or '.join(types)}")
        return variable

    def reals(self, *names: str) -> Reals:
        """A group of real variables that is read or written often."""
        return Reals(self._instance, names, [self.variable(name, "Real").valueReference for name in names])

    def get(self, name: str) -> Scalar:
        """One variable of any type, for use outside the loop: float, int, bool or str."""
        variable = self.variable(name)
        reference = byref(c_uint(variable.valueReference))
        if variable.type == "String":
            text = c_char_p()
            self._instance.call("fmi2GetString", reference, 1, byref(text))
            return (text.value or b"").decode()
        if variable.type == "Real":
            real = c_double()
            self._instance.call("fmi2GetReal", reference, 1, byref(real))
            return real.value
        whole = c_int()
        if variable.type == "Boolean":
            self._instance.call("fmi2GetBoolean", reference, 1, byref(whole))
            return bool(whole.value)
        self._instance.call("fmi2GetInteger", reference, 1, byref(whole))
        return whole.value

    def real(self, name: str) -> float:
        """One real variable."""
        self.variable(name, "Real")
        return float(self.get(name))

    def set(self, name: str, value: Scalar) -> None:
        """Set one variable of any type, for use outside the loop. FmuError if `value` does not suit the
        variable's type, or if the FMU refuses the value."""
        variable = self.variable(name)
        reference = byref(c_uint(variable.valueReference))
        if variable.type == "Real":
            content = c_double(_number(variable, value))
            self._instance.call("fmi2SetReal", reference, 1, byref(content))
        elif variable.type == "String":
            if not isinstance(value, str):
                raise FmuError(f"{name} = {value!r}: allowed is text")
            self._instance.call("fmi2SetString", reference, 1, byref(c_char_p(value.encode())))
        elif variable.type == "Boolean":
            if value not in (0, 1):
                raise FmuError(f"{name} = {value!r}: allowed are True and False")
            self._instance.call("fmi2SetBoolean", reference, 1, byref(c_int(bool(value))))
        else:
            number = _number(variable, value)
            if number != int(number):
                raise FmuError(f"{name} = {value!r}: allowed are whole numbers")
            self._instance.call("fmi2SetInteger", reference, 1, byref(c_int(int(number))))

    def jacobian(self, unknowns: Sequence[str], knowns: Sequence[str]) -> Array:
        """Partial derivatives now, shape (unknowns, knowns): of outputs and derivatives of states (`alpha`)
        by inputs, states (`theta`, `omega`) and tunable parameters."""
        columns = [self.directional_derivative(unknowns, [known], [1.0]) for known in knowns]
        return np.reshape(columns, (len(knowns), len(unknowns))).T

    def directional_derivative(
        self, unknowns: Sequence[str], knowns: Sequence[str], seed: ArrayLike
    ) -> Array:
        """Partial derivatives of `unknowns` by `knowns` times `seed`, shape (knowns,); shape (unknowns,)."""
        direction = np.ascontiguousarray(seed, dtype=float)
        if direction.shape != (len(knowns),):
            raise FmuError(f"seed has shape {direction.shape}: allowed is ({len(knowns)},), one per known")
        product = np.empty(len(unknowns))
        pointer = ctypes.POINTER(c_double)
        self._instance.call(
            "fmi2GetDirectionalDerivative",
            self._references(unknowns),
            len(unknowns),
            self._references(knowns),
            len(knowns),
            direction.ctypes.data_as(pointer),
            product.ctypes.data_as(pointer),
        )
        return product

    def _references(self, names: Sequence[str]) -> ctypes.Array[c_uint]:
        return (c_uint * len(names))(*(self.variable(name, "Real").valueReference for name in names))

    # ---- states ----

    def save_state(self) -> FmuState:
        """The whole state of the instance now."""
        address = c_void_p()
        self._instance.call("fmi2GetFMUstate", byref(address))
        if address.value is None:
            raise FmuError("fmi2GetFMUstate gave no state")
        self._instance.states.add(address.value)
        return FmuState(self._instance, address.value, self.time)

    def restore_state(self, state: FmuState) -> None:
        """Go back to a saved state of this instance, with its `time`. FmuError for a state of another one."""
        if state._instance is not self._instance:
            raise FmuError("this state is of another instance: allowed are those that this one gave")
        self._instance.call("fmi2SetFMUstate", state._address)
        self.time = state._time


class Fmu(Handle):
    """One instance for co-simulation. `start` begins a run, any number of times; `step` advances `time` [s].
    Freed by `close`, by leaving a with statement, or with the last reference to it."""

    _kind, _use = FMU2Slave, "coSimulation"

    def start(
        self,
        parameters: Mapping[str, Scalar] | None = None,
        time: float = 0.0,
        tolerance: float | None = None,
    ) -> None:
        """Begin a run at `time` [s] with these start values of parameters and inputs. All other variables get
        their default start values. `tolerance`: relative, of the FMU's integrator; None: the FMU's default,
        1e-9. FmuError if the FMU refuses a value or the combination of values."""
        self._begin(parameters or {}, time, tolerance)
        self._instance.call("fmi2ExitInitializationMode")

    def step(self, size: float) -> None:
        """Advance by `size` [s] > 0 with the inputs as they were last written."""
        instance = self._instance
        status = instance.do_step(instance.component, self.time, size, 1)
        if status > OK_OR_WARNING:
            instance.check(status, "fmi2DoStep")
        self.time += size


class Preparation:
    """A run of `fmu` in initialization mode, which can begin many times from different start values. The FMU
    keeps its precomputed geometry, so a beginning costs about as much as a step.

    `reals` are the start values, parameters or inputs, that differ between the runs."""

    def __init__(self, fmu: Fmu, parameters: Mapping[str, Scalar], reals: Sequence[str]) -> None:
        self.fmu = fmu
        fmu._begin(parameters, 0.0, None)
        self.start_values = fmu.reals(*reals)
        self._state = fmu.save_state()

    def rewind(self, values: ArrayLike) -> None:
        """Return to initialization mode, with these values of `reals`, shape (n,). Variables that need no
        step can be read there."""
        self.fmu.restore_state(self._state)
        self.start_values.values[:] = values
        self.start_values.write()

    def begin(self, values: ArrayLike) -> None:
        """Begin a run with these values of `reals`, shape (n,)."""
        self.rewind(values)
        self.fmu._instance.call("fmi2ExitInitializationMode")


class ContinuousFmu(Handle):
    """One instance for model exchange: the caller integrates the states `theta` [rad] and `omega` [rad/s].

    `set_states_and_mode` sets the states and lets the FMU decide its mode there. After that `derivatives` can
    be read. `set_states` sets other states in the same mode, as solvers do between events."""

    _kind, _use = FMU2Model, "modelExchange"

    def start(self, parameters: Mapping[str, Scalar] | None = None, time: float = 0.0) -> None:
        """Begin at `time` [s] with these start values, in continuous-time mode.
        FmuError if the FMU refuses a value, or has no inertia: then speed is no state."""
        self._begin(parameters or {}, time, None)
        self._instance.call("fmi2ExitInitializationMode")
        self._settle()
        count = int(self.description.numberOfContinuousStates)
        self._states, self._rates = (c_double * count)(), (c_double * count)()
        self._indicators = (c_double * int(self.description.numberOfEventIndicators))()

    def _settle(self) -> None:
        """Event iteration, then continuous-time mode."""
        info = fmi2EventInfo(newDiscreteStatesNeeded=1)
        while info.newDiscreteStatesNeeded:
            self._instance.call("fmi2NewDiscreteStates", byref(info))
        self._instance.call("fmi2EnterContinuousTimeMode")

    def set_states(self, states: Sequence[float]) -> None:
        """Set theta [rad] and omega [rad/s], shape (2,), in the present mode."""
        self._states[:] = list(states)
        self._instance.call("fmi2SetContinuousStates", self._states, len(self._states))

    def set_states_and_mode(self, states: Sequence[float]) -> None:
        """Set theta [rad] and omega [rad/s], shape (2,), and carry out the mode changes due there."""
        self.set_states(states)
        self.enter_event_mode()

    def enter_event_mode(self) -> None:
        """Carry out the mode changes that are due now; continuous-time mode again after that."""
        self._instance.call("fmi2EnterEventMode")
        self._settle()

    def states(self) -> list[float]:
        """theta [rad], omega [rad/s]."""
        self._instance.call("fmi2GetContinuousStates", self._states, len(self._states))
        return self._states[:]

    def derivatives(self) -> list[float]:
        """Derivatives of the states by time: rad/s, rad/s2."""
        self._instance.call("fmi2GetDerivatives", self._rates, len(self._rates))
        return self._rates[:]

    def indicators(self) -> list[float]:
        """Event indicators: where one changes its sign, the mode may change."""
        self._instance.call("fmi2GetEventIndicators", self._indicators, len(self._indicators))
        return self._indicators[:]

    def set_time(self, time: float) -> None:
        """Set the time [s] at which the next values are computed."""
        self._instance.call("fmi2SetTime", time)
        self.time = time


# ---- error messages ----


def _description(path: Path) -> ModelDescription:
    """modelDescription.xml of an FMI 2.0 FMU. FmuError if there is none."""
    if not path.is_file():
        raise FmuError(f"there is no file {path}: give the path of an FMU, which ./build.sh makes in build/")
    try:
        description = fmpy.read_model_description(path)
    except (OSError, KeyError, zipfile.BadZipFile) as error:
        raise FmuError(f"{path} is no FMU, a ZIP archive with a modelDescription.xml: {error}") from error
    except Exception as error:  # FMPy has none of its own for a description that is not valid
        raise FmuError(f"{path} has no valid modelDescription.xml: {error}") from error
    if description.fmiVersion != "2.0":
        raise FmuError(f"{path} is of FMI {description.fmiVersion}: allowed is 2.0")
    return description


def _unknown(name: str, names: list[str], model: str) -> str:
    """A message with names near the unknown one."""
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    group = name.split(".")[0]
    listed = [other for other in names if other.split(".")[0] == group] if "." in name else []
    listed = listed or [other for other in names if "." not in other]
    more = f" and {len(names) - NAMES_LISTED} more" if len(listed) > NAMES_LISTED else ""
    guess = f"did you mean {', '.join(near)}? " if near else ""
    return f"{model} has no variable {name!r}: {guess}it has {', '.join(listed[:NAMES_LISTED])}{more}"


def _number(variable: ScalarVariable, value: Any) -> float:  # noqa: ANN401
    """`value` as a float. FmuError if it is no number."""
    try:
        if isinstance(value, str):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise FmuError(f"{variable.name} = {value!r}: allowed is a number ({variable.type})") from None
