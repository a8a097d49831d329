"""Integration by DOP853 up to the first event."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar


class EventProblem(NamedTuple):
    """Smooth differential equations in one variable s, time or length of a path, and the events that end
    them."""

    rates: Callable[[float, np.ndarray], list[float]]  # dy/ds
    # event functions by name; |omega| and both reactions
    observe: Callable[[float, np.ndarray], tuple[dict[str, float], tuple[float, float, float]]]
    zero_scale: dict[str, float]  # event values below 1e-12 of this scale count as zero; 0: only 0 does
    fastest_rate: Callable[[np.ndarray], float]  # 1/s, limits the integrator's steps
    atol: np.ndarray  # absolute tolerance of each state

    def event(self, name: str, s: float, y: np.ndarray) -> float:
        return self.observe(s, y)[0][name]


class Peaks:
    """Largest |omega| and reactions, per contact, along the integrated motion."""

    def __init__(self) -> None:
        self.best = [0.0, 0.0, 0.0]

    def note(self, sizes: Iterable[float]) -> None:
        self.best = [max(best, size) for best, size in zip(self.best, sizes, strict=True)]


class Solver:
    """DOP853 between events. Events are bracketed on the dense output, then polished by Newton's method on
    the integrated motion. Peaks inside a step are found in the same manner."""

    samples = 8  # points of each step at which sign changes of the event functions are detected
    stiffness_limit = 1.5  # largest product of step and fastest rate

    def __init__(self, rtol: float) -> None:
        self.rtol = rtol

    def integrate_to_event(
        self, problem: EventProblem, s: float, y: np.ndarray, end: float, peaks: Peaks
    ) -> tuple[float, np.ndarray, str]:
        """From s to the first event or to `end`. Returns s, y and the name of the event, or "end"."""
        last, sizes = problem.observe(s, y)
        peaks.note(sizes)
        armed = {
            name: name in ("stop", "knot") or abs(value) > 1e-12 * problem.zero_scale[name]
            for name, value in last.items()
        }
        if end - s <= 1e-15 * end:
            return end, y, "end"
        solver = DOP853(problem.rates, s, y, end, rtol=self.rtol, atol=problem.atol)
        while solver.status == "running":
            # at the limit of stability the error estimate does not see the rest of the fast component
            solver.max_step = self.stiffness_limit / max(problem.fastest_rate(y), 1e-300)
            with np.errstate(invalid="ignore", divide="ignore"):  # an error estimate that underflows is 0/0
                message = solver.step()
            if solver.status == "failed":
                raise ArithmeticError(message)
            dense, start, stop = solver.dense_output(), float(solver.t_old), float(solver.t)
            begun = y
            y = np.array(solver.y)
            first: tuple[float, str] | None = None
            seen_at = [(start, sizes)]
            before = start
            for j in range(1, self.samples + 1):
                t = stop if j == self.samples else start + (stop - start) * j / self.samples
                seen, sizes = problem.observe(t, y if j == self.samples else dense(t))
                seen_at.append((t, sizes))
                for name, value in seen.items():
                    if not armed[name]:
                        armed[name] = abs(value) > 1e-12 * problem.zero_scale[name] and value != 0
                    elif last[name] * value < 0 or value == 0:
                        root = t
                        if value != 0:
                            root = self._dense_root(problem, dense, name, before, t)
                        if first is None or root < first[0]:
                            first = (root, name)
                last, before = seen, t
                if first is not None:
                    break
            if first is not None:
                s, y = self._polish(problem, first[1], first[0], start, begun)
                seen_at = [entry for entry in seen_at if entry[0] < s] + [(s, problem.observe(s, y)[1])]
                self._inner_peaks(problem, dense, seen_at, begun, peaks)
                return s, y, first[1]
            self._inner_peaks(problem, dense, seen_at, begun, peaks)
        return end, y, "end"

    @staticmethod
    def _dense_root(problem: EventProblem, dense: Callable, name: str, a: float, b: float) -> float:
        values = [problem.event(name, t, dense(t)) for t in (a, b)]
        if values[0] * values[1] >= 0:  # to rounding, the zero is at an end
            return a if abs(values[0]) < abs(values[1]) else b
        return brentq(
            lambda t: problem.event(name, t, dense(t)), a, b, xtol=max(1e-15 * b, 1e-24), maxiter=500
        )

    def _integrate(self, problem: EventProblem, start: float, y: np.ndarray, end: float) -> np.ndarray:
        if end <= start:
            return y
        solver = DOP853(
            problem.rates, start, y, end, rtol=self.rtol, atol=problem.atol, first_step=end - start
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            while solver.status == "running":
                solver.step()
        return np.array(solver.y)

    def _polish(
        self, problem: EventProblem, name: str, s: float, start: float, begun: np.ndarray
    ) -> tuple[float, np.ndarray]:
        """Newton's method on the event function along the integrated motion, not along the interpolated
        one."""
        y = self._integrate(problem, start, begun, s)
        for _ in range(6):
            g = problem.event(name, s, y)
            rate = np.array(problem.rates(s, y))
            increment = 1e-6 * (s - start) + 1e-300
            slope = (problem.event(name, s + increment, y + increment * rate) - g) / increment
            if g == 0 or slope == 0:
                break
            correction = -g / slope
            if abs(correction) <= 1e-16 * s or not abs(correction) < 0.1 * (s - start):
                break
            s += correction
            y = self._integrate(problem, start, begun, s)
        return s, y

    def _inner_peaks(
        self,
        problem: EventProblem,
        dense: Callable,
        seen: list[tuple[float, tuple[float, float, float]]],
        begun: np.ndarray,
        peaks: Peaks,
    ) -> None:
        """Notes the peaks at the end of the step and inside the step: the time of an inner peak is that of
        the dense output, the value at this time is integrated."""
        best = [max(pair) for pair in zip(peaks.best, seen[-1][1], strict=True)]
        peaks.note(seen[-1][1])
        for column in range(3):
            values = [sizes[column] for _, sizes in seen]
            top = values.index(max(values))
            if values[top] < 0.995 * best[column] or values[top] == 0:
                continue
            inward = {0: 1, len(seen) - 1: -1}.get(top)
            if inward is not None:
                t = seen[top][0] + 1e-4 * (seen[top + inward][0] - seen[top][0])
                if problem.observe(t, dense(t))[1][column] <= values[top]:
                    continue
            a, b = seen[max(top - 1, 0)][0], seen[min(top + 1, len(seen) - 1)][0]
            found = minimize_scalar(
                lambda t, c=column: -problem.observe(t, dense(t))[1][c],
                bounds=(a, b),
                method="bounded",
                options={"xatol": 1e-6 * (b - a)},
            )
            t = float(found.x)
            peaks.note(problem.observe(t, self._integrate(problem, seen[0][0], begun, t))[1])
