"""The FMI 3.0 FMUs: the same mechanism as those of FMI 2.0, and what FMI 3.0 has of its own."""

import ctypes
import math
import re
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from ctypes import byref, c_bool, c_double, c_int, c_int32, c_size_t, c_uint, c_void_p
from pathlib import Path

import build_fmu
import driver as fmi2
import driver3
import fmpy
import numpy as np
import pytest
from driver import ERROR, OK, ROOT
from driver3 import CONSTANT, DEPENDENT, FORWARD, INVERSE, OTHER, Driver, models
from lxml import etree
from mechanisms import INERTIA, LIFT, PRELOAD, RHO, STIFFNESS
from reference import LOADING, LOWER_STOP, RELEASING, STICK, UPPER_STOP

SCHEMAS = Path(fmpy.__file__).parent / "schema/fmi3"
MODE_CHANGES_MEET = 1e-9  # s: to the default tolerance, times of order 1 s

each_model = pytest.mark.parametrize("model", models.values(), ids=repr)


@pytest.fixture(scope="session")
def unzipped3(tmp_path_factory):
    places = {}
    for model in models.values():
        places[model.identifier] = tmp_path_factory.mktemp(f"unzipped3-{model.identifier}")
        with zipfile.ZipFile(model.fmu) as archive:
            archive.extractall(places[model.identifier])
    return places


@pytest.fixture(scope="session")
def libraries3(unzipped3):
    return {
        name: driver3.load(place / "binaries/x86_64-linux" / f"{name}.so")
        for name, place in unzipped3.items()
    }


@pytest.fixture
def make3(libraries3):
    """Instances of the FMI 3.0 FMUs, freed at the end of the test."""
    made = []

    def make_one(model=FORWARD, **options):
        made.append(Driver(libraries3[model.identifier], model, **options))
        assert made[-1].instance, made[-1].messages
        return made[-1]

    yield make_one
    for driver in made:
        driver.free()


# ---- scenes ----

ELLIPSES = {"cam1.profile": 2, "cam2.profile": 2, "stop.upper": 0.6}
FORCES = {
    "spring.stiffness3": 1e6, "damper.c_load": 20.0, "damper.q_release": 5.0, "inertia.follower_mass": 0.3,
    "inertia.follower": 1e-4, "shaft.damping": 0.001,
}  # fmt: skip
GENERAL = ELLIPSES | FORCES
BOUNCING = {"stop.restitution": 0.6}


def frequency(sigma: int) -> float:
    """Of the oscillation about the balance, rad/s."""
    return math.sqrt(RHO[sigma] * STIFFNESS * LIFT / INERTIA)


def balance(sigma: int, tau: float) -> float:
    """rad, where spring and friction hold tau."""
    return (tau / RHO[sigma] - PRELOAD) / (STIFFNESS * LIFT)


def wave(t: float) -> float:
    """N.m: sticks, slips both ways, meets the lower stop."""
    return 2.5 + 2.5 * math.sin(2 * math.pi * 7 * t)


# ---- the same mechanism as in FMI 2.0 ----


@pytest.mark.parametrize("scene", [{}, GENERAL, BOUNCING, {"inertia.shaft": 0.0}], ids=str)
def test_co_simulation_is_bit_for_bit_that_of_fmi2(make_model, make3, scene):
    old, new = make_model(fmi2.FORWARD).start(scene), make3().start(scene)
    modes = set()
    for k in range(400):
        h = 1e-3 * (1 + k % 3)
        inputs = {"tau": wave(new.time), "F_ext": 3.0 * (k % 5)}
        old.step(h, **inputs)
        assert new.step(h, **inputs) == (False, False)
        assert new.get("time") == new.time
        for name in fmi2.FORWARD.variables:
            if k % 20 == 0 or name in ("theta", "omega", "mode", "energy.residual"):
                assert new.get(name) == old.get(name), (name, k)
        modes.add(new.get("mode"))
    assert (modes & {LOWER_STOP, UPPER_STOP} or new.get("energy.heat_stop") > 0) and len(modes) >= 2


@pytest.mark.parametrize("stiffness", [0.0, 20.0])
def test_inverse_co_simulation_is_bit_for_bit_that_of_fmi2(make_model, make3, stiffness):
    scene = FORCES | {"shaft.stiffness": stiffness}
    old = make_model(fmi2.models["DualCamInverse"]).start(scene)
    new = make3(INVERSE).start(scene)
    for _ in range(200):
        new.set({"F_ext": 2.0})
        t = new.time + 1e-3
        motion = {"theta": 0.4 * (1 - math.cos(40 * t)), "omega": 16.0 * math.sin(40 * t), "F_ext": 2.0}
        old.step(1e-3, **motion)
        new.step(1e-3, **motion)
        for name in fmi2.models["DualCamInverse"].variables:
            assert new.get(name) == old.get(name), name


def simulate(model, kind: str, **options):
    options = {"stop_time": 0.2, "output_interval": 1e-3, "relative_tolerance": 1e-9} | options
    if kind == "CoSimulation":
        options |= {"step_size": 1e-3}
    return fmpy.simulate_fmu(str(model.fmu), fmi_type=kind, validate=True, **options)


@pytest.mark.parametrize("scene", [{}, {"cam1.profile": 2, "cam2.profile": 2}], ids=["helices", "ellipses"])
def test_model_exchange_agrees_with_co_simulation(scene):
    """Through FMPy, CVode against the FMU's own integrator, with a constant torque: slip, then stick."""
    start = {"tau": 2.0, "damper.c_load": 50.0, "damper.c_release": 50.0, **scene}
    found = [
        simulate(FORWARD, kind, start_values=start, output=["theta", "omega", "mode", "alpha"])
        for kind in ("CoSimulation", "ModelExchange")
    ]
    own, outer = found
    outer = outer[np.searchsorted(outer["time"], own["time"] - 1e-12, side="left")]
    assert np.max(np.abs(own["theta"] - np.interp(own["time"], found[1]["time"], found[1]["theta"]))) < 1e-6
    assert own["mode"][-1] == found[1]["mode"][-1] == STICK
    assert LOADING in own["mode"]


def test_model_exchange_of_the_inverse_fmu():
    times = np.linspace(0, 0.2, 201)
    angle = 20 * math.pi * times
    columns = [
        times,
        0.4 * (1 - np.cos(angle)),
        8 * math.pi * np.sin(angle),
        160 * math.pi**2 * np.cos(angle),
    ]
    given = np.rec.fromarrays([*columns, 0 * times], names=["time", "theta", "omega", "alpha", "F_ext"])
    own, outer = (
        simulate(INVERSE, kind, input=given, output=["tau"]) for kind in ("CoSimulation", "ModelExchange")
    )
    # co-simulation reaches what is set before a step at its end: one row later
    rows = np.searchsorted(outer["time"], own["time"][40:45])
    assert np.allclose(own["tau"][41:46], outer["tau"][rows], rtol=1e-9, atol=1e-9)


# ---- event mode and early return ----


def events_of(fmu, until: float, h: float, torque) -> list[tuple[float, int]]:
    """Time and mode after each early return, the torque constant over each step of h."""
    found = []
    while fmu.time < until - 1e-12:
        goal = min(until, (math.floor(fmu.time / h + 1e-9) + 1) * h)
        event, early = fmu.step(goal - fmu.time, tau=torque(goal - h))
        assert event or not early
        if event:
            found.append((fmu.time, fmu.get("mode")))
            assert fmu.handle_event()["again"] is False
    return found


def test_early_return_is_at_the_time_of_the_closed_form(make3):
    """Swing up under a constant torque to velocity zero, half a period later; then released onto the stop."""
    fmu = make3(events=True, early=True).start()
    event, early = fmu.step(1.0, tau=2.0)
    rest = math.pi / frequency(1)
    assert (event, early) == (True, True)
    assert fmu.time == pytest.approx(rest, rel=1e-13)
    assert fmu.get("time") == fmu.time
    assert (fmu.get("mode"), fmu.get("omega")) == (STICK, 0.0)
    top = 2 * balance(1, 2.0)
    assert fmu.get("theta") == pytest.approx(top, rel=1e-13)
    assert fmu.handle_event() == dict.fromkeys(("again", "terminate", "nominals", "moved", "timed"), False)
    assert fmu.step(0.1, tau=2.0) == (False, False)  # it holds
    assert fmu.time == pytest.approx(rest + 0.1, rel=1e-15)
    start = fmu.time
    assert fmu.step(1.0, tau=0.0) == (True, True)
    low = balance(-1, 0.0)
    fall = math.acos(low / (low - top)) / frequency(-1)
    assert fmu.time - start == pytest.approx(fall, rel=1e-12)
    assert (fmu.get("mode"), fmu.get("theta"), fmu.get("omega")) == (LOWER_STOP, 0.0, 0.0)
    assert abs(fmu.get("energy.residual")) < 1e-14


def test_a_change_brought_about_by_the_input_is_none_of_the_step(make3):
    """Stick to loading at the very start; the step goes on to the change after it."""
    fmu = make3(events=True, early=True).start()
    assert fmu.get("mode") == LOWER_STOP
    fmu.step(1e-3, tau=2.0)
    assert (fmu.get("mode"), fmu.time) == (LOADING, 1e-3)


def bisect(make3, scene, torque: float, interval: tuple[float, float]) -> float:
    """When the mode changes, found with whole steps and snapshots only."""
    fmu = make3().start(scene)
    fmu.step(interval[0], tau=torque)
    state, before, origin = fmu.take(), fmu.get("mode"), fmu.time
    low, high = 0.0, interval[1] - interval[0]
    while high - low > 1e-13:
        middle = 0.5 * (low + high)
        fmu.restore(state)
        fmu.time = origin
        fmu.step(middle)
        low, high = (middle, high) if fmu.get("mode") == before else (low, middle)
    fmu.free_state(state)
    return origin + high


@pytest.mark.parametrize(
    "scene", [ELLIPSES, GENERAL, GENERAL | BOUNCING], ids=["ellipses", "forces", "bounces"]
)
def test_early_return_is_where_bisection_finds_the_change(make3, scene):
    fmu = make3(events=True, early=True).start(scene)
    count = 0
    for torque in (2.0, 0.0):
        start = fmu.time
        event, early = fmu.step(0.5, tau=torque)
        assert event and early
        if torque > 0:
            found = bisect(make3, scene, torque, (0.5 * fmu.time, 0.5))
            assert fmu.time == pytest.approx(found, abs=MODE_CHANGES_MEET)
        assert fmu.time > start
        fmu.handle_event()
        count += 1
    assert count == 2


@pytest.mark.parametrize(
    ("scene", "tolerance"), [({}, 1e-13), (BOUNCING, 1e-11), (GENERAL, 1e-8), (GENERAL | BOUNCING, 1e-8)]
)
def test_parts_of_a_step_give_what_the_whole_step_gives(make3, scene, tolerance):
    parts, whole = make3(events=True, early=True).start(scene), make3().start(scene)
    h, until = 0.03, 0.9
    changes = events_of(parts, until, h, wave)
    for k in range(round(until / h)):
        whole.step(h, tau=wave(k * h))
    assert len(changes) > 10 and len({mode for _, mode in changes}) >= 3
    assert parts.get("events") == whole.get("events")
    for name in ("theta", "omega", "energy.work_in", "energy.heat_cam1", "energy.heat_stop", "peak.omega"):
        assert parts.get(name) == pytest.approx(whole.get(name), rel=tolerance, abs=tolerance), name
    assert abs(parts.get("energy.residual")) < 1e-9


def test_without_early_return_only_the_end_of_the_step_is_an_event(make3):
    fmu = make3(events=True).start()
    assert fmu.step(0.2, tau=2.0) == (False, False)  # the change was inside
    assert fmu.get("mode") == STICK and fmu.time == 0.2


def test_a_plain_master_never_sees_an_event(make3):
    for options in ({}, {"early": True}):
        fmu = make3(**options).start()
        for _ in range(20):
            assert fmu.step(0.02, tau=wave(fmu.time)) == (False, False)
        assert fmu.time == pytest.approx(0.4, rel=1e-14)


def test_event_mode_takes_new_inputs_and_parameters(make3):
    fmu = make3(events=True, early=True).start()
    fmu.ok("EnterEventMode")
    fmu.set({"tau": 2.0, "cam1.friction": 0.1})
    fmu.settle()
    assert fmu.get("mode") == LOADING
    fmu.ok("EnterStepMode")
    event, early = fmu.step(1.0)
    assert event and early and fmu.get("omega") == 0.0
    assert abs(fmu.get("energy.residual")) < 1e-14


def test_events_of_the_inverse_fmu_are_at_the_end_of_its_steps(make3):
    fmu = make3(INVERSE, events=True, early=True).start()
    assert fmu.step(0.1, theta=0.1, omega=1.0) == (True, False)
    assert fmu.step(0.1, theta=0.2, omega=1.0) == (False, False)
    assert fmu.step(0.1, theta=0.2, omega=-1.0) == (True, False)
    fmu.handle_event()
    assert fmu.get("mode") == RELEASING


def test_fmpy_with_event_mode_and_early_return():
    """The same swing through FMPy, which enters event mode where it is told to."""
    found = fmpy.simulate_fmu(
        str(FORWARD.fmu), stop_time=0.1, output_interval=1e-2, start_values={"tau": 2.0},
        output=["theta", "mode"], use_event_mode=True, early_return_allowed=True,
    )  # fmt: skip
    assert np.min(np.abs(found["time"] - math.pi / frequency(1))) < 1e-12
    assert found["theta"][-1] == pytest.approx(2 * balance(1, 2.0), rel=1e-12)


# ---- intermediate update ----


def test_intermediate_update_is_at_each_change_and_at_the_end(make3):
    seen = []

    def look(fmu, time, asks, may_read, finished, may_end):
        assert (asks, may_read, finished) == (False, True, True)
        assert fmu.get("time") == time
        seen.append((time, fmu.get("mode"), fmu.get("theta"), fmu.get("energy.residual"), may_end))

    fmu = make3(update=look, required=("theta",)).start(BOUNCING)
    plain = make3(events=True, early=True).start(BOUNCING)
    changes = []
    for k in range(10):
        torque = wave(0.05 * k)
        seen.clear()
        assert fmu.step(0.05, tau=torque) == (False, False)
        changes = events_of(plain, plain.time + 0.05, 0.05, lambda _, torque=torque: torque)
        inner = [(time, mode) for time, mode in changes if time < fmu.time - 1e-9]
        assert [mode for _, mode, *_ in seen[:-1]] == [mode for _, mode in inner]
        assert [time for time, *_ in seen[:-1]] == pytest.approx([time for time, _ in inner], rel=1e-12)
        assert seen[-1][0] == fmu.time and seen[-1][2] == fmu.get("theta")
        assert all(abs(residual) < 1e-13 and not may_end for *_, residual, may_end in seen)


def test_looking_on_changes_nothing(make3):
    fmu, plain = make3(update=lambda *_: None).start(GENERAL), make3().start(GENERAL)
    for k in range(20):
        for one in (fmu, plain):
            one.step(0.05, tau=wave(0.05 * k))
    assert fmu.everything() == plain.everything()
    assert fmu.get("events") > 20


@pytest.mark.parametrize(
    ("wanted", "ends"), [(-1.0, 0.0), (0.02, 0.02), (9.0, 0.2 - 0.054), (math.nan, 0.0), (math.inf, 0.146)]
)
def test_a_master_may_end_the_step(make3, wanted, ends):
    """At the first change, at pi/w = 0.0546 s, it asks to end `wanted` later; what is past is at once."""
    rest = math.pi / frequency(1)
    asked = []

    def look(_fmu, time, _asks, _may_read, _finished, may_end):
        if not may_end:
            return None
        asked.append(time)
        return time + wanted

    fmu = make3(update=look, early=True).start()
    event, early = fmu.step(0.2, tau=2.0)
    assert asked == [pytest.approx(rest, rel=1e-13)]
    assert not event and early == (ends < 0.1)
    assert fmu.time == pytest.approx(rest + ends if early else 0.2, rel=1e-13)
    other = make3().start()
    other.step(fmu.time, tau=2.0)
    assert fmu.get("theta") == other.get("theta")
    assert fmu.step(0.2 - 0.05) == (False, False)


def test_a_request_to_end_counts_only_where_it_may(make3):
    fmu = make3(update=lambda _fmu, time, *_: time).start()
    assert fmu.step(0.2, tau=2.0) == (False, False)
    assert fmu.time == 0.2


def cubic(t: float) -> float:
    return 1.0 + 40.0 * t - 300.0 * t**2 + 600.0 * t**3


def test_inputs_given_inside_a_step_are_cubics(make_model, make3):
    """As FMI 2.0's derivatives of inputs."""
    times = []

    def give(fmu, time, asks, may_read, finished, _may_end):
        assert may_read == finished == (not asks)
        if asks:
            times.append(time)
            fmu.set({"tau": cubic(time), "F_ext": 10.0 * time})

    for scene, tolerance in ((ELLIPSES, 1e-10), ({"inertia.shaft": 0.0}, 1e-12), ({}, 1e-8)):
        new, old = (
            make3(update=give, required=("tau", "F_ext", "theta")).start(scene),
            make_model(fmi2.FORWARD),
        )
        old.start(scene)
        for k in range(6):
            t, times[:] = 0.05 * k, []
            new.step(0.05, tau=cubic(t), F_ext=10.0 * t)
            assert times == pytest.approx([t + 0.05 / 3, t + 0.1 / 3, t + 0.05], rel=1e-14)
            rates = [40.0 - 600.0 * t + 1800.0 * t**2, -600.0 + 3600.0 * t, 3600.0]
            old.set({"tau": cubic(t), "F_ext": 10.0 * t})
            old.set_derivatives({"tau": rates, "F_ext": [10.0]})
            old.step(0.05)
            for name in ("theta", "omega", "energy.work_in"):
                assert new.get(name) == pytest.approx(old.get(name), rel=tolerance, abs=tolerance)
            assert new.get("tau") == pytest.approx(cubic(t + 0.05), rel=1e-12)
        assert new.get("theta") > 0.05


def test_a_ramp_given_inside_a_step_is_one_to_rounding(make_model, make3):
    """It stays the closed form, as a constant does, bit for bit."""
    slope = 30.0
    new = make3(
        update=lambda f, t, asks, *_: f.set({"tau": slope * t}) if asks else None, required=("tau",)
    ).start()
    old = make_model(fmi2.FORWARD).start()
    for k in range(3):
        new.step(0.025, tau=slope * 0.025 * k)
        old.set({"tau": slope * 0.025 * k})
        old.set_rates(tau=slope)
        old.step(0.025)
    assert new.get("theta") == pytest.approx(old.get("theta"), rel=1e-13) and new.get("theta") > 0.1
    constant, plain = make3(update=lambda *_: None, required=("tau",)).start(), make3().start()
    for one in (constant, plain):
        one.step(0.3, tau=2.0)
    assert constant.everything() == plain.everything()


def test_a_sampled_step_with_events_ends_early(make3):
    """A ramp: at rest until tau reaches T_load at z = 0."""
    slope = 10.0
    fmu = make3(
        update=lambda f, t, asks, *_: f.set({"tau": slope * t}) if asks else None,
        required=("tau",), events=True, early=True,
    ).start()  # fmt: skip
    assert fmu.step(1.0) == (True, True)
    # on the lower stop the torque first comes into the stick band, then leaves it
    assert fmu.get("mode") == STICK
    assert fmu.time == pytest.approx(RHO[-1] * PRELOAD / slope, rel=1e-12)
    assert fmu.get("tau") == pytest.approx(slope * fmu.time, rel=1e-12)
    fmu.handle_event()
    fmu.step(1.0)
    assert fmu.get("mode") == LOADING and fmu.time == pytest.approx(RHO[1] * PRELOAD / slope, rel=1e-12)


def test_what_is_not_allowed_inside_a_step_is_refused(make3):
    done = []

    def meddle(fmu, time, asks, may_read, _finished, _may_end):
        if done and done[-1] == asks:
            return
        done.append(asks)
        count = len(fmu.messages)
        state, flags, number = c_void_p(), [c_bool() for _ in range(3)], c_double()
        tries = [
            fmu.call("DoStep", time, 0.1, True, *map(byref, flags), byref(number)),
            fmu.call("GetFMUState", byref(state)),
            fmu.call("SetFMUState", taken),
            fmu.call("Reset"),
            fmu.call("Terminate"),
            fmu.call("EnterEventMode"),
            fmu.try_set({"spring.preload": 60.0}),
            fmu.try_set({"F_ext": 1.0}),  # not among the required ones
            fmu.try_set({"tau": math.nan}),
        ]
        tries.append(fmu.try_set({"tau": 1.0}) if may_read else fmu.try_get(["theta"])[0])
        assert tries == [ERROR] * len(tries)
        assert len(fmu.messages) == count + len(tries)
        assert all("allowed" in message.text for message in fmu.messages[count:])
        fmu.library.fmi3FreeInstance(fmu.instance)
        assert len(fmu.messages) == count + len(tries) + 1

    fmu, plain = make3(update=meddle, required=("tau",)).start(), make3().start()
    taken = fmu.take()
    for one in (fmu, plain):
        one.step(0.2, tau=2.0)
    assert done == [True, False]
    assert fmu.everything() == plain.everything()
    fmu.restore(taken)
    fmu.free_state(taken)
    assert fmu.get("theta") == 0.0


def test_a_refused_step_with_visits_changes_nothing(make3):
    """Nothing resists on a dwell: the step is refused after the master has given inputs."""
    fmu = make3(update=lambda f, _t, asks, *_: f.set({"tau": 1e308}) if asks else None, required=("tau",))
    fmu.start()
    before = fmu.everything()
    flags, number = [c_bool() for _ in range(3)], c_double()
    fmu.set({"tau": -1e308})
    expected = fmu.everything()
    assert fmu.call("DoStep", 0.0, 1e-3, True, *map(byref, flags), byref(number)) == ERROR
    assert "finite" in fmu.messages[-1].text
    assert fmu.everything() == expected
    fmu.set({"tau": 0.0})
    assert fmu.everything() == before


# ---- derivatives ----

MOVING = {
    FORWARD: {"initial.theta": 0.25, "initial.omega": 3.0, "tau": 4.0, **FORCES},
    INVERSE: {"theta": 0.25, "omega": 3.0, "alpha": 5.0, "F_ext": 2.0, **FORCES},
}
UNKNOWNS = {FORWARD: ["theta", "omega", "alpha", "z", "v"], INVERSE: ["tau", "z", "v"]}
KNOWNS = {
    FORWARD: ["tau", "F_ext", "theta", "omega", "cam1.friction", "spring.preload", "damper.c_load"],
    INVERSE: ["theta", "omega", "alpha", "F_ext", "cam2.friction", "spring.stiffness3"],
}


@each_model
def test_adjoint_is_the_transpose_of_directional(make_model, make3, model):
    fmu = make3(model).start(MOVING[model])
    old_model = fmi2.models[model.identifier]
    old = make_model(old_model).start(MOVING[model])
    rows, columns = UNKNOWNS[model], KNOWNS[model]
    unit = np.eye(len(columns))
    matrix = np.array([fmu.product("Directional", rows, columns, list(seed)) for seed in unit]).T
    assert np.count_nonzero(matrix) >= 8
    for seed, column in zip(unit, matrix.T, strict=True):
        found = (c_double * len(rows))()
        unknowns, knowns = old_model.references(rows), old_model.references(columns)
        arguments = (unknowns, len(rows), knowns, len(columns), driver3.reals(list(seed)), found)
        old.ok("fmi2GetDirectionalDerivative", *arguments)
        assert list(found) == list(column)
    transposed = [fmu.product("Adjoint", rows, columns, list(seed)) for seed in np.eye(len(rows))]
    assert np.array_equal(np.array(transposed), matrix)
    random = np.random.default_rng(1)
    for _ in range(5):
        left, right = random.normal(size=len(rows)), random.normal(size=len(columns))
        forward = left @ fmu.product("Directional", rows, columns, list(right))
        backward = right @ fmu.product("Adjoint", rows, columns, list(left))
        size = np.abs(left) @ np.abs(matrix) @ np.abs(right)
        assert forward == pytest.approx(backward, abs=1e-14 * size)


def test_output_derivatives_are_those_of_fmi2(make_model, make3):
    new, old = make3().start(GENERAL), make_model(fmi2.FORWARD).start(GENERAL)
    for one in (new, old):
        one.step(0.01, tau=4.0)
    for name in ("theta", "omega", "z", "v"):
        for order in (1, 2):
            assert new.output_derivative(name, order) == old.output_derivative(name, order) != 0.0


# ---- model exchange by hand ----


def test_states_rates_and_indicators(make3):
    fmu = make3(exchange=True).initialize({"initial.theta": 0.3, "tau": 4.0})
    numbers = [c_size_t(), c_size_t()]
    fmu.ok("GetNumberOfContinuousStates", byref(numbers[0]))
    fmu.ok("GetNumberOfEventIndicators", byref(numbers[1]))
    assert [n.value for n in numbers] == [2, 7]
    assert fmu.settle()["moved"] is False
    fmu.ok("EnterContinuousTimeMode")
    fmu.ok("SetTime", 0.5)
    assert fmu.get("time") == 0.5
    fmu.ok("SetContinuousStates", driver3.reals([0.31, 2.0]), 2)
    states, rates, nominals, indicators = [(c_double * n)() for n in (2, 2, 2, 7)]
    fmu.ok("GetContinuousStates", states, 2)
    fmu.ok("GetContinuousStateDerivatives", rates, 2)
    fmu.ok("GetNominalsOfContinuousStates", nominals, 2)
    fmu.ok("GetEventIndicators", indicators, 7)
    assert list(states) == [0.31, 2.0] and list(nominals) == [1.0, 10.0]
    alpha = (4.0 - RHO[1] * (PRELOAD + STIFFNESS * LIFT * 0.31)) / INERTIA
    assert list(rates) == [2.0, pytest.approx(alpha, rel=1e-13)]
    assert fmu.get("alpha") == pytest.approx(alpha, rel=1e-13)
    listed = [u.attrib["valueReference"] for u in FORWARD.document.iter("EventIndicator")]
    names = {str(v.reference): n for n, v in FORWARD.variables.items()}
    assert [fmu.get(names[reference]) for reference in listed] == list(indicators)
    assert fmu.get("indicator.velocity") == pytest.approx(2.0, abs=1e-9)
    assert fmu.get("indicator.upper_stop") == pytest.approx(1.3963 - 0.31, abs=1e-9)
    assert fmu.get("indicator.lower_stop") == fmu.get("indicator.load") == 1.0
    fmu.ok("SetContinuousStates", driver3.reals([0.31, -1e-3]), 2)
    assert fmu.get("indicator.velocity") < 0.0
    flags = [c_bool(True), c_bool(True)]
    fmu.ok("CompletedIntegratorStep", True, *map(byref, flags))
    assert not any(flag.value for flag in flags)
    fmu.ok("EnterEventMode")
    assert fmu.settle()["moved"] is True
    assert fmu.get("omega") == 0.0
    other = make3(INVERSE, exchange=True).initialize()
    other.ok("GetNumberOfContinuousStates", byref(numbers[0]))
    other.ok("GetNumberOfEventIndicators", byref(numbers[1]))
    assert [n.value for n in numbers] == [0, 1]


@each_model
def test_indicators_depend_on_what_the_structure_says(make3, model):
    """In model exchange, over modes and states: of the rest the derivative is zero."""
    known = {
        name: set(make3(model).dependencies(name)) for name in model.variables if name.startswith("indicator")
    }
    seen: dict = {name: set() for name in known}
    inputs = model.names(causality=["input"])
    for theta, omega, tau in ((0.3, 3.0, 5.0), (0.3, -3.0, 0.0), (0.3, 0.0, 2.5)):
        fmu = make3(model, exchange=True)
        values = {"initial.theta": theta, "initial.omega": omega, "tau": tau}
        fmu.initialize(values | FORCES if model is FORWARD else {"theta": theta, "omega": omega, **FORCES})
        fmu.settle()
        fmu.ok("EnterContinuousTimeMode")
        before = {name: fmu.get(name) for name in known}

        def note(changed, before=before, fmu=fmu):
            for name in known:
                if abs(fmu.get(name) - before[name]) > 1e-9:
                    seen[name].add(changed)

        for name in inputs:
            value = fmu.get(name)
            fmu.set({name: value + 1e-3})
            note(name)
            fmu.set({name: value})
        for state, change in (("theta", (1e-4, 0.0)), ("omega", (0.0, 1e-3))) if model is FORWARD else ():
            for sign in (1, 0):
                values = [theta + sign * change[0], omega + sign * change[1]]
                fmu.ok("SetContinuousStates", driver3.reals(values), 2)
                if sign:
                    note(state)
    assert seen == known


# ---- dependencies ----


@each_model
def test_dependencies_are_those_of_the_description_and_of_fmi2(make3, model):
    by_reference = {v.reference: name for name, v in model.variables.items()}
    kinds = {"constant": CONSTANT, "dependent": DEPENDENT}

    def listed(element: str) -> dict[str, dict[str, int]]:
        return {
            by_reference[int(u.attrib["valueReference"])]: {
                by_reference[int(known)]: kinds[kind]
                for known, kind in zip(
                    u.attrib["dependencies"].split(), u.attrib["dependenciesKind"].split(), strict=True
                )
            }
            for u in model.document.iter(element)
        }

    later = listed("Output") | listed("ContinuousStateDerivative") | listed("EventIndicator")
    first = listed("InitialUnknown")
    fmu = make3(model)
    assert {name: fmu.dependencies(name) for name in first} == first
    fmu.start()
    assert {name: fmu.dependencies(name) for name in later} == later
    old = fmi2.models[model.identifier]
    by_index = old.by_index
    structure = old.document.find("ModelStructure")
    for kind, mine in (("Outputs", later), ("Derivatives", later), ("InitialUnknowns", first)):
        for unknown in structure.find(kind) or ():
            names = {by_index[int(i)] for i in unknown.attrib["dependencies"].split()}
            assert set(mine[by_index[int(unknown.attrib["index"])]]) == names
    fmu.refused("GetNumberOfVariableDependencies", fmu.variables["mode"].reference, byref(c_size_t()))
    fmu.refused("GetNumberOfVariableDependencies", 10**6, byref(c_size_t()))
    fmu.refused("GetNumberOfVariableDependencies", fmu.variables["z"].reference, None, mentions=("NULL",))
    n, sizes, references = 1000, (c_size_t * 1000)(), (c_uint * 1000)()
    kinds_found = (c_int * 1000)()
    arguments = [fmu.variables["z"].reference, sizes, references, sizes, kinds_found, n]
    fmu.refused("GetVariableDependencies", *arguments, mentions=("nDependencies",))
    arguments[-1] = len(later["z"])
    for k in (1, 2, 3, 4):
        fmu.refused("GetVariableDependencies", *arguments[:k], None, *arguments[k + 1 :], mentions=("NULL",))


# ---- states ----


@pytest.mark.parametrize("options", [{}, {"events": True, "early": True}], ids=["plain", "events"])
def test_a_restored_run_repeats_bit_for_bit(make3, options):
    fmu = make3(**options).start(GENERAL)
    fmu.step(0.01, tau=4.0)
    state = fmu.take()
    content, origin = fmu.to_bytes(state), fmu.time
    other = make3(**options)
    opened = c_void_p()
    other.ok("DeserializeFMUState", content, len(content), byref(opened))
    runs = []
    for one, start in ((fmu, state), (fmu, state), (other, opened)):
        one.restore(start)
        one.time = origin
        trace = []
        for k in range(40):
            one.step(0.02, tau=wave(0.02 * k))
            trace.append((one.time, one.everything()))
        runs.append(trace)
    assert runs[0] == runs[1] == runs[2]
    fmu.free_state(state)
    other.free_state(opened)
    fmu.free_state(c_void_p())


def test_bytes_that_are_no_state_of_this_fmu_are_refused(make_model, make3):
    fmu = make3().start()
    fmu.step(0.1, tau=2.0)
    state = fmu.take()
    content = fmu.to_bytes(state)
    old = make_model(fmi2.FORWARD).start()
    old_state = old.take()
    inverse = make3(INVERSE).start()
    inverse_state = inverse.take()
    foreign = {"FMI 2.0": old.to_bytes(old_state), "inverse": inverse.to_bytes(inverse_state)}
    altered = {k: content[:k] + bytes([content[k] ^ 1]) + content[k + 1 :] for k in range(0, len(content), 7)}
    for wrong in (b"", content[:-1], content + b"\0", *foreign.values(), *altered.values()):
        opened = c_void_p()
        assert fmu.call("DeserializeFMUState", wrong, len(wrong), byref(opened)) == ERROR
        assert opened.value is None and "allowed" in fmu.messages[-1].text
    fmu.refused("DeserializeFMUState", None, len(content), byref(c_void_p()), mentions=("NULL",))
    fmu.refused("DeserializeFMUState", content, len(content), None, mentions=("NULL",))
    fmu.refused("SerializedFMUStateSize", None, byref(c_size_t()), mentions=("NULL",))
    fmu.refused("SerializedFMUStateSize", state, None, mentions=("NULL",))
    fmu.refused("SerializeFMUState", state, None, len(content), mentions=("NULL",))
    room = ctypes.create_string_buffer(len(content))
    fmu.refused("SerializeFMUState", state, room, len(content) - 1, mentions=("size",))
    fmu.refused("SetFMUState", None, mentions=("NULL",))
    fmu.refused("GetFMUState", None, mentions=("NULL",))
    for owner, one in ((fmu, state), (inverse, inverse_state)):
        owner.free_state(one)
    old.free_state(old_state)


def test_a_state_of_another_use_is_refused(make3):
    makers = [{}, {"events": True}, {"exchange": True}]
    fmus = [make3(**options) for options in makers]
    states = [fmu.initialize().take() for fmu in fmus]
    for i, fmu in enumerate(fmus):
        for j, state in enumerate(states):
            if i == j:
                fmu.restore(state)
            else:
                fmu.refused("SetFMUState", state, mentions=("FMU state of",))
    for fmu, state in zip(fmus, states, strict=True):
        fmu.free_state(state)


# ---- what is refused ----


@each_model
def test_other_types_are_refused(make3, model):
    fmu = make3(model).start()
    one = model.references(["F_ext"])
    for name, type_ in OTHER.items():
        for way in ("Get", "Set"):
            fmu.refused(
                f"{way}{name}", one, 1, (type_ * 1)(), 1, mentions=("Float64, Int32, Boolean and String",)
            )
            fmu.ok(f"{way}{name}", None, 0, None, 0)
    for way in ("Get", "Set"):
        fmu.refused(f"{way}Binary", one, 1, (c_size_t * 1)(), (c_void_p * 1)(), 1)
        fmu.refused(f"{way}Clock", one, 1, (c_bool * 1)())
        fmu.refused(
            f"{way}IntervalDecimal", one, 1, (c_double * 1)(), *([(c_int * 1)()] if way == "Get" else [])
        )
        fmu.refused(f"{way}ShiftDecimal", one, 1, (c_double * 1)())
        counters = [(ctypes.c_uint64 * 1)() for _ in range(2)]
        fmu.refused(f"{way}IntervalFraction", one, 1, *counters, *([(c_int * 1)()] if way == "Get" else []))
        fmu.refused(f"{way}ShiftFraction", one, 1, *counters)
    fmu.refused("ActivateModelPartition", 0, 0.0)
    fmu.refused("EnterConfigurationMode")
    fmu.refused("ExitConfigurationMode")
    fmu.refused("EvaluateDiscreteStates", mentions=("fmi3UpdateDiscreteStates",))


@each_model
def test_calls_with_wrong_arguments_are_refused(make3, model):
    fmu = make3(model).start()
    for name, variable in model.variables.items():
        place = (driver3.VALUE[variable.type] * 2)()
        for way in ("Get", "Set"):
            call = f"{way}{variable.type}"
            fmu.refused(call, model.references([name]), 1, place, 2, mentions=("nValues = 2",))
            if name in ("F_ext", "contacts", "ledger", "cam1.table"):
                fmu.refused(call, model.references([name]), 1, None, 1, mentions=("NULL",))
                fmu.refused(call, None, 1, place, 1, mentions=("NULL",))
                fmu.refused(call, model.references([10**6]), 1, place, 1, mentions=("1000000",))
            wrong = "Int32" if variable.type == "Float64" else "Float64"
            if name in ("F_ext", "contacts", "ledger", "cam1.table"):
                other = (driver3.VALUE[wrong] * 1)()
                fmu.refused(f"{way}{wrong}", model.references([name]), 1, other, 1, mentions=(name, wrong))
    for name in ("time", "z", "mode", "cam1.radius"):
        variable = model.variables[name]
        fmu.refused(f"Set{variable.type}", *fmu.arguments({name: 1}), mentions=(name,))
    for value in (math.nan, math.inf):
        fmu.refused("SetFloat64", *fmu.arguments({"F_ext": value}), mentions=("F_ext",))
        fmu.refused("SetFloat64", *fmu.arguments({"cam1.friction": value}), mentions=("cam1.friction",))
    orders, value = (c_int32 * 1)(3), c_double()
    for order in (-1, 0, 3):
        orders[0] = order
        fmu.refused("GetOutputDerivatives", model.references(["z"]), 1, orders, byref(value), 1)
    orders[0] = 1
    fmu.refused("GetOutputDerivatives", model.references(["F_ext"]), 1, orders, byref(value), 1)
    fmu.refused("GetOutputDerivatives", model.references(["z"]), 1, None, byref(value), 1)
    fmu.refused("GetOutputDerivatives", model.references(["z"]), 1, orders, byref(value), 2)
    rows, columns, two = model.references(["z"]), model.references(["F_ext"]), (c_double * 2)(1.0, 1.0)
    for kind in ("Directional", "Adjoint"):
        call = f"Get{kind}Derivative"
        fmu.refused(call, rows, 1, columns, 1, two, 2, two, 1, mentions=("nSeed",))
        fmu.refused(call, rows, 1, columns, 1, two, 1, two, 2, mentions=("nSensitivity",))
        fmu.refused(call, rows, 1, columns, 1, None, 1, two, 1, mentions=("NULL",))
        fmu.refused(call, rows, 1, columns, 1, two, 1, None, 1, mentions=("NULL",))
        fmu.refused(call, columns, 1, columns, 1, two, 1, two, 1, mentions=("F_ext",))
        fmu.refused(call, rows, 1, rows, 1, two, 1, two, 1, mentions=("z",))
        fmu.refused(call, rows, 1, columns, 1, (c_double * 1)(math.nan), 1, two, 1)
    assert fmu.call("SetDebugLogging", True, 1, (ctypes.c_char_p * 1)(b"nonsense")) == ERROR
    fmu.ok("SetDebugLogging", True, 0, None)


@each_model
def test_steps_that_cannot_be_are_refused(make3, model):
    fmu = make3(model, events=True, early=True, update=lambda *_: None).start()
    flags, number = [c_bool() for _ in range(3)], c_double()
    good = [0.0, 0.1, True, *map(byref, flags), byref(number)]
    for k in (3, 4, 5, 6):
        fmu.refused("DoStep", *good[:k], None, *good[k + 1 :], mentions=("NULL",))
    for t, h in ((0.5, 0.1), (0.0, 0.0), (0.0, -0.1), (0.0, math.nan), (0.0, math.inf), (math.nan, 0.1)):
        fmu.refused("DoStep", t, h, *good[2:])
    fmu.ok("EnterEventMode")
    for k in range(6):
        arguments = list(fmu._update_arguments()[0])
        arguments[k] = None
        fmu.refused("UpdateDiscreteStates", *arguments, mentions=("NULL",))


ANY_TIME = ("SetDebugLogging", "Reset", "FMUState", "Dependencies", "Get", "Set")


def test_calls_in_the_wrong_phase_are_refused(make3):
    """What each use and phase does not have. None of these is ever fmi3OK there."""
    update = Driver._update_arguments()[0]
    flags, number = [c_bool() for _ in range(3)], c_double()
    do_step = (0.0, 0.1, True, *map(byref, flags), byref(number))
    completed = (True, byref(flags[0]), byref(flags[1]))
    enter = (False, 0.0, 0.0, False, 0.0)
    two = driver3.reals([0.1, 0.0])
    calls = {
        "EnterInitializationMode": enter, "ExitInitializationMode": (), "DoStep": do_step,
        "EnterEventMode": (), "EnterStepMode": (), "UpdateDiscreteStates": update,
        "EnterContinuousTimeMode": (), "SetTime": (1.0,),
        "SetContinuousStates": (two, 2), "CompletedIntegratorStep": completed, "Terminate": (),
    }  # fmt: skip
    running = {"Terminate"}

    def refuses_all_but(fmu, allowed):
        for name, arguments in calls.items():
            if name not in allowed:
                fmu.refused(name, *arguments)

    plain, hybrid, exchange = make3(), make3(events=True), make3(exchange=True)
    for fmu in (plain, hybrid, exchange):
        refuses_all_but(fmu, {"EnterInitializationMode"})
        fmu.ok("EnterInitializationMode", *enter)
        refuses_all_but(fmu, {"ExitInitializationMode"})
        fmu.ok("ExitInitializationMode")
    refuses_all_but(plain, running | {"DoStep"})
    refuses_all_but(hybrid, running | {"EnterStepMode", "UpdateDiscreteStates"})
    hybrid.ok("EnterStepMode")
    refuses_all_but(hybrid, running | {"DoStep", "EnterEventMode"})
    refuses_all_but(exchange, running | {"EnterContinuousTimeMode", "UpdateDiscreteStates", "SetTime"})
    exchange.ok("EnterContinuousTimeMode")
    refuses_all_but(
        exchange, running | {"EnterEventMode", "SetTime", "SetContinuousStates", "CompletedIntegratorStep"}
    )
    for fmu in (plain, hybrid, exchange):
        fmu.ok("Terminate")
        refuses_all_but(fmu, set())
        fmu.ok("Reset")
        refuses_all_but(fmu, {"EnterInitializationMode"})


def test_times_of_the_experiment_are_checked(make3):
    fmu = make3()
    for wrong in (
        (True, math.nan, 0.0, False, 0.0), (True, 0.0, 0.0, False, 0.0), (False, 0.0, math.inf, False, 0.0),
        (False, 0.0, 1.0, True, 0.5), (False, 0.0, 0.0, True, math.nan),
    ):  # fmt: skip
        fmu.refused("EnterInitializationMode", *wrong)
    fmu.ok("EnterInitializationMode", True, 1e-6, 5.0, True, 6.0)
    assert fmu.get("time") == 5.0
    fmu.ok("ExitInitializationMode")
    fmu.time = 5.0
    fmu.step(0.5)
    assert fmu.time == 5.5


def test_no_instance_no_crash(libraries3):
    for library in libraries3.values():
        nobody = Driver.__new__(Driver)
        nobody.library, nobody.instance = library, None
        for name, arguments in driver3.ARGUMENTS.items():
            empty = [
                0 if kind in (c_uint, c_size_t, c_bool) else 0.0 if kind is c_double else None
                for kind in arguments
            ]
            assert nobody.call(name, *empty) == ERROR, name
        nobody.free()
        assert library.fmi3GetVersion() == b"3.0"


def test_wrong_instances_are_refused_with_a_message(libraries3):
    library = libraries3["DualCamForward"]
    for options in ({"token": None}, {"token": "{}"}, {"name": None}):
        for exchange in (False, True):
            fmu = Driver(library, exchange=exchange, **options)
            assert fmu.instance is None
            assert len(fmu.messages) == 1 and "allowed" in fmu.messages[0].text
    for required in (("mode",), ("cam1.radius",), (10**6,), ("time",)):
        fmu = Driver(library, required=required, update=lambda *_: None)
        assert fmu.instance is None and "intermediateUpdate" in fmu.messages[0].text
    messages = []
    log = driver3.LOG(lambda *message: messages.append(message))
    texts = (b"a", FORWARD.guid.encode(), None, False, False)
    assert not library.fmi3InstantiateScheduledExecution(*texts, None, log, None, None, None)
    assert b"allowed" in messages[0][3]
    assert not library.fmi3InstantiateCoSimulation(*texts, False, False, None, 3, None, log, driver3.UPDATE())


def test_null_callbacks_survive(libraries3):
    for options in ({}, {"exchange": True}, {"events": True, "early": True, "required": ("tau", "theta")}):
        fmu = Driver(libraries3["DualCamForward"], log=False, **options)
        assert fmu.try_set({"tau": math.nan}) == ERROR
        fmu.start({"tau": 2.0})
        if "exchange" not in options:
            fmu.step(0.02)
            assert fmu.get("theta") > 0.0
        fmu.free()
    fmu = Driver(libraries3["DualCamForward"], log=False, token="wrong")
    assert fmu.instance is None
    fmu = Driver(libraries3["DualCamForward"], log=False, resources=None, name="")
    assert fmu.instance
    fmu.free()


def test_messages_escape_what_fmi3_reads_in_them(make3):
    fmu = make3()
    assert fmu.try_set({"cam1.table": "100 %#" + 2000 * "x"}) == ERROR
    assert "100 %##x" in fmu.messages[-1].text


def test_tables_are_found_in_the_resources(make3, tmp_path):
    rows = [f"{k / 10},{0.02 * k / 10 + 1e-4 * (k / 10) ** 2}" for k in range(-20, 21)]
    (tmp_path / "a 1%.csv").write_text("\n".join(["psi_rad,z_m", *rows]))
    fmu = make3(resources=f"{tmp_path}/").start({"cam1.profile": 3, "cam1.table": "a 1%.csv"})
    fmu.step(0.02, tau=3.0)
    assert fmu.get("z") > 0


# ---- archive and description ----


@each_model
def test_xml_is_valid_by_the_schemas_of_the_standard(unzipped3, model):
    place = unzipped3[model.identifier]
    for name, schema in (
        ("modelDescription.xml", "fmi3ModelDescription"),
        ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3TerminalsAndIcons"),
        ("sources/buildDescription.xml", "fmi3BuildDescription"),
    ):
        checker = etree.XMLSchema(file=str(SCHEMAS / f"{schema}.xsd"))
        assert checker.validate(etree.parse(str(place / name))), checker.error_log
    assert fmpy.validation.validate_fmu(str(model.fmu)) == []
    assert (place / "modelDescription.xml").read_bytes() == model.xml.read_bytes()


@each_model
def test_nothing_is_in_it_that_should_not(unzipped3, model):
    place = unzipped3[model.identifier]
    top = {"binaries", "documentation", "extra", "modelDescription.xml", "sources", "terminalsAndIcons"}
    assert {p.name for p in place.iterdir()} == top
    assert not [p for p in (place / "sources").iterdir() if re.match(r"fmi2|emit|fmi3.*\.h", p.name)]
    assert (place / "documentation/licenses/license.txt").read_text() == (ROOT / "LICENSE").read_text()
    assert (place / "terminalsAndIcons/icon.png").read_bytes() == (
        ROOT / "modelDescription/model.png"
    ).read_bytes()
    listed = [
        e.attrib["name"]
        for e in ET.parse(place / "sources/buildDescription.xml").getroot().iter("SourceFile")
    ]
    assert listed == sorted(path.name for path in (place / "sources").glob("*.c"))


@each_model
def test_description_is_fresh(model):
    made = build_fmu.dual_cam(model.identifier, check=True, version=3)
    assert made.description.encode() == model.xml.read_bytes()
    assert made.path == model.fmu


@each_model
def test_variables_are_those_of_fmi2_and_some_more(model):
    types = {"Real": "Float64", "Integer": "Int32"}
    old = fmi2.models[model.identifier].variables
    for name, variable in old.items():
        mine = model.variables[name]
        assert mine.type == types.get(variable.type, variable.type)
        for attribute in ("reference", "causality", "variability", "start", "min", "max", "unit"):
            assert getattr(mine, attribute) == getattr(variable, attribute), name
    extra = set(model.variables) - set(old)
    assert extra == {n for n in model.variables if n == "time" or n.startswith("indicator.")}
    assert [n for n in model.variables if model.variables[n].causality == "independent"] == ["time"]
    assert [v.reference for v in model.variables.values()] == list(range(len(model.variables)))


@each_model
def test_terminals_refer_to_variables_that_can_be_connected(unzipped3, model):
    path = unzipped3[model.identifier] / "terminalsAndIcons/terminalsAndIcons.xml"
    with zipfile.ZipFile(fmi2.models[model.identifier].fmu) as old:
        assert old.read("terminalsAndIcons/terminalsAndIcons.xml") == path.read_bytes()
    terminals = {t.attrib["name"]: t for t in ET.parse(path).getroot().iter("Terminal")}
    assert set(terminals) == {"shaft", "follower"}
    members = {
        name: {m.attrib["memberName"]: (m.attrib["variableName"], m.attrib["variableKind"]) for m in terminal}
        for name, terminal in terminals.items()
    }
    for listed in members.values():
        for variable, _ in listed.values():
            assert model.variables[variable].causality in ("input", "output")
    assert members["shaft"]["tau"] == ("tau", "inflow") and members["shaft"]["phi"] == ("theta", "signal")
    assert members["follower"]["f"] == ("F_ext", "outflow") and members["follower"]["s"] == ("z", "signal")


@each_model
def test_capabilities(model):
    common = {
        "modelIdentifier": model.identifier,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
        "providesAdjointDerivatives": "true",
        "providesPerElementDependencies": "true",
    }
    early = "true" if model is FORWARD else "false"
    old = fmi2.models[model.identifier].document.find("CoSimulation").attrib
    assert model.document.find("ModelExchange").attrib == common | {"needsCompletedIntegratorStep": "true"}
    assert model.document.find("CoSimulation").attrib == common | {
        "canHandleVariableCommunicationStepSize": "true",
        "maxOutputDerivativeOrder": old["maxOutputDerivativeOrder"],
        "providesIntermediateUpdate": "true",
        "mightReturnEarlyFromDoStep": early,
        "canReturnEarlyAfterIntermediateUpdate": early,
        "hasEventMode": "true",
    }
    inside = {e.attrib["name"] for e in model.document.iter() if e.attrib.get("intermediateUpdate") == "true"}
    causalities = ["input", "output"] if model is FORWARD else ["output"]
    assert inside == set(model.names(causality=causalities))
    states = {e.attrib["name"] for e in model.document.iter() if e.attrib.get("reinit") == "true"}
    assert states == ({"theta", "omega"} if model is FORWARD else set())


@each_model
def test_documentation(unzipped3, model):
    text = (unzipped3[model.identifier] / "documentation/index.html").read_text(encoding="utf-8")
    rows = re.findall(r"<tr><td><code>([^<]+)</code>", text)
    assert sorted(rows) == sorted(model.variables)
    assert "FMI 3.0" in text and "FMI 2" not in text and "fmi2" not in text and "$" not in text


@pytest.mark.parametrize("model", [FORWARD], ids=repr)
def test_the_sources_compile_from_there_alone_and_run_alike(unzipped3, libraries3, tmp_path, model):
    folder, headers = unzipped3[model.identifier] / "sources", tmp_path / "headers"
    headers.mkdir()
    for name in ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"):
        (headers / name).write_bytes((build_fmu.fmi_headers() / name).read_bytes())
    options = ["-std=c17", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror"]
    library = tmp_path / f"{model.identifier}.so"
    sources = sorted(path.name for path in folder.glob("*.c"))
    command = [*build_fmu.ZIG, *options, "-isystem", headers, *sources, "-lm", "-o", library]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    values = []
    for loaded in (driver3.load(library), libraries3[model.identifier]):
        fmu = Driver(loaded, model).start(GENERAL)
        fmu.step(0.02, tau=5.0, F_ext=3.0)
        values.append(fmu.everything())
        fmu.free()
    assert values[0] == values[1]


def test_all_functions_of_the_header_are_known():
    header = (build_fmu.fmi_headers() / "fmi3Functions.h").read_text()
    declared = set(re.findall(r"FMI3_Export \w+TYPE\s+(fmi3\w+);", header))
    assert declared == driver3.FUNCTIONS and len(declared) > 70


def test_statuses_are_those_of_fmi2():
    header = (build_fmu.fmi_headers() / "fmi3FunctionTypes.h").read_text()
    names = re.search(r"typedef enum \{([^}]*)\} fmi3Status", header).group(1).replace(",", " ").split()
    assert (names.index("fmi3OK"), names.index("fmi3Error")) == (OK, ERROR)
