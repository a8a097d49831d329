"""Steps in which damping rules the motion: without inertia, or with hardly any.

An answer does not depend on how an interval is cut into steps. Oracles: closed forms, SciPy, and the speed
by the balance of torques (docs/mechanism.md, section 6).
"""

import math

import numpy as np
import pytest
from driver import FORWARD
from pin_equations import Groove, Pin, band, edge, ellipse, helix, polynomial, sampled, spring_force
from reference import LOADING, RELEASING, STICK, write_table
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from test_cuts_of_general_grooves import CUTS, run

NEAR = 1e-9  # the default tolerance


# ---- stiff steps ----

PIN = Pin(helix(0.016, 0.416), ellipse(0.035, 0.456, 0.17, 0.15, 1))
CURVED = PIN.values | {
    "cam1.friction": 0.13,
    "cam2.friction": 0.25,
    "spring.preload": 28.0,
    "spring.stiffness": 4200.0,
    "spring.stiffness2": 1.07e6,
    "spring.stiffness3": 1.05e8,
    "damper.c_load": 20.0,
    "damper.q_load": 300.0,
    "shaft.damping": 3e-4,
    "inertia.shaft": 0.0,
    "initial.theta": -0.08,
    "stop.lower": -0.43,
    "stop.upper": 1.13,
}


def speed(torque, theta):
    """omega >= 0 without inertia: tau - b omega = rho (F_s + c v + q v^2), v = z' omega."""
    place = PIN.at(theta)
    rho = edge(place, (CURVED["cam1.friction"], CURVED["cam2.friction"]), 1, 1.0)[0]
    left = torque - rho * spring_force(CURVED, place.z)
    linear = CURVED["shaft.damping"] + rho * CURVED["damper.c_load"] * place.lift
    square = rho * CURVED["damper.q_load"] * place.lift**2
    return 2.0 * left / (linear + math.sqrt(linear**2 + 4.0 * square * left))


def test_the_speed_in_a_stiff_step_without_inertia(make_model):
    """The speed belongs to the angle: an error of the angle changes the speed by domega/dtheta, here up to
    -530 1/s. The speed at the end keeps ten times the tolerance, relative to itself."""
    h = 1.0
    torque = [0.3, 0.1 / h, 0.15 / h**2, -0.3 / h**3]
    way = solve_ivp(
        lambda t, x: [speed(polynomial(torque, t), x[0])],
        (0.0, h), [CURVED["initial.theta"]], method="DOP853", rtol=1e-11, atol=1e-14,
    )  # fmt: skip
    fmu = make_model(FORWARD).start(CURVED)
    fmu.set({"tau": torque[0]})
    fmu.set_derivatives({"tau": torque[1:]})
    fmu.step(h)
    assert fmu.get("theta") == pytest.approx(way.y[0, -1], rel=NEAR)
    assert fmu.get("omega") == pytest.approx(speed(polynomial(torque, h), way.y[0, -1]), rel=10.0 * NEAR)


def test_the_speed_in_a_stiff_step_with_inertia(make_model):
    """J alpha = tau - b omega - z' (F_s + D) without friction, J = 1e-5 kg.m2: a speed that nothing drives
    would fall by exp(-600) in this step."""
    J, h, groove = 1e-5, 2.0, PIN.second  # of both cams: gamma = phi = theta/2
    p = CURVED | Pin(groove, groove).values
    p |= {"cam1.friction": 0.0, "cam2.friction": 0.0, "shaft.damping": 3e-3, "inertia.shaft": J}
    p |= {"damper.c_release": 20.0, "damper.q_release": 300.0}
    torque = [0.3, 0.1 / h, 0.15 / h**2, -0.3 / h**3]

    def rate(t, x):
        lift = 0.5 * groove.slope(0.5 * x[0])
        v = lift * x[1]
        load = spring_force(p, groove.z(0.5 * x[0])) + v * (p["damper.c_load"] + p["damper.q_load"] * abs(v))
        return [x[1], (polynomial(torque, t) - p["shaft.damping"] * x[1] - lift * load) / J]

    way = solve_ivp(rate, (0.0, h), [p["initial.theta"], 0.0], method="DOP853", rtol=1e-11, atol=1e-14)
    fmu = make_model(FORWARD).start(p)
    fmu.set({"tau": torque[0]})
    fmu.set_derivatives({"tau": torque[1:]})
    fmu.step(h)
    assert fmu.get("theta") == pytest.approx(way.y[0, -1], rel=NEAR)
    assert fmu.get("omega") == pytest.approx(way.y[1, -1], rel=10.0 * NEAR)


# ---- several pairs of flanks ----


@pytest.mark.parametrize("cuts", CUTS)
def test_a_motion_begins_at_the_slowest_of_several_speeds(make_model, cuts):
    """An axial pull moves cam 2. Its friction mu = mu_v v locks the flat groove just above 0.014 rad/s, where
    the torque passes zero. Two pairs of flanks agree: one with that speed, n_2 = a_2 - mu r_2 near zero, and
    one with a speed of 1e8 rad/s, at which the damper carries the pull. A mechanism with hardly any inertia
    reaches the slow one first. tau = r_1 r_2 n_1 n_2 F/Delta (docs/mechanism.md, section 3)."""
    steep, flat = helix(0.05, 1.5706), ellipse(0.0012, 3e-6, 7.5, 5e-6, 1)
    h, preload, pull, square, viscous = 3.5e-4, 834.0, -1702.0, 6400.0, 0.18
    parameters = Pin(steep, flat).values | {
        "cam1.friction": 0.0,
        "cam2.friction": 0.0,
        "cam2.friction_viscous": viscous,
        "spring.preload": preload,
        "spring.stiffness": 0.0,
        "damper.c_load": 0.0,
        "damper.q_load": square,
        "inertia.shaft": 0.0,
        "stop.lower": -6.8,
        "stop.upper": 0.64,
    }
    fmu = make_model(FORWARD).start(parameters)
    torque = 8e-7
    run(fmu, h, cuts, tau=[0.0, 0.0, torque / h**2], F_ext=[pull])

    def left(omega):  # gamma = 0 to all digits, so that phi = theta
        (r1, r2), (a1, a2) = (steep.radius, flat.radius), (steep.slope(0.0), flat.slope(fmu.get("theta")))
        lift, turn = a1 * a2 / (a1 + a2), a1 / (a1 + a2)
        friction = -viscous * omega * turn * math.hypot(r2, a2)  # f_2 = sigma e_2 mu_2
        n2, d2 = a2 + friction * r2, r2 - friction * a2
        load = preload + pull + square * (lift * omega) ** 2
        return 0.5 * torque - load * r1 * r2 * a1 * n2 / (r2 * r1 * n2 + r1 * d2 * a1)

    assert fmu.get("omega") == pytest.approx(brentq(left, 0.01, 0.02, xtol=1e-16), rel=10.0 * NEAR)


# ---- rest and motion under the same torque ----


LIFT = Groove(1.0, {}, lambda x: 0.9 * x * x, lambda x: 1.8 * x, lambda x: 1.8)  # level at psi = 0
LOCKS_AT_REST = {
    "cam1.friction": 0.0,
    "cam2.friction": 1.0,
    "cam1.friction_viscous": 1.0,
    "cam2.friction_viscous": 1.0,
    "spring.preload": 0.0,
    "spring.stiffness": 1.0,
    "spring.stiffness2": -515.0,
    "damper.c_load": 0.0,
    "damper.c_release": 0.0,
    "inertia.shaft": 0.0,
    "shaft.damping": 1.0,
    "stop.lower": 0.0,
    "stop.upper": 1.0,
}


@pytest.fixture
def lifted(tmp_path):
    return Pin(sampled(LIFT, tmp_path / "lift.csv", np.linspace(0.0, 1.01, 9)), helix(1.0, 0.5))


def left_torque(pin, theta, omega):
    """tau - b omega - rho(mu(v)) F_0, tau = 1 N.m, F_ext = -1 N; infinite where no pair of flanks agrees."""
    place = pin.at(theta)
    sliding = (place.length(0) * place.turn * omega, place.length(1) * (1.0 - place.turn) * omega)
    mu = [LOCKS_AT_REST[f"cam{i}.friction"] + v for i, v in enumerate(sliding, start=1)]
    return 1.0 - omega - edge(place, mu, 1, spring_force(LOCKS_AT_REST, place.z) - 1.0)[0]


@pytest.mark.parametrize("cuts", CUTS)
def test_a_torque_that_rest_and_motion_balance_needs_inertia(make_model, lifted, cuts):
    """Found by `./build.sh fuzz`. At rest the contacts lock from theta = 0 on; at a speed they move."""
    for theta in (0.01, 0.05, 0.1):
        at_rest = band(lifted.at(theta), (0.0, 1.0), spring_force(LOCKS_AT_REST, lifted.at(theta).z) - 1.0)
        assert at_rest[1] == math.inf
        assert left_torque(lifted, theta, 0.4) > 0.0 > left_torque(lifted, theta, 0.9)
    fmu = make_model(FORWARD).start(lifted.values | LOCKS_AT_REST)
    with pytest.raises(AssertionError, match=r"rest and motion both balance .* inertia\.shaft must be > 0"):
        run(fmu, 1.0, cuts, tau=[1.0], F_ext=[-1.0])
    light = make_model(FORWARD).start(lifted.values | LOCKS_AT_REST | {"inertia.shaft": 1e-6})
    run(light, 1.0, cuts, tau=[1.0], F_ext=[-1.0])
    whole = make_model(FORWARD).start(lifted.values | LOCKS_AT_REST | {"inertia.shaft": 1e-6})
    run(whole, 1.0, [], tau=[1.0], F_ext=[-1.0])
    assert light.get("theta") == pytest.approx(whole.get("theta"), rel=NEAR) and light.get("theta") > 0.4


def test_a_motion_ends_where_contacts_lock_and_no_torque_drives_it(make_model, lifted):
    """A pull turns F_0 and the torque around: inside the band at rest, whose loading edge is infinite."""
    theta, drag, push, torque = 0.1, -0.05, 5.0, 50.0
    fmu = make_model(FORWARD).start(lifted.values | LOCKS_AT_REST | {"initial.theta": theta})
    fmu.set({"F_ext": push, "tau": torque})
    fmu.step(1e-4)
    moved = fmu.get("theta")
    assert fmu.get("mode") == LOADING and moved > theta
    place = lifted.at(moved)
    release, load = band(place, (0.0, 1.0), spring_force(LOCKS_AT_REST, place.z) - 1.0)
    assert release < drag and load == math.inf
    fmu.set({"F_ext": -1.0, "tau": drag})
    fmu.step(1.0)
    assert fmu.get("omega") == 0.0 and fmu.get("theta") == moved


# ---- contacts without load ----


@pytest.mark.parametrize("cuts", CUTS)
def test_a_force_pulls_the_follower_against_its_damper_while_no_contact_bears_a_load(make_model, cuts):
    """Without torque and inertia the contacts stay without load: F_ext = f t against q v^2, so that
    z = -2/3 sqrt(f/q) t^(3/2). The reactions are rounding, which grows with F_ext and tells no flank."""
    h, rate, square = 1e-4, 10.0, 2.0
    parameters = PIN.values | {
        "cam1.friction": 0.06,
        "cam2.friction": 0.0,
        "spring.preload": 0.0,
        "spring.stiffness": 0.0,
        "damper.c_release": 0.0,
        "damper.q_release": square,
        "inertia.shaft": 0.0,
        "stop.lower": -0.1,
    }
    fmu = make_model(FORWARD).start(parameters)
    run(fmu, h, cuts, tau=[0.0], F_ext=[0.0, rate])
    assert fmu.get("z") == pytest.approx(-2.0 / 3.0 * math.sqrt(rate / square * h**3), rel=NEAR)
    assert fmu.get("energy.heat_cam1") <= NEAR * fmu.get("energy.heat_damper")


@pytest.mark.parametrize("cuts", CUTS)
@pytest.mark.parametrize("above", [4e-10, 1e-8, 1e-7])
def test_a_locked_contact_passes_the_place_where_a_groove_becomes_level(make_model, tmp_path, above, cuts):
    """Down from there the axial load passes no torque: b omega = tau. The slope above, over so short a way,
    counts for nothing. Contact 1 loses its load at that place and does not change its flank."""
    path, h, damping, knot = tmp_path / "groove.csv", 1e-4, 1e-4, 0.013
    write_table(path, [knot * k for k in range(7)], [0.0, 0.0, 0.0, *[5.7e-9] * 4])
    parameters = {
        "cam1.radius": 0.07,
        "cam1.lead_angle": 5.6e-6,
        "cam1.friction": 0.023,
        "cam2.radius": 0.36,
        "cam2.profile": 3,
        "cam2.table": str(path),
        "cam2.friction": 0.0,
        "spring.preload": 0.0,
        "spring.stiffness": 0.0,
        "damper.c_load": 0.0,
        "damper.c_release": 0.0,
        "shaft.damping": damping,
        "inertia.shaft": 0.0,
        "initial.theta": 2.0 * knot + above,
        "stop.lower": 0.0,
        "stop.upper": 0.076,
    }
    fmu = make_model(FORWARD).start(parameters)
    tau = [0.0, -1e-6 / h, -0.02 / h**2]
    run(fmu, h, cuts, tau=tau, F_ext=[-1280.0])
    change = (tau[1] * h**2 / 2.0 + tau[2] * h**3 / 6.0) / damping
    assert fmu.get("mode") == RELEASING
    assert fmu.get("theta") - 2.0 * knot - above == pytest.approx(change, rel=NEAR)


# Cam 1 has no friction, and that of cam 2 grows with the load: its contact locks at rest beyond some 200 N. A
# pull that grows moves the follower, and the damper takes nearly all of the pull.
HELD_BY_DAMPER = {
    "cam1.radius": 0.01,
    "cam2.radius": 0.011,
    "cam1.lead_angle": 0.75,
    "cam2.lead_angle": 0.69,
    "cam1.friction": 0.0,
    "cam2.friction": 0.02,
    "cam2.friction_load": 1.0,
    "cam2.friction_load_exponent": 0.7,
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
    "damper.c_load": 5e4,
    "contacts": 1,
    "shaft.damping": 0.05,
    "stop.lower": 0.0,
    "stop.upper": 1.0,
    "initial.theta": 0.1,
}


def speed_under_damper(pull):
    """rad/s, by docs/mechanism.md, section 9: contact i passes on the torque r (a x + r q) and the axial
    force r x - a q. The drag of the shaft gives x_2, both contacts pass on one torque, and the damper takes
    the rest of the pull."""
    a1, r, a = 0.01 * math.tan(0.75), 0.011, 0.011 * math.tan(0.69)
    full = pull / (5e4 * a1 * a / (a1 + a))  # all of the pull at the damper

    def missed_pull(omega):
        drag = -0.05 * omega

        def missed_drag(x):
            return r * (a * x + r * friction(x)) - drag

        def friction(x):
            return 0.02 * (abs(x) * math.hypot(r, a)) ** 0.7 * abs(x)

        x = brentq(missed_drag, 3.0 * drag / (r * a), 0.0, xtol=1e-14)
        return drag / a1 + r * x - a * friction(x) + pull * (1.0 - omega / full)

    return brentq(missed_pull, 0.0, full, xtol=1e-14)


@pytest.mark.parametrize("cuts", CUTS)
def test_a_pull_that_locks_at_rest_and_moves_a_damper_needs_inertia(make_model, cuts):
    """Found by `./build.sh fuzz`: the mechanism wedged at full speed, where a step happened to end."""
    pull = [-50.0, -5000.0]  # N, N/s
    fmu = make_model(FORWARD).start(HELD_BY_DAMPER | {"inertia.shaft": 0.0})
    with pytest.raises(AssertionError, match=r"rest and motion both balance .* inertia\.shaft must be > 0"):
        run(fmu, 0.1, cuts, tau=[0.0], F_ext=pull)
    if len(cuts) > 10:  # the last step that is accepted ends in motion
        assert fmu.get("omega") > 0.5 and fmu.get("mode") == LOADING
    light = make_model(FORWARD).start(HELD_BY_DAMPER | {"inertia.shaft": 1e-7})
    run(light, 0.1, cuts, tau=[0.0], F_ext=pull)

    way = solve_ivp(
        lambda t, _: [speed_under_damper(-polynomial(pull, t))],
        (0.0, 0.1), [0.1], method="DOP853", rtol=1e-9, atol=1e-12,
    )  # fmt: skip
    assert light.get("theta") == pytest.approx(way.y[0, -1], rel=1e-5)
    assert light.get("mode") == LOADING


@pytest.mark.parametrize("profile", [1, 2])
@pytest.mark.parametrize("h", [0.03, 0.1, 0.3, 1.0])
def test_a_motion_that_fades_away_has_a_speed_as_long_as_it_slips(make_model, profile, h):
    """A damper slows the motion toward the torque that holds the spring: omega falls like exp(-t/T). A step
    ended in mode 1 beside a speed of 1e-11 rad/s, in grooves other than helices."""
    parameters = {
        "cam1.lead_angle": 0.7,
        "cam1.friction": 0.02,
        "cam2.friction": 0.0,
        "cam2.profile": profile,
        "cam2.lead_angle": 0.8,
        "cam2.ellipse_a": 0.1,
        "cam2.ellipse_b": 0.1,
        "spring.preload": 10.0,
        "spring.stiffness": 2000.0,
        "damper.c_load": 150.0,
        "inertia.shaft": 0.0,
        "stop.upper": 0.5,
        "tau": 0.12,
    }
    fmu = make_model(FORWARD).start(parameters)
    modes = []
    for _ in range(math.ceil(6.0 / h)):
        fmu.step(h)
        modes.append(fmu.get("mode"))
        assert (fmu.get("omega") > 0.0) == (modes[-1] == LOADING)
    assert modes[0] == LOADING and modes[-1] == STICK
    assert fmu.get("torque_load") == pytest.approx(0.12, rel=1e-9)
