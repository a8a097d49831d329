"""Stick or slip: the decision at rest."""

from __future__ import annotations

from .arithmetic import Number, poly_zeros, sign
from .parameters import LOWER_STOP, STICK, UPPER_STOP, WEDGED
from .state import State


def rest(state: State) -> tuple[int, int, Number]:
    """(mode, 0, until) if the mechanism rests, (0, sigma, until) if it slips. The decision is valid up to the
    time `until`; it is made for the middle of that span, so that a ramp resolves a torque exactly
    on an edge."""
    mech, number = state.mechanism, state.arithmetic.number
    kin = mech.groove.at(state.theta)
    fs = mech.spring_force(kin.z)
    up, down = state.band_ratios()
    ratios = [r for r in (up, down) if r is not None]
    if down is None:
        ratios.append(kin.dz)
    size = max(len(state.tau), len(state.f_ext))
    tau, f_ext = (c + (number(0),) * (size - len(c)) for c in (state.tau, state.f_ext))
    lines = [(fs + f_ext[0], *f_ext[1:])]
    lines += [tuple(u - r * f for u, f in zip(tau, lines[0], strict=True)) for r in ratios]
    guard = state.t + number(state.arithmetic.tiny) * state.length * 10
    times = [t for line in lines for t in poly_zeros(line, guard, state.length)]
    until = min(times, default=state.length)
    constant = not any(state.tau[1:]) and not any(state.f_ext[1:])
    middle = state.t if constant else (state.t + until) / 2
    tau, f0 = state.tau_at(middle), fs + state.f_ext_at(middle)
    tau_size, f_size = state.input_sizes()
    size = tau_size + abs(up) * mech.force_scale(kin, f_size)
    near = state.arithmetic.tiny * size
    load, release = (up, down) if f0 >= 0 else (down, up)
    if abs(up * f0) <= near:  # the next increment of motion gives the load the sign of sigma
        load = release = up
    if load is not None and tau > load * f0 + near:
        return (UPPER_STOP, 0, until) if state.theta >= mech.upper else (0, +1, until)
    if release is not None and tau < release * f0 - near:
        return (LOWER_STOP, 0, until) if state.theta <= mech.lower else (0, -1, until)
    towards = sign(tau - kin.dz * f0) if abs(tau - kin.dz * f0) > near else 0
    if (towards > 0 and load is None) or (towards < 0 and release is None):
        return WEDGED, 0, until
    ahead = abs(state.tau_at(until)), abs(up * (fs + state.f_ext_at(until)))
    if until < state.length and max(ahead) <= near:  # for an instant the band has no width
        state.doubts.append("stick band without width")
    if constant and state.omega == 0 and mech.inertial and near > 0:
        edges = [r * f0 for r in (load, release) if r is not None]
        if any(0 < abs(tau - edge) < 1e-11 * size for edge in edges):
            state.doubts.append("torque on a band edge")
    return STICK, 0, until
