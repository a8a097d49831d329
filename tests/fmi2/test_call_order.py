"""FMI 2.0: which variable may be set, and which function called, in which phase."""

from ctypes import c_int

import pytest
from driver import END, FORWARD, INITIALIZATION, INSTANTIATED, PHASES, STEP, to_c
from fmi2_inputs import SETTABLE, drive, for_each


@pytest.mark.parametrize("phase", [INSTANTIATED, INITIALIZATION])
@for_each(causality=["parameter"])
def test_parameters_before_the_start(fmu, name, phase):
    fmu.enter(phase).set({name: fmu.variables[name].start})


@for_each(causality=["parameter"], variability=["fixed"])
def test_fixed_parameters_in_step_mode(fmu, name):
    fmu.start().refused_set({name: fmu.variables[name].start}, mentions=(name, "fixed"))


@for_each(variability=["tunable"])
def test_tunable_parameters_in_step_mode(fmu, name):
    fmu.start().step(0.01, **drive(fmu, 1.0))
    v = fmu.variables[name]
    value = v.start + (0.0625 if v.max > v.start else 0.0) if v.type == "Real" else int(v.min)
    fmu.set({name: value})
    assert fmu.get(name) == value
    fmu.step(0.01)


def test_tuning_acts_at_once(fmu):
    fmu.start()
    before = fmu.get("torque_load")
    fmu.set({"spring.preload": 2 * fmu.get("spring.preload")})
    assert fmu.get("torque_load") == pytest.approx(2 * before, rel=1e-14)


@pytest.mark.parametrize("phase", [INSTANTIATED, INITIALIZATION, STEP])
@for_each(causality=["input"])
def test_inputs_until_terminated(fmu, name, phase):
    fmu.enter(phase).set({name: 1.25})
    assert fmu.get(name) == 1.25


@for_each(causality=SETTABLE)
def test_nothing_is_set_after_the_end(fmu, name):
    fmu.enter(END).refused_set({name: fmu.variables[name].start}, mentions=(END, STEP))


@pytest.mark.parametrize("phase", [INSTANTIATED, INITIALIZATION, STEP])
@for_each(causality=["output", "local"])
def test_calculated_variables_are_never_set(fmu, name, phase):
    fmu.enter(phase).refused_set({name: 1}, mentions=(name, "calculated"))


CALLS = {
    "fmi2SetupExperiment": ((0, 0.0, 0.0, 0, 0.0), [INSTANTIATED]),
    "fmi2EnterInitializationMode": ((), [INSTANTIATED]),
    "fmi2ExitInitializationMode": ((), [INITIALIZATION]),
    "fmi2DoStep": ((0.0, 0.1, 1), [STEP]),
    "fmi2Terminate": ((), [STEP]),
    "fmi2Reset": ((), PHASES),
    "fmi2SetReal": (
        (FORWARD.references(["F_ext"]), 1, to_c("Real", [1.0])),
        [INSTANTIATED, INITIALIZATION, STEP],
    ),
    "fmi2SetRealInputDerivatives": (
        (FORWARD.references(["F_ext"]), 1, (c_int * 1)(1), to_c("Real", [1.0])),
        [INSTANTIATED, INITIALIZATION, STEP],
    ),
}


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("function", CALLS)
def test_calls_by_phase(fmu, function, phase):
    arguments, allowed = CALLS[function]
    if arguments and not isinstance(arguments[0], int | float):  # references differ
        arguments = (fmu.model.references(["F_ext"]), *arguments[1:])
    fmu.enter(phase)
    if phase in allowed:
        fmu.ok(function, *arguments)
    else:
        fmu.refused(function, *arguments, mentions=(f'"{phase}"', *allowed))
