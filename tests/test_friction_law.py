"""Friction that depends on the sliding speed or on the load, and wear (docs/mechanism.md, sections 9 and 10):
outputs, derivatives in time, tuning, refusals. The motion is in test_friction_scenes.py, the torque of an
imposed motion and partial derivatives are in test_friction_load.py."""

import math

import numpy as np
import pytest
import test_model_exchange as exchange
import test_output_derivatives as output_derivatives
import test_step_sensitivity as step_sensitivity
from driver import models
from reference.friction import FrictionLaw
from reference.parameters import DEFAULTS

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
STRIBECK = {
    "cam1.friction_peak": 1.6,
    "cam1.stribeck_velocity": 0.03,
    "cam1.friction_viscous": 0.3,
    "cam2.friction_peak": 1.3,
    "cam2.stribeck_velocity": 0.02,
    "cam2.stribeck_exponent": 1,
    "cam2.friction_viscous": 0.05,
}
LOADED = {
    "cam1.friction_load_exponent": 0.3,
    "cam1.friction_load": 80.0,
    "cam2.friction_load_exponent": -0.4,
    "cam2.friction_load": 150.0,
}
LAWS = {"of speed": STRIBECK, "of load": LOADED, "of both": STRIBECK | LOADED}
of_each_law = pytest.mark.parametrize("laws", LAWS.values(), ids=LAWS)
WEARING = {"cam1.wear": 2e-13, "cam2.wear": 5e-13}
# ---- the coefficient ----


@pytest.mark.parametrize("model", [FORWARD, INVERSE], ids=["forward", "inverse"])
def test_power_of_both_grooves_is_the_sum(make_model, model):
    moving = (
        {"initial.theta": 0.3, "initial.omega": 2.0} if model is FORWARD else {"theta": 0.3, "omega": 2.0}
    )
    fmu = make_model(model).start({"cam2.radius": 0.025, "cam2.friction": 0.2, **moving})
    powers = [fmu.get(f"cam{i}.friction_power") for i in (1, 2)]
    assert min(powers) > 0.0 and powers[0] != powers[1]
    assert fmu.get("friction.power") == sum(powers)


def test_band_has_the_static_coefficients(make_model):
    static = {f"cam{i}.friction": 0.14 * STRIBECK[f"cam{i}.friction_peak"] for i in (1, 2)}
    for model in (FORWARD, INVERSE):
        at = {"initial.theta": 0.5} if model is FORWARD else {"theta": 0.5}
        laws, coulomb = (make_model(model).start(p | at) for p in (STRIBECK, static))
        for name in ("torque_load", "torque_release", "efficiency"):
            assert laws.get(name) == coulomb.get(name)
        assert [laws.get(f"cam{i}.friction_coefficient") for i in (1, 2)] == list(static.values())


def test_breaks_away_at_the_static_and_slips_at_the_kinetic_torque(make_model):
    """From just beyond the edge the cam runs away until friction has fallen."""
    fmu = make_model(FORWARD).start(STRIBECK | {"initial.theta": 0.5})
    edge = fmu.get("torque_load")
    fmu.step(0.01, tau=edge * (1 - 1e-9))
    assert (fmu.get("mode"), fmu.get("omega")) == (1, 0.0)
    fastest = 0.0
    for _ in range(300):
        fmu.step(0.0005, tau=edge * (1 + 1e-3))
        fastest = max(fastest, fmu.get("omega"))
        for i in (1, 2):
            expected = FrictionLaw.of_cam(DEFAULTS | STRIBECK, i).at(fmu.get(f"cam{i}.sliding_speed"))
            assert fmu.get(f"cam{i}.friction_coefficient") == pytest.approx(expected, rel=1e-14)
    # the fall of friction carries the cam far beyond the angle that holds the torque
    coulomb = make_model(FORWARD).start({"initial.theta": 0.5})
    coulomb.step(0.01, tau=coulomb.get("torque_load") * (1 + 1e-3))
    assert fastest > 0.05
    assert fmu.get("mode") == 1 and fmu.get("theta") - 0.5 > 4 * (coulomb.get("theta") - 0.5) > 0


# ---- wear ----


def test_wear_under_coulomb_friction_follows_the_heat(make_model):
    """V_i = K_i heat_i/(n mu_i), in every way to spend time: closed form, collocation, play, bounces."""
    grooves = {"cam1.profile": 2, "cam1.lead_angle": 0.8, "cam2.profile": 2, "cam2.lead_angle": 0.7}
    scenes = [{}, grooves, {"inertia.shaft": 0.0}, grooves | {"inertia.shaft": 0.0}]
    scenes += [{"inertia.shaft": 0.0, "damper.c_load": 300.0, "damper.c_release": 300.0}, {"contacts": 1}]
    for scene in scenes:
        fmu = make_model(FORWARD).start(scene | WEARING)
        plain = make_model(FORWARD).start(scene)
        for tau in (3.0, 9.0, 4.0, 12.0, 0.5):
            for one in (fmu, plain):
                one.step(0.08, tau=tau)
            assert fmu.get("theta") == plain.get("theta")
        for i in (1, 2):
            heat = fmu.get(f"energy.heat_cam{i}")
            expected = WEARING[f"cam{i}.wear"] * heat / (scene.get("contacts", 2) * 0.14)
            assert fmu.get(f"wear.cam{i}") == pytest.approx(expected, rel=1e-9)
            assert heat > 0.01 and plain.get(f"wear.cam{i}") == 0.0


def test_a_friction_that_hardly_brakes_books_its_heat(make_model):
    """The same law: heat_i = n mu_i V_i/K_i. The energy balance of a step is blind to so small a heat."""
    friction = {"cam1.friction": 1e-12, "cam2.friction": 3e-12}
    grooves = {f"cam{i}.profile": 2 for i in (1, 2)} | {"inertia.follower_mass": 0.3}
    start = {"initial.theta": 0.1, "initial.omega": 5.0}
    fmu = make_model(FORWARD).start(friction | grooves | WEARING | start)
    for _ in range(5):
        fmu.step(0.001, tau=3.0)
    assert fmu.get("omega") > 1.0
    for i in (1, 2):
        heat = 2 * friction[f"cam{i}.friction"] * fmu.get(f"wear.cam{i}") / WEARING[f"cam{i}.wear"]
        assert fmu.get(f"energy.heat_cam{i}") == pytest.approx(heat, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("extra", [{}, {"shaft.stiffness": 30.0}, {"cam1.friction": 0.0}])
def test_wear_of_an_imposed_motion(make_model, extra):
    fmu = make_model(INVERSE).start(WEARING | extra)
    for k in range(1, 41):
        angle = k * math.pi / 20
        fmu.step(0.01, theta=0.5 * (1 - math.cos(angle)), omega=0.25 * math.pi / 0.05 * math.sin(angle))
    for i in (1, 2):
        mu = extra.get(f"cam{i}.friction", 0.14)
        heat, wear = fmu.get(f"energy.heat_cam{i}"), fmu.get(f"wear.cam{i}")
        assert wear > 0.0
        if mu > 0:
            assert wear == pytest.approx(WEARING[f"cam{i}.wear"] * heat / (2 * mu), rel=1e-8)


def test_wear_where_friction_varies(make_model):
    """Reaction times sliding speed, summed by the trapezoidal rule over short steps."""
    fmu = make_model(FORWARD).start(STRIBECK | WEARING | {"initial.theta": 0.2, "initial.omega": 3.0})
    rates, h = [], 2e-5
    for _ in range(1000):
        rates.append([fmu.get(f"cam{i}.reaction") * fmu.get(f"cam{i}.sliding_speed") for i in (1, 2)])
        fmu.step(h, tau=6.0)
    rates.append([fmu.get(f"cam{i}.reaction") * fmu.get(f"cam{i}.sliding_speed") for i in (1, 2)])
    sums = np.trapezoid(rates[1:], dx=h, axis=0)
    first = np.array(rates[1]) * h
    for i in (1, 2):
        wear = fmu.get(f"wear.cam{i}") / WEARING[f"cam{i}.wear"]
        assert wear == pytest.approx(sums[i - 1] + first[i - 1], rel=2e-3)


@of_each_law
def test_power_is_the_rate_of_the_heat(make_model, laws):
    masses = {"inertia.follower_mass": 1.0, "inertia.follower": 1e-4, "cam2.radius": 0.025}
    fmu = make_model(FORWARD).start(laws | masses | {"initial.theta": 0.2, "initial.omega": 3.0})
    h = 1e-6
    fmu.step(0.01, tau=6.0)
    before = [fmu.get(f"energy.heat_cam{i}") for i in (1, 2)]
    fmu.step(h, tau=6.0)
    power = [fmu.get(f"cam{i}.friction_power") for i in (1, 2)]
    for i in (1, 2):
        assert (fmu.get(f"energy.heat_cam{i}") - before[i - 1]) / h == pytest.approx(power[i - 1], rel=1e-4)


# ---- derivatives ----


REGIMES = {
    "inertial": output_derivatives.REGIMES["inertial"] | STRIBECK,
    "inertial, both laws": output_derivatives.REGIMES["inertial"] | STRIBECK | LOADED,
    "rate-independent": LOADED,
}


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("groove", ["helices", "ellipses"])
def test_output_derivatives(make_model, groove, regime, direction):
    base = output_derivatives.LINEAR | output_derivatives.CURVED | output_derivatives.GROOVES[groove]
    step = output_derivatives.H["inertial" if regime.startswith("inertial") else "viscous"]
    output_derivatives.check_slip(make_model, base | REGIMES[regime], direction, 0.3 * step)


SCENES = {
    f"{name}, {word}": scene
    for word, laws in LAWS.items()
    for name, scene in step_sensitivity.scenes_of_law(laws).items()
}


@pytest.mark.parametrize("name", SCENES)
def test_step_sensitivity(make_model, name):
    step_sensitivity.check(make_model, SCENES[name])


# ---- model exchange ----


@pytest.mark.parametrize("laws", ["of speed", "of both"])
def test_cvode_sees_no_chatter(calls, laws):
    exchange.check_no_chatter(LAWS[laws], calls, 3_000)


calls = exchange.calls


# ---- tuning, states, refusals ----


@of_each_law
def test_tuning_changes_the_law_at_once(make_model, laws):
    """A law tuned during a run gives the run that a start with this law at the same state gives."""
    fmu = make_model(FORWARD).start({"initial.theta": 0.3, "initial.omega": 2.0})
    fmu.step(0.005, tau=6.0)
    fmu.set(laws)
    state = {"initial.theta": fmu.get("theta"), "initial.omega": fmu.get("omega")}
    other = make_model(FORWARD).start(laws | state)
    for one in (fmu, other):
        one.step(0.01, tau=6.0)
    for name in ("theta", "cam1.friction_coefficient", "cam2.friction_coefficient"):
        assert fmu.get(name) == pytest.approx(other.get(name), rel=1e-9)


@of_each_law
def test_a_restored_run_repeats(make_model, laws):
    fmu = make_model(FORWARD).start(laws | WEARING)
    fmu.step(0.05, tau=9.0)
    state = fmu.take()
    runs = []
    for _ in range(2):
        fmu.restore(state)
        fmu.time = 0.05
        fmu.step(0.02, tau=11.0)
        runs.append([fmu.get(n) for n in ("theta", "omega", "wear.cam1", "energy.heat_cam2")])
    assert runs[0] == runs[1]


REFUSED = {
    "without inertia": (FORWARD, {"cam2.friction_peak": 1.5, "inertia.shaft": 0.0}, "inertia"),
    "lubricated, without inertia": (FORWARD, {"cam1.friction_viscous": 0.4, "inertia.shaft": 0.0}, "inertia"),
    "elastic shaft": (INVERSE, {"cam1.friction_peak": 1.5, "shaft.stiffness": 50.0}, "shaft.stiffness"),
    "jam at rest": (FORWARD, {"cam1.friction": 0.5, "cam2.friction": 0.6, "cam1.friction_peak": 4.0}, "jam"),
    "jam under the spring": (
        FORWARD,
        {f"cam{i}.{n}": v for i in (1, 2) for n, v in (("lead_angle", 1.2), ("friction_load_exponent", 0.9))},
        "friction",
    ),
    # its force is part of the load: the coefficient would depend on the unknown speed
    "load and damper, without inertia": (
        FORWARD,
        {"cam2.friction_load_exponent": -0.2, "inertia.shaft": 0.0, "damper.c_load": 10.0},
        "inertia.shaft",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(make_model, name):
    model, values, word = REFUSED[name]
    fmu = make_model(model)
    text = fmu.refused_start(values)
    assert word in text
    assert next(n for n in values if n.startswith("cam")) in text


def test_tuning_that_is_refused_changes_nothing(make_model):
    fmu = make_model(FORWARD).start({"inertia.shaft": 0.0})
    fmu.step(0.01, tau=3.0)
    before = fmu.get("theta")
    assert fmu.try_set({"cam1.friction_peak": 1.2}) == 3
    assert "cam1.friction_peak" in fmu.messages[-1].text
    fmu.step(0.01, tau=3.0)
    assert fmu.get("theta") == before
