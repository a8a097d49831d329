"""One segment of motion on given flanks: steps with a dense solution, and the first event of its guards."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq, minimize_scalar

from .mechanics import Mechanism, Motion, Pair, Unresolved

RTOL = 1e-12
MOST_STEPS = 30_000
STIFF = 2e4  # decay rate times duration from which the implicit method is the cheaper one
GUARDS = ("rest", "x1", "x2", "stop", "mass")

State = tuple[float, float]  # theta, omega
Dense = Callable[[float], State]
Polynomial = Sequence[float]
Row = Sequence[float]  # one number for each guard


class Step(NamedTuple):
    start: float
    end: float
    at: Dense


def value(polynomial: Polynomial, t: float) -> float:
    result = 0.0
    for c in reversed(polynomial):
        result = result * t + c
    return result


class Slide:
    """Motion along sigma on the flanks e, under inputs that are polynomials in the time of their interval."""

    def __init__(self, mechanism: Mechanism, sigma: int, e: Pair, tau: Polynomial, f_ext: Polynomial) -> None:
        self.mechanism, self.sigma, self.e, self.tau, self.f_ext = mechanism, sigma, e, tau, f_ext

    def motion(self, t: float, state: State) -> Motion:
        mech, (theta, omega) = self.mechanism, state
        return mech.motion(
            mech.at(theta), self.sigma, self.e, omega, value(self.tau, t), value(self.f_ext, t)
        )

    def guards(self, t: float, state: State) -> tuple[float, ...]:
        """One number for each of GUARDS, positive while the segment lasts. The reactions' are in units of
        the largest terms they are sums of."""
        mech, sigma = self.mechanism, self.sigma
        now = self.motion(t, state)
        stop = mech.upper - state[0] if sigma > 0 else state[0] - mech.lower
        reactions = (
            e * x / size if law.kinetic + law.viscous > 0 and size > 0 else 1.0
            for e, x, size, law in zip(
                self.e, (now.x1, now.x2), (now.size1, now.size2), mech.laws, strict=True
            )
        )
        return sigma * now.omega, *reactions, stop, now.share

    def rhs(self, t: float, y: np.ndarray) -> list[float]:
        """NaN well beyond the stops, where a trial step is too long."""
        mech = self.mechanism
        margin = 0.1 * (mech.upper - mech.lower)
        if not mech.lower - margin <= y[0] <= mech.upper + margin:
            return [math.nan] * len(y)
        now = self.motion(t, (float(y[0]), float(y[1]) if len(y) > 1 else 0.0))
        return [now.omega, now.alpha] if self.mechanism.inertial else [now.omega]

    def steps(self, t: float, end: float, state: State) -> Iterator[Step]:
        return self._series(t, end, state) if self.mechanism.linear else self._integrated(t, end, state)

    def _integrated(self, t: float, end: float, state: State) -> Iterator[Step]:
        inertial = self.mechanism.inertial
        start = np.array(state if inertial else state[:1])
        speed = max(abs(state[1]), 1e-3)
        method = Radau if self._decay(t, state) * (end - t) > STIFF else DOP853
        atol = np.array([1e-15, 1e-14 * speed])[: len(start)]
        solver = method(self.rhs, t, start, end, rtol=RTOL, atol=atol, max_step=(end - t) / 4)
        while solver.status == "running":
            solver.step()
            if solver.status == "failed":
                raise Unresolved("the integrator fails")
            dense = solver.dense_output()

            def at(time: float, dense: Callable[[float], np.ndarray] = dense) -> State:
                y = dense(time)
                return float(y[0]), float(y[1]) if inertial else 0.0

            yield Step(solver.t_old, solver.t, at)

    def _decay(self, t: float, state: State) -> float:
        """1/s, how fast a disturbance of the speed (without inertia: of the angle) decays."""
        theta, omega = state
        if self.mechanism.inertial:
            h = 1e-6 * (abs(omega) + 1e-3)
            return -(self.motion(t, (theta, omega + h)).alpha - self.motion(t, state).alpha) / h
        h = 1e-7
        return -(self.motion(t, (theta + h, 0.0)).omega - self.motion(t, state).omega) / h

    def _series(self, t: float, end: float, state: State) -> Iterator[Step]:
        """Helices under linear forces: in each step a Taylor series, to rounding."""
        rows = self._linear_rows()
        rate = sum(abs(c) ** (1 / (len(rows) - k)) for k, c in enumerate(rows))
        length = 1.0 / rate if rate > 0 else math.inf
        while t < end:
            h = min(length, (end - t))
            coefficients = self._coefficients(t, state, rows)

            def at(time: float, start: float = t, c: Sequence[float] = coefficients) -> State:
                s = time - start
                theta = omega = 0.0
                for k in range(len(c) - 1, 0, -1):
                    theta = (theta + c[k]) * s
                    omega = omega * s + k * c[k]
                return theta + c[0], omega

            last = end if h == end - t else t + h
            yield Step(t, last, at)
            state, t = at(last), last

    def _linear_rows(self) -> list[float]:
        """Factors of theta (and omega) in alpha (or omega): differences are exact on a linear balance."""
        zero = Slide(self.mechanism, self.sigma, self.e, (0.0,), (0.0,))
        pick = (lambda now: now.alpha) if self.mechanism.inertial else (lambda now: now.omega)
        origin = pick(zero.motion(0.0, (0.0, 0.0)))
        rows = [pick(zero.motion(0.0, (1.0, 0.0))) - origin]
        if self.mechanism.inertial:
            rows.append(pick(zero.motion(0.0, (0.0, float(self.sigma)))) - origin)
            rows[1] *= self.sigma
        return rows

    def _coefficients(self, t: float, state: State, rows: list[float]) -> list[float]:
        """Taylor coefficients of theta about t."""
        order = len(rows)
        c = list(state[:order])
        for k in range(20):
            drive = self._drive(t, k, state) if k < 4 else 0.0
            total = drive + sum(row * c[k + j] * _rising(k, j) for j, row in enumerate(rows))
            c.append(total / _rising(k, order))
        return c

    def _drive(self, t: float, k: int, state: State) -> float:
        """Coefficient k in time of what alpha (or omega) would be at theta = omega = 0."""
        shifted = [_shifted(p, t, k) for p in (self.tau, self.f_ext)]
        mech = self.mechanism
        now = mech.motion(mech.at(0.0), self.sigma, self.e, 0.0, *shifted)
        if k == 0:
            return now.alpha if mech.inertial else now.omega
        none = mech.motion(mech.at(0.0), self.sigma, self.e, 0.0, 0.0, 0.0)
        return now.alpha - none.alpha if mech.inertial else now.omega - none.omega

    def first_event(self, t: float, end: float, state: State) -> tuple[float, State, str]:
        """Where the first guard passes zero, and its name; "end" at the end of the interval."""
        row: Row = self.guards(t, state)
        for count, step in enumerate(self.steps(t, end, state)):
            if count > MOST_STEPS:
                raise Unresolved("too many steps")

            def guards(time: float, step: Step = step) -> tuple[float, ...]:
                return self.guards(time, step.at(time))

            found, row = first_crossing(guards, step.start, step.end, row)
            if found is not None:
                time, index = found
                return time, state if time == t else step.at(time), GUARDS[index]
            last = step
        return end, last.at(end), "end"


def _rising(k: int, j: int) -> int:
    """(k + 1) ... (k + j)"""
    return 1 if j == 0 else k + 1 if j == 1 else (k + 1) * (k + 2)


def _shifted(polynomial: Polynomial, t: float, k: int) -> float:
    """Coefficient k of the polynomial about t."""
    return sum(math.comb(i, k) * c * t ** (i - k) for i, c in enumerate(polynomial) if i >= k)


PLACES = (1e-3, 1 / 3, 2 / 3, 1 - 1e-3, 1.0)  # samples of a step, those next to its ends for the slopes there


def first_crossing(
    f: Callable[[float], Row], start: float, end: float, row: Row
) -> tuple[tuple[float, int] | None, Row]:
    """The first time at which a component of f becomes negative, with its index; and f at the end. `row`: f
    at the start, where a component that is not positive counts as zero. Between samples a dip is looked for
    where the samples have a valley."""
    times = [start, *(start + (end - start) * place for place in PLACES[:-1]), end]
    rows = [row, *map(f, times[1:])]
    best: tuple[float, int] | None = None
    for i in range(len(row)):

        def component(t: float, i: int = i) -> float:
            return f(t)[i]

        found = _first_of_one(component, times, [r[i] for r in rows])
        if found is not None and (best is None or found < best[0]):
            best = found, i
    return best, rows[-1]


def _first_of_one(f: Callable[[float], float], times: list[float], values: list[float]) -> float | None:
    for k in range(1, len(times)):
        if k >= 2 and values[k - 1] <= min(values[k], values[k - 2]):
            dip = _dip(f, times[k - 2 : k + 1], values[k - 2 : k + 1])
            if dip is not None:
                return _descent(f, times[k - 2], dip, values[k - 2])
        if not values[k] >= 0:
            return _descent(f, times[k - 1], times[k], values[k - 1])
    return None


def _dip(f: Callable[[float], float], times: list[float], values: list[float]) -> float | None:
    """A time at which f is negative near its valley, which lies less deep below the middle sample than
    either neighbour's slope would lead in the other cell."""
    (t0, t1, t2), (left, middle, right) = times, values
    if (
        not t0 < t1 < t2
        or middle < 0
        or middle > max((left - middle) / (t1 - t0) * (t2 - t1), (right - middle) / (t2 - t1) * (t1 - t0))
    ):
        return None
    found = minimize_scalar(f, bounds=(t0, t2), method="bounded", options={"xatol": (t2 - t0) * 1e-7})
    return float(found.x) if found.fun < 0 else None


def _descent(f: Callable[[float], float], low: float, high: float, at_low: float) -> float:
    """The zero between low, where f >= 0, and high, where f < 0, to rounding."""
    at_high = f(high)
    if math.isnan(at_high):
        raise Unresolved("the balance has no answer")
    if at_high >= 0:
        return high
    if at_low <= 0:
        inner = next(
            (low + (high - low) * 0.5**k for k in range(1, 46) if f(low + (high - low) * 0.5**k) > 0), None
        )
        if inner is None:
            return low
        low = inner
    try:
        return float(brentq(f, low, high, xtol=1e-17 + 4e-16 * abs(high), rtol=9e-16))
    except ValueError:  # one end is the zero: a pin found from another start differs by rounding
        return min((low, high), key=lambda t: abs(f(t)))
