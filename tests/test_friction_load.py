"""Friction that depends on the reaction (docs/mechanism.md, section 9): the edges of the stick band and the torque of an
imposed motion against SciPy, derivatives, locks, refusals. The motion is in test_friction_scenes.py."""

import math

import numpy as np
import pytest
from driver import models
from reference import Refused
from reference.friction import FrictionLaw, LoadedContact, reactions_under, torque_of_symmetric_edge
from reference.parameters import DEFAULTS

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]


def drawn(rng: np.random.Generator) -> dict:
    p: dict = {"contacts": int(rng.integers(1, 3)), "spring.stiffness2": 1e5}
    for i in (1, 2):
        p |= {
            f"cam{i}.radius": rng.uniform(0.01, 0.03),
            f"cam{i}.lead_angle": rng.uniform(0.5, 0.9),
            f"cam{i}.friction": rng.uniform(0.02, 0.2),
            f"cam{i}.friction_peak": rng.uniform(1.0, 1.5),
            f"cam{i}.stribeck_velocity": 10 ** rng.uniform(-3, -1),
            f"cam{i}.stribeck_exponent": int(rng.integers(1, 3)),
            f"cam{i}.friction_viscous": rng.uniform(0.0, 0.3),
            f"cam{i}.friction_load_exponent": rng.uniform(-0.5, 0.5),
            f"cam{i}.friction_load": 10 ** rng.uniform(1.5, 2.5),
        }
    p |= {"inertia.follower_mass": rng.uniform(0, 2), "inertia.follower": rng.uniform(0, 2e-4)}
    return p | {"shaft.damping": rng.uniform(0, 0.01), "damper.c_load": rng.uniform(0, 50)}


def contacts_of(p: dict, theta_rate: float, sigma: int):
    """Both contacts on the supporting flanks, z' and the sliding distances per angle."""
    full = DEFAULTS | p
    r, s = [full[f"cam{i}.radius"] for i in (1, 2)], [math.tan(full[f"cam{i}.lead_angle"]) for i in (1, 2)]
    a = [r[0] * s[0], r[1] * s[1]]
    turn = [a[1] / sum(a), a[0] / sum(a)]
    sliding = [t * q * math.hypot(1.0, x) for t, q, x in zip(turn, r, s, strict=True)]
    laws = [FrictionLaw.of_cam(full, i) for i in (1, 2)]
    pair = tuple(
        LoadedContact(r[i], s[i], laws[i], abs(theta_rate) * sliding[i], full["contacts"], sigma)
        for i in range(2)
    )
    return pair, a[0] * turn[0], turn, sliding


def required(p: dict, theta: float, omega: float, alpha: float, force: float):
    """Torque, reactions per contact and coefficients on the supporting flanks; None where another answer is due."""
    sigma = 1 if omega > 0 else -1
    pair, dz, turn, sliding = contacts_of(p, omega, sigma)
    z, v = dz * theta, dz * omega
    axial = 50 + 50000 * z + p["spring.stiffness2"] * z**2 + force
    axial += v * (p["damper.c_load"] if omega > 0 else 0.0) + p["inertia.follower_mass"] * dz * alpha
    moment = p["inertia.follower"] * turn[0] * alpha
    try:
        found = reactions_under(pair, axial, moment)
    except Refused:
        return None
    if not all(c.grows(x) for c, x in zip(pair, found, strict=True)):
        return None
    torque = pair[1].torque(found[1]) + p["shaft.damping"] * omega + 0.002 * alpha
    mu = [c.law.at(c.speed, x) for c, x in zip(pair, found, strict=True)]
    return torque, found, mu, [abs(omega) * x for x in sliding]


def test_torque_of_an_imposed_motion(make_model):
    rng, seen = np.random.default_rng(9), 0
    for _ in range(200):
        p = drawn(rng)
        at = {
            "theta": rng.uniform(0.1, 1.2),
            "omega": rng.choice([-1, 1]) * 10 ** rng.uniform(-2, 1),
            "alpha": rng.uniform(-50, 50),
            "F_ext": rng.uniform(-10, 50),
        }
        wanted = required(p, *at.values())
        if wanted is None:
            continue
        seen += 1
        torque, reactions, mu, speeds = wanted
        fmu = make_model(INVERSE).start(p | at)
        assert fmu.get("tau") == pytest.approx(torque, rel=1e-9, abs=1e-12)
        for i in (1, 2):
            assert fmu.get(f"cam{i}.reaction") == pytest.approx(reactions[i - 1], rel=1e-9)
            assert fmu.get(f"cam{i}.friction_coefficient") == pytest.approx(mu[i - 1], rel=1e-9)
            power = mu[i - 1] * reactions[i - 1] * p["contacts"] * speeds[i - 1]
            assert fmu.get(f"cam{i}.friction_power") == pytest.approx(power, rel=1e-9)
    assert seen > 150


@pytest.mark.parametrize("model", [FORWARD, INVERSE])
def test_edges_of_the_stick_band(make_model, model):
    """Both edges take mu(0+, R) with the reactions on the edge, for each its own."""
    rng, seen = np.random.default_rng(11), 0
    for _ in range(60):
        p = drawn(rng) | {"initial.theta" if model is FORWARD else "theta": 0.7}
        fmu = make_model(model).start(p)
        _, dz, _, _ = contacts_of(p, 0.0, 1)
        z = 0.7 * dz
        F_0 = 50 + 50000 * z + 1e5 * z**2
        assert fmu.get("spring.force") == pytest.approx(F_0, rel=1e-12)
        for name, sigma in (("torque_load", 1), ("torque_release", -1)):
            pair, _, _, _ = contacts_of(p, 0.0, sigma)
            found = reactions_under(pair, F_0, 0.0)
            if not all(c.grows(x) for c, x in zip(pair, found, strict=True)):
                continue
            seen += 1
            assert fmu.get(name) == pytest.approx(pair[1].torque(found[1]), rel=1e-11)
        assert fmu.get("efficiency") == pytest.approx(
            fmu.get("torque_release") / fmu.get("torque_load"), rel=1e-12
        )
    assert seen > 100


def test_edges_of_equal_cams_follow_from_one_equation(make_model):
    """Two equal contacts carry half of F_0 each, so that bisection in one unknown gives the edge."""
    for nu in (-0.5, -0.3, 0.3, 0.5):
        p = {f"cam{i}.friction_load_exponent": nu for i in (1, 2)} | {"contacts": 1, "initial.theta": 0.5}
        fmu = make_model(FORWARD).start(p)
        F_0 = fmu.get("spring.force")
        for name, sigma in (("torque_load", 1), ("torque_release", -1)):
            contact = contacts_of(p, 0.0, sigma)[0][0]
            bracket = (F_0 / 4, F_0 * 4)
            assert fmu.get(name) == pytest.approx(torque_of_symmetric_edge(contact, F_0, bracket), rel=1e-12)


def test_band_is_not_in_proportion_to_the_load(make_model):
    p = {f"cam{i}.friction_load_exponent": 0.4 for i in (1, 2)} | {"initial.theta": 0.2}
    ratios = []
    for force in (0.0, 400.0):
        fmu = make_model(FORWARD).start(p | {"F_ext": force})
        ratios.append(fmu.get("torque_load") / (fmu.get("spring.force") + force))
    assert ratios[1] > 1.01 * ratios[0]
