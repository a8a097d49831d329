"""Motions that begin without load where the groove of cam 2 is level.

At rest there nothing but the torque sets the motion, and the time scale of the motion is infinite. The
flanks follow from the loads a little later, when the pin must still be in the groove. Oracle: the equation of
motion of section 6 of docs/mechanism.md, by DOP853.
"""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from driver import OK, models
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
