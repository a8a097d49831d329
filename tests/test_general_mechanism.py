"""The general mechanism: elliptical and tabulated grooves, polynomial spring, quadratic dampers, curved
inputs.

Nothing here is compared with what the FMU or its reference printed earlier: closed forms, the equations of
the mechanism page written down once more (class Pin and the functions after it, with SciPy), the energy
ledger, and the residual of the friction inclusion. The headings are the sections of that page; "bend" is
g_i''.
"""

import math
from dataclasses import dataclass
from itertools import pairwise, product

import build_fmu
import mpmath
import numpy as np
import pytest
from driver import FORWARD, Driver, load, models
from mechanisms import RHO
from reference import (
    INTEGERS,
    LOADING,
    LOWER_STOP,
    RELEASING,
    STICK,
    UPPER_STOP,
    WEDGED,
    random_scene,
)
from scipy.integrate import quad, solve_ivp
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


# ---- the equations once more ----


@dataclass(frozen=True)
class Groove:
    """z, slope and bend over the angle in the groove; the FMU's parameters for it, without `cam1.`."""

    radius: float
    parameters: dict
    z: object
    slope: object
    bend: object
    first: float = -math.inf  # the angles it is made for
    last: float = math.inf


def helix(radius, lead):
    gain = radius * math.tan(lead)
    return Groove(
        radius, {"profile": HELIX, "lead_angle": lead}, lambda x: gain * x, lambda x: gain, lambda x: 0.0
    )


def ellipse(radius, lead, a, b, kappa):
    """Section 2, word for word."""
    start = math.sin(math.atan(a / b * math.tan(lead)))

    def S(x):
        return start + kappa * radius * x / a

    return Groove(
        radius,
        {
            "profile": ELLIPSE,
            "lead_angle": lead,
            "ellipse_a": a,
            "ellipse_b": b,
            "ellipse_curvature": kappa,
        },
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
    psi[-1] = reach  # rounding
    return sampled(Groove(radius, {}, slope.integ(), slope, slope.deriv()), path, psi)


@dataclass(frozen=True)
class Place:
    """Section 2 at one theta, `bent` for second derivatives."""

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
    """The pin in both grooves."""

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
    the axial force, with both x_i = R_i/hypot(r_i, a_i); infinite where no pair agrees with itself."""
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
    """Value at t of the input with these value and derivatives at 0."""
    return sum(value * t**k / math.factorial(k) for k, value in enumerate(u))


# ---- random mechanisms ----


def random_mechanism(rng, folder, pair=None, regime="inertial"):
    """Grooves and the FMU's parameters; sizes such that it swings within some 10 ms and reaches its stops."""
    lower, upper = float(rng.choice([0.0, -rng.uniform(0.2, 0.8)])), rng.uniform(0.6, 1.4)
    kinds = pair or rng.choice(KINDS, 2)
    reach = max(upper, -lower) * 1.02
    name = f"{rng.integers(2**40):x}"
    pin = Pin(*(random_groove(rng, kind, reach, folder / f"{name}-{i}.csv") for i, kind in enumerate(kinds)))
    travel = max(pin.at(upper).z, -pin.at(lower).z)
    force = 10.0 ** rng.uniform(1.5, 2.5)

    def some(share, draw):
        return float(draw()) if rng.random() < share else 0.0

    values = pin.values | {
        "cam1.friction": some(0.9, lambda: rng.uniform(0.02, 0.3)),
        "cam2.friction": some(0.9, lambda: rng.uniform(0.02, 0.3)),
        "spring.preload": force * rng.uniform(0.0, 0.5),
        "spring.stiffness": force / travel * rng.uniform(0.3, 1.0),
        "spring.stiffness2": some(0.7, lambda: force / travel**2 * rng.uniform(-0.3, 0.6)),
        "spring.stiffness3": some(0.7, lambda: force / travel**3 * rng.uniform(-0.2, 0.6)),
        "stop.lower": lower,
        "stop.upper": upper,
        "stop.restitution": some(0.6, lambda: rng.uniform(0.1, 0.7)),
        "initial.theta": rng.uniform(lower, upper),
        "inertia.shaft": 0.0,
        "contacts": int(rng.integers(1, 3)),
    }
    lift = pin.at(0.5 * (lower + upper)).lift
    if regime == "inertial":
        shaft = force * lift * 10.0 ** rng.uniform(-4, -2.5)
        values |= {
            "inertia.shaft": shaft,
            "inertia.follower_mass": some(0.6, lambda: shaft / lift**2 * rng.uniform(0.05, 0.5)),
            "inertia.follower": some(0.6, lambda: shaft * rng.uniform(0.05, 0.5)),
            "initial.omega": some(0.4, lambda: rng.uniform(-10.0, 10.0)),
        }
    if regime != "rate-independent":
        speed = 20.0 * lift  # m/s
        for name in ("load", "release"):
            values[f"damper.c_{name}"] = force / speed * rng.uniform(0.02, 0.5)
            values[f"damper.q_{name}"] = some(0.8, lambda: force / speed**2 * rng.uniform(0.02, 0.5))
        values["shaft.damping"] = some(0.5, lambda: force * lift / 20.0 * rng.uniform(0.01, 0.2))
    return pin, values


def random_inputs(rng, values, pin, h, curved=True):
    """tau and F_ext over a step of h: value and derivatives at its start."""
    place = pin.at(values["stop.upper"])
    force = spring_force(values, place.z)
    tau = force * place.lift * rng.choice([0.0, rng.uniform(-1.0, 0.5), rng.uniform(0.0, 2.0)])
    pull = force * rng.choice([0.0, 0.0, rng.uniform(-1.5, 0.5)])
    orders = rng.integers(0, 4) if curved else 0
    shares = rng.uniform(-1.0, 1.0, (2, orders))
    tau_way, pull_way = abs(tau) + 0.2 * force * place.lift, abs(pull)
    return {
        "tau": [float(tau), *(float(s) * tau_way / h ** (k + 1) for k, s in enumerate(shares[0]))],
        "F_ext": [float(pull), *(float(s) * pull_way / h ** (k + 1) for k, s in enumerate(shares[1]))],
    }


def step(fmu, h, inputs):
    fmu.set({name: u[0] for name, u in inputs.items()})
    rates = {name: u[1:] for name, u in inputs.items() if any(u[1:])}
    if rates:
        fmu.set_derivatives(rates)
    fmu.step(h)


def run_on(fmu, inputs, start, end, pieces):
    """`inputs`, polynomials from time 0 on, from `start` to `end` in some steps."""
    for t, later in pairwise(np.linspace(start, end, pieces + 1)):
        now = {
            name: [polynomial(u[k:], t) for k in range(len(u))] for name, u in inputs.items()
        }  # derivatives of the Taylor polynomial
        step(fmu, float(later - t), now)


def reactions(fmu):
    """Totals."""
    return tuple(fmu.get("contacts") * fmu.get(f"cam{i}.reaction") for i in (1, 2))


def turned_over(fmu):
    return sum(abs(fmu.get(name)) for name in ACCOUNTS)


# ---- section 2: kinematics ----


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_section_2_kinematics(make, tmp_path, pair):
    """gamma, z, v and both sliding speeds |psi_i'| r_i sqrt(1 + s_i^2), and z' and z'' through fmi2's output
    derivatives; against the root of g1(gamma) = g2(theta - gamma)."""
    rng = np.random.default_rng([2, *map(KINDS.index, pair)])
    for _ in range(6):
        pin, values = random_mechanism(rng, tmp_path, pair)
        for _ in range(4):
            theta = rng.uniform(values["stop.lower"], values["stop.upper"])
            omega = rng.uniform(-5.0, 5.0)
            fmu = make().start(values | {"initial.theta": theta, "initial.omega": omega})
            place, z_size = pin.at(theta), abs(pin.at(values["stop.upper"]).z)
            assert fmu.get("gamma") == pytest.approx(place.gamma, abs=2e-14)
            assert fmu.get("z") == pytest.approx(place.z, abs=2e-14 * z_size)
            assert fmu.get("v") == pytest.approx(place.lift * omega, rel=2e-12)
            assert fmu.output_derivative("z", 1) == fmu.get("v")
            speeds = [
                abs(omega * turn) * place.length(i) for i, turn in enumerate((place.turn, 1 - place.turn))
            ]
            for i in range(2):
                assert fmu.get(f"cam{i + 1}.sliding_speed") == pytest.approx(speeds[i], rel=2e-12)
            bent = place.lift * fmu.get("alpha") + place.lift_bent * omega**2
            size = abs(place.lift * fmu.get("alpha")) + abs(place.lift_bent * omega**2)
            assert fmu.output_derivative("z", 2) == pytest.approx(bent, abs=1e-10 * size)


def test_section_2_at_zero_and_both_stops(make, tmp_path):
    """z = gamma = 0 at theta = 0, whatever grooves; and the stops themselves are ordinary places."""
    rng = np.random.default_rng(22)
    for pair in PAIRS:
        pin, values = random_mechanism(rng, tmp_path, pair)
        for theta in (0.0, values["stop.lower"], values["stop.upper"]):
            fmu = make().start(values | {"initial.theta": theta, "initial.omega": 0.0})
            assert fmu.get("theta") == theta
            assert fmu.get("gamma") == pytest.approx(pin.at(theta).gamma, abs=2e-14)
            if theta == 0.0:
                assert (fmu.get("z"), fmu.get("gamma")) == pytest.approx((0.0, 0.0), abs=1e-16)


# ---- section 3: statics ----


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_section_3_statics(make, tmp_path, pair):
    """Both edges of the stick band, efficiency and, just beyond the edges, both reactions, at random angles;
    F_0 of either sign (flank rule: the band is mirrored)."""
    rng = np.random.default_rng([3, *map(KINDS.index, pair)])
    for _ in range(6):
        pin, values = random_mechanism(rng, tmp_path, pair)
        values |= {"initial.omega": 0.0, "inertia.follower_mass": 0.0, "inertia.follower": 0.0}
        margin = 0.1 * (values["stop.upper"] - values["stop.lower"])
        theta = rng.uniform(values["stop.lower"] + margin, values["stop.upper"] - margin)
        place, mu = pin.at(theta), friction(values)
        for pull in (0.0, -2.0 * spring_force(values, place.z)):
            force = spring_force(values, place.z) + pull
            release, load = band(place, mu, force)
            rest = {"initial.theta": theta, "F_ext": pull, "tau": 0.5 * (release + load)}
            fmu = make().start(values | rest)
            assert fmu.get("spring.force") == pytest.approx(force - pull, rel=1e-12)
            assert fmu.get("torque_load") == pytest.approx(load, rel=1e-11)
            assert fmu.get("torque_release") == pytest.approx(release, rel=1e-11)
            assert fmu.get("efficiency") == pytest.approx(release / load, rel=1e-11)
            assert release <= load
            shared = force * place.lift  # frictionless: T = tau_1 = tau_2
            for i in range(2):
                normal = shared * place.length(i) / (place.r[i] * place.a[i]) / values["contacts"]
                assert fmu.get(f"cam{i + 1}.reaction") == pytest.approx(normal, rel=1e-11)
            for direction, torque in ((1, load), (-1, release)):
                _, x = edge(place, mu, direction, force)
                fmu = make().start(values | {"initial.theta": theta, "F_ext": pull})
                fmu.step(1e-9, tau=torque + direction * 1e-3 * abs(load))
                assert fmu.get("mode") == (LOADING if direction > 0 else RELEASING)
                for i in range(2):
                    assert reactions(fmu)[i] == pytest.approx(x[i] * place.length(i), rel=1e-6)


FLAT_MU = 0.2


def flattening():
    """An elliptical groove whose lead angle falls from 0.6 to 0 in about 0.75 rad, so that friction of 0.2
    locks it from psi_lock on, beside a helix of 0.9 rad. s(psi) = mu at S^2 = m^2/(1 + m^2), m = mu a/b."""
    a, b = 0.03, 0.03
    first, second = ellipse(0.02, 0.6, a, b, -1), helix(0.02, 0.9)
    m = FLAT_MU * a / b
    psi = (math.sin(math.atan(a / b * math.tan(0.6))) - m / math.hypot(1.0, m)) * a / first.radius
    assert first.slope(psi) == pytest.approx(FLAT_MU * first.radius, rel=1e-14)
    pin = Pin(first, second)
    lock = psi + first.z(psi) / second.slope(0.0)
    values = pin.values | {
        "cam1.friction": FLAT_MU,
        "cam2.friction": 0.1,
        "spring.preload": 100.0,
        "spring.stiffness": 1e4,
        "stop.upper": 1.02 * lock,
    }
    return pin, values, lock


@pytest.mark.parametrize("swapped", [False, True], ids=["cam 1 locks", "cam 2 locks"])
def test_section_3_a_contact_locks_along_the_groove(make, swapped):
    """torque_release falls through 0 where lambda = atan mu, for either cam: before that place the spring
    drives the mechanism back, beyond it it holds itself without torque, and letting go takes tau < 0, with
    the pin of the other groove on its other flank."""
    pin, values, lock = flattening()
    if swapped:  # gamma and phi change places, theta and z do not
        pin = Pin(pin.second, pin.first)
        values |= pin.values | {"cam1.friction": 0.1, "cam2.friction": FLAT_MU}
    mu, locked = friction(values), int(swapped)
    assert make().start(values | {"initial.theta": lock}).get("torque_release") == pytest.approx(
        0.0, abs=1e-13
    )
    for theta, sign in ((lock - 0.01, 1), (lock - 1e-6, 1), (lock + 1e-6, -1), (lock + 0.01, -1)):
        place = pin.at(theta)
        release, x = edge(place, mu, -1, spring_force(values, place.z))
        fmu = make().start(values | {"initial.theta": theta})
        assert math.copysign(1, release) == math.copysign(1, fmu.get("torque_release")) == sign
        assert fmu.get("torque_release") == pytest.approx(
            release, rel=1e-8 if abs(theta - lock) < 1e-3 else 1e-12
        )
        assert (x[1 - locked] > 0) == (sign > 0) and x[locked] > 0
        fmu.step(0.2)
        if sign < 0:
            assert (fmu.get("mode"), fmu.get("theta")) == (STICK, theta)
            fmu.step(1e-9, tau=1.01 * release)
            assert fmu.get("mode") == RELEASING
            assert reactions(fmu) == pytest.approx([x[i] * place.length(i) for i in range(2)], rel=1e-6)
        elif theta < lock - 1e-3:
            assert (fmu.get("mode"), fmu.get("theta")) == (LOWER_STOP, 0.0)
        else:  # drives it, but hardly
            assert fmu.get("mode") == RELEASING


def test_section_3_falling_back_through_the_place_where_it_locks(make):
    """Released by tau < 0 from the locked part, the flanks change on the way and nothing is lost: the sum
    of the accounts closes, and without inertia the torque to be overcome is the edge at every angle."""
    pin, values, lock = flattening()
    mu = friction(values)
    fmu = make().start(values | {"inertia.shaft": 0.0, "initial.theta": 1.015 * lock})
    start = edge(pin.at(1.015 * lock), mu, -1, spring_force(values, pin.at(1.015 * lock).z))[0]
    assert start < 0
    fmu.step(0.1, tau=0.999 * start)
    assert (fmu.get("mode"), fmu.get("theta")) == (STICK, 1.015 * lock)
    # torque_release rises as theta falls, so past its edge nothing stops the jump but the stop
    fmu.step(0.1, tau=1.001 * start)
    assert (fmu.get("mode"), fmu.get("theta")) == (LOWER_STOP, 0.0)
    assert abs(fmu.get("energy.residual")) <= 1e-10 * turned_over(fmu)
    assert min(fmu.get(name) for name in HEATS) >= 0.0


def test_section_3_both_contacts_lock(make):
    """Both lead angles below both friction angles: n_1, n_2 < 0 at sigma = -1, so both pins stay on their
    supporting flanks and T_release = F r1 r2 n1 n2/Delta < 0 (Delta < 0)."""
    first, second = ellipse(0.02, 0.15, 0.1, 0.1, -1), ellipse(0.03, 0.1, 0.1, 0.1, 1)
    pin = Pin(first, second)
    values = pin.values | {
        "cam1.friction": 0.25,
        "cam2.friction": 0.3,
        "spring.preload": 80.0,
        "stop.upper": 0.4,
    }
    for theta in (0.0, 0.1, 0.4):
        place = pin.at(theta)
        (r1, r2), (a1, a2) = place.r, place.a
        n1, n2, d1, d2 = a1 - 0.25 * r1, a2 - 0.3 * r2, r1 + 0.25 * a1, r2 + 0.3 * a2
        force = spring_force(values | {"spring.stiffness": 5e4}, place.z)
        torque = force * r1 * r2 * n1 * n2 / (r2 * d1 * n2 + r1 * d2 * n1)
        assert n1 < 0 and n2 < 0 and torque < 0
        fmu = make().start(values | {"initial.theta": theta})
        assert fmu.get("torque_release") == pytest.approx(torque, rel=1e-11)
        fmu.step(0.1, tau=0.99 * torque)
        assert (fmu.get("mode"), fmu.get("theta")) == (STICK, theta)


def wedging():
    """Cam 1, r = 60 mm, flattens from 0.2 rad to level; cam 2 is a helix of 0.15 rad; mu = 0.14. Where
    (1 + mu s1)/(r1 (mu - s1)) falls below kappa_2 = (1 - mu s2)/(r2 (s2 + mu)), no pair of flanks agrees
    with its reactions at sigma = -1."""
    mu, a, b = 0.14, 0.06, 0.06
    pin = Pin(ellipse(0.06, 0.2, a, b, -1), helix(0.02, 0.15))
    s2 = math.tan(0.15)
    kappa = (1 - mu * s2) / (0.02 * (s2 + mu))
    s1 = (kappa * 0.06 * mu - 1) / (kappa * 0.06 + mu)  # of (1 + mu s1) = kappa r1 (mu - s1)
    psi = (math.sin(math.atan(a / b * math.tan(0.2))) - math.sin(math.atan(a / b * s1))) * a / 0.06
    wedge = psi + pin.first.z(psi) / pin.second.slope(0.0)
    values = pin.values | {
        "cam1.friction": mu,
        "cam2.friction": mu,
        "spring.stiffness": 0.0,
        "spring.preload": 100.0,
    }
    return pin, values | {"stop.upper": 1.05 * wedge}, wedge


def test_section_3_wedged_along_the_groove(make):
    """Short of the place torque_release falls without bounds, beyond it no torque lets go and loading goes
    on as ever."""
    pin, values, wedge = wedging()
    mu = friction(values)
    for theta in (wedge - 1e-3, wedge - 1e-6, wedge + 1e-6, wedge + 1e-3):
        place = pin.at(theta)
        release, load = band(place, mu, 100.0)
        fmu = make().start(values | {"initial.theta": theta})
        assert fmu.get("torque_load") == pytest.approx(load, rel=1e-11)
        if theta < wedge:
            assert fmu.get("torque_release") == pytest.approx(release, rel=1e-7)
            assert release < -0.1
        else:
            assert release == fmu.get("torque_release") == -math.inf
            fmu.step(0.01, tau=-1e6)
            assert (fmu.get("mode"), fmu.get("theta")) == (WEDGED, theta)
            fmu.step(0.01, tau=0.5 * load)
            assert (fmu.get("mode"), fmu.get("theta")) == (STICK, theta)
            fmu.step(1e-4, tau=1.1 * load)
            assert fmu.get("mode") == LOADING


# ---- section 4: power balance ----


@pytest.mark.parametrize("seed", range(12))
def test_section_4_every_account_at_an_instant(make, tmp_path, seed):
    """While it slips, d/dt of each account, by differences over tiny steps, is the power worked out from
    forces, reactions and speeds read in the middle: P_i = mu_i |R_i| v_i, D v, b omega^2, F_ext v, tau
    omega."""
    rng = np.random.default_rng([4, seed])
    pin, values = random_mechanism(rng, tmp_path)
    values |= {"stop.lower": -0.0, "initial.theta": 0.3 * values["stop.upper"], "initial.omega": 2.0}
    fmu = make().start(values, tolerance=1e-12)
    place = pin.at(values["initial.theta"])
    inputs = {
        "tau": [1.5 * band(place, friction(values), spring_force(values, place.z))[1], 3.0, -40.0],
        "F_ext": [0.1 * spring_force(values, place.z), 50.0],
    }
    h, warm = 2e-5, 1e-3
    run_on(fmu, inputs, 0.0, warm, 1)
    sample, names = [], [*ACCOUNTS]
    for k in range(5):
        sample.append([fmu.get(name) for name in names])
        if k == 2:
            assert fmu.get("mode") == LOADING
            read = {
                n: fmu.get(n) for n in ("tau", "F_ext", "omega", "v", "alpha", "spring.force", "damper.force")
            }
            force, speed = reactions(fmu), [fmu.get(f"cam{i}.sliding_speed") for i in (1, 2)]
            here = pin.at(fmu.get("theta"))
        run_on(fmu, inputs, warm + k * h, warm + (k + 1) * h, 1)
    a0, a1, _, a3, a4 = map(np.array, sample)
    power = dict(zip(names, (a0 - 8 * a1 + 8 * a3 - a4) / (12 * h), strict=True))
    omega, v = read["omega"], read["v"]
    mass, twist = values["inertia.follower_mass"], values["inertia.follower"]
    v_rate = here.lift * read["alpha"] + here.lift_bent * omega**2
    turn_rate = here.turn * read["alpha"] + here.turn_bent * omega**2
    expected = {
        "energy.heat_cam1": values["cam1.friction"] * abs(force[0]) * speed[0],
        "energy.heat_cam2": values["cam2.friction"] * abs(force[1]) * speed[1],
        "energy.heat_damper": read["damper.force"] * v,
        "energy.heat_shaft": values["shaft.damping"] * omega**2,
        "energy.heat_stop": 0.0,
        "energy.work_in": read["tau"] * omega,
        "energy.work_ext": read["F_ext"] * v,
        "energy.work_tuning": 0.0,
        "energy.spring": read["spring.force"] * v,
        "energy.kinetic": values["inertia.shaft"] * read["alpha"] * omega
        + mass * v_rate * v
        + twist * turn_rate * here.turn * omega,
    }
    assert read["damper.force"] == pytest.approx(damper_force(values, v), rel=1e-13)
    size = max(map(abs, expected.values()))
    for name, value in expected.items():
        assert power[name] == pytest.approx(value, abs=3e-8 * size), name
    # and the balance itself, to rounding: T omega = F v + P1 + P2 and the rates of kinetic energy
    heat = expected["energy.heat_cam1"] + expected["energy.heat_cam2"] + expected["energy.heat_damper"]
    out = heat + expected["energy.heat_shaft"] + expected["energy.work_ext"]
    balance = expected["energy.work_in"] - out - expected["energy.spring"] - expected["energy.kinetic"]
    assert abs(balance) <= 1e-12 * sum(map(abs, expected.values()))


@pytest.mark.parametrize("regime", ["inertial", "viscous", "rate-independent"])
def test_section_4_ledger(make, tmp_path, regime):
    """The ledger closes within ten times the tolerance of what was turned over, at any tolerance; no
    heat is ever given back; what is stored is what z and the speeds say."""
    rng = np.random.default_rng([44, len(regime)])
    for tolerance in (1e-4, 1e-9, 1e-11) * 4:
        pin, values = random_mechanism(rng, tmp_path, regime=regime)
        fmu, heats = make().start(values, tolerance=tolerance), dict.fromkeys(HEATS, 0.0)
        total, last = turned_over(fmu), [fmu.get(name) for name in ACCOUNTS]
        for _ in range(40):
            h = 10.0 ** rng.uniform(-4, -1.5)
            step(fmu, h, random_inputs(rng, values, pin, h))
            now = [fmu.get(name) for name in ACCOUNTS]
            total += sum(abs(a - b) for a, b in zip(now, last, strict=True))
            last = now
            assert abs(fmu.get("energy.residual")) <= 10 * tolerance * total
            for name, before in heats.items():
                assert fmu.get(name) >= before - 1e-14 * total
            heats = {name: fmu.get(name) for name in HEATS}
            place, omega = pin.at(fmu.get("theta")), fmu.get("omega")
            moving = values["inertia.shaft"]
            moving += values.get("inertia.follower_mass", 0.0) * place.lift**2
            moving += values.get("inertia.follower", 0.0) * place.turn**2
            assert fmu.get("energy.kinetic") == pytest.approx(0.5 * moving * omega**2, rel=1e-11)
            assert fmu.get("energy.spring") == pytest.approx(
                spring_energy(values, place.z), rel=1e-11, abs=1e-13 * total
            )
        assert total > 0.0


# ---- section 5: elements ----


def test_section_5_spring(make):
    """F_s = F0 + k z + k2 z^2 + k3 z^3 and its integral from 0, on both sides of z = 0."""
    spring = {
        "spring.preload": 30.0,
        "spring.stiffness": 2e4,
        "spring.stiffness2": -3e5,
        "spring.stiffness3": 4e7,
    }
    pin = Pin(ellipse(0.02, 0.5, 0.1, 0.1, 1), helix(0.03, 0.7))
    for theta in (-0.6, -0.1, 0.0, 0.2, 1.0):
        values = pin.values | spring | {"stop.lower": -0.6, "stop.upper": 1.0, "initial.theta": theta}
        fmu, z = make().start(values), pin.at(theta).z
        assert fmu.get("spring.force") == pytest.approx(30 + 2e4 * z - 3e5 * z**2 + 4e7 * z**3, rel=1e-13)
        energy, _ = quad(lambda x: spring_force(spring, x), 0.0, z, epsabs=1e-15)
        assert fmu.get("energy.spring") == pytest.approx(energy, rel=1e-11, abs=1e-16)


@pytest.mark.parametrize("omega", [-7.0, -1e-3, 1e-3, 7.0])
def test_section_5_damper_opposes_the_motion(make, omega):
    """D = v (c_load + q_load v) upwards, v (c_release + q_release |v|) downwards."""
    damper = {"load": (110.0, 900.0), "release": (40.0, 3000.0)}
    values = {f"damper.{letter}_{way}": damper[way][i] for way in damper for i, letter in enumerate("cq")}
    fmu = make().start(values | {"initial.theta": 0.7, "initial.omega": omega})
    v = 0.01 * omega
    c, q = damper["load" if omega > 0 else "release"]
    assert fmu.get("v") == pytest.approx(v, rel=1e-15)
    assert fmu.get("damper.force") == pytest.approx(v * (c + q * abs(v)), rel=1e-14)
    assert fmu.get("damper.force") * v > 0


@pytest.mark.parametrize("restitution", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("side", [-1, 1])
def test_section_5_end_stops(make, restitution, side):
    """On an ellipse, without friction, spring, damper and torque the kinetic energy is constant but for
    impacts: 0.5 (J + m z'^2 + I gamma'^2) omega^2, of which (1 - e^2) goes to the stop at each; omega turns
    round there by -e."""
    pin = Pin(ellipse(0.02, 0.5, 0.06, 0.06, 1), ellipse(0.03, 0.9, 0.08, 0.06, -1))
    values = pin.values | {
        "cam1.friction": 0.0,
        "cam2.friction": 0.0,
        "spring.preload": 0.0,
        "spring.stiffness": 0.0,
    }
    values |= {
        "inertia.shaft": 1e-3,
        "inertia.follower_mass": 4.0,
        "inertia.follower": 2e-3,
        "stop.lower": -0.2,
    }
    values |= {
        "stop.restitution": restitution,
        "stop.upper": 0.8,
        "initial.theta": 0.3,
        "initial.omega": 2.0 * side,
    }

    def inertia(theta):
        place = pin.at(theta)
        return 1e-3 + 4.0 * place.lift**2 + 2e-3 * place.turn**2

    stop = 0.8 if side > 0 else -0.2
    kinetic = 0.5 * inertia(0.3) * 4.0
    # omega = sqrt(2 E/inertia): the time to the stop by quadrature
    late = 0.02
    span, _ = quad(
        lambda x: math.sqrt(inertia(x) / (2 * kinetic)), min(0.3, stop), max(0.3, stop), epsabs=1e-13
    )
    fmu = make().start(values, tolerance=1e-12)
    fmu.step(span * (1 - 1e-9))
    assert fmu.get("omega") == pytest.approx(side * math.sqrt(2 * kinetic / inertia(stop)), rel=1e-7)
    assert fmu.get("energy.kinetic") == pytest.approx(kinetic, rel=1e-10)
    fmu.step(span * 1e-9 + late)
    left = restitution**2 * kinetic
    assert fmu.get("energy.heat_stop") == pytest.approx(kinetic - left, rel=1e-10, abs=1e-13)
    assert fmu.get("energy.kinetic") == pytest.approx(left, rel=1e-10)
    assert fmu.get("mode") == (STICK if restitution == 0 else RELEASING if side > 0 else LOADING)
    if restitution == 0.0:
        assert fmu.get("theta") == stop
        return
    back, _ = quad(
        lambda x: math.sqrt(inertia(x) / (2 * left)), *sorted((stop, fmu.get("theta"))), epsabs=1e-13
    )
    assert back == pytest.approx(late, rel=1e-8)


def test_section_5_a_stop_carries_only_what_presses(make, tmp_path):
    """At rest at the upper stop: mode 5 above T_load, stick in the band, and release below it; mirrored at
    the lower stop."""
    rng = np.random.default_rng(55)
    for _ in range(10):
        pin, values = random_mechanism(rng, tmp_path)
        for side, name in ((1, "stop.upper"), (-1, "stop.lower")):
            place = pin.at(values[name])
            release, load = band(place, friction(values), spring_force(values, place.z))
            out, inside = (load, release) if side > 0 else (release, load)
            fmu = make().start(values | {"initial.theta": values[name], "initial.omega": 0.0})
            gap = 1e-6 * (load - release) + 1e-9
            fmu.step(0.1, tau=out + side * gap)
            assert (fmu.get("mode"), fmu.get("theta")) == (
                UPPER_STOP if side > 0 else LOWER_STOP,
                values[name],
            )
            if load - release > 1e-6:
                fmu.step(0.1, tau=out - side * gap)
                assert (fmu.get("mode"), fmu.get("theta")) == (STICK, values[name])
                fmu.step(0.1, tau=inside + side * gap)
                assert (fmu.get("mode"), fmu.get("theta")) == (STICK, values[name])
            fmu.step(1e-7, tau=inside - side * gap)
            assert fmu.get("mode") == (RELEASING if side > 0 else LOADING)
            assert side * fmu.get("theta") <= side * values[name]


# ---- section 6: forward dynamics ----


def moving_residual(fmu, pin, values):
    """How far theta, omega, alpha and the reactions read from the FMU miss the equations of sliding,
    relative to the sizes of their terms. Flanks: the signs of the reactions."""
    theta, omega, alpha = fmu.get("theta"), fmu.get("omega"), fmu.get("alpha")
    place, mu, direction = pin.at(theta), friction(values), 1 if fmu.get("mode") == LOADING else -1
    (r1, r2), (_a1, _a2) = place.r, place.a
    assert direction * omega >= 0.0
    x = [normal / place.length(i) for i, normal in enumerate(reactions(fmu))]
    e = [1 if value >= 0 else -1 for value in x]
    n = [a + direction * k * m * r for a, k, m, r in zip(place.a, e, mu, place.r, strict=True)]
    d = [r - direction * k * m * a for a, k, m, r in zip(place.a, e, mu, place.r, strict=True)]
    mass, twist = values.get("inertia.follower_mass", 0.0), values.get("inertia.follower", 0.0)
    lift_parts = mass * place.lift * alpha, mass * place.lift_bent * omega**2
    turn_parts = twist * place.turn * alpha, twist * place.turn_bent * omega**2
    axial_parts = [
        spring_force(values, place.z),
        fmu.get("F_ext"),
        damper_force(values, place.lift * omega),
        *lift_parts,
    ]
    torque_parts = [
        fmu.get("tau"),
        -values.get("shaft.damping", 0.0) * omega,
        -values["inertia.shaft"] * alpha,
    ]
    force, torque, moment = math.fsum(axial_parts), math.fsum(torque_parts), math.fsum(turn_parts)
    # the page's form, with the factors that are infinite at lambda = 0 multiplied out
    delta = r2 * d[0] * n[1] + r1 * d[1] * n[0]
    rho, rho_kappa1 = r1 * r2 * n[0] * n[1] / delta, r2 * n[1] * d[0] / delta
    size = abs(rho) * sum(map(abs, axial_parts)) + abs(rho_kappa1) * sum(map(abs, turn_parts))
    size += sum(map(abs, torque_parts))
    law = abs(torque - rho * force - rho_kappa1 * moment) / size
    # the balances that it is made of
    x2 = abs(torque - r2 * n[1] * x[1]) / size
    x1 = abs(torque - moment - r1 * n[0] * x[0]) / size
    return max(law, x1, x2)


def agrees_at_rest(fmu, pin, values):
    """Is the state a rest that section 3 allows?"""
    theta, tau, mode = fmu.get("theta"), fmu.get("tau"), fmu.get("mode")
    place = pin.at(theta)
    force = spring_force(values, place.z) + fmu.get("F_ext")
    release, load = band(place, friction(values), force)
    terms = spring_force(
        {name: abs(value) for name, value in values.items() if "spring" in name}, abs(place.z)
    )
    rounding = 1e-12 * (abs(tau) + place.lift * (abs(fmu.get("F_ext")) + terms))
    if fmu.get("omega") != 0.0:
        return False
    if mode == STICK:
        return release - rounding <= tau <= load + rounding
    if mode == LOWER_STOP:
        return theta == values["stop.lower"] and tau <= release + rounding
    if mode == UPPER_STOP:
        return theta == values["stop.upper"] and tau >= load - rounding
    return math.isinf(release if tau < place.lift * force else load)


@pytest.mark.parametrize("tolerance", [1e-4, None])
@pytest.mark.parametrize("regime", ["inertial", "viscous", "rate-independent"])
def test_section_6_residual_of_the_inclusion(make, tmp_path, regime, tolerance):
    """At every communication point of random scenes, whatever the tolerance: while it slips,
    T = tau - b omega - J alpha equals rho (F_s + F_ext + D + m z_ddot) + rho kappa_1 I gamma_ddot on the
    flanks that the signs of the reactions name; at rest T_release <= tau <= T_load, or a stop or a wedge
    holds it. 1e-12 of the terms is rounding: that of theta and z, amplified where a term is steep."""
    rng = np.random.default_rng([6, len(regime)])
    seen, mixed = dict.fromkeys(range(1, 7), 0), 0
    for _ in range(40):
        pin, values = random_mechanism(rng, tmp_path, regime=regime)
        fmu = make().start(values, tolerance=tolerance)
        for _ in range(30):
            h = 10.0 ** rng.uniform(-4, -1.5)
            step(fmu, h, random_inputs(rng, values, pin, h))
            mode = fmu.get("mode")
            seen[mode] += 1
            if mode in (LOADING, RELEASING):
                assert moving_residual(fmu, pin, values) <= 1e-12, (values, fmu.get("theta"))
                mixed += reactions(fmu)[0] * reactions(fmu)[1] < 0
            else:
                assert agrees_at_rest(fmu, pin, values), (values, fmu.get("theta"), mode)
    assert min(seen[mode] for mode in (STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP)) >= 3, seen
    assert mixed >= 3 or regime != "inertial"


@pytest.mark.parametrize("seed", range(8))
def test_section_6_motion_against_an_integrator(make, tmp_path, seed):
    """A swing without a mode change: the equation of motion, solved for alpha by the two balances,
    integrated by SciPy (DOP853, 1e-12)."""
    rng = np.random.default_rng([66, seed])
    pin, values = random_mechanism(rng, tmp_path, PAIRS[1 + seed])
    values |= {"initial.theta": 0.1 * values["stop.upper"], "initial.omega": 1.0}
    mu, p = friction(values), values
    place = pin.at(0.5 * values["stop.upper"])
    inputs = {
        "tau": [2.0 * band(place, mu, spring_force(values, place.z))[1], 20.0, -3e3, 2e5],
        "F_ext": [1.0, 30.0],
    }

    def alpha(t, theta, omega):
        """x1, x2 and alpha from three linear equations; both reactions positive all the time."""
        q = pin.at(theta)
        (r1, r2), (a1, a2) = q.r, q.a
        tau, pull = (polynomial(inputs[name], t) for name in ("tau", "F_ext"))
        axial = spring_force(p, q.z) + pull + damper_force(p, q.lift * omega)
        axial += p["inertia.follower_mass"] * q.lift_bent * omega**2
        moment = p["inertia.follower"] * q.turn_bent * omega**2
        matrix = [
            [r1 - mu[0] * a1, r2 - mu[1] * a2, -p["inertia.follower_mass"] * q.lift],
            [-r1 * (a1 + mu[0] * r1), r2 * (a2 + mu[1] * r2), -p["inertia.follower"] * q.turn],
            [0.0, r2 * (a2 + mu[1] * r2), p["inertia.shaft"]],
        ]
        x1, x2, acceleration = np.linalg.solve(
            matrix, [axial, moment, tau - p.get("shaft.damping", 0.0) * omega]
        )
        assert x1 > 0 and x2 > 0
        return acceleration

    def upper(_t, y):
        return values["stop.upper"] - y[0]

    def turning(_t, y):
        return y[1]

    upper.terminal = turning.terminal = True
    found = solve_ivp(
        lambda t, y: [y[1], alpha(t, *y)], (0.0, 0.05), [values["initial.theta"], 1.0],
        method="DOP853", rtol=1e-12, atol=1e-14, events=[upper, turning], dense_output=True,
    )  # fmt: skip
    end = found.t[-1]
    assert end > 1e-3
    for tolerance in (1e-6, None, 1e-11):
        fmu = make().start(values, tolerance=tolerance)
        size = max(np.abs(found.y[1]))
        for part in np.linspace(0.0, 0.99, 4)[1:]:
            run_on(fmu, inputs, fmu.time, part * end, 2)
            theta, omega = found.sol(part * end)
            assert fmu.get("theta") == pytest.approx(
                theta, abs=10 * (tolerance or 1e-9) * values["stop.upper"]
            )
            assert fmu.get("omega") == pytest.approx(omega, abs=10 * (tolerance or 1e-9) * size)


RIGHT_ANGLED = {"stop.lower": -40.0, "stop.upper": 40.0}


@pytest.mark.parametrize(("direction", "tau"), [(1, 5.0), (-1, 0.2)])
def test_section_6_viscous_linear_and_quadratic_damper(make, direction, tau):
    """c v + q v |v| = tau/rho - F_0 - k z, so (c + 2 q |v|) dv/dt = -k v: with x = 2 q |v|/c,
    x e^x = x_0 e^(x_0 - k t/c), x = W(...)."""
    c, q, k, preload = 900.0, 8000.0, 5e4, 50.0
    way = "load" if direction > 0 else "release"
    values = RIGHT_ANGLED | {"inertia.shaft": 0.0, f"damper.c_{way}": c, f"damper.q_{way}": q}
    start = 0.0 if direction > 0 else 0.6
    fmu = make().start(values | {"initial.theta": start})
    rho = RHO[direction]
    with mpmath.workdps(30):
        push = direction * (mpmath.mpf(tau) / rho - preload - k * mpmath.mpf(start) * 0.01)
        x0 = mpmath.sqrt(1 + 4 * q * push / c**2) - 1  # 2 q v/c of q v^2 + c v = push
        t = 0.0
        for h in (1e-4, 3e-3, 1e-2, 3e-2):
            fmu.step(h, tau=tau)
            t += h
            speed = c / (2 * q) * mpmath.lambertw(x0 * mpmath.exp(x0 - k * t / c)).real
            z = (tau / rho - preload - direction * (c * speed + q * speed**2)) / k
            assert fmu.get("z") == pytest.approx(float(z), rel=2e-9)
            assert fmu.get("v") == pytest.approx(float(direction * speed), rel=1e-7)
            assert fmu.get("omega") == pytest.approx(fmu.get("v") / 0.01, rel=1e-14)
            assert fmu.get("mode") == (LOADING if direction > 0 else RELEASING)


@pytest.mark.parametrize("inertia", [0.0, 0.002])
@pytest.mark.parametrize(("tau", "rho"), [(0.1, RHO[-1]), (0.0, RHO[-1]), (-0.3, RHO[1])])
def test_section_6_braking_return_through_the_damper(make, inertia, tau, rho):
    """The paper's (4) with a spring force that does not change: released, it ends at the speed at which
    c |v| + q v^2 = F_0 - tau/rho. With tau < 0 the total F is negative, the pins bear on their other
    flanks, and rho_+ applies. Without inertia that is so at once."""
    c, q, preload = 60.0, 900.0, 50.0
    values = RIGHT_ANGLED | {"inertia.shaft": inertia, "damper.c_release": c, "damper.q_release": q}
    values |= {"spring.stiffness": 0.0, "spring.preload": preload, "initial.theta": 39.0}
    fmu = make().start(values)
    fmu.step(2.5 if inertia else 1e-3, tau=tau)
    push = preload - tau / rho
    speed = (math.sqrt(c * c + 4 * q * push) - c) / (2 * q)
    assert fmu.get("mode") == RELEASING
    assert fmu.get("v") == pytest.approx(-speed, rel=1e-9)
    assert fmu.get("damper.force") == pytest.approx(-push, rel=2e-9)
    if tau:
        assert (
            math.copysign(1, tau)
            == math.copysign(1, reactions(fmu)[0])
            == math.copysign(1, reactions(fmu)[1])
        )


@pytest.mark.parametrize("stiffness", [0.0, 2000.0])
def test_section_6_quadratic_damper_riccati(make, stiffness):
    """Helices, J and q only: J omega omega' = tau - rho (F_0 + k z' theta) - rho q z'^2 omega^2, so omega^2
    is linear in theta plus an exponential; without spring rate omega = w tanh(w p t), w^2 = net/(rho q
    z'^2), J p = rho q z'^2, and theta = ln cosh(w p t)/p."""
    inertia, q, tau = 0.002, 3e4, 3.0
    values = RIGHT_ANGLED | {"damper.q_load": q, "spring.stiffness": stiffness}
    fmu = make().start(values, tolerance=1e-11)
    p = RHO[1] * q * 1e-4 / inertia
    net, rate = (tau - RHO[1] * 50.0) / inertia, RHO[1] * stiffness * 0.01 / inertia
    for h in (1e-3, 1e-2, 0.04, 0.05):
        fmu.step(h, tau=tau)
        assert fmu.get("mode") == LOADING
        theta = fmu.get("theta")
        # u = omega^2: u'/2 = net - rate theta - p u; u = A - B theta - A exp(-2 p theta)
        B = rate / p
        A = (net + 0.5 * B) / p
        square = -A * math.expm1(-2 * p * theta) - B * theta
        assert fmu.get("omega") == pytest.approx(math.sqrt(square), rel=1e-9)
        if stiffness == 0.0:
            w = math.sqrt(net / p)
            assert fmu.get("omega") == pytest.approx(w * math.tanh(w * p * fmu.time), rel=1e-9)
            assert theta == pytest.approx(math.log(math.cosh(w * p * fmu.time)) / p, rel=1e-9)
    # heat in the damper: integral of q z'^3 omega^3 dt = integral of q z'^3 omega^2 dtheta
    heat = q * 1e-6 * (A * theta - 0.5 * B * theta**2 + A * math.expm1(-2 * p * theta) / (2 * p))
    assert fmu.get("energy.heat_damper") == pytest.approx(heat, rel=1e-9)


def play_mechanism():
    """Both cams elliptical, nonlinear spring; T_load and T_release rise from stop to stop."""
    pin = Pin(ellipse(0.02, 0.8203, 0.06, 0.05, -1), ellipse(0.03, 0.6, 0.08, 0.05, 1))
    values = pin.values | {"cam1.friction": 0.14, "cam2.friction": 0.19, "inertia.shaft": 0.0}
    values |= {
        "spring.preload": 50.0,
        "spring.stiffness": 2e4,
        "spring.stiffness2": 4e5,
        "spring.stiffness3": 2e7,
    }
    values |= {"stop.upper": 1.2}

    def torque(theta, direction):
        place = pin.at(theta)
        return edge(place, friction(values), direction, spring_force(values, place.z))[0]

    def angle(tau, direction):
        ends = torque(0.0, direction), torque(1.2, direction)
        if not ends[0] < tau < ends[1]:
            return 0.0 if tau <= ends[0] else 1.2
        return brentq(lambda x: torque(x, direction) - tau, 0.0, 1.2, xtol=1e-15)

    return pin, values, torque, angle


def test_section_6_play_on_an_ellipse(make):
    """Without inertia and damping: theta stays inside the band, else it is on the edge, to where
    T_load(theta) = tau on the way up, T_release(theta) = tau on the way down."""
    _pin, values, torque, angle = play_mechanism()
    rng, theta, fmu, moves = np.random.default_rng(7), 0.0, make().start(values), 0
    for _ in range(60):
        tau = rng.uniform(0.3, 1.02) * torque(1.2, 1)
        fmu.step(0.01, tau=tau)
        before = theta
        theta = min(max(theta, angle(tau, 1)), angle(tau, -1))
        moves += theta != before
        assert fmu.get("theta") == pytest.approx(theta, abs=1e-11)
        assert fmu.get("omega") == 0.0
    assert moves >= 20
    assert abs(fmu.get("energy.residual")) <= 1e-9 * fmu.get("energy.work_in")


@pytest.mark.parametrize("ramped", [False, True])
def test_section_6_hysteresis_loop(make, ramped):
    """Over a closed loop the work of tau is what the friction took: the area between the edges
    T_load and T_release, from the angle where the lower torque lets go to that where the upper one arrives;
    whether tau jumps or ramps."""
    _pin, values, torque, angle = play_mechanism()
    high, low = 0.9 * torque(1.2, 1), 1.3 * torque(0.0, 1)
    top, bottom = angle(high, 1), angle(low, -1)
    assert 0.0 < bottom < top < 1.2
    fmu = make().start(values, tolerance=1e-11)

    def go(old, new):
        if ramped:
            run_on(fmu, {"tau": [old, (new - old) / 0.3]}, 0.0, 0.3, 3)
            assert fmu.get("mode") in (LOADING, RELEASING)
        fmu.step(0.1, tau=new)
        if ramped:
            assert fmu.get("omega") == 0.0

    # Driver counts time on its own; run_on takes times of the inputs only
    go(0.0, high)
    go(high, low)
    assert fmu.get("theta") == pytest.approx(bottom, abs=1e-11)
    before = {name: fmu.get(name) for name in ACCOUNTS}
    go(low, high)
    assert fmu.get("theta") == pytest.approx(top, abs=1e-11)
    go(high, low)
    assert fmu.get("theta") == pytest.approx(bottom, abs=1e-11)
    gain = {name: fmu.get(name) - value for name, value in before.items()}
    area, _ = quad(lambda x: torque(x, 1) - torque(x, -1), bottom, top, epsabs=1e-13)
    assert gain["energy.heat_cam1"] + gain["energy.heat_cam2"] == pytest.approx(area, rel=1e-9)
    assert gain["energy.work_in"] == pytest.approx(area, rel=1e-9)
    assert gain["energy.spring"] == pytest.approx(0.0, abs=1e-10)
    assert min(gain["energy.heat_cam1"], gain["energy.heat_cam2"]) > 0.1 * area


def test_section_6_speed_along_the_edge(make):
    """A ramp of tau along the edge: omega = (dtau/dt)/(dT/dtheta), by differences of the edge."""
    _, values, torque, angle = play_mechanism()
    fmu = make().start(values, tolerance=1e-11)
    start = torque(0.3, 1)
    fmu.step(0.1, tau=start)
    run_on(fmu, {"tau": [start, 4.0, 3.0]}, 0.0, 0.1, 1)
    theta = angle(start + 0.4 + 0.015, 1)
    assert fmu.get("theta") == pytest.approx(theta, abs=1e-11)
    h = 1e-3
    slope = (torque(theta - 2 * h, 1) - 8 * torque(theta - h, 1)) / (12 * h)
    slope += (8 * torque(theta + h, 1) - torque(theta + 2 * h, 1)) / (12 * h)
    assert fmu.get("omega") == pytest.approx(4.3 / slope, rel=1e-8)


# ---- section 7: inverse dynamics ----


def test_section_7_the_inverse_of_this_motion(make, make_model, tmp_path):
    """The inverse FMU, driven by theta, omega, alpha of a general motion, asks for the torque that made it
    (test_inverse.py has the rest of this section)."""
    rng, compared = np.random.default_rng(77), 0
    for _ in range(8):
        pin, values = random_mechanism(rng, tmp_path)
        forward = make().start(values, tolerance=1e-11)
        shared = {name: value for name, value in values.items() if not name.startswith("initial.")}
        inverse = make_model(models["DualCamInverse"])
        inverse.start(shared | {"theta": values["initial.theta"]})
        for _ in range(20):
            h = 10.0 ** rng.uniform(-4, -2)
            step(forward, h, random_inputs(rng, values, pin, h))
            if forward.get("mode") not in (LOADING, RELEASING):
                continue
            inverse.set({name: forward.get(name) for name in ("theta", "omega", "alpha", "F_ext")})
            place, tau = pin.at(forward.get("theta")), forward.get("tau")
            size = abs(tau) + place.lift * (abs(forward.get("spring.force")) + abs(forward.get("F_ext")))
            size += abs(values["inertia.shaft"] * forward.get("alpha"))
            assert inverse.get("tau") == pytest.approx(tau, abs=1e-9 * size)
            for i in (1, 2):
                name = f"cam{i}.reaction"
                assert inverse.get(name) == pytest.approx(forward.get(name), rel=1e-7, abs=1e-7)
            compared += 1
    assert compared > 40


# ---- section 8: efficiency, dwells ----


@pytest.mark.parametrize(
    ("mu", "r", "best"),
    [
        ((0.14, 0.14), (0.02, 0.02), 0.5690981841),
        ((0.14, 0.14), (0.03, 0.018), 0.5690981841),
        ((0.19, 0.19), (0.02, 0.025), 0.4633147377),
        ((0.1, 0.2), (0.03, 0.02), None),
        ((0.25, 0.05), (0.02, 0.03), None),
    ],
)
def test_section_8_optimum_passed_on_ellipses(make, mu, r, best):
    """Two flattening ellipses, made so that both grooves have tan lambda_i = mu_i/mu_e at one theta: the
    efficiency there is ((1 - mu_e)/(1 + mu_e))^2, and is smaller everywhere else on the way. For mu1 = mu2
    that is pi/4, and the page's number."""
    mu_e = math.sqrt((mu[0] / r[0] + mu[1] / r[1]) / (1 / (mu[0] * r[0]) + 1 / (mu[1] * r[1])))
    target = [math.atan(m / mu_e) for m in mu]
    if best is None:
        best = ((1 - mu_e) / (1 + mu_e)) ** 2
    else:
        assert mu_e == pytest.approx(mu[0], rel=1e-15) and target == pytest.approx(
            [math.pi / 4] * 2, rel=1e-15
        )

    def rise(lead, radius, a, b, end):
        """Angle and z at which an ellipse that starts at `lead` has flattened to `end`."""
        S0, S1 = (math.sin(math.atan(a / b * math.tan(x))) for x in (lead, end))
        return (S0 - S1) * a / radius, b * (math.sqrt(1 - S1**2) - math.sqrt(1 - S0**2))

    a, b = 0.06, 0.05
    first = target[0] + 0.15
    psi1, z = rise(first, r[0], a, b, target[0])
    second = brentq(
        lambda x: rise(x, r[1], a, b, target[1])[1] - z, target[1], min(target[1] + 0.5, 1.5), xtol=1e-15
    )
    psi2, _ = rise(second, r[1], a, b, target[1])
    at = psi1 + psi2
    pin = Pin(ellipse(r[0], first, a, b, -1), ellipse(r[1], second, a, b, -1))
    values = pin.values | {"cam1.friction": mu[0], "cam2.friction": mu[1], "stop.upper": 1.5 * at}

    def efficiency(theta):
        return make().start(values | {"initial.theta": theta}).get("efficiency")

    assert [math.atan(a / r) for a, r in zip(pin.at(at).a, pin.at(at).r, strict=True)] == pytest.approx(
        target, rel=1e-12
    )
    assert efficiency(at) == pytest.approx(best, abs=1e-10)
    assert best == pytest.approx(((1 - mu_e) / (1 + mu_e)) ** 2, abs=1e-10)
    scan = [efficiency(x) for x in np.linspace(0.0, 1.5 * at, 16) if abs(x - at) > 1e-6]
    assert max(scan) < best
    assert max(efficiency(at - 1e-3), efficiency(at + 1e-3)) < best


DWELL = (0.5, 0.9)  # rad in the groove


def dwelling(folder, cam):
    """A table that rises, stands still over DWELL, rises; beside it a helix. On the dwell of cam 1 the pin
    stands still in cam 2, and goes along the groove of cam 1; on that of cam 2 it stands still altogether.
    theta at which the dwell begins and ends."""
    radius, slope, other = 0.02, 0.02, 0.02 * math.tan(0.7)
    psi = np.arange(0, 29) * 0.05
    z = slope * (np.minimum(psi, DWELL[0]) + np.maximum(psi - DWELL[1], 0.0))
    z[(psi >= DWELL[0] - 1e-9) & (psi <= DWELL[1] + 1e-9)] = slope * DWELL[0]
    table = {"profile": TABLE, "table": write_table(folder / "dwell.csv", psi, z), "radius": radius}
    plain = {"profile": HELIX, "lead_angle": 0.7, "radius": 0.02}
    values = {f"cam{cam}.{name}": value for name, value in table.items()}
    values |= {f"cam{3 - cam}.{name}": value for name, value in plain.items()}
    begin = DWELL[0] + slope * DWELL[0] / other
    return values | {"stop.upper": 1.8}, (begin, begin + DWELL[1] - DWELL[0]), slope * DWELL[0], other


@pytest.mark.parametrize("cam", [1, 2])
def test_section_8_dwell_without_friction_in_it(make, tmp_path, cam):
    """On the dwell of one cam, with friction only in the other, in which the pin does not move: both edges
    are 0, and cam 2 goes on at a constant speed however hard the spring presses."""
    values, (begin, end), height, _ = dwelling(tmp_path, cam)
    values |= {f"cam{cam}.friction": 0.0, f"cam{3 - cam}.friction": 0.3, "inertia.follower_mass": 3.0}
    fmu = make().start(values | {"initial.theta": begin + 0.01, "initial.omega": 2.0})
    for _ in range(5):
        fmu.step(0.03)
        assert fmu.get("omega") == pytest.approx(2.0, rel=1e-12)
        assert (fmu.get("v"), fmu.get("alpha")) == pytest.approx((0.0, 0.0), abs=1e-9)
        assert fmu.get("z") == pytest.approx(height, rel=1e-12)
        assert (fmu.get("torque_load"), fmu.get("torque_release")) == pytest.approx((0.0, 0.0), abs=1e-14)
        assert fmu.get(f"cam{3 - cam}.sliding_speed") == pytest.approx(0.0, abs=1e-15)
        assert fmu.get(f"cam{cam}.sliding_speed") == pytest.approx(2.0 * 0.02, rel=1e-12)
    assert fmu.get("theta") == pytest.approx(begin + 0.31, rel=1e-12)
    assert [fmu.get(name) for name in HEATS] == pytest.approx([0.0] * 5, abs=1e-12)
    fmu.step(0.02, tau=1.0)  # alpha = tau/J, as if nothing else were there
    assert fmu.get("omega") == pytest.approx(2.0 + 1.0 / 0.002 * 0.02, rel=1e-9) or fmu.get("theta") > end


@pytest.mark.parametrize("cam", [1, 2])
@pytest.mark.parametrize("other", [0.0, 0.2])
def test_section_8_dwell_brakes_the_mechanism(make, tmp_path, cam, other):
    """z stands still, yet friction on the dwell takes torque: with a = 0 in that groove
    T = F r1 r2 n1 n2/Delta, n = sigma e mu r of the dwelling cam. Both ways the mechanism is self-locking
    there; thrown in, it comes to rest after omega^2 J/(2 T), and stays."""
    values, (begin, end), height, slope = dwelling(tmp_path, cam)
    mu = 0.25
    values |= {f"cam{cam}.friction": mu, f"cam{3 - cam}.friction": other}
    force = 50.0 + 5e4 * height
    r = 0.02
    d = r - other * slope
    n = slope + other * r
    load = force * r * r * mu * r * n / (r * r * n + r * d * mu * r)
    # sigma = -1: the dwelling contact stays on its flank (n = -mu r), so the other one has to change its own
    release = -force * r * r * mu * r * n / (r * r * n - r * d * mu * r)
    fmu = make().start(values | {"initial.theta": begin + 0.02})
    assert fmu.get("torque_load") == pytest.approx(load, rel=1e-11)
    assert fmu.get("torque_release") == pytest.approx(release, rel=1e-11)
    for torque, mode in ((0.99 * load, STICK), (0.99 * release, STICK), (0.0, STICK)):
        fmu.step(0.01, tau=torque)
        assert (fmu.get("mode"), fmu.get("theta")) == (mode, begin + 0.02)
    omega = math.sqrt(2 * load * 0.3 / 0.002)
    fmu = make().start(values | {"initial.theta": begin + 0.02, "initial.omega": omega})
    assert fmu.get("alpha") == pytest.approx(-load / 0.002, rel=1e-10)
    fmu.step(0.5)
    assert (fmu.get("mode"), fmu.get("omega")) == (STICK, 0.0)
    assert fmu.get("theta") == pytest.approx(begin + 0.32, rel=1e-10)
    assert fmu.get("z") == pytest.approx(height, rel=1e-12)
    assert fmu.get(f"energy.heat_cam{cam}") == pytest.approx(load * 0.3, rel=1e-10)
    assert fmu.get(f"energy.heat_cam{3 - cam}") == pytest.approx(0.0, abs=1e-12)
    fmu = make().start(
        values | {"initial.theta": end - 0.02, "initial.omega": -math.sqrt(-2 * release * 0.3 / 0.002)}
    )
    fmu.step(0.5)
    assert (fmu.get("mode"), fmu.get("omega")) == (STICK, 0.0)
    assert fmu.get("theta") == pytest.approx(end - 0.32, rel=1e-10)


@pytest.mark.parametrize("shaft", [0.0, 1e-3])
@pytest.mark.parametrize("direction", [-1, 1])
def test_section_8_dwell_where_the_other_contact_locks(make, tmp_path, shaft, direction):
    """On the dwell of cam 1, without friction there, cam 2's groove of 0.1 rad locks at mu = 0.2: braking the
    follower asks contact 2 for a torque that no flank gives it while sliding. Whatever the FMU makes of that,
    it has to be a number, and the ledger has to close: neither contact has any friction power to go by."""
    values, (begin, _), _, _ = dwelling(tmp_path, 1)
    slope = 0.02 * math.tan(0.1)
    start = (
        begin - 0.01 / (0.02 * math.tan(0.7)) + 0.01 / slope + 0.2
    )  # phi at which z = 10 mm is another one
    values |= {"cam2.lead_angle": 0.1, "cam1.friction": 0.0, "cam2.friction": 0.2, "inertia.shaft": shaft}
    values |= {"inertia.follower": 1e-4, "spring.preload": 0.0, "spring.stiffness": 0.0, "stop.upper": 6.5}
    fmu = make().start(values | {"initial.theta": start, "initial.omega": float(direction)})
    assert fmu.get("v") == pytest.approx(0.0, abs=1e-14)
    fmu.step(1e-3, tau=-float(direction))
    assert all(math.isfinite(fmu.get(name)) for name in (*ACCOUNTS, "energy.residual", "theta", "omega"))
    assert abs(fmu.get("energy.residual")) <= 1e-8 * turned_over(fmu)


# ---- the general machinery on helices: against the closed form ----


@pytest.fixture(scope="module")
def library_without_closed_form(tmp_path_factory):
    """The forward FMU in which every scene takes the way of general grooves."""
    fmu = build_fmu.dual_cam(FORWARD.identifier, check=False)
    library = tmp_path_factory.mktemp("general") / "DualCamForward.so"
    flags = [*build_fmu.TARGET, *build_fmu.SHARED, *fmu.defines, *build_fmu.identity(fmu)]
    build_fmu.compile_c(build_fmu.ZIG, [*flags, "-DDUALCAM_NO_CLOSED_FORM"], fmu.sources, library)
    return load(library)


MOTION = ("theta", "omega")


def play_scene(fmu, params, intervals, tolerance):
    """What is read after each interval."""
    given = {name: int(value) if name in INTEGERS else float(value) for name, value in params.items()}
    fmu.start(given | {"tau": intervals[0].tau, "F_ext": intervals[0].F_ext}, tolerance=tolerance)
    read = []
    for i in intervals:
        step(fmu, i.duration, {"tau": [i.tau, i.tau_rate], "F_ext": [i.F_ext, i.F_ext_rate]})
        read.append({name: fmu.get(name) for name in (*MOTION, *ACCOUNTS, "energy.residual", "peak.omega")})
    return read


@pytest.mark.parametrize("chunk", range(3))
def test_general_machinery_on_helices(make, library_without_closed_form, chunk):
    """Both ways through the same random helical scenes, in whole intervals: angle, speed and every account
    within ten times the tolerance of the scene's largest angle, speed, energy."""
    wrong = []
    for seed in range(50):
        params, intervals = random_scene(np.random.default_rng([62, chunk, seed]))
        exact = play_scene(make(), params, intervals, None)
        energy = max(abs(read[name]) for read in exact for name in ACCOUNTS) or 1.0
        size = dict.fromkeys([*ACCOUNTS, "energy.residual"], energy)
        size |= {
            "theta": max(abs(read["theta"]) for read in exact) or 1.0,
            "omega": exact[-1]["peak.omega"] or 1.0,
        }
        for tolerance in (1e-4, 1e-9, 1e-11):
            fmu = Driver(library_without_closed_form)
            try:
                found = play_scene(fmu, params, intervals, tolerance)
            except AssertionError as refusal:
                wrong.append(f"scene {chunk}, {seed}, at {tolerance}: {refusal}")
                continue
            finally:
                fmu.free()
            errors = {
                name: max(abs(a[name] - b[name]) for a, b in zip(exact, found, strict=True)) / size[name]
                for name in size
            }
            worst = max(errors, key=errors.get)
            if not errors[worst] <= 10 * tolerance:
                wrong.append(f"scene {chunk}, {seed}, at {tolerance}: {worst} misses by {errors[worst]:.1e}")
    assert not wrong, "\n".join(wrong)


def test_general_machinery_by_a_negligible_curvature(make):
    """The shipped FMU takes the general way where tau is curved, however little: on helices that is the
    motion of the closed form. A follower of which only the inertia about the axis counts, without any axial
    load: all reactions vanish and change flanks at once when alpha does."""
    values = {
        "cam1.radius": 0.029513614203264912, "cam1.lead_angle": 0.23071016207401981,
        "cam1.friction": 0.05074597929311204, "cam2.radius": 0.013967140783131205,
        "cam2.lead_angle": 0.4867667483823339, "cam2.friction": 0.08963531572859298, "spring.stiffness": 0.0,
        "spring.preload": 0.0, "inertia.shaft": 3e-5, "inertia.follower": 0.00024354955881143806,
        "initial.theta": 1.0, "initial.omega": -23.273763108264912, "stop.restitution": 0.3,
    }  # fmt: skip
    ramp = [0.3626971619102233, -11.152021961900246]
    plain, curved = make().start(values), make().start(values)
    run_on(plain, {"tau": ramp}, 0.0, 0.1, 1)
    run_on(curved, {"tau": [*ramp, 1e-300]}, 0.0, 0.1, 1)
    for name in (*MOTION, *ACCOUNTS):
        size = turned_over(plain) if name.startswith("energy") else 1.0
        assert curved.get(name) == pytest.approx(plain.get(name), abs=1e-8 * size), name
    whole, pieces = make().start(values), make().start(values)
    run_on(whole, {"tau": [*ramp, -10.337961488405258]}, 0.0, 0.1, 1)
    run_on(pieces, {"tau": [*ramp, -10.337961488405258]}, 0.0, 0.1, 100)
    assert min(fmu.get(name) for fmu in (whole, pieces) for name in HEATS) >= 0.0
    for name in (*MOTION, *ACCOUNTS):
        size = turned_over(pieces) if name.startswith("energy") else 1.0
        assert whole.get(name) == pytest.approx(pieces.get(name), abs=1e-8 * size), name


# ---- tables, states, tuning, inputs ----


@pytest.mark.parametrize("kappa", [-1, 1])
@pytest.mark.parametrize("other", ["helix", "ellipse"])
def test_a_table_of_an_ellipse_moves_like_it(make, tmp_path, kappa, other):
    """Sampled twice as finely, a table comes closer to its ellipse by 2^4.5 or more, in angle, speed and
    work, on a swing without any switch. The slope between the points is of the fourth order, but wrong by
    nothing on the average from point to point, and the work takes the average; starting with some speed, and
    without follower, whose kinetic energy would take the slope at one place."""
    groove = ellipse(0.02, 0.5, 0.06, 0.05, kappa)
    second = helix(0.03, 0.6) if other == "helix" else ellipse(0.03, 0.6, 0.1, 0.09, 1)
    rest = {"stop.upper": 1.0, "spring.stiffness": 2e4, "spring.stiffness2": 1e5, "initial.omega": 8.0}
    rest |= {"damper.c_load": 60.0, "damper.q_load": 200.0}
    names = ("theta", "omega", "energy.work_in")

    def swing(first):
        fmu = make().start(Pin(first, second).values | rest, tolerance=1e-12)
        read = []
        for part in range(1, 6):
            run_on(fmu, {"tau": [4.0, 60.0]}, (part - 1) * 0.004, part * 0.004, 1)
            assert fmu.get("mode") == LOADING
            read.append([fmu.get(name) for name in names])
        assert 0.5 < fmu.get("theta") < 0.55
        return np.array(read)

    true, errors = swing(groove), []
    for count in (8, 16, 32, 64):
        table = sampled(groove, tmp_path / f"{count}.csv", np.linspace(0.0, 0.9, count + 1))
        errors.append(np.max(np.abs(swing(table) - true), axis=0) / np.max(np.abs(true), axis=0))
    assert np.min(np.log2(errors[0] / errors[-1]) / 3) >= 4.5, errors
    assert min(math.log2(a[0] / b[0]) for a, b in pairwise(errors)) >= 4.5, errors
    assert np.max(errors[-1]) < 1e-9


@pytest.mark.parametrize("regime", ["inertial", "viscous", "rate-independent"])
def test_a_restored_general_scene_repeats_bit_for_bit(make, tmp_path, regime):
    """Whatever was done in between, steps of other sizes and inputs included, on the same instance, or on
    another one that got the state as bytes."""
    rng = np.random.default_rng([31, len(regime)])
    for _ in range(6):
        pin, values = random_mechanism(rng, tmp_path, regime=regime)
        plan = [(h, random_inputs(rng, values, pin, h)) for h in 10.0 ** rng.uniform(-4, -1.5, 30)]
        fmu = make().start(values)
        for h, inputs in plan[:10]:
            step(fmu, h, inputs)
        state, time = fmu.take(), fmu.time
        content = fmu.to_bytes(state)

        def rest(driver, plan=plan, time=time):
            driver.time = time
            for h, inputs in plan[10:]:
                step(driver, h, inputs)
            return driver.everything()

        once = rest(fmu)
        fmu.restore(state)
        fmu.time = time
        for h, inputs in plan[20:]:
            step(fmu, 0.37 * h, inputs)
        fmu.restore(state)
        assert rest(fmu) == once
        fmu.free_state(state)
        twin = make().start(values)
        step(twin, 0.013, {"tau": [1.0], "F_ext": [3.0]})
        status, copy = twin.try_from_bytes(content)
        assert status == 0
        twin.restore(copy)
        assert rest(twin) == once
        twin.free_state(copy)


def test_a_reset_instance_is_as_new(make, tmp_path):
    """Ellipses, then tables, then helices on one instance: after fmi2Reset each run is bit for bit that of a
    fresh one."""
    rng, worn = np.random.default_rng(32), make()
    for pair in (("ellipse", "ellipse"), ("table", "table"), ("helix", "helix"), ("table", "ellipse")):
        pin, values = random_mechanism(rng, tmp_path, pair)
        plan = [(h, random_inputs(rng, values, pin, h)) for h in 10.0 ** rng.uniform(-4, -2, 12)]
        runs = []
        for fmu in (worn, make()):
            fmu.start(values)
            for h, inputs in plan:
                step(fmu, h, inputs)
            runs.append(fmu.everything())
        assert runs[0] == runs[1]
        worn.ok("fmi2Reset")


@pytest.mark.parametrize("regime", ["inertial", "viscous", "rate-independent"])
def test_without_ledger_the_general_motion_is_the_same(make, tmp_path, regime):
    rng = np.random.default_rng([33, len(regime)])
    for _ in range(8):
        pin, values = random_mechanism(rng, tmp_path, regime=regime)
        kept, without = make().start(values), make().start(values | {"ledger": False})
        for h in 10.0 ** rng.uniform(-4, -1.5, 25):
            inputs = random_inputs(rng, values, pin, h)
            for fmu in (kept, without):
                step(fmu, h, inputs)
            for name in ("theta", "omega", "z", "v", "alpha", "cam1.reaction", "mode", "events"):
                assert kept.get(name) == without.get(name), name
        assert (
            without.get("energy.work_in")
            == without.get("energy.residual")
            == without.get("peak.omega")
            == 0.0
        )


def test_tuning_during_a_general_run(make, tmp_path):
    """Friction, spring and damper changed while it moves: energy.work_tuning is the jump of the stored
    energy, and from there on it is the run of an FMU that had these parameters from the start."""
    rng = np.random.default_rng(34)
    for pair in PAIRS[1:]:
        pin, values = random_mechanism(rng, tmp_path, pair)
        values |= {"initial.theta": 0.4 * values["stop.upper"]}
        place = pin.at(values["initial.theta"])
        tau = 1.6 * band(place, friction(values), spring_force(values, place.z))[1]
        fmu = make().start(values, tolerance=1e-11)
        fmu.step(1e-3, tau=tau)
        moving, work = fmu.get("omega"), 0.0
        new = {
            "cam1.friction": 0.11, "cam2.friction": 0.07, "spring.preload": 1.3 * values["spring.preload"],
            "spring.stiffness": 0.8 * values["spring.stiffness"], "damper.c_load": 7.0, "damper.q_load": 50.0,
            "damper.c_release": 11.0, "damper.q_release": 3.0,
            "spring.stiffness2": values["spring.stiffness2"] + 1e4, "spring.stiffness3": 1e6,
        }  # fmt: skip
        z, now = pin.at(fmu.get("theta")).z, dict(values)
        for name, value in new.items():
            before = spring_energy(now, z)
            now[name] = value
            work += spring_energy(now, z) - before
            fmu.set({name: value})
            assert fmu.get("energy.work_tuning") == pytest.approx(work, rel=1e-9, abs=1e-13)
        assert fmu.get("omega") == moving
        assert fmu.get("spring.force") == pytest.approx(spring_force(now, z), rel=1e-11)
        place = pin.at(fmu.get("theta"))
        release, load = band(place, friction(now), spring_force(now, place.z))
        assert fmu.get("torque_load") == pytest.approx(load, rel=1e-11)
        assert fmu.get("torque_release") == pytest.approx(release, rel=1e-11)
        start = {"initial.theta": fmu.get("theta"), "initial.omega": moving}
        fresh = make().start(now | start, tolerance=1e-11)
        for h in (1e-3, 4e-3, 2e-2):
            for driver in (fmu, fresh):
                driver.step(h, tau=tau)
            assert fmu.get("theta") == pytest.approx(fresh.get("theta"), abs=1e-10)
            assert fmu.get("omega") == pytest.approx(
                fresh.get("omega"), abs=1e-9 * max(1.0, fresh.get("peak.omega"))
            )
        assert abs(fmu.get("energy.residual")) <= 1e-10 * turned_over(fmu)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_input_derivatives_are_what_finely_cut_inputs_tend_to(make, tmp_path, order):
    """One long step with derivatives of tau and F_ext; and 64, 128, 256 steps with inputs that are constant
    over each, at the middle's value: their error, of the second order in the step, is extrapolated away."""
    rng = np.random.default_rng([35, order])
    for pair in (("ellipse", "ellipse"), ("table", "helix"), ("ellipse", "table")):
        pin, values = random_mechanism(rng, tmp_path, pair)
        values |= {"initial.theta": 0.2 * values["stop.upper"], "initial.omega": 0.0, "stop.restitution": 0.0}
        place, end = pin.at(values["initial.theta"]), 8e-3
        force = spring_force(values, place.z)
        load = band(place, friction(values), force)[1]
        inputs = {
            "tau": [1.4 * load, *(0.3 * load * math.factorial(k) / end**k for k in range(1, order + 1))],
            "F_ext": [0.05 * force, *(-0.1 * force / end**k for k in range(1, order + 1))],
        }
        smooth = make().start(values, tolerance=1e-11)
        step(smooth, end, inputs)
        found = []
        for pieces in (64, 128, 256):
            fmu = make().start(values, tolerance=1e-11)
            for a, b in pairwise(np.linspace(0.0, end, pieces + 1)):
                step(fmu, float(b - a), {name: [polynomial(u, 0.5 * (a + b))] for name, u in inputs.items()})
            found.append(np.array([fmu.get("theta"), fmu.get("omega")]))
        once = [(4 * fine - coarse) / 3 for coarse, fine in pairwise(found)]
        limit = (16 * once[1] - once[0]) / 15
        assert smooth.get("theta") > values["initial.theta"]
        assert smooth.get("theta") == pytest.approx(limit[0], abs=1e-9)
        assert smooth.get("omega") == pytest.approx(limit[1], abs=1e-8 * max(1.0, abs(limit[1])))
        # and the polynomial itself does not mind where it is cut
        cut = make().start(values, tolerance=1e-11)
        run_on(cut, inputs, 0.0, end, 7)
        assert cut.get("theta") == pytest.approx(smooth.get("theta"), abs=1e-10)
        assert cut.get("tau") == pytest.approx(smooth.get("tau"), rel=1e-12)


# ---- what cannot work is said at the start ----


def start_refused(fmu, values, *words):
    """fmi2ExitInitializationMode fails with one message that holds all of these; a reset brings it back."""
    fmu.set(values)
    fmu.setup()
    fmu.ok("fmi2EnterInitializationMode")
    text = fmu.refused_start()
    assert fmu.messages[-1].category == "logStatusError"
    for word in (*words, "must"):
        assert word in text, text
    assert text == text.strip() and len(text) < 700 and "%" not in text
    fmu.ok("fmi2Reset")
    fmu.start({"tau": 5.0})
    fmu.step(1e-3)
    return text


def number_after(text, label):
    """`label = 1.25`, wherever it is in the text."""
    return float(text.split(f"{label} = ")[1].split()[0].rstrip(":;,"))


@pytest.mark.parametrize("cam", [1, 2])
@pytest.mark.parametrize("kappa", [-1, 1])
def test_ellipse_left_before_a_stop(fmu, cam, kappa):
    """S reaches 0 (flattening) or 1 (steepening) at psi = -kappa S0 a/r or (1 - S0) a/r, upwards; and
    downwards the other one. The message names the cam and the stop."""
    lead, a, b, r = 0.7, 0.03, 0.03, 0.02
    S0 = math.sin(math.atan(a / b * math.tan(lead)))
    values = {
        f"cam{cam}.{n}": v
        for n, v in (("profile", ELLIPSE), ("lead_angle", lead), ("ellipse_a", a), ("ellipse_b", b))
    }
    values[f"cam{cam}.ellipse_curvature"] = kappa
    groove = ellipse(r, lead, a, b, kappa)
    up = (1 - S0 if kappa > 0 else S0) * a / r
    down = (S0 if kappa > 0 else 1 - S0) * a / r
    other = 0.02  # slope of the helix, m/rad
    # theta = psi + z(psi)/other, whichever cam is the ellipse
    upper, lower = (x + groove.z(x * (1 - 1e-15)) / other for x in (up, -down))
    for stop, reach, room in (("stop.upper", upper, 0.02), ("stop.lower", lower, -0.02)):
        near = {"stop.upper": 0.5 * upper} | {stop: reach + room}
        text = start_refused(fmu, values | near, f"cam{cam}", "ellips", stop)
        assert number_after(text, "psi") == pytest.approx(up if room > 0 else -down, abs=1e-8)
        # where it is vertical the FMU does without the last 1e-10 of S, which is 1e-5 of sqrt(1 - S^2)
        assert number_after(text, "theta") == pytest.approx(reach, abs=1e-4)
        fmu.ok("fmi2Reset")
        fmu.start(values | near | {stop: reach - 0.2 * room})
        fmu.ok("fmi2Reset")


GOOD = "psi_rad,z_m\n0,0\n0.5,0.01\n1,0.02\n1.5,0.03\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (GOOD.replace("1,0.02", "0.5,0.02"), ("line 4", "psi_rad = 0.5")),
        (GOOD.replace("1,0.02", "1,0.005"), ("line 4", "z_m = 0.005")),
        (GOOD.replace("1.5,0.03\n", ""), ("3 points",)),
        (GOOD.replace("0.01", "nan"), ("line 3", "nan")),
        (GOOD.replace("0.01", "inf"), ("line 3", "inf")),
        (GOOD.replace("psi_rad,z_m", "angle,height"), ("line 1", "angle,height", "psi_rad,z_m")),
        (GOOD.replace("1,0.02", "1;0.02"), ("line 4", "1;0.02")),
        ("", ("psi_rad,z_m",)),
        (None, ("cannot be opened",)),
    ],
)
@pytest.mark.parametrize("cam", [1, 2])
def test_bad_table_at_the_start(fmu, tmp_path, cam, text, words):
    path = tmp_path / "groove.csv"
    if text is not None:
        path.write_text(text)
    values = {f"cam{cam}.profile": TABLE, f"cam{cam}.table": str(path)}
    start_refused(fmu, values, f"cam{cam}.table", str(path), *words)
    path.write_text(GOOD)
    fmu.ok("fmi2Reset")
    fmu.start(values)


@pytest.mark.parametrize("cam", [1, 2])
def test_table_left_before_a_stop(fmu, tmp_path, cam):
    """It ends at psi = 1 and begins at -0.5, with slope 0.02 m/rad as the helix beside it: theta from -1 to
    2."""
    path = tmp_path / "groove.csv"
    write_table(path, np.linspace(-0.5, 1.0, 16), 0.02 * np.linspace(-0.5, 1.0, 16))
    values = {f"cam{cam}.profile": TABLE, f"cam{cam}.table": str(path)}
    start_refused(fmu, values | {"stop.upper": 2.1}, f"cam{cam}", "stop.upper", "2.1")
    fmu.ok("fmi2Reset")
    start_refused(fmu, values | {"stop.lower": -1.1}, f"cam{cam}", "stop.lower", "-1.1")
    fmu.ok("fmi2Reset")
    fmu.start(values | {"stop.lower": -0.99, "stop.upper": 1.99})


def test_jam_inside_the_stop_range(fmu):
    """Two equal steepening ellipses: gamma = phi = theta/2, and kappa_1 + kappa_2 = 0 where both lead angles
    reach pi/2 - atan mu, tan = 1/mu, S = 1/sqrt(1 + (b mu/a)^2)."""
    mu, a, b, r, lead = 0.3, 0.05, 0.05, 0.02, 0.9
    S0, S1 = math.sin(math.atan(a / b * math.tan(lead))), 1 / math.hypot(1.0, b / a * mu)
    jam = 2 * (S1 - S0) * a / r
    values = {f"cam{i}.{n}": v for i in (1, 2) for n, v in ellipse(r, lead, a, b, 1).parameters.items()}
    values |= {"cam1.friction": mu, "cam2.friction": mu}
    text = start_refused(fmu, values | {"stop.upper": jam + 0.01}, "jam", "cam1", "cam2", "stop.upper")
    assert number_after(text, "theta") == pytest.approx(jam, abs=1e-9)
    fmu.ok("fmi2Reset")
    fmu.start(values | {"stop.upper": jam - 1e-6})
    assert fmu.get("torque_load") < math.inf
    # and tuning the friction up to a jam is refused, with nothing changed
    text = fmu.refused_set({"cam1.friction": 0.31}, mentions=("jam",))
    assert number_after(text, "theta") < jam
    fmu.step(1e-3, tau=1.0)


def test_pin_that_nothing_fixes(fmu, tmp_path):
    """Both slopes zero: at psi = 0 of two tables that begin flat; both helices level."""
    path = tmp_path / "flat.csv"
    psi = np.linspace(0.0, 2.0, 21)
    write_table(path, psi, 0.02 * np.maximum(psi - 0.3, 0.0))
    values = {f"cam{i}.{n}": v for i in (1, 2) for n, v in (("profile", TABLE), ("table", str(path)))}
    start_refused(fmu, values, "cam1", "cam2", "theta")
    fmu.ok("fmi2Reset")
    start_refused(fmu, {"cam1.lead_angle": 0.0, "cam2.lead_angle": 0.0}, "cam1.lead_angle", "cam2.lead_angle")
    fmu.ok("fmi2Reset")
    level = {
        "cam1.profile": ELLIPSE,
        "cam1.lead_angle": 0.0,
        "cam1.ellipse_curvature": 1,
        "cam2.lead_angle": 0.0,
    }
    start_refused(fmu, level, "cam1", "cam2")
