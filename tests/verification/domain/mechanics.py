"""Pointwise equations of docs/mechanism.md, sections 2, 3, 5 and 9, for one pair of flanks at a time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from reference.grooves import Helix, groove_of
from reference.parameters import DEFAULTS

Pair = tuple[int, int]
PAIRS: tuple[Pair, ...] = ((1, 1), (-1, 1), (1, -1), (-1, -1))
ROUNDING = 1e-11  # of the largest term of a sum: a sum below counts as zero in a decision


class Unresolved(Exception):
    """The reference gives no answer: an event chain without end, or a groove left."""


class Place(NamedTuple):
    """Section 2 at one angle. d and dd are derivatives by theta."""

    a1: float
    a2: float
    dgamma: float
    ddgamma: float
    z: float
    dz: float
    ddz: float
    length1: float  # hypot(r_1, a_1), m/rad
    length2: float


class Motion(NamedTuple):
    """The balance of section 3 solved for one pair of flanks."""

    omega: float
    alpha: float
    x1: float  # N.rad/m, positive on the flank that carries F > 0
    x2: float
    share: float  # D/Delta, the inertia (without inertia: the damping) that the torque sees
    size1: float  # largest terms of the sums that are x_1 and x_2
    size2: float
    axial: float  # F, N


class Law(NamedTuple):
    """mu(v, N) of one contact, section 9."""

    kinetic: float
    peak: float
    stribeck: float
    exponent: int
    viscous: float
    nu: float
    load: float

    def at(self, v: float, nominal: float) -> float:
        """An integrator's step may reach beyond the end of the motion, where v is negative: the smooth
        continuation of the law."""
        mu = self.kinetic
        if self.peak != 1.0:
            mu *= 1 + (self.peak - 1) * math.exp(-(max(v / self.stribeck, -2.0) ** self.exponent))
        if self.nu != 0.0:
            mu *= ((nominal * nominal + (0.1 * self.load) ** 2) / self.load**2) ** (self.nu / 2)
        return mu + self.viscous * v

    @property
    def varies_with_speed(self) -> bool:
        return self.viscous > 0 or self.kinetic * (self.peak - 1) > 0


def law_of(p: Mapping[str, Any], i: int) -> Law:
    names = ("", "_peak", ".v", ".e", "_viscous", "_load_exponent", "_load")
    keys = [f"cam{i}.friction{n}" for n in names]
    keys[2:4] = [f"cam{i}.stribeck_velocity", f"cam{i}.stribeck_exponent"]
    return Law(*(p[key] for key in keys))


class Mechanism:
    """One design. `params` holds the FMU's parameters by name; those left out have their start values."""

    def __init__(self, params: Mapping[str, Any]) -> None:
        p = {**DEFAULTS, **params}
        self.r1, self.r2 = p["cam1.radius"], p["cam2.radius"]
        self.grooves = groove_of(p, 1), groove_of(p, 2)
        self.laws = law_of(p, 1), law_of(p, 2)
        self.spring = p["spring.preload"], *(p[f"spring.stiffness{i}"] for i in ("", "2", "3"))
        load, release = ((p[f"damper.c_{way}"], p[f"damper.q_{way}"]) for way in ("load", "release"))
        self.damper = {1: load, -1: release}
        self.J, self.m, self.I = (p[f"inertia.{part}"] for part in ("shaft", "follower_mass", "follower"))
        self.b, self.contacts = p["shaft.damping"], p["contacts"]
        self.lower, self.upper = p["stop.lower"], p["stop.upper"]
        self.restitution = p["stop.restitution"]
        self.theta0, self.omega0 = p["initial.theta"], p["initial.omega"]
        self.inertial = self.J + self.m + self.I > 0
        self.damped = self.b > 0 or any(part > 0 for way in self.damper.values() for part in way)
        self.helical = all(isinstance(groove, Helix) for groove in self.grooves)
        self.coulomb = not any(law.varies_with_speed or law.kinetic * law.nu for law in self.laws)
        straight = not any(self.spring[2:]) and not any(q for _, q in self.damper.values())
        self.linear = self.helical and self.coulomb and straight
        self._gamma = 0.0
        if self.helical:
            self._slopes = [groove.derivatives(0.0, 0)[1] for groove in self.grooves]
        self.travel = self.at(self.upper).z - self.at(self.lower).z

    def at(self, theta: float) -> Place:
        if self.helical:
            a1, a2 = self._slopes
            dz = a1 * a2 / (a1 + a2)
            lengths = math.hypot(self.r1, a1), math.hypot(self.r2, a2)
            return Place(a1, a2, a2 / (a1 + a2), 0.0, dz * theta, dz, 0.0, *lengths)
        z, a1, b1, a2, b2 = self._meet(theta)
        total = a1 + a2
        dgamma, dphi = a2 / total, a1 / total
        bend1, bend2 = b1 * dgamma * dgamma, b2 * dphi * dphi
        lengths = math.hypot(self.r1, a1), math.hypot(self.r2, a2)
        ddz = (a2 * bend1 + a1 * bend2) / total
        return Place(a1, a2, dgamma, (bend2 - bend1) / total, z, a1 * dgamma, ddz, *lengths)

    def _meet(self, theta: float) -> tuple[float, float, float, float, float]:
        """z and the derivatives of both grooves where g_1(gamma) = g_2(theta - gamma): Newton's method from
        the latest gamma, and bisection where a step leaves the bracket of the root."""
        first, second = (groove.derivatives for groove in self.grooves)
        low, high = min(0.0, theta), max(0.0, theta)
        gamma = min(max(self._gamma, low), high)
        for _ in range(100):
            z, a1, b1 = first(gamma, 0)
            other, a2, b2 = second(theta - gamma, 0)
            gap = other - z
            step = gap / (a1 + a2) if a1 + a2 > 0 else gap * math.inf
            if gap == 0 or abs(step) <= 4e-16 * (abs(theta) + abs(gamma)):
                break
            low, high = (gamma, high) if gap > 0 else (low, gamma)
            gamma = gamma + step if low < gamma + step < high else (low + high) / 2
        self._gamma = gamma
        return z, a1, b1, a2, b2

    def spring_force(self, z: float) -> float:
        force, k, k2, k3 = self.spring
        return force + z * (k + z * (k2 + z * k3))

    def spring_energy(self, z: float) -> float:
        force, k, k2, k3 = self.spring
        return z * (force + z * (k / 2 + z * (k2 / 3 + z * k3 / 4)))

    def kinetic_energy(self, k: Place, omega: float) -> float:
        return (self.J + self.m * k.dz**2 + self.I * k.dgamma**2) * omega**2 / 2

    def damper_force(self, sigma: int, v: float) -> float:
        """Continued smoothly to v against sigma, where a step may reach beyond the end of the motion."""
        c, q = self.damper[sigma]
        return v * (c + q * sigma * v)

    def friction(self, k: Place, speed: float, axial: float) -> tuple[float, float]:
        """mu_1 and mu_2 at |omega| under the nominal loads of the axial resistance."""
        share = abs(axial) / (self.contacts * (k.a1 + k.a2))
        return (
            self.laws[0].at(k.dgamma * speed * k.length1, share * k.a2 * k.length1 / self.r1),
            self.laws[1].at((1 - k.dgamma) * speed * k.length2, share * k.a1 * k.length2 / self.r2),
        )

    def corner(self, k: Place, f1: float, f2: float) -> tuple[float, float, float, float, float]:
        """n_1, n_2, d_1, d_2 and Delta of section 3."""
        n1, n2 = k.a1 + f1 * self.r1, k.a2 + f2 * self.r2
        d1, d2 = self.r1 - f1 * k.a1, self.r2 - f2 * k.a2
        return n1, n2, d1, d2, self.r2 * d1 * n2 + self.r1 * d2 * n1

    def inertia(self, k: Place, f1: float, f2: float, parts: tuple[float, float, float]) -> float:
        """D of section 3 for the inertias (J, m, I), or for dampers in their place."""
        n1, n2, d1, _, delta = self.corner(k, f1, f2)
        shaft, mass, turning = parts
        return (
            shaft * delta + mass * k.dz * self.r1 * self.r2 * n1 * n2 + turning * k.dgamma * self.r2 * n2 * d1
        )

    def motion(self, k: Place, sigma: int, e: Pair, omega: float, tau: float, f_ext: float) -> Motion:
        """The answer of one pair. Without inertia omega is the answer, else alpha."""
        if not self.inertial:
            return self._creep(k, sigma, e, tau, f_ext)
        axial = self.spring_force(k.z) + f_ext + self.damper_force(sigma, k.dz * omega)
        mu1, mu2 = self.friction(k, sigma * omega, axial)
        most1, most2 = k.a1 + mu1 * self.r1, k.a2 + mu2 * self.r2  # of |n_1| and |n_2|
        n1, n2, d1, d2, delta = self.corner(k, sigma * e[0] * mu1, sigma * e[1] * mu2)
        p, q = self.r1 * self.r2 * n1 * n2, self.r2 * n2 * d1
        mass = self.J * delta + self.m * k.dz * p + self.I * k.dgamma * q
        square = omega * omega
        drive = (
            delta * (tau - self.b * omega)
            - p * (axial + self.m * k.ddz * square)
            - q * self.I * k.ddgamma * square
        )
        alpha = drive / mass if mass else math.inf  # at the very zero of D
        load = axial + self.m * (k.dz * alpha + k.ddz * square)
        moment = self.I * (k.dgamma * alpha + k.ddgamma * square)
        x1, x2 = (self.r2 * n2 * load - d2 * moment) / delta, (self.r1 * n1 * load + d1 * moment) / delta
        large = self._large(k, axial, f_ext) + self.m * (abs(k.dz * alpha) + abs(k.ddz) * square)
        size1 = (self.r2 * most2 * large + abs(d2 * moment)) / abs(delta)
        size2 = (self.r1 * most1 * large + abs(d1 * moment)) / abs(delta)
        return Motion(omega, alpha, x1, x2, mass / delta, size1, size2, axial)

    def _large(self, k: Place, axial: float, f_ext: float) -> float:
        """N, a size of what the axial load is a sum of; also where the spring passes its free length."""
        z = max(abs(k.z), 1e-3 * self.travel)
        return abs(axial) + abs(f_ext) + abs(self.spring[0]) + abs(self.spring[1]) * z

    def _creep(self, k: Place, sigma: int, e: Pair, tau: float, f_ext: float) -> Motion:
        """Without inertia: Delta (tau - b omega) = P (F_0 + D(z' omega)). Where the root would have the sign
        of -sigma it is continued as an odd function, so that the zero of omega can be located."""
        rest = self.spring_force(k.z) + f_ext
        mu1, mu2 = self.friction(k, 0.0, rest)
        n1, n2, _, _, delta = self.corner(k, sigma * e[0] * mu1, sigma * e[1] * mu2)
        p = self.r1 * self.r2 * n1 * n2
        c, quadratic = self.damper[sigma]
        drive = sigma * (tau - p / delta * rest)
        first, second = self.b + p / delta * c * k.dz, p / delta * quadratic * k.dz**2
        under = first * first + 4 * second * abs(drive)
        if under < 0 or first + math.sqrt(max(under, 0.0)) == 0:
            return Motion(math.nan, 0.0, math.nan, math.nan, -1.0, 0.0, 0.0, rest)
        omega = sigma * 2 * drive / (first + math.sqrt(under))
        axial = rest + self.damper_force(sigma, k.dz * omega)
        x1, x2 = self.r2 * n2 * axial / delta, self.r1 * n1 * axial / delta
        large = self._large(k, axial, f_ext) / abs(delta)
        sizes = self.r2 * (k.a2 + mu2 * self.r2) * large, self.r1 * (k.a1 + mu1 * self.r1) * large
        return Motion(omega, 0.0, x1, x2, math.sqrt(under), *sizes, axial)

    def edge_pair(self, k: Place, sigma: int, f0: float) -> tuple[Pair, float] | None:
        """The pair on whose flanks slow motion along sigma starts, and the torque of that edge of the stick
        band; None where no torque starts it."""
        side = 1 if f0 >= 0 else -1
        mu1, mu2 = self.friction(k, 0.0, f0)
        against = sigma * side > 0  # the motion raises the load
        for g in PAIRS[:1] if against else PAIRS:
            e = side * g[0], side * g[1]
            n1, n2, _, _, delta = self.corner(k, sigma * e[0] * mu1, sigma * e[1] * mu2)
            if delta == 0 or (against and delta < 0):
                continue
            flanks = (g[0] * n2 / delta, mu1), (g[1] * n1 / delta, mu2)
            if all(x >= 0 or mu == 0 for x, mu in flanks):
                return e, self.r1 * self.r2 * n1 * n2 / delta * f0
        return None
