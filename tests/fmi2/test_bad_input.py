"""FMI 2.0: wrong references, types, arrays and parameter sets are refused, and nothing is changed."""

import math
from ctypes import byref, c_int

import pytest
from driver import ERROR, MODEL_EXCHANGE, OK, UNKNOWN_REFERENCE, VALUE, EventInfo, to_c
from fmi2_inputs import DRIVE, SETTABLE, TYPES, drive

# ---- references, types, arrays ----


@pytest.mark.parametrize("beyond", [0, UNKNOWN_REFERENCE, 2**31])
@pytest.mark.parametrize("way", ["Get", "Set"])
@pytest.mark.parametrize("type_", TYPES)
def test_unknown_reference(fmu, type_, way, beyond):
    reference = len(fmu.variables) + beyond
    values = (VALUE[type_] * 1)()
    fmu.refused(f"fmi2{way}{type_}", fmu.model.references([reference]), 1, values, mentions=(str(reference),))


@pytest.mark.parametrize("type_", TYPES)
@pytest.mark.parametrize(
    "name", ["tau", "theta", "cam1.radius", "contacts", "events", "ledger", "cam1.table"]
)
@pytest.mark.parametrize("way", ["Get", "Set"])
def test_wrong_type(fmu, type_, name, way):
    if fmu.variables[name].type != type_:
        values = (VALUE[type_] * 1)()
        mentions = (name, type_, str(fmu.variables[name].reference))
        fmu.refused(f"fmi2{way}{type_}", fmu.model.references([name]), 1, values, mentions=mentions)


@pytest.mark.parametrize("way", ["Get", "Set"])
@pytest.mark.parametrize("type_", TYPES)
def test_null_arrays(fmu, type_, way):
    name = {"Real": "tau", "Integer": "contacts", "Boolean": "ledger", "String": "cam1.table"}[type_]
    values = (VALUE[type_] * 1)()
    fmu.refused(f"fmi2{way}{type_}", None, 1, values, mentions=("vr", "NULL"))
    fmu.refused(f"fmi2{way}{type_}", fmu.model.references([name]), 1, None, mentions=("value", "NULL"))
    fmu.ok(f"fmi2{way}{type_}", None, 0, None)


def test_no_derivatives(fmu):
    for function in ("fmi2SetRealInputDerivatives", "fmi2GetRealOutputDerivatives"):
        fmu.ok(function, None, 0, None, None)


# ---- all or nothing ----


@pytest.mark.parametrize(
    "bad", [{"cam1.radius": -1.0}, {"z": 0.0}, {"F_ext": math.nan}, {"cam1.friction": 11.0}]
)
def test_a_call_is_carried_out_wholly_or_not_at_all(fmu, bad):
    fmu.refused_set(drive(fmu, 0.3) | {"cam1.friction": 0.2, "stop.upper": 1.0} | bad, mentions=tuple(bad))


def test_a_call_in_step_mode_is_carried_out_wholly_or_not_at_all(fmu):
    fmu.start().step(0.01, **drive(fmu, 1.0))
    fmu.refused_set({"F_ext": 3.0, "spring.preload": 70.0, "stop.upper": 1.0}, mentions=("stop.upper",))
    fmu.refused_set({"F_ext": 3.0, "spring.preload": 70.0, "spring.stiffness": -1.0})


def test_a_good_mixed_call(fmu):
    fmu.start()
    assert fmu.try_set(drive(fmu, 0.3) | {"spring.preload": 70.0, "F_ext": -2.0}) == OK
    assert (fmu.get(DRIVE[fmu.model]), fmu.get("spring.preload"), fmu.get("F_ext")) == (0.3, 70.0, -2.0)


def test_the_last_of_equal_references_wins(fmu):
    arguments = fmu.model.references(["F_ext", "F_ext"]), 2, to_c("Real", [1.0, 2.0])
    fmu.ok("fmi2SetReal", *arguments)
    assert fmu.get("F_ext") == 2.0


# ---- parameter sets that cannot work ----


IMPOSSIBLE = [
    ({"stop.lower": 1.0, "stop.upper": 0.5}, "stop.upper"),
    ({"stop.lower": 0.5}, "theta"),
    ({"cam1.lead_angle": 0.0, "cam2.lead_angle": 0.0}, "lead_angle"),
    ({"cam1.lead_angle": 1.5, "cam2.lead_angle": 1.5}, "lead_angle"),
    ({"cam1.friction": 9.0, "cam2.friction": 9.0}, "friction"),
]


@pytest.mark.parametrize("values, word", IMPOSSIBLE)
def test_cannot_leave_initialization(fmu, values, word):
    fmu.ok("fmi2EnterInitializationMode")
    fmu.set(values)
    fmu.refused("fmi2ExitInitializationMode", mentions=(word,))
    fmu.set({name: fmu.variables[name].start for name in values})
    fmu.ok("fmi2ExitInitializationMode")
    fmu.step(0.1, **drive(fmu, 1.0))


@pytest.mark.parametrize("values, word", IMPOSSIBLE)
def test_cannot_read_what_does_not_exist(fmu, values, word):
    fmu.set(values)
    status, _ = fmu.try_get(["z"])
    assert status == ERROR
    assert len(fmu.messages) == 1
    assert word in fmu.messages[0].text
    for name in fmu.model.names(causality=SETTABLE):
        assert fmu.get(name) == values.get(name, fmu.variables[name].start)


def test_tuning_cannot_jam(fmu):
    fmu.start().step(0.01, **drive(fmu, 1.2))
    fmu.refused_set({"cam1.friction": 9.0, "cam2.friction": 9.0}, mentions=("friction",))
    fmu.step(0.01)


# ---- calls in the wrong state: the message names the call that leads on ----


def test_a_call_in_the_wrong_state_names_the_call_to_make(fmu):
    step = ("fmi2DoStep", 0.0, 0.1, 1)
    fmu.refused(*step, mentions=('allowed is "step mode"; call fmi2EnterInitializationMode first',))
    fmu.ok("fmi2EnterInitializationMode")
    fmu.refused(*step, mentions=('allowed is "step mode"; call fmi2ExitInitializationMode first',))
    fmu.ok("fmi2ExitInitializationMode")
    fmu.refused("fmi2EnterInitializationMode", mentions=("; call fmi2Reset first",))
    fmu.ok(*step)
    fmu.ok("fmi2Terminate")
    fmu.refused("fmi2DoStep", fmu.time, 0.1, 1, mentions=("; call fmi2Reset first",))


def test_a_call_of_model_exchange_in_the_wrong_state_names_the_call_to_make(make):
    fmu = make(kind=MODEL_EXCHANGE)
    fmu.start()
    completed = ("fmi2CompletedIntegratorStep", 1, byref(c_int()), byref(c_int()))
    fmu.refused(*completed, mentions=("; call fmi2EnterContinuousTimeMode first",))
    fmu.settle()
    fmu.refused("fmi2NewDiscreteStates", byref(EventInfo()), mentions=("; call fmi2EnterEventMode first",))
