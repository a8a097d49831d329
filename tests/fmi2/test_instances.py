"""FMI 2.0: the binary's functions, and instances: names, callbacks, independence, threads, memory."""

import re
import resource
import threading
from ctypes import byref, c_double, c_int, c_size_t, c_void_p
from pathlib import Path

import fmpy
import pytest
from driver import ARGUMENTS, CO_SIMULATION, ERROR, FORWARD, LOGGER, OK, Callbacks, Driver, to_c
from fmi2_inputs import DRIVE, INVERSE, drive, run

# ---- binary ----


def functions_of_the_header():
    text = (Path(fmpy.__file__).parent / "c-code" / "fmi2Functions.h").read_text()
    common, rest = text[text.index("/* Inquire version numbers of header files */") :].split(
        "Functions for FMI2 for Model Exchange"
    )
    co_simulation = rest.split("Functions for FMI2 for Co-Simulation")[1]
    return re.findall(r"FMI2_Export\s+\w+\s+(fmi2\w+);", common + co_simulation)


def test_the_header_was_read():
    assert len(functions_of_the_header()) == 34


@pytest.mark.parametrize("function", functions_of_the_header())
def test_exports(library, function):
    assert hasattr(library, function)


@pytest.mark.parametrize("function", ["mechanism_advance", "inverse_advance", "instance_refuse", "VARIABLES"])
def test_exports_nothing_else(library, function):
    assert not hasattr(library, function)


def test_version(library):
    assert library.fmi2GetVersion() == b"2.0"
    assert library.fmi2GetTypesPlatform() == b"default"


# ---- instances ----


@pytest.mark.parametrize(
    "name", ["", "a", "/opt/models/My Model (1).fmu", "C:\\FMUs\\x.fmu", "Wörter", "%s%n", "x" * 100_000]
)
def test_any_instance_name(make, name):
    fmu = make(name=name)
    fmu.start().refused("fmi2CancelStep")
    assert fmu.messages[-1].instance == name


@pytest.mark.parametrize(
    "location", [None, "", "file:///x", "file:////x", "file:/x/", "file:///a%20b", "file:///a b", "nonsense"]
)
def test_any_resource_location(make, location):
    assert make(resources=location).start().get("theta") == 0.0


@pytest.mark.parametrize(
    "wrong, word",
    [
        ({"name": None}, "instanceName"),
        ({"guid": None}, "fmuGUID"),
        ({"guid": "{}"}, "fmuGUID"),
        ({"guid": FORWARD.guid.strip("{}")}, "fmuGUID"),
        ({"guid": INVERSE.guid.strip("{}")}, "fmuGUID"),
        ({"guid": "{00000000-0000-0000-0000-000000000000}"}, "fmuGUID"),
        ({"kind": 7}, "fmuType"),
        ({"kind": 7, "name": None}, "fmuType"),
    ],
)
def test_refuses_to_instantiate(library, model, wrong, word):
    fmu = Driver(library, model=model, **wrong)
    assert not fmu.instance
    (message,) = fmu.messages
    assert (message.status, message.category) == (ERROR, "logStatusError")
    assert "fmi2Instantiate" in message.text
    assert word in message.text
    assert word != "fmuGUID" or model.guid in message.text


@pytest.mark.parametrize(("model", "other"), [(FORWARD, INVERSE), (INVERSE, FORWARD)], indirect=["model"])
def test_one_fmu_is_not_the_other(library, model, other):
    assert not Driver(library, guid=other.guid, model=model).instance


@pytest.mark.parametrize("callbacks", [None, Callbacks()])
@pytest.mark.parametrize("name", [b"x", None])
def test_callbacks_may_be_null(library, model, callbacks, name):
    pointer = None if callbacks is None else byref(callbacks)
    component = library.fmi2Instantiate(name, CO_SIMULATION, model.guid.encode(), None, pointer, -1, -1)
    assert bool(component) == (name is not None)
    if component:
        assert library.fmi2EnterInitializationMode(component) == OK
        assert library.fmi2ExitInitializationMode(component) == OK
        assert library.fmi2DoStep(component, 0.0, 0.1, -1) == OK
        assert library.fmi2DoStep(component, 7.0, 0.1, -1) == ERROR
        library.fmi2FreeInstance(component)


def test_component_environment_comes_back(library, model):
    seen = []
    logger = LOGGER(lambda environment, *_: seen.append(environment))
    callbacks = Callbacks(logger=logger, componentEnvironment=4711)
    guid = model.guid.encode()
    component = library.fmi2Instantiate(b"x", CO_SIMULATION, guid, None, byref(callbacks), 0, 0)
    library.fmi2CancelStep(component)
    library.fmi2FreeInstance(component)
    assert seen == [4711]


def test_free_of_nothing(library):
    library.fmi2FreeInstance(None)


@pytest.mark.parametrize("function", ARGUMENTS)
def test_no_instance_is_an_error(library, function):
    numbers = (c_int, c_double, c_size_t)
    nothing = [0 if kind in numbers else None for kind in ARGUMENTS[function]]
    assert getattr(library, function)(None, *nothing) == ERROR


def test_instances_are_independent(make):
    one, two = make(), make()
    one.start({"spring.preload": 10.0})
    two.start({"spring.preload": 99.0})
    alone = make().start({"spring.preload": 10.0})
    for k in range(20):
        one.step(0.01, **drive(one, 0.02 * k))
        two.step(0.01, **drive(two, 0.06 * k))
        alone.step(0.01, **drive(alone, 0.02 * k))
    assert one.everything() == alone.everything()
    assert two.get("torque_load") != one.get("torque_load")


def test_threads(make):
    alone = run(make().start())
    drivers = [make().start() for _ in range(4)]
    records: list = [None] * len(drivers)

    def work(i):
        records[i] = run(drivers[i])

    threads = [threading.Thread(target=work, args=(i,)) for i in range(len(drivers))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert records == [alone] * len(drivers)


def resident_bytes():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs /proc")
def test_nothing_leaks(library, model):
    one, theta = to_c("Real", [0.5]), model.references([DRIVE[model]])

    def live(n):
        for _ in range(n):
            component = library.fmi2Instantiate(
                b"leak", CO_SIMULATION, model.guid.encode(), b"file:///resources", None, 0, 0
            )
            state = c_void_p()
            library.fmi2SetReal(component, theta, 1, one)
            library.fmi2GetReal(component, theta, 1, one)
            library.fmi2EnterInitializationMode(component)
            library.fmi2ExitInitializationMode(component)
            library.fmi2GetFMUstate(component, byref(state))
            library.fmi2GetFMUstate(component, byref(state))
            library.fmi2Reset(component)
            library.fmi2SetFMUstate(component, state)
            library.fmi2DoStep(component, 0.0, -1.0, 0)
            library.fmi2FreeFMUstate(component, byref(state))
            library.fmi2FreeInstance(component)

    live(1000)
    before = resident_bytes()
    live(20_000)
    # losing a struct of each would be 50 MB, losing the name 0.3 MB or more
    assert resident_bytes() - before < 200_000
