"""Events and steps where the tolerance, the rounding of theta or stiffness could decide for the motion.

Oracles: motion under constant forces, the equations of docs/mechanism.md with SciPy, the balance of energy,
and the same interval cut differently.
"""

import math

import numpy as np
import pytest
from driver import OK, Driver, models
from numpy.polynomial import Chebyshev
from reference import LOADING, RELEASING
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

FORWARD = models["DualCamForward"]
TOLERANCES = (1e-4, 1e-6, 1e-9)
FREE = {"cam1.friction": 0.0, "cam2.friction": 0.0, "damper.c_load": 0.0, "damper.c_release": 0.0}
LEVEL = FREE | {"spring.stiffness": 0.0, "spring.preload": 0.0, "inertia.shaft": 0.01}
ULP = np.spacing(0.4)  # rad


def step(fmu, h, tau=None, rates=(0.0, 0.0, 0.0)):
    """One step; `rates`: the derivatives of the torque `tau`."""
    if tau is not None:
        fmu.set({"tau": tau})
    if any(rates):
        fmu.set_derivatives({"tau": list(rates)})
    status = fmu.call("fmi2DoStep", fmu.time, h, 1)
    fmu.time += h
    assert status == OK, fmu.messages[-1].text
    return fmu


# ---- end stops ----


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("beyond", [-3e-6, 3e-7, 3e-6, 3e-5, 3e-3])
def test_a_motion_that_would_turn_beyond_the_stop_hits_it(make_model, tolerance, beyond):
    """J alpha = tau, so that the motion has no error. Without a stop it would turn `beyond` rad behind it.
    The torque's tiny third derivative only keeps the closed form away."""
    torque, J, e, upper, begin = -0.5, LEVEL["inertia.shaft"], 0.3, 1.0, 0.4
    braking = -torque / J
    omega = math.sqrt(2.0 * braking * (upper + beyond - begin))
    start = {"initial.theta": begin, "initial.omega": omega, "stop.upper": upper, "stop.restitution": e}
    end = 0.24
    fmu = make_model(FORWARD).start(LEVEL | start, tolerance=tolerance)
    for _ in range(4):
        step(fmu, end / 4, torque, (0.0, 0.0, 1e-12))
    if beyond <= 0.0:
        assert fmu.get("energy.heat_stop") == 0.0
        assert fmu.get("theta") == pytest.approx(begin + end * omega - 0.5 * braking * end**2, abs=1e-9)
        return
    impact = math.sqrt(2.0 * braking * beyond)
    left = end - (omega - impact) / braking
    assert fmu.get("energy.heat_stop") == pytest.approx(0.5 * J * impact**2 * (1 - e * e), rel=1e-7)
    assert fmu.get("theta") == pytest.approx(upper - e * impact * left - 0.5 * braking * left**2, abs=1e-9)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_a_swing_returns_to_the_stop_that_it_left_at_rest(make_model, tolerance):
    """Without friction the swing reaches the stop without speed. Errors of integration hit no stop: the
    motion repeats, and no energy is lost. Period: by DOP853."""
    parameters = FREE | {"spring.stiffness2": 2e6, "spring.preload": 200.0, "inertia.shaft": 0.002}
    parameters |= {"initial.theta": 0.0, "stop.lower": 0.0, "stop.upper": 2.0}
    fmu = make_model(FORWARD).start(parameters, tolerance=tolerance)
    r, a = 0.02, 0.02 * math.tan(fmu.get("cam1.lead_angle"))
    assert (fmu.get("cam1.radius"), fmu.get("cam2.radius")) == (r, r)
    lift, k, tau = a / 2.0, fmu.get("spring.stiffness"), 6.0

    def alpha(_, x):
        z = lift * x[0]
        return [x[1], (tau - lift * (200.0 + k * z + 2e6 * z * z)) / 0.002]

    def turns(_, x):
        return x[1]

    turns.terminal, turns.direction = True, -1
    half = solve_ivp(alpha, (0.0, 1.0), [0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-14, events=turns).t[-1]
    assert half < 0.5
    for _ in range(4):
        step(fmu, half, tau)
        turned = fmu.get("theta")
        step(fmu, half)
        assert fmu.get("theta") <= math.sqrt(tolerance) * turned
    assert fmu.get("energy.heat_stop") <= tolerance * tau * turned


# ---- changes of flanks ----


def table(path, psi, z):
    """A table of a groove; its height at psi = 0 is 0."""
    z = z - np.interp(0.0, psi, z)
    path.write_text("psi_rad,z_m\n" + "\n".join(f"{a:.17g},{b:.17g}" for a, b in zip(psi, z, strict=True)))
    return str(path)


def dwell_table(tmp_path):
    """A rise, a dwell and another rise."""
    psi = np.array([-1.0, -0.6, -0.4, -0.2, 0.0, 0.2, 0.5, 0.9, 1.5])
    z = np.array([0.0, 0.010, 0.0155, 0.017, 0.017, 0.017, 0.022, 0.034, 0.053])
    return table(tmp_path / "dwell.csv", psi, z)


def uneven_table(tmp_path):
    psi = np.linspace(-1.2, 1.6, 8)
    psi[3] = 0.0
    rises = 0.0072 * np.random.default_rng(0).uniform(0.5, 1.0, 7) * 0.4
    return table(tmp_path / "uneven.csv", psi, np.concatenate([[0.0], np.cumsum(rises)]))


@pytest.fixture
def bent(tmp_path):
    """Behind the dwell the groove of cam 2 bends so sharply that at a high speed the follower's inertia
    exceeds the pull of the spring: both contacts change their flanks."""
    return {
        "cam1.radius": 0.26,
        "cam1.lead_angle": 0.04,
        "cam1.friction": 0.2,
        "cam2.profile": 3,
        "cam2.radius": 0.03,
        "cam2.friction": 0.01,
        "cam2.table": dwell_table(tmp_path),
        "stop.lower": -0.6,
        "stop.upper": 0.9,
        "spring.stiffness": 3000.0,
        "spring.preload": -60.0,
        "inertia.shaft": 5e-4,
        "inertia.follower_mass": 0.02,
        "initial.omega": 280.0,
        "contacts": 1,
    }


def test_the_rounding_of_theta_jams_no_motion(make_model, bent):
    """Both reactions vanish at the same angle, since one axial load makes both. Where the motion goes on at
    both sides of this angle, it goes on at each angle in between, however close."""

    def start(theta):
        return make_model(FORWARD).start(bent | {"initial.theta": theta, "tau": 70.0})

    def reaction(theta):
        return start(theta).get("cam2.reaction")

    angles = np.linspace(0.2, 0.3, 81)
    found = [reaction(theta) for theta in angles]
    zeros = [
        brentq(reaction, angles[i], angles[i + 1], xtol=1e-16, rtol=4 * np.finfo(float).eps)
        for i in range(80)
        if found[i] * found[i + 1] < 0.0
    ]
    passed = [x for x in zeros if start(x - 1e-7).get("mode") == start(x + 1e-7).get("mode") == LOADING]
    assert passed
    for zero in passed:
        for k in (*range(-6, 7), *(s * 3**n for n in range(2, 18) for s in (-1, 1))):
            assert start(zero + k * ULP).get("mode") == LOADING, (zero, k)


def test_a_locked_contact_lets_a_dwell_pass(make_model, tmp_path):
    """On a dwell of cam 2 without friction the axial load makes no torque, so that J alpha = tau, however the
    time is cut. Contact 1 passes on nothing: its flank is a matter of rounding."""
    parameters = LEVEL | {
        "cam1.profile": 3,
        "cam1.radius": 0.0072,
        "cam1.table": uneven_table(tmp_path),
        "cam1.friction": 1.2,
        "cam1.friction_viscous": 0.14,
        "cam2.profile": 3,
        "cam2.table": dwell_table(tmp_path),
        "spring.preload": 3.0,
        "stop.lower": -0.6,
        "stop.upper": 0.8,
        "initial.theta": -0.05,
        "inertia.shaft": 1e-3,
    }
    rng = np.random.default_rng(3)
    for pieces in (1, 2, 5, 20, 20, 20):
        times = np.sort(np.concatenate([[0.0, 0.05], rng.uniform(0.0, 0.05, pieces - 1)]))
        fmu = make_model(FORWARD).start(parameters)
        for h in np.diff(times):
            step(fmu, h, 0.06)
        assert fmu.get("theta") == pytest.approx(-0.05 + 0.5 * 60.0 * 0.05**2, rel=1e-9)
        assert fmu.get("omega") == pytest.approx(60.0 * 0.05, rel=1e-9)
        assert fmu.get("energy.heat_cam1") <= 1e-12


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("order", [2, 3])
def test_a_motion_that_begins_slowly_against_a_damper_alone_finds_its_flanks(make_model, way, order):
    """No force acts at first, and the torque begins like t^2 or t^3: neither a load nor its rates tell the
    flanks. J alpha = tau - rho c z' omega, on the flanks that the damper presses."""
    J, c, r, mu, lead, end = 0.01, 100.0, 0.02, 0.3, 1.0, 0.1
    parameters = (
        LEVEL | {f"cam{i}.friction": mu for i in (1, 2)} | {f"cam{i}.lead_angle": lead for i in (1, 2)}
    )
    parameters |= {"damper.c_load": c, "damper.c_release": c, "initial.theta": 0.5, "stop.upper": 1.0}
    fmu = make_model(FORWARD).start(parameters)
    assert (fmu.get("cam1.radius"), fmu.get("cam2.radius")) == (r, r)
    step(fmu, end, 0.0, tuple(way * 10.0 / end**k if k == order else 0.0 for k in (1, 2, 3)))
    a = r * math.tan(lead)
    drag = 0.5 * r * (a + mu * r) / (r - mu * a) * c * 0.5 * a

    def rates(t, x):
        return [x[1], (way * 10.0 * (t / end) ** order / math.factorial(order) - drag * x[1]) / J]

    wanted = solve_ivp(rates, (0.0, end), [0.5, 0.0], "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    assert [fmu.get("theta"), fmu.get("omega")] == pytest.approx(wanted, rel=1e-8)


# ---- stiff steps ----

STIFF = {
    "cam1.profile": 2,
    "cam1.radius": 0.007,
    "cam1.ellipse_a": 0.022,
    "cam1.ellipse_b": 0.012,
    "cam1.lead_angle": 0.05,
    "cam1.ellipse_curvature": 1,
    "cam1.friction": 0.15,
    "cam2.radius": 0.0126,
    "cam2.lead_angle": 0.62,
    "cam2.friction": 0.28,
    "contacts": 1,
    "spring.stiffness": 1460.0,
    "spring.preload": 0.73,
    "spring.stiffness2": -65000.0,
    "spring.stiffness3": 5.3e7,
    "damper.c_load": 5.0,
    "damper.c_release": 26.0,
    "stop.upper": 0.878,
    "initial.theta": 0.8,
}


@pytest.mark.parametrize("inertia", [1e-15, 1e-14, 1e-12])
@pytest.mark.parametrize("h", [0.01, 0.04])
def test_energy_closes_where_the_damper_rules(make_model, inertia, h):
    """The steps are up to 1e9 times as long as inertia over damping. Radau's method integrates the smooth
    motion to far below the tolerance: only equations solved too coarsely leave a residual."""
    parameters = STIFF | {"inertia.shaft": inertia, "initial.theta": 0.0, "shaft.damping": 1e-3}
    fmu = make_model(FORWARD).start(parameters, tolerance=1e-9)
    for tau in np.linspace(0.05, 0.2, 8):
        step(fmu, h, tau, (1.0, 0.0, 0.0))
        assert abs(fmu.get("energy.residual")) <= 2e-11 * fmu.get("energy.work_in")


class Coasting:
    """The stiff mechanism without torque and follower mass, on the flanks below the pin while it releases:
    J alpha = -rho (F_s + c v). All loads vanish where alpha does."""

    J = 1e-11

    def __init__(self):
        p = STIFF
        self.r, self.mu, self.c = (p["cam1.radius"], p["cam2.radius"]), (0.15, 0.28), p["damper.c_release"]
        self.a, self.b, self.a2 = p["cam1.ellipse_a"], p["cam1.ellipse_b"], self.r[1] * math.tan(0.62)
        self.S0 = math.sin(math.atan(self.a / self.b * math.tan(0.05)))

    def sine(self, gamma):
        return self.S0 + self.r[0] * gamma / self.a

    def height(self, gamma):
        return self.b * (math.sqrt(1 - self.S0**2) - math.sqrt(1 - self.sine(gamma) ** 2))

    def place(self, theta):
        """z, z' and rho at the angle."""
        gamma = brentq(lambda g: self.height(g) - self.a2 * (theta - g), 0.0, theta, xtol=1e-15, rtol=1e-15)
        S = self.sine(gamma)
        slopes = self.r[0] * self.b / self.a * S / math.sqrt(1 - S * S), self.a2
        kappa = sum((r - m * a) / (r * (a + m * r)) for r, m, a in zip(self.r, self.mu, slopes, strict=True))
        return self.height(gamma), slopes[0] * slopes[1] / sum(slopes), 1.0 / kappa

    def balanced(self, theta):
        """The speed at which damper and spring balance, and the time scale of the way there, J/(rho c z')."""
        z, lift, rho = self.place(theta)
        spring = 0.73 + z * (1460.0 + z * (-65000.0 + z * 5.3e7))
        return -spring / (self.c * lift), self.J / (rho * self.c * lift)

    def unloaded(self):
        """The angle at which the loads vanish. J omega omega' = -rho c z' (omega - w) gives omega = w -
        e w w' up to e^2, with the balanced speed w and the time scale e; loads and omega' vanish together."""
        domain = [0.45, 0.75]
        w, e = (
            Chebyshev.interpolate(lambda x, k=k: [self.balanced(y)[k] for y in x], 40, domain) for k in (0, 1)
        )
        change = (w - e * w * w.deriv()).deriv()
        return brentq(change, *domain, xtol=1e-14)


def coasting(make_model, times):
    """A run to each of these times, in one step between two of them."""
    omega = Coasting().balanced(STIFF["initial.theta"])[0]
    start = {"inertia.shaft": Coasting.J, "initial.omega": omega, "tau": 0.0, "cam1.friction_viscous": 1e-9}
    fmu = make_model(FORWARD).start(STIFF | start, tolerance=1e-11)
    for h in np.diff([0.0, *times]):
        step(fmu, h)
    return fmu


@pytest.fixture(scope="module")
def instant(libraries):
    """s, at which the loads vanish, for steps from the start."""

    def load(t):
        fmu = coasting(lambda model: Driver(libraries[model.identifier], model=model), [t])
        value = fmu.get("cam1.reaction")
        fmu.free()
        return value

    return brentq(load, 0.0042, 0.00434, xtol=1e-13)


def test_a_stiff_step_finds_the_angle_at_which_the_loads_vanish(make_model, instant):
    """An error of the speed by 1e-11 shifts the zero of alpha by 1e-9 rad. Steps 1000 time constants long
    must not err by much more."""
    assert coasting(make_model, [instant]).get("theta") == pytest.approx(Coasting().unloaded(), abs=1e-8)


@pytest.mark.parametrize("before", [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, -1e-10])
def test_a_step_that_ends_before_the_loads_vanish_does_not_jam(make_model, instant, before):
    """The mechanism moves on from there as without the cut."""
    after = instant + 2e-5
    fmu, whole = coasting(make_model, [instant - before, after]), coasting(make_model, [after])
    assert fmu.get("mode") == RELEASING
    assert fmu.get("omega") == pytest.approx(whole.get("omega"), rel=1e-6)
