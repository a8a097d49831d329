"""The mechanism against numbers worked out by hand; each test says from which equation.

Unless a test says otherwise: r1 = r2 = 20 mm, both lead angles pi/4 (slopes a = 20 mm/rad, z' = 10 mm/rad),
mu = 0.14, F0 = 50 N, k = 50 kN/m, J = 0.002 kg.m2. Then kappa_i = (1 - sigma mu)/(r (1 + sigma mu)), so
rho_+ = r/2 (1 + mu)/(1 - mu) = 0.0132558139... m and rho_- = r/2 (1 - mu)/(1 + mu) = 0.0075438596... m.
"""

import math

import pytest
from driver import OK
from mechanisms import INERTIA, LIFT, MU, PRELOAD, RHO, STIFFNESS
from reference import LOADING, LOWER_STOP, RELEASING, STICK, UPPER_STOP, WEDGED
from statics_cases import MOVABLE, STATICS, geometry


def reactions(fmu):
    return fmu.get("cam1.reaction"), fmu.get("cam2.reaction")


# Section 3: statics
@pytest.mark.parametrize("name", MOVABLE)
def test_statics_with_60_digits(make, name):
    *case, loading, releasing = STATICS[name]
    fmu = make().start(geometry(*case))
    assert fmu.get("torque_load") == pytest.approx(loading[2], rel=1e-12)
    fmu.step(1e-6, tau=loading[2] + 1.0)
    assert fmu.get("mode") == LOADING
    assert reactions(fmu) == pytest.approx(loading[:2], rel=1e-12)
    if releasing is None:
        return
    assert fmu.get("torque_release") == pytest.approx(releasing[2], rel=1e-12)
    fmu = make().start(geometry(*case))
    fmu.step(1e-6, tau=releasing[2] - 1.0)
    assert fmu.get("mode") == RELEASING
    assert reactions(fmu) == pytest.approx(releasing[:2], rel=1e-12)


@pytest.mark.parametrize(("mu", "best"), [(0.14, 0.5690981841), (0.19, 0.4633147377)])
def test_optimum_of_efficiency(make, mu, best):
    """Section 8: ((1 - mu)/(1 + mu))^2 at lambda_1 = lambda_2 = pi/4, whatever radii and load; less anywhere
    else."""
    assert best == pytest.approx(((1 - mu) / (1 + mu)) ** 2, abs=1e-10)
    quarter = math.pi / 4
    for r2, force in ((0.02, 100.0), (0.035, 7.0)):
        fmu = make().start(geometry(0.02, r2, quarter, quarter, mu, mu, force))
        assert fmu.get("efficiency") == pytest.approx(best, abs=1e-9)
        for angles in ((0.7, 0.8), (0.9, 0.6), (quarter + 0.01, quarter), (quarter, quarter - 0.01)):
            assert make().start(geometry(0.02, r2, *angles, mu, mu, force)).get("efficiency") < best


def test_optimum_for_unequal_friction(make):
    """Section 8: tan lambda_i = mu_i/mu_e, eta = ((1 - mu_e)/(1 + mu_e))^2."""
    r, mu = (0.03, 0.02), (0.1, 0.2)
    mu_e = math.sqrt((mu[0] / r[0] + mu[1] / r[1]) / (1 / (mu[0] * r[0]) + 1 / (mu[1] * r[1])))
    best = math.atan(mu[0] / mu_e), math.atan(mu[1] / mu_e)
    eta = make().start(geometry(*r, *best, *mu, 100.0)).get("efficiency")
    assert eta == pytest.approx(((1 - mu_e) / (1 + mu_e)) ** 2, rel=1e-12)
    for step in ((0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)):
        angles = best[0] + step[0], best[1] + step[1]
        assert make().start(geometry(*r, *angles, *mu, 100.0)).get("efficiency") < eta


@pytest.mark.parametrize("name", ["one contact locks", "scissors"])
def test_one_locked_contact(make, name):
    """Section 3: contact 1 locks (lambda_1 < atan 0.14), contact 2 does not. Releasing, the pin of contact 2
    bears on its other flank: kappa_2 = (1 - mu s2)/(r2 (s2 + mu)), kappa_1 = (1 + mu s1)/(r1 (s1 - mu)).
    """
    r1, r2, l1, l2, mu1, mu2, force, _, _ = STATICS[name]
    s1, s2 = math.tan(l1), math.tan(l2)
    kappa = (1 + mu1 * s1) / (r1 * (s1 - mu1)) + (1 - mu2 * s2) / (r2 * (s2 + mu2))
    torque = force / kappa
    assert torque < 0
    fmu = make().start(geometry(r1, r2, l1, l2, mu1, mu2, force))
    assert fmu.get("torque_release") == pytest.approx(torque, rel=1e-12)
    fmu.step(0.01, tau=0.0)  # self-locking: the spring alone does not drive it back
    assert (fmu.get("mode"), fmu.get("theta")) == (STICK, 0.0)
    fmu.step(1e-6, tau=torque - 1e-3)
    assert fmu.get("mode") == RELEASING
    first, second = reactions(fmu)
    assert first > 0 > second
    assert first * (r1 / math.hypot(r1, r1 * s1)) * (1 + mu1 * s1) + second * (
        r2 / math.hypot(r2, r2 * s2)
    ) * (1 - mu2 * s2) == pytest.approx(force, rel=1e-9)


def test_wedge_holds_and_lets_go(make):
    """Section 3: contact 1 locks so firmly that on no pair of flanks both reactions agree with their flanks:
    |kappa_1| = (1 + mu s1)/(r1 (mu - s1)) < kappa_2 = (1 - mu s2)/(r2 (s2 + mu)). No torque releases it;
    loading goes on as ever."""
    s1, s2 = math.tan(0.001), math.tan(0.15)
    assert (1 + MU * s1) / (0.06 * (MU - s1)) < (1 - MU * s2) / (0.02 * (s2 + MU))
    load = 100.0 / ((1 - MU * s1) / (0.06 * (s1 + MU)) + (1 - MU * s2) / (0.02 * (s2 + MU)))
    fmu = make().start(geometry(0.06, 0.02, 0.001, 0.15, MU, MU, 100.0))
    assert fmu.get("torque_release") == -math.inf
    assert fmu.get("torque_load") == pytest.approx(load, rel=1e-12)
    fmu.step(0.1, tau=-1000.0)
    assert (fmu.get("mode"), fmu.get("theta")) == (WEDGED, 0.0)
    fmu.step(0.1, tau=load - 1e-6)
    assert (fmu.get("mode"), fmu.get("theta")) == (STICK, 0.0)
    fmu.step(1e-3, tau=load + 1.0)
    assert fmu.get("mode") == LOADING
    fmu.step(0.1, tau=-1.0)
    assert fmu.get("mode") == WEDGED
    assert fmu.get("theta") > 0
    assert abs(fmu.get("energy.residual")) <= 1e-15 * fmu.get("energy.work_in")


def test_stick_band_is_mirrored_for_negative_load(make):
    """Section 3, flank rule: for F < 0 the band is [-T_load(|F|), -T_release(|F|)]."""
    fmu = make().start({"spring.stiffness": 0.0, "stop.lower": -1.0})
    fmu.set({"F_ext": -150.0})  # F_0 = -100 N
    assert fmu.get("torque_load") == pytest.approx(-100 * RHO[-1], rel=1e-14)
    assert fmu.get("torque_release") == pytest.approx(-100 * RHO[1], rel=1e-14)
    fmu.step(0.1, tau=-1.0)
    assert (fmu.get("mode"), fmu.get("theta")) == (STICK, 0.0)
    fmu.step(1e-3, tau=-0.7)
    assert fmu.get("mode") == LOADING
    assert fmu.get("alpha") == pytest.approx((-0.7 + 100 * RHO[-1]) / INERTIA, rel=1e-12)
    assert fmu.get("cam1.reaction") < 0


# Section 5: end stops
def test_modes_at_the_stops(make):
    fmu = make().start()  # theta = 0 is the lower stop: the spring presses into it
    fmu.step(0.1)
    assert (fmu.get("mode"), fmu.get("theta")) == (LOWER_STOP, 0.0)
    fmu.step(0.1, tau=50 * RHO[-1] + 1e-9)  # now friction holds it
    assert fmu.get("mode") == STICK
    fmu.step(1.0, tau=20.0)
    assert (fmu.get("mode"), fmu.get("theta"), fmu.get("omega")) == (UPPER_STOP, 1.3963, 0.0)
    fmu.step(0.1, tau=8.0)
    assert fmu.get("mode") == STICK


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_impact(make, restitution):
    """No spring, no friction, tau = 0: omega -> -e omega, the loss goes to the stop."""
    values = {"spring.preload": 0.0, "spring.stiffness": 0.0, "cam1.friction": 0.0, "cam2.friction": 0.0}
    values |= {"stop.restitution": restitution, "initial.theta": 1.0, "initial.omega": 2.0}
    fmu = make().start(values)
    fmu.step(0.5)
    late = 0.5 - (1.3963 - 1.0) / 2.0  # since the impact
    assert fmu.get("omega") == pytest.approx(-2.0 * restitution, rel=1e-14)
    assert fmu.get("theta") == pytest.approx(1.3963 - 2.0 * restitution * late, rel=1e-14)
    loss = 0.5 * INERTIA * 4.0 * (1 - restitution**2)
    assert fmu.get("energy.heat_stop") == pytest.approx(loss, rel=1e-14, abs=1e-18)


def test_bouncing_ends(make):
    """Constant torque g J into the upper stop, no friction: bounces last 2 v_n/g with v_n = e^n v_0, so all
    is over after v_0/g (1 + 2 e/(1 - e)), and all energy went into the stop."""
    values = {"spring.preload": 0.0, "spring.stiffness": 0.0, "cam1.friction": 0.0, "cam2.friction": 0.0}
    values |= {"stop.restitution": 0.7, "initial.theta": 1.3963 - 0.1}
    gravity = 50.0  # rad/s2
    fall = math.sqrt(2 * 0.1 / gravity)
    over = fall * (1 + 2 * 0.7 / (1 - 0.7))
    fmu = make().start(values)
    fmu.step(over * 0.999, tau=gravity * INERTIA)
    assert fmu.get("mode") in (LOADING, RELEASING)
    fmu.step(over * 0.002)
    assert (fmu.get("mode"), fmu.get("theta"), fmu.get("omega")) == (UPPER_STOP, 1.3963, 0.0)
    assert fmu.get("energy.heat_stop") == pytest.approx(0.1 * gravity * INERTIA, rel=1e-12)
    events = fmu.get("events")
    fmu.step(10.0)
    assert fmu.get("events") == events


# Section 6: the three regimes
def test_breakaway_under_a_torque_ramp(make):
    """From tau = 1.5 N.m at 0.5 N.m/s the band's upper edge at theta = 0.2, F_0 = 150 N, is reached after
    (150 rho_+ - 1.5)/0.5 s. From there J alpha + K theta = ramp: theta - theta0 = r/K (t - sin(w t)/w) with
    r = 0.5 N.m/s, K = rho_+ k z', w^2 = K/J."""
    fmu = make().start({"initial.theta": 0.2})
    edge = 150 * RHO[1]
    assert edge == pytest.approx(1.98837209302, rel=1e-11)
    breakaway = (edge - 1.5) / 0.5
    fmu.set({"tau": 1.5})
    fmu.set_rates(tau=0.5)
    fmu.step(breakaway * (1 - 1e-12))
    assert (fmu.get("mode"), fmu.get("theta")) == (STICK, 0.2)
    fmu.set({"tau": edge})
    fmu.set_rates(tau=0.5)
    stiffness = RHO[1] * STIFFNESS * LIFT
    w = math.sqrt(stiffness / INERTIA)
    t = 0.03  # within the first swing, 2 pi/w = 0.109 s
    fmu.step(t)
    assert fmu.get("mode") == LOADING
    assert fmu.get("theta") - 0.2 == pytest.approx(0.5 / stiffness * (t - math.sin(w * t) / w), rel=1e-10)
    assert fmu.get("omega") == pytest.approx(0.5 / stiffness * (1 - math.cos(w * t)), rel=1e-11)


def test_half_oscillation_between_two_sticks(make):
    """Constant tau past the upper edge, no damping: half a cosine about the angle where T_load = tau, of
    length pi/w, that ends as far beyond; there tau is inside the band, and it sticks."""
    fmu = make().start({"initial.theta": 0.2})
    stiffness = RHO[1] * STIFFNESS * LIFT
    w = math.sqrt(stiffness / INERTIA)
    tau = 150 * RHO[1] + 1.0
    swing = 1.0 / stiffness
    quarter = 0.5 * math.pi / w
    fmu.step(quarter, tau=tau)
    assert fmu.get("theta") == pytest.approx(0.2 + swing, rel=1e-13)
    assert fmu.get("omega") == pytest.approx(swing * w, rel=1e-13)
    fmu.step(quarter * 0.999999)
    assert fmu.get("mode") == LOADING
    fmu.step(1.0)
    assert fmu.get("mode") == STICK
    assert fmu.get("theta") == pytest.approx(0.2 + 2 * swing, rel=1e-13)
    assert fmu.get("events") == 2
    assert fmu.get("peak.omega") == pytest.approx(swing * w, rel=1e-13)
    # work in = tau times angle; what the spring did not take is friction heat, half in each groove
    spring = 2 * LIFT * swing * (150 + STIFFNESS * LIFT * swing)
    heat = tau * 2 * swing - spring
    assert fmu.get("energy.heat_cam1") == pytest.approx(heat / 2, rel=1e-12)
    assert fmu.get("energy.heat_cam2") == pytest.approx(heat / 2, rel=1e-12)


def test_viscous_motion(make):
    """Without inertia, linear damper: z - z_s = (z0 - z_s) exp(-k t/c), z_s = (tau/rho_+ - F0)/k."""
    fmu = make().start({"inertia.shaft": 0.0, "damper.c_load": 3000.0})
    tau, t = 5.0, 0.04
    z_s = (tau / RHO[1] - PRELOAD) / STIFFNESS
    fmu.step(t, tau=tau)
    left = math.exp(-STIFFNESS * t / 3000.0)
    assert fmu.get("z") == pytest.approx(z_s * (1 - left), rel=1e-13)
    assert fmu.get("v") == pytest.approx(z_s * left * STIFFNESS / 3000.0, rel=1e-12)
    heat = 3000.0 * (z_s * STIFFNESS / 3000.0) ** 2 * (1 - left**2) / (2 * STIFFNESS / 3000.0)
    assert fmu.get("energy.heat_damper") == pytest.approx(heat, rel=1e-12)


def test_braking_return_at_steady_speed(make):
    """Section 4 with no spring rate: released against the damper, v = -(F0 - tau/rho_-)/c, at once without
    inertia."""
    values = {"inertia.shaft": 0.0, "damper.c_release": 2000.0, "spring.stiffness": 0.0, "initial.theta": 1.0}
    fmu = make().start(values)
    fmu.step(0.01, tau=0.1)
    assert fmu.get("v") == pytest.approx(-(PRELOAD - 0.1 / RHO[-1]) / 2000.0, rel=1e-13)
    assert fmu.get("mode") == RELEASING


def test_play(make):
    """Without inertia and damping theta is the play operator of tau: it moves just far enough."""
    fmu = make().start({"inertia.shaft": 0.0})

    def angle(tau, rho):
        return (tau / rho - PRELOAD) / STIFFNESS / LIFT

    history = [(5.0, angle(5.0, RHO[1])), (4.0, angle(5.0, RHO[1])), (6.0, angle(6.0, RHO[1]))]
    history += [(3.0, angle(3.0, RHO[-1])), (3.5, angle(3.0, RHO[-1])), (20.0, 1.3963), (-1.0, 0.0)]
    for tau, theta in history:
        fmu.step(0.1, tau=tau)
        assert fmu.get("theta") == pytest.approx(theta, rel=1e-13, abs=1e-16)
        assert fmu.get("omega") == 0.0
    assert abs(fmu.get("energy.residual")) < 1e-14
    fmu.set({"tau": 1.0})
    fmu.set_rates(tau=10.0)  # and follows a ramp along the edge
    fmu.step(0.2)
    assert fmu.get("theta") == pytest.approx(angle(3.0, RHO[1]), rel=1e-13)
    assert fmu.get("omega") == pytest.approx(10.0 / (RHO[1] * STIFFNESS * LIFT), rel=1e-13)


def test_follower_mass_is_felt_more_when_loading(make):
    """Section 6: M = J + rho m z' + rho kappa_1 I gamma', here with gamma' = 1/2, rho kappa_1 = 1/2."""
    values = {"inertia.follower_mass": 0.5, "inertia.follower": 2e-4, "initial.theta": 0.5}
    values |= {"spring.stiffness": 0.0}
    for tau, rho in ((2.0, RHO[1]), (0.2, RHO[-1])):
        fmu = make().start(values)
        fmu.step(1e-4, tau=tau)
        mass = INERTIA + rho * 0.5 * LIFT + 0.5 * 2e-4 * 0.5
        assert fmu.get("alpha") == pytest.approx((tau - rho * PRELOAD) / mass, rel=1e-12)
        assert min(reactions(fmu)) > 0


def test_power_balance(make):
    """Section 4, at an instant: tau omega = F v + P1 + P2 + J alpha omega, P_i = mu R_i v_i (R_i total)."""
    fmu = make().start({"damper.c_load": 300.0, "shaft.damping": 0.01})
    fmu.step(0.02, tau=6.0)
    assert fmu.get("mode") == LOADING
    omega, v = fmu.get("omega"), fmu.get("v")
    friction = sum(MU * 2 * fmu.get(f"cam{i}.reaction") * fmu.get(f"cam{i}.sliding_speed") for i in (1, 2))
    force = fmu.get("spring.force") + fmu.get("damper.force")
    losses = force * v + friction + 0.01 * omega**2 + INERTIA * fmu.get("alpha") * omega
    assert 6.0 * omega == pytest.approx(losses, rel=1e-12)


# Ledger
def test_ledger_after_a_million_steps(fmu):
    """Energy residual at most 1e-12 of the energy turned over. A torque that sticks, slips both ways and hits
    the stop; the loop is in C (fmpy would need minutes), through the FMU's own functions."""
    import ctypes

    fmu.start()
    set_real, do_step = fmu.library.fmi2SetReal, fmu.library.fmi2DoStep
    from driver import references

    tau, reference, h = ctypes.c_double(), references(["tau"]), 1e-3
    turned_over = 0.0
    for n in range(1_000_000):
        tau.value = 5 + 5 * math.sin(0.031 * n) + 2 * math.sin(0.0017 * n)
        if set_real(fmu.instance, reference, 1, ctypes.byref(tau)) or do_step(fmu.instance, n * h, h, 1):
            pytest.fail(fmu.messages[-1].text)
    turned_over = fmu.get("energy.work_in")
    assert turned_over > 1000.0
    assert abs(fmu.get("energy.residual")) <= 1e-12 * turned_over
    assert fmu.get("events") > 10_000


@pytest.mark.parametrize(("profile", "least", "most"), [(1, 0.0, 1e-14), (2, 1e-14, 1e-9)])
def test_ledger_closes_to_rounding_for_helices_else_to_the_tolerance(make, profile, least, most):
    """As the description of energy.residual says; the default tolerance is 1e-9."""
    fmu = make().start({"cam1.profile": profile, "cam2.profile": profile, "inertia.shaft": 0.01})
    residuals = []
    for n in range(100):
        fmu.step(0.02, tau=6.0 * math.sin(0.04 * math.pi * n))
        residuals.append(abs(fmu.get("energy.residual")))
    assert least <= max(residuals) / fmu.get("energy.work_in") <= most


def test_ledger_does_not_change_the_motion(make):
    with_ledger, without = make().start(), make().start({"ledger": False})
    for n in range(3000):
        for fmu in (with_ledger, without):
            fmu.step(1e-3, tau=5 + 5 * math.sin(0.03 * n))
        assert with_ledger.get("theta").hex() == without.get("theta").hex()
        assert with_ledger.get("omega").hex() == without.get("omega").hex()
    assert without.get("energy.work_in") == without.get("peak.torque") == 0.0


def test_tuning_is_booked(fmu):
    """A tuned spring's jump in stored energy: F0 z + k z^2/2 at z = 0.01."""
    fmu.start({"initial.theta": 1.0})
    fmu.step(0.01, tau=5.0)
    fmu.set({"spring.stiffness": 30e3})
    fmu.set({"spring.preload": 100.0})
    assert fmu.get("energy.work_tuning") == pytest.approx(50 * 0.01 - 0.5 * 20e3 * 0.01**2, rel=1e-13)
    fmu.step(0.05, tau=9.0)
    assert abs(fmu.get("energy.residual")) < 1e-14


def test_peaks_inside_a_long_step(make):
    """Half an oscillation and a stop inside one step: the peaks are those of many short steps."""
    values = {"damper.c_load": 20.0, "inertia.follower_mass": 0.5, "stop.restitution": 0.3}
    fine, coarse = make().start(values), make().start(values)
    for _ in range(40_000):
        fine.step(1e-5, tau=8.0)
    coarse.step(0.4, tau=8.0)
    for name in ("peak.omega", "peak.reaction1", "peak.reaction2", "peak.torque"):
        assert coarse.get(name) == pytest.approx(fine.get(name), rel=1e-9)
        assert coarse.get(name) >= fine.get(name) * (1 - 1e-14)


# Output derivatives
def test_output_derivatives(fmu):
    fmu.start({"inertia.follower_mass": 0.3, "damper.c_load": 100.0})
    fmu.step(0.01, tau=6.0)
    values = {}
    for name in ("theta", "omega", "z", "v"):
        values[name] = fmu.output_derivative(name, 1), fmu.output_derivative(name, 2)
    state = fmu.take()
    h = 1e-4
    samples = {name: [fmu.get(name)] for name in values}
    for _ in range(4):
        fmu.step(h)
        for name, sample in samples.items():
            sample.append(fmu.get(name))
    fmu.free_state(state)
    for name, (s0, s1, s2, s3, s4) in samples.items():
        # one-sided differences of fourth and third order
        first = (-25 * s0 + 48 * s1 - 36 * s2 + 16 * s3 - 3 * s4) / (12 * h)
        second = (35 * s0 - 104 * s1 + 114 * s2 - 56 * s3 + 11 * s4) / (12 * h * h)
        assert values[name][0] == pytest.approx(first, rel=1e-6)
        assert values[name][1] == pytest.approx(second, rel=1e-3)


# Steps
def test_landing_on_any_communication_step(fmu):
    fmu.start()
    time = 0.0
    for h in (1e-9, 1e-300, 0.1, 3.7, 1e3):
        assert fmu.call("fmi2DoStep", time, h, 1) == OK
        time += h


def test_many_events_in_one_step(make):
    """Elastic bouncing between stop and spring, 1 s in one step or in a thousand."""
    values = {"stop.restitution": 1.0, "cam1.friction": 0.0, "cam2.friction": 0.0, "initial.theta": 0.5}
    one, many = make().start(values), make().start(values)
    one.step(1.0)
    for _ in range(1000):
        many.step(1e-3)
    assert one.get("events") == many.get("events") > 10
    assert one.get("theta") == pytest.approx(many.get("theta"), rel=1e-11)
    assert one.get("energy.kinetic") + one.get("energy.spring") == pytest.approx(
        50 * 0.005 + 0.5 * 50e3 * 0.005**2, rel=1e-13
    )
