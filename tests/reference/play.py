"""Motion without inertia and damping: the play operator, its jumps and its motion along the band's edge."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from .arithmetic import Number, poly, poly_derivative, sign
from .flank_choice import flank_order
from .integration import EventProblem, Peaks
from .kinematics import Kinematics
from .mechanism import Balance, Flanks, Load, Slip
from .numerical import OdeFlow
from .parameters import FLOWS, Refused
from .state import State


def jump(state: State, sigma: int) -> None:
    """Play operator: theta jumps along the band edge to the angle at which the edge torque equals tau, or to
    the stop."""
    if not state.is_straight():
        creep(state, sigma, following=False)
        return
    mech, tau = state.mechanism, state.tau_at(state.t)
    kin = mech.groove.at(state.theta)
    f_ext, k = state.f_ext_at(state.t), mech.spring[1]
    f0 = mech.spring_force(kin.z) + f_ext
    limit = mech.upper if sigma > 0 else mech.lower
    slope = k * kin.dz
    end = limit
    if k > 0:
        ratio = state.band_ratio(sign(tau) * sigma or 1)
        if ratio is not None and not (ratio < 0):
            end = state.theta + (tau / ratio - f0) / slope if tau != 0 else state.theta - f0 / slope
        if (end - limit) * sigma > 0:
            end = limit
    if (end - state.theta) * sigma < 0:
        end = state.theta
    knots = [state.theta, end]
    if k > 0:
        zero = state.theta - f0 / slope
        if (zero - state.theta) * (end - zero) > 0:
            knots.insert(1, zero)
    for a, b in pairwise(knots):
        book_path(state, sigma, a, b, f0 + slope * (a - state.theta), f0 + slope * (b - state.theta))
    state.account["work_ext"] += f_ext * kin.dz * (end - state.theta)
    state.theta = end


def book_path(state: State, sigma: int, a: Number, b: Number, fa: Number, fb: Number) -> None:
    """Accounts of quasi-static motion from angle a to b, with F_0 from fa to fb of one sign: all are
    linear in F_0, so the mean load counts. The caller adds work_ext."""
    mech = state.mechanism
    kin = mech.groove.at(a)
    mean = (fa + fb) / 2
    ratio = state.band_ratio(sigma * (sign(mean) or 1))
    if a == b:
        return
    if ratio is None:
        raise Refused("moving wedge")
    q = static_balance(state, kin, sigma, sign(mean) or 1)
    xi1, xi2 = mech.r2 * q.n2 / q.delta, mech.r1 * q.n1 / q.delta  # x_i per F_0
    for f in (fa, fb):
        state.note_reactions(mech.reactions(kin, f * xi1, f * xi2))
    turned = abs(b - a)
    state.account["work_in"] += ratio * mean * (b - a)
    state.account["heat_cam1"] += mech.mu1 * abs(mean * xi1) * (mech.r1**2 + kin.a1**2) * kin.dgamma * turned
    state.account["heat_cam2"] += (
        mech.mu2 * abs(mean * xi2) * (mech.r2**2 + kin.a2**2) * (1 - kin.dgamma) * turned
    )


def static_flanks(state: State, kin: Kinematics, sigma: int, s: int) -> Flanks:
    """Flanks of static sliding in direction sigma under a load of sign s."""
    mech = state.mechanism
    for e in flank_order(s):
        q = mech.balance(kin, Slip(sigma, e))
        if q.delta == 0:
            continue
        x1, x2 = s * mech.r2 * q.n2 / q.delta, s * mech.r1 * q.n1 / q.delta
        if (e[0] * x1 >= 0 or mech.mu1 == 0) and (e[1] * x2 >= 0 or mech.mu2 == 0):
            return e
    raise Refused("no consistent flanks")


def static_balance(state: State, kin: Kinematics, sigma: int, s: int) -> Balance:
    """Coefficients of the balance on these flanks."""
    return state.mechanism.balance(kin, Slip(sigma, static_flanks(state, kin, sigma, s)))


def load_sign(state: State, sigma: int) -> int:
    """Sign of F_0. Where F_0 vanishes, the sign that F_0 takes by further motion in direction sigma."""
    mech = state.mechanism
    kin, f_ext = mech.groove.at(state.theta), state.f_ext_at(state.t)
    f0 = mech.spring_force(kin.z) + f_ext
    return sign(f0) if abs(f0) > state.arithmetic.tiny * mech.force_scale(kin, f_ext) else sigma


def edge_slope(state: State, kin: Kinematics, slip: Slip, t: float) -> tuple[float, float]:
    """With the excess H = tau - rho F_0 over the edge torque: (dH/dt, d(rho F_0)/dtheta)."""
    mech = state.mechanism
    q = mech.balance(kin, slip)
    f1, f2 = slip.sigma * slip.e[0] * mech.mu1, slip.sigma * slip.e[1] * mech.mu2
    product = mech.r1 * mech.r2 * (kin.da1 * q.n2 + q.n1 * kin.da2)
    delta = mech.r2 * (q.d1 * kin.da2 - f1 * kin.da1 * q.n2)
    delta += mech.r1 * (q.d2 * kin.da1 - f2 * kin.da2 * q.n1)
    ratio = q.product / q.delta
    f0 = mech.spring_force(kin.z) + state.f_ext_at(t)
    drive = poly(poly_derivative(state.tau), t) - ratio * poly(poly_derivative(state.f_ext), t)
    rise = (product - ratio * delta) / q.delta * f0 + ratio * mech.spring_slope(kin.z) * kin.dz
    return drive, rise


def edge_slopes(state: State, sigma: int) -> tuple[float, float]:
    """`edge_slope` at the present angle and time, on the flanks of further motion in direction sigma."""
    mech = state.mechanism
    piece, _ = mech.groove.ahead(state.theta, sigma)
    step = sigma * 1e-7 * (mech.upper - mech.lower)
    e = static_flanks(state, mech.groove.at(state.theta + step, piece), sigma, load_sign(state, sigma))
    return edge_slope(state, mech.groove.at(state.theta, piece), Slip(sigma, e), state.t)


def creep(state: State, sigma: int, *, following: bool) -> str:
    """Motion without inertia and damping along the band's edge, any grooves; returns the cause of its end.

    Not following: at once, at fixed inputs, until the edge torque T = rho F_0 holds tau ("held") or to
    the stop. Following: along the curve H(theta, t) = tau(t) - T(theta, t) = 0, by its own length:
    (dtheta, dt) ~ (H_t, T_theta), each in units of its span. It turns where H_t changes sign; where
    T_theta does, the edge torque no longer rises along the path ("fold"), and theta jumps."""
    mech, length = state.mechanism, state.length
    assert isinstance(state.flow, OdeFlow)
    span = mech.upper - mech.lower
    y = np.array([state.theta, state.t] + [0.0] * len(FLOWS))
    path, s, peaks, ended = 0.0, load_sign(state, sigma), Peaks(), ""
    kin = mech.groove.at(state.theta)
    force = mech.force_scale(kin, state.input_sizes()[1])
    up, down = state.band_ratios()
    torque = state.input_sizes()[0] + max(abs(up), abs(down or 0.0)) * force
    if not following:
        excess = sigma * (
            state.tau_at(state.t) - (state.band_ratio(sigma * s) or 0.0) * state.f0_at(kin, state.t)
        )
        level = abs(excess) <= state.arithmetic.tiny * torque and not state.snapping
        if level and edge_slopes(state, sigma)[1] > 0:
            return "held"
    state.snapping = False
    scale = 1e-15 * np.array([span, length] + [torque * span * 1e-2] * len(FLOWS))
    zero_scale = dict.fromkeys(("stop", "knot", "turn", "fold", "end"), 0.0)
    zero_scale |= {"kink": force, "held": torque}
    zero_scale |= dict.fromkeys(("cross1", "cross2"), 1 / mech.r1 + 1 / mech.r2)
    while ended in ("", "knot", "kink", "cross1", "cross2"):
        theta = float(y[0])
        piece, knot = mech.groove.ahead(theta, sigma)
        ahead = mech.groove.at(theta + sigma * 1e-7 * span, piece)
        slip = Slip(sigma, static_flanks(state, ahead, sigma, s))
        if ended in ("cross1", "cross2") and not following:
            # without torque, a contact changes its flank where the edge torque passes zero
            q = mech.balance(ahead, slip)
            beyond = state.tau_at(state.t) - q.product / q.delta * state.f0_at(ahead, state.t)
            if sigma * beyond < -state.arithmetic.tiny * torque:
                ended = "held"
                break
        problem = creep_problem(state, slip, piece, knot, following, zero_scale, scale)
        path, y, ended = state.flow.solver.integrate_to_event(problem, path, y, 10.0, peaks)
        if ended == "knot":
            y[0] = knot
        if ended == "kink":
            s = -s
            if not following and abs(state.tau_at(state.t)) <= state.arithmetic.tiny * torque:
                ended = "held"  # without torque the motion ends where the load vanishes
    if ended == "end" and path == 10.0:
        raise ArithmeticError("the path along the edge does not end")
    state.theta, state.t = float(y[0]), float(y[1])
    if ended == "stop":
        state.theta = mech.upper if sigma > 0 else mech.lower
    if ended == "end":
        state.t = length
    if ended in (
        "end",
        "turn",
    ):  # Newton's method removes the rounding error of the integration along the curve
        for _ in range(3):
            kin = mech.groove.at(state.theta, piece)
            q = mech.balance(kin, slip)
            excess = state.tau_at(state.t) - q.product / q.delta * state.f0_at(kin, state.t)
            state.theta += excess / edge_slope(state, kin, slip, state.t)[1]
    for name, value in zip(FLOWS, y[2:], strict=True):
        state.account[name] += float(value)
    state.peak["omega"] = max(state.peak["omega"], peaks.best[0])
    state.note_reactions(peaks.best[1:])
    return ended


def creep_problem(
    state: State,
    slip: Slip,
    piece: int,
    knot: float | None,
    following: bool,
    zero_scale: dict[str, float],
    scale: np.ndarray,
) -> EventProblem:
    mech, length, sigma = state.mechanism, state.length, slip.sigma
    span, stop = mech.upper - mech.lower, mech.upper if sigma > 0 else mech.lower

    def direction(kin: Kinematics, t: float) -> tuple[float, float]:
        if not following:
            return sigma * span, 0.0
        drive, rise = edge_slope(state, kin, slip, t)
        size = math.hypot(drive * length, rise * span)
        return span * (drive * length / size), length * (rise * span / size)

    def rates(_s: float, y: np.ndarray) -> list[float]:
        theta, t = float(y[0]), float(y[1])
        kin, f_ext = mech.groove.at(theta, piece), state.f_ext_at(t)
        q, f0 = mech.balance(kin, slip), mech.spring_force(kin.z) + f_ext
        turned, passed = direction(kin, t)
        x1, x2 = mech.r2 * q.n2 / q.delta * f0, mech.r1 * q.n1 / q.delta * f0
        load = Load(turned, 0.0, x1, x2)
        flows = mech.powers(kin, slip, load, q.product / q.delta * f0, f_ext)
        return [turned, passed, *flows[:4], 0.0, 0.0]

    def observe(_s: float, y: np.ndarray) -> tuple[dict[str, float], tuple[float, float, float]]:
        theta, t = float(y[0]), float(y[1])
        kin = mech.groove.at(theta, piece)
        q, f0 = mech.balance(kin, slip), state.f0_at(kin, t)
        xi1, xi2 = mech.r2 * q.n2 / q.delta, mech.r1 * q.n1 / q.delta
        seen = {"stop": theta - stop, "kink": f0}
        if knot is not None:
            seen["knot"] = theta - knot
        if mech.mu1 > 0:
            seen["cross1"] = xi1
        if mech.mu2 > 0:
            seen["cross2"] = xi2
        omega = 0.0
        if following:
            drive, rise = edge_slope(state, kin, slip, t)
            seen |= {"turn": drive, "fold": rise, "end": t - length}
            if rise > 0:
                omega = abs(drive) / rise
        else:
            seen["held"] = state.tau_at(t) - q.product / q.delta * f0
        return seen, (omega, *mech.reactions(kin, xi1 * f0, xi2 * f0))

    return EventProblem(rates, observe, zero_scale, lambda _y: 6.0, scale)


def follow_ramp(state: State) -> str:
    """Quasi-static motion along the edge on helices, under ramps: theta is linear in time. Returns the cause
    of its end: end, stop or kink."""
    mech, speed = state.mechanism, state.follow
    assert speed is not None
    kin = mech.groove.at(state.theta)
    limit = mech.upper if speed > 0 else mech.lower
    ends = {"end": state.length - state.t, "stop": (limit - state.theta) / speed}
    if state.tau[1] != 0:
        kink = -state.tau_at(state.t) / state.tau[1]  # F_0 = tau/ratio changes sign
        if kink > state.arithmetic.tiny * state.length:
            ends["kink"] = kink
    cause = min(ends, key=lambda name: ends[name])
    dt = ends[cause]
    if any(abs(t - dt) <= 1e-12 * state.length for name, t in ends.items() if name != cause):
        state.doubts.append("two switches at once")
    theta = limit if cause == "stop" else state.theta + speed * dt
    fs = mech.spring_force(kin.z)
    fs_end = mech.spring_force(mech.groove.at(theta).z)
    before, after = fs + state.f_ext_at(state.t), fs_end + state.f_ext_at(state.t + dt)
    turned, held = theta - state.theta, state.account["work_in"]
    book_path(state, sign(speed), state.theta, theta, before, after)
    state.account["work_in"] = held + (state.tau_at(state.t) + state.tau_at(state.t + dt)) / 2 * turned
    state.account["work_ext"] += state.f_ext_at(state.t + dt / 2) * kin.dz * turned
    state.peak["omega"] = max(state.peak["omega"], abs(speed))
    state.t += dt
    state.theta = theta
    if cause != "end":
        state.omega = speed * 0
    return cause


def follow_curve(state: State) -> str:
    """Quasi-static motion along the edge, any grooves and inputs. Returns the cause of its end."""
    assert state.follow is not None
    sigma = sign(state.follow)
    ended = creep(state, sigma, following=True)
    if ended == "end":
        drive, rise = edge_slopes(state, sigma)
        state.omega = drive / rise
        return ended
    state.omega = 0.0
    if ended == "fold":
        state.peak["omega"] = math.inf
        state.snapping, state.follow = True, None
        jump(state, sigma)
    return ended
