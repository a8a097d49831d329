"""The equations of docs/mechanism.md once more, with SciPy, for the tests of the general mechanism.

Nothing here is compared with earlier output of the FMU or of its reference. "bend" is g_i''.
"""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import brentq

HELIX, ELLIPSE, TABLE = 1, 2, 3
HEATS = [f"energy.heat_{name}" for name in ("cam1", "cam2", "damper", "shaft", "stop")]
ACCOUNTS = [
    *HEATS,
    "energy.work_in",
    "energy.work_ext",
    "energy.work_tuning",
    "energy.spring",
    "energy.kinetic",
]
KINDS = ("helix", "ellipse", "table")
PAIRS = list(product(KINDS, KINDS))


@dataclass(frozen=True)
class Groove:
    """z, slope and bend over the angle in the groove; the FMU's parameters for it, without `cam1.`."""

    radius: float
    parameters: dict
    z: object
    slope: object
    bend: object
    first: float = -math.inf  # rad, limits of the angle in the groove
    last: float = math.inf


def helix(radius, lead):
    gain = radius * math.tan(lead)
    return Groove(
        radius, {"profile": HELIX, "lead_angle": lead}, lambda x: gain * x, lambda x: gain, lambda x: 0.0
    )


def ellipse(radius, lead, a, b, kappa):
    """Ellipse of section 2 of docs/mechanism.md."""
    start = math.sin(math.atan(a / b * math.tan(lead)))

    def S(x):
        return start + kappa * radius * x / a

    return Groove(
        radius,
        {"profile": ELLIPSE, "lead_angle": lead, "ellipse_a": a, "ellipse_b": b, "ellipse_curvature": kappa},
        lambda x: kappa * b * (math.sqrt(1 - start**2) - math.sqrt(1 - S(x) ** 2)),
        lambda x: radius * b / a * S(x) / math.sqrt(1 - S(x) ** 2),
        lambda x: kappa * (radius / a) ** 2 * b * (1 - S(x) ** 2) ** -1.5,
        *sorted((-kappa * start * a / radius, kappa * (1 - start) * a / radius)),
    )


def write_table(path, psi, z):
    rows = "".join(f"{float(x)!r},{float(y)!r}\n" for x, y in zip(psi, z, strict=True))
    path.write_text(f"psi_rad,z_m\n{rows}")
    return str(path)


def sampled(groove, path, psi):
    """The same groove as a table."""
    table = write_table(path, psi, [groove.z(x) for x in psi])
    return Groove(groove.radius, {"profile": TABLE, "table": table}, groove.z, groove.slope, groove.bend)


def random_groove(rng, kind, reach, path):
    """A groove for angles from -reach to reach. Tables are of polynomials of degree 4, unevenly sampled:
    those five neighbours reproduce, so that nothing is lost between the points."""
    radius, lead = rng.uniform(0.01, 0.04), rng.uniform(0.4, 1.0)
    if kind == "helix":
        return helix(radius, lead)
    if kind == "ellipse":
        start, a = rng.uniform(0.3, 0.7), radius * reach / 0.25 * rng.uniform(1.0, 2.0)
        b = a * math.tan(lead) * math.sqrt(1 - start**2) / start
        return ellipse(radius, lead, a, b, int(rng.choice([-1, 1])))
    rise = radius * math.tan(lead)
    slope = np.polynomial.Polynomial(
        rise * np.array([1.0, *rng.uniform(-0.25, 0.25, 3) / [reach, reach**2, reach**3]])
    )
    steps = rng.uniform(1.0, 2.0, rng.integers(8, 24))
    psi = -reach + 2.0 * reach * np.concatenate([[0.0], np.cumsum(steps) / np.sum(steps)])
    psi[-1] = reach  # without rounding error
    return sampled(Groove(radius, {}, slope.integ(), slope, slope.deriv()), path, psi)


@dataclass(frozen=True)
class Place:
    """Kinematics of section 2 at one theta; `_bent` marks second derivatives by theta."""

    gamma: float
    z: float
    r: tuple
    a: tuple
    turn: float
    lift: float
    turn_bent: float
    lift_bent: float

    def length(self, i):
        return math.hypot(self.r[i], self.a[i])


class Pin:
    """The pin, which is in both grooves."""

    def __init__(self, first, second):
        self.first, self.second = first, second

    @property
    def values(self):
        cams = {f"cam{i}.{name}": value for i, g in self.numbered for name, value in g.parameters.items()}
        return cams | {f"cam{i}.radius": g.radius for i, g in self.numbered}

    @property
    def numbered(self):
        return enumerate((self.first, self.second), start=1)

    def at(self, theta):
        first, second = self.first, self.second
        # both grooves rise through 0
        low = max(min(theta, 0.0), first.first, theta - second.last)
        high = min(max(theta, 0.0), first.last, theta - second.first)
        gap = lambda x: first.z(x) - second.z(theta - x)  # noqa: E731
        gamma = low if low == high else brentq(gap, low, high, xtol=1e-16, rtol=1e-15)
        a1, a2 = first.slope(gamma), second.slope(theta - gamma)
        b1, b2 = first.bend(gamma), second.bend(theta - gamma)
        total = a1 + a2
        turn = a2 / total  # gamma'
        # d/dtheta of g1(gamma) = g2(phi), twice
        turn_bent = (b2 * (1 - turn) ** 2 - b1 * turn**2) / total
        lift_bent = b1 * turn**2 + a1 * turn_bent
        radii = first.radius, second.radius
        return Place(gamma, first.z(gamma), radii, (a1, a2), turn, a1 * turn, turn_bent, lift_bent)


def edge(place, mu, direction, force):
    """Section 3 by trial of every pair of flanks: the torque at which motion in `direction` begins against
    the axial force, with both x_i = R_i/hypot(r_i, a_i); infinite where no pair of flanks is consistent."""
    (r1, r2), (a1, a2) = place.r, place.a
    s = 1 if force >= 0 else -1
    for e1, e2 in ((s, s), (s, -s), (-s, s), (-s, -s)):
        n1, n2 = a1 + direction * e1 * mu[0] * r1, a2 + direction * e2 * mu[1] * r2
        d1, d2 = r1 - direction * e1 * mu[0] * a1, r2 - direction * e2 * mu[1] * a2
        delta = r2 * d1 * n2 + r1 * d2 * n1
        x1, x2 = force * r2 * n2 / delta, force * r1 * n1 / delta
        if e1 * x1 >= 0 and e2 * x2 >= 0:
            return r2 * n2 * x2, (x1, x2)
    return direction * math.inf, None


def band(place, mu, force):
    return edge(place, mu, -1, force)[0], edge(place, mu, 1, force)[0]


def spring_force(values, z):
    k = [values.get(f"spring.{name}", 0.0) for name in ("preload", "stiffness", "stiffness2", "stiffness3")]
    return k[0] + z * (k[1] + z * (k[2] + z * k[3]))


def spring_energy(values, z):
    k = [values.get(f"spring.{name}", 0.0) for name in ("preload", "stiffness", "stiffness2", "stiffness3")]
    return z * (k[0] + z * (k[1] / 2 + z * (k[2] / 3 + z * k[3] / 4)))


def damper_force(values, v):
    way = "load" if v > 0 else "release"
    return v * (values.get(f"damper.c_{way}", 0.0) + values.get(f"damper.q_{way}", 0.0) * abs(v))


def friction(values):
    return values["cam1.friction"], values["cam2.friction"]


def polynomial(u, t):
    """Value at t of the polynomial whose value and derivatives at 0 are u."""
    return sum(value * t**k / math.factorial(k) for k, value in enumerate(u))
