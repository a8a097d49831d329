"""Motion along the band's edge without inertia and damping, for any grooves and inputs."""

from __future__ import annotations

import math

import numpy as np

from .band_edge import edge_slope, edge_slopes, load_sign, static_flanks
from .integration import EventProblem, Peaks
from .kinematics import Kinematics
from .mechanism import Load, Slip
from .numerical import OdeFlow
from .parameters import FLOWS
from .state import State

LONGEST_PATH = 10.0  # in units of the span between the stops


class Creep:
    """One motion along the edge, from the angle and the time of a state, in direction sigma.

    Not following: theta moves at once, at fixed inputs, until the edge torque T = rho F_0 equals tau ("held")
    or to the stop. Following: theta and t move along the curve H(theta, t) = tau(t) - T(theta, t) = 0, by its
    own length: (dtheta, dt) ~ (H_t, T_theta), each in units of its span. The curve turns where H_t changes
    sign. Where T_theta changes sign, the edge torque no longer rises along the path ("fold"), and theta
    jumps."""

    def __init__(self, state: State, sigma: int, following: bool) -> None:
        mech = state.mechanism
        self.state, self.sigma, self.following = state, sigma, following
        self.span = mech.upper - mech.lower
        self.stop = mech.upper if sigma > 0 else mech.lower
        self.load_sign = load_sign(state, sigma)
        kin = mech.groove.at(state.theta)
        tau_size, pull_size = state.input_sizes()
        self.force = mech.force_scale(kin, pull_size)
        up, down = state.band_ratios()
        self.torque = tau_size + max(abs(up), abs(down or 0.0)) * self.force
        self.near = state.arithmetic.tiny * self.torque
        self.peaks = Peaks()
        self.atol = 1e-15 * np.array(
            [self.span, state.length] + [self.torque * self.span * 1e-2] * len(FLOWS)
        )
        self.zero_scale = dict.fromkeys(("stop", "knot", "turn", "fold", "end"), 0.0)
        self.zero_scale |= {"kink": self.force, "held": self.torque}
        self.zero_scale |= dict.fromkeys(("cross1", "cross2"), 1 / mech.r1 + 1 / mech.r2)

    def run(self) -> str:
        """Moves the state and books the motion. Returns the cause of the end."""
        state = self.state
        if not self.following and self._is_held():
            return "held"
        state.snapping = False
        y, ended = self._move(np.array([state.theta, state.t] + [0.0] * len(FLOWS)))
        state.theta, state.t = float(y[0]), float(y[1])
        if ended == "stop":
            state.theta = self.stop
        if ended == "end":
            state.t = state.length
        if ended in ("end", "turn"):
            self._return_to_curve()
        for name, value in zip(FLOWS, y[2:], strict=True):
            state.account[name] += float(value)
        state.peak["omega"] = max(state.peak["omega"], self.peaks.best[0])
        state.note_reactions(self.peaks.best[1:])
        return ended

    def _is_held(self) -> bool:
        """Does the edge torque equal tau already, and would it rise by motion?"""
        state = self.state
        kin = state.mechanism.groove.at(state.theta)
        ratio = state.band_ratio(self.sigma * self.load_sign) or 0.0
        excess = self.sigma * (state.tau_at(state.t) - ratio * state.f0_at(kin, state.t))
        level = abs(excess) <= self.near and not state.snapping
        return level and edge_slopes(state, self.sigma)[1] > 0

    def _move(self, y: np.ndarray) -> tuple[np.ndarray, str]:
        """Integrates theta, t and the flows from one event to the next, up to one that ends the motion."""
        state, path, ended = self.state, 0.0, ""
        assert isinstance(state.flow, OdeFlow)
        while ended in ("", "knot", "kink", "cross1", "cross2"):
            self.piece, knot = state.mechanism.groove.ahead(float(y[0]), self.sigma)
            ahead = state.mechanism.groove.at(float(y[0]) + self.sigma * 1e-7 * self.span, self.piece)
            self.slip = Slip(self.sigma, static_flanks(state, ahead, self.sigma, self.load_sign))
            if ended in ("cross1", "cross2") and not self.following and self._excess(ahead) < -self.near:
                # without torque, a contact changes its flank where the edge torque passes zero
                return y, "held"
            path, y, ended = state.flow.solver.integrate_to_event(
                self._problem(knot), path, y, LONGEST_PATH, self.peaks
            )
            if ended == "knot":
                y[0] = knot
            if ended == "kink":
                self.load_sign = -self.load_sign
                if not self.following and abs(state.tau_at(state.t)) <= self.near:
                    ended = "held"  # without torque the motion ends where the load vanishes
        if ended == "end" and path == LONGEST_PATH:
            raise ArithmeticError("the path along the edge does not end")
        return y, ended

    def _excess(self, kin: Kinematics) -> float:
        """Torque beyond the edge torque, counted in the direction of motion."""
        state, q = self.state, self.state.mechanism.balance(kin, self.slip)
        return self.sigma * (state.tau_at(state.t) - q.product / q.delta * state.f0_at(kin, state.t))

    def _return_to_curve(self) -> None:
        """Newton's method removes the rounding error of the integration along the curve."""
        state, mech = self.state, self.state.mechanism
        for _ in range(3):
            kin = mech.groove.at(state.theta, self.piece)
            q = mech.balance(kin, self.slip)
            excess = state.tau_at(state.t) - q.product / q.delta * state.f0_at(kin, state.t)
            state.theta += excess / edge_slope(state, kin, self.slip, state.t)[1]

    def _problem(self, knot: float | None) -> EventProblem:
        state, slip, piece, following = self.state, self.slip, self.piece, self.following
        mech, length, sigma, span, stop = state.mechanism, state.length, self.sigma, self.span, self.stop

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

        return EventProblem(rates, observe, self.zero_scale, lambda _y: 6.0, self.atol)


def creep(state: State, sigma: int, *, following: bool) -> str:
    """Moves the state along the band's edge. Returns the cause of the end."""
    return Creep(state, sigma, following).run()
