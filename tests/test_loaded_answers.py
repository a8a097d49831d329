"""Friction that depends on the load (docs/mechanism.md, section 9): the one answer of the balance where the
reactions are far from those without friction, and rest that ends where an answer appears.

Oracles: the balance of two contacts by SciPy's bisection, and instants in closed form.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
from driver import models
from reference import DOUBLE, Mechanism, write_table
from reference.friction import FrictionLaw, LoadedContact
from reference.parameters import DEFAULTS
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar
from test_friction_jams import OK, WEDGED, run

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
LUBRICATED = {
    1: {"friction_load_exponent": 0.3, "friction_load": 80.0, "friction_viscous": 0.4},
    2: {"friction_load_exponent": 0.4, "friction_load": 150.0, "friction_viscous": 0.2},
}
FREE = {"spring.preload": 0.0, "spring.stiffness": 0.0, "contacts": 1}


def cam(i, radius, lead, friction, exponent=0.0, load=100.0):
    values = (radius, lead, friction, exponent, load)
    names = ("radius", "lead_angle", "friction", "friction_load_exponent", "friction_load")
    return {f"cam{i}.{name}": value for name, value in zip(names, values, strict=True)}


def contact(p, i, turn):
    """Contact i with turn = sigma e_i."""
    full = DEFAULTS | p
    lead = math.tan(full[f"cam{i}.lead_angle"])
    return LoadedContact(full[f"cam{i}.radius"], lead, FrictionLaw.of_cam(full, i), 0.0, 1, turn)


def reaction_beside(of: LoadedContact, rise: float, axial: float, low: float, high: float) -> float:
    """The reaction of `of` between low and high, N. The other contact has no friction and a groove of the
    slope `rise`, m/rad. It bears the torque over this slope as axial force."""
    return brentq(lambda r: of.torque(r) / rise + of.axial(r) - axial, low, high, xtol=1e-300, rtol=1e-15)


def reaction_at(of: LoadedContact, torque: float) -> float:
    """The reaction of a contact whose torque grows with the reaction."""
    return brentq(lambda r: of.torque(r) - torque, 0.0, 1e14, xtol=1e-300, rtol=1e-15)


# ---- the answer of the balance ----

NEARLY_LEVEL = FREE | cam(1, 0.0047, 0.26, 0.11, 0.16, 9300.0) | cam(2, 0.055, 1e-4, 0.086, -0.6, 9.4e5)


@pytest.mark.parametrize("model", [FORWARD, INVERSE])
def test_loading_edge_of_a_nearly_level_groove(make_model, model):
    """Both torques grow with their reactions, so that R_2 gives R_1 and with both the axial load."""
    first, second = (contact(NEARLY_LEVEL, i, 1) for i in (1, 2))

    def carried(reaction):
        return first.axial(reaction_at(first, second.torque(reaction))) + second.axial(reaction)

    fmu = make_model(model).start(NEARLY_LEVEL)
    for F_0 in np.geomspace(1.0, 1e7, 40):
        found = brentq(lambda r, f=F_0: carried(r) - f, 1e-9, 1e9, xtol=1e-300, rtol=1e-15)
        fmu.set({"F_ext": F_0})
        assert fmu.get("torque_load") == pytest.approx(second.torque(found), rel=1e-10), F_0


@pytest.mark.parametrize("model", [FORWARD, INVERSE])
def test_release_edge_beside_a_locked_contact(make_model, model):
    """Contact 1 without friction bears on its other flank: its axial force is T/a_1. The reaction of the
    locked contact is 20 times that without friction."""
    p = FREE | cam(1, 0.004, 1.3, 0.0) | cam(2, 0.076, 0.63, 1.37, -0.1, 205.0)
    locked, rise = contact(p, 2, -1), 0.004 * math.tan(1.3)
    fmu = make_model(model).start(p)
    for F_0 in np.linspace(1000.0, 3000.0, 200):
        reaction = reaction_beside(locked, rise, F_0, 1.0, 1e6)
        fmu.set({"F_ext": F_0})
        assert locked.torque(reaction) < 0.0
        assert fmu.get("torque_release") == pytest.approx(locked.torque(reaction), rel=1e-10), F_0


@pytest.mark.parametrize("model", [FORWARD, INVERSE])
@pytest.mark.parametrize("size", [1.0, 0.01])
def test_release_edge_of_a_nearly_locked_contact_beside_a_nearly_level_groove(make_model, model, size):
    """As above, with friction that falls with the load: contact 2 locks below a reaction, and the edge is
    just above. Newton's method ends at a reaction off the flank, in a mechanism of any size."""
    radius = size * 0.0986, size * 0.00914
    p = FREE | cam(1, radius[0], 1.5e-5, 0.0) | cam(2, radius[1], 1.1, 1.0, -0.7, 6.3)
    second, rise = contact(p, 2, -1), radius[0] * math.tan(1.5e-5)
    unlocked = 6.3 * (1.0 / math.tan(1.1)) ** (1 / 0.7)
    fmu = make_model(model).start(p)
    for F_0 in np.linspace(8.0, 60.0, 12):
        reaction = reaction_beside(second, rise, F_0, unlocked, 1e4)
        fmu.set({"F_ext": F_0})
        # the torque is a difference of nearly equal terms: their rounding over the torque is 1e-9
        assert fmu.get("torque_release") == pytest.approx(second.torque(reaction), rel=1e-8, abs=0.0), F_0


@pytest.mark.parametrize("model", [FORWARD, INVERSE])
def test_release_edge_of_a_nearly_locked_contact_1_beside_a_nearly_level_groove_2(make_model, model):
    """The same with the cams exchanged. Contact 1 bears next to nothing beside contact 2."""
    p = FREE | cam(1, 0.0826, 1.1303, 0.117, -0.517, 214.0) | cam(2, 0.0149, 1e-6, 0.0)
    first, rise = contact(p, 1, -1), 0.0149 * math.tan(1e-6)
    unlocked = brentq(first.torque, 0.2, 0.5, xtol=1e-300, rtol=1e-15)
    fmu = make_model(model).start(p)
    for F_0 in np.linspace(700.0, 3000.0, 12):
        reaction = reaction_beside(first, rise, F_0, unlocked, 1e4)
        fmu.set({"F_ext": F_0})
        torque = rise * (F_0 - first.axial(reaction))
        assert fmu.get("torque_release") == pytest.approx(torque, rel=1e-10, abs=0.0), F_0


@pytest.mark.parametrize("model", [FORWARD, INVERSE])
def test_efficiency_is_0_where_no_torque_moves_the_mechanism(make_model, model):
    """The load exceeds the largest that the contacts carry when loading, and when releasing while contact 2
    is not locked. With contact 2 locked the load is below the least that they carry."""
    p, F_0 = (
        FREE | cam(1, 0.0624, 1.021, 0.293, -0.095, 4.93e5) | cam(2, 0.0121, 0.7125, 0.13, 0.304, 803.5),
        4e5,
    )
    for turn in (1, -1):
        first, second = (contact(p, i, turn) for i in (1, 2))
        grows = [r for r in np.geomspace(1e-3, 1e8, 500) if second.grows(r)]
        assert max(second.axial(r) + first.axial(reaction_at(first, second.torque(r))) for r in grows) < F_0
    other = contact(p, 1, 1)
    pulls = [r for r in np.geomspace(1e-3, 1e10, 500) if second.torque(r) <= 0.0]
    left = [second.axial(r) - other.axial(reaction_at(other, -second.torque(r))) for r in pulls]
    assert min(left) > F_0
    fmu = make_model(model).start(p | {"F_ext": F_0})
    assert (fmu.get("torque_load"), fmu.get("torque_release")) == (math.inf, -math.inf)
    assert fmu.get("efficiency") == 0.0


# ---- the edges of random mechanisms ----


def random_mechanism(rng):
    """Radii, lead angles and laws over some decades, under the preload alone."""

    def decades(low, high):
        return float(10.0 ** rng.uniform(low, high))

    p = FREE | {"spring.preload": decades(-2, 3), "inertia.shaft": 1.0, "stop.upper": 0.1}
    for i in (1, 2):
        lead = float(rng.choice([rng.uniform(0.05, 1.4), decades(-6, -1)]))
        friction = float(rng.choice([0.0, rng.uniform(0.0, 1.5), decades(-4, 0)]))
        p |= cam(i, decades(-2.5, -0.3), lead, friction, float(rng.uniform(-0.9, 0.9)), decades(-1, 4))
        if rng.random() < 0.5:
            p |= {f"cam{i}.friction_peak": 1.0 + decades(-2, 0.5), f"cam{i}.stribeck_velocity": 0.1}
    return p


@pytest.mark.parametrize("number", range(40))
def test_edges_of_random_mechanisms(make_model, number):
    """Beside the reference, which samples both reactions on each pair of flanks. It leaves out reactions of
    more than 1e4 F_0, under which friction that grows with the load locks contacts."""
    p = random_mechanism(np.random.default_rng([number, 7]))
    fmu = make_model(FORWARD)
    try:
        fmu.start(p)
    except AssertionError:
        assert "jam when loading" in fmu.messages[-1].text
        return
    mechanism, F_0 = Mechanism(p, DOUBLE), p["spring.preload"]
    for direction, name in ((1, "torque_load"), (-1, "torque_release")):
        ratio = mechanism.static_ratio(mechanism.groove.at(0.0), direction, F_0)
        if ratio is not None:
            assert fmu.get(name) == pytest.approx(ratio * F_0, rel=1e-7, abs=1e-14 * F_0)


# ---- rest that ends where an answer appears ----

STEEP = FREE | {k: v for i in (1, 2) for k, v in cam(i, 0.02, 1.0, 0.2, 0.5, 100.0).items()}
BODIES = {"inertia": {"inertia.shaft": 0.01}, "damping": {"inertia.shaft": 0.0, "shaft.damping": 0.5}}


def largest_load():
    """N, that two equal contacts carry when loading: mu grows with the load until it carries no more."""
    equal = contact(STEEP, 1, 1)
    found = minimize_scalar(
        lambda r: -equal.axial(r), bounds=(1.0, 1e4), method="bounded", options={"xatol": 1e-9}
    )
    return 2.0 * equal.axial(found.x), equal.torque(found.x)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("pieces", [1, 7])
def test_a_jam_above_a_load_ends_with_the_load(make_model, body, pieces):
    """F_ext falls through the largest load that can be moved, while the torque is twice that at its edge."""
    load, torque = largest_load()
    begins, end = 0.07, 0.1
    pull = (1.7 * load, -0.7 * load / begins)
    p = STEEP | BODIES[body] | {"F_ext": pull[0], "tau": 2.0 * torque, "stop.upper": 50.0}
    fmu = make_model(FORWARD).start(p)
    assert fmu.get("mode") == WEDGED
    assert run(fmu, begins * (1.0 - 1e-7), pieces, (2.0 * torque, 0.0), pull) == OK
    assert fmu.get("theta") == 0.0
    whole = make_model(FORWARD).start(p)
    assert run(whole, end, pieces, (2.0 * torque, 0.0), pull) == OK
    fine = make_model(FORWARD).start(p)
    assert run(fine, end, 60, (2.0 * torque, 0.0), pull) == OK
    assert whole.get("theta") > 0.0
    assert whole.get("theta") == pytest.approx(fine.get("theta"), rel=1e-7)
    assert abs(whole.get("energy.residual")) <= 1e-9 * whole.get("energy.work_in")


@pytest.mark.parametrize("middle", [0.0505, 0.0511, 0.0517, 0.0523])
def test_a_short_dip_of_the_load_ends_rest(make_model, middle):
    """The load falls as a parabola, for 0.8 ms of the 70 below that which the torque moves."""
    equal = contact(STEEP, 1, 1)
    load, torque = 2.0 * equal.axial(50.0), equal.torque(50.0)
    half, end = 0.0004, 0.07
    curve = 2e-4 * load / half**2
    pull = (load * 0.9998 + curve * middle**2, -2.0 * curve * middle, 2.0 * curve)
    fmus = [
        make_model(FORWARD).start(STEEP | BODIES["inertia"] | {"F_ext": pull[0], "tau": torque}) for _ in "ab"
    ]
    for fmu, parts in zip(fmus, (1, 300), strict=True):
        for k in range(parts):
            t = end * k / parts
            fmu.set({"F_ext": pull[0] + t * (pull[1] + t * pull[2] / 2), "tau": torque})
            fmu.set_derivatives({"F_ext": [pull[1] + t * pull[2], pull[2], 0.0]})
            assert fmu.call("fmi2DoStep", fmu.time, end / parts, 1) == OK
            fmu.time += end / parts
    moved, fine = (fmu.get("theta") for fmu in fmus)
    assert moved > 0.0
    assert moved == pytest.approx(fine, rel=1e-6)


# ---- a motion of which Newton's method loses the answer ----

# Two steep helices. Friction of contact 1 falls with its load: below 199 N the axial force of the contact is
# negative, and the motion goes on at reactions of 114 to 92 N, which settle. Off the flanks the balance has
# another answer, near 0.2 N. From 0.5 s on Newton's method ends there in some steps.
RADII, LEAD = (1e-3, 10**-2.5), 1.5
FALLING = FREE | cam(1, RADII[0], LEAD, 1.0, -0.5, 1.0) | cam(2, RADII[1], LEAD, 0.0)
FALLING |= {"damper.c_load": 0.0, "damper.c_release": 0.0, "spring.stiffness": 1.0, "shaft.damping": 1.0}
FALLING |= {"inertia.shaft": 1.0, "inertia.follower_mass": 1.0, "stop.upper": 1.0}


def motion_on_the_large_answer():
    """theta and omega after 1 s with tau = 1 N.m, F_ext = -1 N/s t, by DOP853."""
    first, slope = contact(FALLING, 1, 1), [r * math.tan(LEAD) for r in RADII]
    lift = slope[0] * slope[1] / sum(slope)

    def rates(t, y):
        theta, omega = y

        def missed(reaction):
            alpha = 1.0 - omega - first.torque(reaction)
            axial = lift * theta - t + lift * alpha
            return first.torque(reaction) / slope[1] + first.axial(reaction) - axial

        reaction = brentq(missed, 60.0, 190.0, xtol=1e-300, rtol=1e-15)
        return [omega, 1.0 - omega - first.torque(reaction)]

    return solve_ivp(rates, (0.0, 1.0), [0.0, 0.0], "DOP853", rtol=1e-13, atol=1e-15).y[:, -1]


@pytest.mark.parametrize("steps", [1, 2, 3, 7, 30])
def test_a_motion_keeps_the_answer_that_newtons_method_loses(make_model, steps):
    """A step had nodes on both answers: the angle erred by 1e-7."""
    fmu = make_model(FORWARD).start(FALLING)
    for k in range(steps):
        fmu.set({"tau": 1.0, "F_ext": -k / steps})
        fmu.set_rates(F_ext=-1.0)
        fmu.step(1.0 / steps)
    assert [fmu.get("theta"), fmu.get("omega")] == pytest.approx(motion_on_the_large_answer(), rel=1e-9)


# ---- rest that ends after a load has come ----

# Groove 1 is level, groove 2 a helix: the follower turns with the shaft. Friction of contact 2 grows with the
# load. Without load nothing holds a torque; under the smallest F_ext the contacts lock each other and hold
# 0.0053 N.m. F_ext falls with 1 N/s, and the torque grows with 1 N.m/s.
LEVEL_BESIDE_A_HELIX = {
    **FREE,
    **cam(1, 0.01, 1.0, 0.01, -0.75, 100.0),
    **cam(2, 0.01, 0.5, 0.1, 0.5, 0.1),
    **{"cam1.profile": 3, "cam1.friction_peak": 2.0, "cam1.friction_viscous": 1.0},
    **{"cam1.stribeck_velocity": 1.0, "damper.c_load": 0.0, "damper.c_release": 0.0, "shaft.damping": 0.0},
    **{"inertia.shaft": 1.0, "inertia.follower_mass": 0.0, "inertia.follower": 0.01},
    "stop.upper": 1.0,
}
LEVEL = ([0.0, 0.35, 0.7, 1.05], [0.0] * 4)


class TurningWithTheFollower:
    """On the flanks e = -1 and 1. The groove of cam 1 passes on the torque of friction alone."""

    shaft, follower = 1.0, 0.01  # kg.m2

    def __init__(self):
        full = DEFAULTS | LEVEL_BESIDE_A_HELIX
        self.law, self.second = FrictionLaw.of_cam(full, 1), contact(LEVEL_BESIDE_A_HELIX, 2, 1)
        self.near = 0.74  # N, a reaction of contact 2 near that which is sought

    def alpha(self, t, omega):
        def missed(reaction):
            torque = self.second.torque(reaction)
            alpha = (t - torque) / self.shaft
            first = t + self.second.axial(reaction)  # N, of contact 1 in a level groove
            rubs = 0.01 * self.law.at(0.01 * omega, first) * first
            return torque - rubs - self.follower * alpha

        low, high = 0.9 * self.near, 1.1 * self.near
        self.near = brentq(missed, low, high, xtol=1e-300, rtol=1e-15)
        return (t - self.second.torque(self.near)) / self.shaft


@pytest.mark.parametrize("steps", [1, 2, 3, 10])
def test_rest_ends_when_the_torque_leaves_contacts_that_lock_each_other(make_model, tmp_path, steps):
    """In one step rest ended 5e-3 s late."""
    table = tmp_path / "level.csv"
    write_table(table, *LEVEL)
    fmu = make_model(FORWARD).start(LEVEL_BESIDE_A_HELIX | {"cam1.table": str(table)})
    for k in range(steps):
        fmu.set({"tau": k / steps, "F_ext": -k / steps})
        fmu.set_rates(tau=1.0, F_ext=-1.0)
        fmu.step(1.0 / steps)
    motion = TurningWithTheFollower()
    begin = brentq(lambda t: motion.alpha(t, 0.0), 0.005, 0.006, xtol=1e-16)
    end = solve_ivp(
        lambda t, y: [y[1], motion.alpha(t, y[1])], (begin, 1.0), [0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-15
    )
    assert [fmu.get("theta"), fmu.get("omega")] == pytest.approx(end.y[:, -1], rel=1e-9)


# ---- without inertia: the torque limits the speed ----


class Limited:
    """A steep and a nearly level groove without inertia. Friction at cam 1 grows with the load, at both cams
    with the speed. Up to a torque more torque gives more speed. There two answers of the balance meet."""

    p = (
        FREE
        | cam(1, 0.0091, math.pi / 2 - 1e-4, 0.033, 0.54, 930.0)
        | cam(2, 0.31, 1e-6, 0.15)
        | {"cam1.friction_viscous": 6e-4, "cam2.friction_viscous": 0.03, "contacts": 2, "inertia.shaft": 0.0}
        | {"damper.c_load": 5600.0, "spring.stiffness": 1.6e5}
        | {"initial.theta": -0.93, "stop.lower": -0.93, "stop.upper": 2.0}
    )

    def __init__(self):
        full = DEFAULTS | self.p
        self.r = [full[f"cam{i}.radius"] for i in (1, 2)]
        self.s = [math.tan(full[f"cam{i}.lead_angle"]) for i in (1, 2)]
        self.laws = [FrictionLaw.of_cam(full, i) for i in (1, 2)]
        a = [r * s for r, s in zip(self.r, self.s, strict=True)]
        self.lift = a[0] * a[1] / sum(a)
        self.sliding = [a[1 - i] / sum(a) * math.hypot(self.r[i], a[i]) for i in (0, 1)]
        at = self.p["initial.theta"]
        self.limit = brentq(
            lambda t: self.speed(1.001 * t, at) - self.speed(0.999 * t, at), 0.3, 2.0, rtol=1e-13
        )

    def speed(self, torque, theta):
        """The speed at which the contacts carry spring and damper."""

        def missed(omega):
            of = [
                LoadedContact(r, s, law, omega * v, 2, 1)
                for r, s, law, v in zip(self.r, self.s, self.laws, self.sliding, strict=True)
            ]
            carried = sum(c.axial(reaction_at(c, torque)) for c in of)
            spring = self.p["spring.stiffness"] * self.lift * theta
            return carried - spring - self.p["damper.c_load"] * self.lift * omega

        return brentq(missed, 0.0, 1e4, xtol=1e-300, rtol=1e-14)

    def angle(self, torque, rate, end):
        """At the time `end`, under a torque of that rate."""

        def speed(t, theta):
            return [self.speed(torque + rate * t, theta[0])]

        at = self.p["initial.theta"]
        return solve_ivp(speed, (0.0, end), [at], "DOP853", rtol=1e-11, atol=1e-12).y[0, -1]


@pytest.mark.parametrize("cuts", [1, 7])
def test_a_torque_that_a_speed_balances_moves_the_mechanism(make_model, cuts):
    motion, rate, end = Limited(), -100.0, 1e-3
    torque = 0.98 * motion.limit
    fmu = make_model(FORWARD).start(motion.p | {"tau": torque})
    for begin, to in pairwise(np.linspace(0.0, end, cuts + 1)):
        fmu.set({"tau": torque + rate * begin})
        fmu.set_derivatives({"tau": [rate]})
        assert fmu.call("fmi2DoStep", begin, to - begin, 1) == OK, fmu.messages[-1].text
    assert fmu.get("theta") == pytest.approx(motion.angle(torque, rate, end), abs=1e-9)


@pytest.mark.parametrize("share", [1.01, 170.0])
def test_a_torque_that_no_speed_balances_is_refused(make_model, share):
    motion = Limited()
    fmu = make_model(FORWARD).start(motion.p | {"tau": share * motion.limit})
    assert fmu.call("fmi2DoStep", 0.0, 1e-3, 1) != OK
    assert "no speed balances the torque" in fmu.messages[-1].text


def test_a_spring_that_no_speed_balances_needs_inertia(make_model):
    """No torque holds the spring: with a small inertia the mechanism moves back to the lower stop."""
    load = {f"cam{i}.{name}": x for i, laws in LUBRICATED.items() for name, x in laws.items()}
    start = load | {"initial.theta": 1.1}
    light, massless = (make_model(FORWARD).start(start | {"inertia.shaft": J}) for J in (1e-4, 0.0))
    assert light.call("fmi2DoStep", 0.0, 0.05, 1) == OK
    assert light.get("theta") == 0.0
    assert massless.call("fmi2DoStep", 0.0, 0.05, 1) != OK
    assert "inertia.shaft must be > 0" in massless.messages[-1].text


class NoTorque:
    """Helices without inertia under the spring, a damper and no torque. A contact that carries a load passes
    no torque where mu = tan(lead angle). Friction at the one cam grows with the speed: this contact carries
    the follower, which sinks at the speed of the lock, and the other contact carries nothing. Friction at the
    other cam depends on the load."""

    preload, stiffness, damping, top, branch = 0.5, 200.0, 20.0, 0.02, 8.0  # N, N/m, N.s/m, m, s/m
    end = 0.14  # s

    def __init__(self, viscous: int):
        """`viscous`: the cam whose friction grows with the speed."""
        leads, radii = {viscous: 0.8, 3 - viscous: 0.6}, {1: 0.02, 2: 0.03}
        rise = {i: radii[i] * math.tan(leads[i]) for i in (1, 2)}
        lift = rise[1] * rise[2] / (rise[1] + rise[2])
        self.p = (
            cam(viscous, radii[viscous], leads[viscous], 0.0)
            | cam(3 - viscous, radii[3 - viscous], leads[3 - viscous], 0.3, 0.5)
            | {f"cam{viscous}.friction_viscous": self.branch, "inertia.shaft": 0.0}
            | {"spring.preload": self.preload, "spring.stiffness": self.stiffness}
            | {"damper.c_release": self.damping, "damper.c_load": self.damping}
            | {"initial.theta": self.top / lift, "stop.lower": -1.0, "stop.upper": 4.0}
        )
        self.fall = self.end * math.tan(leads[viscous]) / self.branch * math.sin(leads[viscous])  # m

    def heat(self):
        """J: what the spring gives and the damper does not take."""
        force = self.preload + self.stiffness * (self.top - self.fall / 2.0)  # N, on the average
        drag = self.damping * self.fall / self.end
        assert force - self.stiffness * self.fall / 2.0 > drag  # the spring alone would be faster
        return (force - drag) * self.fall


@pytest.mark.parametrize("viscous", [1, 2])
@pytest.mark.parametrize("pieces", [1, 7, 60])
def test_no_torque_moves_the_mechanism_at_the_speed_of_the_lock(make_model, viscous, pieces):
    """The torque below which the contacts release is above zero, so that rest is no answer."""
    motion = NoTorque(viscous)
    fmu = make_model(FORWARD).start(motion.p)
    assert fmu.get("torque_release") > 0.0
    assert run(fmu, motion.end, pieces, (0.0, 0.0), (0.0, 0.0)) == OK, fmu.messages[-1].text
    assert fmu.get("z") == pytest.approx(motion.top - motion.fall, abs=1e-10 * motion.top)
    assert fmu.get(f"energy.heat_cam{viscous}") == pytest.approx(motion.heat(), rel=1e-10)
    assert abs(fmu.get(f"energy.heat_cam{3 - viscous}")) <= 1e-12 * motion.heat()
