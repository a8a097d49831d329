"""The pair of flanks on which the pins slide: the pair whose contact loads press on these flanks."""

from __future__ import annotations

from .arithmetic import Number, sign
from .mechanism import Flanks, Load, Slip
from .state import State


def choose_flanks(
    state: State, sigma: int, present: Flanks | None, crossed: Flanks | None, crossing: bool
) -> Slip | None:
    """The first consistent flanks, or None. `present` are the flanks of the motion so far, which stay if they
    are consistent. `crossed` are the flanks to try first after a contact load has crossed zero."""
    mech = state.mechanism
    kin = mech.groove.at(state.theta)
    s = axial_sign(state, sigma)
    order = [e for e in flank_order(s) if mech.balance(kin, Slip(sigma, e)).delta != 0]
    if (
        not mech.inertial
    ):  # the damper force depends on the flanks: each pair is ordered by its own axial force
        own = {e: sign(ahead(state, Slip(sigma, e))[2]) or s for e in order}
        order.sort(key=lambda e: flank_order(own[e]).index(e))
    first = present or crossed
    if first is not None:
        order = [first] + [e for e in order if e != first]
    found = [Slip(sigma, e) for e in order if consistent(state, Slip(sigma, e))]
    if len(found) > 1:
        # The choice is a matter of convention only at the start of a motion, and only while more torque means
        # more acceleration.
        loads = [ahead(state, slip)[1] for slip in found]
        size = max(abs(load.x1) + abs(load.x2) for load in loads)
        differ = any(abs(load.x1 - loads[0].x1) > 1e-9 * size for load in loads)
        masses = [mech.inertia_and_drag(kin, s)[1] * mech.balance(kin, s).delta for s in found]
        if differ and (crossing or min(masses) < 0):
            state.doubts.append("several flank pairs are consistent")
    return found[0] if found else None


def flank_order(s: int) -> list[Flanks]:
    """Order of trial under an axial load of sign s."""
    return [(s, s), (s, -s), (-s, s), (-s, -s)]


def ahead(state: State, slip: Slip) -> tuple[Load, Load, Number]:
    """Load now, load a short time dt later, and the axial force F at that later time."""
    mech = state.mechanism
    kin = mech.groove.at(state.theta)
    dt = state.arithmetic.probe / (mech.rate(kin, slip) + 1 / state.length)
    now = mech.load(kin, slip, state.omega, state.tau_at(state.t), state.f_ext_at(state.t))
    theta, omega, t = state.theta + dt * now.omega, now.omega + dt * now.alpha, state.t + dt
    first = mech.load(mech.groove.at(theta), slip, omega, state.tau_at(t), state.f_ext_at(t))
    # second step with the mean of both rates: at a start on a ramp the first acceleration is zero
    theta += dt * (first.omega - now.omega) / 2 + dt**2 * (first.alpha - now.alpha) / 6
    omega = now.omega + dt * (now.alpha + first.alpha) / 2
    later_kin = mech.groove.at(theta)
    later = mech.load(later_kin, slip, omega, state.tau_at(t), state.f_ext_at(t))
    force = mech.spring_force(later_kin.z) + state.f_ext_at(t)
    return now, later, force + mech.damper_force(slip.sigma, later_kin.dz * later.omega)


def axial_sign(state: State, sigma: int) -> int:
    """Sign of F = F_s + F_ext + D. Where F vanishes, the sign that F takes a short time later."""
    mech = state.mechanism
    kin = mech.groove.at(state.theta)
    damping = mech.damper_force(sigma, kin.dz * state.omega) if mech.inertial else state.omega * 0
    force = mech.spring_force(kin.z) + state.f_ext_at(state.t) + damping
    if abs(force) > state.arithmetic.tiny * (mech.force_scale(kin, state.input_sizes()[1]) + abs(damping)):
        return sign(force)
    return sign(ahead(state, Slip(sigma, (sigma, sigma)))[2]) or sigma


def consistent(state: State, slip: Slip) -> bool:
    """Do the contact loads press on the assumed flanks, and does a start from rest go along sigma?"""
    mech, tiny = state.mechanism, state.arithmetic.tiny
    kin = mech.groove.at(state.theta)
    now, later, _ = ahead(state, slip)
    size = mech.scales(kin, slip, state.omega, *state.input_sizes())
    pairs = ((now.x1, later.x1, size.x1, mech.mu1), (now.x2, later.x2, size.x2, mech.mu2))
    for e, (x, x_later, scale, mu) in zip(slip.e, pairs, strict=True):
        if mu == 0:
            continue
        if abs(x) > tiny * scale:
            if e * x < 0:
                return False
        elif e * x_later < -tiny / 100 * scale:
            return False
    if mech.inertial and state.omega != 0:
        return True
    which = 1 if mech.inertial else 0  # alpha or omega
    return slip.sigma * (now[which] if abs(now[which]) > tiny * size[which] else later[which]) > 0
