"""The edge of the stick band without inertia: flanks of static sliding, and slopes of the edge torque."""

from __future__ import annotations

from .arithmetic import poly, poly_derivative, sign
from .flank_choice import flank_order
from .kinematics import Kinematics
from .mechanism import Balance, Flanks, Slip
from .parameters import Refused
from .state import State


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
