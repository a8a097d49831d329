"""Friction that depends on the load: a reaction that falls to zero because the other contact begins to lock.

Contact 2 has no dry friction, mu_2 = branch v: at the speed where n_2 = a_2 - mu_2 r_2 = 0 it passes on no
torque, and the reaction of contact 1 changes its sign. The balance knows this reaction to a rounding of the
load of contact 2, which is far larger.
"""

import math

import pytest
from driver import FORWARD
from reference import RELEASING
from scipy.integrate import solve_ivp
from test_friction_jams import OK, run

RADIUS, SLOPE = 1.0, (math.tan(0.5), math.tan(1e-4))  # m; m/rad
BRANCH, DRY = 0.01, 0.1  # s/m; mu_1 under any load
INERTIA, DAMPING, LOAD = 1.0, 1.0, -1.0  # kg.m2, N.m.s/rad, N
TORQUE, SPEED, END = -1.0, 1.0, 1.0  # N.m and N.m/s, rad/s, s
FLAT_LAW = "v_m_s,R_N,mu\n" + "".join(f"{v},{R},{DRY}\n" for R in (1.0, 2.0) for v in (0.0, 1.0, 2.0))


@pytest.fixture(scope="module")
def parameters(tmp_path_factory):
    law = tmp_path_factory.mktemp("law") / "flat.csv"
    law.write_text(FLAT_LAW)
    leads = {f"cam{i}.lead_angle": math.atan(slope / RADIUS) for i, slope in enumerate(SLOPE, 1)}
    return leads | {
        "cam1.radius": RADIUS,
        "cam2.radius": RADIUS,
        "cam1.friction_table": str(law),
        "cam2.friction": 0.0,
        "cam2.friction_viscous": BRANCH,
        "spring.preload": 0.0,
        "spring.stiffness": 0.0,
        "inertia.shaft": INERTIA,
        "inertia.follower": 0.0,
        "inertia.follower_mass": 0.0,
        "shaft.damping": DAMPING,
        "stop.lower": -1.0,
        "stop.upper": 1.0,
        "initial.omega": SPEED,
    }


def acceleration(t, omega):
    """(tau - b omega - T)/J with T = F r_1 r_2 n_1 n_2/(r_2 d_1 n_2 + r_1 d_2 n_1): section 3 of
    docs/mechanism.md. F < 0 presses contact 2 on its upper flank; T has the sign of x_1."""
    way = math.copysign(1.0, omega)
    turn = SLOPE[0] / (SLOPE[0] + SLOPE[1])  # phi'
    f_2 = -way * BRANCH * abs(omega) * turn * math.hypot(RADIUS, SLOPE[1])
    n_2, d_2 = SLOPE[1] + f_2 * RADIUS, RADIUS - f_2 * SLOPE[1]
    f_1 = way * DRY * math.copysign(1.0, LOAD * n_2)
    n_1, d_1 = SLOPE[0] + f_1 * RADIUS, RADIUS - f_1 * SLOPE[0]
    torque = LOAD * RADIUS * n_1 * n_2 / (d_1 * n_2 + d_2 * n_1)
    return (TORQUE * (1.0 + t) - DAMPING * omega - torque) / INERTIA


def motion():
    """theta and omega at the end: with the speed positive, then negative."""

    def rates(t, y):
        return [y[1], acceleration(t, y[1])]

    def turns(t, y):
        return y[1]

    turns.terminal = True
    there = solve_ivp(rates, (0.0, END), [0.0, SPEED], "DOP853", rtol=1e-13, atol=1e-15, events=turns)
    theta, turned = there.y[0, -1], there.t[-1]
    back = solve_ivp(rates, (turned, END), [theta, -1e-300], "DOP853", rtol=1e-13, atol=1e-15)
    return back.y[:, -1]


@pytest.mark.parametrize("pieces", [1, 2, 3, 4, 6, 8, 16, 32])
def test_a_reaction_below_the_rounding_of_the_load_jams_no_contact(make_model, parameters, pieces):
    fmu = make_model(FORWARD).start(parameters)
    assert run(fmu, END, pieces, (TORQUE, TORQUE), (LOAD, 0.0)) == OK
    theta, omega = motion()
    assert fmu.get("mode") == RELEASING
    assert fmu.get("theta") == pytest.approx(theta, rel=1e-9)
    assert fmu.get("omega") == pytest.approx(omega, rel=1e-9)
