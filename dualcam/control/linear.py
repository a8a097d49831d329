"""Linear models of the forward FMU from its own partial derivatives."""

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import control
import numpy as np

from dualcam.common.arrays import number_of
from dualcam.control.forward import (
    INPUTS,
    LOADING,
    LOWER_STOP,
    OUTPUTS,
    RELEASING,
    STATES,
    STICK,
    UPPER_STOP,
    WEDGED,
    CamAtState,
    Names,
    Source,
    sampling_period,
    selected_names,
)
from dualcam.errors import DualcamWarning, OperatingPointError
from dualcam.fmi.model_description import Scalar

AtRest = Literal["loading", "releasing", "frozen"]

BEYOND_EDGE = 1e-6  # of the band's edge: torque this much beyond the edge begins slip, as 1e-13 would
UNBALANCED = 1e-3  # of the torque: less than this beside the steady torque is an equilibrium
ITERATIONS = 20  # one for each pair of flanks and one more are enough


@dataclass(frozen=True)
class OperatingPoint:
    """The point of a linear model. The model's states, inputs and outputs are deviations from this point.

    Attributes
    ----------
    theta : Angle [rad].
    omega : Speed [rad/s].
    tau : Torque [N.m].
    F_ext : Axial force [N].
    alpha
        Acceleration [rad/s2]. Where it is not zero, deviations are from a motion, not from an equilibrium.
    mode : 1 stick, 2 loading, 3 releasing.
    """

    theta: float
    omega: float
    tau: float
    F_ext: float
    alpha: float
    mode: int


def linearize(
    source: Source,
    theta: float,
    omega: float = 0.0,
    tau: float | None = None,
    F_ext: float | None = None,
    *,
    at_rest: AtRest | None = None,
    inputs: Names = None,
    outputs: Names = None,
    parameters: Mapping[str, Scalar] | None = None,
    period: float | None = None,
    dt: float | None = None,
) -> control.StateSpace:
    """The linear model about an operating point, from the FMU's partial derivatives.

    With x = (theta, omega) [rad, rad/s], u out of (tau [N.m], F_ext [N]) and y out of theta, omega, z [m],
    v [m/s], all as deviations:  x' = A x + B u,  y = C x + D u.  A is (2, 2); D is zero.

    Parameters
    ----------
    source
        "forward", the path of a forward FMU (FMI 2.0 or 3.0), or a handle (then with the parameters of its
        last start).
    theta : Angle of the operating point [rad], between the stops.
    omega : Speed of the operating point [rad/s]. Its sign is the direction of slip.
    tau : Torque at the point [N.m]. None: the torque that keeps omega constant (alpha = 0).
    F_ext : Axial force at the point [N]. None: that of `parameters`, else 0.
    at_rest : {"loading", "releasing", "frozen"}, optional
        For omega = 0, where slip or stick depends on the torque. "loading", "releasing": slip at its
        beginning in that direction, at that edge of the stick band. Design controllers for moves in that
        direction with this model. "frozen": stick. Nothing moves, A = 0 and B = 0, while tau is inside the
        band. None: tau decides. For slip from rest the model of that slip; for stick an error.
    inputs, outputs : Names, in order. None: all.
    parameters : Start values of the FMU.
    period
        None: continuous. Else the model at multiples of `period` [s] under inputs held over each period:
        control.sample_system of the continuous one. While the mode lasts, the sampled model is exact for
        linear slip (helices, linear spring and damper), else right to first order in the period.
    dt : The same as `period`, by python-control's name.

    Returns
    -------
    With named signals, and the OperatingPoint as its attribute `operating_point`.

    Warns
    -----
    DualcamWarning
        `tau` is more than 0.1 % beside the torque that keeps omega constant. The point is then no
        equilibrium: the model's deviations are from a motion that leaves the point with the acceleration
        alpha.

    Raises
    ------
    OperatingPointError
        No such model exists: at rest without `at_rest`, on a stop, wedged, outside the stops.
    FmuError : An unknown name, or a value that the FMU refuses (without inertia the speed is no state).

    Notes
    -----
    Source of the equations: docs/mechanism.md, section 6; the derivatives are the FMU's own, analytic ones.

    Examples
    --------
    >>> import dualcam
    >>> model = dualcam.linearize("forward", theta=0.4, at_rest="loading", inputs="tau", outputs="theta")
    >>> model.A.round(1).tolist()  # 1/s, 1/s2
    [[0.0, 1.0], [-3314.0, 0.0]]
    >>> round(model.operating_point.tau, 3)  # N.m, the load edge of the stick band
    3.314
    """
    names_in, names_out = selected_names(inputs, INPUTS, "input"), selected_names(outputs, OUTPUTS, "output")
    sampling = sampling_period(period, dt)
    theta, omega = number_of(theta, "theta"), number_of(omega, "omega")
    tau = None if tau is None else number_of(tau, "tau")
    cam = CamAtState(source, parameters)
    try:
        force = number_of(cam.fmu.parameters.get("F_ext", 0.0) if F_ext is None else F_ext, "F_ext")
        point = _go_to_operating_point(cam, theta, omega, tau, force, at_rest)
        model = _model(cam, point, names_in, names_out)
        _warn_of_motion(cam, point)
    finally:
        cam.fmu.close()
    if sampling is not None:
        model = control.sample_system(model, sampling, "zoh", name="cam")
    model.operating_point = point
    return model


def _model(
    cam: CamAtState, point: OperatingPoint, inputs: list[str], outputs: list[str]
) -> control.StateSpace:
    """The model from the partial derivatives at the FMU's present state."""
    rates = cam.fmu.jacobian(["omega", "alpha"], [*STATES, *inputs])
    if point.mode not in (LOADING, RELEASING):
        rates[:] = 0.0  # at rest a deviation of the speed is no motion: friction stops it at once
    output_jacobian = cam.fmu.jacobian(outputs, [*STATES, *inputs])
    return control.ss(
        rates[:, :2], rates[:, 2:], output_jacobian[:, :2], output_jacobian[:, 2:],
        inputs=inputs, outputs=outputs, states=list(STATES), name="cam",
    )  # fmt: skip


def _warn_of_motion(cam: CamAtState, point: OperatingPoint) -> None:
    """DualcamWarning where the point, at which the FMU is, is no equilibrium."""
    if point.alpha == 0.0:
        return
    steady = point.tau - point.alpha / float(cam.fmu.jacobian(["alpha"], ["tau"])[0, 0])
    if abs(point.tau - steady) > UNBALANCED * max(abs(point.tau), abs(steady)):
        way = "loading" if point.mode == LOADING else "releasing"
        remedy = "leave tau out" if point.omega else f"give at_rest = {way!r} and leave tau out"
        warnings.warn(
            DualcamWarning(
                f"theta = {point.theta:g} rad, omega = {point.omega:g} rad/s, tau = {point.tau:g} N.m is no"
                f" equilibrium: alpha = {point.alpha:.4g} rad/s2. The model's deviations are from this"
                f" motion, which leaves the point. tau = {steady:.4g} N.m keeps the speed: {remedy}"
            ),
            stacklevel=3,
        )


# ---- operating points ----


def _go_to_operating_point(
    cam: CamAtState, theta: float, omega: float, tau: float | None, F_ext: float, at_rest: AtRest | None
) -> OperatingPoint:
    """The operating point, with the FMU at it and in its mode. OperatingPointError if there is none."""
    where = f"theta = {theta:g} rad, omega = {omega:g} rad/s"
    if not cam.lower <= theta <= cam.upper:
        raise OperatingPointError(
            f"{where}: allowed is theta between the stops, {cam.lower:g} to {cam.upper:g} rad"
        )
    if at_rest not in (None, "loading", "releasing", "frozen"):
        raise OperatingPointError(
            f'at_rest = {at_rest!r}: allowed are "loading", "releasing", "frozen", None'
        )
    if omega != 0.0:
        if at_rest is not None:
            raise OperatingPointError(
                f"at_rest = {at_rest!r} with {where}: allowed is only one of them, omega has a direction"
            )
        torque = _steady_torque(cam, theta, omega, F_ext, where) if tau is None else tau
        cam.set_state(theta, omega, torque, F_ext)
    elif at_rest in ("loading", "releasing"):
        if tau is not None:
            raise OperatingPointError(
                f"at_rest = {at_rest!r} with tau = {tau:g} N.m: leave tau out, that edge of the band is it"
            )
        torque = _break_away(cam, theta, F_ext, at_rest, where)
    else:
        torque = _torque_at_rest(cam, theta, tau, F_ext, at_rest, where)
    mode = cam.mode
    _check_model_exists(cam, mode, at_rest, f"{where}, tau = {torque:g} N.m")
    return OperatingPoint(theta, omega, torque, F_ext, cam.alpha, mode)


ADVICE = {
    STICK: "it sticks; give at_rest = 'loading' or 'releasing' for slip about to begin there (tau left out),"
    " at_rest = 'frozen' for the model that stays, omega != 0, or a torque outside",
    LOWER_STOP: "it is pressed on the lower stop; give theta above it, or a torque beyond",
    UPPER_STOP: "it is pressed on the upper stop; give theta below it, or a torque beyond",
    WEDGED: "friction wedges it; lower the friction or choose other lead angles. The torque is beyond",
}


def _check_model_exists(cam: CamAtState, mode: int, at_rest: AtRest | None, where: str) -> None:
    """OperatingPointError where the mode has no linear model of the kind asked for."""
    release, load = cam.band()
    band = f"the stick band, {release:g} to {load:g} N.m"
    slips = mode in (LOADING, RELEASING)
    if slips and at_rest == "frozen":
        raise OperatingPointError(f"{where}: it slips; at_rest = 'frozen' is for torques inside {band}")
    if not slips and at_rest != "frozen":
        raise OperatingPointError(
            f"{where}: no torque or force has an effect there to linearize or to control with:"
            f" {ADVICE[mode]} {band}"
        )


def _steady_torque(cam: CamAtState, theta: float, omega: float, F_ext: float, where: str) -> float:
    """The torque at which alpha = 0. Newton's method: alpha is affine in tau while the flanks stay the same.
    So a step that is small against tau (or 1e-6 N.m) is the last one, and exact."""
    tau = 0.0
    for _ in range(ITERATIONS):
        cam.set_state(theta, omega, tau, F_ext)
        slope = float(cam.fmu.jacobian(["alpha"], ["tau"])[0, 0])
        if slope == 0.0 or not math.isfinite(slope):
            break
        last, tau = tau, tau - cam.alpha / slope
        if abs(tau - last) <= 1e-9 * max(abs(last), 1e-6):
            return tau
    raise OperatingPointError(
        f"{where}: no torque keeps this speed there; give tau, or another place or direction"
    )


def _break_away(cam: CamAtState, theta: float, F_ext: float, at_rest: AtRest, where: str) -> float:
    """Begins slip at omega = 0 and then sets tau to the edge of the band; returns that torque [N.m]."""
    cam.set_state(theta, 0.0, 0.0, F_ext)
    release, load = cam.band()
    direction, edge = (1.0, load) if at_rest == "loading" else (-1.0, release)
    if not math.isfinite(edge):
        raise OperatingPointError(
            f"{where}: friction jams it, no torque starts {at_rest} there; lower the friction or choose"
            " other lead angles"
        )
    size = max(abs(x) for x in (release, load, 1e-3) if math.isfinite(x))
    cam.set_state(theta, 0.0, edge + direction * BEYOND_EDGE * size, F_ext)
    cam.set_inputs(edge, F_ext)
    return edge


def _torque_at_rest(
    cam: CamAtState, theta: float, tau: float | None, F_ext: float, at_rest: AtRest | None, where: str
) -> float:
    """The given torque, or one inside the band [N.m]."""
    if tau is None:
        if at_rest is None:
            raise OperatingPointError(
                f"{where}: at rest the model depends on the torque; give at_rest = 'loading' or 'releasing'"
                " for slip about to begin, at_rest = 'frozen' for stick, or tau"
            )
        cam.set_state(theta, 0.0, 0.0, F_ext)
        edges = [edge for edge in cam.band() if math.isfinite(edge)]
        tau = float(np.mean(edges)) if edges else 0.0
    cam.set_state(theta, 0.0, tau, F_ext)
    return tau
