"""Independent reference simulator of the dual cylindrical cam, the oracle of the accuracy tests.

It shares nothing with the C core but the equations. Two ways to integrate are built on one event
logic, which is generic in the number type:

`simulate`        DOP853 at rtol 1e-13 in double precision; the accounts are extra states; events are
                  bracketed on the dense output and polished by integrating again from the last
                  accepted step. Any grooves, springs and dampers, inputs cubic in time; steps end
                  where a table's third derivative jumps.
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

Grooves g_i(psi) have a_i = g_i' and curvature b_i = g_i''. With gamma the root of g_1(gamma) = g_2(phi),
phi = theta - gamma, and a prime for d/dtheta:

    gamma' = a_2/(a_1 + a_2)     gamma'' = (b_2 phi'^2 - b_1 gamma'^2)/(a_1 + a_2)
    z' = a_1 gamma'              z'' = (a_2 b_1 gamma'^2 + a_1 b_2 phi'^2)/(a_1 + a_2)
    a_1' = b_1 gamma'            a_2' = b_2 phi'
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import mpmath
import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

Number = Any  # float, or mpf: the event logic works on either
Flanks = tuple[int, int]
Polynomial = tuple[Number, ...]  # coefficients, from the constant one

STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP, WEDGED = 1, 2, 3, 4, 5, 6
FLOWS = ("work_in", "work_ext", "heat_cam1", "heat_cam2", "heat_damper", "heat_shaft")  # integrated in time
HEATS = ("heat_cam1", "heat_cam2", "heat_damper", "heat_shaft", "heat_stop")
ENERGIES = ("work_in", "work_ext", "work_tuning", "spring", "kinetic", *HEATS, "residual")
PEAKS = ("torque", "omega", "reaction1", "reaction2")

Params = Mapping[str, Any]  # numbers, and paths of tables

DEFAULTS: dict[str, Any] = {
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
            "table": "",
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
CAM = [name.removeprefix("cam1.") for name in DEFAULTS if name.startswith("cam1.")]
INTEGERS = frozenset(
    name for name in DEFAULTS if name.endswith(("profile", "curvature")) or name == "contacts"
)


class Refused(ValueError):
    """The scene has no well-posed answer: loading jam, moving wedge, or no consistent flanks."""


@dataclass(frozen=True)
class Interval:
    """Inputs over `duration` seconds: u(t) = sum of u_k t^k/k!, with u_k the value and the derivatives at
    the start."""

    duration: float
    tau: float
    tau_rate: float = 0.0
    F_ext: float = 0.0
    F_ext_rate: float = 0.0
    tau_rate2: float = 0.0
    tau_rate3: float = 0.0
    F_ext_rate2: float = 0.0
    F_ext_rate3: float = 0.0

    def coefficients(self, name: str, number: Callable[[Any], Number] = float) -> Polynomial:
        """Coefficients of input `name` in t; trailing zeros beyond the linear term left out."""
        u = [number(getattr(self, name + order)) for order in ("", "_rate", "_rate2", "_rate3")]
        u[2], u[3] = u[2] / 2, u[3] / 6
        while len(u) > 2 and u[-1] == 0:
            u.pop()
        return tuple(u)

    def at(self, name: str, t: float) -> list[float]:
        """Value and three derivatives of input `name` at time t of the interval."""
        u = [getattr(self, name + order) for order in ("", "_rate", "_rate2", "_rate3")]
        return [
            math.fsum(u[k + j] * t**j / math.factorial(j) for j in range(4 - k)) for k in range(4)
        ]  # fmt: skip


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


def poly(c: Sequence[Number], t: Number) -> Number:
    total = c[-1]
    for a in c[-2::-1]:
        total = total * t + a
    return total


def poly_derivative(c: Sequence[Number]) -> Polynomial:
    return tuple(k * a for k, a in enumerate(c) if k) or (c[0] * 0,)


def poly_shift(c: Sequence[Number], t: Number) -> Polynomial:
    """Coefficients in the time from t on."""
    found, factorial = [], 1
    d = tuple(c)
    for k in range(len(c)):
        factorial *= max(k, 1)
        found.append(poly(d, t) / factorial)
        d = poly_derivative(d)
    return tuple(found)


def poly_zeros(c: Sequence[Number], a: Number, b: Number) -> list[Number]:
    """Sign changes in (a, b); between those of the derivative the polynomial is monotone."""
    c = list(c)
    while len(c) > 1 and c[-1] == 0:
        c.pop()
    if len(c) == 1:
        return []
    if len(c) == 2:
        return [t for t in [-c[0] / c[1]] if a < t < b]
    knots = [a, *poly_zeros(poly_derivative(c), a, b), b]
    values = [poly(c, t) for t in knots]
    pieces = zip(pairwise(knots), pairwise(values), strict=True)
    return [
        brentq(lambda t: poly(c, t), *ends, xtol=1e-16 * (b - a), rtol=1e-15)
        for ends, (f, g) in pieces
        if sign(f) * sign(g) < 0
    ]


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
    da1: Number = 0
    da2: Number = 0


class Helices:
    """Two plain helices: everything is linear in theta."""

    def __init__(self, a1: Number, a2: Number) -> None:
        self.a1, self.a2 = a1, a2
        self.dgamma, self.dz = a2 / (a1 + a2), a1 * a2 / (a1 + a2)

    def at(self, theta: Number, piece: int | None = None) -> Kinematics:
        dgamma, dz = self.dgamma, self.dz
        return Kinematics(self.a1, self.a2, dgamma * theta, dgamma, 0, dz * theta, dz, 0)

    def ahead(self, theta: Number, sigma: int) -> tuple[int, Number | None]:
        """The smooth piece that motion in direction sigma from theta is on, and where it ends."""
        return 0, None


class Groove(Protocol):
    """z = g(psi), g(0) = 0, as smooth pieces between knots."""

    knots: Sequence[float]
    range: tuple[float, float]  # of psi, where g' >= 0 holds

    def derivatives(self, psi: float, piece: int) -> tuple[float, float, float]:
        """g, g', g'' of a piece, which goes on smoothly beyond its ends."""
        ...


class Helix:
    """g = a psi."""

    knots: Sequence[float] = ()
    range = (-math.inf, math.inf)

    def __init__(self, a: float) -> None:
        self.a = a

    def derivatives(self, psi: float, piece: int) -> tuple[float, float, float]:
        return self.a * psi, self.a, 0.0


class Ellipse:
    """z = kappa b (sqrt(1 - S0^2) - sqrt(1 - S^2)), S = S0 + kappa r psi/a; the difference of the roots is
    (S^2 - S0^2)/(their sum). g' = r (b/a) S/sqrt(1 - S^2), g'' = kappa (r/a)^2 b/(1 - S^2)^(3/2)."""

    knots: Sequence[float] = ()

    def __init__(self, r: float, lead: float, a: float, b: float, kappa: int) -> None:
        steep = a / b * math.tan(lead)
        self.s0 = steep / math.hypot(1.0, steep)
        self.c0 = 1.0 / math.hypot(1.0, steep)
        self.turn, self.kappa, self.b = r / a, kappa, b
        ends = [(s - self.s0) / (kappa * self.turn) for s in (0.0, 1.0)]
        self.range = min(ends), max(ends)

    def derivatives(self, psi: float, piece: int) -> tuple[float, float, float]:
        way = self.turn * psi
        s = self.s0 + self.kappa * way
        square = (1.0 - s) * (1.0 + s)
        if square <= 0.0:
            return math.nan, math.nan, math.nan
        c = math.sqrt(square)
        scale = self.turn * self.b / c
        return (
            self.b * way * (s + self.s0) / (self.c0 + c),
            scale * s,
            self.kappa * self.turn * scale / square,
        )


class Table:
    """Quintic Hermite pieces through (psi_j, z_j), twice continuously differentiable and monotone.

    Slope d_j and second derivative c_j are those of the polynomial through the five nearest knots (four, if
    there are no more). With the pieces' mean slopes Delta and widths h:
    1. d_j = max(d_j, 0); d_j = c_j = 0 beside a piece with Delta = 0
    2. c_j into [-4 d_j/h_right, 4 d_j/h_left]: then all Bernstein coefficients of g' but the middle one
       are >= 0
    3. per piece f = min(1, 5 Delta/s), s = 2 d_0 + c_0 h/4 + 2 d_1 - c_1 h/4: then so is the middle one
    4. d_j, c_j times the smaller f of the pieces beside knot j
    """

    def __init__(self, psi: Sequence[float], z: Sequence[float]) -> None:
        x, y = [float(v) for v in psi], [float(v) for v in z]
        if len(x) < 4 or any(b <= a for a, b in pairwise(x)) or any(b < a for a, b in pairwise(y)):
            raise Refused("a table needs 4 increasing points")
        h = [b - a for a, b in pairwise(x)]
        mean = [(b - a) / w for (a, b), w in zip(pairwise(y), h, strict=True)]
        n = len(x)
        d, c = [0.0] * n, [0.0] * n
        for j in range(n):
            d[j], c[j] = self._local_derivatives(x, y, j)
            beside = [k for k in (j - 1, j) if 0 <= k < n - 1]
            d[j] = max(d[j], 0.0)
            if any(mean[k] == 0 for k in beside):
                d[j] = c[j] = 0.0
            if j < n - 1:
                c[j] = max(c[j], -4 * d[j] / h[j])
            if j > 0:
                c[j] = min(c[j], 4 * d[j] / h[j - 1])
        factor = []
        for k in range(n - 1):
            s = 2 * d[k] + c[k] * h[k] / 4 + 2 * d[k + 1] - c[k + 1] * h[k] / 4
            factor.append(min(1.0, 5 * mean[k] / s) if s > 0 else 1.0)
        for j in range(n):
            f = min(factor[k] for k in (j - 1, j) if 0 <= k < n - 1)
            d[j], c[j] = f * d[j], f * c[j]
        self.knots, self.range, self.slopes, self.seconds = x, (x[0], x[-1]), d, c
        self.pieces = [
            self._piece(x[k], h[k], y[k], y[k + 1] - y[k], d[k], d[k + 1], c[k], c[k + 1])
            for k in range(n - 1)
        ]
        if not x[0] <= 0 <= x[-1]:
            raise Refused("a table must hold psi = 0")
        zero = self.derivatives(0.0, min(max(bisect_right(x, 0.0) - 1, 0), n - 2))[0]
        self.pieces = [(start, c0 - zero, *rest) for start, c0, *rest in self.pieces]

    @staticmethod
    def _local_derivatives(x: list[float], y: list[float], j: int) -> tuple[float, float]:
        """First and second derivative at x_j of the polynomial through the nearest knots, by Newton's form
        with x_j as the first point: p = y_j + t (u_1 + (t - t_1)(u_2 + (t - t_2)(u_3 + ...)))."""
        size = min(5, len(x))
        start = min(max(j - 2, 0), len(x) - size)
        order = [j] + [i for i in range(start, start + size) if i != j]
        t = [x[i] - x[j] for i in order]
        u = [y[i] - y[j] for i in order]
        for level in range(1, size):
            for i in range(size - 1, level - 1, -1):
                u[i] = (u[i] - u[i - 1]) / (t[i] - t[i - level])
        inner, slope = u[-1], 0.0  # of the factor of t
        for i in range(size - 2, 0, -1):
            slope = inner - t[i] * slope
            inner = u[i] - t[i] * inner
        return inner, 2 * slope

    @staticmethod
    def _piece(
        start: float, h: float, y: float, rise: float, d0: float, d1: float, c0: float, c1: float
    ) -> tuple[float, ...]:
        return (
            start,
            y,
            d0,
            c0 / 2,
            (20 * rise - (8 * d1 + 12 * d0) * h - (3 * c0 - c1) * h * h) / (2 * h**3),
            (-30 * rise + (14 * d1 + 16 * d0) * h + (3 * c0 - 2 * c1) * h * h) / (2 * h**4),
            (12 * rise - 6 * (d1 + d0) * h - (c0 - c1) * h * h) / (2 * h**5),
        )

    def derivatives(self, psi: float, piece: int) -> tuple[float, float, float]:
        start, c0, c1, c2, c3, c4, c5 = self.pieces[piece]
        t = psi - start
        return (
            c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))),
            c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4 + t * (5 * c5)))),
            2 * c2 + t * (6 * c3 + t * (12 * c4 + t * (20 * c5))),
        )


HELIX, ELLIPSE, TABLE = 1, 2, 3


def read_table(path: str | Path) -> tuple[list[float], list[float]]:
    """psi and z of a CSV file, with or without a line of names."""
    lines = [line.split(",") for line in Path(path).read_text().splitlines() if line.strip()]
    if any(character.isalpha() and character not in "eE" for character in lines[0][0]):
        lines = lines[1:]
    return [float(line[0]) for line in lines], [float(line[1]) for line in lines]


def write_table(path: str | Path, psi: Iterable[float], z: Iterable[float]) -> None:
    rows = [f"{float(a)!r},{float(b)!r}" for a, b in zip(psi, z, strict=True)]
    Path(path).write_text("\n".join(["psi_rad,z_m", *rows]) + "\n")


def groove_of(params: Params, i: int) -> Groove:
    p = {name: params.get(f"cam{i}.{name}", DEFAULTS[f"cam{i}.{name}"]) for name in CAM}
    if p["profile"] == HELIX:
        return Helix(p["radius"] * math.tan(p["lead_angle"]))
    if p["profile"] == ELLIPSE:
        curvature = int(p["ellipse_curvature"])
        return Ellipse(p["radius"], p["lead_angle"], p["ellipse_a"], p["ellipse_b"], curvature)
    return Table(*read_table(p["table"]))


class Grooves:
    """Any two grooves: gamma is the root of g1(gamma) = g2(theta - gamma), to rounding.

    Between the angles where either pin passes a knot everything is smooth: `breaks` holds these, and each
    piece between them one piece of either groove and, on a grid, gamma and its slope as a first guess."""

    cells = 12  # of the grid, per piece; more for grooves without knots
    margin = 1e-12  # breaks nearer than this are one

    def __init__(self, first: Groove, second: Groove, lower: float, upper: float) -> None:
        self.first, self.second, self.lower, self.upper = first, second, lower, upper
        ends = [self._solve(theta) for theta in (lower, upper)]
        for groove, psi in ((first, ends), (second, [lower - ends[0], upper - ends[1]])):
            if not (groove.range[0] <= psi[0] and psi[1] <= groove.range[1]):
                raise Refused("a groove is left inside the stops")
        used = [(ends[0], ends[1]), (lower - ends[0], upper - ends[1])]
        breaks = self._passes(first, second, *used) + self._passes(second, first, *used[::-1])
        breaks = sorted(theta for theta in breaks if lower + self.margin < theta < upper - self.margin)
        self.breaks = [b for a, b in pairwise([lower, *breaks]) if b - a > self.margin]
        bounds = [lower, *self.breaks, upper]
        self.pieces: list[tuple[int, int]] = []
        self.grids: list[tuple[float, float, list[float], list[float]]] = []
        for a, b in pairwise(bounds):
            middle = (a + b) / 2
            gamma = self._solve(middle)
            self.pieces.append((self._index(first, gamma), self._index(second, middle - gamma)))
            cells = self.cells if len(bounds) > 4 else 16 * self.cells
            width = (b - a) / cells
            found = [self._at(a, *self.pieces[-1], self._solve(a))]
            for k in range(1, cells + 1):
                guess = found[-1].gamma + width * found[-1].dgamma
                found.append(self._at(a + k * width, *self.pieces[-1], guess))
            self.grids.append((a, width, [k.gamma for k in found], [k.dgamma for k in found]))

    @staticmethod
    def _index(groove: Groove, psi: float) -> int:
        return min(max(bisect_right(groove.knots, psi) - 1, 0), max(len(groove.knots) - 2, 0))

    @classmethod
    def _value(cls, groove: Groove, psi: float) -> float:
        """g, with slope 1 beyond its range, so that there is always one root."""
        inside = min(max(psi, groove.range[0]), groove.range[1])
        if isinstance(groove, Ellipse):  # at the end of its range the slope is infinite
            low, high = groove.range
            inside = min(max(inside, low + 1e-13 * (high - low)), high - 1e-13 * (high - low))
        return groove.derivatives(inside, cls._index(groove, inside))[0] + (psi - inside)

    def _solve(self, theta: float) -> float:
        """gamma by bisection alone, between 0 and theta, to the last bit."""
        low, high = min(0.0, theta), max(0.0, theta)
        while True:
            middle = (low + high) / 2
            if not low < middle < high:
                return middle
            if self._value(self.first, middle) < self._value(self.second, theta - middle):
                low = middle
            else:
                high = middle

    @classmethod
    def _passes(
        cls, groove: Groove, other: Groove, used: tuple[float, float], others: tuple[float, float]
    ) -> list[float]:
        """theta where the pin passes the knots of one groove; in a dwell of the other, any such."""
        found = []
        for psi in groove.knots:
            if not used[0] <= psi <= used[1]:
                continue
            z = cls._value(groove, psi)
            low, high = others
            while True:
                middle = (low + high) / 2
                if not low < middle < high:
                    break
                low, high = (middle, high) if cls._value(other, middle) < z else (low, middle)
            found.append(psi + middle)
        return found

    def ahead(self, theta: float, sigma: int) -> tuple[int, float | None]:
        """The smooth piece that motion in direction sigma from theta is on, and where it ends."""
        if sigma > 0:
            piece = bisect_right(self.breaks, theta + self.margin / 2)
            return piece, self.breaks[piece] if piece < len(self.breaks) else None
        piece = bisect_right(self.breaks, theta - self.margin / 2)
        return piece, self.breaks[piece - 1] if piece > 0 else None

    def at(self, theta: float, piece: int | None = None) -> Kinematics:
        """Kinematics; of a given piece, which goes on smoothly a little beyond its ends."""
        index = bisect_right(self.breaks, theta) if piece is None else piece
        start, width, gammas, slopes = self.grids[index]
        place = (theta - start) / width
        last = len(gammas) - 2
        if not -2 < place < last + 3:  # only a trial step of the integrator gets there
            if piece is not None:
                return self.at(theta)
            return self._at(theta, *self.pieces[index], self._solve(theta) if place == place else theta)
        cell = min(max(int(place), 0), last)
        t = place - cell
        g, h, d, e = gammas[cell], gammas[cell + 1], width * slopes[cell], width * slopes[cell + 1]
        guess = g + t * (d + t * (3 * (h - g) - 2 * d - e + t * (2 * (g - h) + d + e)))
        return self._at(theta, *self.pieces[index], guess)

    def _at(self, theta: float, i: int, j: int, gamma: float) -> Kinematics:
        """Kinematics on one piece of either groove, by Newton's method from a guess of gamma."""
        first, second = self.first.derivatives, self.second.derivatives
        for _ in range(12):
            z, a1, b1 = first(gamma, i)
            other, a2, b2 = second(theta - gamma, j)
            total = a1 + a2
            if not total > 0:
                return Kinematics(*[math.nan] * 10)
            step = (other - z) / total
            if abs(step) <= 1e-15 * (abs(theta) + abs(z) / total):
                break
            gamma += step
        dgamma, dphi = a2 / total, a1 / total
        bend1, bend2 = b1 * dgamma * dgamma, b2 * dphi * dphi
        return Kinematics(
            a1,
            a2,
            gamma,
            dgamma,
            (bend2 - bend1) / total,
            z,
            a1 * dgamma,
            (a2 * bend1 + a1 * bend2) / total,
            b1 * dgamma,
            b2 * dphi,
        )


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

    def __init__(self, params: Params, arithmetic: Arithmetic) -> None:
        unknown = set(params) - set(DEFAULTS)
        if unknown:
            raise KeyError(f"no such parameter: {sorted(unknown)}")
        given = {**DEFAULTS, **params}
        p: dict[str, Any] = {
            name: value if isinstance(value, str) else arithmetic.number(value)
            for name, value in given.items()
        }
        self.arithmetic = arithmetic
        self.r1, self.r2 = p["cam1.radius"], p["cam2.radius"]
        self.mu1, self.mu2 = p["cam1.friction"], p["cam2.friction"]
        self.spring = [p["spring.preload"]] + [p[f"spring.stiffness{i}"] for i in ("", "2", "3")]
        self.damper = {
            +1: (p["damper.c_load"], p["damper.q_load"]),
            -1: (p["damper.c_release"], p["damper.q_release"]),
        }
        self.J, self.m, self.I = (p[f"inertia.{part}"] for part in ("shaft", "follower_mass", "follower"))
        self.b = p["shaft.damping"]
        self.lower, self.upper = p["stop.lower"], p["stop.upper"]
        self.groove = self._grooves(p)
        ends = [abs(self.groove.at(theta).z) for theta in (self.lower, self.upper)]
        self.reach = max(ends)  # of the follower
        self.restitution = p["stop.restitution"]
        self.theta0, self.omega0 = p["initial.theta"], p["initial.omega"]
        self.contacts = p["contacts"]
        self.inertial = bool(self.J + self.m + self.I > 0)
        self._balances: dict[Slip, tuple[Number, Number, Balance]] = {}
        self.linear = not any(self.spring[2:]) and not any(q for _, q in self.damper.values())
        self.linear = self.linear and isinstance(self.groove, Helices)

    def _grooves(self, p: Params) -> Helices | Grooves:
        """Two plain helices in closed form; anything else in double precision."""
        profiles = [int(p[f"cam{i}.profile"]) for i in (1, 2)]
        if profiles == [HELIX, HELIX]:
            slopes = [p[f"cam{i}.radius"] * self.arithmetic.tan(p[f"cam{i}.lead_angle"]) for i in (1, 2)]
            return Helices(*slopes)
        if self.arithmetic is not DOUBLE:
            raise NotImplementedError("60 digits need helical grooves")
        return Grooves(groove_of(p, 1), groove_of(p, 2), self.lower, self.upper)

    def force_scale(self, kin: Kinematics, f_ext: Number) -> Number:
        """Size of the terms whose sum is F_0."""
        return sum(abs(c) * self.reach**i for i, c in enumerate(self.spring)) + abs(f_ext)

    def viscous(self, sigma: int) -> bool:
        """Without inertia: does any damper act in this direction?"""
        return bool(self.b + sum(self.damper[sigma]) > 0)

    def spring_force(self, z: Number) -> Number:
        force, k, k2, k3 = self.spring
        return force + z * (k + z * (k2 + z * k3))

    def spring_slope(self, z: Number) -> Number:
        _, k, k2, k3 = self.spring
        return k + z * (2 * k2 + z * 3 * k3)

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
            alpha = omega * 0
            omega = self._damped_speed(kin, q, slip.sigma, tau, f0)
            force = f0 + self.damper_force(slip.sigma, kin.dz * omega)
        axial = force + self.m * (kin.dz * alpha + kin.ddz * omega**2)
        moment = self.I * (kin.dgamma * alpha + kin.ddgamma * omega**2)
        x1 = (self.r2 * q.n2 * axial - q.d2 * moment) / q.delta
        x2 = (self.r1 * q.n1 * axial + q.d1 * moment) / q.delta
        return Load(omega, alpha, x1, x2)

    def _damped_speed(self, kin: Kinematics, q: Balance, sigma: int, tau: Number, f0: Number) -> Number:
        """Without inertia: omega from delta (tau - b omega) = product (f0 + D(z' omega)).
        w = sigma omega >= 0 is the root of A w^2 + B w = C that vanishes with C; if C < 0 this is the
        continuation through w = 0, odd in C, so that the zero of omega can be located."""
        c, quadratic = self.damper[sigma]
        first = q.delta * self.b + q.product * c * kin.dz
        drive = q.delta * tau - q.product * f0
        if quadratic == 0 or kin.dz == 0:
            return drive / first
        if q.delta < 0:
            first, drive = -first, -drive
        second = abs(q.product) * quadratic * kin.dz**2
        if (q.product < 0) != (q.delta < 0):
            second = -second
        under = first * first + 4 * second * abs(drive)
        if under < 0:
            return math.nan
        return 2 * drive / (first + under**0.5) if drive != 0 else drive

    def scales(self, kin: Kinematics, slip: Slip, omega: Number, tau: Number, f_ext: Number) -> Load:
        """Sizes of the terms whose sums make up a Load; against them a sum counts as zero."""
        q, (drag, mass) = self.balance(kin, slip), self._inertia_and_drag(kin, slip)
        axial, torque, turning = self.force_scale(kin, f_ext), abs(tau), 0 * omega
        span = max(abs(self.lower), abs(self.upper))
        if self.inertial:
            # second derivatives are sums of terms of at least the size they have over the whole way
            centrifugal = self.m * (abs(kin.ddz) + self.reach / span**2) * omega**2
            turning = self.I * (abs(kin.ddgamma) + 1 / span) * omega**2
            axial += abs(self.damper_force(slip.sigma, kin.dz * omega)) + centrifugal
            torque += self.b * abs(omega) + turning
        drive = abs(q.delta) * torque + abs(q.product) * axial
        c, quadratic = self.damper[slip.sigma]
        if self.inertial:
            start = drive / abs(mass)
            axial += self.m * kin.dz * start
        else:
            second = abs(q.product) * quadratic * kin.dz**2
            start = 2 * drive / (abs(drag) + (drag * drag + 4 * second * drive) ** 0.5)
            axial += (c + quadratic * kin.dz * start) * kin.dz * start
        moment = self.I * kin.dgamma * start + turning
        least = self.reach / span / 1000  # in a dwell there is no slope
        return Load(
            start * (not self.inertial),
            start * self.inertial,
            (self.r2 * (kin.a2 + self.mu2 * self.r2 + least) * axial + abs(q.d2) * moment) / abs(q.delta),
            (self.r1 * (kin.a1 + self.mu1 * self.r1 + least) * axial + abs(q.d1) * moment) / abs(q.delta),
        )

    def rate(self, kin: Kinematics, slip: Slip, omega: Number = 0) -> Number:
        """About the fastest rate of change, 1/s; used to size look-aheads and steps only."""
        drag, mass = self._inertia_and_drag(kin, slip, omega)
        stiffness = abs(self.balance(kin, slip).product * self.spring_slope(kin.z) * kin.dz)
        if self.inertial:
            return abs(drag / mass) + (stiffness / abs(mass)) ** 0.5
        return stiffness / abs(drag) if drag else stiffness * 0

    def _inertia_and_drag(self, kin: Kinematics, slip: Slip, omega: Number = 0) -> tuple[Number, Number]:
        """Coefficients of omega and alpha in the balance multiplied through by delta; the damper counts with
        its slope at the speed omega."""
        q = self.balance(kin, slip)
        c, quadratic = self.damper[slip.sigma]
        drag = q.delta * self.b + q.product * (c + 2 * quadratic * abs(kin.dz * omega)) * kin.dz
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

    def reactions(self, kin: Kinematics, x1: Number, x2: Number) -> tuple[Number, Number]:
        """R_i = |x_i| hypot(r_i, a_i), per contact."""
        half = self.arithmetic.number(0.5)
        return (
            abs(x1) * (self.r1**2 + kin.a1**2) ** half / self.contacts,
            abs(x2) * (self.r2**2 + kin.a2**2) ** half / self.contacts,
        )

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
    tau: Polynomial  # of local time
    f_ext: Polynomial
    length: Number
    stop: Number  # the end stop ahead
    load_sign: int = 1  # without inertia: of F_0, for the band edge that ends the motion


@dataclass
class Outcome:
    """Where a segment ended, and why: a subset of end, rest, stop, cross1, cross2, kink."""

    time: Number
    theta: Number
    omega: Number
    flows: list[Number]
    causes: set[str]
    peak_omega: Number
    peak_reactions: tuple[Number, Number]  # per contact


class Flow(Protocol):
    arithmetic: Arithmetic

    def advance(self, mechanism: Mechanism, segment: Segment) -> Outcome: ...


class ExactFlow:
    """Closed form of a linear segment: functions of time are coefficients over a basis t^p exp(lambda t)."""

    arithmetic = SIXTY_DIGITS
    zero = MP.mpf("1e-40")

    def advance(self, mechanism: Mechanism, segment: Segment) -> Outcome:
        if not mechanism.linear or max(len(segment.tau), len(segment.f_ext)) > 2:
            raise NotImplementedError("closed form needs helices, a linear spring and dampers, linear inputs")
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
            edge = mechanism.static_ratio(kin, slip.sigma * segment.load_sign)
            watched["rest"] = self._sum((1, tau), (-edge, f0))
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
            mechanism.reactions(kin, self._largest(x1, length), self._largest(x2, length)),
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


class Course(NamedTuple):
    """A smooth stretch in one variable s, time or path: what is integrated and what can end it."""

    rates: Callable[[float, np.ndarray], list[float]]
    look: Callable[[float, np.ndarray], tuple[dict[str, float], tuple[float, float, float]]]
    nothing: dict[str, float]  # event values below 1e-12 of this are zeros; 0: only zero is
    fastest: Callable[[np.ndarray], float]  # rate of change, sizes the steps
    scale: np.ndarray  # absolute tolerances

    def event(self, name: str, s: float, y: np.ndarray) -> float:
        return self.look(s, y)[0][name]


class Peaks:
    """Largest |omega| and reactions, per contact, along what is integrated."""

    def __init__(self) -> None:
        self.best = [0.0, 0.0, 0.0]

    def note(self, sizes: Iterable[float]) -> None:
        self.best = [max(best, size) for best, size in zip(self.best, sizes, strict=True)]


class Solver:
    """DOP853 between events: these are bracketed on the dense output, then polished by Newton's method on the
    integrated motion. Peaks inside a step likewise."""

    samples = 8  # per step, where sign changes are looked for
    stiffness_limit = 1.5  # step times rate

    def __init__(self, rtol: float) -> None:
        self.rtol = rtol

    def march(
        self, course: Course, s: float, y: np.ndarray, end: float, peaks: Peaks
    ) -> tuple[float, np.ndarray, str]:
        """From s to the first event or the end: (s, y, name of the event or "end")."""
        last, sizes = course.look(s, y)
        peaks.note(sizes)
        armed = {
            name: name in ("stop", "knot") or abs(value) > 1e-12 * course.nothing[name]
            for name, value in last.items()
        }
        if end - s <= 1e-15 * end:
            return end, y, "end"
        solver = DOP853(course.rates, s, y, end, rtol=self.rtol, atol=course.scale)
        while solver.status == "running":
            # at the edge of stability the error estimate misses what is left of the fast component
            solver.max_step = self.stiffness_limit / max(course.fastest(y), 1e-300)
            with np.errstate(invalid="ignore", divide="ignore"):  # error estimate 0/0 where it underflows
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
                seen, sizes = course.look(t, y if j == self.samples else dense(t))
                seen_at.append((t, sizes))
                for name, value in seen.items():
                    if not armed[name]:
                        armed[name] = abs(value) > 1e-12 * course.nothing[name] and value != 0
                    elif last[name] * value < 0 or value == 0:
                        root = t
                        if value != 0:
                            root = self._dense_root(course, dense, name, before, t)
                        if first is None or root < first[0]:
                            first = (root, name)
                last, before = seen, t
                if first is not None:
                    break
            if first is not None:
                s, y = self._polish(course, first[1], first[0], start, begun)
                seen_at = [entry for entry in seen_at if entry[0] < s] + [(s, course.look(s, y)[1])]
                self._inner_peaks(course, dense, seen_at, begun, peaks)
                return s, y, first[1]
            self._inner_peaks(course, dense, seen_at, begun, peaks)
        return end, y, "end"

    @staticmethod
    def _dense_root(course: Course, dense: Callable, name: str, a: float, b: float) -> float:
        values = [course.event(name, t, dense(t)) for t in (a, b)]
        if values[0] * values[1] >= 0:  # a zero at an end, to rounding
            return a if abs(values[0]) < abs(values[1]) else b
        return brentq(
            lambda t: course.event(name, t, dense(t)), a, b, xtol=max(1e-15 * b, 1e-24), maxiter=500
        )

    def _integrate(self, course: Course, start: float, y: np.ndarray, end: float) -> np.ndarray:
        if end <= start:
            return y
        solver = DOP853(
            course.rates, start, y, end, rtol=self.rtol, atol=course.scale, first_step=end - start
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            while solver.status == "running":
                solver.step()
        return np.array(solver.y)

    def _polish(
        self, course: Course, name: str, s: float, start: float, begun: np.ndarray
    ) -> tuple[float, np.ndarray]:
        """Newton on the event function along the integrated, not the interpolated, motion."""
        y = self._integrate(course, start, begun, s)
        for _ in range(6):
            g = course.event(name, s, y)
            rate = np.array(course.rates(s, y))
            hair = 1e-6 * (s - start) + 1e-300
            slope = (course.event(name, s + hair, y + hair * rate) - g) / hair
            if g == 0 or slope == 0:
                break
            correction = -g / slope
            if abs(correction) <= 1e-16 * s or not abs(correction) < 0.1 * (s - start):
                break
            s += correction
            y = self._integrate(course, start, begun, s)
        return s, y

    def _inner_peaks(
        self,
        course: Course,
        dense: Callable,
        seen: list[tuple[float, tuple[float, float, float]]],
        begun: np.ndarray,
        peaks: Peaks,
    ) -> None:
        """Ends of the step, and interior maxima: the time from the dense output, the value integrated."""
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
                if course.look(t, dense(t))[1][column] <= values[top]:
                    continue
            a, b = seen[max(top - 1, 0)][0], seen[min(top + 1, len(seen) - 1)][0]
            found = minimize_scalar(
                lambda t, c=column: -course.look(t, dense(t))[1][c],
                bounds=(a, b),
                method="bounded",
                options={"xatol": 1e-6 * (b - a)},
            )
            t = float(found.x)
            peaks.note(course.look(t, self._integrate(course, seen[0][0], begun, t))[1])


class OdeFlow:
    """DOP853 in double precision, for any segment. State: theta, omega (with inertia), FLOWS."""

    arithmetic = DOUBLE

    def __init__(self, rtol: float = 1e-13) -> None:
        self.solver = Solver(rtol)

    def advance(self, mechanism: Mechanism, segment: Segment) -> Outcome:
        inertial, sigma = mechanism.inertial, segment.slip.sigma
        size = 2 if inertial else 1
        y = np.array([segment.theta, segment.omega][:size] + [0.0] * len(FLOWS))
        scale = self._scale(mechanism, segment, size)
        time, length, peaks, name = 0.0, float(segment.length), Peaks(), "knot"
        while name == "knot":
            piece, knot = mechanism.groove.ahead(float(y[0]), sigma)
            course = self._course(mechanism, segment, y, piece, knot, scale)
            time, y, name = self.solver.march(course, time, y, length, peaks)
            if name == "knot":
                y[0] = knot
                name = self._vanished(course, time, y) or name
        causes = {name}
        watched, _ = course.look(time, y)
        if name in ("cross1", "cross2"):  # without follower inertia both vanish together
            both = [n for n in ("cross1", "cross2") if n in watched]
            causes |= {n for n in both if abs(watched[n]) < 1e-10 * course.nothing[n]}
        omega = float(y[1]) if inertial else course.rates(time, y)[0]
        if abs(omega) <= 1e-13 * peaks.best[0] and "end" not in causes:
            causes.add("rest")  # with damping alone on the shaft, torque and speed vanish together
        flows = [float(v) for v in y[size:]]
        return Outcome(time, float(y[0]), omega, flows, causes, peaks.best[0], (peaks.best[1], peaks.best[2]))

    @staticmethod
    def _vanished(course: Course, time: float, y: np.ndarray) -> str | None:
        """A load that is zero at a knot: in a dwell without friction on it the other contact is idle, and the
        flank it takes afterwards is another matter."""
        watched, _ = course.look(time, y)
        idle = (
            n for n in ("cross1", "cross2") if n in watched and abs(watched[n]) <= 1e-12 * course.nothing[n]
        )
        return next(idle, None)

    @staticmethod
    def _course(
        mechanism: Mechanism,
        segment: Segment,
        y: np.ndarray,
        piece: int,
        knot: float | None,
        scale: np.ndarray,
    ) -> Course:
        slip, inertial, stop = segment.slip, mechanism.inertial, segment.stop
        at, load, powers = mechanism.groove.at, mechanism.load, mechanism.powers
        friction1, friction2 = mechanism.mu1 > 0, mechanism.mu2 > 0

        def rates(t: float, y: np.ndarray) -> list[float]:
            kin, tau, f_ext = at(float(y[0]), piece), poly(segment.tau, t), poly(segment.f_ext, t)
            now = load(kin, slip, float(y[1]) if inertial else 0.0, tau, f_ext)
            motion = [now.omega, now.alpha] if inertial else [now.omega]
            return motion + powers(kin, slip, now, tau, f_ext)

        def look(t: float, y: np.ndarray) -> tuple[dict[str, float], tuple[float, float, float]]:
            theta = float(y[0])
            kin, tau, f_ext = at(theta, piece), poly(segment.tau, t), poly(segment.f_ext, t)
            now = load(kin, slip, float(y[1]) if inertial else 0.0, tau, f_ext)
            seen = {"stop": theta - stop}
            if knot is not None:
                seen["knot"] = theta - knot
            if inertial:
                seen["rest"] = now.omega
            else:
                f0 = mechanism.spring_force(kin.z) + f_ext
                ratio = mechanism.static_ratio(kin, slip.sigma * segment.load_sign)
                if ratio is None:
                    raise Refused("moving wedge")
                seen |= {"rest": tau - ratio * f0, "kink": f0}
            if friction1:
                seen["cross1"] = now.x1
            if friction2:
                seen["cross2"] = now.x2
            return seen, (abs(now.omega), *mechanism.reactions(kin, now.x1, now.x2))

        kin = at(float(y[0]), piece)
        tau, f_ext = segment.tau[0], segment.f_ext[0]
        natural = mechanism.scales(kin, slip, float(y[1]) if inertial else segment.omega, tau, f_ext)
        nothing = {"cross1": natural.x1, "cross2": natural.x2, "stop": 0.0, "knot": 0.0}
        if inertial:
            nothing["rest"] = 0.0
        else:
            nothing["kink"] = mechanism.force_scale(kin, f_ext)
            ratio = mechanism.static_ratio(kin, slip.sigma * segment.load_sign)
            nothing["rest"] = abs(tau) + abs(ratio or 0.0) * nothing["kink"]

        def fastest(y: np.ndarray) -> float:
            kin = at(float(y[0]), piece)
            omega = float(y[1]) if inertial else 0.0
            return mechanism.rate(kin, slip, omega)

        return Course(rates, look, nothing, fastest, scale)

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
        force = mechanism.force_scale(kin, segment.f_ext[0])
        energy = abs(segment.tau[0]) * reach * 1e-2 + force * mechanism.reach * 1e-2 + 1e-12
        return 1e-15 * np.array([reach, speed][:size] + [energy] * len(FLOWS))


# ---- modes and events ---------------------------------------------------------------------------


class Simulation:
    """The mechanism between events: rest, sliding (a Flow), or following the band edge without inertia."""

    def __init__(self, params: Params, flow: Flow, first: Interval) -> None:
        self.flow, self.arithmetic = flow, flow.arithmetic
        number = self.arithmetic.number
        self.mechanism = Mechanism(params, self.arithmetic)
        self._ratios: tuple[Number, Number | None, Number | None] | None = None
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
        self.snapping = False  # at an angle beyond which the band's edge falls
        self.stored = self._stored()
        self._start(first)
        self._begin(first)

    # -- inputs and accounts

    def _start(self, first: Interval) -> None:
        """The mode before t = 0: nothing has moved yet, and rates of the inputs are not known yet."""
        self._set_inputs(Interval(first.duration, first.tau, F_ext=first.F_ext))
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
        self.tau = interval.coefficients("tau", number)
        self.f_ext = interval.coefficients("F_ext", number)

    def _tau(self, t: Number) -> Number:
        return poly(self.tau, t)

    def _f_ext(self, t: Number) -> Number:
        return poly(self.f_ext, t)

    def _extremes(self, c: Polynomial, a: Number, b: Number) -> list[Number]:
        """The ends of (a, b) and the times between at which polynomial c turns."""
        return [a, b, *(poly_zeros(poly_derivative(c), a, b) if len(c) > 2 else [])]

    def _input_sizes(self) -> tuple[Number, Number]:
        """Largest torque and pull of the interval, about: zeros within their rounding are zeros."""
        tau, f_ext = (poly([abs(u) for u in c], self.length) for c in (self.tau, self.f_ext))
        return tau, f_ext

    def _stored(self) -> Number:
        kin = self.mechanism.groove.at(self.theta)
        return self.mechanism.spring_energy(kin.z) + self.mechanism.kinetic_energy(kin, self.omega)

    def _note_reactions(self, reactions: Sequence[Number]) -> None:
        for i, reaction in enumerate(reactions, start=1):
            self.peak[f"reaction{i}"] = max(self.peak[f"reaction{i}"], reaction)

    def _note_rest(self, a: Number, b: Number) -> None:
        mech = self.mechanism
        kin = mech.groove.at(self.theta)
        for t in self._extremes(self.f_ext, a, b):
            shared = mech.shared(kin, mech.spring_force(kin.z) + self._f_ext(t))
            self._note_reactions(mech.reactions(kin, *shared))

    def _set_mode(self, mode: int) -> None:
        self.events += mode != self.mode
        self.mode = mode

    # -- decisions

    def _edges(self) -> tuple[Number, Number | None]:
        """Ratios of the band's edges at the present angle, for F_0 > 0: loading, releasing."""
        if self._ratios is None or self._ratios[0] is not self.theta:
            kin = self.mechanism.groove.at(self.theta)
            up, down = (self.mechanism.static_ratio(kin, direction) for direction in (+1, -1))
            self._ratios = self.theta, up, down
        if self._ratios[1] is None:
            raise Refused("loading jam")
        return self._ratios[1], self._ratios[2]

    def _edge(self, direction: int) -> Number | None:
        return self._edges()[direction < 0]

    def _rest(self) -> tuple[int, int, Number]:
        """(mode, 0, until) if it rests, (0, sigma, until) if it slips; decided in the middle of the time
        to the next change of that decision, so that a ramp resolves a torque exactly on an edge."""
        mech, number = self.mechanism, self.arithmetic.number
        kin = mech.groove.at(self.theta)
        fs = mech.spring_force(kin.z)
        up, down = self._edges()
        ratios = [r for r in (up, down) if r is not None]
        if down is None:
            ratios.append(kin.dz)
        size = max(len(self.tau), len(self.f_ext))
        tau, f_ext = (c + (number(0),) * (size - len(c)) for c in (self.tau, self.f_ext))
        lines = [(fs + f_ext[0], *f_ext[1:])]
        lines += [tuple(u - r * f for u, f in zip(tau, lines[0], strict=True)) for r in ratios]
        guard = self.t + number(self.arithmetic.tiny) * self.length * 10
        times = [t for line in lines for t in poly_zeros(line, guard, self.length)]
        until = min(times, default=self.length)
        constant = not any(self.tau[1:]) and not any(self.f_ext[1:])
        middle = self.t if constant else (self.t + until) / 2
        tau, f0 = self._tau(middle), fs + self._f_ext(middle)
        tau_size, f_size = self._input_sizes()
        size = tau_size + abs(up) * mech.force_scale(kin, f_size)
        near = self.arithmetic.tiny * size
        load, release = (up, down) if f0 >= 0 else (down, up)
        if abs(up * f0) <= near:  # the next hair of motion sets the sign of the load, that of sigma
            load = release = up
        if load is not None and tau > load * f0 + near:
            return (UPPER_STOP, 0, until) if self.theta >= mech.upper else (0, +1, until)
        if release is not None and tau < release * f0 - near:
            return (LOWER_STOP, 0, until) if self.theta <= mech.lower else (0, -1, until)
        towards = sign(tau - kin.dz * f0) if abs(tau - kin.dz * f0) > near else 0
        if (towards > 0 and load is None) or (towards < 0 and release is None):
            return WEDGED, 0, until
        ahead = abs(self._tau(until)), abs(up * (fs + self._f_ext(until)))
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
        self._after_jump()

    def _after_jump(self) -> None:
        """Without inertia, on the band's edge or at a stop: stay, or go on as the inputs change."""
        mech = self.mechanism
        mode, sigma, until = self._rest()
        kin, tau, f_ext = mech.groove.at(self.theta), self._tau(self.t), self._f_ext(self.t)
        f0, size = mech.spring_force(kin.z) + f_ext, mech.force_scale(kin, f_ext)
        up, down = self._edges()
        if down is not None and abs((up - down) * f0) < 1e-12 * up * size:
            self.doubts.append("stick band without width")
        if sigma == 0:
            self._settle(mode, until)
            return
        if mech.viscous(sigma):  # in the other direction than the jump
            self._enter(sigma, None)
            return
        # on the edge, and the ramp leads on: follow it
        self._set_mode(LOADING if sigma > 0 else RELEASING)
        if self._straight():
            rounding = self.arithmetic.tiny * (abs(self.tau[0]) + abs(self.tau[1] * self.length))
            ratio = self._edge(sigma * (sign(self.tau[1]) if abs(tau) <= rounding else sign(tau)))
            if ratio is None or mech.spring[1] == 0:
                raise Refused("no quasi-static motion")
            speed = (self.tau[1] / ratio - self.f_ext[1]) / (mech.spring[1] * kin.dz)
        else:
            drive, rise = self._edge_slopes(sigma)
            speed = drive / rise if rise > 0 else 0.0
        if sign(speed) != sigma:
            raise Refused("no quasi-static motion")
        self.slip, self.follow, self.omega = None, speed, speed

    def _straight(self) -> bool:
        """Do edge torque and inputs change linearly?"""
        return self.mechanism.linear and max(len(self.tau), len(self.f_ext)) <= 2

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
        for t in self._extremes(self.tau, self.arithmetic.number(0), self.length):
            self.peak["torque"] = max(self.peak["torque"], abs(self._tau(t)))
        for _ in range(5000):
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
        load_sign = 1
        if not mech.inertial:
            f0 = mech.spring_force(kin.z) + self._f_ext(self.t)
            if abs(f0) <= self.arithmetic.tiny * mech.force_scale(kin, self._input_sizes()[1]):
                now, _, _ = self._ahead(slip)
                rate = poly(poly_derivative(self.f_ext), self.t)
                f0 = (mech.spring_slope(kin.z) * kin.dz * now.omega + rate) or f0 * 0 + slip.sigma
            load_sign = sign(f0) or slip.sigma
            if self._edge(slip.sigma * load_sign) is None:
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
        self._note_reactions(out.peak_reactions)
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
        if not self._straight():
            self._creep(sigma, following=False)
            return
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
            self._note_reactions(mech.reactions(kin, f * xi1, f * xi2))
        turned = abs(b - a)
        self.account["work_in"] += ratio * mean * (b - a)
        self.account["heat_cam1"] += (
            mech.mu1 * abs(mean * xi1) * (mech.r1**2 + kin.a1**2) * kin.dgamma * turned
        )
        self.account["heat_cam2"] += (
            mech.mu2 * abs(mean * xi2) * (mech.r2**2 + kin.a2**2) * (1 - kin.dgamma) * turned
        )

    def _static_flanks(self, kin: Kinematics, sigma: int, s: int) -> Flanks:
        """Flanks of static sliding in direction sigma under a load of sign s."""
        mech = self.mechanism
        for e in self._preference(s):
            q = mech.balance(kin, Slip(sigma, e))
            if q.delta == 0:
                continue
            x1, x2 = s * mech.r2 * q.n2 / q.delta, s * mech.r1 * q.n1 / q.delta
            if (e[0] * x1 >= 0 or mech.mu1 == 0) and (e[1] * x2 >= 0 or mech.mu2 == 0):
                return e
        raise Refused("no consistent flanks")

    def _static_balance(self, kin: Kinematics, sigma: int, s: int) -> Balance:
        """Its coefficients."""
        return self.mechanism.balance(kin, Slip(sigma, self._static_flanks(kin, sigma, s)))

    def _load_sign(self, sigma: int) -> int:
        """Sign of F_0; where it vanishes, the one it takes by moving on."""
        mech = self.mechanism
        kin, f_ext = mech.groove.at(self.theta), self._f_ext(self.t)
        f0 = mech.spring_force(kin.z) + f_ext
        return sign(f0) if abs(f0) > self.arithmetic.tiny * mech.force_scale(kin, f_ext) else sigma

    def _edge_slope(self, kin: Kinematics, slip: Slip, t: float) -> tuple[float, float]:
        """With the excess H = tau - rho F_0 over the edge torque: (dH/dt, d(rho F_0)/dtheta)."""
        mech = self.mechanism
        q = mech.balance(kin, slip)
        f1, f2 = slip.sigma * slip.e[0] * mech.mu1, slip.sigma * slip.e[1] * mech.mu2
        product = mech.r1 * mech.r2 * (kin.da1 * q.n2 + q.n1 * kin.da2)
        delta = mech.r2 * (q.d1 * kin.da2 - f1 * kin.da1 * q.n2)
        delta += mech.r1 * (q.d2 * kin.da1 - f2 * kin.da2 * q.n1)
        ratio = q.product / q.delta
        f0 = mech.spring_force(kin.z) + self._f_ext(t)
        drive = poly(poly_derivative(self.tau), t) - ratio * poly(poly_derivative(self.f_ext), t)
        rise = (product - ratio * delta) / q.delta * f0 + ratio * mech.spring_slope(kin.z) * kin.dz
        return drive, rise

    def _edge_slopes(self, sigma: int) -> tuple[float, float]:
        """The same here and now, on the flanks of moving on."""
        mech = self.mechanism
        piece, _ = mech.groove.ahead(self.theta, sigma)
        hair = sigma * 1e-7 * (mech.upper - mech.lower)
        e = self._static_flanks(mech.groove.at(self.theta + hair, piece), sigma, self._load_sign(sigma))
        return self._edge_slope(mech.groove.at(self.theta, piece), Slip(sigma, e), self.t)

    def _creep(self, sigma: int, *, following: bool) -> str:
        """Motion without inertia and damping along the band's edge, any grooves; returns what ended it.

        Not following: at once, at fixed inputs, until the edge torque T = rho F_0 holds tau ("held") or to
        the stop. Following: along the curve H(theta, t) = tau(t) - T(theta, t) = 0, by its own length:
        (dtheta, dt) ~ (H_t, T_theta), each in units of its span. It turns where H_t changes sign; where
        T_theta does, the edge torque no longer rises along the way ("fold"), and the angle has to snap on."""
        mech, length = self.mechanism, self.length
        assert isinstance(self.flow, OdeFlow)
        span = mech.upper - mech.lower
        y = np.array([self.theta, self.t] + [0.0] * len(FLOWS))
        path, s, peaks, ended = 0.0, self._load_sign(sigma), Peaks(), ""
        kin = mech.groove.at(self.theta)
        force = mech.force_scale(kin, self._input_sizes()[1])
        up, down = self._edges()
        torque = self._input_sizes()[0] + max(abs(up), abs(down or 0.0)) * force
        if not following:
            excess = sigma * (self._tau(self.t) - (self._edge(sigma * s) or 0.0) * self._f0(kin, self.t))
            level = abs(excess) <= self.arithmetic.tiny * torque and not self.snapping
            if level and self._edge_slopes(sigma)[1] > 0:
                return "held"
        self.snapping = False
        scale = 1e-15 * np.array([span, length] + [torque * span * 1e-2] * len(FLOWS))
        nothing = dict.fromkeys(("stop", "knot", "turn", "fold", "end"), 0.0)
        nothing |= {"kink": force, "held": torque}
        nothing |= dict.fromkeys(("cross1", "cross2"), 1 / mech.r1 + 1 / mech.r2)
        while ended in ("", "knot", "kink", "cross1", "cross2"):
            theta = float(y[0])
            piece, knot = mech.groove.ahead(theta, sigma)
            ahead = mech.groove.at(theta + sigma * 1e-7 * span, piece)
            slip = Slip(sigma, self._static_flanks(ahead, sigma, s))
            if ended in ("cross1", "cross2") and not following:
                # without torque, a contact changes flank just where the edge torque passes zero
                q = mech.balance(ahead, slip)
                beyond = self._tau(self.t) - q.product / q.delta * self._f0(ahead, self.t)
                if sigma * beyond < -self.arithmetic.tiny * torque:
                    ended = "held"
                    break
            course = self._creep_course(slip, piece, knot, following, nothing, scale)
            path, y, ended = self.flow.solver.march(course, path, y, 10.0, peaks)
            if ended == "knot":
                y[0] = knot
            if ended == "kink":
                s = -s
                if not following and abs(self._tau(self.t)) <= self.arithmetic.tiny * torque:
                    ended = "held"  # without torque it goes just where the load vanishes
        if ended == "end" and path == 10.0:
            raise ArithmeticError("the way along the edge does not end")
        self.theta, self.t = float(y[0]), float(y[1])
        if ended == "stop":
            self.theta = mech.upper if sigma > 0 else mech.lower
        if ended == "end":
            self.t = length
        if ended in ("end", "turn"):  # back to the curve, from which the integration strays by rounding
            for _ in range(3):
                kin = mech.groove.at(self.theta, piece)
                q = mech.balance(kin, slip)
                excess = self._tau(self.t) - q.product / q.delta * self._f0(kin, self.t)
                self.theta += excess / self._edge_slope(kin, slip, self.t)[1]
        for name, value in zip(FLOWS, y[2:], strict=True):
            self.account[name] += float(value)
        self.peak["omega"] = max(self.peak["omega"], peaks.best[0])
        self._note_reactions(peaks.best[1:])
        return ended

    def _f0(self, kin: Kinematics, t: Number) -> Number:
        return self.mechanism.spring_force(kin.z) + self._f_ext(t)

    def _creep_course(
        self,
        slip: Slip,
        piece: int,
        knot: float | None,
        following: bool,
        nothing: dict[str, float],
        scale: np.ndarray,
    ) -> Course:
        mech, length, sigma = self.mechanism, self.length, slip.sigma
        span, stop = mech.upper - mech.lower, mech.upper if sigma > 0 else mech.lower

        def direction(kin: Kinematics, t: float) -> tuple[float, float]:
            if not following:
                return sigma * span, 0.0
            drive, rise = self._edge_slope(kin, slip, t)
            size = math.hypot(drive * length, rise * span)
            return span * (drive * length / size), length * (rise * span / size)

        def rates(_s: float, y: np.ndarray) -> list[float]:
            theta, t = float(y[0]), float(y[1])
            kin, f_ext = mech.groove.at(theta, piece), self._f_ext(t)
            q, f0 = mech.balance(kin, slip), mech.spring_force(kin.z) + f_ext
            turned, passed = direction(kin, t)
            x1, x2 = mech.r2 * q.n2 / q.delta * f0, mech.r1 * q.n1 / q.delta * f0
            load = Load(turned, 0.0, x1, x2)
            flows = mech.powers(kin, slip, load, q.product / q.delta * f0, f_ext)
            return [turned, passed, *flows[:4], 0.0, 0.0]

        def look(_s: float, y: np.ndarray) -> tuple[dict[str, float], tuple[float, float, float]]:
            theta, t = float(y[0]), float(y[1])
            kin = mech.groove.at(theta, piece)
            q, f0 = mech.balance(kin, slip), self._f0(kin, t)
            xi1, xi2 = mech.r2 * q.n2 / q.delta, mech.r1 * q.n1 / q.delta
            seen = {"stop": theta - stop, "kink": f0}
            if knot is not None:
                seen["knot"] = theta - knot
            if mech.mu1 > 0:
                seen["cross1"] = xi1
            if mech.mu2 > 0:
                seen["cross2"] = xi2
            omega = 0.0
            if following:
                drive, rise = self._edge_slope(kin, slip, t)
                seen |= {"turn": drive, "fold": rise, "end": t - length}
                if rise > 0:
                    omega = abs(drive) / rise
            else:
                seen["held"] = self._tau(t) - q.product / q.delta * f0
            return seen, (omega, *mech.reactions(kin, xi1 * f0, xi2 * f0))

        return Course(rates, look, nothing, lambda _y: 6.0, scale)

    def _follow_edge(self) -> bool:
        """Quasi-static motion along the edge; on helices, under ramps, theta is linear in time."""
        if not self._straight():
            return self._follow_curve()
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

    def _follow_curve(self) -> bool:
        assert self.follow is not None
        sigma = sign(self.follow)
        ended = self._creep(sigma, following=True)
        if ended == "end":
            drive, rise = self._edge_slopes(sigma)
            self.omega = drive / rise
            return True
        self.omega = 0.0
        if ended == "fold":
            self.peak["omega"] = math.inf
            self.snapping, self.follow = True, None
            self._jump(sigma)
            self._after_jump()
        else:
            self._decide()
        return False

    def _point(self) -> Point:
        mech = self.mechanism
        kin = mech.groove.at(self.theta)
        if self.slip is None and self.follow is None:
            self._note_rest(self.length, self.length)
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


def _simulate(params: Params, intervals: Sequence[Interval], flow: Flow) -> list[Point]:
    simulation = Simulation(params, flow, intervals[0])
    return [simulation.run(interval, first=i == 0) for i, interval in enumerate(intervals)]


def simulate(params: Params, intervals: Sequence[Interval], rtol: float = 1e-13) -> list[Point]:
    """Integrates numerically, in double precision. One Point at the end of each interval."""
    return _simulate(params, intervals, OdeFlow(rtol))


def simulate_exact(params: Params, intervals: Sequence[Interval]) -> list[Point]:
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


def _inertia_is_positive(params: Params) -> bool:
    """Does more torque mean more acceleration on the flanks that statics chooses, in both directions, at any
    angle between the stops?"""
    mech = Mechanism(params, DOUBLE)
    angles = [0.0]
    if not isinstance(mech.groove, Helices):
        angles = np.linspace(mech.lower, mech.upper, 201).tolist()
    for kin in map(mech.groove.at, angles):
        for sigma in (+1, -1):
            for e in ((1, 1), (-1, -1), (1, -1), (-1, 1)):
                slip = Slip(sigma, e)
                q = mech.balance(kin, slip)
                x1, x2 = e[0] * q.n2 * q.delta, e[1] * q.n1 * q.delta
                used = (x1 >= 0 and x2 >= 0) or (x1 <= 0 and x2 <= 0)
                if used and not mech._inertia_and_drag(kin, slip)[1] * q.delta > 0:
                    return False
    return True


# ---- scenes with any grooves --------------------------------------------------------------------


def random_general_scene(
    rng: np.random.Generator, folder: str | Path
) -> tuple[dict[str, Any], list[Interval]]:
    """A varied, well-posed scene with elliptical and tabulated grooves (some helices), nonlinear spring and
    damper, and inputs up to cubic in time. Tables are written into `folder`."""
    while True:
        scene = _draw_general_scene(rng, Path(folder))
        if scene is not None:
            return scene


def _draw_ellipse(rng: np.random.Generator, radius: float, lower: float, upper: float) -> dict[str, Any]:
    """From S_0 at psi = 0 towards S_1, with some room beyond the largest angle there can be."""
    s0, s1 = rng.uniform(0.1, 0.9, 2)
    kappa = 1 if s1 > s0 else -1
    room = min(s0, 1.0 - s0) if lower < 0 else 1.0
    span = max(upper, -lower * abs(s1 - s0) / room)
    a = radius * span * rng.uniform(1.05, 1.5) / abs(s1 - s0)
    lead = rng.uniform(0.25, 1.15)
    b = a * math.tan(lead) * math.sqrt(1.0 - s0 * s0) / s0
    return {"lead_angle": lead, "ellipse_a": a, "ellipse_b": b, "ellipse_curvature": kappa}


def _draw_table(
    rng: np.random.Generator, radius: float, lower: float, upper: float
) -> tuple[np.ndarray, np.ndarray]:
    """psi, z of a smooth slope z' = r tan(lambda(psi)) w(psi); w is 0 in a dwell and 1 well beside it."""
    count = int(rng.integers(6, 61))
    low, high = lower - rng.uniform(0.02, 0.3), upper + rng.uniform(0.02, 0.3)
    if lower == 0 and rng.random() < 0.5:
        low = 0.0
    steps = rng.uniform(1.0, rng.choice([1.0, 1.5, 3.0]), count - 1)
    psi = low + (high - low) * np.concatenate([[0.0], np.cumsum(steps) / np.sum(steps)])
    mean, swing = rng.uniform(0.4, 1.0), rng.uniform(0.0, 0.3)
    waves, phase = rng.uniform(0.5, 1.0 + min(count, 20) / 8.0), rng.uniform(0.0, 6.0)
    dwell = None
    if count >= 16 and rng.random() < 0.35:
        first = int(rng.integers(2, count - 6))
        last = first + int(rng.integers(1, max(2, count // 6)))
        dwell = psi[first], psi[min(last, count - 3)], (high - low) * rng.uniform(0.05, 0.2)

    def slope(x: np.ndarray) -> np.ndarray:
        lead = mean + swing * np.sin(waves * x + phase)
        weight = 1.0
        if dwell is not None:
            outside = np.maximum(np.maximum(dwell[0] - x, x - dwell[1]), 0.0) / dwell[2]
            weight = -np.expm1(-(outside**2))
        return radius * np.tan(lead) * weight

    nodes, weights = np.polynomial.legendre.leggauss(12)
    middles, halves = (psi[1:] + psi[:-1]) / 2, np.diff(psi) / 2
    rises = (slope(middles[:, None] + halves[:, None] * nodes) @ weights) * halves
    return psi, np.concatenate([[0.0], np.cumsum(rises)])


def _draw_general_scene(
    rng: np.random.Generator, folder: Path
) -> tuple[dict[str, Any], list[Interval]] | None:
    p: dict[str, Any] = {"stop.upper": rng.uniform(0.4, 2.2)}
    p["stop.lower"] = _mixed(rng, 0.6, lambda: -rng.uniform(0.1, 1.0))
    p["stop.restitution"] = _mixed(rng, 0.7, lambda: rng.uniform(0.05, 0.6))
    lower, upper = p["stop.lower"], p["stop.upper"]
    span = upper - lower
    profiles = rng.choice([HELIX, ELLIPSE, TABLE], 2, p=[0.15, 0.45, 0.4])
    if all(profiles == HELIX):
        return None
    name = f"{rng.integers(2**48):012x}"
    dwell = False
    for i, profile in enumerate(profiles, start=1):
        radius = p[f"cam{i}.radius"] = rng.uniform(0.008, 0.05)
        p[f"cam{i}.profile"] = int(profile)
        if profile == HELIX:
            p[f"cam{i}.lead_angle"] = rng.uniform(0.2, 1.1)
        elif profile == ELLIPSE:
            drawn = _draw_ellipse(rng, radius, lower, upper)
            p |= {f"cam{i}.{key}": value for key, value in drawn.items()}
        else:
            psi, z = _draw_table(rng, radius, lower, upper)
            dwell = dwell or bool(np.any(np.diff(z) == 0))
            p[f"cam{i}.table"] = str(folder / f"{name}-{i}.csv")
            write_table(p[f"cam{i}.table"], psi, z)
        p[f"cam{i}.friction"] = _mixed(rng, 0.15, lambda: rng.uniform(0.0, 0.4) * rng.choice([1.0, 0.4]))
    p["contacts"] = int(rng.integers(1, 3))
    start = rng.choice(4, p=[0.4, 0.15, 0.15, 0.3])
    p["initial.theta"] = float([0.0, lower, upper, rng.uniform(lower, upper)][start])

    try:
        probe = Mechanism(p, DOUBLE)
    except Refused:
        return None
    way = [probe.groove.at(theta) for theta in np.linspace(lower, upper, 101).tolist()]
    ups = [probe.static_ratio(kin, +1) for kin in way]
    if not all(
        up is not None and 0 <= up < 20 * (kin.dz + 0.2 * probe.reach)
        for up, kin in zip(ups, way, strict=True)
    ):
        return None
    if min(kin.a1 + kin.a2 for kin in way) < 0.1 * max(kin.a1 + kin.a2 for kin in way):
        return None
    travel = way[-1].z - way[0].z
    dz, dgamma = travel / span, float(np.mean([kin.dgamma for kin in way]))
    force = _log_uniform(rng, 3.0, 3000.0)
    up = float(np.mean(ups))
    p["spring.stiffness"] = _mixed(rng, 0.1, lambda: force / travel * _log_uniform(rng, 0.2, 2.0))
    p["spring.preload"] = _mixed(rng, 0.2, lambda: force * rng.uniform(0.02, 1.0))
    p["spring.stiffness2"] = _mixed(rng, 0.4, lambda: force / travel**2 * rng.uniform(-0.3, 1.0))
    p["spring.stiffness3"] = _mixed(rng, 0.4, lambda: force / travel**3 * rng.uniform(-0.2, 1.0))
    stiffness = max(p["spring.stiffness"], 0.2 * force / travel) * dz * dz  # as seen by cam 2
    spring = [p[f"spring.{name}"] for name in ("preload", "stiffness", "stiffness2", "stiffness3")]
    force = max(abs(poly(spring, kin.z)) for kin in way) or force
    torque = up * force
    regime = rng.choice(["inertial", "viscous", "quasi-static"], p=[0.7, 0.15, 0.15])
    time = _log_uniform(rng, 1e-2, 1.0)
    p["inertia.shaft"] = 0.0
    if regime == "inertial":
        shaft = max(_log_uniform(rng, 1e-5, 0.1), stiffness * 1e-6)
        p["inertia.shaft"] = _mixed(rng, 0.0 if dwell else 0.1, lambda: shaft)
        p["inertia.follower_mass"] = _mixed(rng, 0.3, lambda: shaft / dz**2 * _log_uniform(rng, 0.01, 2.0))
        p["inertia.follower"] = _mixed(rng, 0.4, lambda: shaft / dgamma**2 * _log_uniform(rng, 0.01, 2.0))
        inertia = p["inertia.shaft"] + p["inertia.follower_mass"] * dz**2 + p["inertia.follower"] * dgamma**2
        if inertia == 0:
            return None
        time = 2 * math.pi * math.sqrt(inertia / stiffness)
        critical = 2 * math.sqrt(inertia * stiffness)
        speed = math.sqrt(torque * span / inertia)
        for side in ("load", "release"):
            draw = lambda: critical / dz**2 * _log_uniform(rng, 0.01, 4.0)  # noqa: E731
            p[f"damper.c_{side}"] = _mixed(rng, 0.4, draw)
            draw = lambda: critical / dz**3 / speed * _log_uniform(rng, 0.03, 6.0)  # noqa: E731
            p[f"damper.q_{side}"] = _mixed(rng, 0.4, draw)
        p["shaft.damping"] = _mixed(rng, 0.5, lambda: critical * _log_uniform(rng, 0.01, 3.0))
        p["initial.omega"] = _mixed(rng, 0.6, lambda: speed * rng.uniform(-1.0, 1.0))
        at_stop = p["initial.theta"] in (lower, upper)
        if at_stop and (p["initial.omega"] > 0) == (p["initial.theta"] == upper):
            p["initial.omega"] *= -1.0
    elif regime == "viscous":
        for side in ("load", "release"):
            draw = lambda: stiffness / dz**2 * time * _log_uniform(rng, 0.1, 10.0)  # noqa: E731
            p[f"damper.c_{side}"] = _mixed(rng, 0.4, draw)
            draw = lambda: stiffness / dz**3 * time**2 / span * _log_uniform(rng, 0.1, 10.0)  # noqa: E731
            p[f"damper.q_{side}"] = _mixed(rng, 0.4, draw)
        shaft_free = 0.0 if dwell else 0.6
        p["shaft.damping"] = _mixed(rng, shaft_free, lambda: stiffness * time * _log_uniform(rng, 0.1, 10.0))
    if regime == "inertial" and not _inertia_is_positive(p):
        return None

    curved, pulls = rng.random() < 0.7, rng.random() < 0.5
    intervals = []
    for _ in range(rng.integers(4, 11)):
        duration = _log_uniform(rng, 0.05 * time, 1.5 * time)
        none = rng.uniform(-0.3, 0.3) if regime == "quasi-static" else 0.0
        sizes = [none, rng.uniform(-1.0, 0.3), rng.uniform(0.0, 0.9), rng.uniform(0.5, 2.0)]
        tau = torque * rng.choice(sizes, p=[0.1, 0.2, 0.5, 0.2])
        sizes = [0.0, rng.uniform(-1.0, 0.0), rng.uniform(-0.3, 0.7)]
        pull = force * rng.choice(sizes, p=[0.2, 0.3, 0.5]) if pulls else 0.0
        rates = np.zeros((2, 3))
        for row, size, share in ((0, torque, 0.7), (1, force, 0.5 * pulls)):
            if curved and rng.random() < share:
                order = int(rng.integers(1, 4))
                swing = size * rng.uniform(-1.5, 1.5, order)
                rates[row, :order] = [
                    x * math.factorial(k + 1) / duration ** (k + 1) for k, x in enumerate(swing)
                ]
        values = [float(duration), float(tau), rates[0, 0], float(pull), rates[1, 0]]
        values += [rates[0, 1], rates[0, 2], rates[1, 1], rates[1, 2]]
        intervals.append(Interval(*map(float, values)))
    return {key: _plain(value) for key, value in p.items()}, intervals


def _plain(value: Any) -> Any:
    """A number or text of Python's own."""
    return value.item() if isinstance(value, np.generic) else value
