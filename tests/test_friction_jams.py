"""Friction that grows with the sliding speed until it jams, and wedged rest (docs/mechanism.md).

Oracles: the balances solved by SciPy, DOP853, the zero of a polynomial, and the balance of energy.
"""

import math

import numpy as np
import pytest
from driver import ERROR, OK, models
from reference import LOADING, RELEASING, STICK, write_table
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

FORWARD = models["DualCamForward"]
CUTS, WEDGED = (1, 2, 7, 60), 6
R, LEAD = (0.02, 0.03), (1.2, 1.1)
A = tuple(r * math.tan(lead) for r, lead in zip(R, LEAD, strict=True))
TURN, LIFT = A[1] / (A[0] + A[1]), A[0] * A[1] / (A[0] + A[1])
SLIDING = TURN * math.hypot(R[0], A[0])  # m/rad, of contact 1
MU, BRANCH = (0.1, 0.05), 2.0  # 1; s/m at cam 1
HELICES = {
    "cam1.radius": R[0],
    "cam2.radius": R[1],
    "cam1.lead_angle": LEAD[0],
    "cam2.lead_angle": LEAD[1],
    "cam1.friction": MU[0],
    "cam2.friction": MU[1],
    "cam1.friction_viscous": BRANCH,
    "spring.stiffness": 0.0,
    "stop.lower": -50.0,
    "stop.upper": 50.0,
    "contacts": 1,
}


def factors(omega, flanks=(1, 1)):
    """n_i r_i and d_i of section 3 at a speed."""
    way = 1 if omega >= 0 else -1
    mu = MU[0] + BRANCH * SLIDING * abs(omega), MU[1]
    f = [way * e * m for e, m in zip(flanks, mu, strict=True)]
    return [r * (a + k * r) for r, a, k in zip(R, A, f, strict=True)], [
        r - k * a for r, a, k in zip(R, A, f, strict=True)
    ]


def delta(omega, flanks=(1, 1)):
    rn, d = factors(omega, flanks)
    return d[0] * rn[1] + rn[0] * d[1]


def lever(omega, flanks=(1, 1)):
    """rho: torque per axial load."""
    rn, _ = factors(omega, flanks)
    return rn[0] * rn[1] / delta(omega, flanks)


JAM = brentq(delta, 0.0, 1e4)  # rad/s, at which loading jams


def run(fmu, duration, pieces, tau, pull):
    """Constant or linear inputs (value, rate) over `duration`, in equal steps."""
    h = duration / pieces
    for k in range(pieces):
        fmu.set({"tau": tau[0] + tau[1] * k * h, "F_ext": pull[0] + pull[1] * k * h})
        if tau[1] or pull[1]:
            fmu.set_rates(tau=tau[1], F_ext=pull[1])
        status = fmu.call("fmi2DoStep", fmu.time, h, 1)
        if status != OK:
            return status
        fmu.time += h
    return OK


@pytest.mark.parametrize("share", [0.5, 0.99, 1.0 - 1e-6])
def test_speed_without_inertia_is_the_root_of_the_balance(make_model, share):
    """tau = rho(mu(omega)) F_0: a root as close to the jam as asked for."""
    load, omega = 40.0, share * JAM
    fmu = make_model(FORWARD).start(HELICES | {"spring.preload": load, "inertia.shaft": 0.0})
    assert run(fmu, 1e-3, 1, (load * lever(omega), 0.0), (0.0, 0.0)) == OK
    assert fmu.get("mode") == LOADING
    assert fmu.get("omega") == pytest.approx(omega, rel=1e-9)


def test_speed_without_inertia_is_no_jam(make_model):
    """The axial load passes zero while the torque loads: the torque left has no zero on the old flanks then.
    Friction heat never falls, and the energy balance closes."""
    parameters = HELICES | {"spring.preload": 20.0, "shaft.damping": 0.002, "inertia.shaft": 0.0}
    fmu, heat = make_model(FORWARD).start(parameters), 0.0
    for k in range(40):
        assert run(fmu, 5e-3, 1, (0.6, 0.0), (-30.0 + k, 0.0)) == OK, fmu.messages[-1].text
        assert fmu.get("energy.heat_cam1") + fmu.get("energy.heat_cam2") >= heat
        heat = fmu.get("energy.heat_cam1") + fmu.get("energy.heat_cam2")
        assert abs(fmu.get("energy.residual")) <= 1e-8 * (heat + fmu.get("energy.work_in"))


def test_torque_that_no_speed_balances_is_refused(make_model):
    """rho for mu to infinity is finite if contact 2 does not lock: 1/(kappa_2 - s_1/r_1)."""
    kappa_2 = (1.0 - MU[1] * A[1] / R[1]) / (A[1] + MU[1] * R[1])
    flat = HELICES | {"cam1.lead_angle": 0.1, "spring.preload": 40.0, "inertia.shaft": 0.0}
    limit = 40.0 / (kappa_2 - math.tan(0.1) / R[0])
    fmu = make_model(FORWARD).start(flat)
    assert run(fmu, 1e-4, 1, (0.99 * limit, 0.0), (0.0, 0.0)) == OK
    assert run(fmu, 1e-4, 1, (1.01 * limit, 0.0), (0.0, 0.0)) == ERROR
    assert "without inertia no speed balances the torque" in fmu.messages[-1].text
    inertial = make_model(FORWARD).start(flat | {"inertia.shaft": 1e-4})
    assert run(inertial, 1e-4, 1, (1.01 * limit, 0.0), (0.0, 0.0)) == OK


STEEP_BRANCH = 200.0  # s/m: mu_2 = 1e10 less than 0.1 rad from the start


@pytest.fixture(scope="module")
def dwell_of_cam_2(tmp_path_factory):
    """Cam 2 is level for psi_2 from -1.2 on, with mu_2 = STEEP_BRANCH v. Cam 1 has mu_1 = 1."""
    path = tmp_path_factory.mktemp("dwell") / "groove.csv"
    write_table(path, [-6.0, -3.0, -1.2, 0.0, 0.5], [0.0, 0.02, 0.025, 0.025, 0.025])
    level = {
        "cam2.profile": 3,
        "cam2.table": str(path),
        "cam2.friction": 0.0,
        "cam2.friction_viscous": STEEP_BRANCH,
    }
    cam1 = {"cam1.lead_angle": 0.1, "cam1.friction": 1.0, "cam1.friction_viscous": 0.0}
    return HELICES | level | cam1 | {"spring.preload": 0.0, "stop.lower": -5.0, "stop.upper": 0.4}


@pytest.mark.parametrize("pieces", CUTS)
def test_a_torque_that_grows_beyond_what_any_speed_balances(make_model, dwell_of_cam_2, pieces):
    """F = -1 N and tau = -t. On the dwell tau = F r_1 r_2 n_1 n_2/(r_2 d_1 n_2 + r_1 d_2 n_1), where
    n_2 = mu_2 r_2 and d_2 = r_2: a speed without bound as tau comes to F r_1 n_1/d_1. Contact 1 locks on its
    other flank, where a low speed balances more torque. A light mechanism does not come to this speed."""
    slope, inertia = R[0] * math.tan(0.1), 1e-7
    n_1, d_1 = slope + R[0], R[0] - slope
    limit, half = R[0] * n_1 / d_1, n_1 / d_1 * R[0] / R[1]  # N.m, and s; mu_2 at half of the limit
    mu_by_speed = STEEP_BRANCH * R[1]
    fmu = make_model(FORWARD).start(dwell_of_cam_2 | {"inertia.shaft": 0.0})
    assert run(fmu, 0.9 * limit, pieces, (0.0, -1.0), (-1.0, 0.0)) == OK
    assert fmu.get("omega") == pytest.approx(-9.0 * half / mu_by_speed, rel=1e-9)
    assert run(fmu, 0.2 * limit, pieces, (-0.9 * limit, -1.0), (-1.0, 0.0)) == ERROR
    assert "without inertia no speed balances the torque" in fmu.messages[-1].text
    light = make_model(FORWARD).start(dwell_of_cam_2 | {"inertia.shaft": inertia})
    assert run(light, 1.2 * limit, pieces, (0.0, -1.0), (-1.0, 0.0)) == OK

    def acceleration(t, omega):
        mu_2 = -mu_by_speed * omega
        return (limit * mu_2 / (mu_2 + half) - t) / inertia

    exact = solve_ivp(acceleration, (0.0, 1.2 * limit), [0.0], "Radau", rtol=1e-12, atol=1e-14)
    assert light.get("omega") == pytest.approx(exact.y[0, -1], rel=1e-7)


ALIKE = HELICES | {
    "cam2.radius": R[0],
    "cam1.lead_angle": 0.6,
    "cam2.lead_angle": 0.6,
    "cam2.friction": MU[0],
    "cam2.friction_viscous": BRANCH,
    "spring.preload": 400.0,
    "inertia.shaft": 0.0,
}


@pytest.mark.parametrize("damping", [0.0, 20.0])
@pytest.mark.parametrize("tau", [0.5, 1e-3, 0.0, -1e-3, -0.5, -3.0])
def test_contacts_that_lock_at_the_same_speed_move_on(make_model, damping, tau):
    """Two equal contacts: both lock at the speed at which mu(v) = tan(lead angle). From there on a torque
    pulls the mechanism back. One contact then bears on its other flank: tau = rho F with f_i = -+ mu. The
    damper takes load off the contacts, so that the torque left has a second zero, at a higher speed."""
    r, a = R[0], R[0] * math.tan(0.6)
    sliding = math.hypot(r, a) / 2.0  # m/rad

    def left(omega, flank):
        mu = MU[0] + BRANCH * sliding * omega
        f = (-mu, -flank * mu)
        n, d = [r * (a + k * r) for k in f], [r - k * a for k in f]
        return tau - n[0] * n[1] / (d[0] * n[1] + n[0] * d[1]) * (400.0 - damping * a / 2.0 * omega)

    locks = (math.tan(0.6) - MU[0]) / (BRANCH * sliding)
    fmu = make_model(FORWARD).start(ALIKE | {"damper.c_release": damping})
    assert run(fmu, 1e-4, 1, (tau, 0.0), (0.0, 0.0)) == OK, fmu.messages[-1].text
    span = (0.0, locks * (1 - 1e-9)) if tau > 0.0 else (locks * (1 - 1e-9), 10 * locks)
    wanted = brentq(left, *span, args=(1 if tau > 0.0 else -1,), xtol=1e-12)
    assert fmu.get("mode") == RELEASING
    assert fmu.get("omega") == pytest.approx(-wanted, rel=1e-9)


def test_no_speed_at_rest_without_inertia(make_model):
    """The load grows until the band holds the torque: the speed is zero wherever the mode is stick."""
    fmu = make_model(FORWARD).start(HELICES | {"spring.preload": 5.0, "inertia.shaft": 0.0})
    for k in range(30):
        assert run(fmu, 1e-3, 1, (0.3, 0.0), (1.0 * k, 0.5e3)) == OK
        assert fmu.get("mode") in (STICK, LOADING, RELEASING)
        assert fmu.get("mode") != STICK or fmu.get("omega") == 0.0


@pytest.mark.parametrize("pieces", CUTS)
def test_energy_closes_while_the_contacts_hold_the_speed(make_model, pieces):
    """A small load: the speed stays 1e-6 below the jam, where J alpha = tau - rho(omega) F_0."""
    load, inertia = 1e-4, 1e-4
    fmu = make_model(FORWARD).start(HELICES | {"spring.preload": load, "inertia.shaft": inertia})
    assert run(fmu, 2.0, pieces, (0.5, 0.0), (0.0, 0.0)) == OK
    held = brentq(lambda omega: 0.5 - load * lever(omega), 0.0, JAM * (1 - 1e-12))
    assert fmu.get("omega") == pytest.approx(held, rel=1e-8)
    assert abs(fmu.get("energy.residual")) <= 1e-8 * fmu.get("energy.work_in")


def test_contacts_let_go_where_the_load_vanishes(make_model):
    """The load passes zero while the contacts hold the speed. Then J alpha = tau - rho F on the flanks of the
    coming load, from the speed held on: by DOP853. This speed and the instant do not depend on tau."""
    inertia, tau, rate, start = 1e-4, 0.5, 40.0, 2.0
    parameters = HELICES | {"spring.preload": 0.0, "inertia.shaft": inertia}

    def held(load):
        return brentq(lambda w: tau - load * lever(w), 0.0, JAM * (1 - 1e-15))

    assert lever(0.5 * JAM, (-1, -1)) > 0.0  # so that the coming load is held by the other flanks
    vanishes = start / rate
    end = 1.1 * vanishes

    def speed_under(torque):
        def rates(t, x):
            return [(torque - rate * (vanishes - t) * lever(x[0], (-1, -1))) / inertia]

        way = solve_ivp(rates, (vanishes, end), [held(1e-13)], method="DOP853", rtol=1e-12, atol=1e-12)
        return way.y[0, -1]

    found = []
    for pieces in CUTS:
        fmu = make_model(FORWARD).start(parameters)
        assert run(fmu, end, pieces, (tau, 0.0), (start, -rate)) == OK
        found.append(fmu.get("omega"))
        if pieces == 1:
            by_torque = fmu.get("step.domega_dtau")
    assert found == pytest.approx([speed_under(tau)] * len(CUTS), rel=1e-6)
    assert np.ptp(found) <= 1e-7 * abs(found[0])
    change = 1e-3
    expected = (speed_under(tau + change) - speed_under(tau - change)) / (2.0 * change)
    assert by_torque == pytest.approx(expected, rel=1e-5)


HELD = {
    "cam1.radius": 0.01,
    "cam2.radius": 0.05,
    "cam1.lead_angle": math.atan(1.0),
    "cam2.lead_angle": math.atan(0.02),
    "cam1.friction": 0.0,
    "cam2.friction": 0.1,
    "cam2.friction_viscous": 2.0,
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
    "inertia.shaft": 1e-4,
    "stop.lower": -50.0,
    "contacts": 1,
}


def held_balance(p, omega, flanks):
    """The matrix of x_1, x_2 and alpha in the balance of section 6 at the speed omega < 0."""
    r = p["cam1.radius"], p["cam2.radius"]
    a = [r[i] * math.tan(p[f"cam{i + 1}.lead_angle"]) for i in (0, 1)]
    turn, lift = a[1] / (a[0] + a[1]), a[0] * a[1] / (a[0] + a[1])
    mu = 0.0, p["cam2.friction"] + p["cam2.friction_viscous"] * (1.0 - turn) * math.hypot(r[1], a[1]) * -omega
    f = [-e * k for e, k in zip(flanks, mu, strict=True)]
    rn, d = [r[i] * (a[i] + f[i] * r[i]) for i in (0, 1)], [r[i] - f[i] * a[i] for i in (0, 1)]
    shaft, mass, ring = p["inertia.shaft"], p["inertia.follower_mass"], p["inertia.follower"]
    return np.array([[d[0], d[1], -mass * lift], [rn[0], 0.0, shaft + ring * turn], [0.0, rn[1], shaft]])


@pytest.mark.parametrize("inertia", [(0.0, 1e-6), (1e-2, 0.0), (1e-2, 1e-6)])
def test_follower_with_inertia_lets_go_at_the_end_of_the_jam(make_model, inertia):
    """The torque releases against contact 2, which is locked, and the contacts hold the speed. With inertia
    of the follower they let go while the axial load is above zero: where the matrix of the balance and its
    numerator vanish together. From there the speed is that of the other flanks, by DOP853."""
    p = HELD | {"inertia.follower_mass": inertia[0], "inertia.follower": inertia[1]}
    tau, start, rate, held = -0.05, 5.0, 10.0, (-1, 1)

    def determinant(omega, load=None):
        matrix = held_balance(p, omega, held)
        if load is not None:
            matrix[:, 2] = load, tau, tau
        return np.linalg.det(matrix)

    speed = brentq(determinant, -1.4, -0.1, xtol=1e-15)
    load = brentq(lambda load: determinant(speed, load), -1.0, 1.0, xtol=1e-15)
    assert 1e-3 < load < 0.1
    begin = (start - load) / rate

    def rates(t, x):
        for flanks in ((1, -1), (-1, -1), (1, 1)):
            found = np.linalg.solve(held_balance(p, x[0], flanks), [start - rate * t, tau, tau])
            if flanks[0] * found[0] >= -1e-9 and flanks[1] * found[1] >= -1e-9:
                return [found[2]]
        raise AssertionError(t)

    end = 1.02 * start / rate
    after = solve_ivp(rates, (begin, end), [speed], method="DOP853", rtol=1e-11, atol=1e-12)
    found = []
    for pieces in (*CUTS, 28, 66, 79, 110):
        fmu = make_model(FORWARD).start(p)
        assert run(fmu, end, pieces, (tau, 0.0), (start, -rate)) == OK
        found.append(fmu.get("omega"))
    assert found == pytest.approx([after.y[0, -1]] * len(found), rel=1e-7)


PAINLEVE = {
    "cam1.radius": 0.28,
    "cam2.radius": 0.0035,
    "cam1.lead_angle": 0.15,
    "cam2.lead_angle": 0.7,
    "cam1.friction": 1.0,
    "cam2.friction": 0.13,
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
    "inertia.shaft": 9e-4,
    "inertia.follower": 1.8e-4,
    "stop.upper": 10.0,
}


def agrees(tau, load, p=PAINLEVE):
    """Does a pair of flanks agree with the reactions of loading from rest? Section 6, for alpha and x_i."""
    r = p["cam1.radius"], p["cam2.radius"]
    a = [r[i] * math.tan(p[f"cam{i + 1}.lead_angle"]) for i in (0, 1)]
    turn, inertia = a[1] / (a[0] + a[1]), (p["inertia.shaft"], p["inertia.follower"])
    for flanks in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        f = [e * p[f"cam{i + 1}.friction"] for i, e in enumerate(flanks)]
        rn, d = [r[i] * (a[i] + f[i] * r[i]) for i in (0, 1)], [r[i] - f[i] * a[i] for i in (0, 1)]
        matrix = [[d[0], d[1], 0.0], [rn[0], 0.0, inertia[0] + inertia[1] * turn], [0.0, rn[1], inertia[0]]]
        x0, x1, alpha = np.linalg.solve(matrix, [load, tau, tau])
        moves = (d[0] * rn[1] + rn[0] * d[1]) * np.linalg.det(matrix) < 0.0
        if moves and alpha > 0.0 and flanks[0] * x0 >= 0.0 and flanks[1] * x1 >= 0.0:
            return True
    return False


def test_wedge_ends_where_flanks_agree(make_model):
    """Beyond a finite edge of the band, with no pair of flanks that agrees, until the load has grown."""
    tau, rate, end = 0.1, 20.0, 0.03
    least = brentq(lambda load: 1.0 if agrees(tau, load) else -1.0, 0.1, 0.5)
    found = []
    for pieces in CUTS:
        fmu = make_model(FORWARD).start(PAINLEVE)
        assert run(fmu, least / rate * (1 - 1e-6), pieces, (tau, 0.0), (0.0, rate)) == OK
        assert fmu.get("mode") == WEDGED and fmu.get("omega") == 0.0
        assert fmu.get("torque_load") < tau
        fmu = make_model(FORWARD).start(PAINLEVE)
        assert run(fmu, least / rate * (1 + 1e-6), pieces, (tau, 0.0), (0.0, rate)) == OK
        assert fmu.get("mode") == LOADING and fmu.get("omega") > 0.0
        fmu = make_model(FORWARD).start(PAINLEVE)
        assert run(fmu, end, pieces, (tau, 0.0), (0.0, rate)) == OK
        found.append(fmu.get("omega"))
    assert found[0] > 0.0
    assert np.ptp(found) <= 1e-8 * found[0]


# A heavy follower, no inertia of the shaft, and a contact that the load locks.
LOCKED_UNDER_LOAD = {
    "cam1.radius": 0.1,
    "cam2.radius": 0.1,
    "cam1.lead_angle": 1.0,
    "cam1.friction": 0.0,
    "cam2.profile": 2,
    "cam2.lead_angle": 0.75,
    "cam2.ellipse_a": 0.4,
    "cam2.ellipse_b": 0.6454311564206855,
    "cam2.ellipse_curvature": -1,
    "cam2.friction": 0.05717224847382875,
    "cam2.friction_load_exponent": -0.5,
    "cam2.friction_load": 1.0,
    "spring.preload": 0.0,
    "spring.stiffness": 100.0,
    "spring.stiffness2": -100.0,
    "spring.stiffness3": -1000.0,
    "damper.c_load": 1.0,
    "damper.c_release": 1.0,
    "damper.q_load": 1.0,
    "damper.q_release": 1.0,
    "shaft.damping": 1.0,
    "inertia.shaft": 0.0,
    "inertia.follower_mass": 1.0,
    "inertia.follower": 1e-5,
    "stop.upper": 1.0,
    "initial.theta": 1.0,
}


@pytest.mark.parametrize("parts", [1, 3, 10])
def test_a_wedge_under_load_friction_ends_where_flanks_agree(make, parts):
    """Not at the end of a step: then the answer would depend on the cuts. The contacts jam and let go some
    hundred times. The motion is the limit of motions with a small inertia of the shaft, which do not jam."""
    angles = []
    for inertia in (0.0, 1e-9):
        fmu = make().start(LOCKED_UNDER_LOAD | {"tau": 0.0, "F_ext": -1.0, "inertia.shaft": inertia})
        assert inertia > 0.0 or fmu.get("mode") == WEDGED
        assert run(fmu, 1.0, parts, (0.0, -1.0), (-1.0, 0.0)) == OK, fmu.messages[-1].text
        angles.append(fmu.get("theta"))
    assert angles[0] == pytest.approx(angles[1], abs=2e-9)


# ---- moving contacts whose load passes zero ----

# Contact 2 alone locks. Under a torque that turns the inertia two pairs of flanks agree where R_1 is zero.
TWO_PAIRS = {
    "cam1.radius": 0.0143,
    "cam2.radius": 0.19,
    "cam1.lead_angle": 0.3,
    "cam2.lead_angle": 0.01,
    "cam1.friction": 0.21,
    "cam2.friction": 0.124,
    "spring.stiffness": 0.0,
    "spring.preload": 0.0,
    "inertia.shaft": 0.16,
    "inertia.follower": 2.4e-4,
    "stop.lower": -50.0,
    "stop.upper": 50.0,
    "initial.omega": 1.0,
    "contacts": 1,
}


def balance(p, tau, load, flanks):
    """R_1/h_1, R_2/h_2 and alpha of loading in helices: the axial balance and two moment balances."""
    r = p["cam1.radius"], p["cam2.radius"]
    a = [r[i] * math.tan(p[f"cam{i + 1}.lead_angle"]) for i in (0, 1)]
    f = [e * p[f"cam{i + 1}.friction"] for i, e in enumerate(flanks)]
    rn, d = [r[i] * (a[i] + f[i] * r[i]) for i in (0, 1)], [r[i] - f[i] * a[i] for i in (0, 1)]
    J, inertia = p["inertia.shaft"], p["inertia.follower"] * a[1] / (a[0] + a[1])
    return np.linalg.solve([[d[0], d[1], 0.0], [rn[0], 0.0, J + inertia], [0.0, rn[1], J]], [load, tau, tau])


@pytest.mark.parametrize("pieces", CUTS)
def test_a_contact_whose_load_passes_zero_changes_its_flank_alone(make_model, pieces):
    """The axial load falls. At R_1 = 0 the speed goes on with the same acceleration, although another pair of
    flanks agrees too, with another acceleration. alpha is linear in the load, and the load in time."""
    tau, end = 500.0, 1e-3
    zero = brentq(lambda load: balance(TWO_PAIRS, tau, load, (1, 1))[0], 0.0, 100.0)
    other = balance(TWO_PAIRS, tau, zero, (1, -1))
    assert other[0] > 0.0 > other[1]
    speed, loads = TWO_PAIRS["initial.omega"], (1.5 * zero, zero, 0.5 * zero)
    for flanks, phase in (((1, 1), loads[:2]), ((-1, 1), loads[1:])):
        speed += 0.25 * end * sum(balance(TWO_PAIRS, tau, load, flanks)[2] for load in phase)
    fmu = make_model(FORWARD).start(TWO_PAIRS)
    assert run(fmu, end, pieces, (tau, 0.0), (loads[0], -zero / end)) == OK
    assert fmu.get("omega") == pytest.approx(speed, rel=1e-10)
