"""Friction that depends on the reaction (docs/mechanism.md, section 9): the edges of the stick band and the
torque of an imposed motion against SciPy, derivatives, locks, refusals. The motion is in
test_friction_scenes.py."""

import math

import numpy as np
import pytest
import test_model_exchange as exchange
import test_output_derivatives as output_derivatives
import test_step_sensitivity as step_sensitivity
from driver import Driver, models
from friction_scenes import LOADED_FILE, load
from reference import Refused, write_table
from reference.friction import FrictionLaw, LoadedContact, reactions_under, torque_of_symmetric_edge
from reference.parameters import DEFAULTS
from scipy.optimize import brentq
from test_friction_law import STRIBECK, VISCOUS, WEARING, check_output_derivatives, slope
from test_general_accuracy import TOLERANCES, cuts, title, verdict
from test_sensitivity import partial

LOADED = {
    "cam1.friction_load_exponent": 0.3,
    "cam1.friction_load": 80.0,
    "cam2.friction_load_exponent": -0.4,
    "cam2.friction_load": 150.0,
}
GROWING = LOADED | {"cam2.friction_load_exponent": 0.4}
LAW = (
    "friction",
    "friction_peak",
    "stribeck_velocity",
    "friction_viscous",
    "friction_load_exponent",
    "friction_load",
)
TUNED = [f"cam{i}.{name}" for i in (1, 2) for name in LAW]
MASSES = {"inertia.follower_mass": 1.0, "inertia.follower": 1e-4, "cam2.radius": 0.025}

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]


def drawn(rng: np.random.Generator) -> dict:
    p: dict = {"contacts": int(rng.integers(1, 3)), "spring.stiffness2": 1e5}
    for i in (1, 2):
        p |= {
            f"cam{i}.radius": rng.uniform(0.01, 0.03),
            f"cam{i}.lead_angle": rng.uniform(0.5, 0.9),
            f"cam{i}.friction": rng.uniform(0.02, 0.2),
            f"cam{i}.friction_peak": rng.uniform(1.0, 1.5),
            f"cam{i}.stribeck_velocity": 10 ** rng.uniform(-3, -1),
            f"cam{i}.stribeck_exponent": int(rng.integers(1, 3)),
            f"cam{i}.friction_viscous": rng.uniform(0.0, 0.3),
            f"cam{i}.friction_load_exponent": rng.uniform(-0.5, 0.5),
            f"cam{i}.friction_load": 10 ** rng.uniform(1.5, 2.5),
        }
    p |= {"inertia.follower_mass": rng.uniform(0, 2), "inertia.follower": rng.uniform(0, 2e-4)}
    return p | {"shaft.damping": rng.uniform(0, 0.01), "damper.c_load": rng.uniform(0, 50)}


def contacts_of(p: dict, theta_rate: float, sigma: int):
    """Both contacts on the supporting flanks, z' and the sliding distances per angle."""
    full = DEFAULTS | p
    r, s = [full[f"cam{i}.radius"] for i in (1, 2)], [math.tan(full[f"cam{i}.lead_angle"]) for i in (1, 2)]
    a = [r[0] * s[0], r[1] * s[1]]
    turn = [a[1] / sum(a), a[0] / sum(a)]
    sliding = [t * q * math.hypot(1.0, x) for t, q, x in zip(turn, r, s, strict=True)]
    laws = [FrictionLaw.of_cam(full, i) for i in (1, 2)]
    pair = tuple(
        LoadedContact(r[i], s[i], laws[i], abs(theta_rate) * sliding[i], full["contacts"], sigma)
        for i in range(2)
    )
    return pair, a[0] * turn[0], turn, sliding


def required(p: dict, theta: float, omega: float, alpha: float, force: float):
    """Torque, reactions and coefficients on the supporting flanks; None where another answer is due."""
    sigma = 1 if omega > 0 else -1
    pair, dz, turn, sliding = contacts_of(p, omega, sigma)
    z, v = dz * theta, dz * omega
    axial = 50 + 50000 * z + p["spring.stiffness2"] * z**2 + force
    axial += v * (p["damper.c_load"] if omega > 0 else 0.0) + p["inertia.follower_mass"] * dz * alpha
    moment = p["inertia.follower"] * turn[0] * alpha
    try:
        found = reactions_under(pair, axial, moment)
    except Refused:
        return None
    if not all(c.grows(x) for c, x in zip(pair, found, strict=True)):
        return None
    torque = pair[1].torque(found[1]) + p["shaft.damping"] * omega + 0.002 * alpha
    mu = [c.law.at(c.speed, x) for c, x in zip(pair, found, strict=True)]
    return torque, found, mu, [abs(omega) * x for x in sliding]


def test_torque_of_an_imposed_motion(make_model):
    rng, seen = np.random.default_rng(9), 0
    for _ in range(200):
        p = drawn(rng)
        at = {
            "theta": rng.uniform(0.1, 1.2),
            "omega": rng.choice([-1, 1]) * 10 ** rng.uniform(-2, 1),
            "alpha": rng.uniform(-50, 50),
            "F_ext": rng.uniform(-10, 50),
        }
        wanted = required(p, *at.values())
        if wanted is None:
            continue
        seen += 1
        torque, reactions, mu, speeds = wanted
        fmu = make_model(INVERSE).start(p | at)
        assert fmu.get("tau") == pytest.approx(torque, rel=1e-9, abs=1e-12)
        for i in (1, 2):
            assert fmu.get(f"cam{i}.reaction") == pytest.approx(reactions[i - 1], rel=1e-9)
            assert fmu.get(f"cam{i}.friction_coefficient") == pytest.approx(mu[i - 1], rel=1e-9)
            power = mu[i - 1] * reactions[i - 1] * p["contacts"] * speeds[i - 1]
            assert fmu.get(f"cam{i}.friction_power") == pytest.approx(power, rel=1e-9)
    assert seen > 150


@pytest.mark.parametrize("model", [FORWARD, INVERSE])
def test_edges_of_the_stick_band(make_model, model):
    """Both edges take mu(0+, R) with the reactions on the edge, for each its own."""
    rng, seen = np.random.default_rng(11), 0
    for _ in range(60):
        p = drawn(rng) | {"initial.theta" if model is FORWARD else "theta": 0.7}
        fmu = make_model(model).start(p)
        _, dz, _, _ = contacts_of(p, 0.0, 1)
        z = 0.7 * dz
        F_0 = 50 + 50000 * z + 1e5 * z**2
        assert fmu.get("spring.force") == pytest.approx(F_0, rel=1e-12)
        for name, sigma in (("torque_load", 1), ("torque_release", -1)):
            pair, _, _, _ = contacts_of(p, 0.0, sigma)
            found = reactions_under(pair, F_0, 0.0)
            if not all(c.grows(x) for c, x in zip(pair, found, strict=True)):
                continue
            seen += 1
            assert fmu.get(name) == pytest.approx(pair[1].torque(found[1]), rel=1e-11)
        assert fmu.get("efficiency") == pytest.approx(
            fmu.get("torque_release") / fmu.get("torque_load"), rel=1e-12
        )
    assert seen > 100


def test_edges_of_equal_cams_follow_from_one_equation(make_model):
    """Two equal contacts carry half of F_0 each, so that bisection in one unknown gives the edge."""
    for nu in (-0.5, -0.3, 0.3, 0.5):
        p = {f"cam{i}.friction_load_exponent": nu for i in (1, 2)} | {"contacts": 1, "initial.theta": 0.5}
        fmu = make_model(FORWARD).start(p)
        F_0 = fmu.get("spring.force")
        for name, sigma in (("torque_load", 1), ("torque_release", -1)):
            contact = contacts_of(p, 0.0, sigma)[0][0]
            bracket = (F_0 / 4, F_0 * 4)
            assert fmu.get(name) == pytest.approx(torque_of_symmetric_edge(contact, F_0, bracket), rel=1e-12)


def test_band_is_not_in_proportion_to_the_load(make_model):
    p = {f"cam{i}.friction_load_exponent": 0.4 for i in (1, 2)} | {"initial.theta": 0.2}
    ratios = []
    for force in (0.0, 400.0):
        fmu = make_model(FORWARD).start(p | {"F_ext": force})
        ratios.append(fmu.get("torque_load") / (fmu.get("spring.force") + force))
    assert ratios[1] > 1.01 * ratios[0]


# ---- derivatives ----


@pytest.mark.parametrize("omega", [0.3, 4.0, -1.0])
@pytest.mark.parametrize("law", [LOADED, LOADED | STRIBECK, STRIBECK])
def test_directional_derivatives(make_model, law, omega):
    """By states, inputs and all parameters of the law, the exponent at zero included."""
    values = law | MASSES | {"spring.stiffness2": 2e5}
    scenes = (
        (
            FORWARD,
            "alpha",
            {"initial.theta": 0.4, "initial.omega": omega, "tau": 5.0},
            ("theta", "omega", "tau"),
        ),
        (INVERSE, "tau", {"theta": 0.4, "omega": omega, "alpha": 3.0}, ("theta", "omega", "alpha")),
    )
    more = ("F_ext", "spring.preload", "spring.stiffness", "spring.stiffness2", "damper.c_load")
    for model, unknown, at, own in scenes:
        start = values | at

        def one(name: str, value: float, start=start, model=model) -> Driver:
            key = f"initial.{name}" if model is FORWARD and name in ("theta", "omega") else name
            return make_model(model).start(start | {key: value})

        fmu = make_model(model).start(start)
        for known in [*own, *more, *TUNED]:
            if known.endswith(("_peak", "_viscous", "c_load")) and fmu.get(known) in (0.0, 1.0):
                continue  # a difference would leave the range
            found = partial(fmu, unknown, known)
            expected = slope(one, known, fmu.get(known), unknown)
            assert found == pytest.approx(expected, rel=1e-5, abs=1e-7 * abs(fmu.get(unknown))), known


def test_directional_derivatives_without_inertia(make_model):
    start = (
        GROWING | VISCOUS | {"inertia.shaft": 0.0, "initial.theta": 0.4, "tau": 12.0, "damper.c_load": 300.0}
    )

    def one(name: str, value: float) -> Driver:
        key = "initial.theta" if name == "theta" else name
        return make_model(FORWARD).start(start | {key: value})

    fmu = make_model(FORWARD).start(start)
    for known in ["theta", "tau", "F_ext", "spring.preload", "spring.stiffness", "damper.c_load", *TUNED]:
        if known.endswith("_peak"):
            continue
        found, expected = partial(fmu, "alpha", known), slope(one, known, fmu.get(known), "alpha")
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-7 * abs(fmu.get("alpha"))), known


def test_directional_derivatives_with_an_elastic_shaft(make_model):
    start = LOADED | {"shaft.stiffness": 40.0, "theta": 0.6}

    def one(name: str, value: float) -> Driver:
        fmu = make_model(INVERSE).start(start | ({} if name == "theta" else {name: value}))
        fmu.set({"theta": 0.8 if name != "theta" else value})
        return fmu

    fmu = make_model(INVERSE).start(start)
    fmu.set({"theta": 0.8, "omega": 1.0})
    assert fmu.get("mode") == 2
    for known in ["theta", "F_ext", "spring.stiffness", "cam1.friction", *TUNED[4:6], *TUNED[-2:]]:
        if known.endswith(("friction_viscous", "velocity")):
            continue
        found, expected = partial(fmu, "tau", known), slope(one, known, fmu.get(known), "tau")
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-7 * abs(fmu.get("tau"))), known


REGIMES = {
    "inertial": output_derivatives.REGIMES["inertial"] | STRIBECK | LOADED,
    "viscous": output_derivatives.REGIMES["viscous"] | GROWING,
    "viscous by friction": VISCOUS | GROWING,
    "rate-independent": LOADED,
}


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("groove", ["helices", "ellipses"])
def test_output_derivatives(make_model, groove, regime, direction):
    check_output_derivatives(make_model, groove, regime, REGIMES[regime], direction)


Scene = step_sensitivity.Scene
SCENES = {
    "slip": Scene(step_sensitivity.SLIP | LOADED, 6.0, 0.01, size=1e-3),
    "slip, all laws": Scene(step_sensitivity.SLIP | LOADED | STRIBECK, 6.0, 0.01, size=1e-3),
    "slip, ellipses": Scene(step_sensitivity.SLIP | LOADED | step_sensitivity.ELLIPSES, 6.0, 0.01, size=1e-3),
    "to rest": Scene(step_sensitivity.SLIP | LOADED, 3.0, 0.05, mode=1, events=1, size=1e-3),
    "breakaway": Scene(step_sensitivity.REST | LOADED, 3.0, 0.03, (100.0,), events=1, size=1e-4),
    "viscous": Scene(
        step_sensitivity.REST | step_sensitivity.MASSLESS | GROWING | {"damper.c_load": 500.0}, 7.0, 0.02
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_step_sensitivity(make_model, name):
    step_sensitivity.check(make_model, SCENES[name])


# ---- the motion ----


def test_power_is_the_rate_of_the_heat(make_model):
    fmu = make_model(FORWARD).start(LOADED | STRIBECK | MASSES | {"initial.theta": 0.2, "initial.omega": 3.0})
    h = 1e-6
    fmu.step(0.01, tau=6.0)
    before = [fmu.get(f"energy.heat_cam{i}") for i in (1, 2)]
    fmu.step(h, tau=6.0)
    power = [fmu.get(f"cam{i}.friction_power") for i in (1, 2)]
    for i in (1, 2):
        assert (fmu.get(f"energy.heat_cam{i}") - before[i - 1]) / h == pytest.approx(power[i - 1], rel=1e-4)


GROOVES = {"helices": {}, "ellipses": step_sensitivity.ELLIPSES}
INERTIAS = {
    "inertial": LOADED,
    "viscous": GROWING | {"inertia.shaft": 0.0, "damper.c_load": 300.0, "damper.c_release": 200.0},
    "viscous by friction": GROWING | {"inertia.shaft": 0.0} | VISCOUS,
    "rate-independent": LOADED | {"inertia.shaft": 0.0},
}


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("regime", INERTIAS)
def test_ledger_closes_and_cuts_change_nothing(make_model, groove, regime):
    """Loading, rest, releasing, stops; the heat is the integral of the friction power. 200 short steps end
    where five long ones end. At the last torque the spring moves the mechanism back at some speed."""
    values = INERTIAS[regime] | GROOVES[groove] | WEARING
    long, short = (make_model(FORWARD).start(values) for _ in range(2))
    for tau in (6.0, 14.0, 4.0, 9.0, 3.0 if regime == "viscous by friction" else 0.0):
        long.step(0.08, tau=tau)
        for _ in range(40):
            short.step(0.002, tau=tau)
        for name, size in (("theta", 1.0), ("omega", 100.0), ("energy.heat_cam1", 3.0), ("wear.cam2", 1e-12)):
            assert abs(long.get(name) - short.get(name)) <= 1e-8 * size, name
        assert long.get("mode") == short.get("mode")
    assert abs(long.get("energy.residual")) <= 1e-8 * long.get("energy.work_in")
    assert long.get("energy.heat_cam1") > 0.1


@pytest.mark.parametrize("regime", INERTIAS)
def test_rest_ends_where_the_torque_leaves_the_band(make_model, regime):
    """F_ext grows while cam 2 rests: the band's edge is no straight line of the time."""
    p = INERTIAS[regime] | {"initial.theta": 0.4, "tau": 12.0}
    fmu = make_model(FORWARD).start(p | {"F_ext": 900.0})
    full = p | {"cam1.radius": 0.02, "cam2.radius": 0.02}
    assert fmu.get("mode") == 1
    spring = fmu.get("spring.force")

    def excess(t: float) -> float:
        pair, _, _, _ = contacts_of(full, 0.0, 1)
        return 12.0 - pair[1].torque(reactions_under(pair, spring + 900.0 - 2000.0 * t, 0.0)[1])

    start = brentq(excess, 0.0, 0.4, xtol=1e-14)
    fmu.set_derivatives({"F_ext": [-2000.0]})
    fmu.step(start * (1 - 1e-9))
    assert (fmu.get("mode"), fmu.get("omega"), fmu.get("events")) == (1, 0.0, 0)
    fmu.set_derivatives({"F_ext": [-2000.0]})
    fmu.step(start * 2e-9, F_ext=900.0 - 2000.0 * start * (1 - 1e-9))
    assert fmu.get("mode") == 2


def test_cvode_sees_no_chatter(calls):
    scene = [(0.0, 0.0), (0.05, 12.0), (0.3, 3.0), (0.6, 30.0), (0.8, -5.0)]
    wanted = exchange.simulate("CoSimulation", LOADED | STRIBECK, scene, 1e-11)
    found = exchange.simulate("ModelExchange", LOADED | STRIBECK, scene, 1e-9)
    for name, size in exchange.SIZE.items():
        assert np.abs(found[name] - wanted[name]).max() / size <= 1e-5
    assert calls["enterEventMode"] <= wanted["events"][-1] + 2 * len(scene)
    assert calls["getDerivatives"] <= 3_000


calls = exchange.calls


def test_motion_off_a_dwell_closes_the_ledger(make_model, tmp_path):
    """Without inertia. Near the dwell friction resists the motion, and the damper hardly does."""
    table = tmp_path / "groove.csv"
    write_table(table, [-1.01, -0.64, -0.27, 0.1], [0.0, 0.006, 0.012, 0.012])
    p = {"cam1.profile": 3, "cam1.table": str(table), "cam1.radius": 0.01, "cam1.friction": 0.1}
    p |= {"cam1.friction_viscous": 1.0, "cam1.friction_load_exponent": 0.5, "cam1.friction_load": 1.0}
    p |= {"cam2.radius": 0.01, "cam2.lead_angle": 0.25, "cam2.friction": 0.0, "inertia.shaft": 0.0}
    p |= {"spring.preload": -1.0, "spring.stiffness": 100.0, "damper.c_load": 1.0, "damper.c_release": 1.0}
    p |= {"stop.lower": -1.0, "stop.upper": 0.1, "tau": -0.00132, "F_ext": -1.0}
    fmu = make_model(FORWARD).start(p)
    fmu.step(1.0)
    assert fmu.get("theta") < -0.272
    assert abs(fmu.get("energy.residual")) < 1e-9 * fmu.get("energy.work_in")


def test_imposed_motion_closes_the_ledger(make_model):
    for shaft in ({}, {"shaft.stiffness": 60.0}):
        fmu = make_model(INVERSE).start(LOADED | WEARING | shaft)
        for k in range(200):
            t = 0.01 * (k + 1)
            angle = 0.6 * (1 - math.cos(3 * t))
            fmu.step(0.01, theta=angle, omega=1.8 * math.sin(3 * t), alpha=5.4 * math.cos(3 * t))
        assert fmu.get("energy.heat_cam1") > 0.1
        assert abs(fmu.get("energy.residual")) <= 1e-8 * fmu.get("energy.heat_cam1")


# ---- tuning and states ----


def test_tuning_changes_the_law_at_once(make_model):
    fmu = make_model(FORWARD).start({"initial.theta": 0.3, "initial.omega": 2.0})
    fmu.step(0.005, tau=6.0)
    fmu.set(LOADED)
    state = {"initial.theta": fmu.get("theta"), "initial.omega": fmu.get("omega")}
    other = make_model(FORWARD).start(LOADED | state)
    for one in (fmu, other):
        one.step(0.01, tau=6.0)
    for name in ("theta", "cam1.friction_coefficient", "cam2.friction_coefficient"):
        assert fmu.get(name) == pytest.approx(other.get(name), rel=1e-9)


def test_a_restored_run_repeats(make_model):
    fmu = make_model(FORWARD).start(LOADED | STRIBECK | WEARING)
    fmu.step(0.05, tau=9.0)
    state = fmu.take()
    runs = []
    for _ in range(2):
        fmu.restore(state)
        fmu.time = 0.05
        fmu.step(0.02, tau=11.0)
        runs.append([fmu.get(n) for n in ("theta", "omega", "wear.cam1", "energy.heat_cam2")])
    assert runs[0] == runs[1]


# ---- locks and refusals ----


def test_contact_locks_above_a_load(make_model):
    """T = R (s - mu(R)) of a releasing contact grows up to mu (1 + nu) = s. Beyond, two reactions give one
    torque: the spring does not drive the mechanism back, whatever its force."""
    p = {f"cam{i}.friction_load_exponent": 0.5 for i in (1, 2)} | {f"cam{i}.lead_angle": 0.35 for i in (1, 2)}
    p |= {"initial.theta": 0.3, "tau": 0.0, "contacts": 1}
    contact = contacts_of(p, 0.0, -1)[0][0]
    largest = brentq(lambda r: contact.lead - contact.law.tangent(0.0, r), 1.0, 1e6)
    F_0 = 2 * contact.axial(largest)
    spring = make_model(FORWARD).start(p).get("spring.force")
    below, above = (make_model(FORWARD).start(p | {"F_ext": F_0 * k - spring}) for k in (1 - 1e-6, 1 + 1e-6))
    assert below.get("torque_release") == pytest.approx(contact.torque(largest), rel=1e-9)
    assert below.get("torque_release") > 0
    assert above.get("torque_release") <= 0
    assert (below.get("mode"), above.get("mode")) == (3, 6)
    above.step(0.1, tau=0.0, F_ext=F_0 * (1 + 1e-6) - spring)
    assert above.get("theta") == 0.3


def test_lubrication_moves_the_lock(make_model):
    """With mu_v v the lock is at s = mu + nu (mu - mu_v v): the lubricated part has no load in it."""
    p = {f"cam{i}.friction_load_exponent": 0.5 for i in (1, 2)} | {f"cam{i}.lead_angle": 0.35 for i in (1, 2)}
    p |= {f"cam{i}.friction_viscous": 1.0 for i in (1, 2)} | {"theta": 0.3, "contacts": 1, "omega": -2.0}
    contact = contacts_of(p, 2.0, -1)[0][0]
    assert contact.law.viscous * contact.speed > 0.01
    largest = brentq(lambda r: contact.lead - contact.law.tangent(contact.speed, r), 1.0, 1e6)
    F_0 = 2 * contact.axial(largest)
    spring = make_model(INVERSE).start(p).get("spring.force")
    fmu = make_model(INVERSE).start(p | {"F_ext": F_0 * (1 - 1e-6) - spring})
    assert fmu.get("tau") == pytest.approx(contact.torque(largest), rel=1e-9)
    fmu.set({"F_ext": F_0 * (1 + 1e-6) - spring})
    assert fmu.try_get(["tau"])[0] == 3


def test_jam_under_the_spring_is_refused(make_model):
    fmu = make_model(FORWARD)
    fmu.set({f"cam{i}.friction_load_exponent": 0.6 for i in (1, 2)} | {"contacts": 1})
    fmu.setup()
    fmu.ok("fmi2EnterInitializationMode")
    text = fmu.refused_start()
    assert "jam" in text and "cam1.friction_load_exponent" in text


def test_friction_that_falls_with_the_load_needs_inertia_or_no_damping(make_model):
    fmu = make_model(FORWARD)
    fmu.set({"cam2.friction_load_exponent": -0.2, "inertia.shaft": 0.0, "damper.c_load": 10.0})
    fmu.setup()
    fmu.ok("fmi2EnterInitializationMode")
    text = fmu.refused_start()
    assert "cam2.friction_load_exponent" in text and "inertia" in text


@pytest.mark.parametrize("value", [-0.91, 0.91, math.nan])
def test_exponent_out_of_range(make_model, value):
    make_model(FORWARD).refused_set(
        {"cam1.friction_load_exponent": value}, mentions=("cam1.friction_load_exponent", "0.9")
    )


# ---- random scenes, solved by the reference (friction_scenes.py) ----


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    return load(tmp_path_factory.mktemp("tables"), LOADED_FILE)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_random_scenes(tolerance, make_model, scenes):
    """Error at most ten times the tolerance; helices, ellipses and tables, exponents of both signs."""
    wrong = []
    for scene in scenes:
        rng = np.random.default_rng([1, scene.number])
        found = verdict(make_model(FORWARD), scene, tolerance, lambda d, rng=rng: cuts(rng, d))
        wrong += [f"{title(scene)}: {text}" for text in found[:4]]
    assert not wrong, "\n".join(wrong)


def test_random_scenes_are_varied(scenes):
    exponents = [s.params.get(f"cam{i}.friction_load_exponent", 0.0) for s in scenes for i in (1, 2)]
    assert len(scenes) == 200 and min(exponents) < -0.3 and max(exponents) > 0.3
    assert {s.params.get("cam1.profile", 1) for s in scenes} == {1, 2, 3}
