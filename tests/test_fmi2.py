"""What FMI 2.0 and real masters ask of a co-simulation FMU: life, variables, errors, states, threads."""

import ctypes
import math
import re
import resource
import subprocess
import sys
import threading
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_void_p
from pathlib import Path

import fmpy
import pytest
from driver import (
    ARGUMENTS,
    CO_SIMULATION,
    DO_STEP_STATUS,
    END,
    ERROR,
    FORWARD,
    INITIALIZATION,
    INSTANTIATED,
    LAST_SUCCESSFUL_TIME,
    LOGGER,
    OK,
    PENDING_STATUS,
    PHASES,
    STEP,
    TERMINATED,
    UNKNOWN_REFERENCE,
    VALUE,
    Callbacks,
    Driver,
    models,
    to_c,
)

INVERSE = models["DualCamInverse"]
TYPES = ["Real", "Integer", "Boolean", "String"]


@pytest.fixture(scope="session", params=models.values(), ids=repr)
def model(request):
    """Every test here is about both FMUs, unless it says which."""
    return request.param


def for_each(condition=lambda variable: True, **wanted):
    """Parametrizes `name` over the variables of each FMU with these attributes."""
    pairs = [(m, n) for m in models.values() for n in m.names(**wanted) if condition(m.variables[n])]
    return pytest.mark.parametrize(("model", "name"), pairs, indirect=["model"], ids=lambda value: str(value))


for_forward = pytest.mark.parametrize("model", [FORWARD], indirect=True)
for_inverse = pytest.mark.parametrize("model", [INVERSE], indirect=True)
SETTABLE = ["parameter", "input"]
DRIVE = {FORWARD: "tau", INVERSE: "theta"}  # the input that matters most


def drive(fmu, value):
    """That input as argument of step() and set()."""
    return {DRIVE[fmu.model]: value}


# A torsion spring without friction, far from its stops: motion in closed form.
LIFT = 0.01  # m/rad: two cams of 0.02 m at 45 degrees share the turning
INERTIA = 0.5
FREE = {
    "cam1.friction": 0.0,
    "cam2.friction": 0.0,
    "inertia.shaft": INERTIA,
    "stop.lower": -1e3,
    "stop.upper": 1e3,
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
}
SWING = FREE | {"spring.stiffness": 50000.0, "spring.preload": 20.0, "initial.theta": 0.3}

# Through loading, upper stop, release and lower stop with the default parameters.
TORQUES = [0.0, 3.0, 12.0, 12.0, 40.0, 40.0, 2.0, 0.0, -5.0, 6.0, 6.0, 1.0]
ANGLES = [0.0, 0.2, 0.7, 0.7, 1.3963, 1.2, 0.4, 0.0, 0.3, 0.31, 0.2, 0.2]
COURSE = {
    FORWARD: [{"tau": tau} for tau in TORQUES],
    INVERSE: [{"theta": a, "omega": 3 * (k % 3 - 1.0), "alpha": 7.0 * k} for k, a in enumerate(ANGLES)],
}


def run(driver, count=None, h=0.013):
    """Bits of everything after every step."""
    record = []
    for inputs in COURSE[driver.model][:count]:
        driver.step(h, **inputs)
        record.append(driver.everything())
    return record


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


# ---- start values ----


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
    for inputs in COURSE[read.model]:
        read.step(0.013, **inputs)
        read.everything()
        unread.step(0.013, **inputs)
    assert read.everything() == unread.everything()


# ---- ranges ----


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@for_each(causality=SETTABLE, type=["Real"])
def test_refuses_what_is_not_finite(fmu, name, value):
    fmu.refused_set({name: value}, mentions=(name, "nan" if value != value else "inf"))


@for_each(lambda v: math.isfinite(v.min), causality=["parameter"], type=["Real"])
def test_refuses_below_min(fmu, name):
    v = fmu.variables[name]
    fmu.set({name: v.min})
    assert fmu.get(name) == v.min
    fmu.refused_set({name: math.nextafter(v.min, -math.inf)}, mentions=(name,))
    fmu.refused_set({name: v.min - 1.25}, mentions=(f"{v.min - 1.25:.17g}"[:5],))


@for_each(lambda v: math.isfinite(v.max), causality=["parameter"], type=["Real"])
def test_refuses_above_max(fmu, name):
    v = fmu.variables[name]
    fmu.set({name: v.max})
    assert fmu.get(name) == v.max
    fmu.refused_set({name: math.nextafter(v.max, math.inf)}, mentions=(name,))


@for_each(causality=["parameter"], type=["Integer"])
def test_refuses_integers_outside(fmu, name):
    v = fmu.variables[name]
    for value in (v.min, v.max):
        fmu.set({name: int(value)})
        assert fmu.get(name) == value
    for value in (v.min - 1, v.max + 1, 2**31 - 1, -(2**31)):
        fmu.refused_set({name: int(value)}, mentions=(name, str(int(value))))


@pytest.mark.parametrize("cam", ["cam1", "cam2"])
def test_curvature_is_a_sign(fmu, cam):
    fmu.refused_set({f"{cam}.ellipse_curvature": 0}, mentions=("-1 or +1",))


TEXTS = ["groove.csv", " ", "/a/b c.csv", "Größe %s%n", "x" * 1023]


@for_each(type=["String"])
def test_tables_are_any_text(fmu, name):
    """A helix does not read it."""
    for value in (*TEXTS, ""):
        fmu.set({name: value})
        assert fmu.get(name) == value
    fmu.set({name: TEXTS[-1]})
    fmu.start()


@for_each(type=["String"])
@pytest.mark.parametrize("value", ["x" * 1024, "x" * 100_000, "ü" * 512])
def test_refuses_long_tables(fmu, name, value):
    fmu.refused_set({name: value}, mentions=(name, '""', "1023"))


@for_each(type=["String"])
def test_an_old_text_leaves_no_trace(make, name):
    fmu, new = make(), make()
    fmu.set({name: "x" * 1000})
    for driver in (fmu, new):
        driver.set({name: "short"})
    assert state_bytes(fmu) == state_bytes(new)


@for_each(type=["String"])
def test_refuses_null_string(fmu, name):
    fmu.refused("fmi2SetString", fmu.model.references([name]), 1, (c_char_p * 1)(None), mentions=(name,))


@pytest.mark.parametrize("value", [1, -1, 2, -(2**31)])
def test_any_nonzero_boolean_is_true(fmu, value):
    fmu.set({"ledger": False})
    fmu.set({"ledger": value})
    assert fmu.get("ledger") is True
    fmu.set({"ledger": 0})
    assert fmu.get("ledger") is False


# ---- what may be set when ----


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
    value = v.start + (0.0625 if v.max > v.start else 0.0)
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


def test_null_arrays_of_derivatives(fmu):
    one, order = to_c("Real", [1.0]), (c_int * 1)(1)
    for function, name in (("fmi2SetRealInputDerivatives", "F_ext"), ("fmi2GetRealOutputDerivatives", "z")):
        fmu.refused(function, None, 1, order, one, mentions=("vr",))
        fmu.refused(function, fmu.model.references([name]), 1, None, one, mentions=("order",))
        fmu.refused(function, fmu.model.references([name]), 1, order, None, mentions=("value",))
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


# ---- time ----


def last_time(fmu):
    time = c_double()
    fmu.ok("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, byref(time))
    return time.value


@pytest.mark.parametrize("start", [0.0, -3.0, 1e6, 1e-300])
@pytest.mark.parametrize("h", [1e-9, 1e-3, 0.1, 7.3])
def test_lands_on_tc_plus_h(fmu, start, h):
    fmu.start(time=start)
    assert last_time(fmu) == start
    for _ in range(5):
        fmu.step(h)
        assert last_time(fmu) == fmu.time


def test_time_starts_at_zero_without_setup(fmu):
    fmu.enter(STEP).refused("fmi2DoStep", 1.0, 0.1, 1, mentions=("1", "0"))
    fmu.step(0.1)
    assert last_time(fmu) == 0.1


def test_rounding_of_the_masters_time(fmu):
    fmu.start()
    fmu.ok("fmi2DoStep", 0.0, 0.3, 1)
    fmu.ok("fmi2DoStep", 0.1 + 0.2, 0.001, 1)
    assert last_time(fmu) == 0.1 + 0.2 + 0.001 != 0.3 + 0.001


def test_rounding_near_zero_is_relative_to_the_step(fmu):
    fmu.start()
    fmu.ok("fmi2DoStep", 1e-17, 0.1, 1)


@pytest.mark.parametrize("t", [0.3 + 1e-9, 0.2, 0.0, -0.3, 1e300, math.nan, math.inf, -math.inf])
def test_refuses_another_time(fmu, t):
    fmu.start().step(0.3, **drive(fmu, 1.2))
    text = fmu.refused("fmi2DoStep", t, 0.1, 1, mentions=(f"{t:.17g}", f"{0.3:.17g}"))
    assert "currentCommunicationPoint" in text
    fmu.step(0.1)


@pytest.mark.parametrize("h", [0.0, -0.0, -0.1, math.nan, math.inf, -math.inf])
def test_refuses_step_sizes(fmu, h):
    fmu.start().step(0.3, **drive(fmu, 1.2))
    fmu.refused("fmi2DoStep", fmu.time, h, 1, mentions=("communicationStepSize", f"{h:.17g}"))
    fmu.step(0.1)


@for_forward
def test_a_step_that_fails_changes_nothing(fmu):
    fmu.start(FREE | {"stop.lower": -1e308, "stop.upper": 1e308})
    fmu.set_rates(tau=3.0)
    fmu.step(1.0)
    fmu.set({"tau": 1e300})
    rate = fmu.output_derivative("omega", 2)
    assert rate == pytest.approx(3.0 / INERTIA, rel=1e-14)
    fmu.refused("fmi2DoStep", 1.0, 1e10, 1, mentions=("step", "tau"))
    fmu.set({"tau": 1e300})  # derivatives are computed anew
    assert fmu.output_derivative("omega", 2) == rate
    fmu.step(1.0, tau=0.0)


def test_refuses_time_beyond_numbers(fmu):
    fmu.start(time=1.7e308).refused("fmi2DoStep", 1.7e308, 1.7e308, 1)


@pytest.mark.parametrize(
    "wrong, word",
    [
        ((1, 0.0, 0.0, 0, 0.0), "tolerance"),
        ((-1, -1e-6, 0.0, 0, 0.0), "tolerance"),
        ((1, math.nan, 0.0, 0, 0.0), "tolerance"),
        ((0, 0.0, math.nan, 0, 0.0), "startTime"),
        ((0, 0.0, math.inf, 0, 0.0), "startTime"),
        ((0, 0.0, 0.0, 1, math.nan), "stopTime"),
        ((0, 0.0, 2.0, -1, 1.0), "stopTime"),
    ],
)
def test_refuses_experiments(fmu, wrong, word):
    fmu.refused("fmi2SetupExperiment", *wrong, mentions=(word,))


@pytest.mark.parametrize(
    "good", [(0, math.nan, 0.0, 0, math.nan), (1, 1e-4, 0.0, 1, 0.0), (-1, 1e-9, 5.0, -1, 6.0)]
)
def test_accepts_experiments(fmu, good):
    fmu.ok("fmi2SetupExperiment", *good)
    assert last_time(fmu) == good[2]


# ---- derivatives ----


@for_forward
def test_an_input_with_a_rate(fmu):
    fmu.start(FREE)
    fmu.set({"tau": 1.0})
    fmu.set_rates(tau=3.0)
    fmu.step(2.0)
    assert fmu.get("tau") == 7.0
    assert fmu.get("omega") == pytest.approx((1.0 * 2 + 3.0 * 2**2 / 2) / INERTIA, rel=1e-14)
    assert fmu.get("theta") == pytest.approx((1.0 * 2**2 / 2 + 3.0 * 2**3 / 6) / INERTIA, rel=1e-14)


@for_forward
def test_a_rate_lasts_one_step(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=1.0)
    fmu.step(1.0)
    omega = fmu.get("omega")
    fmu.step(1.0)
    assert fmu.get("tau") == 1.0
    assert fmu.get("omega") - omega == pytest.approx(1.0 / INERTIA, rel=1e-14)


@for_forward
def test_a_value_leaves_the_rate_alone(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=1.0)
    fmu.step(1.0, tau=5.0)
    assert fmu.get("tau") == 6.0


@for_forward
def test_tuning_leaves_the_rate_alone(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=1.0)
    fmu.set({"spring.preload": 0.0})
    assert fmu.try_set({"spring.preload": 0.0, "tau": 5.0}) == OK
    fmu.step(1.0)
    assert fmu.get("tau") == 6.0


@for_forward
def test_rates_are_zero_unless_set_again(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=1.0, F_ext=1.0)
    fmu.step(1.0)
    fmu.set_rates(F_ext=1.0)
    fmu.step(1.0)
    assert (fmu.get("tau"), fmu.get("F_ext")) == (1.0, 2.0)


@for_forward
def test_rates_may_come_before_the_start(fmu):
    fmu.set(FREE)
    fmu.set_rates(tau=1.0)
    fmu.enter(STEP).step(1.0)
    assert fmu.get("tau") == 1.0


@pytest.mark.parametrize("order", [0, -1, 4, 2**31 - 1, -(2**31)])
def test_refuses_orders_of_inputs(fmu, order):
    arguments = fmu.model.references(["F_ext"]), 1, (c_int * 1)(order), to_c("Real", [1.0])
    fmu.refused("fmi2SetRealInputDerivatives", *arguments, mentions=("F_ext", str(order), "1 to 3"))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_refuses_rates_that_are_not_finite(fmu, value):
    arguments = fmu.model.references(["F_ext"]), 1, (c_int * 1)(1), to_c("Real", [value])
    fmu.refused("fmi2SetRealInputDerivatives", *arguments, mentions=("F_ext",))


@pytest.mark.parametrize("name", ["z", "cam1.radius", "contacts", UNKNOWN_REFERENCE])
def test_refuses_rates_of_what_is_no_input(fmu, name):
    arguments = fmu.model.references([name]), 1, (c_int * 1)(1), to_c("Real", [1.0])
    fmu.refused("fmi2SetRealInputDerivatives", *arguments, mentions=(str(name),))


@for_forward
def test_rates_are_set_all_or_none(fmu):
    fmu.start(FREE)
    arguments = fmu.model.references(["tau", "F_ext"]), 2, (c_int * 2)(1, 4), to_c("Real", [1.0, 1.0])
    fmu.refused("fmi2SetRealInputDerivatives", *arguments)
    fmu.step(1.0)
    assert fmu.get("tau") == 0.0


@for_forward
def test_output_derivatives(fmu):
    fmu.start(SWING)
    fmu.step(0.07, tau=4.0)
    theta, omega = fmu.get("theta"), fmu.get("omega")
    stiffness = 50000.0 * LIFT**2
    alpha = (4.0 - LIFT * 20.0 - stiffness * theta) / INERTIA
    jerk = -stiffness * omega / INERTIA
    expected = {
        ("theta", 1): omega,
        ("theta", 2): alpha,
        ("omega", 1): alpha,
        ("omega", 2): jerk,
        ("z", 1): LIFT * omega,
        ("z", 2): LIFT * alpha,
        ("v", 1): LIFT * alpha,
        ("v", 2): LIFT * jerk,
    }
    actual = {key: fmu.output_derivative(*key) for key in expected}
    assert actual == pytest.approx(expected, rel=1e-12)
    assert fmu.get("alpha") == actual["theta", 2]


@for_forward
def test_output_derivatives_after_a_ramp(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=3.0)
    fmu.step(1.0)
    assert fmu.output_derivative("omega", 2) == pytest.approx(3.0 / INERTIA, rel=1e-14)
    fmu.step(1.0)
    assert fmu.output_derivative("omega", 2) == 0.0


@pytest.mark.parametrize("order", [0, -1, 3, 2**31 - 1])
@for_each(causality=["output"])
def test_refuses_orders_of_outputs(fmu, name, order):
    arguments = fmu.model.references([name]), 1, (c_int * 1)(order), to_c("Real", [0.0])
    fmu.refused("fmi2GetRealOutputDerivatives", *arguments, mentions=(name, str(order)))


@pytest.mark.parametrize("name", ["F_ext", "alpha", "cam1.radius", "contacts", UNKNOWN_REFERENCE])
def test_refuses_derivatives_of_what_is_no_output(fmu, name):
    arguments = fmu.model.references([name]), 1, (c_int * 1)(1), to_c("Real", [0.0])
    fmu.refused("fmi2GetRealOutputDerivatives", *arguments, mentions=(str(name),))


def test_derivatives_of_all_orders(fmu):
    """value[k] is the k-th derivative: F = 1 + 2 t + 3 t^2/2 + 4 t^3/6."""
    fmu.set({"F_ext": 1.0})
    fmu.start({"inertia.shaft": 0.0})
    fmu.set_derivatives({"F_ext": [2.0, 3.0, 4.0]})
    fmu.step(0.5)
    assert fmu.get("F_ext") == pytest.approx(1 + 2 * 0.5 + 3 * 0.25 / 2 + 4 * 0.125 / 6, rel=1e-15)
    after = fmu.get("F_ext")
    fmu.step(0.5)
    assert fmu.get("F_ext") == after


# ---- tolerance ----


def bytes_with(make, tolerance):
    fmu = make()
    fmu.setup(tolerance=tolerance)
    return state_bytes(fmu)


def test_tolerance(make):
    """1e-9 unless given; below 1e-12 and above 1e-2 the nearest of them counts."""
    assert bytes_with(make, None) == bytes_with(make, 1e-9) == state_bytes(make())
    assert bytes_with(make, 1e-12) == bytes_with(make, 1e-20) != bytes_with(make, 1.1e-12)
    assert bytes_with(make, 1e-2) == bytes_with(make, 0.5) == bytes_with(make, 1e300)
    assert bytes_with(make, 1e-2) != bytes_with(make, 9e-3)


def test_reset_restores_the_tolerance(fmu, make):
    fmu.setup(tolerance=1e-4)
    fmu.ok("fmi2Reset")
    assert state_bytes(fmu) == state_bytes(make())


# ---- status ----


def test_status(fmu):
    fmu.start().step(0.5)
    terminated = c_int(7)
    fmu.ok("fmi2GetBooleanStatus", TERMINATED, byref(terminated))
    assert terminated.value == 0
    assert last_time(fmu) == 0.5


@pytest.mark.parametrize(
    "function, kind, room",
    [
        ("fmi2GetStatus", DO_STEP_STATUS, c_int(7)),
        ("fmi2GetStringStatus", PENDING_STATUS, c_char_p()),
        ("fmi2GetIntegerStatus", LAST_SUCCESSFUL_TIME, c_int(7)),
        ("fmi2GetRealStatus", TERMINATED, c_double(7)),
        ("fmi2GetBooleanStatus", LAST_SUCCESSFUL_TIME, c_int(7)),
        ("fmi2GetBooleanStatus", 99, c_int(7)),
        ("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, None),
        ("fmi2GetBooleanStatus", TERMINATED, None),
    ],
)
def test_status_without_an_answer(fmu, function, kind, room):
    fmu.start().refused(function, kind, None if room is None else byref(room))


def test_cancel_is_refused(fmu):
    fmu.start().refused("fmi2CancelStep", mentions=("pending",))


# ---- log ----


def set_logging(fmu, on, *categories):
    array = (c_char_p * len(categories))(*(c.encode() for c in categories))
    return fmu.call("fmi2SetDebugLogging", on, len(categories), array)


@pytest.mark.parametrize("logging", [0, 1, -1])
def test_errors_are_always_logged(make, logging):
    make(logging=logging).refused("fmi2CancelStep")


@pytest.mark.parametrize(
    "categories", [(), ("logStatusError",), ("logAll",), ("logEvents", "logStatusError")]
)
def test_errors_can_be_silenced(fmu, categories):
    assert set_logging(fmu, 0, *categories) == OK
    assert fmu.call("fmi2CancelStep") == ERROR
    assert fmu.messages == []
    assert set_logging(fmu, -1, *categories) == OK
    fmu.refused("fmi2CancelStep")


def test_other_categories_leave_errors_alone(fmu):
    assert set_logging(fmu, 0, "logEvents", "logStatusWarning") == OK
    fmu.refused("fmi2CancelStep")


def test_refuses_unknown_categories(fmu):
    categories = (c_char_p * 2)(b"logStatusError", b"logEverything")
    fmu.refused("fmi2SetDebugLogging", 0, 2, categories, mentions=("logEverything",))
    fmu.refused("fmi2CancelStep")
    fmu.refused("fmi2SetDebugLogging", 0, 1, None, mentions=("categories",))
    fmu.refused("fmi2SetDebugLogging", 0, 1, (c_char_p * 1)(None))


def test_messages_are_safe_as_formats(fmu):
    text = fmu.refused("fmi2SetDebugLogging", 1, 1, (c_char_p * 1)("%s #r1# \n ü".encode()))
    assert "%%s ##r1## ? ??" in text


# ---- reset ----


def state_bytes(fmu):
    state = fmu.take()
    content = fmu.to_bytes(state)
    fmu.free_state(state)
    return content


@pytest.mark.parametrize("phase", PHASES)
def test_reset(make, phase):
    fmu, new = make(), make()
    fmu.set({"spring.preload": 10.0, "F_ext": 7.0, "contacts": 1, "ledger": False, "cam1.table": "x"})
    fmu.set_rates(F_ext=1.0)
    fmu.setup(3.0, tolerance=1e-4)
    fmu.enter(phase)
    fmu.ok("fmi2Reset")
    assert fmu.everything() == new.everything()
    assert state_bytes(fmu) == state_bytes(new)
    fmu.time = 0.0
    assert run(fmu.start()) == run(new.start())


def test_reset_revives_after_errors(fmu):
    fmu.start().step(0.1, **drive(fmu, 1.2))
    fmu.refused("fmi2DoStep", math.nan, math.nan, 1)
    fmu.ok("fmi2Terminate")
    fmu.refused("fmi2DoStep", 0.1, 0.1, 1)
    fmu.ok("fmi2Reset")
    fmu.time = 0.0
    fmu.start().step(0.1, **drive(fmu, 1.2))


# ---- states ----


def test_a_restored_run_repeats_bit_for_bit(fmu):
    fmu.start()
    run(fmu, 5)
    state, time = fmu.take(), fmu.time
    first = run(fmu)
    fmu.restore(state)
    fmu.time = time
    assert run(fmu) == first
    fmu.free_state(state)


def test_any_number_of_states_in_any_order(fmu):
    fmu.start()
    states, records = [], []
    for inputs in COURSE[fmu.model]:
        fmu.step(0.013, **inputs)
        states.append(fmu.take())
        records.append(fmu.everything())
    for i in [3, 0, 11, 7, 7, 1]:
        fmu.restore(states[i])
        assert fmu.everything() == records[i]
    for state in states:
        fmu.free_state(state)
        assert not state


@pytest.mark.parametrize("phase", PHASES)
def test_a_state_holds_the_phase(fmu, phase):
    fmu.enter(phase)
    before = fmu.everything()
    state = fmu.take()
    fmu.ok("fmi2Reset")
    fmu.enter(END)
    fmu.restore(state)
    assert fmu.everything() == before
    allowed = {INSTANTIATED: "fmi2EnterInitializationMode", INITIALIZATION: "fmi2ExitInitializationMode"}
    if phase in allowed:
        fmu.ok(allowed[phase])
    elif phase == STEP:
        fmu.ok("fmi2DoStep", 0.0, 0.1, 1)
    else:
        fmu.refused("fmi2DoStep", 0.0, 0.1, 1)
    fmu.free_state(state)


def test_a_state_holds_impossible_parameters(fmu):
    fmu.set({"stop.upper": -1.0})
    state = fmu.take()
    fmu.ok("fmi2Reset")
    fmu.restore(state)
    assert fmu.get("stop.upper") == -1.0
    fmu.set({"stop.upper": 1.0})
    fmu.start().step(0.1, **drive(fmu, 0.9))
    fmu.free_state(state)


def test_a_state_holds_tuned_parameters(fmu):
    fmu.start().step(0.01, **drive(fmu, 1.2))
    fmu.set({"cam1.friction": 0.3, "spring.preload": 77.0})
    state, time = fmu.take(), fmu.time
    first = run(fmu)
    fmu.set({"cam1.friction": 0.1, "spring.preload": 11.0})
    fmu.restore(state)
    fmu.time = time
    assert fmu.get("cam1.friction") == 0.3
    assert run(fmu) == first
    fmu.free_state(state)


@for_forward
@pytest.mark.parametrize("fresh", [True, False])
def test_a_state_holds_rates(fmu, fresh):
    fmu.start(FREE)
    fmu.set_rates(tau=2.0)
    if not fresh:
        fmu.step(1.0)
    state, time = fmu.take(), fmu.time
    fmu.step(1.0)
    expected = fmu.everything()
    fmu.step(1.0, tau=-5.0)
    fmu.restore(state)
    fmu.time = time
    fmu.step(1.0)
    assert fmu.everything() == expected
    fmu.free_state(state)


def test_a_state_is_used_again(fmu):
    fmu.start()
    state = fmu.take()
    address = state.value
    fmu.step(0.1, **drive(fmu, 1.2))
    before = fmu.everything()
    fmu.ok("fmi2GetFMUstate", byref(state))
    assert state.value == address
    fmu.step(0.1)
    fmu.restore(state)
    assert fmu.everything() == before
    fmu.free_state(state)


def test_a_state_is_for_all_instances_of_the_fmu(make):
    one, two = make(), make()
    one.start()
    run(one)
    state = one.take()
    two.restore(state)
    assert two.everything() == one.everything()
    two.free_state(state)


def test_freeing_nothing(fmu):
    fmu.ok("fmi2FreeFMUstate", None)
    fmu.ok("fmi2FreeFMUstate", byref(c_void_p()))


def test_refuses_what_is_no_state(fmu):
    fmu.start().step(0.1, **drive(fmu, 1.2))
    other = ctypes.create_string_buffer(8192)
    size = c_size_t()
    for pointer, word in ((None, "NULL"), (c_void_p(ctypes.addressof(other)), "not of this FMU")):
        fmu.refused("fmi2SetFMUstate", pointer, mentions=(word,))
        fmu.refused("fmi2SerializedFMUstateSize", pointer, byref(size), mentions=(word,))
        fmu.refused("fmi2SerializeFMUstate", pointer, other, 8192, mentions=(word,))
    fmu.refused("fmi2GetFMUstate", byref(c_void_p(ctypes.addressof(other))))
    fmu.refused("fmi2FreeFMUstate", byref(c_void_p(ctypes.addressof(other))))
    fmu.refused("fmi2GetFMUstate", None, mentions=("FMUstate",))


# ---- states as bytes ----


@pytest.fixture
def midway(fmu):
    """In the middle of a run, with the state as bytes."""
    fmu.start({"cam1.friction": 0.17})
    run(fmu, 5)
    return fmu, state_bytes(fmu)


def test_bytes_restore_the_state(midway, make):
    fmu, content = midway
    other = make()
    status, state = other.try_from_bytes(content)
    assert status == OK
    other.restore(state)
    other.free_state(state)
    other.time = fmu.time
    assert run(other) == run(fmu)


def test_bytes_come_back(midway):
    fmu, content = midway
    _, state = fmu.try_from_bytes(content)
    assert fmu.to_bytes(state) == content
    fmu.free_state(state)


def test_equal_runs_have_equal_bytes(midway, make):
    _, content = midway
    other = make()
    other.everything()
    other.start({"cam1.friction": 0.17})
    run(other, 5)
    assert state_bytes(other) == content


ELSEWHERE = """
import ast, sys
sys.path.insert(0, sys.argv[2])
from driver import Driver, load, models
from pathlib import Path
fmu = Driver(load(Path(sys.argv[1])), model=models[sys.argv[4]])
status, state = fmu.try_from_bytes(sys.stdin.buffer.read())
assert status == 0, fmu.messages
fmu.restore(state)
fmu.time = float.fromhex(sys.argv[3])
for inputs in ast.literal_eval(sys.argv[5]):
    fmu.step(0.013, **inputs)
print(sorted(fmu.everything().items()))
"""


def test_bytes_load_in_another_process(midway, binary):
    fmu, content = midway
    course = str(COURSE[fmu.model])
    arguments = [str(binary), str(Path(__file__).parent), fmu.time.hex(), fmu.model.identifier, course]
    done = subprocess.run([sys.executable, "-c", ELSEWHERE, *arguments], input=content, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    run(fmu)
    assert done.stdout.decode().strip() == str(sorted(fmu.everything().items()))


def damaged(content):
    """One bit of every byte of the header and of every 37th byte after it, and of the last."""
    places = [*range(96), *range(96, len(content), 37), len(content) - 1]
    for place in places:
        copy = bytearray(content)
        copy[place] ^= 1 << place % 8
        yield bytes(copy)


def test_damaged_bytes_are_refused(midway):
    fmu, content = midway
    before = fmu.everything()
    for bad in damaged(content):
        count = len(fmu.messages)
        status, state = fmu.try_from_bytes(bad)
        assert status == ERROR
        assert not state
        assert len(fmu.messages) == count + 1
        assert "fmi2DeSerializeFMUstate" in fmu.messages[-1].text
    assert fmu.everything() == before


@pytest.mark.parametrize(
    "change", [lambda b: b"", lambda b: b[:-1], lambda b: b + b"\0", lambda b: b[8:], lambda b: 2 * b]
)
def test_bytes_of_another_length_are_refused(midway, change):
    fmu, content = midway
    bad = change(content)
    fmu.refused("fmi2DeSerializeFMUstate", bad, len(bad), byref(c_void_p()), mentions=(str(len(content)),))


def test_bytes_of_another_fmu_are_refused(midway):
    fmu, content = midway
    bad = content.replace(fmu.model.guid.encode(), b"{00000000-0000-0000-0000-000000000000}")
    assert bad != content
    fmu.refused("fmi2DeSerializeFMUstate", bad, len(bad), byref(c_void_p()), mentions=("GUID",))


def test_refuses_bad_rooms(midway):
    fmu, content = midway
    state = fmu.take()
    room = ctypes.create_string_buffer(len(content))
    fmu.refused("fmi2SerializeFMUstate", state, room, len(content) - 1, mentions=(str(len(content)),))
    fmu.refused("fmi2SerializeFMUstate", state, None, len(content), mentions=("NULL",))
    fmu.refused("fmi2SerializedFMUstateSize", state, None, mentions=("NULL",))
    fmu.refused("fmi2DeSerializeFMUstate", None, len(content), byref(c_void_p()), mentions=("NULL",))
    fmu.refused("fmi2DeSerializeFMUstate", content, len(content), None, mentions=("NULL",))
    fmu.free_state(state)


# ---- tables ----


def write_table(path, slope=0.02, last=2.0):
    """A straight groove, sampled."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [f"{psi},{slope * psi}" for psi in (k * last / 20 for k in range(21))]
    path.write_text("\n".join(["psi_rad,z_m", *rows]) + "\n")


TABLE = {"cam1.profile": 3, "cam1.table": "groove.csv"}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """With tables under names that a URI can hold in several ways; the working directory is elsewhere."""
    for name in ("res", "with blank", "50% ä", "C:/res"):
        write_table(tmp_path / name / "groove.csv")
    monkeypatch.chdir(tmp_path)
    return str(tmp_path)


@pytest.mark.parametrize(
    "location",
    [
        "file://{}/res",
        "file://{}/res/",
        "file://{}/res///",
        "file:///{}/res",
        "file:{}/res",
        "file:{}/res/",
        "file://localhost{}/res",
        "FILE://LOCALHOST{}/res",
        "file://{}/%72es",
        "file://{}/with%20blank",
        "file://{}/with blank",
        "file://{}/50%25%20%C3%A4",
        "file://{}/50%25%20%c3%a4/",
        "file://{}/50% ä",
        "file:///C:/res",
        "file:/C:/res/",
        "file:///C%3A/res",
    ],
)
def test_tables_relative_to_the_resources(make, folder, location):
    fmu = make(resources=location.format(folder)).start(TABLE | {"stop.upper": 1.3})
    fmu.step(0.1, **drive(fmu, 1.0))
    assert fmu.get("spring.force") > 50.0


@pytest.mark.parametrize(
    "location",
    [
        *(None, "", "{}/res", "res", "http://localhost{}/res"),
        *("file://elsewhere{}/res", "file:res", "file://res", "file:"),
    ],
)
def test_without_resources_a_relative_table_is_refused(make, folder, location):
    fmu = make(resources=location and location.format(folder))
    fmu.set(TABLE)
    fmu.ok("fmi2EnterInitializationMode")
    text = fmu.refused_start()
    assert "cam1.table" in text and "groove.csv" in text
    fmu.set({"cam1.table": f"{folder}/res/groove.csv"})
    fmu.ok("fmi2ExitInitializationMode")


@pytest.mark.parametrize("content", ["", "psi_rad,z_m\n0,0\n", "psi_rad,z_m\n0,0\n1,0.02\n2,0.01\n3,0.03\n"])
def test_refuses_bad_tables(make, tmp_path, content):
    (tmp_path / "groove.csv").write_text(content)
    fmu = make(resources=f"file://{tmp_path}")
    fmu.set(TABLE)
    fmu.ok("fmi2EnterInitializationMode")
    assert "cam1.table" in fmu.refused_start()


def test_a_state_needs_its_table(make, folder):
    fmu = make(resources=f"file://{folder}/res").start(TABLE)
    fmu.step(0.1, **drive(fmu, 1.0))
    state = fmu.take()
    content = fmu.to_bytes(state)
    (Path(folder) / "res" / "groove.csv").unlink()
    first = run(fmu, 4)
    fmu.restore(state)  # has read it
    fmu.time = 0.1
    assert run(fmu, 4) == first
    other = make(resources=f"file://{folder}/res")
    _, state_there = other.try_from_bytes(content)
    other.refused("fmi2SetFMUstate", state_there, mentions=("cam1.table",))
    other.start().step(0.1, **drive(other, 0.3))
    other.refused("fmi2SetFMUstate", state_there, mentions=("cam1.table",))
    other.step(0.1, **drive(other, 0.4))
    write_table(Path(folder) / "res" / "groove.csv")
    other.restore(state_there)
    other.time = 0.1
    assert run(other, 4) == first
    for driver, held in ((fmu, state), (other, state_there)):
        driver.free_state(held)


def test_reset_reads_the_table_again(make, folder):
    fmu = make(resources=f"file://{folder}/res").start(TABLE)
    (Path(folder) / "res" / "groove.csv").unlink()
    fmu.ok("fmi2Reset")
    fmu.set(TABLE)
    fmu.ok("fmi2EnterInitializationMode")
    assert "cam1.table" in fmu.refused_start()
