"""Friction that depends on the load (docs/mechanism.md, section 9): reactions that the balance has are found,
and have digits where Delta is rounding.

Oracles: a law whose exponent is zero, the balance of energy, and DOP853 with the reaction of a contact by
bisection.
"""

import math

import pytest
from driver import OK, models
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from test_friction_jams import run

FORWARD = models["DualCamForward"]

# ---- reactions where Delta is rounding ----

# Both frictions grow with the speed: releasing, the contacts hold the speed at the limit of a jam, Delta = 0,
# until the damper has taken all of the spring's load.
HELD_BY_FRICTION = {
    "cam1.radius": 1.0,
    "cam2.radius": 1.0,
    "cam1.lead_angle": 1.0,
    "cam2.lead_angle": 0.25,
    "cam1.friction": 0.01,
    "cam2.friction": 1.0,
    "cam1.friction_viscous": 1.0,
    "cam2.friction_viscous": 1.0,
    "cam1.friction_load": 1.0,
    "spring.preload": 1.0,
    "spring.stiffness": 0.0,
    "spring.stiffness2": -100.0,
    "spring.stiffness3": -1000.0,
    "damper.c_release": 1.0,
    "damper.q_load": 1.0,
    "damper.q_release": 1.0,
    "inertia.shaft": 1e-7,
    "stop.lower": -1.0,
    "stop.upper": 1.0,
    "initial.omega": -1.0,
}
SHOWN = ("theta", "peak.omega", "peak.reaction1", "peak.reaction2", "energy.heat_cam1", "energy.heat_cam2")


@pytest.mark.parametrize("pieces", [1, 3, 20])
@pytest.mark.parametrize("exponent", [5e-249, 1e-12, 1e-10])
def test_reactions_at_the_limit_of_a_jam_have_digits(make_model, exponent, pieces):
    """Found by `./build.sh fuzz`: where the contacts let go, both reactions are quotients of two zeros. The
    reaction was 1e5 times as large as it is, and friction made heat of nothing. An exponent of 1e-10
    changes friction by 1e-9 at most."""
    runs = []
    for nu in (0.0, exponent):
        fmu = make_model(FORWARD).start(HELD_BY_FRICTION | {"cam1.friction_load_exponent": nu})
        assert run(fmu, 1.0, pieces, (-0.8188322728463655, 0.0), (-1.0, 0.0)) == OK
        assert abs(fmu.get("energy.residual")) <= 1e-12 * fmu.get("energy.work_in")
        runs.append([fmu.get(name) for name in SHOWN])
    assert runs[1] == pytest.approx(runs[0], rel=2e-9)


# ---- reactions that Newton's method does not find ----

# Contact 1 has no friction. Contact 2 locks on its other flank, where the torque has a balance, too, but one
# whose reactions do not settle: the motion is that with contact 2 on its supporting flank. The shaft has no
# inertia: the torque alone makes the reaction of contact 2.
LOCKED = {
    "cam1.radius": 0.00786789525834973,
    "cam2.radius": 0.07943282347242814,
    "cam1.lead_angle": 0.20778973557270497,
    "cam2.lead_angle": 0.4030517399235851,
    "cam1.friction": 0.0,
    "cam2.friction": 0.05384512885519625,
    "cam2.friction_viscous": 0.3103779841550781,
    "cam2.friction_load_exponent": 0.86,
    "cam2.friction_load": 1.0,
    "spring.preload": 0.0,
    "spring.stiffness": 8629.598051271923,
    "inertia.shaft": 0.0,
    "inertia.follower": 0.009999769744141627,
    "stop.upper": 2.4,
}


def angle_of_locked(tau: float, end: float, mass: float) -> float:
    """rad, after `end` seconds from rest at 0: x_2 by bisection from the torque, then alpha from the torque
    at contact 1, T_1 = T_2 - I gamma' alpha = r_1 a_1 x_1, and the axial balance."""
    p = LOCKED
    r = [p[f"cam{i}.radius"] for i in (1, 2)]
    a = [r[i] * math.tan(p[f"cam{i + 1}.lead_angle"]) for i in (0, 1)]
    turn, lift = a[1] / (a[0] + a[1]), a[0] * a[1] / (a[0] + a[1])
    length = math.hypot(r[1], a[1])
    felt = mass * lift + p["inertia.follower"] * turn / a[0]  # kg.m, of the axial balance without x_1

    def friction(x: float, omega: float) -> float:
        reaction = abs(x) * length / 2.0 / p["cam2.friction_load"]
        by_load = p["cam2.friction"] * reaction ** p["cam2.friction_load_exponent"]
        return by_load + p["cam2.friction_viscous"] * omega * (1.0 - turn) * length

    def rates(_: float, y: list[float]) -> list[float]:
        x2 = brentq(lambda x: r[1] * (a[1] + friction(x, y[1]) * r[1]) * x - tau, 0.0, 1e7, xtol=1e-12)
        axial2 = (r[1] - friction(x2, y[1]) * a[1]) * x2
        return [y[1], (tau / a[0] + axial2 - p["spring.stiffness"] * lift * y[0]) / felt]

    return solve_ivp(rates, (0.0, end), [0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-14).y[0, -1]


@pytest.mark.parametrize("pieces", [1, 2, 5, 7, 13])
@pytest.mark.parametrize("mass", [0.0, 0.3, 1.0])
def test_a_motion_without_inertia_of_the_shaft_keeps_its_flanks(make_model, mass, pieces):
    """Found by `./build.sh fuzz cuts`: a motion on the locked flank, whose reactions Newton's method did not
    find at some speeds, changed its flanks there, or did not, as the communication points fell.
    tests/test_elastic_flanks.py shows that no motion stays on this flank."""
    tau, end = 5.321953131066431, 0.03296503269797845
    parameters = LOCKED | {"inertia.follower_mass": mass}
    fmu = make_model(FORWARD).start(parameters | {"F_ext": -234.0, "tau": -0.2})
    assert run(fmu, 0.1, 1, (-0.2, 0.0), (-234.0, 0.0)) == OK  # so that the other flanks come first
    assert fmu.get("theta") == 0.0
    assert run(fmu, end, pieces, (tau, 0.0), (0.0, 0.0)) == OK
    assert fmu.get("theta") == pytest.approx(angle_of_locked(tau, end, mass), rel=1e-8)
