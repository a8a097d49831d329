"""Runs of a fleet with the Jacobian of every step, and the chain rule backwards through them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NoReturn, Self

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import Array, positive_number, real_array
from dualcam.common.moved import also_called
from dualcam.common.process_bound import ProcessBound, ProcessLock
from dualcam.errors import FmuError, UnknownVariableError
from dualcam.fleet import Fleet
from dualcam.fleet.values import FleetValue
from dualcam.fmi.handle import names_of
from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import ModelDescription, read_model_description

STATES, INPUTS = ("theta", "omega"), ("tau", "F_ext")
INITIAL = ("initial.theta", "initial.omega")


@dataclass(frozen=True, eq=False)
class Gradient:
    """The gradient of a loss, of the shapes of the arguments of the run.

    `start`: by theta [1/rad] and omega [s/rad] at the start, shape (count, 2). `inputs`: by the inputs of
    each step, shape (count, steps, n). `parameters`: by the parameters, shape (count, k).
    """

    start: Array
    inputs: Array
    parameters: Array

    def __getattr__(self, name: str) -> NoReturn:
        near = {"u": ": inputs is the gradient by u", "p": ": parameters is the gradient by p"}
        raise AttributeError(f"a Gradient has no {name}{near.get(name, '')}")


@dataclass(frozen=True, eq=False)
class Rollout:
    """A run of all instances, with the Jacobian of each step.

    `states`: theta [rad] and omega [rad/s] after each step, shape (count, steps, 2). `jacobians`: derivatives
    of theta and omega after a step by theta and omega before it, by the n inputs of the step, and by the k
    parameters, shape (count, steps, 2, 2 + n + k). `input_count`: n.
    """

    states: Array
    jacobians: Array
    input_count: int

    def gradient(self, by_states: ArrayLike) -> Gradient:
        """The gradient of a loss by start, inputs and parameters, by the chain rule from the last step to the
        first.

        `by_states`: the derivative of the loss by each element of `states`, shape (count, steps, 2).

        Examples
        --------
        >>> import numpy as np
        >>> from dualcam.gradient import DifferentiableFleet
        >>> with DifferentiableFleet("forward", 1, 1e-3, parameters=["cam1.friction"]) as fleet:
        ...     run = fleet.rollout([[0.4, 0.0]], np.full((1, 20, 1), 5.0), [[0.14]])
        >>> by_states = np.zeros_like(run.states)
        >>> by_states[0, -1, 0] = 1.0  # the loss is theta at the end
        >>> run.gradient(by_states).parameters.round(3).tolist()  # rad per 1
        [[-0.32]]
        """
        given = real_array(by_states, "by_states", FmuError, self.states.shape)
        count, steps, _ = given.shape
        first = 2 + self.input_count
        adjoint = np.zeros((count, 2))
        inputs = np.empty((count, steps, self.input_count))
        parameters = np.zeros((count, self.jacobians.shape[3] - first))
        for step in reversed(range(steps)):
            pulled = np.einsum("ci,cij->cj", adjoint + given[:, step], self.jacobians[:, step])
            adjoint, inputs[:, step] = pulled[:, :2], pulled[:, 2:first]
            parameters += pulled[:, first:]
        return Gradient(adjoint, inputs, parameters)


class DifferentiableFleet(ProcessBound):
    """Runs of many instances of the forward FMU, with the Jacobian of every step.

    The Jacobians are analytic: `step.dtheta_d...` and `step.domega_d...` of the FMU. They go through stick
    and slip, through mode changes, bounces and changes of flanks inside a step.

    A run depends on its arguments alone: each call begins a new run.

    Parameters
    ----------
    fmu : "forward", or the path of an FMU of FMI 2.0 that `export_fmu` has made.
    count : Number of instances, > 0.
    step : Length of each step [s], > 0.
    inputs : Of "tau" and "F_ext". Inputs are constant over a step.
    parameters : Tunable parameters by which a run is differentiated.
    values : Start values of other parameters: one value, or an array of shape (count,). Default: the FMU's.
    threads : Threads that share the instances, 1 to 256.
    tolerance : Relative tolerance of the FMU's integrator. None: 1e-9.

    Raises
    ------
    UnknownVariableError : The FMU has no derivatives by an input or a parameter.
    FmuError : Another argument is wrong.

    See Also
    --------
    dualcam.gradient.jax_rollout : The same runs in JAX.

    Notes
    -----
    A loss has no derivative where a stop is touched without speed (grazing), where the torque of a step is
    exactly on an edge of the stick band at rest, and where an event lies exactly at the end of a step. The
    derivative of one side comes out: that of the run as it was made. A torque on the edge counts as inside
    the band, an event at the end of a step as past. Near grazing a derivative is as large as 1 over the speed
    at the stop.

    At rest inside the stick band the angle does not depend on the torque: the derivative is 0. All
    derivatives of a step are 0 if the contacts wedge in it after they have moved, and those by a
    `friction_peak` of 1.
    """

    _instead = "make a new one there, from the same arguments"

    @also_called(h="step")
    def __init__(
        self,
        fmu: str | Path,
        count: int,
        step: float,
        inputs: Sequence[str] = ("tau",),
        parameters: Sequence[str] = (),
        values: Mapping[str, FleetValue] | None = None,
        threads: int = 1,
        *,
        tolerance: float | None = None,
    ) -> None:
        self._step = positive_number(step, "step", "a finite number > 0, in s")
        self.inputs = tuple(names_of(inputs, "inputs"))
        if isinstance(parameters, Mapping):
            raise FmuError(
                f"parameters = {parameters!r}: allowed is a list of names, of what a run is differentiated"
                " by; p of rollout has their values, and values={...} sets those of other parameters"
            )
        self.parameters = tuple(names_of(parameters, "parameters"))
        knowns = (*STATES, *self.inputs, *self.parameters)
        description = read_model_description(source_path(fmu))
        _require_derivatives(description, self.inputs, self.parameters)
        derivatives = [f"step.d{state}_d{known}" for state in STATES for known in knowns]
        others = dict(values or {})
        _refuse_twice(self.parameters, others)
        self._shape = (len(STATES), len(knowns))
        self._lock = ProcessLock()  # JAX calls from threads of its own
        others[INITIAL[0]] = _between_stops(description, others)

        def fleet(outputs: Sequence[str]) -> Fleet:
            return Fleet(fmu, count, self.inputs, outputs, others, threads, tolerance=tolerance)

        self._fleet = fleet([*STATES, *derivatives])
        self._new_plain_fleet = partial(fleet, STATES)
        self._plain_fleet: Fleet | None = None

    def __enter__(self) -> Self:
        self._fleet.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Differentiable {self._fleet!r}>"

    @property
    def count(self) -> int:
        """Number of instances."""
        return self._fleet.count

    def close(self) -> None:
        """Free all instances. Any later run is an FmuError."""
        self._fleet.close()
        if self._plain_fleet is not None:
            self._plain_fleet.close()

    def rollout(self, start: ArrayLike, u: ArrayLike, p: ArrayLike | None = None) -> Rollout:
        """A new run of all instances: the states after each step, and the Jacobians.

        `start`: theta [rad] and omega [rad/s] at the start, shape (count, 2). Without inertia omega is not
        used. `u`: inputs in the FMU's units, constant over each step, shape (count, steps, n). `p`: the
        parameters of each instance, shape (count, k). May be left out where there are none. FleetError: the
        FMU refuses a start value or a step of an instance. FmuError: a wrong shape or type.

        Examples
        --------
        >>> import numpy as np
        >>> from dualcam.gradient import DifferentiableFleet
        >>> with DifferentiableFleet("forward", 2, 1e-3) as fleet:
        ...     run = fleet.rollout([[0.4, 0.0], [0.4, 2.0]], np.full((2, 50, 1), 3.0))
        >>> run.states[:, -1].round(4).tolist()  # rad, rad/s: the first instance sticks
        [[0.4, 0.0], [0.4114, 0.0]]
        """
        found = self._run(self._fleet, start, u, p)
        jacobians = found[:, :, 2:].reshape(*found.shape[:2], *self._shape)
        return Rollout(np.ascontiguousarray(found[:, :, :2]), jacobians, len(self.inputs))

    def states(self, start: ArrayLike, u: ArrayLike, p: ArrayLike | None = None) -> Array:
        """The states of `rollout`, shape (count, steps, 2), without Jacobians.

        Theta [rad] and omega [rad/s] after each step are in each bit as in `rollout`. The first call makes a
        second set of instances. `start`, `u`, `p` and the errors: as for `rollout`.

        Examples
        --------
        >>> import numpy as np
        >>> from dualcam.gradient import DifferentiableFleet
        >>> with DifferentiableFleet("forward", 1, 1e-3) as fleet:
        ...     fleet.states([[0.4, 2.0]], np.full((1, 50, 1), 3.0))[:, -1].round(4).tolist()  # rad, rad/s
        [[0.4114, 0.0]]
        """
        with self._lock:
            if self._plain_fleet is None:
                self._fleet.__enter__()  # an error where the fleet is closed
                self._plain_fleet = self._new_plain_fleet()
        return self._run(self._plain_fleet, start, u, p)

    def _run(self, fleet: Fleet, start: ArrayLike, u: ArrayLike, p: ArrayLike | None) -> Array:
        """The outputs of a new run of `fleet`."""
        if p is None and self.parameters:
            raise FmuError(
                f"p is missing: allowed is an array of shape {(self.count, len(self.parameters))} with"
                f" {', '.join(self.parameters)} of each instance"
            )
        columns = np.empty((self.count, 0)) if p is None else p
        first = real_array(start, "start", FmuError, (self.count, 2))
        tuned = real_array(columns, "p", FmuError, (self.count, len(self.parameters)))
        values: dict[str, FleetValue] = dict(zip(INITIAL, first.T, strict=True))
        values |= dict(zip(self.parameters, tuned.T, strict=True))
        with self._lock:
            fleet.reset(parameters=values)
            return fleet.rollout(u, self._step)


def _require_derivatives(
    description: ModelDescription, inputs: Sequence[str], parameters: Sequence[str]
) -> None:
    """UnknownVariableError where a step has no derivative by one of these."""
    prefix = f"step.d{STATES[0]}_d"
    variables = [variable.name for variable in description.variables]
    known = [name.removeprefix(prefix) for name in variables if name.startswith(prefix)]
    tunable = [name for name in known if name not in (*STATES, *INPUTS)]
    for names, allowed in ((inputs, [name for name in INPUTS if name in known]), (parameters, tunable)):
        for name in names:
            if name not in allowed:
                raise UnknownVariableError(
                    f"{description.model_name} has no derivatives of a step by {name!r}: allowed here are "
                    f"{', '.join(allowed) or 'none'}"
                )


def _between_stops(description: ModelDescription, values: Mapping[str, FleetValue]) -> FleetValue:
    """An angle [rad] that every instance allows."""
    starts = {variable.name: variable.start for variable in description.variables}
    lower, upper = (
        np.asarray(values.get(name, starts[name]), float) for name in ("stop.lower", "stop.upper")
    )
    return 0.5 * (lower + upper)


def _refuse_twice(parameters: Sequence[str], values: Mapping[str, FleetValue]) -> None:
    taken = {*parameters, *INITIAL}.intersection(values)
    if taken:
        raise FmuError(
            f"values has {', '.join(sorted(taken))}: allowed are other parameters; these are arguments of "
            "rollout"
        )
