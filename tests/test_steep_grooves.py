"""Grooves so steep that the follower travels 1e6 m between the stops: at z = 0 a small load decides,
although the spring's force is large far away.

The rounding of F_s is dF_s/dz times the rounding of z. Oracles: a closed form, and the balances solved by
SciPy (docs/mechanism.md, sections 6 and 9).
"""

import math

import numpy as np
import pytest
from driver import FORWARD
from reference import LOADING, RELEASING, write_table
from scipy.integrate import solve_ivp

LEAD = math.pi / 2 - 1e-6  # of both cams; r = 1 m
SLOPE = math.tan(LEAD)
LIFT, TURN = SLOPE / 2, 0.5  # z', gamma' = phi'
J = M = TURNING = STIFFNESS = 1.0  # TURNING: kg.m2, I of the follower
STIFFNESS2 = -100.0
SLIDING = TURN * math.hypot(1.0, SLOPE)  # m/rad, of both contacts
NEAR = 1e-8
STEEP = {
    **{f"cam{i}.radius": 1.0 for i in (1, 2)},
    **{f"cam{i}.lead_angle": LEAD for i in (1, 2)},
    **{f"cam{i}.friction": 0.0 for i in (1, 2)},
    "cam2.profile": 3,
    "spring.stiffness": STIFFNESS,
    "spring.stiffness2": STIFFNESS2,
    "inertia.shaft": J,
    "inertia.follower_mass": M,
    "inertia.follower": TURNING,
    "stop.lower": -1.0,
    "stop.upper": 1.0,
}


@pytest.fixture
def steep(make_model, tmp_path):
    """A start with these parameters; a helix and a table whose samples lie on a straight line."""
    path, samples = tmp_path / "groove.csv", np.linspace(-1.01, 1.01, 4)
    write_table(path, samples, SLOPE * samples)
    return lambda parameters: make_model(FORWARD).start(STEEP | {"cam2.table": str(path)} | parameters)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_torque_beyond_the_edge_moves_the_mechanism(steep, share):
    """Without friction: theta'' = (tau - z' (preload + k z' theta))/(J + I gamma'^2 + m z'^2)."""
    preload, h = 0.1, 1e-3
    beyond, inertia = (share - 1.0) * LIFT * preload, J + TURNING * TURN**2 + M * LIFT**2
    rate = LIFT * math.sqrt(STIFFNESS / inertia)
    fmu = steep({"spring.preload": preload})
    fmu.set({"tau": share * LIFT * preload})
    fmu.step(h)
    assert fmu.get("mode") == (LOADING if share > 1.0 else RELEASING)
    way = beyond / inertia * 2.0 * (math.sin(rate * h / 2) / rate) ** 2
    assert fmu.get("theta") == pytest.approx(way, rel=NEAR)
    assert fmu.get("omega") == pytest.approx(beyond / inertia * math.sin(rate * h) / rate, rel=NEAR)


@pytest.mark.parametrize("h", [1e-8, 1e-7, 6e-7])
def test_the_motion_begins_on_the_flanks_that_its_loads_press(steep, h):
    """mu = mu_v v with mu_v = 1 s/m. The inertia of the follower presses both flanks, against the pull of the
    spring: each heat grows."""
    damper, preload, tau = 1.0, -1.0, LIFT

    def rate(_, x):
        theta, omega, _ = x
        mu, z, v = SLIDING * omega, LIFT * theta, LIFT * omega
        force = preload + STIFFNESS * z + STIFFNESS2 * z**2 + damper * v * (1.0 + v)
        n, d = SLOPE + mu, 1.0 - mu * SLOPE
        # of cam 2, of the follower's turn, along z
        balances = [
            [J, 0.0, n],
            [TURNING * TURN, n, -n],
            [M * LIFT, -d, -d],
        ]
        alpha, x_1, _ = np.linalg.solve(balances, [tau - omega, 0.0, -force])
        return omega, alpha, mu * x_1 * math.hypot(1.0, SLOPE) * SLIDING * omega

    way = solve_ivp(rate, (0.0, h), [0.0, 0.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-60)
    law = {f"cam{i}.friction_viscous": 1.0 for i in (1, 2)}
    dampers = {f"damper.{name}": damper for name in ("c_load", "c_release", "q_load", "q_release")}
    fmu = steep(law | dampers | {"spring.preload": preload, "shaft.damping": 1.0})
    fmu.set({"tau": tau})
    fmu.step(h)
    theta, omega, heat = way.y[:, -1]
    assert fmu.get("theta") == pytest.approx(theta, rel=NEAR)
    assert fmu.get("omega") == pytest.approx(omega, rel=NEAR)
    for i in (1, 2):
        assert fmu.get(f"energy.heat_cam{i}") == pytest.approx(heat, rel=NEAR)
