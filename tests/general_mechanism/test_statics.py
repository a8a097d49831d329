"""Section 3 of docs/mechanism.md, statics, with any grooves: stick band, locking and wedging contacts."""

import math

import numpy as np
import pytest
from pin_equations import HEATS, KINDS, PAIRS, Pin, band, edge, ellipse, friction, helix, spring_force
from random_mechanisms import random_mechanism, reactions, turned_over
from reference import LOADING, LOWER_STOP, RELEASING, STICK, WEDGED


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
