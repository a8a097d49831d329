"""FMI 2.0: values before the first step."""

import pytest
from driver import INITIALIZATION, INSTANTIATED, PHASES, STEP
from fmi2_inputs import INPUT_SEQUENCE, LIFT, SETTABLE, for_each, for_forward, for_inverse


@for_each(causality=SETTABLE)
def test_start_value_is_the_one_in_the_xml(fmu, name):
    assert fmu.get(name) == fmu.variables[name].start


@pytest.mark.parametrize("phase", PHASES)
def test_everything_can_be_read_in_every_phase(fmu, phase):
    assert "refused" not in fmu.enter(phase).everything().values()


@for_forward
@pytest.mark.parametrize("phase", [INSTANTIATED, INITIALIZATION])
def test_outputs_follow_the_parameters_before_the_start(fmu, phase):
    fmu.enter(phase)
    assert fmu.get("theta") == 0.0
    fmu.set({"initial.theta": 0.5, "initial.omega": -2.0})
    assert fmu.get("theta") == 0.5
    assert fmu.get("omega") == -2.0
    assert fmu.get("z") == pytest.approx(0.5 * LIFT, rel=1e-15)
    assert fmu.get("v") == pytest.approx(-2.0 * LIFT, rel=1e-15)
    fmu.set({"cam1.radius": 0.04, "cam2.radius": 0.04})
    assert fmu.get("z") == pytest.approx(0.5 * 2 * LIFT, rel=1e-15)


@for_inverse
@pytest.mark.parametrize("phase", [INSTANTIATED, INITIALIZATION])
def test_outputs_follow_inputs_and_parameters_before_the_start(fmu, phase):
    fmu.enter(phase)
    before = fmu.get("tau")
    fmu.set({"theta": 0.5, "omega": -2.0})
    assert fmu.get("z") == pytest.approx(0.5 * LIFT, rel=1e-15)
    assert fmu.get("v") == pytest.approx(-2.0 * LIFT, rel=1e-15)
    assert fmu.get("tau") == fmu.get("torque_release") != before
    fmu.set({"cam1.radius": 0.04, "cam2.radius": 0.04})
    assert fmu.get("z") == pytest.approx(0.5 * 2 * LIFT, rel=1e-15)


@for_forward
def test_mode_before_the_start_follows_the_inputs(fmu):
    assert fmu.get("mode") == 4
    fmu.set({"tau": 100.0})
    assert fmu.get("mode") == 2
    fmu.set({"tau": 0.2})
    assert fmu.get("mode") in (1, 4)


def test_any_order_of_start_values_and_setup(make):
    values = {"contacts": 1, "ledger": False, "spring.preload": 30.0, "F_ext": 2.0, "stop.upper": 1.1}
    early, late, last = make(), make(), make()
    early.set(values)
    early.setup(1.5)
    late.setup(1.5)
    late.set(values)
    last.setup(1.5)
    last.ok("fmi2EnterInitializationMode")
    last.set(values)
    last.ok("fmi2ExitInitializationMode")
    assert early.enter(STEP).everything() == late.enter(STEP).everything() == last.everything()


def test_reading_changes_nothing(make):
    read, unread = make(), make()
    read.everything()
    for driver in (read, unread):
        driver.start()
    for inputs in INPUT_SEQUENCE[read.model]:
        read.step(0.013, **inputs)
        read.everything()
        unread.step(0.013, **inputs)
    assert read.everything() == unread.everything()
