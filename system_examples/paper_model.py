"""The numbers behind docs/paper.md: the pairs of cams with the arcs assumed, their statics by formula and
through the FMUs, the paper's equations as printed, and what readings and friction laws would show.

SI units; torque and axial force are totals of the mechanism, reactions are per contact (two share the load).
Sign: direction +1 is loading, -1 releasing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize

from dualcam import Fmu

Array = NDArray[np.float64]
Law = Callable[[Array], Array]  # friction over the normal reaction of one contact

GREASES = (0.14, 0.19)  # friction with grease 1 and 2
RANGE = 1.3963  # rad
LEVER = 0.500  # m
TORQUE = 10.0  # N.m, its order
TILT = 0.0524  # rad, misalignment
LOADING, RELEASING = 1, -1
CONTACTS = 2
PUBLISHED = {"A": {LOADING: 0.451, RELEASING: 0.735}, "B": {LOADING: 1.51, RELEASING: 0.69}}  # RMSE, N.m
UNCERTAINTY = 0.0029  # relative, in total and with the misalignment right

# assumed: neither radii nor arcs nor spring are published
INNER_RADIUS, OUTER_RADIUS = 0.020, 0.025  # m
PRELOAD = 0.3  # share of the spring's force at the end of the range
ARCS = {
    "A": (0.8203, 0.12, 0.08),
    "B": (0.8552, 0.12, 0.20),
}  # start angle, rad; radius of inner, outer arc, m


# ---- Statics by formula ------------------------------------------------------------------------------


def conversion(radius: float, slope: Array, friction: Array, direction: int) -> Array:
    """kappa = cot(lambda + direction phi)/r of one contact, 1/m."""
    return (1.0 - direction * friction * slope) / (radius * (slope + direction * friction))


def efficiency(lead: tuple[Array, Array], friction: tuple[float, float], radii: tuple[float, float]) -> Array:
    """Torque when releasing over torque when loading, same axial force, formula alone: also where it has no
    meaning."""
    total = {
        direction: sum(
            conversion(radius, np.tan(angle), np.asarray(mu), direction)
            for radius, angle, mu in zip(radii, lead, friction, strict=True)
        )
        for direction in (LOADING, RELEASING)
    }
    return np.asarray(total[LOADING]) / np.asarray(total[RELEASING])


def best_efficiency(friction: float) -> float:
    """At pi/4, both contacts alike."""
    return ((1.0 - friction) / (1.0 + friction)) ** 2


def unequal_optimum(friction: tuple[float, float], radii: tuple[float, float]) -> tuple[float, float, float]:
    """Lead angles and efficiency where the two contacts differ."""
    (mu1, mu2), (r1, r2) = friction, radii
    mean = math.sqrt((mu1 / r1 + mu2 / r2) / (1.0 / (mu1 * r1) + 1.0 / (mu2 * r2)))
    return math.atan(mu1 / mean), math.atan(mu2 / mean), best_efficiency(mean)


def searched_optimum(friction: tuple[float, float], radii: tuple[float, float]) -> tuple[float, float, float]:
    """The same by a search that knows the efficiency alone."""
    found = minimize(
        lambda x: -float(efficiency((x[0], x[1]), friction, radii)),
        [0.6, 0.6],
        method="Nelder-Mead",
        options={"xatol": 1e-10, "fatol": 1e-15, "maxiter": 2000},
    )
    return float(found.x[0]), float(found.x[1]), -float(found.fun)


# ---- Pairs of cams -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Arc:
    """A groove that unwraps to an arc of a circle: an ellipse with equal semi-axes."""

    radius: float  # of the cam, m
    lead: float  # lead angle at the start, rad
    size: float  # radius of the arc, m
    curvature: int = -1  # +1 steepens, -1 flattens

    def _sine(self, angle: Array) -> Array:
        """Sine of the lead angle after `angle`: the arc's direction turns in proportion to r psi."""
        return math.sin(self.lead) + self.curvature * self.radius * angle / self.size

    def height(self, angle: Array) -> Array:
        sine = self._sine(angle)
        return self.curvature * self.size * (math.cos(self.lead) - np.sqrt(1.0 - sine**2))

    def slope(self, angle: Array) -> Array:
        sine = self._sine(angle)
        return sine / np.sqrt(1.0 - sine**2)

    def parameters(self, cam: str) -> dict[str, float | int]:
        return {
            f"{cam}.radius": self.radius,
            f"{cam}.profile": 2,
            f"{cam}.lead_angle": self.lead,
            f"{cam}.ellipse_a": self.size,
            f"{cam}.ellipse_b": self.size,
            f"{cam}.ellipse_curvature": self.curvature,
        }


@dataclass(frozen=True)
class Pair:
    """Two cams and the spring. Which of the cams turns does not matter to the torque."""

    inner: Arc
    outer: Arc
    preload: float = PRELOAD  # share of the force at the end of the range
    force: float = 1.0  # of the spring at the end of the range, N

    def scaled(self, torque: float = TORQUE) -> Pair:
        """With the spring that makes `torque` the largest torque when loading with grease 1."""
        angle = np.linspace(0.0, RANGE, 141)
        return replace(self, force=self.force * torque / float(np.max(Statics(self, angle).torque(LOADING))))

    def turns(self, angle: Array) -> tuple[Array, Array]:
        """The pin's angles relative to each cam: g1(gamma) = g2(theta - gamma), by halving."""
        low, high = np.zeros_like(angle), angle.copy()
        for _ in range(60):
            middle = 0.5 * (low + high)
            above = self.inner.height(middle) > self.outer.height(angle - middle)
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        middle = 0.5 * (low + high)
        return middle, angle - middle

    @cached_property
    def stroke(self) -> float:
        """Of the follower over the range, m."""
        return float(self.inner.height(self.turns(np.array([RANGE]))[0])[0])

    @property
    def rate(self) -> float:
        """Of the spring, N/m."""
        return (1.0 - self.preload) * self.force / self.stroke

    def parameters(self, friction: float) -> dict[str, float | int]:
        return {
            **self.inner.parameters("cam1"),
            **self.outer.parameters("cam2"),
            "cam1.friction": friction,
            "cam2.friction": friction,
            "spring.preload": self.preload * self.force,
            "spring.stiffness": self.rate,
            "inertia.shaft": 0.0,
            "stop.upper": RANGE,
        }


class Statics:
    """Kinematics and statics of a pair at angles of the turning cam, from the formulas."""

    def __init__(self, pair: Pair, angle: Array) -> None:
        self.cams, self.turn = (pair.inner, pair.outer), pair.turns(angle)
        self.slopes = tuple(cam.slope(turn) for cam, turn in zip(self.cams, self.turn, strict=True))
        self.z = pair.inner.height(self.turn[0])
        self.spring = pair.preload * pair.force + pair.rate * self.z

    def torque(self, direction: int, *friction: Array | float) -> Array:
        """Torque at the turning cam with friction of both contacts (one number: of each; none: grease 1)."""
        mu = self._friction(friction)
        kappa = [
            conversion(cam.radius, slope, m, direction)
            for cam, slope, m in zip(self.cams, self.slopes, mu, strict=True)
        ]
        return self.spring / (kappa[0] + kappa[1])

    def reactions(self, direction: int, *friction: Array | float) -> tuple[Array, Array]:
        """Normal reaction at each contact of cam 1 and cam 2, N."""
        mu, torque = self._friction(friction), self.torque(direction, *friction)
        first, second = (
            torque * np.hypot(1.0, slope) / (cam.radius * (slope + direction * m)) / CONTACTS
            for cam, slope, m in zip(self.cams, self.slopes, mu, strict=True)
        )
        return first, second

    def band(self, friction: float) -> Array:
        """Width of the stick band, N.m."""
        return self.torque(LOADING, friction) - self.torque(RELEASING, friction)

    def torque_under(self, law: Law, direction: int) -> Array:
        """Torque with friction that depends on the reactions. Given the friction forces A_i, the balance (see
        Case.balance) is linear in the reactions R_i; A_i follows from R_i, and so on. nan where it locks."""
        (r1, r2), (s1, s2) = (cam.radius for cam in self.cams), self.slopes
        c1, c2 = 1.0 / np.hypot(1.0, s1), 1.0 / np.hypot(1.0, s2)  # cosines of the lead angles
        axial = (r1 * s1 + r2 * s2) * c1 * c2
        first, second = self.reactions(direction)
        for _ in range(200):
            a1, a2 = (direction * law(reaction) * reaction for reaction in (first, second))
            force = self.spring / CONTACTS + a1 * s1 * c1 + a2 * s2 * c2
            moment = r2 * a2 * c2 - r1 * a1 * c1
            old = (first, second)
            first = (force * r2 * s2 * c2 + moment * c2) / axial
            second = (force * r1 * s1 * c1 - moment * c1) / axial
            if all(np.max(np.abs(a - b)) < 1e-10 for a, b in zip(old, (first, second), strict=True)):
                torque = CONTACTS * r2 * c2 * (second * s2 + a2)
                return np.where((torque > 0.0) & (first > 0.0) & (second > 0.0), torque, math.nan)
        raise ArithmeticError("friction and reactions do not settle")

    @staticmethod
    def _friction(given: tuple[Array | float, ...]) -> tuple[Array, Array]:
        first = np.asarray(given[0] if given else GREASES[0])
        return first, np.asarray(given[1]) if len(given) > 1 else first


def pair(name: str) -> Pair:
    """Pair A or B, with what is assumed."""
    lead, inner, outer = ARCS[name]
    return Pair(Arc(INNER_RADIUS, lead, inner), Arc(OUTER_RADIUS, lead, outer)).scaled()


def other_pairs(name: str, count: int, seed: int = 1) -> Iterator[Pair]:
    """Pairs that the published facts allow as well: start angle of the inner cam, an outer arc smaller (A) or
    larger (B) than the inner one. All else is drawn; torque still reaches 10 N.m."""
    random = np.random.default_rng(seed)
    found = 0
    while found < count:
        radii = random.uniform(0.010, 0.030, 2)
        inner = random.uniform(0.04, 0.20)
        ratio = random.uniform(0.4, 1.0) if name == "A" else random.uniform(1.0, 2.5)
        curvature = random.choice([-1, 1], 2)
        lead, outer_lead, preload = ARCS[name][0], random.uniform(0.6, 0.95), random.uniform(0.0, 0.6)
        first = Arc(float(radii[0]), lead, float(inner), int(curvature[0]))
        second = Arc(float(radii[1]), float(outer_lead), float(inner * ratio), int(curvature[1]))
        if all(_usable(cam) for cam in (first, second)):
            found += 1
            yield Pair(first, second, float(preload)).scaled()


def _usable(arc: Arc) -> bool:
    """Lead angles between 15 and 70 degrees wherever the pin can come."""
    end = math.sin(arc.lead) + arc.curvature * arc.radius * RANGE / arc.size
    return math.sin(math.radians(15.0)) < end < math.sin(math.radians(70.0))


# ---- Through the FMUs --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Curve:
    """One way along the range as DualCamInverse gives it."""

    angle: Array  # rad
    torque: Array  # N.m
    reactions: tuple[Array, Array]  # per contact, N
    sliding: tuple[Array, Array]  # m/s at 1 rad/s


def curve(inverse: Fmu, cams: Pair, friction: float, direction: int, angle: Array) -> Curve:
    """Torque and reactions at 1 rad/s without inertia: the kinetostatic ones."""
    inverse.start({**cams.parameters(friction), "ledger": False})
    motion = inverse.reals("theta", "omega")
    wanted = inverse.reals(
        "tau", "cam1.reaction", "cam2.reaction", "cam1.sliding_speed", "cam2.sliding_speed"
    )
    rows = []
    for place in angle[::direction]:
        motion.values[:] = place, direction
        motion.write()
        inverse.step(1.0)
        rows.append(wanted.read())
    tau, first, second, slow, fast = np.array(rows)[::direction].T
    return Curve(angle, tau, (first, second), (np.abs(slow), np.abs(fast)))


def edges(inverse: Fmu, parameters: dict[str, float]) -> tuple[float, float]:
    """Torques when loading and releasing at the start of two helices, N.m."""
    inverse.start({"inertia.shaft": 0.0, "stop.upper": 0.01, **parameters})
    return inverse.real("torque_load"), inverse.real("torque_release")


def helices(
    lead: tuple[float, float], friction: tuple[float, float], radii: tuple[float, float], force: float
) -> dict[str, float]:
    return {
        "cam1.radius": radii[0],
        "cam2.radius": radii[1],
        "cam1.lead_angle": lead[0],
        "cam2.lead_angle": lead[1],
        "cam1.friction": friction[0],
        "cam2.friction": friction[1],
        "spring.preload": force,
        "spring.stiffness": 0.0,
    }


def efficiency_of_fmu(
    inverse: Fmu, lead: tuple[float, float], friction: tuple[float, float], radii: tuple[float, float]
) -> float:
    load, release = edges(inverse, helices(lead, friction, radii, 1000.0))
    return release / load


def friction_heat(forward: Fmu, cams: Pair, friction: float) -> tuple[float, float]:
    """Heat at cam 1 and cam 2 of a slow cycle over the whole range, J: torque up and down in ramps."""
    peak = 1.2 * TORQUE * max(1.0, friction / GREASES[0])
    forward.start(cams.parameters(friction))
    command = forward.reals("tau")
    for start, rate in ((0.0, peak), (peak, -peak)):
        command.values[0] = start
        command.write()
        command.write_derivatives(1, [rate])
        forward.step(1.0)
    assert abs(forward.real("theta")) < 1e-9, "the cycle does not come back"
    return forward.real("energy.heat_cam1"), forward.real("energy.heat_cam2")


# ---- The paper's equations as printed ----------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """Two helices under an axial force."""

    lead: tuple[float, float] = (0.8203, 0.7)
    radii: tuple[float, float] = (INNER_RADIUS, OUTER_RADIUS)
    friction: float = GREASES[0]
    force: float = 1000.0

    def tangents(self, direction: int = LOADING) -> tuple[float, float]:
        """tan(lambda_i + direction phi)."""
        phi = direction * math.atan(self.friction)
        return math.tan(self.lead[0] + phi), math.tan(self.lead[1] + phi)

    def correct(self, direction: int = LOADING) -> float:
        """Moment balance: T = F/(kappa_1 + kappa_2)."""
        (t1, t2), (r1, r2) = self.tangents(direction), self.radii
        return self.force / (1.0 / (r1 * t1) + 1.0 / (r2 * t2))

    def printed_3(self, direction: int = LOADING) -> float:
        """(3): the minus sign in the denominator."""
        (t1, t2), (r1, r2) = self.tangents(direction), self.radii
        return self.force * r2 * t2 / (1.0 - r2 * t2 / (r1 * t1))

    def tangential(self, direction: int = LOADING) -> float:
        """(7): tangential forces, not moments, are balanced; the torque is then taken at r2."""
        t1, t2 = self.tangents(direction)
        return self.radii[1] * self.force / (1.0 / t1 + 1.0 / t2)

    def swapped(self, direction: int = LOADING) -> float:
        """Section 4: each lead angle with the other cam's radius."""
        return replace(self, radii=self.radii[::-1]).correct(direction)

    def balance(self, direction: int, axial: int = 1, tangential: int = 1) -> float:
        """Torque at cam 2 from two rows: the follower's axial forces and moments, R_i normal, A_i = mu R_i.

            R1 cos l1 - s A1 sin l1 + R2 cos l2 - s A2 sin l2 = F
            r1 (R1 sin l1 + s A1 cos l1) - r2 (R2 sin l2 + s A2 cos l2) = 0        s: direction

        `axial`, `tangential` = -1 gives the term of A2 in that row the wrong sign."""
        (l1, l2), (r1, r2), mu = self.lead, self.radii, self.friction * direction
        rows = np.array(
            [
                [math.cos(l1) - mu * math.sin(l1), math.cos(l2) - axial * mu * math.sin(l2)],
                [
                    r1 * (math.sin(l1) + mu * math.cos(l1)),
                    -r2 * (math.sin(l2) + tangential * mu * math.cos(l2)),
                ],
            ]
        )
        reactions = np.linalg.solve(rows, [self.force, 0.0])
        return float(r2 * reactions[1] * (math.sin(l2) + mu * math.cos(l2)))


# ---- Readings and friction laws ----------------------------------------------------------------------


def rms(values: Array) -> float:
    return math.sqrt(float(np.mean(np.square(values))))


DRAWS: dict[str, tuple[Callable[[np.random.Generator, tuple[int, ...]], Array], float]] = {
    "anywhere, all alike": (lambda random, shape: random.uniform(0.0, 1.0, shape), math.sqrt(1 / 3)),
    "rather near the line (triangular)": (
        lambda random, shape: random.triangular(0.0, 0.0, 1.0, shape),
        math.sqrt(1 / 6),
    ),
    "in the near half": (lambda random, shape: random.uniform(0.0, 0.5, shape), math.sqrt(1 / 12)),
    "in the near quarter": (lambda random, shape: random.uniform(0.0, 0.25, shape), math.sqrt(1 / 48)),
}  # how far from the line, as a share of the band; and its root mean square


@dataclass(frozen=True)
class Readings:
    """RMSE of many series of hand-read torques against one edge of the band, N.m."""

    mean: float
    low: float  # 2.5 % of the series are below
    high: float  # 2.5 % are above
    exact: float  # of endlessly many readings


def readings(
    band: Array, draw: str, series: int = 4000, seed: int = 2
) -> tuple[Readings, tuple[float, float]]:
    """One reading at each angle of `band`; and the 95 % range of the ratio of two such RMSEs."""
    sample, share = DRAWS[draw]
    random = np.random.default_rng(seed)
    errors = np.sqrt(np.mean(np.square(band * sample(random, (2, series, band.size))), axis=2))
    low, high = np.quantile(errors, [0.025, 0.975])
    ratio = np.quantile(errors[0] / errors[1], [0.025, 0.975])
    return (
        Readings(float(np.mean(errors)), float(low), float(high), share * rms(band)),
        (float(ratio[0]), float(ratio[1])),
    )


def friction_for(statics: Statics, friction: float, direction: int, error: float, sign: int) -> float:
    """The friction, larger (sign +1) or smaller, whose torque is off by the RMSE `error`; nan if none is."""
    line = statics.torque(direction, friction)

    def miss(other: float) -> float:
        return rms(statics.torque(direction, other) - line) - error

    limit = 0.6 if sign > 0 else 0.0
    if miss(limit) < 0.0:
        return math.nan
    return float(brentq(miss, friction, limit, xtol=1e-13))


def power_law(friction: float, reference: float, exponent: float) -> Law:
    """mu = friction (R/reference)^-exponent."""
    return lambda reaction: friction * (np.abs(reaction) / reference) ** -exponent


def law_error(
    statics: Statics, friction: float, exponent: float, direction: int
) -> tuple[float, float, float]:
    """RMSE between friction that falls with the load and a constant one, which agree at the least, the mean
    and the largest reaction."""
    reactions = np.concatenate(statics.reactions(LOADING, friction))
    line = statics.torque(direction, friction)
    least, mean, largest = (
        rms(statics.torque_under(power_law(friction, float(of(reactions)), exponent), direction) - line)
        for of in (np.min, np.mean, np.max)
    )
    return least, mean, largest


def largest_change(ratio: float) -> float:
    """Largest change of exp(-v/v_s) while v grows by `ratio`, any v_s: at v/v_s = ln(ratio)/(ratio - 1)."""
    return ratio ** (-1.0 / (ratio - 1.0)) * (1.0 - 1.0 / ratio)


# ---- Misalignment ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Budget:
    """Relative uncertainties of the torque."""

    as_sine: float
    as_cosine: float
    rest: float  # all but the misalignment, root of squares
    printed_total: float
    bias: float  # mean loss of torque, tilt anywhere within its limits
    spread: float  # standard deviation about that


def budget() -> Budget:
    sine, cosine = math.sin(TILT), 1.0 - math.cos(TILT)
    rest = math.sqrt(UNCERTAINTY**2 - cosine**2)
    mean = math.sin(TILT) / TILT  # of cos over -TILT..TILT
    square = 0.5 + math.sin(2.0 * TILT) / (4.0 * TILT)  # of cos^2
    return Budget(sine, cosine, rest, math.hypot(rest, sine), 1.0 - mean, math.sqrt(square - mean**2))
