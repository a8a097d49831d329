"""Springs with which a groove gives a wanted torque.

Many springs are tried at once: the equation of the groove (groove_equation.py) is solved for all of them by
the classical Runge-Kutta method on a coarse grid. The spring whose groove has lead angles nearest to 45 deg
is then designed in full, so that a proposed spring is one that works."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from dualcam.design.design import Design
from dualcam.design.groove_equation import FIRST, GrooveProblem
from dualcam.design.mechanism import Spring
from dualcam.design.statics import Array
from dualcam.design.tabulation import tabulate
from dualcam.errors import DesignError

VARIED = ("preload", "stiffness", "both")
CANDIDATES = 81
DECADES = (-3.0, 2.0)  # of the force that two grooves of 45 deg need
GRID = 50  # steps of the coarse solution
TRIED = 2  # candidates that are designed in full before the search gives up
DIGITS = 3  # of a proposed value


@dataclass(frozen=True, eq=False)
class SpringProposal:
    """A spring with which `synthesize` gives the wanted torque.

    `spring`: the proposed spring, with which `design` was made. `vary`: what differs from the given spring:
    "preload", "stiffness", or "both". `design`: the groove for that spring.
    """

    spring: Spring
    vary: str
    design: Design

    @property
    def lead_angle(self) -> tuple[float, float]:
        """Least and largest lead angle of the designed groove [rad]."""
        mechanism = self.design.mechanism
        slope = mechanism.configuration(mechanism.angles()).slope[0]
        low, high = (math.atan(float(end) / mechanism.radius[0]) for end in (slope.min(), slope.max()))
        return low, high

    def __str__(self) -> str:
        values = {
            "preload": f"spring.preload = {self.spring.preload:g} N",
            "stiffness": f"spring.stiffness = {self.spring.stiffness:g} N/m",
        }
        chosen = " with ".join(values.values()) if self.vary == "both" else values[self.vary]
        low, high = (math.degrees(angle) for angle in self.lead_angle)
        return f"{chosen} (lead angle {low:.0f} to {high:.0f} deg)"


def propose(problem: GrooveProblem, vary: str, contacts: int, tolerance: float) -> SpringProposal | None:
    """The spring whose groove has lead angles nearest to 45 deg; None if none was found."""
    values, spring_of = _candidates(problem, vary)
    misfit = _misfit(problem, spring_of(values))
    for k in np.argsort(misfit)[:TRIED]:
        if not math.isfinite(misfit[k]):
            return None
        spring = spring_of(float(f"{values[k]:.{DIGITS}g}"))
        try:
            tried = replace(problem, spring=spring)
            design = tabulate(tried, tried.solve(), contacts, tolerance)
        except DesignError:
            continue
        if not design.torque_band().jams:
            return SpringProposal(spring, vary, design)
    return None


def with_proposals(
    error: DesignError, problem: GrooveProblem, contacts: int, tolerance: float
) -> DesignError:
    """The error, with springs that would work."""
    found = [propose(problem, vary, contacts, tolerance) for vary in VARIED[:2]]
    if not any(found):
        found = [propose(problem, VARIED[2], contacts, tolerance)]
    texts = [str(one) for one in found if one]
    return DesignError(f"{error}. This would work: {', or '.join(texts)}") if texts else error


def _candidates(problem: GrooveProblem, vary: str) -> tuple[Array, Callable[[Any], Spring]]:
    """Values, and the spring for a value or an array of values."""
    given, radius = problem.spring, problem.radius[0]
    force = problem.largest() / (0.5 * radius)  # rho = r/2 of two frictionless grooves of 45 deg
    stiffness = force / (0.5 * radius * problem.upper)
    shares = np.logspace(*DECADES, CANDIDATES)
    if vary == "preload":
        return force * shares, lambda value: _springs(replace(given, preload=0.0), preload=value)
    if vary == "stiffness":
        return stiffness * shares, lambda value: _springs(replace(given, stiffness=0.0), stiffness=value)
    # a preload, and the stiffness that lets the force grow over the range by as much
    return force * shares, lambda value: _springs(
        Spring(0.0, 0.0), preload=value, stiffness=_rounded(value * stiffness / force)
    )


class _Springs(Spring):
    """Many springs at once: values are numbers or arrays, which the check of one spring cannot take."""

    def __post_init__(self) -> None:
        pass


def _springs(given: Spring, **values: Any) -> Spring:  # noqa: ANN401
    """`given` with other values: one spring for numbers, many springs for arrays."""
    kind = Spring if all(isinstance(value, float) for value in values.values()) else _Springs
    return kind(**{**vars(given), **values})


def _rounded(value: Any) -> Any:  # noqa: ANN401
    """A number to DIGITS digits; an array as it is."""
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def _misfit(problem: GrooveProblem, springs: Spring) -> Array:
    """For each spring, the largest distance of groove 1's lead angle from 45 deg [rad]; infinite where a
    groove is impossible. `springs`: with arrays of shape (n,) for one or two of its values."""
    tried = replace(problem, spring=springs)
    shape = np.broadcast_shapes(np.shape(springs.preload), np.shape(springs.stiffness))
    grid = np.linspace(0.0, problem.upper, GRID + 1)
    state, misfit = np.zeros(shape), np.zeros(shape)
    if np.ndim(springs.preload) == 0 and springs.preload <= 0.0:
        state, misfit = _start_without_preload(problem, springs)
        first = FIRST * problem.upper
        grid = np.append(np.geomspace(first, grid[1], GRID), grid[2:])
    with np.errstate(all="ignore"):
        for now, after in pairwise(grid):
            misfit = np.maximum(misfit, _distance(tried, float(now), state))
            h = after - now
            k1 = tried.rate(now, state)
            k2 = tried.rate(now + 0.5 * h, state + 0.5 * h * k1)
            k3 = tried.rate(now + 0.5 * h, state + 0.5 * h * k2)
            k4 = tried.rate(after, state + h * k3)
            state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return np.maximum(misfit, _distance(tried, float(grid[-1]), state))


def _start_without_preload(problem: GrooveProblem, springs: Spring) -> tuple[Array, Array]:
    """State of each spring at the angle FIRST upper; misfit infinite where the torque cannot begin."""
    stiffnesses = np.asarray(springs.stiffness)
    state, misfit = np.zeros(len(stiffnesses)), np.zeros(len(stiffnesses))
    for k, stiffness in enumerate(stiffnesses):
        try:
            state[k] = replace(problem, spring=replace(springs, stiffness=float(stiffness))).start()[1]
        except DesignError:
            misfit[k] = math.inf
    return state, misfit


def _distance(tried: GrooveProblem, theta: float, state: Array) -> Array:
    """Of the lead angle from 45 deg at this angle [rad]; infinite where no groove gives the torque."""
    top, bottom, _ = tried.slope_fraction(np.asarray(theta), state)
    distance = np.abs(np.arctan2(top, tried.radius[0] * bottom) - 0.25 * math.pi)
    return np.where(np.isfinite(state) & tried.possible(theta, state), distance, math.inf)
