"""Independent reference simulator of the dual cylindrical cam, the oracle of the accuracy tests.

It shares nothing with the C core but the equations. Two ways to integrate are built on one event
logic, which is generic in the number type:

`simulate`        DOP853 at rtol 1e-13 in double precision; the accounts are extra states; events are
                  bracketed on the dense output and polished by integrating again from the last
                  accepted step. Works for any smooth law.
`simulate_exact`  closed form at 60 digits: while one set of flanks slides, a scene with helical grooves,
                  linear spring and linear dampers is a linear ODE with polynomial forcing, so the
                  motion is a sum of t^p exp(lambda t), its zeros are isolated by Rolle's theorem and
                  the accounts are integrals of products of such terms. Never stiff, no tolerance.

Contact unknowns are x_i = R_i/hypot(r_i, a_i), signed, with a_i = r_i tan(lambda_i). For sliding in
direction sigma on flanks e_i = sign(x_i), and with n_i = a_i + sigma e_i mu_i r_i,
d_i = r_i - sigma e_i mu_i a_i:

    d_1 x_1 + d_2 x_2 = A := F + m z_ddot             axial balance of the follower
    r_1 n_1 x_1 - r_2 n_2 x_2 = -G := -I gamma_ddot   its moment balance about the axis
    r_2 n_2 x_2 = tau - b omega - J alpha             moment balance of cam 2
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import mpmath
import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

Number = Any  # float, or mpf: the event logic works on either
Flanks = tuple[int, int]

STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP, WEDGED = 1, 2, 3, 4, 5, 6
FLOWS = ("work_in", "work_ext", "heat_cam1", "heat_cam2", "heat_damper", "heat_shaft")  # integrated in time
HEATS = ("heat_cam1", "heat_cam2", "heat_damper", "heat_shaft", "heat_stop")
ENERGIES = ("work_in", "work_ext", "work_tuning", "spring", "kinetic", *HEATS, "residual")
PEAKS = ("torque", "omega", "reaction1", "reaction2")

DEFAULTS: dict[str, float] = {
    **{
        f"cam{i}.{name}": value
        for i in (1, 2)
        for name, value in {
            "radius": 0.02,
            "profile": 1,
            "lead_angle": math.pi / 4,
            "ellipse_a": 0.05,
            "ellipse_b": 0.05,
            "ellipse_curvature": -1,
            "friction": 0.14,
        }.items()
    },
    "spring.preload": 50.0,
    "spring.stiffness": 50000.0,
    "spring.stiffness2": 0.0,
    "spring.stiffness3": 0.0,
    "damper.c_load": 0.0,
    "damper.q_load": 0.0,
    "damper.c_release": 0.0,
    "damper.q_release": 0.0,
    "inertia.shaft": 0.002,
    "inertia.follower_mass": 0.0,
    "inertia.follower": 0.0,
    "shaft.damping": 0.0,
    "stop.lower": 0.0,
    "stop.upper": 1.3963,
    "stop.restitution": 0.0,
    "initial.theta": 0.0,
    "initial.omega": 0.0,
    "contacts": 2,
}
INTEGERS = frozenset(
    name for name in DEFAULTS if name.endswith(("profile", "curvature")) or name == "contacts"
)


class Refused(ValueError):
    """The scene has no well-posed answer: loading jam, moving wedge, or no consistent flanks."""


@dataclass(frozen=True)
class Interval:
    """Inputs over `duration` seconds: a value at the start and a constant rate."""

    duration: float
    tau: float
    tau_rate: float = 0.0
    F_ext: float = 0.0
    F_ext_rate: float = 0.0


@dataclass
class Point:
    """What an FMU should report at the end of an interval."""

    theta: float
    omega: float
    z: float
    v: float
    mode: int
    events: int
    energy: dict[str, float]
    peak: dict[str, float]
    doubts: list[str] = field(default_factory=list)  # switches within rounding during this interval

    def value(self, name: str) -> float:
        """The value of an interface variable, by its name."""
        group, _, entry = name.partition(".")
        if group == "energy":
            return self.energy[entry]
        if group == "peak":
            return self.peak[entry]
        return getattr(self, name)


# ---- numbers ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Arithmetic:
    """A number type. `tiny` is the relative size below which a balance counts as zero; `probe` is the
    look-ahead, in units of the fastest time constant, that tells which way a zero is about to go."""

    number: Callable[[Any], Number]
    tan: Callable[[Number], Number]
    tiny: Number
    probe: Number
    still: Number  # a speed this small, relative to the largest seen, is rest when new inputs arrive


MP = mpmath.MPContext()
MP.dps = 60
DOUBLE = Arithmetic(float, math.tan, 1e-12, 1e-5, 0.0)
SIXTY_DIGITS = Arithmetic(MP.mpf, MP.tan, MP.mpf("1e-40"), MP.mpf("1e-16"), MP.mpf("1e-25"))


def sign(x: Number) -> int:
    return (x > 0) - (x < 0)


# ---- the mechanism ------------------------------------------------------------------------------


class Kinematics(NamedTuple):
    """Section 2 at one theta; a_i = g_i', a prime is d/dtheta."""

    a1: Number
    a2: Number
    gamma: Number
    dgamma: Number
    ddgamma: Number
    z: Number
    dz: Number
    ddz: Number


class Helices:
    """Two plain helices: everything is linear in theta."""

    def __init__(self, a1: Number, a2: Number) -> None:
        self.a1, self.a2 = a1, a2
        self.dgamma, self.dz = a2 / (a1 + a2), a1 * a2 / (a1 + a2)

    def at(self, theta: Number) -> Kinematics:
        dgamma, dz = self.dgamma, self.dz
        return Kinematics(self.a1, self.a2, dgamma * theta, dgamma, 0, dz * theta, dz, 0)


class Balance(NamedTuple):
    """Coefficients of the contact balance for one direction and one pair of flanks."""

    n1: Number
    n2: Number
    d1: Number
    d2: Number
    delta: Number  # r2 d1 n2 + r1 d2 n1
    product: Number  # r1 r2 n1 n2


class Load(NamedTuple):
    """Solution of the balance at one instant."""

    omega: Number
    alpha: Number  # 0 without inertia
    x1: Number
    x2: Number


class Slip(NamedTuple):
    """A way to slide: direction and flanks."""

    sigma: int
    e: Flanks


class Mechanism:
    """Parameters in the chosen number type, and the pointwise equations."""

    def __init__(self, params: Mapping[str, float], arithmetic: Arithmetic) -> None:
        unknown = set(params) - set(DEFAULTS)
        if unknown:
            raise KeyError(f"no such parameter: {sorted(unknown)}")
        p = {name: arithmetic.number(value) for name, value in {**DEFAULTS, **params}.items()}
        if p["cam1.profile"] != 1 or p["cam2.profile"] != 1:
            raise NotImplementedError("only helical grooves")
        self.arithmetic = arithmetic
        self.r1, self.r2 = p["cam1.radius"], p["cam2.radius"]
        self.mu1, self.mu2 = p["cam1.friction"], p["cam2.friction"]
        tan = arithmetic.tan
        self.groove = Helices(self.r1 * tan(p["cam1.lead_angle"]), self.r2 * tan(p["cam2.lead_angle"]))
        self.spring = [p["spring.preload"]] + [p[f"spring.stiffness{i}"] for i in ("", "2", "3")]
        self.damper = {
            +1: (p["damper.c_load"], p["damper.q_load"]),
            -1: (p["damper.c_release"], p["damper.q_release"]),
        }
        self.J, self.m, self.I = (p[f"inertia.{part}"] for part in ("shaft", "follower_mass", "follower"))
        self.b = p["shaft.damping"]
        self.lower, self.upper = p["stop.lower"], p["stop.upper"]
        self.restitution = p["stop.restitution"]
        self.theta0, self.omega0 = p["initial.theta"], p["initial.omega"]
        self.contacts = p["contacts"]
        self.inertial = bool(self.J + self.m + self.I > 0)
        self._balances: dict[Slip, tuple[Number, Number, Balance]] = {}
        self.linear = not any(self.spring[2:]) and not any(q for _, q in self.damper.values())

    def force_scale(self, kin: Kinematics, f_ext: Number) -> Number:
        """Size of the terms whose sum is F_0."""
        reach = kin.dz * max(abs(self.lower), abs(self.upper))
        return sum(abs(c) * reach**i for i, c in enumerate(self.spring)) + abs(f_ext)

    def viscous(self, sigma: int) -> bool:
        """Without inertia: does any damper act in this direction?"""
        return bool(self.b + sum(self.damper[sigma]) > 0)

    def spring_force(self, z: Number) -> Number:
        force, k, k2, k3 = self.spring
        return force + z * (k + z * (k2 + z * k3))

    def spring_energy(self, z: Number) -> Number:
        force, k, k2, k3 = self.spring
        return z * (force + z * (k / 2 + z * (k2 / 3 + z * k3 / 4)))

    def damper_force(self, sigma: int, v: Number) -> Number:
        c, q = self.damper[sigma]
        return v * (c + q * abs(v))

    def kinetic_energy(self, kin: Kinematics, omega: Number) -> Number:
        return (self.J + self.m * kin.dz**2 + self.I * kin.dgamma**2) * omega**2 / 2

    def balance(self, kin: Kinematics, slip: Slip) -> Balance:
        known = self._balances.get(slip)
        if known is None or known[0] is not kin.a1 or known[1] is not kin.a2:
            known = self._balances[slip] = (kin.a1, kin.a2, self._balance(kin, slip))
        return known[2]

    def _balance(self, kin: Kinematics, slip: Slip) -> Balance:
        f1, f2 = slip.sigma * slip.e[0] * self.mu1, slip.sigma * slip.e[1] * self.mu2
        n1, n2 = kin.a1 + f1 * self.r1, kin.a2 + f2 * self.r2
        d1, d2 = self.r1 - f1 * kin.a1, self.r2 - f2 * kin.a2
        delta = self.r2 * d1 * n2 + self.r1 * d2 * n1
        return Balance(n1, n2, d1, d2, delta, self.r1 * self.r2 * n1 * n2)

    def static_ratio(self, kin: Kinematics, direction: int) -> Number | None:
        """Edge of the stick band per unit of F_0 > 0 for motion in `direction`; None: no torque moves it.
        F_0 < 0 mirrors: the ratio for (sigma, F_0) is that for direction sigma * sign(F_0)."""
        order = [(1, 1), (1, -1), (-1, 1), (-1, -1)] if direction < 0 else [(1, 1)]
        for e in order:
            q = self.balance(kin, Slip(direction, e))
            if q.delta == 0 or (direction > 0 and q.delta < 0):
                continue
            x1, x2 = self.r2 * q.n2 / q.delta, self.r1 * q.n1 / q.delta
            if (e[0] * x1 >= 0 or self.mu1 == 0) and (e[1] * x2 >= 0 or self.mu2 == 0):
                return q.product / q.delta
        return None

    def load(self, kin: Kinematics, slip: Slip, omega: Number, tau: Number, f_ext: Number) -> Load:
        """Acceleration (with inertia) or speed (without) and the contact loads, by elimination."""
        q = self.balance(kin, slip)
        f0 = self.spring_force(kin.z) + f_ext
        if self.inertial:
            force = f0 + self.damper_force(slip.sigma, kin.dz * omega)
            carried = q.d1 * self.r2 * q.n2 * self.I  # what multiplies gamma_ddot
            mass = q.delta * self.J + carried * kin.dgamma + q.product * self.m * kin.dz
            if mass == 0:
                raise Refused("no effective inertia")
            centrifugal = q.product * self.m * kin.ddz + carried * kin.ddgamma
            drive = q.delta * (tau - self.b * omega) - q.product * force - centrifugal * omega**2
            alpha = drive / mass
        else:
            c, qq = self.damper[slip.sigma]
            if qq:
                raise NotImplementedError("quadratic damper without inertia")
            alpha = omega * 0
            omega = (q.delta * tau - q.product * f0) / (q.delta * self.b + q.product * c * kin.dz)
            force = f0 + c * kin.dz * omega
        axial = force + self.m * (kin.dz * alpha + kin.ddz * omega**2)
        moment = self.I * (kin.dgamma * alpha + kin.ddgamma * omega**2)
        x1 = (self.r2 * q.n2 * axial - q.d2 * moment) / q.delta
        x2 = (self.r1 * q.n1 * axial + q.d1 * moment) / q.delta
        return Load(omega, alpha, x1, x2)

    def scales(self, kin: Kinematics, slip: Slip, omega: Number, tau: Number, f_ext: Number) -> Load:
        """Sizes of the terms whose sums make up a Load; against them a sum counts as zero."""
        q, (drag, mass) = self.balance(kin, slip), self._inertia_and_drag(kin, slip)
        axial, torque = self.force_scale(kin, f_ext), abs(tau)
        if self.inertial:
            axial += abs(self.damper_force(slip.sigma, kin.dz * omega))
            torque += self.b * abs(omega)
        start = (abs(q.delta) * torque + abs(q.product) * axial) / abs(mass if self.inertial else drag)
        if self.inertial:
            axial += self.m * kin.dz * start
        else:
            axial += self.damper[slip.sigma][0] * kin.dz * start
        moment = self.I * kin.dgamma * start
        return Load(
            start * (not self.inertial),
            start * self.inertial,
            (abs(self.r2 * q.n2) * axial + abs(q.d2) * moment) / abs(q.delta),
            (abs(self.r1 * q.n1) * axial + abs(q.d1) * moment) / abs(q.delta),
        )

    def rate(self, kin: Kinematics, slip: Slip) -> Number:
        """About the fastest rate of change, 1/s; used to size look-aheads only."""
        drag, mass = self._inertia_and_drag(kin, slip)
        stiffness = abs(self.balance(kin, slip).product) * abs(self.spring[1]) * kin.dz
        return abs(drag / mass) + (stiffness / abs(mass)) ** 0.5 if self.inertial else stiffness / abs(drag)

    def _inertia_and_drag(self, kin: Kinematics, slip: Slip) -> tuple[Number, Number]:
        """Coefficients of omega and alpha in the balance multiplied through by delta."""
        q = self.balance(kin, slip)
        drag = q.delta * self.b + q.product * self.damper[slip.sigma][0] * kin.dz
        carried = q.d1 * self.r2 * q.n2 * self.I * kin.dgamma
        return drag, q.delta * self.J + carried + q.product * self.m * kin.dz

    def powers(self, kin: Kinematics, slip: Slip, load: Load, tau: Number, f_ext: Number) -> list[Number]:
        """Rates of the accounts FLOWS."""
        omega, v = load.omega, kin.dz * load.omega
        return [
            tau * omega,
            f_ext * v,
            self.mu1 * abs(load.x1) * (self.r1**2 + kin.a1**2) * kin.dgamma * abs(omega),
            self.mu2 * abs(load.x2) * (self.r2**2 + kin.a2**2) * (1 - kin.dgamma) * abs(omega),
            self.damper_force(slip.sigma, v) * v,
            self.b * omega**2,
        ]

    def shared(self, kin: Kinematics, f0: Number) -> tuple[Number, Number]:
        """x_1, x_2 at rest: frictionless sharing of the axial load."""
        return f0 * kin.dgamma / self.r1, f0 * (1 - kin.dgamma) / self.r2


# ---- sliding from one event to the next ---------------------------------------------------------


@dataclass(frozen=True)
class Segment:
    """Sliding on one pair of flanks, from local time 0 for at most `length`."""

    slip: Slip
    theta: Number
    omega: Number
    tau: tuple[Number, Number]  # value, rate
    f_ext: tuple[Number, Number]
    length: Number
    stop: Number  # the end stop ahead
    edge: Number | None = None  # without inertia: ratio of the band edge that ends the motion


@dataclass
class Outcome:
    """Where a segment ended, and why: a subset of end, rest, stop, cross1, cross2, kink."""

    time: Number
    theta: Number
    omega: Number
    flows: list[Number]
    causes: set[str]
    peak_omega: Number
    peak_x: tuple[Number, Number]


class Flow(Protocol):
    arithmetic: Arithmetic

    def advance(self, mechanism: Mechanism, segment: Segment) -> Outcome: ...


class ExactFlow:
    """Closed form of a linear segment: functions of time are coefficients over a basis t^p exp(lambda t)."""

    arithmetic = SIXTY_DIGITS
    zero = MP.mpf("1e-40")

    def advance(self, mechanism: Mechanism, segment: Segment) -> Outcome:
        if not mechanism.linear:
            raise NotImplementedError("closed form needs a linear spring and linear dampers")
        slip, k = segment.slip, mechanism.spring[1]
        kin = mechanism.groove.at(segment.theta)
        q = mechanism.balance(kin, slip)
        c = mechanism.damper[slip.sigma][0]
        drag = q.delta * mechanism.b + q.product * c * kin.dz
        force = mechanism.spring[0] + segment.f_ext[0]
        drive = [
            q.delta * segment.tau[0] - q.product * force,
            q.delta * segment.tau[1] - q.product * segment.f_ext[1],
        ]
        stiffness = q.product * k * kin.dz
        carried = q.d1 * mechanism.r2 * q.n2 * mechanism.I * kin.dgamma
        mass = q.delta * mechanism.J + carried + q.product * mechanism.m * kin.dz
        if mechanism.inertial:
            theta = self._second_order(
                stiffness / mass, drag / mass, drive[0] / mass, drive[1] / mass, segment.theta, segment.omega
            )
        else:
            theta = self._first_order(stiffness / drag, drive[0] / drag, drive[1] / drag, segment.theta)
        omega = self._derivative(theta)
        alpha = self._derivative(omega) if mechanism.inertial else [MP.mpf(0)] * len(theta)
        tau, f_ext = self._line(*segment.tau), self._line(*segment.f_ext)
        f0 = self._sum((1, self._line(mechanism.spring[0], 0)), (k * kin.dz, theta), (1, f_ext))
        axial = self._sum((1, f0), (c * kin.dz, omega), (mechanism.m * kin.dz, alpha))
        moment = mechanism.I * kin.dgamma
        x1 = self._sum((mechanism.r2 * q.n2 / q.delta, axial), (-q.d2 * moment / q.delta, alpha))
        x2 = self._sum((mechanism.r1 * q.n1 / q.delta, axial), (q.d1 * moment / q.delta, alpha))

        watched: dict[str, list[Number]] = {}
        if mechanism.inertial:
            watched["rest"] = omega
        else:
            watched["rest"] = self._sum((1, tau), (-segment.edge, f0))
            watched["kink"] = f0
        watched["stop"] = self._sum((1, theta), (-1, self._line(segment.stop, 0)))
        if mechanism.mu1 > 0:
            watched["cross1"] = x1
        if mechanism.mu2 > 0:
            watched["cross2"] = x2
        length, found = segment.length, {}
        for name, function in watched.items():
            root = self._first_zero(function, length)
            if root is not None:
                found[name] = root
                length = min(length, root * (1 + self.zero))
        length = min(found.values(), default=segment.length)
        causes = {name for name, t in found.items() if t <= length * (1 + self.zero)} or {"end"}

        table = self._product_integrals(length)
        f1 = slip.sigma * slip.e[0] * mechanism.mu1 * (mechanism.r1**2 + kin.a1**2) * kin.dgamma
        f2 = slip.sigma * slip.e[1] * mechanism.mu2 * (mechanism.r2**2 + kin.a2**2) * (1 - kin.dgamma)
        flows = [
            self._integral(tau, omega, table),
            kin.dz * self._integral(f_ext, omega, table),
            f1 * self._integral(x1, omega, table),
            f2 * self._integral(x2, omega, table),
            c * kin.dz**2 * self._integral(omega, omega, table),
            mechanism.b * self._integral(omega, omega, table),
        ]
        return Outcome(
            length,
            self._value(theta, length),
            self._value(omega, length),
            flows,
            causes,
            self._largest(omega, length),
            (self._largest(x1, length), self._largest(x2, length)),
        )

    def _second_order(
        self, K: Number, C: Number, c0: Number, c1: Number, theta: Number, omega: Number
    ) -> list[Number]:
        """theta'' = c0 + c1 t - K theta - C theta'."""
        if K == 0 and C == 0:
            self._set_basis([(0, 0), (1, 0), (2, 0), (3, 0)])
            return [theta, omega, c0 / 2, c1 / 6]
        if K == 0:
            self._set_basis([(0, 0), (1, 0), (2, 0), (0, -C)])
            p2 = c1 / (2 * C)
            p1 = (c0 - 2 * p2) / C
            decay = (p1 - omega) / C
            return [theta - decay, p1, p2, decay]
        p1 = c1 / K
        p0 = (c0 - C * p1) / K
        x, y = theta - p0, omega - p1
        discriminant = C * C - 4 * K
        if discriminant == 0:
            self._set_basis([(0, 0), (1, 0), (0, -C / 2), (1, -C / 2)])
            return [p0, p1, x, y + C / 2 * x]
        root = MP.sqrt(discriminant)  # imaginary when it oscillates
        first, second = (-C + root) / 2, (-C - root) / 2
        self._set_basis([(0, 0), (1, 0), (0, first), (0, second)])
        share = (y - second * x) / root
        return [p0, p1, share, x - share]

    def _first_order(self, K: Number, w0: Number, w1: Number, theta: Number) -> list[Number]:
        """theta' = w0 + w1 t - K theta."""
        if K == 0:
            self._set_basis([(0, 0), (1, 0), (2, 0)])
            return [theta, w0, w1 / 2]
        p1 = w1 / K
        p0 = (w0 - p1) / K
        self._set_basis([(0, 0), (1, 0), (0, -K)])
        return [p0, p1, theta - p0]

    def _set_basis(self, basis: list[tuple[int, Number]]) -> None:
        self.basis = basis
        self._latest: tuple[Number, dict[Number, Number]] = (None, {})
        self.exponents = [rate for _, rate in basis]

    def _line(self, value: Number, slope: Number) -> list[Number]:
        return [value, slope] + [MP.mpf(0)] * (len(self.basis) - 2)

    def _sum(self, *terms: tuple[Number, list[Number]]) -> list[Number]:
        return [MP.fsum(factor * u[j] for factor, u in terms) for j in range(len(self.basis))]

    def _derivative(self, u: list[Number]) -> list[Number]:
        du = [MP.mpf(0)] * len(u)
        for j, (power, rate) in enumerate(self.basis):
            du[j] += rate * u[j]
            if power:
                du[self.basis.index((power - 1, rate))] += power * u[j]
        return du

    def _value(self, u: list[Number], t: Number) -> Number:
        total = MP.mpf(0)
        for c, (power, rate) in zip(u, self.basis, strict=True):
            if c:
                term = c * t**power if power else c
                total += term * self._exp(rate, t) if rate else term
        return MP.re(total)

    def _exp(self, rate: Number, t: Number) -> Number:
        """exp(rate t), remembered for the conjugate rate and the next function at the same time."""
        if self._latest[0] is not t:
            self._latest = (t, {})
        known = self._latest[1]
        if rate not in known:
            known[rate] = MP.exp(rate * t)
            known[MP.conj(rate)] = MP.conj(known[rate])
        return known[rate]

    def _first_zero(self, u: list[Number], end: Number) -> Number | None:
        """Looks at two periods first: a swing mostly ends in its first one."""
        frequency = max(abs(MP.im(rate)) for rate in self.exponents)
        window = min(end, 4 * MP.pi / frequency) if frequency > 0 else end
        while True:
            roots = self._zeros(u, window)
            if roots or window == end:
                return roots[0] if roots else None
            window = min(end, 4 * window)

    def _zeros(self, u: list[Number], end: Number) -> list[Number]:
        """All sign changes in (0, end]: between those of the derivative the function is monotone."""
        terms = [(c, power, rate) for c, (power, rate) in zip(u, self.basis, strict=True) if c != 0]
        tail = [term for term in terms if term[2] != 0]
        if len(tail) == len(terms):
            return [t for t in self._zeros_of_tail(tail, end) if self.zero * end < t <= end]
        du = self._derivative(u)
        knots = [MP.mpf(0), *(t for t in self._zeros(du, end) if t < end), end]
        nothing = self.zero * MP.fsum(abs(c) for c in u)
        values = [self._value(u, t) for t in knots]
        values = [MP.mpf(0) if abs(value) <= nothing else value for value in values]
        roots = []
        for a, b, fa, fb in zip(knots, knots[1:], values, values[1:], strict=False):
            if fb == 0:
                roots.append(b)
            elif sign(fa) * sign(fb) < 0:
                roots.append(self._root(u, du, a, b, sign(fb)))
        return roots

    def _zeros_of_tail(self, tail: list[tuple[Number, int, Number]], end: Number) -> Iterable[Number]:
        if len(tail) < 2:
            return []
        (c1, _, rate1), (c2, _, rate2) = tail
        if rate1 == rate2:  # (c1 + c2 t) exp(rate t)
            return [-c1 / c2]
        if MP.im(rate1) == 0:
            ratio = -MP.re(c2) / MP.re(c1)
            return [MP.log(ratio) / MP.re(rate1 - rate2)] if ratio > 0 else []
        frequency = MP.im(rate1)  # 2 |c1| exp(-a t) cos(frequency t + phase)
        first = (MP.pi / 2 - MP.arg(c1)) / frequency
        period = MP.pi / frequency
        start = MP.ceil(-first / period)
        return [first + (start + j) * period for j in range(int(end / period) + 2)]

    def _root(self, u: list[Number], du: list[Number], a: Number, b: Number, rising: int) -> Number:
        """Newton inside a bracket of a monotone function; bisection where Newton does not halve its steps."""
        t, step = (a + b) / 2, b - a
        for _ in range(1000):
            f = self._value(u, t)
            if f == 0:
                return t
            a, b = (a, t) if sign(f) == rising else (t, b)
            slope = self._value(du, t)
            before, step = step, (-f / slope if slope != 0 else b - a)
            if not a < t + step < b or abs(2 * step) > abs(before):
                step = (a + b) / 2 - t
            t += step
            if abs(step) <= MP.mpf("1e-52") * abs(t):
                return t
        raise ArithmeticError("root finding did not end")

    def _largest(self, u: list[Number], end: Number) -> Number:
        times = [MP.mpf(0), end, *self._zeros(self._derivative(u), end)]
        return max(abs(self._value(u, t)) for t in times)

    def _product_integrals(self, end: Number) -> dict[tuple[int, int], Number]:
        """Integral over (0, end) of basis_i basis_j, for i <= j."""
        size = max((abs(rate) for rate in self.exponents), default=MP.mpf(0))
        table = {}
        for i, (p, first) in enumerate(self.basis):
            for j, (q, second) in enumerate(self.basis[i:], start=i):
                rate = first + second
                if abs(rate) <= self.zero * size:
                    table[i, j] = end ** (p + q + 1) / (p + q + 1)
                    continue
                grown = MP.exp(rate * end)
                integral = (grown - 1) / rate
                for power in range(1, p + q + 1):
                    integral = (end**power * grown - power * integral) / rate
                table[i, j] = integral
        return table

    def _integral(self, u: list[Number], w: list[Number], table: dict[tuple[int, int], Number]) -> Number:
        terms = [(j, b) for j, b in enumerate(w) if b]
        total = MP.mpf(0)
        for i, a in enumerate(u):
            if a:
                total += a * sum(b * table[min(i, j), max(i, j)] for j, b in terms)
        return MP.re(total)


class OdeFlow:
    """DOP853 in double precision, for any smooth segment. State: theta, omega (with inertia), FLOWS."""

    arithmetic = DOUBLE
    rtol = 1e-13
    samples = 8  # per step, where sign changes are looked for
    stiffness_limit = 1.5  # step times rate

    def advance(self, mechanism: Mechanism, segment: Segment) -> Outcome:
        slip, inertial = segment.slip, mechanism.inertial
        size = 2 if inertial else 1

        def load_at(t: float, y: np.ndarray) -> tuple[Kinematics, Load, float, float]:
            tau = segment.tau[0] + segment.tau[1] * t
            f_ext = segment.f_ext[0] + segment.f_ext[1] * t
            kin = mechanism.groove.at(float(y[0]))
            omega = float(y[1]) if inertial else 0.0
            return kin, mechanism.load(kin, slip, omega, tau, f_ext), tau, f_ext

        def derivative(t: float, y: np.ndarray) -> list[float]:
            kin, load, tau, f_ext = load_at(t, y)
            motion = [load.omega, load.alpha] if inertial else [load.omega]
            return motion + mechanism.powers(kin, slip, load, tau, f_ext)

        def watch(t: float, y: np.ndarray) -> dict[str, float]:
            kin, load, tau, f_ext = load_at(t, y)
            f0 = mechanism.spring_force(kin.z) + f_ext
            seen = {"stop": float(y[0]) - segment.stop}
            seen |= {"rest": load.omega} if inertial else {"rest": tau - segment.edge * f0, "kink": f0}
            if mechanism.mu1 > 0:
                seen["cross1"] = load.x1
            if mechanism.mu2 > 0:
                seen["cross2"] = load.x2
            return seen

        y = np.array([segment.theta, segment.omega][:size] + [0.0] * len(FLOWS))
        scale = self._scale(mechanism, segment, size)
        outcome_peaks = _Peaks(load_at)
        time, length = 0.0, float(segment.length)
        last = watch(0.0, y)
        armed = {name: True for name in last}
        kin = mechanism.groove.at(segment.theta)
        tau, f_ext = segment.tau[0], segment.f_ext[0]
        natural = mechanism.scales(kin, slip, segment.omega, tau, f_ext)
        nothing = {"cross1": natural.x1, "cross2": natural.x2}
        nothing["stop"] = abs(mechanism.upper) + abs(mechanism.lower)
        if inertial:
            nothing["rest"] = 0.0
        else:
            nothing["kink"] = mechanism.force_scale(kin, f_ext)
            nothing["rest"] = abs(segment.tau[0]) + abs(segment.edge) * nothing["kink"]
        for name, value in last.items():
            armed[name] = name == "stop" or abs(value) > 1e-12 * nothing[name]
        outcome_peaks.look(0.0, y)
        # at the edge of stability the error estimate misses what is left of the fast component
        longest = self.stiffness_limit / max(mechanism.rate(kin, slip), self.stiffness_limit / length)
        solver = DOP853(derivative, 0.0, y, length, rtol=self.rtol, atol=scale, max_step=longest)
        while solver.status == "running":
            with np.errstate(invalid="ignore", divide="ignore"):  # error estimate 0/0 where it underflows
                message = solver.step()
            if solver.status == "failed":
                raise ArithmeticError(message)
            dense, start, end = solver.dense_output(), float(solver.t_old), float(solver.t)
            begun = y
            y = np.array(solver.y)
            first: tuple[float, str] | None = None
            before = start
            for j in range(1, self.samples + 1):
                t = start + (end - start) * j / self.samples
                state = y if j == self.samples else dense(t)
                seen = watch(t, state)
                for name, value in seen.items():
                    if not armed[name]:
                        armed[name] = abs(value) > 1e-12 * nothing[name] and value != 0
                    elif last[name] * value < 0 or value == 0:
                        root = t
                        if value != 0:
                            root = self._dense_root(watch, dense, name, before, t)
                        if first is None or root < first[0]:
                            first = (root, name)
                last, before = seen, t
                if first is not None:
                    break
            if first is None:
                outcome_peaks.step(start, end, begun, dense, derivative, scale, self.rtol, y)
                time = end
                continue
            name = first[1]
            time, y = self._polish(derivative, watch, name, first[0], start, begun, scale)
            outcome_peaks.step(start, time, begun, dense, derivative, scale, self.rtol, y)
            return self._outcome(mechanism, segment, time, y, size, {name}, watch, nothing, outcome_peaks)
        return self._outcome(mechanism, segment, length, y, size, {"end"}, watch, nothing, outcome_peaks)

    def _outcome(
        self,
        mechanism: Mechanism,
        segment: Segment,
        time: float,
        y: np.ndarray,
        size: int,
        causes: set[str],
        watch: Callable[[float, np.ndarray], dict[str, float]],
        nothing: dict[str, float],
        peaks: _Peaks,
    ) -> Outcome:
        if "cross1" in causes or "cross2" in causes:  # without follower inertia both vanish together
            seen = watch(time, y)
            causes |= {n for n in ("cross1", "cross2") if n in seen and abs(seen[n]) < 1e-10 * nothing[n]}
        omega = float(y[1]) if mechanism.inertial else peaks.load_at(time, y)[1].omega
        if abs(omega) <= 1e-13 * peaks.omega and "end" not in causes:
            causes.add("rest")  # with damping alone on the shaft, torque and speed vanish together
        flows = [float(v) for v in y[size:]]
        return Outcome(time, float(y[0]), omega, flows, causes, peaks.omega, (peaks.x[0], peaks.x[1]))

    @staticmethod
    def _dense_root(watch: Callable, dense: Callable, name: str, a: float, b: float) -> float:
        return brentq(lambda t: watch(t, dense(t))[name], a, b, xtol=1e-15 * b)

    @staticmethod
    def _integrate(
        derivative: Callable, start: float, y: np.ndarray, end: float, scale: np.ndarray, rtol: float
    ) -> np.ndarray:
        if end <= start:
            return y
        solver = DOP853(derivative, start, y, end, rtol=rtol, atol=scale, first_step=end - start)
        with np.errstate(invalid="ignore", divide="ignore"):
            while solver.status == "running":
                solver.step()
        return np.array(solver.y)

    def _polish(
        self,
        derivative: Callable,
        watch: Callable[[float, np.ndarray], dict[str, float]],
        name: str,
        time: float,
        start: float,
        begun: np.ndarray,
        scale: np.ndarray,
    ) -> tuple[float, np.ndarray]:
        """Newton on the event function along the integrated, not the interpolated, motion."""
        y = self._integrate(derivative, start, begun, time, scale, self.rtol)
        for _ in range(6):
            g = watch(time, y)[name]
            rate = np.array(derivative(time, y))
            hair = 1e-6 * (time - start) + 1e-300
            slope = (watch(time + hair, y + hair * rate)[name] - g) / hair
            if g == 0 or slope == 0:
                break
            correction = -g / slope
            if abs(correction) <= 1e-16 * time or abs(correction) > 0.1 * (time - start):
                break
            time += correction
            y = self._integrate(derivative, start, begun, time, scale, self.rtol)
        return time, y

    @staticmethod
    def _scale(mechanism: Mechanism, segment: Segment, size: int) -> np.ndarray:
        """Absolute tolerances: rounding of the natural size of each state."""
        reach = max(abs(mechanism.upper), abs(mechanism.lower))
        kin = mechanism.groove.at(segment.theta)
        load = mechanism.load(kin, segment.slip, segment.omega, segment.tau[0], segment.f_ext[0])
        rate = mechanism.rate(kin, segment.slip)
        rate = max(rate, 1e-9)
        travel = min(reach, abs(load.omega) / rate + abs(load.alpha) / rate**2 + 1e-9 * reach)
        speed = abs(load.omega) + travel * rate + 1e-12
        force = abs(mechanism.spring[0]) + mechanism.spring[1] * kin.dz * reach + abs(segment.f_ext[0])
        energy = (abs(segment.tau[0]) + force * kin.dz) * reach * 1e-2 + 1e-12
        return 1e-15 * np.array([reach, speed][:size] + [energy] * len(FLOWS))


class _Peaks:
    """Largest |omega| and |x_i| along an integrated segment."""

    def __init__(self, load_at: Callable[[float, np.ndarray], tuple[Kinematics, Load, float, float]]) -> None:
        self.load_at = load_at
        self.omega = 0.0
        self.x = [0.0, 0.0]

    def sizes(self, t: float, y: np.ndarray) -> tuple[float, float, float]:
        load = self.load_at(t, y)[1]
        return abs(load.omega), abs(load.x1), abs(load.x2)

    def look(self, t: float, y: np.ndarray) -> None:
        omega, x1, x2 = self.sizes(t, y)
        self.omega, self.x = max(self.omega, omega), [max(self.x[0], x1), max(self.x[1], x2)]

    def step(
        self,
        start: float,
        end: float,
        begun: np.ndarray,
        dense: Callable,
        derivative: Callable,
        scale: np.ndarray,
        rtol: float,
        y: np.ndarray,
    ) -> None:
        """Ends of the step, and interior maxima: the time from the dense output, the value integrated."""
        self.look(end, y)
        times = np.linspace(start, end, OdeFlow.samples + 1)
        seen = np.array([self.sizes(t, dense(t)) for t in times])
        best = (self.omega, *self.x)
        for column in range(3):
            top = int(np.argmax(seen[:, column]))
            if seen[top, column] < 0.99 * best[column]:
                continue
            found = minimize_scalar(
                lambda t, c=column: -self.sizes(t, dense(t))[c],
                bounds=(times[max(top - 1, 0)], times[min(top + 1, len(times) - 1)]),
                method="bounded",
                options={"xatol": 1e-9 * (end - start)},
            )
            t = float(found.x)
            self.look(t, OdeFlow._integrate(derivative, start, begun, t, scale, rtol))


# ---- modes and events ---------------------------------------------------------------------------


class Simulation:
    """The mechanism between events: rest, sliding (a Flow), or following the band edge without inertia."""

    def __init__(self, params: Mapping[str, float], flow: Flow, first: Interval) -> None:
        self.flow, self.arithmetic = flow, flow.arithmetic
        number = self.arithmetic.number
        self.mechanism = Mechanism(params, self.arithmetic)
        kin = self.mechanism.groove.at(self.mechanism.theta0)
        self.up = self.mechanism.static_ratio(kin, +1)
        self.down = self.mechanism.static_ratio(kin, -1)
        if self.up is None:
            raise Refused("loading jam")
        self.theta = self.mechanism.theta0
        self.omega = self.mechanism.omega0 if self.mechanism.inertial else number(0)
        self.slip: Slip | None = None
        self.follow: Number | None = None  # speed along the band edge, quasi-static
        self.rest_until = number(0)
        self.mode = 0
        self.events = 0
        self.account = {name: number(0) for name in (*FLOWS, "heat_stop")}
        self.peak = {name: number(0) for name in PEAKS}
        self.doubts: list[str] = []
        self.stored = self._stored()
        self._start(first)
        self._begin(first)

    # -- inputs and accounts

    def _start(self, first: Interval) -> None:
        """The mode before t = 0: nothing has moved yet, and rates of the inputs are not known yet."""
        self._set_inputs(replace(first, tau_rate=0.0, F_ext_rate=0.0))
        if self.omega != 0:
            self.mode = LOADING if self.omega > 0 else RELEASING
        else:
            mode, sigma, _ = self._rest()
            self.mode = mode or (LOADING if sigma > 0 else RELEASING)

    def _begin(self, interval: Interval) -> None:
        self._set_inputs(interval)
        if abs(self.omega) <= self.arithmetic.still * self.peak["omega"]:
            self.omega *= 0
        self._decide()

    def _set_inputs(self, interval: Interval) -> None:
        number = self.arithmetic.number
        self.t, self.length = number(0), number(interval.duration)
        self.tau = (number(interval.tau), number(interval.tau_rate))
        self.f_ext = (number(interval.F_ext), number(interval.F_ext_rate))

    def _tau(self, t: Number) -> Number:
        return self.tau[0] + self.tau[1] * t

    def _f_ext(self, t: Number) -> Number:
        return self.f_ext[0] + self.f_ext[1] * t

    def _input_sizes(self) -> tuple[Number, Number]:
        """Largest torque and pull of the interval, about: zeros within their rounding are zeros."""
        tau, f_ext = (abs(u) + abs(rate) * self.length for u, rate in (self.tau, self.f_ext))
        return tau, f_ext

    def _stored(self) -> Number:
        kin = self.mechanism.groove.at(self.theta)
        return self.mechanism.spring_energy(kin.z) + self.mechanism.kinetic_energy(kin, self.omega)

    def _note_x(self, x1: Number, x2: Number) -> None:
        """Peak reactions, per contact: R_i = x_i hypot(r_i, a_i)."""
        kin, mech = self.mechanism.groove.at(self.theta), self.mechanism
        for i, (x, r, a) in enumerate(((x1, mech.r1, kin.a1), (x2, mech.r2, kin.a2)), start=1):
            reaction = abs(x) * (r * r + a * a) ** self.arithmetic.number(0.5) / mech.contacts
            self.peak[f"reaction{i}"] = max(self.peak[f"reaction{i}"], reaction)

    def _note_rest(self, *times: Number) -> None:
        kin = self.mechanism.groove.at(self.theta)
        for t in times:
            self._note_x(*self.mechanism.shared(kin, self.mechanism.spring_force(kin.z) + self._f_ext(t)))

    def _set_mode(self, mode: int) -> None:
        self.events += mode != self.mode
        self.mode = mode

    # -- decisions

    def _edge(self, direction: int) -> Number | None:
        return self.up if direction > 0 else self.down

    def _rest(self) -> tuple[int, int, Number]:
        """(mode, 0, until) if it rests, (0, sigma, until) if it slips; decided in the middle of the time
        to the next change of that decision, so that a ramp resolves a torque exactly on an edge."""
        mech, number = self.mechanism, self.arithmetic.number
        kin = mech.groove.at(self.theta)
        fs = mech.spring_force(kin.z)
        ratios = [r for r in (self.up, self.down) if r is not None]
        if self.down is None:
            ratios.append(kin.dz)
        lines = [(fs + self.f_ext[0], self.f_ext[1])]
        lines += [(self.tau[0] - r * lines[0][0], self.tau[1] - r * lines[0][1]) for r in ratios]
        guard = self.t + number(self.arithmetic.tiny) * self.length / 100
        times = [-value / slope for value, slope in lines if slope != 0]
        until = min((t for t in times if guard < t < self.length), default=self.length)
        constant = self.tau[1] == 0 and self.f_ext[1] == 0
        middle = self.t if constant else (self.t + until) / 2
        tau, f0 = self._tau(middle), fs + self._f_ext(middle)
        tau_size, f_size = self._input_sizes()
        size = tau_size + abs(self.up) * mech.force_scale(kin, f_size)
        near = self.arithmetic.tiny * size
        load, release = (self.up, self.down) if f0 >= 0 else (self.down, self.up)
        if (
            abs(self.up * f0) <= near
        ):  # the next hair of motion sets the sign of the load, and it is that of sigma
            load = release = self.up
        if load is not None and tau > load * f0 + near:
            return (UPPER_STOP, 0, until) if self.theta >= mech.upper else (0, +1, until)
        if release is not None and tau < release * f0 - near:
            return (LOWER_STOP, 0, until) if self.theta <= mech.lower else (0, -1, until)
        towards = sign(tau - kin.dz * f0) if abs(tau - kin.dz * f0) > near else 0
        if (towards > 0 and load is None) or (towards < 0 and release is None):
            return WEDGED, 0, until
        ahead = abs(self._tau(until)), abs(self.up * (fs + self._f_ext(until)))
        if until < self.length and max(ahead) <= near:  # the band will shrink to the torque, for a moment
            self.doubts.append("stick band without width")
        if constant and self.omega == 0 and mech.inertial and near > 0:
            edges = [r * f0 for r in (load, release) if r is not None]
            if any(0 < abs(tau - edge) < 1e-11 * size for edge in edges):
                self.doubts.append("torque on a band edge")
        return STICK, 0, until

    def _decide(self) -> None:
        """Chooses what happens from self.t on: sets slip, follow or rest_until, and the mode."""
        mech = self.mechanism
        self.follow = None
        if mech.inertial and self.omega != 0:
            sigma = sign(self.omega)
            present = self.slip.e if self.slip is not None and self.slip.sigma == sigma else None
            if self.theta >= mech.upper if sigma > 0 else self.theta <= mech.lower:
                self._set_mode(LOADING if sigma > 0 else RELEASING)
                self._impact()
                return
            self._enter(sigma, present)
            return
        mode, sigma, until = self._rest()
        if sigma == 0:
            self._settle(mode, until)
            return
        if mech.inertial or mech.viscous(sigma):
            self._enter(sigma, None)
            return
        self._set_mode(LOADING if sigma > 0 else RELEASING)  # also a jump is motion
        self._jump(sigma)
        mode, sigma, until = self._rest()
        kin, tau, f_ext = mech.groove.at(self.theta), self._tau(self.t), self._f_ext(self.t)
        f0, size = mech.spring_force(kin.z) + f_ext, mech.force_scale(kin, f_ext)
        if self.down is not None and abs((self.up - self.down) * f0) < 1e-12 * self.up * size:
            self.doubts.append("stick band without width")
        if sigma == 0:
            self._settle(mode, until)
            return
        if mech.viscous(sigma):  # in the other direction than the jump
            self._enter(sigma, None)
            return
        # on the edge, and the ramp leads on: follow it
        self._set_mode(LOADING if sigma > 0 else RELEASING)
        rounding = self.arithmetic.tiny * (abs(self.tau[0]) + abs(self.tau[1] * self.length))
        ratio = self._edge(sigma * (sign(self.tau[1]) if abs(tau) <= rounding else sign(tau)))
        if ratio is None or mech.spring[1] == 0:
            raise Refused("no quasi-static motion")
        speed = (self.tau[1] / ratio - self.f_ext[1]) / (mech.spring[1] * kin.dz)
        if sign(speed) != sigma:
            raise Refused("no quasi-static motion")
        self.slip, self.follow, self.omega = None, speed, speed

    def _settle(self, mode: int, until: Number) -> None:
        self.slip, self.omega, self.rest_until = None, self.omega * 0, until
        self._set_mode(mode)

    def _enter(
        self, sigma: int, present: Flanks | None, crossed: Flanks | None = None, *, crossing: bool = False
    ) -> None:
        slip = self._choose(sigma, present, crossed, crossing)
        if slip is None:
            if not self.mechanism.inertial:
                raise Refused("no consistent flanks")
            raise Refused("moving wedge" if self.omega != 0 else "no consistent flanks")
        self.slip = slip
        self._set_mode(LOADING if sigma > 0 else RELEASING)

    def _choose(
        self, sigma: int, present: Flanks | None, crossed: Flanks | None, crossing: bool
    ) -> Slip | None:
        """`present`: flanks to keep if they are consistent; `crossed`: flanks to try first, at a crossing."""
        mech = self.mechanism
        kin = mech.groove.at(self.theta)
        s = self._axial_sign(sigma)
        order = [e for e in self._preference(s) if mech.balance(kin, Slip(sigma, e)).delta != 0]
        if not mech.inertial:  # the damper's share of F depends on the flanks: each counts with its own
            own = {e: sign(self._ahead(Slip(sigma, e))[2]) or s for e in order}
            order.sort(key=lambda e: self._preference(own[e]).index(e))
        first = present or crossed
        if first is not None:
            order = [first] + [e for e in order if e != first]
        found = [Slip(sigma, e) for e in order if self._consistent(Slip(sigma, e))]
        if len(found) > 1:
            # which one is a convention only at an entry, and while more torque means more acceleration
            loads = [self._ahead(slip)[1] for slip in found]
            size = max(abs(load.x1) + abs(load.x2) for load in loads)
            differ = any(abs(load.x1 - loads[0].x1) > 1e-9 * size for load in loads)
            masses = [mech._inertia_and_drag(kin, s)[1] * mech.balance(kin, s).delta for s in found]
            if differ and (crossing or min(masses) < 0):
                self.doubts.append("several flank pairs are consistent")
        return found[0] if found else None

    @staticmethod
    def _preference(s: int) -> list[Flanks]:
        """Order of trial under an axial load of sign s."""
        return [(s, s), (s, -s), (-s, s), (-s, -s)]

    def _ahead(self, slip: Slip) -> tuple[Load, Load, Number]:
        """Load now, load a hair later, and the axial force F a hair later."""
        mech = self.mechanism
        kin = mech.groove.at(self.theta)
        hair = self.arithmetic.probe / (mech.rate(kin, slip) + 1 / self.length)
        now = mech.load(kin, slip, self.omega, self._tau(self.t), self._f_ext(self.t))
        theta, omega, t = self.theta + hair * now.omega, now.omega + hair * now.alpha, self.t + hair
        first = mech.load(mech.groove.at(theta), slip, omega, self._tau(t), self._f_ext(t))
        # by the mean of both: a start on a ramp has no acceleration yet
        theta += hair * (first.omega - now.omega) / 2 + hair**2 * (first.alpha - now.alpha) / 6
        omega = now.omega + hair * (now.alpha + first.alpha) / 2
        later_kin = mech.groove.at(theta)
        later = mech.load(later_kin, slip, omega, self._tau(t), self._f_ext(t))
        force = mech.spring_force(later_kin.z) + self._f_ext(t)
        return now, later, force + mech.damper_force(slip.sigma, later_kin.dz * later.omega)

    def _axial_sign(self, sigma: int) -> int:
        """Sign of F = F_s + F_ext + D; if it vanishes, the one it is about to take."""
        mech = self.mechanism
        kin = mech.groove.at(self.theta)
        damping = mech.damper_force(sigma, kin.dz * self.omega) if mech.inertial else self.omega * 0
        force = mech.spring_force(kin.z) + self._f_ext(self.t) + damping
        if abs(force) > self.arithmetic.tiny * (mech.force_scale(kin, self._input_sizes()[1]) + abs(damping)):
            return sign(force)
        return sign(self._ahead(Slip(sigma, (sigma, sigma)))[2]) or sigma

    def _consistent(self, slip: Slip) -> bool:
        """Do the contact loads press on the assumed flanks, and does a start from rest go along sigma?"""
        mech, tiny = self.mechanism, self.arithmetic.tiny
        kin = mech.groove.at(self.theta)
        now, later, _ = self._ahead(slip)
        size = mech.scales(kin, slip, self.omega, *self._input_sizes())
        pairs = ((now.x1, later.x1, size.x1, mech.mu1), (now.x2, later.x2, size.x2, mech.mu2))
        for e, (x, x_later, scale, mu) in zip(slip.e, pairs, strict=True):
            if mu == 0:
                continue
            if abs(x) > tiny * scale:
                if e * x < 0:
                    return False
            elif e * x_later < -tiny / 100 * scale:
                return False
        if mech.inertial and self.omega != 0:
            return True
        which = 1 if mech.inertial else 0  # alpha or omega
        return slip.sigma * (now[which] if abs(now[which]) > tiny * size[which] else later[which]) > 0

    # -- motion

    def run(self, interval: Interval, first: bool) -> Point:
        if not first:
            self.doubts = []
            self._begin(interval)
        for t in (self.arithmetic.number(0), self.length):
            self.peak["torque"] = max(self.peak["torque"], abs(self._tau(t)))
        for _ in range(100_000):
            if self.slip is not None:
                done = self._slide()
            elif self.follow is not None:
                done = self._follow_edge()
            else:
                self._note_rest(self.t, self.rest_until)
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
        edge = None
        if not mech.inertial:
            f0 = mech.spring_force(kin.z) + self._f_ext(self.t)
            if abs(f0) <= self.arithmetic.tiny * mech.force_scale(kin, self._input_sizes()[1]):
                now, _, _ = self._ahead(slip)
                f0 = (mech.spring[1] * kin.dz * now.omega + self.f_ext[1]) or f0 * 0 + slip.sigma
            edge = self._edge(slip.sigma * (sign(f0) or slip.sigma))
            if edge is None:
                raise Refused("moving wedge")
        segment = Segment(
            slip,
            self.theta,
            self.omega,
            (self._tau(self.t), self.tau[1]),
            (self._f_ext(self.t), self.f_ext[1]),
            self.length - self.t,
            mech.upper if slip.sigma > 0 else mech.lower,
            edge,
        )
        out = self.flow.advance(mech, segment)
        self.t += out.time
        self.theta, self.omega = out.theta, out.omega
        for name, value in zip(FLOWS, out.flows, strict=True):
            self.account[name] += value
        self.peak["omega"] = max(self.peak["omega"], out.peak_omega)
        self._note_x(*out.peak_x)
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

    def _cross(self, slip: Slip, causes: set[str]) -> None:
        """A contact load vanished: change that flank; if both vanished, enter anew."""
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
            load = mech.load(kin, self.slip, self.omega, self._tau(self.t), self._f_ext(self.t))
            reach = max(abs(self.theta), mech.upper - mech.lower)
            if load.alpha * self.omega < 0 and self.omega**2 < 2 * abs(load.alpha) * reach * 2.0**-53:
                self.doubts.append("bounces within rounding")
                self.omega = self.omega * 0
        self.account["heat_stop"] += before - mech.kinetic_energy(kin, self.omega)
        if self.omega == 0:
            self._decide()

    def _jump(self, sigma: int) -> None:
        """Play operator: along the band edge until it holds the torque, or to the stop."""
        mech, tau = self.mechanism, self._tau(self.t)
        kin = mech.groove.at(self.theta)
        f_ext, k = self._f_ext(self.t), mech.spring[1]
        f0 = mech.spring_force(kin.z) + f_ext
        limit = mech.upper if sigma > 0 else mech.lower
        slope = k * kin.dz
        end = limit
        if k > 0:
            ratio = self._edge(sign(tau) * sigma or 1)
            if ratio is not None and not (ratio < 0):
                end = self.theta + (tau / ratio - f0) / slope if tau != 0 else self.theta - f0 / slope
            if (end - limit) * sigma > 0:
                end = limit
        if (end - self.theta) * sigma < 0:
            end = self.theta
        knots = [self.theta, end]
        if k > 0:
            zero = self.theta - f0 / slope
            if (zero - self.theta) * (end - zero) > 0:
                knots.insert(1, zero)
        for a, b in pairwise(knots):
            self._edge_path(sigma, a, b, f0 + slope * (a - self.theta), f0 + slope * (b - self.theta))
        self.account["work_ext"] += f_ext * kin.dz * (end - self.theta)
        self.theta = end

    def _edge_path(self, sigma: int, a: Number, b: Number, fa: Number, fb: Number) -> None:
        """Accounts of quasi-static motion from angle a to b, with F_0 from fa to fb of one sign: all are
        linear in F_0, so the mean load counts. work_ext is the caller's."""
        mech = self.mechanism
        kin = mech.groove.at(a)
        mean = (fa + fb) / 2
        ratio = self._edge(sigma * (sign(mean) or 1))
        if a == b:
            return
        if ratio is None:
            raise Refused("moving wedge")
        q = self._static_balance(kin, sigma, sign(mean) or 1)
        xi1, xi2 = mech.r2 * q.n2 / q.delta, mech.r1 * q.n1 / q.delta  # x_i per F_0
        for f in (fa, fb):
            self._note_x(f * xi1, f * xi2)
        turned = abs(b - a)
        self.account["work_in"] += ratio * mean * (b - a)
        self.account["heat_cam1"] += (
            mech.mu1 * abs(mean * xi1) * (mech.r1**2 + kin.a1**2) * kin.dgamma * turned
        )
        self.account["heat_cam2"] += (
            mech.mu2 * abs(mean * xi2) * (mech.r2**2 + kin.a2**2) * (1 - kin.dgamma) * turned
        )

    def _static_balance(self, kin: Kinematics, sigma: int, s: int) -> Balance:
        """Coefficients of static sliding in direction sigma under a load of sign s."""
        mech = self.mechanism
        for e in ((s, s), (s, -s), (-s, s), (-s, -s)):
            q = mech.balance(kin, Slip(sigma, e))
            if q.delta == 0:
                continue
            x1, x2 = s * mech.r2 * q.n2 / q.delta, s * mech.r1 * q.n1 / q.delta
            if (e[0] * x1 >= 0 or mech.mu1 == 0) and (e[1] * x2 >= 0 or mech.mu2 == 0):
                return q
        raise Refused("no consistent flanks")

    def _follow_edge(self) -> bool:
        """Quasi-static motion along the edge under ramps: theta is linear in time."""
        mech, speed = self.mechanism, self.follow
        kin = mech.groove.at(self.theta)
        limit = mech.upper if speed > 0 else mech.lower
        ends = {"end": self.length - self.t, "stop": (limit - self.theta) / speed}
        if self.tau[1] != 0:
            kink = -self._tau(self.t) / self.tau[1]  # F_0 = tau/ratio changes sign
            if kink > self.arithmetic.tiny * self.length:
                ends["kink"] = kink
        cause = min(ends, key=lambda name: ends[name])
        dt = ends[cause]
        if any(abs(t - dt) <= 1e-12 * self.length for name, t in ends.items() if name != cause):
            self.doubts.append("two switches at once")
        theta = limit if cause == "stop" else self.theta + speed * dt
        fs = mech.spring_force(kin.z)
        fs_end = mech.spring_force(mech.groove.at(theta).z)
        before, after = fs + self._f_ext(self.t), fs_end + self._f_ext(self.t + dt)
        turned, held = theta - self.theta, self.account["work_in"]
        self._edge_path(sign(speed), self.theta, theta, before, after)
        self.account["work_in"] = held + (self._tau(self.t) + self._tau(self.t + dt)) / 2 * turned
        self.account["work_ext"] += self._f_ext(self.t + dt / 2) * kin.dz * turned
        self.peak["omega"] = max(self.peak["omega"], abs(speed))
        self.t += dt
        self.theta = theta
        if cause == "end":
            return True
        self.omega = speed * 0
        self._decide()
        return False

    def _point(self) -> Point:
        mech = self.mechanism
        kin = mech.groove.at(self.theta)
        if self.slip is None and self.follow is None:
            self._note_rest(self.length)
        energy = {name: value for name, value in self.account.items()}
        energy["work_tuning"] = self.omega * 0
        energy["spring"] = mech.spring_energy(kin.z)
        energy["kinetic"] = mech.kinetic_energy(kin, self.omega)
        heat = sum(energy[name] for name in HEATS)
        energy["residual"] = energy["work_in"] - energy["work_ext"] - heat - (self._stored() - self.stored)
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


def _simulate(params: Mapping[str, float], intervals: Sequence[Interval], flow: Flow) -> list[Point]:
    simulation = Simulation(params, flow, intervals[0])
    return [simulation.run(interval, first=i == 0) for i, interval in enumerate(intervals)]


def simulate(params: Mapping[str, float], intervals: Sequence[Interval]) -> list[Point]:
    """Integrates numerically, in double precision. One Point at the end of each interval."""
    return _simulate(params, intervals, OdeFlow())


def simulate_exact(params: Mapping[str, float], intervals: Sequence[Interval]) -> list[Point]:
    """Solves in closed form at 60 digits. One Point at the end of each interval."""
    return _simulate(params, intervals, ExactFlow())


# ---- scenes -------------------------------------------------------------------------------------


def random_scene(rng: np.random.Generator) -> tuple[dict[str, float], list[Interval]]:
    """A varied, well-posed scene with helical grooves. Sizes follow from a characteristic axial force, so
    that the mechanism moves, reaches its stops, sticks and turns round; the number of swings is bounded."""
    while True:
        scene = _draw_scene(rng)
        if scene is not None:
            return scene


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _mixed(rng: np.random.Generator, zero_share: float, draw: Callable[[], float]) -> float:
    return 0.0 if rng.random() < zero_share else float(draw())


def _draw_scene(rng: np.random.Generator) -> tuple[dict[str, float], list[Interval]] | None:
    p: dict[str, float] = {}
    lead_ranges = [(0.35, 1.1), (0.05, 0.35), (1.1, 1.4)]
    for i in (1, 2):
        p[f"cam{i}.radius"] = rng.uniform(0.005, 0.05)
        p[f"cam{i}.lead_angle"] = rng.uniform(*lead_ranges[rng.choice(3, p=[0.6, 0.25, 0.15])])
        p[f"cam{i}.friction"] = _mixed(rng, 0.15, lambda: rng.uniform(0.0, 0.5) * rng.choice([1.0, 0.4]))
    if rng.random() < 0.1:
        p["cam1.friction"] = p["cam2.friction"] = 0.0
    p["contacts"] = int(rng.integers(1, 3))
    p["stop.upper"] = rng.uniform(0.3, 2.5)
    p["stop.lower"] = _mixed(rng, 0.6, lambda: -rng.uniform(0.1, 1.5))
    p["stop.restitution"] = _mixed(rng, 0.3, lambda: rng.uniform(0.05, 0.9))
    span = p["stop.upper"] - p["stop.lower"]
    start = rng.choice(4, p=[0.4, 0.15, 0.15, 0.3])
    middle = rng.uniform(p["stop.lower"], p["stop.upper"])
    p["initial.theta"] = float([0.0, p["stop.lower"], p["stop.upper"], middle][start])

    probe = Mechanism(p, DOUBLE)
    kin = probe.groove.at(0.0)
    up, dz, dgamma = probe.static_ratio(kin, +1), kin.dz, kin.dgamma
    if up is None or up > 30 * dz:  # a loading jam, or nearly
        return None
    force = _log_uniform(rng, 3.0, 3000.0)
    p["spring.stiffness"] = _mixed(rng, 0.12, lambda: force / (dz * span) * _log_uniform(rng, 0.1, 3.0))
    p["spring.preload"] = _mixed(rng, 0.25, lambda: force * rng.uniform(0.02, 1.0))
    torque = up * force
    stiffness = max(p["spring.stiffness"], 0.1 * force / (dz * span)) * dz * dz  # as seen by cam 2
    regime = rng.choice(["inertial", "viscous", "quasi-static"], p=[0.7, 0.15, 0.15])
    time = _log_uniform(rng, 1e-2, 1.0)
    p["inertia.shaft"] = 0.0
    if regime == "inertial":
        # J 1e-5..1, but slow enough for at most some tens of swings per interval
        shaft = max(_log_uniform(rng, 1e-5, 1.0), stiffness * 1e-6)
        p["inertia.shaft"] = _mixed(rng, 0.05, lambda: shaft)
        p["inertia.follower_mass"] = _mixed(rng, 0.5, lambda: shaft / dz**2 * _log_uniform(rng, 0.01, 5.0))
        p["inertia.follower"] = _mixed(rng, 0.5, lambda: shaft / dgamma**2 * _log_uniform(rng, 0.01, 5.0))
        inertia = p["inertia.shaft"] + p["inertia.follower_mass"] * dz**2 + p["inertia.follower"] * dgamma**2
        if inertia == 0:
            return None
        time = 2 * math.pi * math.sqrt(inertia / stiffness)
        critical = 2 * math.sqrt(inertia * stiffness)
        for side in ("load", "release"):
            draw = lambda: critical / dz**2 * _log_uniform(rng, 0.01, 30.0)  # noqa: E731
            p[f"damper.c_{side}"] = _mixed(rng, 0.35, draw)
        p["shaft.damping"] = _mixed(rng, 0.5, lambda: critical * _log_uniform(rng, 0.01, 10.0))
        speed = math.sqrt(torque * span / inertia)
        p["initial.omega"] = _mixed(rng, 0.6, lambda: speed * rng.uniform(-1.0, 1.0))
        at_stop = p["initial.theta"] in (p["stop.lower"], p["stop.upper"])
        if at_stop and (p["initial.omega"] > 0) == (p["initial.theta"] == p["stop.upper"]):
            p["initial.omega"] *= -1.0
    elif regime == "viscous":
        for side in ("load", "release"):
            draw = lambda: stiffness / dz**2 * time * _log_uniform(rng, 0.03, 30.0)  # noqa: E731
            p[f"damper.c_{side}"] = _mixed(rng, 0.25, draw)
        p["shaft.damping"] = _mixed(rng, 0.5, lambda: stiffness * time * _log_uniform(rng, 0.03, 10.0))
    if regime == "inertial" and not _inertia_is_positive(p):
        return None

    ramps, pulls = rng.random() < 0.35, rng.random() < 0.5
    longest = min(1.0, max(4e-3, 6.0 * time))
    intervals = []
    for _ in range(rng.integers(5, 21)):
        duration = _log_uniform(rng, max(1e-3, min(0.02 * time, 0.3 * longest)), longest)
        tau = torque * rng.choice([0.0, rng.uniform(-2.0, 0.3), rng.uniform(0.0, 1.0), rng.uniform(0.5, 3.0)])
        pull = force * rng.choice([0.0, rng.uniform(-2.0, 0.0), rng.uniform(-0.5, 1.0)]) if pulls else 0.0
        rates = [0.0, 0.0]
        if ramps and rng.random() < 0.6:
            rates[0] = torque * rng.uniform(-3.0, 3.0) / duration
        if ramps and pulls and rng.random() < 0.5:
            rates[1] = force * rng.uniform(-2.0, 2.0) / duration
        intervals.append(Interval(duration, float(tau), rates[0], float(pull), rates[1]))
    return p, intervals


def _inertia_is_positive(params: Mapping[str, float]) -> bool:
    """Does more torque mean more acceleration on the flanks that statics chooses, in both directions?"""
    mech = Mechanism(params, DOUBLE)
    kin = mech.groove.at(0.0)
    for sigma in (+1, -1):
        for e in ((1, 1), (-1, -1), (1, -1), (-1, 1)):
            slip = Slip(sigma, e)
            q = mech.balance(kin, slip)
            x1, x2 = e[0] * q.n2 * q.delta, e[1] * q.n1 * q.delta
            used = (x1 >= 0 and x2 >= 0) or (x1 <= 0 and x2 <= 0)
            if used and not mech._inertia_and_drag(kin, slip)[1] * q.delta > 0:
                return False
    return True
