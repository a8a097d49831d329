"""Section 5 of docs/mechanism.md: spring, dampers and end stops."""

import math

import numpy as np
import pytest
from pin_equations import Pin, band, ellipse, friction, helix, spring_force
from random_mechanisms import random_mechanism
from reference import LOADING, LOWER_STOP, RELEASING, STICK, UPPER_STOP
from scipy.integrate import quad


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
