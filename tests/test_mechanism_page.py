"""docs/mechanism.md: its equations, its numbers and its pictures. Links: tests/test_pages.py.

The equations are written here as the page writes them. They are compared with forces and moments as vectors,
with differences, with SciPy's integrator, and with the FMUs."""

import math
import re
import subprocess
import sys

import numpy as np
import pytest
from driver import ROOT
from scipy.optimize import brentq, minimize
from svg_files import assert_same_picture

from dualcam import Fmu
from dualcam.design import Ellipse, Helix, Mechanism, Spring, band_factors, efficiency, optimum

DOCS = ROOT / "docs"
PAGE = (DOCS / "mechanism.md").read_text(encoding="utf-8")
NUMBER = re.compile(r"-?\d+\.\d+")


def numbers_after(words):
    """The decimal numbers in the sentence that begins with these words."""
    sentence = re.search(re.escape(words) + r"(.*?)(?:\.\s|$)", PAGE, re.DOTALL)[1]
    return [float(found) for found in NUMBER.findall(sentence)]


# ---- sections ----


# ---- section 2 ----


def ellipse_law(radius, lead, A, B, chi, psi):
    S_0 = math.sin(math.atan(A / B * math.tan(lead)))
    S = S_0 + chi * radius * psi / A
    return chi * B * (math.sqrt(1 - S_0**2) - math.sqrt(1 - S**2)), B / A * S / math.sqrt(1 - S**2)


# radius, lead angle, A, B, chi of the grooves of this module, and the FMU's parameters for them
ELLIPSES = ((0.02, 0.7, 0.06, 0.05, -1), (0.026, 0.5, 0.09, 0.07, 1))
NAMES = ("radius", "lead_angle", "ellipse_a", "ellipse_b", "ellipse_curvature")


def place(theta):
    """gamma, phi, z and the slopes a_i at theta."""
    gamma = brentq(
        lambda g: ellipse_law(*ELLIPSES[0], g)[0] - ellipse_law(*ELLIPSES[1], theta - g)[0],
        0,
        theta,
        xtol=1e-16,
    )
    (z, s1), (_, s2) = (ellipse_law(*E, psi) for E, psi in zip(ELLIPSES, (gamma, theta - gamma), strict=True))
    return np.array([gamma, theta - gamma, z, ELLIPSES[0][0] * s1, ELLIPSES[1][0] * s2])


def kinematics(theta):
    """a_i, gamma', phi', z', gamma'', z'' and z by the page; a_i' by differences."""
    here, step = place(theta), 1e-5
    rate = (place(theta + step) - place(theta - step)) / (2 * step)
    a, a_rate = here[3:], rate[3:]
    total = a[0] + a[1]
    turn = np.array([a[1], a[0]]) / total
    turn_rate = (a_rate[1] * turn[1] - a_rate[0] * turn[0]) / total
    return (
        a,
        turn,
        a[0] * a[1] / total,
        turn_rate,
        a_rate[0] * turn[0] ** 2 + a_rate[1] * turn[1] ** 2,
        here[2],
    )


@pytest.mark.parametrize("parameters", ELLIPSES)
def test_ellipse(parameters):
    groove = Ellipse(*parameters)
    psi = np.linspace(-0.2, 0.6, 9)
    z, slope = np.array([ellipse_law(*parameters, p) for p in psi]).T
    step = 1e-6
    ahead, behind = (np.array([ellipse_law(*parameters, p + s)[0] for p in psi]) for s in (step, -step))
    assert groove.at(psi).z == pytest.approx(z, rel=1e-12, abs=1e-16)
    assert (ahead - behind) / (2 * step * parameters[0]) == pytest.approx(slope, rel=1e-8)
    assert ellipse_law(*parameters, 0.0)[1] == pytest.approx(math.tan(parameters[1]), rel=1e-14)


# ---- section 3 ----


def random_contacts(count):
    rng = np.random.default_rng(15)
    for _ in range(count):
        yield (
            rng.uniform(0.2, 1.2, 2),
            rng.uniform(0.01, 0.04, 2),
            rng.uniform(0.0, 0.15, 2),
            int(rng.choice([-1, 1])),
            rng.choice([-1, 1], 2),
            rng.uniform(-300.0, 300.0),
            rng.uniform(-1.0, 1.0),
        )


def forms(a, radius, f):
    """n_i, d_i and Delta."""
    n, d = a + f * radius, radius - f * a
    return n, d, radius[1] * d[0] * n[1] + radius[0] * d[1] * n[0]


def test_band_examples():
    """The table of section 3, and that it has every case."""
    rows = re.findall(
        r"^\| ([a-z 1]+) \| ([\d., ]+) \| ([\d., ]+) \| ([\d., ]+) \| (\d+) \| (\S+) \| (\S+) \|$", PAGE, re.M
    )
    assert [row[0] for row in rows] == ["neither locked", "both locked", "contact 1 locked", "wedged", "jam"]
    for _, *pairs, force, release, load in rows:
        radius, lead, friction = (np.array([float(v) for v in pair.split(",")]) for pair in pairs)
        edges = [
            float(force) * float(edge)
            for edge in band_factors(1e-3 * radius * np.tan(lead), friction, 1e-3 * radius)
        ]
        assert [float(release), float(load)] == pytest.approx(edges, abs=5e-7)


def default_mechanism():
    groove = Helix(0.02, math.pi / 4)
    return Mechanism((groove, groove), (0.14, 0.14), Spring(50.0, 50e3), 1.3963)


def test_loop_of_the_picture():
    """Its area is the friction heat of the FMU's slow run through it."""
    (area,) = numbers_after("The area of the loop")
    angles = np.linspace(0.35, 1.05, 201)
    release, load = default_mechanism().band(angles)
    assert np.trapezoid(load - release, angles) == pytest.approx(area, abs=5e-4)
    edges = [float(load[0]), float(load[-1]), float(release[-1]), float(release[0]), float(load[0])]
    with Fmu(ROOT / "build" / "DualCamForward.fmu") as fmu:
        fmu.start({"inertia.shaft": 0.0, "initial.theta": 0.35, "tau": edges[0]})
        for torque in edges:
            fmu.set("tau", torque)
            fmu.step(1e-3)
        assert fmu.real("theta") == pytest.approx(0.35, abs=1e-9)
        assert fmu.real("energy.heat_cam1") + fmu.real("energy.heat_cam2") == pytest.approx(area, abs=5e-4)


# ---- sections 4 to 7 ----


INERTIA = {
    "inertia.shaft": 0.003,
    "inertia.follower_mass": 0.4,
    "inertia.follower": 4e-4,
    "shaft.damping": 0.02,
}
FORCES = {
    "spring.stiffness2": 2e5,
    "spring.stiffness3": 3e6,
    "damper.c_load": 20.0,
    "damper.q_load": 60.0,
    "damper.c_release": 35.0,
    "damper.q_release": 45.0,
}


@pytest.mark.parametrize("sigma", [1, -1])
def test_equation_of_motion_and_power(sigma):
    """Against both FMUs, in two elliptical grooves with every force. The same numbers balance the power."""
    theta, omega, tau, F_ext = 0.8, sigma * 3.0, 9.0, 30.0
    grooves = {
        f"cam{i}.{name}": v for i, E in enumerate(ELLIPSES, 1) for name, v in zip(NAMES, E, strict=True)
    }
    common = {
        "cam1.profile": 2,
        "cam2.profile": 2,
        "cam2.friction": 0.1,
        **grooves,
        **INERTIA,
        **FORCES,
        "F_ext": F_ext,
    }
    a, turn, dz, turn_rate, dz_rate, z = kinematics(theta)
    r, mu = np.array([E[0] for E in ELLIPSES]), np.array([0.14, 0.1])
    J, m, inertia, b = INERTIA.values()
    v = dz * omega
    F_s = 50 + z * (50e3 + z * (2e5 + z * 3e6))
    D = v * (20 + 60 * v) if v > 0 else v * (35 + 45 * abs(v))
    n, d, _ = forms(a, r, sigma * mu)
    kappa = d / (r * n)
    rho = 1 / (kappa[0] + kappa[1])
    felt = J + rho * m * dz + rho * kappa[0] * inertia * turn[0]
    by_speed = (rho * m * dz_rate + rho * kappa[0] * inertia * turn_rate) * omega**2
    alpha = (tau - b * omega - rho * (F_s + F_ext + D) - by_speed) / felt
    with Fmu(ROOT / "build" / "DualCamForward.fmu") as fmu:
        fmu.start({**common, "initial.theta": theta, "initial.omega": omega, "tau": tau})
        assert fmu.real("alpha") == pytest.approx(alpha, rel=1e-8)
        reported = [fmu.real("cam1.reaction"), fmu.real("cam2.reaction")]
    with Fmu(ROOT / "build" / "DualCamInverse.fmu") as fmu:
        fmu.start({**common, "theta": theta, "omega": omega, "alpha": alpha})
        assert fmu.real("tau") == pytest.approx(tau, rel=1e-8)
    T = tau - b * omega - J * alpha
    twist = inertia * (turn[0] * alpha + turn_rate * omega**2)
    R = np.array([T - twist, T]) * np.hypot(r, a) / (r * n)
    assert (R > 0).all()
    assert reported == pytest.approx(R / 2, rel=1e-8)
    friction = np.sum(mu * R * np.abs(turn * omega) * np.hypot(r, a))
    kinetic = J * omega * alpha + m * v * (dz * alpha + dz_rate * omega**2) + turn[0] * omega * twist
    assert tau * omega == pytest.approx(kinetic + (F_s + F_ext + D) * v + friction + b * omega**2, rel=1e-9)


# ---- section 8 ----


def test_best_efficiency_of_equal_friction():
    found = re.findall(r"(0\.\d+) for mu = (0\.\d+)", PAGE)
    assert [mu for _, mu in found] == ["0.14", "0.19"]
    for eta, mu in found:
        best = optimum((float(mu), float(mu)), (0.02, 0.03))
        assert float(eta) == pytest.approx(best.efficiency, abs=5e-11)
        assert best.efficiency == pytest.approx(((1 - float(mu)) / (1 + float(mu))) ** 2, rel=1e-14)
        assert best.lead_angle == pytest.approx((math.pi / 4, math.pi / 4), rel=1e-14)


def test_efficiency_is_the_weighted_mean():
    for lead, r, mu, *_ in random_contacts(100):
        angle = math.atan(mu[0])
        weight = 1 / np.tan(lead - angle) / r
        term = (np.sin(2 * lead) - math.sin(2 * angle)) / (np.sin(2 * lead) + math.sin(2 * angle))
        mean = np.sum(weight * term) / np.sum(weight)
        assert efficiency(lead, (mu[0], mu[0]), r) == pytest.approx(mean, rel=1e-11)


def test_best_efficiency_of_unequal_friction():
    """The example, and that a search finds nothing better."""
    r1, r2, mu_1, mu_2 = 0.03, 0.02, 0.1, 0.2
    mean, *angles, eta = numbers_after("Example: r1 = 30 mm, r2 = 20 mm, mu_1 = 0.1, mu_2 = 0.2 give")
    mu_e = math.sqrt((mu_1 / r1 + mu_2 / r2) / (1 / (mu_1 * r1) + 1 / (mu_2 * r2)))
    assert mean == pytest.approx(mu_e, abs=5e-11)
    assert angles == pytest.approx([math.atan(mu_1 / mu_e), math.atan(mu_2 / mu_e)], abs=5e-11)
    assert eta == pytest.approx(((1 - mu_e) / (1 + mu_e)) ** 2, abs=5e-11)
    best = optimum((mu_1, mu_2), (r1, r2))
    assert [*best.lead_angle, best.efficiency] == pytest.approx([*angles, eta], abs=5e-11)
    search = minimize(
        lambda lead: -float(efficiency(lead, (mu_1, mu_2), (r1, r2))),
        [0.7, 0.8],
        method="Nelder-Mead",
        options={"xatol": 1e-8, "fatol": 1e-15},
    )
    assert -search.fun == pytest.approx(eta, abs=1e-10)
    assert search.x == pytest.approx(angles, abs=1e-6)


# ---- pictures ----

PICTURES = ("mechanism.svg", "mechanism_forces.svg", "mechanism_band.svg")


def test_script_draws_the_pictures(tmp_path):
    """The committed ones, if matplotlib is the version that drew them."""
    script = DOCS / "figures" / "mechanism.py"
    subprocess.run(
        [sys.executable, script, "--output", tmp_path], check=True, timeout=120, capture_output=True
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(PICTURES)
    for name in PICTURES:
        assert f"]({name})" in PAGE
        assert_same_picture(tmp_path / name, DOCS / name)
