"""step.dtheta_d... and step.domega_d...: the Jacobian of a step by state, inputs and tunable parameters,
against differences of the FMU itself, against SciPy with saltation matrices, and against the chain rule."""

import math
import sys
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
import test_friction_law as friction_law
from driver import models
from mechanisms import ELLIPSES, FOLLOWER, FORCES, INERTIA, LIFT, MU, PRELOAD, STIFFNESS
from scipy.integrate import solve_ivp
from test_step_sensitivity import FAST, SCENES, TIGHT, Scene

FORWARD = models["DualCamForward"]
OF_CAM = {
    "friction": 0.02,
    "friction_peak": 0.1,
    "stribeck_velocity": 0.1,
    "friction_viscous": 1.0,
    "friction_load_exponent": 0.1,
    "friction_load": 10.0,
}
OTHERS = {
    "spring.preload": 100.0,
    "spring.stiffness": 1e4,
    "spring.stiffness2": 1e6,
    "spring.stiffness3": 1e8,
    "damper.c_load": 100.0,
    "damper.q_load": 1e3,
    "damper.c_release": 100.0,
    "damper.q_release": 1e3,
}
# all knowns, with the change that shifts the motion about as much as 1 N.m
SIZES = (
    {"theta": 1e-2, "omega": 1.0, "tau": 1.0, "F_ext": 100.0}
    | {f"cam{i}.{name}": size for name, size in OF_CAM.items() for i in (1, 2)}
    | OTHERS
)
LEAST = {"friction_peak": 1.0} | dict.fromkeys(
    (
        "c_load",
        "q_load",
        "c_release",
        "q_release",
        "stribeck_velocity",
        "friction_viscous",
        "friction",
        "stiffness",
    ),
    0.0,
)
INITIAL = {"theta": "initial.theta", "omega": "initial.omega"}
CENTRAL = {1: 0.75, -1: -0.75, 2: -0.15, -2: 0.15, 3: 1 / 60, -3: -1 / 60}
ONE_SIDED = {0: -2.45, 1: 6.0, 2: -7.5, 3: 20 / 3, 4: -3.75, 5: 1.2, 6: -1 / 6}  # at the end of a range

BACK = {"initial.theta": 1.0, "initial.omega": -20.0, "F_ext": -500.0}
HEAVY = {"inertia.follower": 1e-3, "inertia.follower_mass": 0.3}
FLANKS = {  # the axial load changes its sign
    "helices, flanks change": Scene(
        BACK | HEAVY | {"cam1.lead_angle": 0.9, "cam2.lead_angle": 0.9}, -5.0, 0.015, mode=3, size=1e-3
    ),
    "ellipses, flanks change": Scene(BACK | HEAVY | ELLIPSES | FORCES, -5.0, 0.015, mode=3, size=1e-3),
    "under load, flanks change": Scene(
        BACK | HEAVY | ELLIPSES | FORCES | friction_law.LOADED, -5.0, 0.015, mode=3, size=1e-3
    ),
}
BOUNCES = SCENES["stop that bounces, ellipses"]
LAWS = friction_law.SCENES | {
    "speed: bounces": BOUNCES._replace(values=BOUNCES.values | friction_law.STRIBECK)
}
ALL = SCENES | FLANKS | LAWS


def name_of(output: str, known: str) -> str:
    return f"step.d{output}_d{known}"


class Difference(NamedTuple):
    value: float
    error: float  # estimate


class Shifted:
    """A scene, made again and again with one start value shifted."""

    def __init__(self, make_model, scene: Scene) -> None:
        self.scene, self.fmu = scene, make_model(FORWARD)
        self.values = scene.values | {"tau": scene.tau}

    def start_value(self, name: str) -> float:
        return float(self.values.get(name, self.fmu.model.variables[name].start))

    def run(self, values: dict) -> tuple[float, float]:
        fmu = self.fmu
        fmu.ok("fmi2Reset")
        fmu.start(self.values | values, tolerance=TIGHT)
        if self.scene.rates:
            fmu.set_derivatives({"tau": list(self.scene.rates)})
        fmu.step(self.scene.h)
        return fmu.get("theta"), fmu.get("omega")

    def differences(self, known: str) -> list[Difference]:
        """Of order 6, at the shift at which it agrees best with one of a quarter of the size. The error has
        the rounding of the ends: two differences that are rounding may agree by chance."""
        name = INITIAL.get(known, known)
        start, least = self.start_value(name), LEAST.get(known.rpartition(".")[2], -math.inf)
        size = min(10.0 * self.scene.size, 1.0) * SIZES[known]
        if start > least:
            size = min(size, (start - least) / 4.0)
        weights = ONE_SIDED if start == least else CENTRAL
        found = []
        for n in range(6):
            h = size * 0.25**n
            ends = {k: self.run({name: start + k * h}) for k in weights}
            found.append([self.difference(weights, ends, i, h) for i in range(2)])
        pairs = (pairwise(f[i] for f in found) for i in range(2))
        return [
            min(
                (Difference(a.value, abs(a.value - b.value) + b.error) for a, b in both),
                key=lambda d: d.error,
            )
            for both in pairs
        ]

    @staticmethod
    def difference(weights: dict[int, float], ends: dict, i: int, h: float) -> Difference:
        terms = [w * ends[k][i] for k, w in weights.items()]
        return Difference(math.fsum(terms) / h, sys.float_info.epsilon / 2 * sum(map(abs, terms)) / h)


def exists(scene: Scene, known: str, shifted: Shifted) -> bool:
    """Is there a derivative on both sides, or on that of the allowed values?"""
    law = known.partition(".")[2]
    massless = shifted.start_value("inertia.shaft") == 0.0
    if law in ("friction_peak", "stribeck_velocity"):  # a law without a fall: refused without inertia
        return not massless and shifted.start_value(known.partition(".")[0] + ".friction_peak") > 1.0
    if law == "friction_load_exponent" and shifted.start_value(known) == 0.0:
        return not massless and scene not in FLANKS.values()  # else refused; log(R) where R vanishes
    if law.startswith(("c_", "q_", "friction_viscous")) and massless:  # from 0 on damping would begin to act
        return shifted.start_value(known) > 0.0
    return True


@pytest.mark.parametrize("name", ALL)
def test_agrees_with_differences(make_model, name):
    scene = ALL[name]
    shifted = Shifted(make_model, scene)
    shifted.run({})
    found = {known: [shifted.fmu.get(name_of(o, known)) for o in ("theta", "omega")] for known in SIZES}
    compared = 0
    for known in SIZES:
        if not exists(scene, known, shifted):
            continue
        for value, expected in zip(found[known], shifted.differences(known), strict=True):
            bound = 1e-6 * abs(expected.value) + 3.0 * expected.error + 1e-10 / SIZES[known]
            assert abs(value - expected.value) <= bound, (known, value, expected)
            compared += expected.error <= 1e-4 * abs(expected.value)
    assert compared >= (0 if scene.mode == 5 else 1)


# ---- SciPy: the variational equations, with saltation matrices ----

KNOWNS = ("theta", "omega", "tau", "F_ext", "cam1.friction", "spring.preload", "spring.stiffness")


class Helices:
    """J alpha = tau - rho (F_0 + k z' theta) for the default mechanism, and its partial derivatives."""

    radius = 2.0 * LIFT  # z' = r/2 for two helices of 45 deg

    def __init__(self, tau: float, restitution: float) -> None:
        self.tau, self.restitution = tau, restitution

    def rho(self, sigma: int) -> tuple[float, float]:
        """And its derivative by the friction of cam 1, by kappa_i = (1 - sigma mu)/(r (1 + sigma mu))."""
        kappa = (1.0 - sigma * MU) / (self.radius * (1.0 + sigma * MU))
        rho = 0.5 / kappa
        return rho, rho**2 * 2.0 * sigma / (self.radius * (1.0 + sigma * MU) ** 2)

    def alpha(self, theta: float, sigma: int) -> float:
        return (self.tau - self.rho(sigma)[0] * (PRELOAD + STIFFNESS * LIFT * theta)) / INERTIA

    def forcing(self, theta: float, sigma: int) -> np.ndarray:
        """d alpha/d known at constant state."""
        rho, by_friction = self.rho(sigma)
        force = PRELOAD + STIFFNESS * LIFT * theta
        return np.array([0, 0, 1, -rho, -by_friction * force, -rho, -rho * LIFT * theta]) / INERTIA

    def rates(self, _t: float, y: np.ndarray, sigma: int) -> np.ndarray:
        """Of theta, omega and the rows of the variation."""
        theta, omega, x = y[0], y[1], y[2:].reshape(2, -1)
        stiffness = self.rho(sigma)[0] * STIFFNESS * LIFT / INERTIA
        dx = np.array([x[1], -stiffness * x[0] + self.forcing(theta, sigma)])
        return np.concatenate([[omega, self.alpha(theta, sigma)], dx.ravel()])

    def run(self, theta: float, omega: float, h: float) -> tuple[np.ndarray, list[str]]:
        """The variation at the end, and the events."""
        y = np.concatenate([[theta, omega], np.eye(2, len(KNOWNS)).ravel()])
        t, events = 0.0, []
        while t < h:
            sigma = 1 if y[1] > 0.0 or (y[1] == 0.0 and self.alpha(y[0], 1) > 0.0) else -1
            if y[1] == 0.0 and sigma * self.alpha(y[0], sigma) <= 0.0:
                return np.array([y[2:].reshape(2, -1)[0], np.zeros(len(KNOWNS))]), events
            found = self._slip(t, y, sigma, h)
            t, y = found.t[-1], found.y[:, -1]
            for kind, times in zip(("stop", "rest"), found.t_events, strict=True):
                if len(times):
                    y = self._pass(kind, y, sigma)
                    events.append(kind)
        return y[2:].reshape(2, -1), events

    def _slip(self, t: float, y: np.ndarray, sigma: int, h: float):
        def stop(_t, y, *_):
            return y[0] - 1.3963

        def rest(_t, y, *_):
            return y[1]

        stop.terminal = rest.terminal = True
        stop.direction, rest.direction = 1, -sigma
        tight = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
        return solve_ivp(self.rates, (t, h), y, args=(sigma,), events=(stop, rest), **tight)

    def _pass(self, kind: str, y: np.ndarray, sigma: int) -> np.ndarray:
        """x_after = R (x + f_before dt) - f_after dt with dt = -grad g . x/(dg/dt)."""
        theta, omega, x = y[0], y[1], y[2:].reshape(2, -1)
        before = np.array([omega, self.alpha(theta, sigma)])
        if kind == "stop":
            late, after = -x[0] / omega, -self.restitution * omega
            reset, theta = np.diag([1.0, -self.restitution]), 1.3963
            next_alpha = self.alpha(theta, -1)
        else:
            late, after, reset = -x[1] / before[1], 0.0, np.diag([1.0, 0.0])
            turns = -sigma * self.alpha(theta, -sigma) > 0.0
            next_alpha = self.alpha(theta, -sigma) if turns else 0.0
        x = reset @ (x + np.outer(before, late)) - np.outer([after, next_alpha], late)
        return np.concatenate([[theta, after], x.ravel()])


@pytest.mark.parametrize(
    ("omega", "tau", "h", "events"),
    [
        (30.0, 6.0, 0.015, ["stop"]),
        (20.0, 8.0, 0.02, ["stop", "rest"]),
        (35.0, 6.0, 0.04, ["stop", "rest"]),
        (20.0, 4.0, 0.2, ["rest", "rest"]),
    ],
)
def test_agrees_with_variational_equations(make_model, omega, tau, h, events):
    expected, passed = Helices(tau, 0.5).run(1.2, omega, h)
    start = {"initial.theta": 1.2, "initial.omega": omega, "stop.restitution": 0.5, "tau": tau}
    fmu = make_model(FORWARD).start(start)
    fmu.step(h)
    found = np.array([[fmu.get(name_of(o, known)) for known in KNOWNS] for o in ("theta", "omega")])
    assert passed == events
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-12)


# ---- the chain rule, and reading ----


@pytest.mark.parametrize("values", [{}, ELLIPSES | FORCES | FOLLOWER, friction_law.STRIBECK])
def test_halves_make_the_whole(make_model, values):
    """The Jacobian of a step of 2 h from those of two steps of h, with a bounce and a rest inside."""
    knowns = [known for known in SIZES if known not in ("theta", "omega")]
    start = FAST | values | {"stop.restitution": 0.5, "tau": 6.0}

    def step(fmu, h: float) -> tuple[np.ndarray, np.ndarray]:
        fmu.step(h)
        by = [[fmu.get(name_of(o, known)) for known in ("theta", "omega")] for o in ("theta", "omega")]
        rest = [[fmu.get(name_of(o, known)) for known in knowns] for o in ("theta", "omega")]
        return np.array(by), np.array(rest)

    whole, halves = (make_model(FORWARD).start(start, tolerance=TIGHT) for _ in range(2))
    for h in (0.02, 0.02, 0.02):
        state, rest = step(whole, 2.0 * h)
        (first, first_rest), (second, second_rest) = (step(halves, h) for _ in range(2))
        for found, expected in ((second @ first, state), (second @ first_rest + second_rest, rest)):
            np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())


def test_reading_changes_nothing(make_model):
    watched, left_alone = (
        make_model(FORWARD).start(FAST | ELLIPSES | {"stop.restitution": 0.5}) for _ in range(2)
    )
    for k in range(40):
        for fmu in (watched, left_alone):
            fmu.step(0.01, tau=8.0 * math.sin(0.4 * k))
        assert all(
            math.isfinite(watched.get(name_of(o, known))) for o in ("theta", "omega") for known in SIZES
        )
        assert watched.to_bytes(watched.take()) == left_alone.to_bytes(left_alone.take())


def test_of_the_step_as_it_was_made(make_model):
    """Parameters that are set afterwards change nothing."""
    fmu = make_model(FORWARD).start(FAST | {"tau": 5.0})
    names = [name_of(o, known) for o in ("theta", "omega") for known in SIZES]
    assert [fmu.get(name) for name in names] == [0.0] * len(names)
    fmu.step(0.005)
    before = [fmu.get(name) for name in names]
    fmu.set({"cam1.friction": 0.2, "tau": 1.0})
    assert [fmu.get(name) for name in names] == before


@pytest.mark.parametrize(
    ("values", "tau", "known"),
    [
        ({"initial.theta": 1.3963}, 60.0, "theta"),  # held by the stop
        ({"initial.theta": 0.4}, 3.0, "omega"),  # at rest
        ({"initial.theta": 0.4, "inertia.shaft": 0.0, "damper.c_load": 2e3}, 8.0, "omega"),  # no state
        ({"initial.theta": 0.4, "initial.omega": 2.0}, 8.0, "cam1.friction_peak"),  # Coulomb's law
    ],
)
def test_is_zero_where_the_documentation_says_so(make_model, values, tau, known):
    fmu = make_model(FORWARD).start(values | {"tau": tau})
    fmu.step(0.01)
    assert fmu.get(name_of("theta", known)) == fmu.get(name_of("omega", known)) == 0.0
