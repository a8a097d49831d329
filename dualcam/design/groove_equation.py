"""The inverse problem: the groove that makes a given spring give a wanted torque over the angle.

While cam 2 turns slowly in direction sigma, T = rho_sigma(a_1, a_2) F_s(z). At each theta the angle phi gives
z = g_2(phi) and a_2 = g_2'(phi) of groove 2, and with z the rho = T/F_s that groove 1 must provide:

    kappa_1 = 1/rho - kappa_2     tan lambda_1 = (1 - sigma mu_1 r_1 kappa_1)/(r_1 kappa_1 + sigma mu_1)

With q = rho kappa_1 = 1 - rho kappa_2 it stays finite for T = 0: a_1 = r_1 N/D, N = rho - sigma mu_1 r_1 q,
D = r_1 q + sigma mu_1 rho. Groove 1 exists while N >= 0 (level) and D > 0 (upright); releasing,
T >= 0 keeps both lead angles at least at the angle of friction. The one differential equation that is left is
the kinematics,

    dphi/dtheta = a_1/(a_1 + a_2) = r_1 N/(r_1 N + a_2 D),     phi(0) = 0,     gamma = theta - phi.

With both grooves equal gamma = phi = theta/2 and a_1 = a_2 = a. Then kappa_1 + kappa_2 = 1/rho is a quadratic
equation for a, of which the larger root is meant, and dz/dtheta = a/2.

Without preload F_s(0) = 0: then T(0) = 0 is needed, and dT/dtheta > 0 there. T/F_s tends to a limit that the
groove itself decides: with z = c theta, c = a_1 a_2/(a_1 + a_2), T'(0) = rho(a_1, a_2) k c is solved for
a_1(0). The solution is followed from a very small angle on; an error there dies out, since too much z makes
T/F_s, hence the slope, too small.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.design.grooves import CLASSES, Groove
from dualcam.design.mechanism import Spring, check_pair
from dualcam.design.statics import Array, sign_of, transfer
from dualcam.design.torque import Torque, WantedTorque, wanted_torque
from dualcam.errors import DesignError

if TYPE_CHECKING:
    from scipy.integrate import OdeSolution

SOLVER = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-18, "dense_output": True}
STEPS = 200  # at least, so that the solver's dense output is as exact as its steps
SLACK = 1e-13  # of the radius: a slope that is negative by this much is level, but for rounding
FIRST = 1e-7  # share of the range at which a spring without preload is started


@dataclass(frozen=True)
class GrooveProblem:
    """The wanted torque and everything given, with the differential equation of the state."""

    wanted: Torque
    upper: float
    spring: Spring
    direction: str
    groove2: Groove | None  # None: both equal
    friction: tuple[float, float]
    radius: tuple[float, float]
    kinks: tuple[float, ...]  # inside the range, in order

    @property
    def acting(self) -> tuple[float, float]:
        """sigma mu_i"""
        sign = sign_of(self.direction)
        return sign * self.friction[0], sign * self.friction[1]

    # ---- the state is phi, or z where both grooves are equal ----

    def height(self, state: Array) -> Array:
        """z [m] at this state."""
        return state if self.groove2 is None else self.groove2.at(state).z

    def rate(self, theta: ArrayLike, state: ArrayLike) -> Array:
        """Derivative of the state by theta. Where no groove gives the torque, the derivative is that of the
        nearest groove, level or upright, so that a trial step of the solver beyond the end does no harm."""
        top, bottom, a2 = self.slope_fraction(np.asarray(theta), np.asarray(state))
        top, bottom = np.maximum(top, 0.0), np.maximum(bottom, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.groove2 is None:
                return np.minimum(0.5 * top / bottom, 1e3 * max(self.radius))
            return np.where(top + a2 * bottom > 0.0, top / (top + a2 * bottom), 1.0)

    def slope_fraction(self, theta: Array, state: Array) -> tuple[Array, Array, Array]:
        """a_1 as top/bottom [m/rad], both >= 0 where a groove gives the torque, and a_2."""
        force = np.maximum(self.spring.force(self.height(state)), 1e-300)
        rho = self.wanted(theta) / force
        (m1, m2), (r1, r2) = self.acting, self.radius
        if self.groove2 is None:
            return (*_equal_slope(rho, m1, m2, r1), np.zeros(()))
        a2 = self.groove2.at(state).slope
        n2 = a2 + m2 * r2
        with np.errstate(divide="ignore", invalid="ignore"):
            q = np.where(rho == 0.0, 1.0, 1.0 - rho * (r2 - m2 * a2) / (r2 * n2))
        q = np.where((n2 > 0.0) | (rho == 0.0), q, -1e30)  # groove 2 locks itself
        return r1 * (rho - m1 * r1 * q), r1 * q + m1 * rho, a2

    # ---- its solution ----

    def solve(self) -> GrooveSolution:
        """The state over theta, integrated to rounding. DesignError where no groove gives the torque."""
        from scipy.integrate import solve_ivp

        theta, state = self.start()
        spans = []
        for end in (*(kink for kink in self.kinks if kink > theta), self.upper):
            solution = solve_ivp(
                lambda t, y: [float(self.rate(t, y[0]))],
                (theta, end),
                [state],
                # without preload the solution varies on the scale of theta itself
                first_step=theta if theta == FIRST * self.upper else None,
                max_step=self.upper / STEPS,
                **SOLVER,
            )
            if not solution.success:
                raise DesignError(f"{self.where(solution.t[-1])}: {solution.message}")
            spans.append((theta, solution.sol))
            theta, state = end, float(solution.y[0, -1])
        found = GrooveSolution(spans)
        self.check(found)
        return found

    def start(self) -> tuple[float, float]:
        """theta [rad] and state at the beginning. DesignError for a preload that does not suit the torque."""
        wanted, force = float(self.wanted(np.zeros(()))), self.spring.preload
        if force < 0.0 or not math.isfinite(force):
            raise DesignError(f"spring.preload = {force:g} N: allowed is >= 0, the spring must push at z = 0")
        if force > 0.0:
            return 0.0, 0.0
        if abs(wanted) > 1e-12 * self.largest():
            raise DesignError(
                f"torque {wanted:.6g} N.m at theta = 0 with spring.preload = 0: without preload there is no"
                " force at z = 0, and the torque must begin at 0 there, or there must be a preload > 0"
            )
        small = FIRST * self.upper
        rise = float(self.wanted(np.asarray(small))) / small
        a1 = self.slope_without_preload(rise)
        a2 = a1 if self.groove2 is None else float(self.groove2.at(0.0).slope)
        return small, small * (0.5 * a1 if self.groove2 is None else a1 / (a1 + a2))

    def slope_without_preload(self, rise: float) -> float:
        """a_1 at theta = 0 from rise = dT/dtheta = rho k c."""
        a2 = None if self.groove2 is None else float(self.groove2.at(0.0).slope)
        if a2 is not None and self.locks(a2):
            raise DesignError(f"{self.where(0.0)}: {self.locks(a2)}")

        def excess(log: float) -> float:
            a = (math.exp(log), math.exp(log) if a2 is None else a2)
            found = transfer(a, self.acting, self.radius, 1)
            c = a[0] * a[1] / (a[0] + a[1])
            return float(found.rho) * self.spring.stiffness * c - rise if found.regular else math.inf

        # from the level, or from the friction angle of releasing, to 89.99 deg or to where it jams
        level = max(0.0, -self.acting[0] if a2 is not None else -min(self.acting)) * self.radius[0]
        low = math.log(level * (1.0 + 1e-9) + 1e-9 * self.radius[0])
        ends = np.linspace(low, math.log(1e4 * self.radius[0]), 400)
        values = np.array([excess(log) for log in ends])
        regular = np.isfinite(values)
        last = int(np.argmin(regular)) - 1 if not regular.all() else len(ends) - 1
        if last < 1 or not values[0] <= 0.0 <= values[last]:
            highest = float(values[last] + rise) if last >= 0 else 0.0
            raise DesignError(
                f"torque rises with {rise:.6g} N.m/rad at theta = 0 with spring.preload = 0: with"
                f" {self.spring.stiffness:g} N/m allowed is {values[0] + rise:.6g} to {highest:.6g} N.m/rad"
            )
        from scipy.optimize import brentq

        return math.exp(brentq(excess, low, ends[last], xtol=1e-15))

    def largest(self) -> float:
        """Largest magnitude of the wanted torque [N.m]."""
        return float(np.max(np.abs(self.wanted(np.linspace(0.0, self.upper, 400)))))

    # ---- check of the solution ----

    def check(self, solution: GrooveSolution) -> None:
        """DesignError at the first angle where no groove gives the torque."""
        theta = solution.sample_angles()
        bad = ~self.possible(theta, solution(theta))
        if not bad.any():
            return
        first = int(np.argmax(bad))
        low, high = float(theta[max(first - 1, 0)]), float(theta[first])
        while high - low > 1e-9 * self.upper:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.possible(middle, solution(middle)) else (low, middle)
        raise DesignError(self.obstacle(high, solution(high)))

    def possible(self, theta: ArrayLike, state: ArrayLike) -> NDArray[np.bool_]:
        """Whether a groove gives the torque at theta [rad] with this state, arrays that broadcast."""
        theta, state = np.asarray(theta, dtype=float), np.asarray(state, dtype=float)
        wanted, force = self.wanted(theta), self.spring.force(self.height(state))
        top, bottom, _ = self.slope_fraction(theta, state)
        slack = SLACK * max(self.radius)
        found = (force > 0.0) & (wanted >= 0.0) & (bottom > 0.0) & (top >= -slack * np.abs(bottom))
        if self.groove2 is None:
            return found & ((wanted != 0.0) | (top > slack * bottom))
        low, high = self.groove2.range
        return found & (state >= low) & (state <= high)

    def obstacle(self, theta: float, state: Array) -> str:
        """The reason why no groove gives the torque at theta [rad] with this state."""
        z = float(self.height(state))
        force, wanted = float(self.spring.force(z)), float(self.wanted(np.asarray(theta)))
        location = self.where(theta)
        if not force > 0.0:
            return (
                f"{location}: spring force {force:.6g} N at z = {z:.6g} m: allowed is > 0, to"
                f" give {wanted:.6g} N.m"
            )
        if self.groove2 is not None:
            low, high = self.groove2.range
            if not low <= float(state) <= high:
                return (
                    f"{location}: groove 2 ends: phi = {float(state):.6g} rad is needed, allowed is"
                    f" {low:.6g} to {high:.6g}"
                )
        if self.groove2 is None and wanted == 0.0:
            return (
                f"{location}: torque 0: allowed is > 0, since two equal grooves would be level there"
                " and leave the pin loose"
            )
        return f"{location}: {self.limits(state, force, wanted)}"

    def limits(self, state: Array, force: float, wanted: float) -> str:
        """A message with the torques that a groove can give at this state and spring force [N]."""
        (m1, m2), (r1, r2) = self.acting, self.radius
        verb = {1: "while loading", -1: "while releasing", 0: "without friction"}[sign_of(self.direction)]
        equal = self.groove2 is None
        if self.groove2 is not None:
            a2 = float(self.groove2.at(state).slope)
            if locked := self.locks(a2):
                return locked
            second = (r2 - m2 * a2) / (r2 * (a2 + m2 * r2))
        # 1/rho with groove 1 (or both) level or, releasing, at the friction angle, and upright
        level = 1.0 / (r1 * m1) if m1 > 0.0 else math.inf
        upright = -m1 / r1
        if equal:
            level += 1.0 / (r2 * m2) if m2 > 0.0 else math.inf
            upright += -m2 / r2
        else:
            level, upright = level + second, upright + second
        if level <= 0.0:
            return (
                f"no torque loads: with friction {self.friction[0]:g} and {self.friction[1]:g} the contacts"
                " jam whatever groove 1 is"
            )
        lowest = force / level
        highest = force / upright if upright > 0.0 else math.inf
        what = "negative" if wanted < 0.0 else "too low" if wanted < lowest else "too high"
        which = "both grooves" if equal else "groove 1"
        sign = ". A torque that loads the spring is positive: is the sign wrong?" if wanted < 0.0 else ""
        return (
            f"torque {wanted:.6g} N.m {verb} is {what}: with the spring's {force:.6g} N allowed is"
            f" {lowest:.6g} to {highest:.6g} N.m ({which} from level to upright){sign}"
        )

    def locks(self, a2: float) -> str:
        """In words, if groove 2 locks itself with that slope; empty if not."""
        m2, r2 = self.acting[1], self.radius[1]
        if a2 + m2 * r2 > 0.0:
            return ""
        return (
            f"groove 2 locks itself, {self.direction}: its lead angle {math.atan(a2 / r2):.6g} rad must be"
            f" above {math.atan(-m2):.6g} rad, the angle of friction"
        )

    def where(self, theta: float) -> str:
        """The angle in messages."""
        return f"theta = {float(theta):.9g} rad"


@dataclass(frozen=True)
class GrooveSolution:
    """The state over theta."""

    spans: list[tuple[float, OdeSolution]]  # from theta [rad] on

    def __call__(self, theta: ArrayLike) -> Array:
        theta = np.asarray(theta, dtype=float)
        found = np.zeros(theta.shape)
        begin, first = self.spans[0]
        if begin > 0.0:  # without preload: straight from 0
            found = theta / begin * float(first(np.asarray(begin))[0])
        for begin, solution in self.spans:
            inside = theta >= begin
            if inside.any():
                found = np.where(
                    inside, solution(np.where(inside, theta, begin).ravel())[0].reshape(theta.shape), found
                )
        return found

    def sample_angles(self) -> Array:
        """Angles [rad], eight in each step of the solver, at which the solution is checked."""
        steps = np.concatenate([solution.ts for _, solution in self.spans])
        steps = np.unique(steps)
        share = np.linspace(0.0, 1.0, 8, endpoint=False)
        return np.append((steps[:-1, None] + share * np.diff(steps)[:, None]).ravel(), steps[-1])


def _equal_slope(rho: Array, m1: float, m2: float, r: float) -> tuple[Array, Array]:
    """top and bottom of the slope a = r s of two equal grooves, from rho (kappa_1 + kappa_2) = 1:
    (r + rho M) s^2 + (r M + 2 rho (P - 1)) s + r P - rho M = 0 with M = m1 + m2, P = m1 m2, m_i = sigma mu_i.
    Its larger root is the one with both s + m_i > 0."""
    M, P = m1 + m2, m1 * m2
    A, B, C = r + rho * M, r * M + 2.0 * rho * (P - 1.0), r * P - rho * M
    root = np.sqrt(np.maximum(B * B - 4.0 * A * C, 0.0))
    # no cancellation where B > 0
    return r * np.where(B > 0.0, -2.0 * C, root - B), np.where(B > 0.0, B + root, 2.0 * A)


# ---- preparation ----


def groove_problem(
    torque: WantedTorque,
    upper: float,
    spring: Spring,
    direction: str,
    groove2: Groove | None,
    friction: Sequence[float],
    radius: float,
    kinks: Sequence[float],
) -> GrooveProblem:
    """The problem as `synthesize` gets it. DesignError for values that are not allowed."""
    sign_of(direction)
    for name, value in (("upper", upper), ("radius", radius)):
        if not 0.0 < value < math.inf:
            raise DesignError(f"{name} = {value}: allowed is a finite number > 0")
    pair = check_pair("friction", friction, 0.0)
    _check_spring(spring)
    angles = np.linspace(0.0, upper, 400)
    wanted = wanted_torque(torque, angles)
    if not (finite := np.isfinite(wanted(angles))).all():
        angle = angles[int(np.argmin(finite))]
        raise DesignError(f"theta = {angle:.6g} rad: torque {wanted(angle)}: allowed are finite numbers")
    if not wanted(angles).any():
        raise DesignError(f"torque 0 from theta = 0 to {upper:g} rad: allowed is a torque > 0 at some angle")
    if groove2 is not None and not isinstance(groove2, CLASSES):
        names = ", ".join(one.__name__ for one in CLASSES)
        raise DesignError(f"groove2 = {groove2!r}: allowed are {names} or None")
    inside = tuple(sorted({float(kink) for kink in kinks if 0.0 < kink < upper}))
    radii = (radius, radius if groove2 is None else groove2.radius)
    return GrooveProblem(wanted, float(upper), spring, direction, groove2, pair, radii, inside)


def _check_spring(spring: Spring) -> None:
    """DesignError for values that the FMU refuses; the preload is checked where the design starts."""
    for name, value in spring.parameters().items():
        least = 0.0 if name == "spring.stiffness" else -math.inf
        if not (math.isfinite(value) and value >= least):
            what = "number >= 0" if least == 0.0 else "number"
            raise DesignError(f"{name} = {value}: allowed is a finite {what}")
