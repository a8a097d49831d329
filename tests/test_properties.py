"""What holds for every mechanism and every input, however extreme (hypothesis looks for exceptions).

.venv/bin/python -m pytest tests/test_properties.py --hypothesis-profile long    # minutes instead of seconds
"""

import math

import numpy as np
import pytest
from cut_dependence import Outcome, Scene, judge
from driver import ERROR, OK, VARIABLES, Driver
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st
from random_scenes import (
    CURVES,
    CUTS,
    EXTREME,
    GENERAL,
    LEAST,
    PARAMETERS,
    STEPS,
    curve,
    general_with_laws,
    inertia_felt,
    step,
    unit_of_torque,
)
from reference import DOUBLE, LOADING, RELEASING, Mechanism, groove_of
from rest_judge import EPS, NOTHING, TOLERANCE, rests

FIXTURE = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])

HEATS = [f"energy.heat_{name}" for name in ("cam1", "cam2", "damper", "shaft", "stop")]
ENERGY_ERROR = 10 * TOLERANCE  # of what is turned over, where motion is integrated step by step
FLOWS = [*HEATS, "energy.work_in", "energy.work_ext", "energy.spring", "energy.kinetic"]
REALS = [v.name for v in VARIABLES.values() if v.type == "Real"]


# With all the decades of PARAMETERS a step may hold as many mode changes as are allowed, which takes seconds
# where motion is integrated.
SCENES = EXTREME if settings.default.max_examples > 1000 else GENERAL
GENERAL_FIXTURE = settings(FIXTURE, max_examples=max(1, settings.default.max_examples // 3))


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("grooves")


def started(make, parameters) -> Driver:
    fmu = make()
    fmu.set(parameters)
    fmu.setup()
    fmu.ok("fmi2EnterInitializationMode")
    assume(fmu.call("fmi2ExitInitializationMode") == OK)
    return fmu


def refused_for_a_reason(fmu: Driver) -> bool:
    """Contacts that wedge again and again, endless vibrations, friction that grows with the speed until no
    inertia is felt: docs/limits.md."""
    reasons = (
        "the contacts wedge and let go without end",
        "the step needs too many segments",
        "the step needs too many evaluations of the motion",
        "take the inertia that the torque feels to zero",
    )
    return any(why in fmu.messages[-1].text for why in reasons)


SETTLES_AT_ONCE = {
    "cam1.radius": 1.0,
    "cam2.radius": 1.0,
    "cam1.lead_angle": math.pi / 2 - 1e-5,
    "cam2.lead_angle": 1.0,
    "cam1.friction": 0.0,
    "cam2.friction": 0.0,
    "spring.preload": 1.0,
    "spring.stiffness": 0.0,
    "damper.c_load": 0.0,
    "damper.c_release": 1000.0,
    "inertia.shaft": 0.0,
    "inertia.follower_mass": 0.0,
    "inertia.follower": 1e-4,
    "shaft.damping": 0.0,
    "stop.lower": 0.0,
    "stop.upper": 1.0,
    "stop.restitution": 0.0,
    "initial.omega": -1.0,
}  # releasing, within 1e-17 s
SETTLES_SLOWLY = SETTLES_AT_ONCE | {
    "cam1.lead_angle": 1.0,
    "cam2.friction": 0.1,
    "spring.preload": 0.0,
    "damper.c_release": 0.0,
    "inertia.follower_mass": 1.0,
    "inertia.follower": 1.0,
    "shaft.damping": 100.0,
    "stop.lower": -1.0,
}  # so that curvatures vanish while rates do not
# Contact 2 locks and turns the damper around: a speed off the balance grows like exp(5e5 t), t in seconds.
UNSTABLE_BALANCE = {
    "cam1.radius": 10.0**-1.5,
    "cam2.radius": 1.0,
    "cam1.lead_angle": 0.6922471073347196,
    "cam2.lead_angle": 0.01,
    "cam1.friction": 1.0,
    "cam2.friction": 1.9952623149688793,
    "spring.preload": 0.0067681215630575565,
    "spring.stiffness": 0.0,
    "damper.c_load": 0.0,
    "damper.c_release": 1e7,
    "inertia.shaft": 0.0009424384239903301,
    "inertia.follower": 0.0,
    "inertia.follower_mass": 1.0,
    "shaft.damping": 0.0,
    "stop.lower": 0.0,
    "stop.upper": 3.5224330693943626,
    "stop.restitution": 0.9250689269275421,
    "initial.omega": 0.5047821530270642,
}
ONTO_THE_BALANCE = [
    (0.49607880583216174, 0.60748218719101, -3.1622776601683795, 0.0, 1.0),
    (1.0, -11.031936787188194, 1.0000002744895709, 0.0, 0.0),
    (1.0, 0.0, -1.0, 1727.6388336611528, 0.0),
    (3.251093040837382e-06, 0.45024702240876363, 0.0, 3.1800168696925524, -1.0),
    (1.0, -0.18595147004309007, -1.0, 0.0, 1.0),
    (0.0008138380363614127, 0.0, 0.0, 0.0, 6.975070479802972),
    (1.0, -11.031936787188194, 1.0000002744895709, 0.0, 0.0),
    (10.0**-0.99999, 0.0, 0.0, 0.0, 0.0),
    (1.0785718166916307, 0.0, 0.0, 0.0, 0.0),
]
RAMP, BOTH = (1.0, -1.0, -1.0, 0.0, 0.0), (1.0, -1.0, -1.0, -1.0, 0.0)
PUSHED_BACK = [RAMP, RAMP, BOTH, RAMP, BOTH, (1.0, 0.0, 0.0, 0.0, -1.0)]


# Of a piece of the transmission, a polynomial of degree 12. Each coefficient rounds z by half an EPS of the
# largest height. The residual has the rounding of z at the start, and now.
Z_COEFFICIENTS = 13


def rounding_of_step(parameters, values, h: float) -> float:
    """J, added to the residual of all steps before. To and fro within one step turns over more than its ends
    show: rounding counts against that."""
    way = min(parameters["stop.upper"] - parameters["stop.lower"], values["peak.omega"] * h)
    return 1e-14 * values["peak.torque"] * way


@FIXTURE
@example(parameters=SETTLES_AT_ONCE, steps=[(1.0, -1.0, -1.0, 0.0, -10.0), (1.0, -1.0, 0.0, 0.0, -10.0)])
@example(parameters=SETTLES_SLOWLY, steps=PUSHED_BACK)
@example(parameters=UNSTABLE_BALANCE, steps=ONTO_THE_BALANCE)
@given(PARAMETERS, STEPS)
def test_energy_is_conserved_and_nothing_is_nan(make, parameters, steps):
    fmu = started(make, parameters)
    torque_unit = unit_of_torque(fmu)
    flows = [fmu.get(name) for name in FLOWS]
    turned_over, rounding = sum(map(abs, flows)), 0.0
    for one in steps:
        if step(fmu, torque_unit, *one) == ERROR:
            assert refused_for_a_reason(fmu)
            break
        values = {name: fmu.get(name) for name in REALS}
        assert not any(math.isnan(value) for value in values.values())
        assert parameters["stop.lower"] <= values["theta"] <= parameters["stop.upper"]
        turned_over += sum(abs(values[name] - old) for name, old in zip(FLOWS, flows, strict=True))
        flows = [values[name] for name in FLOWS]
        rounding += rounding_of_step(parameters, values, one[0])
        assert abs(values["energy.residual"]) <= 1e-9 * turned_over + rounding + NOTHING
        # lead angles of 1e-6 rad make the terms of a reaction 1e6 times the reaction: six digits less
        assert min(values[name] for name in HEATS) >= -1e-9 * turned_over - rounding - NOTHING


def turned_over_inside(make, parameters, torque_unit, curves) -> float:
    """J, in short steps: a motion to and fro within a step turns over more than its ends show."""
    fmu, total, parts = started(make, parameters), 0.0, 32
    for one in curves:
        flows = [fmu.get(name) for name in FLOWS]
        for k in range(parts):
            assume(curve(fmu, torque_unit, *one, (k / parts, (k + 1) / parts)) == OK)
            now = [fmu.get(name) for name in FLOWS]
            total += sum(abs(new - old) for new, old in zip(now, flows, strict=True))
            flows = now
    return total


def largest_height(parameters, make) -> float:
    """m: z is a difference of heights of the grooves. It has the digits of the largest one between the stops,
    and those of the heights in the tables."""
    ends = [
        started(make, parameters | {"initial.theta": parameters[f"stop.{s}"]}) for s in ("lower", "upper")
    ]
    tables = [parameters.get(f"cam{i}.table") for i in (1, 2)]
    heights = [np.abs(np.loadtxt(table, delimiter=",", skiprows=1)[:, 1]).max() for table in tables if table]
    return max(*(abs(end.get("z")) for end in ends), *heights)


@GENERAL_FIXTURE
@given(SCENES, CURVES, st.data())
def test_general_energy_is_conserved_and_nothing_is_nan(make, scratch, scene, curves, data):
    """As above, with grooves of any shape, nonlinear springs and dampers, curved inputs; no heat falls."""
    parameters = general_with_laws(data, scene, scratch)
    fmu = started(make, parameters)
    height, force = largest_height(parameters, make), 0.0
    torque_unit = unit_of_torque(fmu, LEAST)
    flows = [fmu.get(name) for name in FLOWS]
    turned_over, rounding = sum(map(abs, flows)), 0.0
    grooves = [groove_of(parameters, i) for i in (1, 2)]
    felt = inertia_felt(fmu, parameters, grooves)
    for number, one in enumerate(curves, 1):
        if curve(fmu, torque_unit, *one) == ERROR:
            assert refused_for_a_reason(fmu), fmu.messages[-1].text
            break
        values = {name: fmu.get(name) for name in REALS}
        assert not any(math.isnan(value) for value in values.values())
        assert parameters["stop.lower"] <= values["theta"] <= parameters["stop.upper"]
        changes = {name: values[name] - old for name, old in zip(FLOWS, flows, strict=True)}
        turned_over += sum(map(abs, changes.values()))
        flows = [values[name] for name in FLOWS]
        rounding += rounding_of_step(parameters, values, one[0])
        force = max(force, abs(values["spring.force"]) + abs(values["F_ext"]))
        before, felt = felt, inertia_felt(fmu, parameters, grooves)
        # a swing to and fro within the step takes up and gives back kinetic energy that its ends do not show
        swing = max(before, felt) * values["peak.omega"] ** 2 if felt else 0.0
        allowed = ENERGY_ERROR * (turned_over + swing) + rounding + NOTHING
        allowed += Z_COEFFICIENTS * EPS * force * height
        if abs(values["energy.residual"]) > allowed:
            allowed += ENERGY_ERROR * turned_over_inside(make, parameters, torque_unit, curves[:number])
        assert abs(values["energy.residual"]) <= allowed
        assert min(changes[name] for name in HEATS) >= -allowed


@GENERAL_FIXTURE
@given(SCENES, CURVES, st.data())
def test_general_rest_is_one_that_friction_allows(make, scratch, scene, curves, data):
    parameters = general_with_laws(data, scene, scratch)
    fmu = started(make, parameters)
    mechanism = Mechanism(parameters, DOUBLE)
    torque_unit = unit_of_torque(fmu, LEAST)
    for one in curves:
        assume(curve(fmu, torque_unit, *one) == OK)
        if fmu.get("mode") not in (LOADING, RELEASING):
            assert fmu.get("omega") == 0.0
            assert rests(fmu, mechanism, parameters)


# A heavy follower, J = 0: the one pair whose reactions press its flanks would feel a negative inertia, for
# D = -0.39 kg.m5 and Delta = 0.44 m3.
NEGATIVE_INERTIA = {
    "cam1.radius": 1.0,
    "cam2.radius": 1.0,
    "cam1.lead_angle": math.atan(0.12565513657513097),
    "cam2.lead_angle": math.atan(0.0922993451949297),
    "cam1.friction": 1.0,
    "cam2.friction": 1.0,
    "spring.preload": -1.0,
    "spring.stiffness": 0.0,
    "spring.stiffness2": 0.0,
    "spring.stiffness3": 0.0,
    "inertia.shaft": 0.0,
    "inertia.follower_mass": 1.0,
    "inertia.follower": 1.0,
    "shaft.damping": 0.0,
    "stop.lower": -1.0,
}


def test_a_pair_that_feels_a_negative_inertia_does_not_move(make):
    """Found by `./build.sh run fuzz`: the judge left out this condition of docs/mechanism.md, section 6."""
    fmu = make().start(NEGATIVE_INERTIA)
    fmu.step(1.0, tau=4.0, F_ext=-1.0)
    assert fmu.get("mode") not in (LOADING, RELEASING) and fmu.get("torque_load") < 4.0
    assert rests(fmu, Mechanism(NEGATIVE_INERTIA, DOUBLE), NEGATIVE_INERTIA)


@GENERAL_FIXTURE
@given(SCENES, CURVES, CUTS, st.data())
def test_general_answer_does_not_depend_on_cuts(make, scratch, scene, curves, cuts, data):
    verdict = judge(make, Scene(general_with_laws(data, scene, scratch), curves, sorted(cuts)))
    assert verdict.outcome is not Outcome.DEPENDS, verdict.text


def check_that_it_repeats(fmu: Driver, go_on, first, second) -> None:
    """After `first` the state is taken; from there `second` leads to the same bits twice."""
    for one in first:
        go_on(one)
    state, time = fmu.take(), fmu.time
    runs = []
    for _ in range(2):
        fmu.restore(state)
        fmu.time = time
        for one in second:
            go_on(one)
        runs.append(fmu.everything())
    fmu.free_state(state)
    assert runs[0] == runs[1]


@GENERAL_FIXTURE
@given(SCENES, CURVES, CURVES, st.data())
def test_a_restored_general_run_repeats_bit_for_bit(make, scratch, scene, first, second, data):
    fmu = started(make, general_with_laws(data, scene, scratch))
    torque_unit = unit_of_torque(fmu, LEAST)
    check_that_it_repeats(fmu, lambda one: curve(fmu, torque_unit, *one), first, second)


@FIXTURE
@given(PARAMETERS, STEPS, STEPS)
def test_a_restored_run_repeats_bit_for_bit(make, parameters, first, second):
    fmu = started(make, parameters)
    torque_unit = unit_of_torque(fmu)
    check_that_it_repeats(fmu, lambda one: step(fmu, torque_unit, *one), first, second)


@pytest.mark.parametrize("name", [v.name for v in VARIABLES.values() if v.causality == "parameter"])
def test_every_parameter_is_read_back(fmu, name):
    assert fmu.get(name) == VARIABLES[name].start
