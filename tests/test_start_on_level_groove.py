"""Motions that begin without load where the groove of cam 2 is level.

At rest there nothing but the torque sets the motion, and the time scale of the motion is infinite. The
flanks follow from the loads a little later, when the pin must still be in the groove. Oracles: the equation
of motion of section 6 of docs/mechanism.md, by DOP853; a closed form on a dwell.
"""

import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from driver import OK, models
from reference import DOUBLE, RELEASING, WEDGED, Mechanism, Slip, write_table
from reference.grooves import Ellipse
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

FORWARD = models["DualCamForward"]
RADIUS, LEAD, AXIS, FRICTION = (0.01, 0.004), (0.3, 0.0), 0.02, (0.5, 0.0)
STIFFNESS, TORQUE, DURATION = 1500.0, 0.04, 1e-4  # N/m, N.m, s
CURVATURE = (-1, 1)
# kg.m2 and kg: the contacts were wedged; the pin bore on the wrong flanks
INERTIAS = [(1e-8, 0.6), (1e-9, 0.6), (1e-9, 0.0)]


def parameters(inertia, mass):
    p = dict.fromkeys(("shaft.damping", "damper.c_load", "damper.c_release"), 0.0)
    p |= {"tau": TORQUE, "stop.upper": 1.0, "inertia.shaft": inertia, "inertia.follower_mass": mass}
    p |= {"spring.stiffness": STIFFNESS, "spring.preload": 0.0}
    for i, j in (("cam1", 0), ("cam2", 1)):
        p |= {f"{i}.profile": 2, f"{i}.ellipse_a": AXIS, f"{i}.ellipse_b": AXIS, f"{i}.radius": RADIUS[j]}
        p |= {
            f"{i}.lead_angle": LEAD[j],
            f"{i}.ellipse_curvature": CURVATURE[j],
            f"{i}.friction": FRICTION[j],
        }
    return p


@cache
def at_end(inertia, mass):
    """Angle and speed, on the flanks that support the load."""
    grooves = [Ellipse(RADIUS[i], LEAD[i], AXIS, AXIS, CURVATURE[i]) for i in (0, 1)]

    def height_gap(gamma, theta):
        return grooves[0].derivatives(gamma, 0)[0] - grooves[1].derivatives(theta - gamma, 0)[0]

    def rates(_, y):
        theta, omega = y
        gamma = brentq(height_gap, 0.0, theta, (theta,), xtol=1e-18, rtol=1e-15)
        z, a1, b1 = grooves[0].derivatives(gamma, 0)
        _, a2, b2 = grooves[1].derivatives(theta - gamma, 0)
        lift, curve = a1 * a2 / (a1 + a2), (b1 * a2**3 + b2 * a1**3) / (a1 + a2) ** 3  # z', z''
        rn = [r * (a + mu * r) for r, a, mu in zip(RADIUS, (a1, a2), FRICTION, strict=True)]
        d = [r - mu * a for r, a, mu in zip(RADIUS, (a1, a2), FRICTION, strict=True)]
        rho = rn[0] * rn[1] / (d[0] * rn[1] + d[1] * rn[0])
        net = TORQUE - rho * (STIFFNESS * z + mass * curve * omega**2)
        return [omega, net / (inertia + rho * mass * lift)]

    return solve_ivp(rates, (0.0, DURATION), [0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-13, first_step=1e-8).y[
        :, -1
    ]


@pytest.mark.parametrize(("inertia", "mass"), INERTIAS)
@pytest.mark.parametrize("steps", [1, 7])
def test_a_torque_moves_an_unloaded_cam_off_a_level_groove(make_model, inertia, mass, steps):
    fmu = make_model(FORWARD).start(parameters(inertia, mass))
    times = np.linspace(0.0, DURATION, steps + 1).tolist()
    for begin, end in pairwise(times):
        assert fmu.call("fmi2DoStep", begin, end - begin, 1) == OK, fmu.messages[-1].text
    assert [fmu.get("theta"), fmu.get("omega")] == pytest.approx(at_end(inertia, mass), rel=1e-8)


# The table begins level. Friction grows with the speed: its rate has the sign of the other flank of contact
# 1, and the load of contact 1 is rounding until theta has grown a hundredfold. The follower has 1e8 times the
# inertia of the shaft: the acceleration changes within 1e-10 s. The contacts were wedged.
NEARLY_LEVEL, TABLE = 1e-17, ((0.0, 0.007, 0.014, 0.065), (0.0, 3.7e-8, 2.7e-7, 1.5e-5))
LIGHT_SHAFT = {
    "cam1.profile": 2,
    "cam1.radius": 0.01,
    "cam1.lead_angle": 7.3e-5,
    "cam1.ellipse_a": 0.0057,
    "cam1.ellipse_b": 3.4e-6,
    "cam1.ellipse_curvature": -1,
    "cam1.friction": 0.0025,
    "cam1.friction_viscous": 0.5,
    "cam1.stribeck_velocity": 2.6e-4,
    "cam2.profile": 3,
    "cam2.radius": 0.2,
    "cam2.friction": 1.0,
    "cam2.friction_viscous": 1.7e-4,
    "cam2.stribeck_velocity": 1.0,
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
    "spring.stiffness2": 34000.0,
    "damper.c_load": 1.1,
    "damper.c_release": 1.0,
    "inertia.shaft": 1.8e-8,
    "inertia.follower": 1.0,
    "inertia.follower_mass": 0.0,
    "stop.upper": 0.064,
}


@pytest.mark.parametrize("steps", [1, 7])
@pytest.mark.parametrize("torque", [0.01, 2.0])
def test_a_light_shaft_moves_off_a_groove_that_is_level_to_rounding(make_model, tmp_path, torque, steps):
    table, duration = tmp_path / "level.csv", 1e-2
    write_table(table, *TABLE)
    start = LIGHT_SHAFT | {"cam2.table": str(table), "initial.theta": NEARLY_LEVEL}
    fmu = make_model(FORWARD).start(start)
    fmu.set({"tau": torque})
    for _ in range(steps):
        fmu.step(duration / steps)
    mechanism, slip = Mechanism(start, DOUBLE), Slip(1, (-1, 1))

    def rates(_, y):
        return [y[1], mechanism.load(mechanism.groove.at(y[0]), slip, y[1], torque, 0.0).alpha]

    end = solve_ivp(rates, (0.0, duration), [1e-14, 0.0], "DOP853", rtol=1e-10, atol=1e-16, first_step=1e-9).y
    assert [fmu.get("theta"), fmu.get("omega")] == pytest.approx(end[:, -1], rel=1e-8)


# Contact 1 of a helix locks as soon as the groove of cam 2 rises: n_1 of section 2 of docs/mechanism.md,
# a_1 - mu_1 R_1, is negative, and no pair of flanks agrees with its own forces. On the dwell before, contact
# 1 bears no load.
DWELL, RISE = 0.5, 0.75  # rad
BEFORE_A_RISE = {
    **{f"cam{i}.radius": 1.0 for i in (1, 2)},
    "cam1.lead_angle": 0.5,
    "cam1.friction": 1.0,
    "cam2.friction": 0.0,
    "cam2.profile": 3,
    "spring.preload": -1.0,
    "spring.stiffness": 0.0,
    "inertia.shaft": 100.0,
    "inertia.follower_mass": 0.0,
    "inertia.follower": 1.0,
    "shaft.damping": 10.0,
    "initial.omega": 1.0,
    "stop.upper": 1.5,
}


@pytest.mark.parametrize("steps", [1, 7, 100])
def test_contacts_that_jam_at_the_end_of_a_dwell_hold_a_small_torque(make_model, tmp_path, steps):
    """The torque accelerates the shaft so little that the load of contact 1 stays rounding for 0.1 s: the
    shaft went on by 1e-6 rad."""
    table = tmp_path / "dwell.csv"
    write_table(table, [0.0, DWELL / 2, DWELL, RISE, 1.0, 1.6], [0.0, 0.0, 0.0, 0.004, 0.004, 1.0])
    fmu = make_model(FORWARD).start(BEFORE_A_RISE | {"cam2.table": str(table)})
    for k in range(steps):
        fmu.set({"tau": 0.1 * k / steps})
        fmu.set_rates(tau=0.1)
        fmu.step(1.0 / steps)
    assert fmu.get("mode") == WEDGED
    assert fmu.get("theta") == pytest.approx(DWELL, rel=1e-9)
    for torque, mode in ((5.0, WEDGED), (-5.0, RELEASING)):
        fmu.set({"tau": torque})
        fmu.step(0.1)
        assert fmu.get("mode") == mode
    rate = BEFORE_A_RISE["shaft.damping"] / BEFORE_A_RISE["inertia.shaft"]  # J omega' = tau - b omega
    speed = -5.0 / BEFORE_A_RISE["shaft.damping"]
    way = speed * (0.1 + math.expm1(-0.1 * rate) / rate)
    assert fmu.get("theta") == pytest.approx(DWELL + way, rel=1e-9)
