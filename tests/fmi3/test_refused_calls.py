"""FMI 3.0: calls that are refused."""

import ctypes
import math
from ctypes import byref, c_bool, c_double, c_int32, c_size_t, c_uint

import driver3
import pytest
from driver import ERROR
from driver3 import FORWARD, OTHER, Driver
from fmi3_scenes import each_model


@each_model
def test_empty_lists_of_other_types(make3, model):
    fmu = make3(model).start()
    for name in OTHER:
        for way in ("Get", "Set"):
            fmu.ok(f"{way}{name}", None, 0, None, 0)


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
    fmu.refused("GetOutputDerivatives", model.references(["z"]), 1, orders, byref(value), 2)
    rows, columns, two = model.references(["z"]), model.references(["F_ext"]), (c_double * 2)(1.0, 1.0)
    for kind in ("Directional", "Adjoint"):
        call = f"Get{kind}Derivative"
        fmu.refused(call, rows, 1, columns, 1, two, 2, two, 1, mentions=("nSeed = 2: allowed is 1",))
        fmu.refused(call, rows, 1, columns, 1, two, 1, two, 2, mentions=("nSensitivity = 2: allowed is 1",))
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
    for t, h in ((0.5, 0.1), (0.0, 0.0), (0.0, -0.1), (0.0, math.nan), (0.0, math.inf), (math.nan, 0.1)):
        fmu.refused("DoStep", t, h, True, *map(byref, flags), byref(number))


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


@pytest.mark.parametrize("resources", [None, ""])
def test_without_resources_a_relative_table_is_refused(make3, resources):
    fmu = make3(resources=resources)
    fmu.set({"cam1.profile": 3, "cam1.table": "groove.csv"})
    fmu.ok("EnterInitializationMode", False, 0.0, 0.0, False, 0.0)
    assert fmu.call("ExitInitializationMode") == ERROR
    assert "cam1.table" in fmu.messages[-1].text and "groove.csv" in fmu.messages[-1].text
