"""Thousands of instances of one FMU, stepped by one call."""

import math
import weakref
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from ctypes import addressof, byref
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import Array, given_once, number_of, positive_number, real_array
from dualcam.common.process_bound import ProcessBound
from dualcam.common.unit_guards import warn_units
from dualcam.errors import FleetError, FmuError, UnknownVariableError
from dualcam.fleet.core import Core, FleetState, NotFiniteError
from dualcam.fleet.native import GETTERS, Ports, address, pointer_to
from dualcam.fleet.values import (
    NUMBERS,
    FleetValue,
    Layout,
    chosen_instances,
    output_buffer,
    steps_of,
    whole_number,
)
from dualcam.fmi.handle import OWN_NAMES, names_of, unknown_variable
from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import Variable, read_model_description

MOST_THREADS = 256


class Fleet(ProcessBound):
    """Many instances of one FMU of FMI 2.0 for co-simulation. A run of all instances has begun when the fleet
    is made, and again after `reset`.

    Each instance moves bit for bit as if the instance were alone. Values that the FMU refuses in `set` or
    `reset` change nothing. An instance that fails in a step makes that call an error, and is left alone from
    then on: its inputs are not read, its outputs are NaN, and the others go on. `reset` and `restore` bring a
    failed instance back.

    A forked child process has a copy of the fleet, which works there with one thread.

    Parameters
    ----------
    fmu : "forward" or "inverse" for this package's own FMUs, or the path of any FMU of FMI 2.0.
    count : Number of instances, > 0.
    inputs : Names of the n real variables that are set before each step.
    outputs : Names of the m real variables that are read after each step.
    parameters : mapping of str to value, optional
        Start values of parameters and inputs, in the FMU's units: one value for all instances, or an array of
        shape (count,). Default: the FMU's.
    threads : int
        Threads that share the instances of a call, 1 to 256. An FMU whose instances are not independent
        allows one thread only.
    time : Start time [s].
    tolerance : Relative tolerance of the FMU's integrator. None: the FMU's default, here 1e-9.

    Raises
    ------
    FleetError
        The FMU refuses a start value of an instance.
    FmuError
        An argument is wrong (UnknownVariableError: a name), or the FMU has no co-simulation of FMI 2.0.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam import Fleet
    >>> stiffness = np.linspace(40e3, 60e3, 5)  # N/m
    >>> parameters = {"spring.stiffness": stiffness, "inertia.shaft": 0.01}
    >>> torques = np.full((5, 1), 5.0)  # N.m
    >>> with Fleet("forward", 5, parameters=parameters) as fleet:
    ...     for _ in range(50):
    ...         motion = fleet.step(torques, 1e-3)  # s
    ...     motion[:, 0].round(4).tolist()  # rad
    [0.4848, 0.478, 0.4713, 0.4646, 0.4581]
    """

    _instead = "make a new one there, from the same arguments"

    def __init__(
        self,
        fmu: str | Path,
        count: int,
        inputs: Sequence[str] = ("tau",),
        outputs: Sequence[str] = ("theta", "omega"),
        parameters: Mapping[str, FleetValue] | None = None,
        threads: int = 1,
        *,
        time: float = 0.0,
        tolerance: float | None = None,
    ) -> None:
        self.path = source_path(fmu)
        self.count = whole_number(count, "count", "a whole number > 0", math.inf)
        allowed = f"a whole number from 1 to {MOST_THREADS}"
        self.threads = whole_number(threads, "threads", allowed, MOST_THREADS)
        self.description = read_model_description(self.path)
        if self.description.fmi_major != 2:
            raise FmuError(f"{self.path} is of FMI {self.description.fmi_version}: allowed is FMI 2.0")
        interface = self.description.co_simulation
        if interface is not None and interface.allows_one_instance and count > 1:
            raise FmuError(f"count = {count}: {self.path} allows one instance in a process")
        self._variables = {variable.name: variable for variable in self.description.variables}
        self.inputs = tuple(names_of(inputs, "inputs"))
        self.outputs = tuple(names_of(outputs, "outputs"))
        self._references = [self._real_references(names) for names in (self.inputs, self.outputs)]
        sizes = (len(self.inputs), len(self.outputs))
        self._ports = Ports(*sizes, *(address(references) for references in self._references))
        self._ports_address = addressof(self._ports)
        start_time = number_of(time, "time")
        allowed = "a finite number > 0, or None"
        relative = 0.0 if tolerance is None else positive_number(tolerance, "tolerance", allowed)
        parameters = {} if parameters is None else parameters
        layout = self._layout(parameters)  # refuses wrong values before an instance is made
        self._warn_units(parameters)
        self._parameters: dict[str, FleetValue] = dict(parameters)
        self._core = Core(self.path, self.description, self.count, self.threads, start_time, relative)
        self._close = weakref.finalize(self, self._core.close)
        try:
            self._core.call("fleet_start", byref(layout.struct), None)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        self._core.times()  # an error where the fleet is closed
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __len__(self) -> int:
        return self.count

    def __repr__(self) -> str:
        state = "" if self._core.is_open else ", closed"
        return f"<Fleet of {self.count} {self.description.model_name}{state}>"

    def close(self) -> None:
        """Free all instances and the unpacked files. Any later call is an FmuError."""
        self._close()

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which instances have failed since their last `reset` or `restore`, shape (count,)."""
        return self._core.failed()

    @property
    def times(self) -> Array:
        """Present time of each instance [s], shape (count,)."""
        return self._core.times()

    # ---- steps ----

    def step(
        self, u: ArrayLike, step: float | None = None, out: Array | None = None, *, h: float | None = None
    ) -> Array:
        """One step of all instances.

        Parameters
        ----------
        u : array_like, shape (count, n)
            Inputs in the FMU's units, constant over the step. No copy is made of a C-contiguous array of
            float64. The rows of instances that have failed are not read.
        step, h : Length of the step [s], > 0, by either name.
        out : Array of float64 for the outputs, shape (count, m). Default: a new one.

        Returns
        -------
        ndarray, shape (count, m)
            Outputs after the step.

        Raises
        ------
        FleetError
            An instance failed in this call. The others made the step; `outputs` of the error has their rows.
            Or all instances had failed before.
        FmuError
            A wrong shape or type, or a value that is not finite: no instance made the step.
        """
        return self._roll(u, (), step, h, out)

    def rollout(
        self, u: ArrayLike, step: float | None = None, out: Array | None = None, *, h: float | None = None
    ) -> Array:
        """Many steps of all instances, with a history of inputs for each.

        Parameters
        ----------
        u : Inputs in the FMU's units, constant over each step, shape (count, steps, n).
        step, h : Length of each step [s], > 0, by either name.
        out : Array of float64 for the outputs, shape (count, steps, m). Default: a new one.

        Returns
        -------
        ndarray, shape (count, steps, m)
            Outputs after each step. Errors are those of `step`: in `outputs` of a FleetError the rows of a
            failed instance are NaN from the step on in which it failed.

        Examples
        --------
        >>> import numpy as np
        >>> from dualcam import Fleet
        >>> torque = np.full((2, 100, 1), 5.0)  # N.m
        >>> torque[1, 50:] = 0.0
        >>> with Fleet("forward", 2, parameters={"inertia.shaft": 0.01}) as fleet:
        ...     fleet.rollout(torque, 1e-3)[:, -1].round(3).tolist()  # rad, rad/s
        [[1.206, 9.05], [0.7, -5.543]]
        """
        return self._roll(u, (steps_of(u),), step, h, out)

    def _roll(
        self, u: ArrayLike, steps: tuple[int, ...], step: float | None, h: float | None, out: Array | None
    ) -> Array:
        """Steps of all instances. `steps`: the shape of one column of inputs of one instance."""
        shape = (self.count, *steps, len(self.inputs))
        inputs = np.ascontiguousarray(real_array(u, "u", FmuError, shape))
        if h is not None:
            _, step = given_once(step=step, h=h)
        if type(step) is not float or not 0.0 < step < math.inf:
            step = positive_number(step, "step", "a finite number > 0, in s")
        wanted = (self.count, *steps, len(self.outputs))
        outputs = np.empty(wanted) if out is None else output_buffer(out, wanted)
        buffers = pointer_to(inputs), math.prod(steps), step, pointer_to(outputs)
        try:
            self._core.call("fleet_roll", self._ports_address, *buffers)
        except FleetError as error:
            error.outputs = outputs
            raise
        except NotFiniteError:
            raise FmuError(self._not_finite(inputs)) from None
        return outputs

    def _not_finite(self, u: Array) -> str:
        wrong = ~np.isfinite(u)
        wrong[self.failed] = False
        instance, *step, column = np.argwhere(wrong)[0].tolist()
        at = f" in step {step[0]}" if step else ""
        return (
            f"{self.inputs[column]} of instance {instance}{at} = {u[instance, *step, column]}: allowed are"
            " finite numbers; no instance was stepped"
        )

    def reset(
        self, instances: ArrayLike | None = None, parameters: Mapping[str, FleetValue] | None = None
    ) -> None:
        """Begin a new run of some instances, at the start time.

        FleetError where the FMU refuses a start value of an instance: no instance was reset. Where the FMU
        cannot save its state, that instance fails, and the others have begun a new run. FmuError for a wrong
        argument: no instance was reset.

        Parameters
        ----------
        instances : Numbers of the instances, or booleans of shape (count,). Default: all.
        parameters : mapping of str to value, optional
            Start values that replace earlier ones of these instances: one value, or shape (count,).
        """
        chosen = chosen_instances(instances, self.count)
        merged = self._merged(parameters or {}, chosen)
        layout = self._layout(merged)
        self._warn_units(parameters or {})
        self._change("fleet_start", layout, chosen)
        self._parameters = merged

    def get(self, name: str) -> NDArray[Any]:
        """The value of one variable in each instance.

        Parameters
        ----------
        name : A real, integer or boolean variable.

        Returns
        -------
        ndarray, shape (count,)
            In the variable's unit. Instances that have failed: NaN, or 0 where the variable is not real.
        """
        variable = self._variable(name)
        if variable.kind not in GETTERS:
            raise FmuError(f"{name} is {variable.type}: allowed are Real, Integer and Boolean")
        kind = NUMBERS[variable.kind]
        values = np.full(self.count, math.nan if variable.kind == "real" else 0, kind)
        self._core.call(GETTERS[variable.kind], variable.value_reference, address(values))
        return values.astype(bool) if variable.kind == "boolean" else values

    def set(self, name: str, values: FleetValue, instances: ArrayLike | None = None) -> None:
        """Set one variable in some instances: inputs and tunable parameters.

        FleetError where the FMU refuses the value of an instance: no instance has a new value. Where the FMU
        cannot save its state, that instance fails, and the others have their values.

        Parameters
        ----------
        name : Name of the variable.
        values : One value, or an array of shape (count,), in the variable's unit.
        instances : Numbers of the instances, or booleans of shape (count,). Default: all.
        """
        layout = Layout([self._variable(name)], {name: values}, self.count)
        self._change("fleet_set", layout, chosen_instances(instances, self.count))

    def _change(self, function: str, layout: Layout, chosen: NDArray[np.uint8]) -> None:
        """Give values to the chosen instances. Where one refuses them, all go back to their states before."""
        before = self.save(chosen.astype(bool)) if self._can_save_state else None
        try:
            self._core.call(function, byref(layout.struct), address(chosen))
        except FleetError as error:
            if before is not None:
                with suppress(FleetError):  # an instance that had failed before has no state: it fails again
                    self._restore(before, chosen)
                error.args = (f"{error}; no instance has changed",)
            raise

    def save(self, instances: ArrayLike | None = None) -> FleetState:
        """The whole state of some instances now. FmuError where the FMU cannot save its state.

        Parameters
        ----------
        instances : Numbers of the instances, or booleans of shape (count,). Default: all.

        Returns
        -------
        FleetState
            For `restore` of this fleet.
        """
        if not self._can_save_state:
            raise FmuError(f"{self.path} cannot save its state: canGetAndSetFMUstate is not set")
        chosen = chosen_instances(instances, self.count)
        addresses, times = np.zeros(self.count, np.uintp), np.zeros(self.count)
        state = FleetState(self._core, chosen.astype(bool), addresses, times)
        self._core.call("fleet_save", address(chosen), address(addresses), address(times))
        return state

    def restore(self, state: FleetState, instances: ArrayLike | None = None) -> None:
        """Go back to saved states, with their times. FmuError for those of another fleet, and for an instance
        that was not saved.

        Parameters
        ----------
        state : From `save` of this fleet.
        instances : Which of the saved instances, as in `save`. Default: all of them.
        """
        if not isinstance(state, FleetState) or state._core is not self._core:
            raise FmuError(f"restore({state!r}): allowed is a FleetState from save of this fleet")
        chosen = chosen_instances(state.instances if instances is None else instances, self.count)
        missing = np.flatnonzero(chosen.astype(bool) & ~state.instances)
        if missing.size:
            raise FmuError(f"the state of instance {missing[0]} was not saved: save had other instances")
        self._restore(state, chosen)

    def _restore(self, state: FleetState, chosen: NDArray[np.uint8]) -> None:
        self._core.call("fleet_restore", address(chosen), address(state._addresses), address(state._times))

    @property
    def _can_save_state(self) -> bool:
        interface = self.description.co_simulation
        return interface is not None and interface.can_save_state

    def _variable(self, name: str) -> Variable:
        variable = self._variables.get(name) if isinstance(name, str) else None
        if variable is None:
            text = unknown_variable(str(name), list(self._variables), self.description.model_name)
            raise UnknownVariableError(text)
        return variable

    def _real_references(self, names: Iterable[str]) -> NDArray[np.uintc]:
        variables = [self._variable(name) for name in names]
        for variable in variables:
            if variable.kind != "real":
                raise FmuError(f"{variable.name} is {variable.type}: allowed is Real")
        return np.array([variable.value_reference for variable in variables], np.uintc)

    def _layout(self, parameters: Mapping[str, FleetValue]) -> Layout:
        if not (isinstance(parameters, Mapping) and all(isinstance(name, str) for name in parameters)):
            raise FmuError(f"parameters = {parameters!r}: allowed is a dict of names and values, or nothing")
        return Layout([self._variable(name) for name in parameters], parameters, self.count)

    def _merged(self, new: Mapping[str, FleetValue], chosen: NDArray[np.uint8]) -> dict[str, FleetValue]:
        """The start values of all instances, where `new` holds for the chosen ones."""
        self._layout(new)
        if chosen.all():
            return {**self._parameters, **new}
        merged = dict(self._parameters)
        for name, values in new.items():
            kept = self._parameters.get(name, self._variable(name).start)
            merged[name] = np.where(chosen.astype(bool), np.array(values), np.array(kept))
        return merged

    def _warn_units(self, parameters: Mapping[str, FleetValue]) -> None:
        if not set(self._variables) >= OWN_NAMES:
            return
        for name, values in parameters.items():
            if self._variable(name).kind == "real":
                for extreme in {float(np.min(values)), float(np.max(values))}:
                    warn_units({name: (name, extreme)}, stacklevel=4)
