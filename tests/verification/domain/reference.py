"""The forward dynamics of docs/mechanism.md solved from event to event, with the documented rule for the
pair of flanks. An independent judge of the FMU: nothing here is taken from its code."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from .flow import Slide, first_crossing, value
from .mechanics import PAIRS, ROUNDING, Mechanism, Motion, Pair, Place, Unresolved

NEVER = -1e300
STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP, WEDGED = range(1, 7)
MOST_EVENTS = 2000
SAMPLES = 16  # cells in which a stick's end is looked for
GRID = 256  # cells in which a quasi-static motion's end is looked for


@dataclass(frozen=True)
class Interval:
    """Inputs over `duration` s: coefficients of powers of the time since its start, N.m and N."""

    duration: float
    tau: tuple[float, ...]
    f_ext: tuple[float, ...] = (0.0,)


class Point(NamedTuple):
    """What the FMU must show at the end of an interval."""

    theta: float
    omega: float
    mode: int
    events: int
    energy: float  # J, spring and kinetic
    doubtful: bool  # bounces below rounding, or jumps of the play: the count of events is open


class Ambiguous(Exception):
    """Several pairs carry, in a design that should have one answer."""


class Simulation:
    """The state between events. `unique`: any pair that agrees is the answer, and no second one may."""

    def __init__(self, params: Mapping[str, Any], unique: bool) -> None:
        self.mechanism, self.unique = Mechanism(params), unique
        self.theta, self.omega = self.mechanism.theta0, self.mechanism.omega0
        self.slide: Slide | None = None
        self.mode, self.events, self.doubtful, self.speed = 0, 0, False, abs(self.omega)

    def run(self, intervals: Sequence[Interval]) -> list[Point]:
        self._start(intervals[0])
        return [self._interval(interval, index) for index, interval in enumerate(intervals)]

    def _start(self, first: Interval) -> None:
        """The mode before time 0, of the inputs' values there."""
        self._set_inputs(Interval(first.duration, first.tau[:1], first.f_ext[:1]))
        if self.mechanism.inertial and self.omega != 0:
            sigma = int(math.copysign(1, self.omega))
            carried = self._carrying(0.0, sigma, None, PAIRS) is not None
            self.mode = self._moving_mode(sigma) if carried else WEDGED
            self.omega *= carried
            return
        sigma, mode = self._side_at_rest(0.0)
        self.mode = mode if sigma == 0 else self._moving_mode(sigma)

    @staticmethod
    def _moving_mode(sigma: int) -> int:
        return LOADING if sigma > 0 else RELEASING

    def _set_mode(self, mode: int) -> None:
        self.events += mode != self.mode
        self.mode = mode

    def _set_inputs(self, interval: Interval) -> None:
        self.tau, self.f_ext, self.duration = interval.tau, interval.f_ext, interval.duration

    def _interval(self, interval: Interval, index: int) -> Point:
        old = (value(self.tau, self.duration), value(self.f_ext, self.duration)) if index else None
        self._set_inputs(interval)
        jump = old != (self.tau[0], self.f_ext[0])
        mech = self.mechanism
        if mech.inertial or mech.damped:
            self._play_events(jump)
        else:
            self._follow_band()
        k = mech.at(self.theta)
        energy = mech.spring_energy(k.z) + mech.kinetic_energy(k, self.omega)
        return Point(self.theta, self.omega, self.mode, self.events, energy, self.doubtful)

    # motion with inertia or damping

    def _play_events(self, jump: bool) -> None:
        t, first = 0.0, self.slide.e if self.slide is not None else None
        moving = self.slide is not None if not self.mechanism.inertial else self.omega != 0
        if moving and (jump or self.slide is None or not self.mechanism.inertial):
            sigma = self._sigma()
            if self.mechanism.inertial or self._goes_on(sigma):
                self._slip(t, sigma, first)
            else:
                self._rest_or_leave(t)
        elif moving:
            self._slip(t, self._sigma(), first)
        else:
            self._rest_or_leave(t)
        for _ in range(MOST_EVENTS):
            t = self._advance(t)
            if t >= self.duration:
                return
        raise Unresolved("events without end")

    def _sigma(self) -> int:
        return self.slide.sigma if self.slide is not None else int(math.copysign(1, self.omega))

    def _goes_on(self, sigma: int) -> bool:
        """Without inertia: do the inputs still drive the motion along sigma?"""
        return self._side_at_rest(0.0)[0] == sigma

    def _advance(self, t: float) -> float:
        """To the next event, which is answered, or to the interval's end."""
        if self.slide is None:
            return self._stand(t)
        slide = self.slide
        t, (self.theta, self.omega), cause = slide.first_event(t, self.duration, (self.theta, self.omega))
        self.speed = max(self.speed, abs(self.omega))
        if cause == "rest":
            self._rest_or_leave(t)
        elif cause == "stop":
            self._impact(t)
        elif cause in ("x1", "x2"):
            self._flip(t, slide)
        elif cause == "mass":
            self._slip(t, slide.sigma, None)
        if not self.mechanism.inertial and self.slide is not None:
            self.omega = self.slide.motion(t, (self.theta, 0.0)).omega
        return t

    def _flip(self, t: float, slide: Slide) -> None:
        """The reactions that are zero change their flanks. By Cramer's rule x_i is a number that does not
        depend on e_i, over D: after its zero it lies on the other flank if D keeps its sign. Where both are
        zero (I = 0 and the load passes zero) x_1 is in proportion to n_2/D and x_2 to n_1/D."""
        now = slide.motion(t, (self.theta, self.omega))
        zero = [abs(x) <= 1e-6 * size for x, size in ((now.x1, now.size1), (now.x2, now.size2))]
        first = (-slide.e[0] if zero[0] else slide.e[0], -slide.e[1] if zero[1] else slide.e[1])
        terms = {e: self._terms(slide, t, e) for e in PAIRS}
        if all(zero):
            n1, n2, mass = terms[slide.e]
            after = -slide.e[0] * n2 * mass, -slide.e[1] * n1 * mass
            after = (after[0] or after[1],) * 2
            leaving = [
                e
                for e, (m1, m2, d) in terms.items()
                if e[0] * m2 * d * after[0] >= 0 <= e[1] * m1 * d * after[0]
            ]
        else:
            same = terms[first][2] * terms[slide.e][2] > 0
            leaving = [e for e in PAIRS if e != slide.e and (same or e != first)]
        self._slip(t, slide.sigma, first, leaving)

    def _terms(self, slide: Slide, t: float, e: Pair) -> tuple[float, float, float]:
        """n_1, n_2 and D of a pair."""
        mech, k = self.mechanism, self.mechanism.at(self.theta)
        sigma, v = slide.sigma, k.dz * self.omega
        axial = mech.spring_force(k.z) + value(self.f_ext, t) + mech.damper_force(sigma, v)
        mu1, mu2 = mech.friction(k, abs(self.omega), axial)
        f1, f2 = sigma * e[0] * mu1, sigma * e[1] * mu2
        c, q = mech.damper[sigma]
        parts = (mech.J, mech.m, mech.I) if mech.inertial else (mech.b, c + 2 * q * abs(v), 0.0)
        n1, n2, *_ = mech.corner(k, f1, f2)
        return n1, n2, mech.inertia(k, f1, f2, parts)

    def _slip(self, t: float, sigma: int, first: Pair | None, among: Sequence[Pair] = PAIRS) -> None:
        """Motion along sigma on the first pair in the documented order that carries; none: wedged."""
        e = self._carrying(t, sigma, first, among)
        if e is None:
            moved = self.omega != 0
            self.slide, self.omega = None, 0.0
            self._set_mode(WEDGED)
            if moved:  # the rule begins anew, from rest; where F_0 turns, its coming sign counts
                side, mode = self._side_at_rest(t + 1e-9 * self.duration)
                if side == 0:
                    self._set_mode(mode)
                else:
                    self._leave(t, side)
            return
        self.slide = Slide(self.mechanism, sigma, e, self.tau, self.f_ext)
        self._set_mode(self._moving_mode(sigma))

    def _carrying(self, t: float, sigma: int, first: Pair | None, among: Sequence[Pair]) -> Pair | None:
        mech, k = self.mechanism, self.mechanism.at(self.theta)
        inputs = value(self.tau, t), value(self.f_ext, t)
        axial = mech.spring_force(k.z) + inputs[1] + mech.damper_force(sigma, k.dz * self.omega)
        side = 1 if axial > 0 or (axial == 0 and sigma > 0) else -1
        order = [first] if first is not None else []
        order += [e for e in ((side * g, side * h) for g, h in PAIRS) if e not in order]
        near = ROUNDING * self._torque_size(k, t)
        carried = [
            (e, now)
            for e in order
            if self._agrees(now := mech.motion(k, sigma, e, self.omega, *inputs), e, sigma, near)
        ]
        if self.unique and mech.inertial:
            self._check_unique(carried)
        return next((e for e, _ in carried if e in among), None)

    def _agrees(self, now: Motion, e: Pair, sigma: int, near: float) -> bool:
        """Each reaction on its flank, to rounding; D/Delta > 0; from rest the motion goes along sigma.
        `near`: N.m, a torque that is rounding."""
        if not now.share > 0:
            return False
        flanks = zip(e, (now.x1, now.x2), (now.size1, now.size2), self.mechanism.laws, strict=True)
        if any(x * g < -ROUNDING * size and law.kinetic + law.viscous > 0 for g, x, size, law in flanks):
            return False
        if self.mechanism.inertial and self.omega != 0:
            return True
        return sigma * (now.alpha if self.mechanism.inertial else now.omega) * now.share >= -near

    @staticmethod
    def _check_unique(carried: list[tuple[Pair, Motion]]) -> None:
        if not carried:
            raise Ambiguous("no pair of flanks carries")
        scale = max(abs(now.alpha) for _, now in carried)
        if max(now.alpha for _, now in carried) - min(now.alpha for _, now in carried) > 1e-8 * scale:
            raise Ambiguous("pairs of flanks carry that differ")

    def _impact(self, t: float) -> None:
        mech = self.mechanism
        self.theta = mech.upper if self._sigma() > 0 else mech.lower
        before, self.omega = self.omega, -mech.restitution * self.omega
        if not mech.inertial or self.omega == 0:
            self._rest_or_leave(t)
            return
        self._slip(t, -int(math.copysign(1, before)), None)
        if self.slide is not None:
            back = self.slide.motion(t, (self.theta, self.omega)).alpha
            span = max(abs(self.theta), mech.upper - mech.lower)
            if back * self.omega < 0 and self.omega**2 < 2 * abs(back) * span * 2.0**-53:
                self.doubtful = True
                self._rest_or_leave(t)

    # rest

    def _gaps(self, k: Place, t: float) -> tuple[float, float]:
        """T_load - tau and tau - T_release."""
        mech, tau = self.mechanism, value(self.tau, t)
        f0 = mech.spring_force(k.z) + value(self.f_ext, t)
        load, release = (mech.edge_pair(k, sigma, f0) for sigma in (1, -1))
        return (
            math.inf if load is None else load[1] - tau,
            math.inf if release is None else tau - release[1],
        )

    def _torque_size(self, k: Place, t: float) -> float:
        spring = sum(abs(c) * max(abs(k.z), 1e-3) ** i for i, c in enumerate(self.mechanism.spring))
        largest = max(abs(k.dz), 0.01 * self.mechanism.r1)
        return abs(value(self.tau, t)) + largest * (spring + abs(value(self.f_ext, t))) + 1e-12

    def _side_at_rest(self, t: float) -> tuple[int, int]:
        """(sigma, 0) where the inputs lead out of the stick band, (0, mode) where they do not."""
        mech, k = self.mechanism, self.mechanism.at(self.theta)
        load, release = self._gaps(k, t)
        near = 1e-13 * self._torque_size(k, t)
        if load < -near:
            return (0, UPPER_STOP) if self.theta >= mech.upper else (1, 0)
        if release < -near:
            return (0, LOWER_STOP) if self.theta <= mech.lower else (-1, 0)
        into, soon = (self._into_lock(k, time) for time in (t, t + 1e-9 * self.duration))
        wedged = into > near or (abs(into) <= near and soon > max(into, 0.0))  # its rate decides a tie
        return 0, WEDGED if wedged else STICK

    def _into_lock(self, k: Place, t: float) -> float:
        """The torque beyond the frictionless one toward an infinite edge of the band; NEVER: no edge is."""
        load, release = self._gaps(k, t)
        towards = value(self.tau, t) - k.dz * (self.mechanism.spring_force(k.z) + value(self.f_ext, t))
        return max(towards if load == math.inf else NEVER, -towards if release == math.inf else NEVER)

    def _rest_or_leave(self, t: float) -> None:
        sigma, mode = self._side_at_rest(t)
        self.slide, self.omega = None, 0.0
        if sigma == 0:
            self._set_mode(mode)
            return
        self._leave(t, sigma)

    def _leave(self, t: float, sigma: int) -> None:
        mech, k = self.mechanism, self.mechanism.at(self.theta)
        edge = mech.edge_pair(k, sigma, mech.spring_force(k.z) + value(self.f_ext, t))
        self._slip(t, sigma, None if edge is None else edge[0])

    def _stand(self, t: float) -> float:
        """At rest up to the next event: the torque leaves the band, or a stop."""
        k, mech = self.mechanism.at(self.theta), self.mechanism
        if max(len(self.tau), len(self.f_ext)) == 1:
            return self.duration
        near = 1e-12 * self._torque_size(k, t)
        if self.mode in (UPPER_STOP, LOWER_STOP):
            sign = 1 if self.mode == UPPER_STOP else -1

            def held(time: float) -> tuple[float, ...]:
                return (-self._gaps(k, time)[0 if sign > 0 else 1],)
        else:

            def held(time: float) -> tuple[float, ...]:
                into = self._into_lock(k, time)
                return *self._gaps(k, time), near + (into if self.mode == WEDGED else -into)

        row: Sequence[float] = held(t)
        width = (self.duration - t) / SAMPLES
        if self.mode == WEDGED and min(row[:2]) < 0:
            return self.duration
        row = tuple(0.0 if abs(gap) <= near else gap for gap in row)
        for cell in range(SAMPLES):
            end = self.duration if cell == SAMPLES - 1 else t + (cell + 1) * width
            found, row = first_crossing(held, t + cell * width, end, row)
            if found is None:
                continue
            time, index = found
            if len(row) == 1:
                self._leave_stop(time, near)
                return time
            if index == 2:
                # where F_0 crosses zero, the edge becomes finite as the torque leaves the band
                out, _ = first_crossing(lambda s: self._gaps(k, s), time, end, (0.0, 0.0))
                if out is None or out[0] > time + 1e-9 * self.duration:
                    self._set_mode(STICK if self.mode == WEDGED else WEDGED)
                    return time
                time, index = out
            sigma = 1 if index == 0 else -1
            if self.theta >= mech.upper if sigma > 0 else self.theta <= mech.lower:
                self._set_mode(UPPER_STOP if sigma > 0 else LOWER_STOP)
            else:
                self._leave(time, sigma)
            return time
        return self.duration

    def _leave_stop(self, t: float, near: float) -> None:
        """The torque no longer presses into the stop: the mechanism sticks, or moves where the band has no
        width."""
        sigma = -1 if self.mode == UPPER_STOP else 1
        gap = self._gaps(self.mechanism.at(self.theta), t)[0 if sigma > 0 else 1]
        if gap <= near:
            self._leave(t, sigma)
        else:
            self._set_mode(STICK)

    # neither inertia nor damping: the play

    def _follow_band(self) -> None:
        """theta moves just far enough that the torque is in the band. F_ext is constant in the interval, so
        that theta is monotone where tau is."""
        rate = np.polynomial.Polynomial(self.tau).deriv()
        turns = rate.roots().astype(complex) if len(self.tau) > 2 else np.zeros(0, complex)
        inner = sorted(float(r.real) for r in turns if abs(r.imag) < 1e-12 and 0 < r.real < self.duration)
        self._settle(0.0)
        for start, end in pairwise([0.0, *inner, self.duration]):
            moved = self.theta
            self._settle(end)
            self.doubtful = True
            if len(self.tau) > 1 and end > start and self.theta != moved and self.mode == STICK:
                self.mode = self._moving_mode(1 if self.theta > moved else -1)

    def _settle(self, t: float) -> None:
        sigma, mode = self._side_at_rest(t)
        if sigma == 0:
            self.mode = mode
            return
        mech, edge = self.mechanism, 0 if sigma > 0 else 1
        limit = mech.upper if sigma > 0 else mech.lower

        def gap(theta: float) -> float:
            return self._gaps(mech.at(theta), t)[edge]

        for a, b in pairwise(np.linspace(self.theta, limit, GRID + 1).tolist()):
            if gap(b) >= 0:
                self.theta = float(brentq(gap, a, b, xtol=1e-16)) if gap(b) < math.inf else a
                self.mode = STICK
                return
        self.theta, self.mode = limit, UPPER_STOP if sigma > 0 else LOWER_STOP


def solve(params: Mapping[str, Any], intervals: Sequence[Interval], unique: bool) -> list[Point]:
    """One Point at the end of each interval. Raises Unresolved or Ambiguous."""
    return Simulation(params, unique).run(intervals)


def nudged(params: Mapping[str, Any], by: float, signs: Iterator[int]) -> dict[str, Any]:
    """The design with each continuous number but angles of stops changed by the relative amount `by`."""
    fixed = ("stop.", "initial.theta")
    return {
        name: given * (1 + next(signs) * by)
        if isinstance(given, float) and not name.startswith(fixed)
        else given
        for name, given in params.items()
    }
