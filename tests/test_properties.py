"""What holds for every mechanism and every input, however extreme (hypothesis looks for exceptions).

.venv/bin/python -m pytest tests/test_properties.py --hypothesis-profile long    # minutes instead of seconds
"""

import math

import pytest
from driver import ERROR, OK, VARIABLES, Driver
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

FIXTURE = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])

HEATS = [f"energy.heat_{name}" for name in ("cam1", "cam2", "damper", "shaft", "stop")]
FLOWS = [*HEATS, "energy.work_in", "energy.work_ext", "energy.spring", "energy.kinetic"]
REALS = [v.name for v in VARIABLES.values() if v.type == "Real"]


def decades(low, high):
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


def or_zero(strategy):
    return st.one_of(strategy, st.just(0.0))


def signed(strategy):
    return st.tuples(strategy, st.sampled_from([-1.0, 1.0])).map(lambda pair: pair[0] * pair[1])


ANGLES = st.one_of(st.floats(0.01, 1.5), decades(-6, 0), decades(-6, -1).map(lambda x: math.pi / 2 - x))
PARAMETERS = st.fixed_dictionaries(
    {
        "cam1.radius": decades(-3, 0),
        "cam2.radius": decades(-3, 0),
        "cam1.lead_angle": ANGLES,
        "cam2.lead_angle": ANGLES,
        "cam1.friction": or_zero(decades(-3, 0.3)),
        "cam2.friction": or_zero(decades(-3, 0.3)),
        "spring.preload": or_zero(signed(decades(-3, 4))),
        "spring.stiffness": or_zero(decades(-2, 8)),
        "damper.c_load": or_zero(decades(-3, 7)),
        "damper.c_release": or_zero(decades(-3, 7)),
        "inertia.shaft": or_zero(decades(-9, 3)),
        "inertia.follower_mass": or_zero(decades(-6, 3)),
        "inertia.follower": or_zero(decades(-9, 1)),
        "shaft.damping": or_zero(decades(-6, 3)),
        "stop.lower": or_zero(decades(-2, 1).map(lambda x: -x)),
        "stop.upper": decades(-2, 1),
        "stop.restitution": st.floats(0.0, 0.98),
        "initial.omega": or_zero(signed(decades(-2, 2))),
    }
)
TORQUES = or_zero(signed(decades(-1, 1.5)))  # in units of T_load at the start
FORCES = or_zero(signed(decades(-1, 4)))
STEPS = st.lists(
    st.tuples(decades(-6, 1), TORQUES, TORQUES, FORCES, FORCES), min_size=1, max_size=12
)  # h, tau, its rate, F_ext, its rate


def started(make, parameters) -> Driver:
    fmu = make()
    fmu.set(parameters)
    fmu.setup()
    fmu.ok("fmi2EnterInitializationMode")
    assume(fmu.call("fmi2ExitInitializationMode") == OK)
    return fmu


def unit_of_torque(fmu: Driver) -> float:
    torque = abs(fmu.get("torque_load"))
    return torque if 0.0 < torque < math.inf else 1.0


def step(fmu: Driver, torque_unit: float, h, tau, tau_rate, force, force_rate) -> int:
    fmu.set({"tau": tau * torque_unit, "F_ext": force})
    if tau_rate or force_rate:
        fmu.set_rates(tau=tau_rate * torque_unit, F_ext=force_rate)
    status = fmu.call("fmi2DoStep", fmu.time, h, 1)
    if status == OK:
        fmu.time += h
    return status


def refused_for_a_reason(fmu: Driver) -> bool:
    """Rigid bodies under Coulomb friction that jam for ever, or endless vibrations: the limits of README."""
    return any(why in fmu.messages[-1].text for why in ("jam and let go without end", "changes too often"))


@FIXTURE
@given(PARAMETERS, STEPS)
def test_energy_is_conserved_and_nothing_is_nan(make, parameters, steps):
    fmu = started(make, parameters)
    torque_unit = unit_of_torque(fmu)
    flows = [fmu.get(name) for name in FLOWS]
    turned_over = sum(map(abs, flows))
    for one in steps:
        if step(fmu, torque_unit, *one) == ERROR:
            assert refused_for_a_reason(fmu)
            break
        values = {name: fmu.get(name) for name in REALS}
        assert not any(math.isnan(value) for value in values.values())
        assert parameters["stop.lower"] <= values["theta"] <= parameters["stop.upper"]
        turned_over += sum(abs(values[name] - old) for name, old in zip(FLOWS, flows, strict=True))
        flows = [values[name] for name in FLOWS]
        # to and fro within one step turns over more than its ends show: rounding counts against that
        way = min(parameters["stop.upper"] - parameters["stop.lower"], values["peak.omega"] * one[0])
        rounding = 1e-14 * values["peak.torque"] * way
        assert abs(values["energy.residual"]) <= 1e-9 * turned_over + rounding
        # lead angles of 1e-6 rad make the terms of a reaction 1e6 times the reaction: six digits less
        assert min(values[name] for name in HEATS) >= -1e-9 * turned_over - rounding


@FIXTURE
@given(PARAMETERS, STEPS, STEPS)
def test_a_restored_run_repeats_bit_for_bit(make, parameters, first, second):
    fmu = started(make, parameters)
    torque_unit = unit_of_torque(fmu)
    for one in first:
        step(fmu, torque_unit, *one)
    state, time = fmu.take(), fmu.time
    runs = []
    for _ in range(2):
        fmu.restore(state)
        fmu.time = time
        for one in second:
            step(fmu, torque_unit, *one)
        runs.append(fmu.everything())
    fmu.free_state(state)
    assert runs[0] == runs[1]


@pytest.mark.parametrize("name", [v.name for v in VARIABLES.values() if v.causality == "parameter"])
def test_every_parameter_is_read_back(fmu, name):
    assert fmu.get(name) == VARIABLES[name].start
