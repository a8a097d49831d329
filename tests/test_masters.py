"""What real masters do to an FMU, one test per fact that was seen in traces of theirs.

These facts have their test elsewhere:

- masters fail if a common or co-simulation function is not exported: test_fmi2.py, test_exports
- the callbacks, or some of them, are NULL: test_fmi2.py, test_callbacks_may_be_null
- resourceLocation is file:///x, file:////x or file:/x/, with %20 or raw spaces, and a table is found there:
  test_fmi2.py, test_tables_relative_to_the_resources; it is NULL or nonsense: test_any_resource_location,
  test_without_resources_a_relative_table_is_refused
- the name of an instance is a whole path: test_fmi2.py, test_any_instance_name
- start values come before fmi2SetupExperiment, after it, or in initialization mode: test_fmi2.py,
  test_any_order_of_start_values_and_setup
- a tolerance of 0.1 (Maestro), or of 0: test_fmi2.py, test_tolerance and test_refuses_experiments
- undefined units are refused: test_model_description.py, test_units_used_are_the_units_defined
- the FMU runs alike on x86-64 and aarch64: test_platforms.py, test_runs_alike
"""

import math
import re
import sys
from ctypes import byref, c_double, c_int, c_void_p
from itertools import accumulate, repeat
from pathlib import Path

import build_fmu
import fmpy
import numpy as np
import pytest
from driver import CO_SIMULATION, FORWARD, LAST_SUCCESSFUL_TIME, OK, PHASES, ROOT, STEP, models, to_c

from verification.masters import players, run, scenes
from verification.masters.hosts import job
from verification.masters.install import Failed, Missing

INVERSE = models["DualCamInverse"]

# An FMU of another FMI version gets its own entry here, and a Driver of its own in conftest.py.
VERSIONS = {f"FMI 2 {model}": model for model in models.values()}


@pytest.fixture(scope="session", params=VERSIONS.values(), ids=VERSIONS)
def model(request):
    return request.param


# Stick, loading, upper stop, release, stick; up and down with reversals.
TORQUES = [0.3, 0.5, 3.0, 12.0, 12.0, 14.0, 14.0, 6.0, 4.0, 3.0, 3.0, 3.0]
ANGLES = [0.0, 0.2, 0.7, 0.7, 1.3963, 1.2, 0.4, 0.0, 0.3, 0.31, 0.2, 0.2]
COURSE = {FORWARD: [{"tau": tau} for tau in TORQUES], INVERSE: [{"theta": angle} for angle in ANGLES]}
START = {"spring.preload": 60.0, "contacts": 1, "cam1.friction": 0.2}
H = 0.03


def course(fmu, between=lambda: None):
    """Bits of everything after each step."""
    record = []
    for inputs in COURSE[fmu.model]:
        between()
        fmu.step(H, **inputs)
        record.append(fmu.everything())
    return record


@pytest.fixture
def expected(make):
    fmu = make()
    record = course(fmu.start(START))
    if fmu.model == FORWARD:
        assert {1, 2, 3} <= {point["mode"] for point in record}
    return record


# ---- functions ----


def functions_for_model_exchange():
    text = (Path(fmpy.__file__).parent / "c-code/fmi2Functions.h").read_text()
    rest = text[text.index("/* Inquire version numbers of header files */") :]
    part = rest.split("Functions for FMI2 for Model Exchange")[1].split(
        "Functions for FMI2 for Co-Simulation"
    )[0]
    return re.findall(r"FMI2_Export\s+\w+\s+(fmi2\w+);", part)


def test_every_function_of_model_exchange_is_exported(library, model):
    assert len(functions_for_model_exchange()) == 10
    assert [name for name in functions_for_model_exchange() if not hasattr(library, name)] == []


# ---- numbers that stand for true ----


def everything_true(library, model, true):
    """A run in which every fmi2Boolean that a master can set has this value; bits of the outputs."""
    component = library.fmi2Instantiate(
        b"/opt/models/My Model.fmu", CO_SIMULATION, model.guid.encode(), None, None, true, true
    )
    ledger = model.references(["ledger"])
    assert library.fmi2SetBoolean(component, ledger, 1, (c_int * 1)(true)) == OK
    assert library.fmi2SetupExperiment(component, true, 1e-6, 0.0, true, 1.0) == OK
    assert library.fmi2EnterInitializationMode(component) == OK
    assert library.fmi2ExitInitializationMode(component) == OK
    names = [*model.names(causality=["output"]), "energy.work_in"]
    values, record = to_c("Real", [0.0] * len(names)), []
    for k, inputs in enumerate(COURSE[model]):
        for name, value in inputs.items():
            library.fmi2SetReal(component, model.references([name]), 1, to_c("Real", [value]))
        assert library.fmi2DoStep(component, k * H, H, true) == OK
        assert library.fmi2GetReal(component, model.references(names), len(names), values) == OK
        record.append([value.hex() for value in values])
    answer = c_int()
    assert library.fmi2GetBoolean(component, ledger, 1, byref(answer)) == OK
    assert answer.value == 1
    library.fmi2FreeInstance(component)
    return record


def test_true_is_minus_one(library, model):
    record = everything_true(library, model, -1)
    assert record == everything_true(library, model, 1)
    assert record[0] != record[-1]


# ---- initialization ----


def test_values_read_in_initialization_mode_are_those_of_the_start(make):
    """Masters read them there, pass them on to other FMUs, and read on after they have set inputs."""
    fmu = make()
    fmu.setup()
    fmu.ok("fmi2EnterInitializationMode")
    fmu.set(START)
    before = fmu.everything()
    inputs = COURSE[fmu.model][-1]
    fmu.set(inputs)
    there = fmu.everything()
    assert there != before
    fmu.ok("fmi2ExitInitializationMode")
    assert fmu.everything() == there
    plain = make().start(START | inputs)
    assert plain.everything() == there


def test_a_run_is_the_same_wherever_the_start_values_come(make, expected):
    for late in range(3):
        fmu = make()
        steps = [
            lambda fmu=fmu: fmu.setup(),
            lambda fmu=fmu: fmu.ok("fmi2EnterInitializationMode"),
            lambda fmu=fmu: fmu.ok("fmi2ExitInitializationMode"),
        ]
        steps.insert(late, lambda fmu=fmu: fmu.set(START))
        for step in steps:
            step()
        assert course(fmu) == expected


# ---- end of the experiment ----


@pytest.mark.parametrize(
    ("defined", "stop"), [(0, 0.0), (0, float("nan")), (1, 12 * H), (-1, 12 * H), (1, 1e9)]
)
def test_a_run_is_the_same_with_and_without_a_stop_time(make, expected, defined, stop):
    fmu = make()
    fmu.set(START)
    fmu.ok("fmi2SetupExperiment", 0, 0.0, 0.0, defined, stop)
    assert course(fmu.enter(STEP)) == expected


def test_the_last_step_may_pass_the_stop_time_by_rounding(make):
    fmu = make()
    fmu.ok("fmi2SetupExperiment", 0, 0.0, 0.0, 1, 0.3)
    fmu.enter(STEP)
    for time in (0.0, 0.1, 0.2):
        fmu.ok("fmi2DoStep", time, 0.1, 1)
    reached = c_double()
    fmu.ok("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, byref(reached))
    assert reached.value == 0.30000000000000004 > 0.3


@pytest.mark.parametrize("phase", PHASES)
def test_terminate_may_never_come(library, make, model, expected, phase):
    """The instance is freed in any phase, after steps as well, and others go on."""
    other = make()
    other.start(START)
    component = library.fmi2Instantiate(b"x", CO_SIMULATION, model.guid.encode(), None, None, 0, 0)
    calls = [
        lambda: library.fmi2EnterInitializationMode(component),
        lambda: library.fmi2ExitInitializationMode(component),
        lambda: library.fmi2DoStep(component, 0.0, 0.1, 1) or library.fmi2Terminate(component),
    ]
    for call in calls[: PHASES.index(phase)]:
        assert call() == OK
    if phase == STEP:
        assert library.fmi2DoStep(component, 0.0, 0.1, 1) == OK
    library.fmi2FreeInstance(component)
    assert course(other) == expected


# ---- time ----

STEPS = 3000
TIMES = {
    "products": [k * 1e-3 for k in range(STEPS + 1)],
    "sums": [*accumulate(repeat(1e-3, STEPS), initial=0.0)],
    "nanoseconds": [k * 1_000_000 / 1e9 for k in range(STEPS + 1)],
    "nanoseconds, scaled": [k * 1_000_000 * 1e-9 for k in range(STEPS + 1)],
}


SWINGS = 4  # up and down, or so, in those 3 s


def timed_run(fmu, times, differences):
    """Steps of 1 ms, or the difference of the two times; angle (or torque) and mode after each."""
    forward = fmu.model == FORWARD
    fmu.start({} if forward else {"shaft.stiffness": 100.0})
    read, values = "theta" if forward else "tau", []
    for k in range(STEPS):
        rate = 2 * math.pi * SWINGS / STEPS
        up, speed = (1 - math.cos(rate * k)) / 2, math.sin(rate * k) / 2 * rate / 1e-3
        fmu.set({"tau": 9.0 * up} if forward else {"theta": 1.3 * up, "omega": 1.3 * speed})
        h = times[k + 1] - times[k] if differences else 1e-3
        fmu.ok("fmi2DoStep", times[k], h, 1)
        values.append((fmu.get(read), fmu.get("mode")))
    return values


@pytest.mark.parametrize("differences", [False, True])
@pytest.mark.parametrize("times", TIMES.values(), ids=TIMES)
def test_however_a_master_rounds_its_times(make, times, differences):
    """The steps differ by 4e-16 s at most, half a unit of the last place of 3 s on either side, and all of
    them together, in sums, by 1e-13 s; at 20 rad/s that is 2e-12 rad."""
    plain, other = timed_run(make(), TIMES["products"], False), timed_run(make(), times, differences)
    assert [mode for _, mode in other] == [mode for _, mode in plain]
    assert {1, 2, 3} <= {mode for _, mode in plain}
    assert max(abs(a - b) for (a, _), (b, _) in zip(plain, other, strict=True)) < 2e-12


# ---- states ----


def test_a_state_taken_before_every_step_changes_nothing(make, expected):
    """Maestro takes one before each step, each time into another pointer, and frees none."""
    fmu = make()
    fmu.start(START)
    states = []
    assert course(fmu, between=lambda: states.append(fmu.take())) == expected
    assert len({state.value for state in states}) == len(expected)
    for state in states:
        fmu.free_state(state)


def test_every_step_taken_back_and_done_in_two(make, expected):
    """What Maestro does when another FMU does not get to the end of a step."""
    fmu = make()
    fmu.start(START)
    state = c_void_p()
    for inputs, point in zip(COURSE[fmu.model], expected, strict=True):
        fmu.ok("fmi2GetFMUstate", byref(state))
        time = fmu.time
        fmu.step(H / 4, **inputs)
        fmu.restore(state)
        fmu.time = time
        fmu.step(H, **inputs)
        assert fmu.everything() == point
    fmu.free_state(state)


# ---- the description ----


def test_initial_unknowns_are_all_there(model):
    """FMI 2.0, section 2.2.8: outputs that are calculated; there are no calculated parameters, and states of
    model exchange and their derivatives belong to it too."""
    elements = list(model.document.iter("ScalarVariable"))
    named = {
        int(u.attrib["index"]) for u in model.document.iter("InitialUnknowns") for u in u.iter("Unknown")
    }
    derivatives = {
        int(u.attrib["index"]) for d in model.document.iter("Derivatives") for u in d.iter("Unknown")
    }
    states = {int(elements[i - 1][0].attrib["derivative"]) for i in derivatives}
    wanted = {
        i
        for i, element in enumerate(elements, start=1)
        if element.attrib["causality"] in ("output", "calculatedParameter") or i in derivatives | states
        if element.attrib.get("initial") in ("calculated", "approx")
    }
    assert wanted
    assert named == wanted


def test_enumerations_are_not_used(model):
    """ecos and libcosim pass over them."""
    assert list(model.document.iter("Enumeration")) == []
    assert {v.type for v in model.variables.values()} <= {"Real", "Integer", "Boolean", "String"}
    assert model.variables["cam1.profile"].type == "Integer"


# ---- the last digit ----

FUSED = re.compile(r"\b(fn?m(add|sub)|fml[as])\b")


@pytest.mark.parametrize("contract", [False, True])
def test_no_fused_multiply_add(tmp_path, contract):
    """Where the processor has one (aarch64), the compiler would use it and change the last digits."""
    assembly = tmp_path / "oscillator.s"
    flags = ["-target", "aarch64-linux-gnu.2.17", "-O2", "-g0", "-S", "-Wno-unused-command-line-argument"]
    flags += ["-ffp-contract=fast"] if contract else []
    build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "fmu_src/closed_form/oscillator.c"], assembly)
    text = assembly.read_text()
    assert "fmul" in text
    assert bool(FUSED.search(text)) == contract


# ---- verification/masters/run.py, without the masters ----


@pytest.mark.parametrize("scene", scenes.SCENES, ids=lambda scene: scene.name)
def test_the_scenes_show_what_they_are_for(scene):
    result = scenes.reference(scene, scenes.fmu(scene.model))
    assert set(result) == set(scene.outputs)
    assert all(len(column) == len(scene.times) for column in result.values())
    if scene.model == FORWARD.identifier:
        impacts = len(set(result["energy.heat_stop"])) - 1
        assert impacts >= (2 if scene is scenes.FLUNG else 1)
        assert result["mode"][-1] == scenes.STICK
    else:
        assert np.count_nonzero(np.diff(result["mode"])) >= 6


@pytest.mark.parametrize("scene", scenes.SCENES, ids=lambda scene: scene.name)
def test_a_program_in_a_master_is_told_the_scene(scene, tmp_path, monkeypatch):
    words, outputs = players.job(scene, Path("some.fmu"), tmp_path)
    monkeypatch.setattr(sys, "argv", ["host", *(str(word) for word in words)])
    told = job.from_arguments()
    assert (told.fmu, told.step, told.outputs) == ("some.fmu", scene.step, list(scene.outputs))
    first = {name: column[0] for name, column in scene.inputs.items()}
    assert told.start == dict(scene.start) | first
    assert all(type(told.start[name]) is type(value) for name, value in scene.start.items())
    for name, column in scene.inputs.items():
        assert [row[name] for row in told.inputs] == column.tolist()
    told.save([[0.1 * k] * len(told.outputs) for k in range(len(told.inputs))])
    for column in players.read(outputs).values():
        assert column.tolist() == [0.1 * k for k in range(len(scene.times))]


def test_where_a_time_comes_twice_the_last_row_counts(tmp_path):
    (tmp_path / "x.csv").write_text("time, theta\n0,1\n0.1,2\n0.1,3\n0.2,4\n0.2,5\n0.2,6\n")
    assert players.read(tmp_path / "x.csv")["theta"].tolist() == [1.0, 3.0, 6.0]


@pytest.mark.parametrize("content", [None, "", "theta,omega\n1,2\n3\n", "theta\nx\n"])
def test_a_master_that_leaves_no_result_fails(tmp_path, content):
    if content is not None:
        (tmp_path / "x.csv").write_text(content)
    with pytest.raises(Failed, match="no result"):
        players.read(tmp_path / "x.csv")


def test_a_program_that_fails_is_quoted(tmp_path):
    with pytest.raises(Failed, match="exit 3: an error"):
        players.insist(["sh", "-c", "echo fine; echo an error >&2; echo more >&2; exit 3"], tmp_path)
    assert players.insist(["sh", "-c", "pwd; echo $TMPDIR"], tmp_path).split() == [str(tmp_path)] * 2


def play(player, **more):
    return run.Play("a master", "1.0", player, (scenes.FLUNG,), **more)


def with_error(error, output="omega"):
    """A player that is off by this in one place."""

    def player(scene, path, folder):
        result = {name: column.copy() for name, column in scenes.play(scene, path).items()}
        result[output][7] += error
        return result

    return player


def failing(error):
    def player(*_):
        raise error

    return player


@pytest.mark.parametrize(
    ("row", "wrong", "verdict"),
    [
        (play(with_error(0.0)), False, "agrees"),
        (play(with_error(1e-11)), True, "**differs**: omega in flung"),
        (play(with_error(1.0, "mode")), True, "**differs**: mode in flung"),
        (play(with_error(float("nan"))), True, "**differs**: omega in flung"),
        (play(with_error(4e-7), allowed=run.SIX_DECIMALS), False, "agrees"),
        (play(lambda *_: {"theta": scenes.grid(0.1)}), True, "**fails**: 101 communication points, not 301"),
        (
            play(lambda *_: {"angle": 1.0}),
            True,
            "**fails**: shows none of theta, omega, z, v, mode, energy.heat_stop",
        ),
        (play(failing(Missing("no java"))), False, "skipped: no java"),
        (play(failing(Failed("exit 3"))), True, "**fails**: exit 3"),
        (play(with_error(0.0), fmi="9.9"), False, "skipped: not built"),
        (run.Check("a checker", "1.0", lambda path: None), False, "finds nothing"),
        (run.Check("a checker", "1.0", failing(Failed("no units"))), True, "**fails**: no units"),
    ],
)
def test_verdicts_on_masters(row, wrong, verdict):
    outcome = run.outcome(row)
    assert outcome.wrong == wrong
    assert outcome.verdict.startswith(verdict)
