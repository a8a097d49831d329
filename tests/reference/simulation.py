"""Simulation of a scene: the decisions between the segments of motion."""

from __future__ import annotations

from collections.abc import Sequence

from .arithmetic import Number, poly, poly_derivative, poly_shift, sign
from .band_edge import edge_slopes
from .closed_form import ExactFlow
from .flank_choice import ahead, choose_flanks
from .mechanism import Flanks, Slip
from .numerical import OdeFlow
from .parameters import ENERGIES, FLOWS, HEATS, LOADING, PEAKS, RELEASING, Params, Refused
from .play import follow_curve, follow_ramp, jump
from .scene import Interval, Point
from .segment import Flow, Segment
from .state import State
from .stick import rest


class Simulation(State):
    """The mechanism between events: rest, sliding (a Flow), or following the band edge without inertia."""

    def __init__(self, params: Params, flow: Flow, first: Interval) -> None:
        super().__init__(params, flow)
        self._start(first)
        self._begin(first)

    def _start(self, first: Interval) -> None:
        """The mode before t = 0: nothing has moved yet, and rates of the inputs are not known yet."""
        self.set_inputs(Interval(first.duration, first.tau, F_ext=first.F_ext))
        if self.omega != 0:
            self.mode = LOADING if self.omega > 0 else RELEASING
        else:
            mode, sigma, _ = rest(self)
            self.mode = mode or (LOADING if sigma > 0 else RELEASING)

    def _begin(self, interval: Interval) -> None:
        self.set_inputs(interval)
        if abs(self.omega) <= self.arithmetic.still * self.peak["omega"]:
            self.omega *= 0
        self._decide()

    def _decide(self) -> None:
        """Chooses what happens from self.t on: sets slip, follow or rest_until, and the mode."""
        mech = self.mechanism
        self.follow = None
        if mech.inertial and self.omega != 0:
            sigma = sign(self.omega)
            present = self.slip.e if self.slip is not None and self.slip.sigma == sigma else None
            if self.theta >= mech.upper if sigma > 0 else self.theta <= mech.lower:
                self.set_mode(LOADING if sigma > 0 else RELEASING)
                self._impact()
                return
            self._enter(sigma, present)
            return
        mode, sigma, until = rest(self)
        if sigma == 0:
            self._settle(mode, until)
            return
        if mech.inertial or mech.viscous(sigma):
            self._enter(sigma, None)
            return
        self.set_mode(LOADING if sigma > 0 else RELEASING)  # a jump counts as motion
        jump(self, sigma)
        self._after_jump()

    def _after_jump(self) -> None:
        """Without inertia, on the band's edge or at a stop: stay, or go on as the inputs change."""
        mech = self.mechanism
        mode, sigma, until = rest(self)
        kin, tau, f_ext = mech.groove.at(self.theta), self.tau_at(self.t), self.f_ext_at(self.t)
        f0, size = mech.spring_force(kin.z) + f_ext, mech.force_scale(kin, f_ext)
        up, down = self.band_ratios()
        if down is not None and abs((up - down) * f0) < 1e-12 * up * size:
            self.doubts.append("stick band without width")
        if sigma == 0:
            self._settle(mode, until)
            return
        if mech.viscous(sigma):  # this direction is opposite to that of the jump
            self._enter(sigma, None)
            return
        # theta is on the band edge and the ramp continues: theta follows the edge
        self.set_mode(LOADING if sigma > 0 else RELEASING)
        if self.is_straight():
            rounding = self.arithmetic.tiny * (abs(self.tau[0]) + abs(self.tau[1] * self.length))
            ratio = self.band_ratio(sigma * (sign(self.tau[1]) if abs(tau) <= rounding else sign(tau)))
            if ratio is None or mech.spring[1] == 0:
                raise Refused("no quasi-static motion")
            speed = (self.tau[1] / ratio - self.f_ext[1]) / (mech.spring[1] * kin.dz)
        else:
            drive, rise = edge_slopes(self, sigma)
            speed = drive / rise if rise > 0 else 0.0
        if sign(speed) != sigma:
            raise Refused("no quasi-static motion")
        self.slip, self.follow, self.omega = None, speed, speed

    def _settle(self, mode: int, until: Number) -> None:
        self.slip, self.omega, self.rest_until = None, self.omega * 0, until
        self.set_mode(mode)

    def _enter(
        self, sigma: int, present: Flanks | None, crossed: Flanks | None = None, *, crossing: bool = False
    ) -> None:
        slip = choose_flanks(self, sigma, present, crossed, crossing)
        if slip is None:
            if not self.mechanism.inertial:
                raise Refused("no consistent flanks")
            raise Refused("moving wedge" if self.omega != 0 else "no consistent flanks")
        self.slip = slip
        self.set_mode(LOADING if sigma > 0 else RELEASING)

    def run(self, interval: Interval, first: bool) -> Point:
        if not first:
            self.doubts = []
            self._begin(interval)
        for t in self.extremes(self.tau, self.arithmetic.number(0), self.length):
            self.peak["torque"] = max(self.peak["torque"], abs(self.tau_at(t)))
        for _ in range(5000):
            if self.slip is not None:
                done = self._slide()
            elif self.follow is not None:
                done = self._follow_edge()
            else:
                self.note_rest(self.t, self.rest_until)
                self.t = self.rest_until
                done = self.t >= self.length
                if not done:
                    self._decide()
            if done:
                return self._point()
        raise ArithmeticError("events do not end")

    def _slide(self) -> bool:
        mech, slip = self.mechanism, self.slip
        assert slip is not None
        kin = mech.groove.at(self.theta)
        load_sign = 1
        if not mech.inertial:
            f0 = mech.spring_force(kin.z) + self.f_ext_at(self.t)
            if abs(f0) <= self.arithmetic.tiny * mech.force_scale(kin, self.input_sizes()[1]):
                now, _, _ = ahead(self, slip)
                rate = poly(poly_derivative(self.f_ext), self.t)
                f0 = (mech.spring_slope(kin.z) * kin.dz * now.omega + rate) or f0 * 0 + slip.sigma
            load_sign = sign(f0) or slip.sigma
            if self.band_ratio(slip.sigma * load_sign) is None:
                raise Refused("moving wedge")
        segment = Segment(
            slip,
            self.theta,
            self.omega,
            poly_shift(self.tau, self.t),
            poly_shift(self.f_ext, self.t),
            self.length - self.t,
            mech.upper if slip.sigma > 0 else mech.lower,
            load_sign,
        )
        out = self.flow.advance(mech, segment)
        self.t += out.time
        self.theta, self.omega = out.theta, out.omega
        for name, value in zip(FLOWS, out.flows, strict=True):
            self.account[name] += value
        self.peak["omega"] = max(self.peak["omega"], out.peak_omega)
        self.note_reactions(out.peak_reactions)
        if out.peak_omega < 1e-11 * self.peak["omega"]:
            self.doubts.append("speed within rounding")
        if abs(self.length - self.t) < 1e-12 * self.length and "end" not in out.causes:
            self.doubts.append("event at the end of the interval")
        if len(out.causes & {"rest", "stop", "kink"}) > 1:
            self.doubts.append("two switches at once")
        if "end" in out.causes:
            if abs(self.omega) < 1e-10 * self.peak["omega"]:
                self.doubts.append("speed within rounding")
            return True
        if "stop" in out.causes:
            self.theta = segment.stop
        if "rest" in out.causes:
            self.omega = self.omega * 0
        if mech.inertial and self.omega != 0:
            if "stop" in out.causes:
                self._impact()
            else:
                self._cross(slip, out.causes)
            return False
        self.omega = self.omega * 0
        self._decide()
        if mech.inertial and self.slip is not None and self.slip.sigma == slip.sigma:
            self.doubts.append("speed grazes zero")
        return False

    def _follow_edge(self) -> bool:
        ended = follow_ramp(self) if self.is_straight() else follow_curve(self)
        if ended == "fold":
            self._after_jump()
        elif ended != "end":
            self._decide()
        return ended == "end"

    def _cross(self, slip: Slip, causes: set[str]) -> None:
        """A contact load has vanished: this contact changes its flank. Both have vanished: flanks are chosen
        anew."""
        flipped = None
        if not {"cross1", "cross2"} <= causes:
            flipped = (-slip.e[0], slip.e[1]) if "cross1" in causes else (slip.e[0], -slip.e[1])
        self._enter(slip.sigma, None, flipped, crossing=True)

    def _impact(self) -> None:
        mech = self.mechanism
        kin = mech.groove.at(self.theta)
        before = mech.kinetic_energy(kin, self.omega)
        self.omega = -mech.restitution * self.omega
        self.slip = None
        if self.omega != 0:
            self._enter(sign(self.omega), None)
            assert self.slip is not None
            load = mech.load(kin, self.slip, self.omega, self.tau_at(self.t), self.f_ext_at(self.t))
            reach = max(abs(self.theta), mech.upper - mech.lower)
            if load.alpha * self.omega < 0 and self.omega**2 < 2 * abs(load.alpha) * reach * 2.0**-53:
                self.doubts.append("bounces within rounding")
                self.omega = self.omega * 0
        self.account["heat_stop"] += before - mech.kinetic_energy(kin, self.omega)
        if self.omega == 0:
            self._decide()

    def _point(self) -> Point:
        mech = self.mechanism
        kin = mech.groove.at(self.theta)
        if self.slip is None and self.follow is None:
            self.note_rest(self.length, self.length)
        energy = {name: value for name, value in self.account.items()}
        energy["work_tuning"] = self.omega * 0
        energy["spring"] = mech.spring_energy(kin.z)
        energy["kinetic"] = mech.kinetic_energy(kin, self.omega)
        heat = sum(energy[name] for name in HEATS)
        energy["residual"] = (
            energy["work_in"] - energy["work_ext"] - heat - (self.stored_energy() - self.stored)
        )
        return Point(
            float(self.theta),
            float(self.omega),
            float(kin.z),
            float(kin.dz * self.omega),
            self.mode,
            self.events,
            {name: float(energy[name]) for name in ENERGIES},
            {name: float(self.peak[name]) for name in PEAKS},
            self.doubts,
        )


def _simulate(params: Params, intervals: Sequence[Interval], flow: Flow) -> list[Point]:
    simulation = Simulation(params, flow, intervals[0])
    return [simulation.run(interval, first=i == 0) for i, interval in enumerate(intervals)]


def simulate(params: Params, intervals: Sequence[Interval], rtol: float = 1e-13) -> list[Point]:
    """Integrates numerically, in double precision. One Point at the end of each interval."""
    return _simulate(params, intervals, OdeFlow(rtol))


def simulate_exact(params: Params, intervals: Sequence[Interval]) -> list[Point]:
    """Solves in closed form at 60 digits. One Point at the end of each interval."""
    return _simulate(params, intervals, ExactFlow())
