"""The forward FMU as a nonlinear system of python-control."""

from collections.abc import Callable, Mapping
from typing import Any

import control
import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import positive_number, real_array
from dualcam.control.forward import (
    INPUTS,
    OUTPUTS,
    STATES,
    CamAtState,
    Names,
    Source,
    name_list,
    open_forward,
    sampling_period,
    selected_names,
)
from dualcam.control.linear import linearize
from dualcam.errors import FmuError
from dualcam.fmi.fmu import Fmu, RepeatedStart
from dualcam.fmi.handle import Handle
from dualcam.fmi.model_description import Scalar
from dualcam.fmi.reals import Array

REST_SPEED = 1e-3  # rad/s: 1000 times the absolute tolerance of SciPy's solvers, 1e-4 of a usual speed
REST_TIME = 1e-3  # s: steps of explicit solvers at rest are then some ms long
STOP_TIME = 1e-5  # s: an impact lasts about ten of these, a few dozen steps of a solver
OVERSHOOT = 1e-3  # of the room between the stops: where a solver ended a run, another one may begin

ACCUMULATED = ("energy.", "peak.", "events")  # beginnings of names of variables that sum up over steps


def to_nonlinear_io_system(
    source: Source,
    inputs: Names = None,
    outputs: Names = None,
    parameters: Mapping[str, Scalar] | None = None,
    period: float | None = None,
    *,
    rest_speed: float = REST_SPEED,
    rest_time: float = REST_TIME,
    name: str = "cam",
    dt: float | None = None,
) -> control.NonlinearIOSystem:
    """The cam as a plant for input_output_response, interconnect, linearize and the rest of python-control.

    States are theta [rad] and omega [rad/s], in both kinds of system. Their initial values belong to the
    simulation: `initial.theta` and `initial.omega` have no effect.

    Parameters
    ----------
    source
        "forward", the path of a forward FMU (FMI 2.0 or 3.0), or a handle (then with the parameters of its
        last start).
    inputs
        Out of tau [N.m], F_ext [N]: a list, or one text with commas. None: both. An input left out keeps its
        value of `parameters`, or 0.
    outputs
        None: theta, omega, z [m], v [m/s]. Else any outputs or locals of the FMU that follow from states and
        inputs (`mode`, `torque_load`, `spring.force`, ...), but not the accounts `energy.*`, `peak.*`.
        python-control allows no dot in a name: `spring.force` becomes `spring_force`.
    parameters : Start values of the FMU.
    period
        Period [s] of a sampled system, from co-simulation, with inputs held over the period. Prefer this
        kind: the FMU locates stick, slip, stops and bounces within a period, to its accuracy. None: a
        continuous system, from model exchange, for solvers without event location; see Notes.
    rest_speed : Speed [rad/s], > 0, below which the continuous system can rest; see Notes.
    rest_time : Time constant [s], > 0, with which the speed decays at rest; see Notes.
    name : Name of the system.
    dt : The same as `period`, by python-control's name.

    Returns
    -------
    With named signals.

    Raises
    ------
    FmuError
        An unknown name, a bad period, a file that is no such FMU, or a value that the FMU refuses (with the
        FMU's message).

    See Also
    --------
    linearize : The linear model about an operating point.

    Notes
    -----
    The state is theta and omega alone. The FMU's mode is decided anew at each call: slip by the sign of
    omega, and at omega = 0 slip or stick by the torque. There is no other memory, with one exception. Where a
    contact locks (lead angle below atan(friction)) several slip modes can be consistent, and a motion in the
    FMU keeps its mode. The decision here prefers both supporting flanks.

    Without inertia (sampled only) omega is no state: the output omega is the speed at the end of the last
    period, and its initial value has no effect.

    The continuous system. A zero of the speed, or a stop, is an event. The solvers of python-control do not
    locate events. Their error estimate sees a right-hand side that jumps, so events are smeared by the
    solver's tolerance. Give input_output_response a `max_step` in `solve_ivp_kwargs` no longer than the
    shortest motion of interest, and tolerances as small as the result needs. A solver never hits a speed of
    exactly zero, so rest has a width: below `rest_speed` the FMU decides by torque, as at omega = 0. If the
    cam sticks, omega decays with the time constant `rest_time`, and the angle creeps by at most
    rest_speed * rest_time (1e-6 rad) per stop. In motion into an end stop the angle stands still, and omega
    decays within about 1e-4 s. Bounces are impulses: stop.restitution > 0 is refused.

    control.linearize of the continuous system is `dualcam.linearize`: exact, and an error at stick. For the
    sampled system it is python-control's own, by differences of whole steps.

    Copies of a system share one FMU, whose whole state each call sets.

    Names of the FMU's parameters in the `params` of a run are refused (FmuError). Other params belong to
    other systems of a loop.

    Source of the equations: docs/mechanism.md, sections 3 and 6.

    Examples
    --------
    >>> import control, dualcam, numpy as np
    >>> cam = dualcam.to_nonlinear_io_system("forward", "tau", ["theta", "omega"], period=1e-3)
    >>> time = np.arange(0.0, 0.2, 1e-3)  # s
    >>> response = control.input_output_response(cam, time, np.full(200, 3.0), [0.0, 0.0])
    >>> [round(theta, 4) for theta in response.outputs[0, [0, 20, -1]].tolist()]  # rad, under 3 N.m
    [0.0, 0.209, 0.6854]
    """
    names_in = selected_names(inputs, INPUTS, "input")
    sampling = sampling_period(period, dt)
    if sampling is None:
        speed, time = positive_number(rest_speed, "rest_speed"), positive_number(rest_time, "rest_time")
        return ContinuousCamSystem(source, names_in, outputs, parameters, speed, time, name)
    return _sampled(source, names_in, outputs, parameters, sampling, name)


def _outputs(fmu: Handle, names: Names) -> list[str]:
    """Names of outputs. FmuError for variables that do not follow from states and inputs alone."""
    variables = fmu.description.variables
    allowed = [
        variable.name
        for variable in variables
        if variable.causality in ("output", "local") and not variable.name.startswith(ACCUMULATED)
    ]
    wanted = list(OUTPUTS) if names is None else name_list(names)
    for name in wanted:
        if fmu.variable(name).name.startswith(ACCUMULATED):
            raise FmuError(
                f"output {name!r} is kept over steps and does not follow from theta and omega: step a Fmu"
            )
    return selected_names(wanted, allowed, "output")


class _InputValues:
    """Values of all inputs of the FMU from those of the system."""

    def __init__(self, names: list[str], parameters: Mapping[str, Scalar]) -> None:
        self._values = [float(parameters.get(name, 0.0)) for name in INPUTS]
        self._indices = [INPUTS.index(name) for name in names]

    def all_inputs(self, u: Array) -> list[float]:
        """tau [N.m] and F_ext [N] for inputs u of the system, shape (inputs,)."""
        values = list(self._values)
        for index, value in zip(self._indices, u, strict=True):
            values[index] = float(value)
        return values


def _label(name: str) -> str:
    """A name that python-control allows."""
    return name.replace(".", "_")


def _read(fmu: Handle, outputs: list[str], x: Array) -> Array:
    """Values of the outputs at state x, shape (outputs,)."""
    return np.array(
        [x[STATES.index(name)] if name in STATES else fmu.get(name) for name in outputs], dtype=float
    )


class CamSystem(control.NonlinearIOSystem):
    """A plant whose FMU has the start values of the constructor."""

    def __init__(
        self,
        fmu: Handle,
        *functions: Callable[..., Array],
        outputs: list[str],
        **options: Any,  # noqa: ANN401
    ) -> None:
        variables = fmu.description.variables
        self._parameters = [variable.name for variable in variables if variable.causality == "parameter"]
        super().__init__(*functions, outputs=[*map(_label, outputs)], states=list(STATES), **options)

    def _update_params(self, params: Mapping[str, Any]) -> None:
        """python-control calls this at the beginning of each run."""
        self._refuse_params(params)
        super()._update_params(params)

    def _refuse_params(self, params: Mapping[str, Any] | None) -> None:
        """FmuError for params that mean the FMU. In a loop those of all systems come here."""
        meant = [key for key in params or () if any(_means(str(key), name) for name in self._parameters)]
        if meant:
            raise FmuError(
                f"params with {', '.join(meant)}: the FMU takes no params of a run; parameters={{...}} of"
                " to_nonlinear_io_system sets its start values"
            )


def _means(key: str, name: str) -> bool:
    """Whether a key is a parameter's name, with dots or with _, or begins with the name's group and a dot."""
    group, dot, _ = key.partition(".")
    return key == _label(name) or (dot != "" and name.startswith(group + dot))


# ---- continuous ----


class ContinuousCamSystem(CamSystem):
    """See to_nonlinear_io_system."""

    def __init__(
        self,
        source: Source,
        inputs: list[str],
        outputs: Names,
        parameters: Mapping[str, Scalar] | None,
        rest_speed: float,
        rest_time: float,
        name: str,
    ) -> None:
        cam = CamAtState(source, parameters)
        fmu = cam.fmu
        if fmu.real("stop.restitution") > 0.0:
            raise FmuError(
                "stop.restitution > 0: a bounce is an impulse, which no continuous right-hand side has;"
                " allowed is 0, or any with a period, which makes a sampled system"
            )
        all_inputs = _InputValues(inputs, fmu.parameters).all_inputs
        names = _outputs(fmu, outputs)
        needs_fmu = any(name not in STATES for name in names)

        def set_state(x: Array, u: Array) -> tuple[bool, bool]:
            """Sets the FMU; whether the cam counts as at rest, and as moving into a stop."""
            theta, omega = float(x[0]), float(x[1])
            self._check_begin(cam, theta)
            blocked = (theta >= cam.upper and omega > 0.0) or (theta <= cam.lower and omega < 0.0)
            rests = blocked or abs(omega) < rest_speed
            cam.set_state(theta, 0.0 if rests else omega, *all_inputs(u))
            return rests, blocked

        def rates(t: float, x: Array, u: Array, params: Mapping[str, Any]) -> Array:
            rests, blocked = set_state(x, u)
            omega, alpha = float(x[1]), cam.alpha
            if blocked and abs(omega) >= rest_speed:
                alpha -= omega / STOP_TIME
            elif rests and alpha == 0.0:
                alpha -= omega / rest_time
            return np.array([0.0 if blocked else omega, alpha])

        def output(t: float, x: Array, u: Array, params: Mapping[str, Any]) -> Array:
            if needs_fmu:
                set_state(x, u)
            return _read(fmu, names, x)

        def linear_model(x: Array, u: Array) -> control.StateSpace:
            tau, F_ext = all_inputs(u)
            return linearize(fmu, float(x[0]), float(x[1]), tau, F_ext, inputs=inputs, outputs=names)

        # Copies of the system share the FMU, whose whole state each call sets: only functions refer to it.
        self._linear_model = linear_model
        self._begins = False
        super().__init__(fmu, rates, output, inputs=inputs, outputs=names, name=name, dt=0)

    def _update_params(self, params: Mapping[str, Any]) -> None:
        super()._update_params(params)
        self._begins = True

    def _check_begin(self, cam: CamAtState, theta: float) -> None:
        """FmuError where a run begins outside the stops. Later a solver may try angles outside."""
        if not self._begins:
            return
        self._begins = False
        margin = OVERSHOOT * (cam.upper - cam.lower)
        if not cam.lower - margin <= theta <= cam.upper + margin:
            raise FmuError(
                f"theta = {theta:g} rad at the beginning: allowed is between the stops, {cam.lower:g} to"
                f" {cam.upper:g} rad"
            )

    def linearize(
        self,
        x0: ArrayLike | control.OperatingPoint,
        u0: ArrayLike | None = None,
        t: float = 0.0,
        params: Mapping[str, Any] | None = None,
        eps: float = 0.0,
        copy_names: bool = True,
        **names: object,
    ) -> control.StateSpace:
        """dualcam.linearize at states x0, shape (2,), and inputs u0, shape (inputs,); `names` rename its
        signals. The other arguments are python-control's and have no effect: the model is exact, and has
        names. FmuError for params that mean the FMU."""
        self._refuse_params(params)
        if isinstance(x0, control.OperatingPoint):
            x0, u0 = x0.states, x0.inputs if u0 is None else u0
        x = np.broadcast_to(real_array(x0, "x0", FmuError), 2)
        u = np.broadcast_to(real_array(0.0 if u0 is None else u0, "u0", FmuError), self.ninputs)
        model = self._linear_model(x, u)
        model.update_names(**({"inputs": self.input_labels, "outputs": self.output_labels} | names))
        return model


# ---- sampled ----


def _sampled(
    source: Source,
    inputs: list[str],
    outputs: Names,
    parameters: Mapping[str, Scalar] | None,
    period: float,
    name: str,
) -> control.NonlinearIOSystem:
    """See to_nonlinear_io_system."""
    fmu, values = open_forward(Fmu, source, parameters)
    names = _outputs(fmu, outputs)
    needs_fmu = any(name not in STATES for name in names)
    all_inputs = _InputValues(inputs, values).all_inputs
    runs = RepeatedStart(fmu, values, ["initial.theta", "initial.omega", *INPUTS])
    state = fmu.reals(*STATES)

    def update(t: float, x: Array, u: Array, params: Mapping[str, Any]) -> Array:
        runs.start([*x, *all_inputs(u)])
        fmu.step(period)
        return np.array(state.read())

    def output(t: float, x: Array, u: Array, params: Mapping[str, Any]) -> Array:
        if needs_fmu:
            runs.initialize([*x, *all_inputs(u)])
        return _read(fmu, names, x)

    return CamSystem(fmu, update, output, inputs=inputs, outputs=names, name=name, dt=period)
