"""Without inertia of the shaft and of the follower's turn the torque loads both contacts: T_1 = T_2 = tau.

A pull begins to move the follower's mass while the torque grows from nothing like t^2. Contact 2, whose
friction grows with the speed, locks at a speed that the mechanism reaches within 1e-7 s. From there on the
torque holds this speed. With x_i = tau/(r_i n_i), n_i = a_i + f_i r_i and d_i = r_i - f_i a_i
(docs/mechanism.md, section 6)

    m z' alpha = d_1 x_1 + d_2 x_2 - F_ext - D.

Oracle: SciPy's Radau.
"""

import math

import numpy as np
import pytest
from driver import FORWARD
from reference import RELEASING
from scipy.integrate import solve_ivp

RADII, LEADS, MASS, DAMPER, PULL = (0.006, 0.032), (1.5, 0.005), 0.07, 0.1, 28.0
DRY, VISCOUS, TORQUE = (
    0.5,
    1.0,
    2400.0,
)  # of cam 1; s/m, of cam 2; N.m/s2, the second derivative of the torque
END = 1e-3  # s
PARAMETERS = {
    **{f"cam{i}.radius": r for i, r in zip((1, 2), RADII, strict=True)},
    **{f"cam{i}.lead_angle": lead for i, lead in zip((1, 2), LEADS, strict=True)},
    "cam1.friction": DRY,
    "cam2.friction": 0.0,
    "cam2.friction_viscous": VISCOUS,
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
    "spring.stiffness2": 1e-9,  # a curved spring, nearly without force: by collocation
    "damper.c_release": DAMPER,
    "inertia.shaft": 0.0,
    "inertia.follower": 0.0,
    "inertia.follower_mass": MASS,
    "shaft.damping": 0.0,
    "stop.lower": -0.3,
}


def rates(t, state):
    """Releasing, sigma = -1, on the flanks e_i = 1."""
    _theta, omega = state
    slopes = [r * math.tan(lead) for r, lead in zip(RADII, LEADS, strict=True)]
    turn = slopes[1] / sum(slopes), slopes[0] / sum(slopes)  # of both grooves, per angle
    lift = slopes[0] * turn[0]
    sliding = -omega * turn[1] * math.hypot(RADII[1], slopes[1])
    friction = -DRY, -VISCOUS * sliding
    torque, axial = TORQUE * t * t / 2.0, PULL + DAMPER * lift * omega
    for r, a, f in zip(RADII, slopes, friction, strict=True):
        axial -= (r - f * a) * torque / (r * (a + f * r))
    return [omega, -axial / (MASS * lift)]


@pytest.mark.parametrize("cuts", [1, 2, 10])
def test_the_motion_begins_at_once(make_model, cuts):
    fmu = make_model(FORWARD).start(PARAMETERS)
    h = END / cuts
    for k in range(cuts):
        t = k * h
        fmu.set({"tau": TORQUE * t * t / 2.0, "F_ext": PULL})
        fmu.set_derivatives({"tau": [TORQUE * t, TORQUE]})
        fmu.step(h)
    found = solve_ivp(rates, (0.0, END), [0.0, 0.0], "Radau", rtol=1e-12, atol=1e-18)
    assert found.success and np.all(found.y[1] <= 0.0)
    assert fmu.get("mode") == RELEASING
    assert fmu.get("theta") == pytest.approx(found.y[0, -1], rel=1e-7)
    assert fmu.get("omega") == pytest.approx(found.y[1, -1], rel=1e-9)
