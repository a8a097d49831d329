"""Angle, speed, inputs, mode and accounts of a simulation."""

from __future__ import annotations

from collections.abc import Sequence

from .arithmetic import Number, Polynomial, poly, poly_derivative, poly_zeros
from .kinematics import Kinematics
from .mechanism import Mechanism, Slip
from .parameters import FLOWS, PEAKS, Params, Refused
from .scene import Interval
from .segment import Flow


class State:
    """The mechanism at one instant of an interval, without any decision. Functions that decide (`stick`,
    `flank_choice`) read the state; functions of motion (`play`, `simulation`) change the state."""

    def __init__(self, params: Params, flow: Flow) -> None:
        self.flow, self.arithmetic = flow, flow.arithmetic
        number = self.arithmetic.number
        self.mechanism = Mechanism(params, self.arithmetic)
        self._ratios: tuple[Number, Number | None, Number | None] | None = None
        self.theta = self.mechanism.theta0
        self.omega = self.mechanism.omega0 if self.mechanism.inertial else number(0)
        self.slip: Slip | None = None
        self.follow: Number | None = None  # rad/s, speed along the band edge in quasi-static motion
        self.rest_until = number(0)
        self.mode = 0
        self.events = 0
        self.account = {name: number(0) for name in (*FLOWS, "heat_stop")}
        self.peak = {name: number(0) for name in PEAKS}
        self.doubts: list[str] = []
        self.snapping = False  # theta is at an angle beyond which the band's edge falls
        self.stored = self.stored_energy()

    def set_inputs(self, interval: Interval) -> None:
        number = self.arithmetic.number
        self.t, self.length = number(0), number(interval.duration)
        self.tau = interval.coefficients("tau", number)
        self.f_ext = interval.coefficients("F_ext", number)

    def tau_at(self, t: Number) -> Number:
        return poly(self.tau, t)

    def f_ext_at(self, t: Number) -> Number:
        return poly(self.f_ext, t)

    def extremes(self, c: Polynomial, a: Number, b: Number) -> list[Number]:
        """The ends of (a, b) and the times between at which polynomial c turns."""
        return [a, b, *(poly_zeros(poly_derivative(c), a, b) if len(c) > 2 else [])]

    def input_sizes(self) -> tuple[Number, Number]:
        """Upper bounds of |tau| and |F_ext| in the interval: a value within rounding of these counts as
        zero."""
        tau, f_ext = (poly([abs(u) for u in c], self.length) for c in (self.tau, self.f_ext))
        return tau, f_ext

    def stored_energy(self) -> Number:
        kin = self.mechanism.groove.at(self.theta)
        return self.mechanism.spring_energy(kin.z) + self.mechanism.kinetic_energy(kin, self.omega)

    def note_reactions(self, reactions: Sequence[Number]) -> None:
        for i, reaction in enumerate(reactions, start=1):
            self.peak[f"reaction{i}"] = max(self.peak[f"reaction{i}"], reaction)

    def note_rest(self, a: Number, b: Number) -> None:
        """Peak reactions of a rest from time a to b."""
        mech = self.mechanism
        kin = mech.groove.at(self.theta)
        for t in self.extremes(self.f_ext, a, b):
            shared = mech.shared(kin, mech.spring_force(kin.z) + self.f_ext_at(t))
            self.note_reactions(mech.reactions(kin, *shared))

    def set_mode(self, mode: int) -> None:
        self.events += mode != self.mode
        self.mode = mode

    def band_ratios(self) -> tuple[Number, Number | None]:
        """Ratios of the band's edges at the present angle, for F_0 > 0: loading, releasing."""
        if self._ratios is None or self._ratios[0] is not self.theta or self.mechanism.is_loaded:
            kin = self.mechanism.groove.at(self.theta)
            f0 = self.mechanism.spring_force(kin.z) + self.f_ext_at(self.t)
            up, down = (self.mechanism.static_ratio(kin, direction, f0) for direction in (+1, -1))
            self._ratios = self.theta, up, down
        if self._ratios[1] is None:
            raise Refused("loading jam")
        return self._ratios[1], self._ratios[2]

    def band_ratio(self, direction: int) -> Number | None:
        return self.band_ratios()[direction < 0]

    def is_straight(self) -> bool:
        """Is the edge torque linear in theta, and are the inputs linear in time?"""
        return self.mechanism.linear and max(len(self.tau), len(self.f_ext)) <= 2

    def f0_at(self, kin: Kinematics, t: Number) -> Number:
        return self.mechanism.spring_force(kin.z) + self.f_ext_at(t)
