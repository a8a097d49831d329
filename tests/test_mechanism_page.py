"""docs/mechanism.md: its equations, its numbers and its pictures. Links: tests/test_pages.py.

The equations are written here as the page writes them. tests/general_mechanism compares those of motion."""

import math
import re
import subprocess
import sys

import numpy as np
import pytest
from driver import ROOT
from scipy.optimize import minimize
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


# ---- section 2 ----


def ellipse_law(radius, lead, A, B, chi, psi):
    S_0 = math.sin(math.atan(A / B * math.tan(lead)))
    S = S_0 + chi * radius * psi / A
    return chi * B * (math.sqrt(1 - S_0**2) - math.sqrt(1 - S**2)), B / A * S / math.sqrt(1 - S**2)


# radius, lead angle, A, B, chi of the grooves of this module, and the FMU's parameters for them
ELLIPSES = ((0.02, 0.7, 0.06, 0.05, -1), (0.026, 0.5, 0.09, 0.07, 1))


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
