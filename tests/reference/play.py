"""Motion without inertia and damping: jumps of the play operator, and motion along the band's edge."""

from __future__ import annotations

import math
from itertools import pairwise

from .arithmetic import Number, sign
from .band_edge import edge_slopes, static_balance
from .creep import creep
from .parameters import Refused
from .state import State


def jump(state: State, sigma: int) -> None:
    """Play operator: theta jumps along the band edge to the angle at which the edge torque equals tau, or to
    the stop."""
    if state.mechanism.is_loaded:
        raise NotImplementedError("a load law: its play is in tests/test_friction_load.py, in closed form")
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
