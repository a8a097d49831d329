"""The examples as SSP packages: their files, their parts, and their behaviour when coupled."""

import ctypes
import math
import re
import sys
import zipfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from driver import ROOT
from fmpy.validation import validate_fmu
from lxml import etree
from ssp_structures import connections_of, connectors_of

from dualcam import Fmu
from dualcam import ssp as ssp_package
from dualcam.errors import FmuError
from dualcam.ssp.package import split, tag
from dualcam.systems.blocks.current_loop import CURRENT_BANDWIDTH, CURRENT_RATE, CurrentLoop
from dualcam.systems.blocks.motions import FourierSeries
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.blocks.pendulum import HingeMotion
from dualcam.systems.machines import car_door, elbow, knee
from dualcam.systems.machines.gait import DESIGN_WALKER
from dualcam.systems.machines.swing import SWING, full_extension
from system_examples.ssp import __main__ as ssp_run
from system_examples.ssp import compilation, parts, systems, variables
from system_examples.ssp.coupling import couple
from system_examples.ssp.systems import STEP, STEPS_PER_PERIOD, WATCHED
from verification.masters import players
from verification.masters.hosts import package
from verification.masters.install import Failed, Missing

NAMES = list(systems.EXAMPLES)
SCHEMAS = Path(fmpy.__file__).parent / "ssp/schema"
TICK = 1e-3  # s
CAM = ROOT / "build/DualCamForward.fmu"


@pytest.fixture(scope="module")
def examples():
    compilation.build()
    found = {name: build() for name, build in systems.EXAMPLES.items()}
    for example in found.values():
        example.system.write()
    return found


@pytest.fixture(scope="module", params=NAMES)
def example(request, examples):
    return examples[request.param]


@pytest.fixture
def structure(example):
    with zipfile.ZipFile(example.system.path) as archive:
        return ElementTree.fromstring(archive.read("SystemStructure.ssd"))


# ---- the packages ----


def test_structure_and_parameters_are_valid(example):
    schemas = {
        suffix: etree.XMLSchema(etree.parse(str(SCHEMAS / f"SystemStructure{name}.xsd")))
        for suffix, name in ((".ssd", "Description"), (".ssv", "ParameterValues"))
    }
    with zipfile.ZipFile(example.system.path) as archive:
        files = [name for name in archive.namelist() if Path(name).suffix in schemas]
        assert len(files) == 1 + len(example.system.components)
        for name in files:
            schemas[Path(name).suffix].assertValid(etree.fromstring(archive.read(name)))


def variables_of(archive, source):
    """Of an FMU in a package, by name."""
    with archive.open(source) as file, zipfile.ZipFile(file) as fmu:
        root = ElementTree.fromstring(fmu.read("modelDescription.xml"))
    return {v.attrib["name"]: v for v in root.iter("ScalarVariable")}


def test_connectors_are_variables_and_connections_join_equal_units(example, structure):
    declared = {unit.attrib["name"] for unit in structure.iter(tag("ssc:Unit"))}
    with zipfile.ZipFile(example.system.path) as archive:
        for component in structure.iter(tag("ssd:Component")):
            known = variables_of(archive, component.attrib["source"])
            for connector in component.iter(tag("ssd:Connector")):
                variable = known[connector.attrib["name"]]
                assert connector.attrib["kind"] == variable.attrib["causality"]
                assert connector[0].tag == tag(f"ssc:{variable[0].tag}")
                assert connector[0].attrib.get("unit") == variable[0].attrib.get("unit")
                assert connector[0].attrib.get("unit") in declared | {None}
    read = []
    for start, end in connections_of(structure):
        assert (start.attrib["kind"], end.attrib["kind"]) == ("output", "input")
        read.append(end)
    inputs = [end for end in connectors_of(structure).values() if end.attrib["kind"] == "input"]
    assert len(read) == len(inputs) == len({id(end) for end in read})  # each is connected, once


def test_masters_find_the_step_of_the_package(example, structure):
    """libcosim's annotation stands in the experiment, OMSimulator's in the system."""
    (cosim,) = structure.iter(tag("osp:FixedStepAlgorithm"))
    (openmodelica,) = structure.find(tag("ssd:System")).iter(tag("oms:FixedStepMaster"))
    steps = cosim.attrib["baseStepSize"], openmodelica.attrib["stepSize"]
    assert [float(step) for step in steps] == [example.system.step] * 2
    assert openmodelica.attrib["description"] == "oms-ma"


def test_parameter_sets_have_one_name_and_set_parameters_in_their_units(example, structure):
    with zipfile.ZipFile(example.system.path) as archive:
        for component in structure.iter(tag("ssd:Component")):
            known = variables_of(archive, component.attrib["source"])
            (binding,) = component.iter(tag("ssd:ParameterBinding"))
            values = ElementTree.fromstring(archive.read(binding.attrib["source"]))
            assert values.attrib["name"] == ssp_package.START
            rows = list(values.iter(tag("ssv:Parameter")))
            assert rows
            for row in rows:
                variable = known[row.attrib["name"]]
                assert variable.attrib["causality"] == "parameter"
                assert row[0].tag == tag(f"ssv:{variable[0].tag}")
                assert row[0].attrib.get("unit") == variable[0].attrib.get("unit")


def test_a_unit_means_the_same_in_all_fmus(examples):
    meaning = {}
    for example in examples.values():
        for component in example.system.components:
            for unit, base in component.units.items():
                assert meaning.setdefault(unit, base) == base


def test_a_package_depends_on_the_sources_alone(example):
    first = example.system.path.read_bytes()
    assert example.system.write().read_bytes() == first


def test_only_parameters_can_be_start_values(examples):
    system = examples["robot_joint"].system
    wrong = replace(system.components[0], values={"theta": 1.0})
    with pytest.raises(ValueError, match=r"cam\.theta is no parameter"):
        replace(system, components=(wrong, *system.components[1:])).write()


# ---- the parts ----


@pytest.fixture(params=parts.PARTS, ids=lambda part: part.identifier)
def part(request, examples):
    return request.param


@pytest.fixture
def slave(part):
    with Fmu(part.path) as made:
        yield made


def test_parts_are_valid_and_export_all_functions(part, tmp_path):
    assert validate_fmu(str(part.path)) == []
    with zipfile.ZipFile(part.path) as archive:
        library = archive.extract(f"binaries/linux64/{part.identifier}.so", tmp_path)
    header = (compilation.build_fmu.fmi_headers() / "fmi2Functions.h").read_text()
    *_, common, _, for_co_simulation = re.split("Functions for FMI2 for .*", header)  # _: model exchange
    wanted = re.findall(r"FMI2_Export \w+TYPE +(\w+);", common + for_co_simulation)
    assert len(wanted) > 30
    exported = ctypes.CDLL(library)
    for name in wanted:
        assert hasattr(exported, name), name


def test_start_values_of_xml_and_binary_agree_and_reset_brings_them_back(part, slave):
    rows = [v for v in part.variables if v.causality in (variables.PARAMETER, variables.INPUT)]
    with zipfile.ZipFile(part.path) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    starts = {v.attrib["name"]: v[0].attrib.get("start") for v in root.iter("ScalarVariable")}

    def values():
        return {v.name: slave.get(v.name) for v in rows}

    told = {name: float(start) for name, start in starts.items() if start is not None}
    slave.start()
    assert values() == told
    slave.start(dict.fromkeys(told, 0.75))
    assert values() == dict.fromkeys(told, 0.75)
    slave.start()
    assert values() == told


def test_what_cannot_be_is_refused(part, slave):
    for name, value in (("omega", math.nan), ("omega", math.inf)):
        with pytest.raises(FmuError):
            slave.start({name: value})
    slave.start({})
    fixed = next(v for v in part.variables if v.causality == variables.PARAMETER)
    output = next(v for v in part.variables if v.causality == variables.OUTPUT)
    before = [slave.get(v.name) for v in part.variables]
    unknown, room = (ctypes.c_uint * 1)(len(part.variables)), (ctypes.c_double * 1)(1.0)
    for refused in (
        lambda: slave.set(fixed.name, 2.0),
        lambda: slave.set(output.name, 2.0),
        lambda: slave._instance.call("fmi2SetReal", unknown, 1, room),
        lambda: slave._instance.call("fmi2GetReal", unknown, 1, room),
        lambda: slave._instance.call("fmi2GetInteger", (ctypes.c_uint * 1)(0), 1, (ctypes.c_int * 1)()),
        lambda: slave.step(0.0),
        lambda: slave.step(math.nan),
        lambda: slave._instance.call("fmi2EnterInitializationMode"),
    ):
        with pytest.raises(FmuError):
            refused()
    assert [slave.get(v.name) for v in part.variables] == before
    slave.step(STEP)


@pytest.mark.parametrize(
    ("part", "name"),
    [(parts.MOTOR, "ratio"), (parts.PENDULUM_LOAD, "ratio"), (parts.SHANK_LOAD, "stride")],
)
def test_parameters_without_meaning_are_noticed(examples, part, name, capsys):
    with Fmu(part.path) as slave, pytest.raises(FmuError):
        slave.start({name: 0.0})


def test_a_controller_refuses_steps_beyond_its_tick(part, slave):
    slave.start({})
    if "tick" not in [v.name for v in part.variables]:
        slave.step(2.0 * TICK)
        return
    with pytest.raises(FmuError):
        slave.step(1.1 * TICK)
    slave.step(TICK)


@pytest.mark.parametrize("step", [1e-3, 2.5e-4, 3e-4, 5e-5, 7e-5])
def test_a_command_is_computed_two_steps_before_its_tick(examples, step):
    with Fmu(parts.KNEE_CONTROLLER.path) as slave:
        slave.start({})
        for k in range(round(0.2 / step)):
            newest = slave.get("newest")
            slave.step(step)
            if (due := slave.get("newest")) > newest:
                assert abs(due * TICK - (k + 2) * step) <= 0.501 * step
        assert newest == pytest.approx(0.2 / TICK, abs=3)


# ---- coupled: against the building blocks of the Python versions ----


def side_by_side(start, plan, controller, motor, load, ratio=1.0, offset=0.0):
    """The Python classes in the order of an explicit master: each takes what the others gave at the beginning
    of the step. A command is computed two steps before its tick, for the state that is expected then.

    `plan`: angle and speed of the output by tick; `controller(tick, angle, speed)`, `load(time, angle)`."""
    loop = CurrentLoop(motor, CURRENT_BANDWIDTH, CURRENT_RATE, STEP)
    ticks = len(plan) - 2
    rows = np.empty((ticks, 4))
    with Fmu(CAM) as slave:
        drive, sensors = slave.reals("tau"), slave.reals("theta", "omega")
        slave.start(start)

        def output():
            theta, omega = sensors.read()
            return offset + theta / ratio, omega / ratio

        angle, speed = output()
        command, pull = controller(0, angle, speed), load(0.0, angle)
        tau, heat, energy = pull / ratio, 0.0, 0.0
        for k in range(ticks * STEPS_PER_PERIOD):
            done = loop.run(command, speed)
            acting, tau = tau, (done.torque + pull) / ratio
            pull = load((k + 2.5) * STEP, angle + 2.5 * STEP * speed)
            if (k + 2) % STEPS_PER_PERIOD == 0:
                tick, lead = (k + 2) // STEPS_PER_PERIOD, 2.0 * STEP
                acceleration = (plan[tick + 1][1] - plan[tick][1]) / TICK
                then = angle + lead * speed + 0.5 * lead**2 * acceleration
                command = controller(tick, then, speed + lead * acceleration)
            drive.values[0] = acting
            drive.write()
            slave.step(STEP)
            angle, speed = output()
            heat += done.heat
            energy += done.energy
            if (k + 1) % STEPS_PER_PERIOD == 0:
                rows[k // STEPS_PER_PERIOD] = (angle - offset) * ratio, tau, heat, energy
    return dict(zip(("cam.theta", "motor.tau", "motor.heat", "motor.energy"), rows.T, strict=True))


def listed(angle, speed):
    return list(zip(angle.tolist(), speed.tolist(), strict=True))


def elbow_run(ticks):
    cam, load = elbow.design_cam(), elbow.weight(1.5)
    believed = elbow.controller(cam, 1.5)
    plan = listed(*elbow.MOTION.sample(TICK * np.arange(ticks + 2)))
    start = {
        **cam.parameters(),
        "inertia.shaft": elbow.inertia(1.5),
        "stop.upper": elbow.RANGE,
        "initial.theta": elbow.MOTION.start,
    }

    def controller(tick, angle, speed):
        return believed.torque(angle, speed, plan[tick], plan[tick + 1])

    return side_by_side(start, plan, controller, AK80_6, lambda time, angle: load.torque(angle))


def door_run(ticks):
    cam, load = car_door.design(), car_door.weight(car_door.NOSE_UP)
    believed = car_door.controller(cam, car_door.NOSE_UP)
    motion, ratio, opened = car_door.MOTION, car_door.RATIO, car_door.OPEN
    plan = listed(*motion.sample(motion.dwell + TICK * np.arange(ticks + 2)))
    start = {
        **cam.parameters(),
        "inertia.shaft": car_door.INERTIA / ratio**2,
        "stop.upper": ratio * opened,
        "initial.theta": ratio * (opened - motion.start),
    }

    def controller(tick, angle, speed):
        return believed.torque(angle, speed, plan[tick], plan[tick + 1])

    return side_by_side(
        start, plan, controller, car_door.MOTOR, lambda time, angle: load.torque(angle), -ratio, opened
    )


def knee_run(ticks):
    walker, cam = DESIGN_WALKER, knee.design_cam()
    pendulum, extension = walker.pendulum, full_extension(walker)
    inertia = knee.inertia(walker)
    impedance = knee.impedance(inertia)
    flexion, thigh, forward, upward = (
        FourierSeries(curve, walker.stride)
        for curve in (walker.knee, walker.thigh, walker.forward, walker.upward)
    )
    toe_off = SWING[0] * walker.stride
    times = toe_off + TICK * np.arange(ticks + 2)
    plan = listed(flexion.sample(times) - extension, flexion.sample(times, 1))
    start = {
        **cam.parameters(),
        "inertia.shaft": inertia,
        "stop.upper": knee.RANGE,
        "initial.theta": plan[0][0],
        "initial.omega": plan[0][1],
    }
    halves = toe_off + 0.5 * STEP * np.arange(
        2 * STEPS_PER_PERIOD * ticks + 5
    )  # loads are asked for at half steps
    tilt = np.column_stack([thigh.sample(halves, order) for order in range(5)]).tolist()
    ahead, above = (
        np.column_stack([path.sample(halves, order) for order in (2, 3, 4)]).tolist()
        for path in (forward, upward)
    )

    def load(time, angle):
        k = round(2.0 * time / STEP)
        return pendulum.drive(HingeMotion(tilt[k], ahead[k], above[k]), angle + extension)[0]

    def controller(tick, angle, speed):
        wanted = impedance.torque(angle - plan[tick][0], speed - plan[tick][1])
        return max(wanted, 0.0) if angle <= 0.0 else wanted

    return side_by_side(start, plan, controller, knee.MOTOR, load)


# The elbow lowers and holds the arm, the door opens and is held: the controllers move and rest in this time.
PYTHON = {"robot_joint": (elbow_run, 3000), "prosthetic_knee": (knee_run, 418), "car_door": (door_run, 3500)}


def package_run(example, step):
    """As long as in PYTHON."""
    ticks = PYTHON[example.system.name][1]
    return couple(example.system.path, step, round(ticks * TICK / step), WATCHED, round(TICK / step))


@pytest.fixture(scope="module")
def runs(examples):
    return {name: package_run(example, STEP) for name, example in examples.items()}


@pytest.mark.parametrize("name", NAMES)
def test_parts_in_c_do_what_the_python_classes_do(runs, name):
    """Sums are taken in other orders; the knee's cam is integrated to 1e-9, which amplifies rounding."""
    make, ticks = PYTHON[name]
    assert ticks <= round(systems.EXAMPLES[name]().system.duration / TICK)
    found, python = runs[name], make(ticks)
    for column, allowed in (
        ("cam.theta", 1e-12),
        ("motor.tau", 1e-9),
        ("motor.heat", 1e-10),
        ("motor.energy", 1e-10),
    ):
        assert np.max(np.abs(found[column] - python[column])) < allowed, column


@pytest.mark.parametrize(
    ("name", "apart"), [("robot_joint", 5e-7), ("car_door", 1e-6), ("prosthetic_knee", 5e-5)]
)
def test_beside_the_python_version(examples, runs, name, apart):
    """The Python version knows angle and speed when a tick begins. Here they are expected from two steps
    before, by the planned acceleration, from which the knee's differs most: its motor follows softly. So the
    distance shrinks with the step, down to what averaging the motor's torque over a tick makes in Python."""
    example = examples[name]
    fine, coarse = (example.package_run(run) for run in (runs[name], package_run(example, 2.0 * STEP)))
    original = example.python_run()
    ticks = len(fine.angle)
    assert np.max(np.abs(fine.reference - original.reference[:ticks])) < 1e-10
    distances = [np.max(np.abs(run.angle - original.angle[:ticks])) for run in (fine, coarse)]
    assert distances[0] < apart
    assert distances[1] > 1.5 * distances[0]
    assert np.max(np.abs(2.0 * fine.angle - coarse.angle - original.angle[:ticks])) < 0.5 * distances[0]
    for account in ("motor_heat", "supply", "cam_heat"):
        found, told = (getattr(run, account)[ticks - 1] for run in (fine, original))
        assert found == pytest.approx(told, rel=ssp_run.FIGURE_TOLERANCE)


@pytest.mark.parametrize(
    ("name", "apart"), [("robot_joint", 1e-5), ("car_door", 2e-5), ("prosthetic_knee", 1e-3)]
)
def test_steps_as_long_as_a_tick(examples, name, apart):
    """Then a command is on its way for two ticks."""
    example = examples[name]
    found, told = example.package_run(package_run(example, TICK)), example.python_run()
    assert np.max(np.abs(found.angle - told.angle[: len(found.angle)])) < apart


def test_the_order_of_components_does_not_matter(examples):
    """Side by side is side by side."""
    system = examples["prosthetic_knee"].system
    turned = replace(system, name="turned", components=system.components[::-1])
    try:
        runs = [couple(s.path if s is system else s.write(), STEP, 400, WATCHED) for s in (system, turned)]
    finally:
        turned.path.unlink(missing_ok=True)
    assert all(np.array_equal(runs[0][name], runs[1][name]) for name in WATCHED)


# ---- what runs the masters, without the masters ----


def test_a_program_in_a_master_is_told_what_to_run(examples, tmp_path, monkeypatch):
    system, file = examples["car_door"].system, tmp_path / "rows.csv"
    words = ssp_run.arguments(system, 7, file)
    monkeypatch.setattr(sys, "argv", ["host", *(str(word) for word in words)])
    work = package.from_arguments()
    assert (work.package, work.start, work.step) == (str(system.path), ssp_package.START, system.step)
    assert (work.rows, work.every, work.watched) == (7, STEPS_PER_PERIOD, list(WATCHED))
    known = {c.name: c.variables for c in system.components}
    assert all(split(name)[1] in known[split(name)[0]] for name in work.watched)
    work.save([[0.1 * k] * len(WATCHED) for k in range(7)])
    columns = players.read(file)
    assert all(columns[name].tolist() == [0.1 * k for k in range(7)] for name in WATCHED)


def runner(error=0.0, name="motor.tau", ticks=5):
    def run(system, count, file):
        assert count == 5
        columns = {watched: np.zeros(ticks) for watched in WATCHED}
        columns[name][3] += error
        return columns

    return run


def failing(error):
    def run(*_):
        raise error

    return run


@pytest.mark.parametrize(
    ("run", "wrong", "verdict"),
    [
        (runner(), False, "agrees"),
        (runner(9e-10), False, "agrees"),
        (runner(2e-9), True, "**differs**"),
        (runner(2e-9, "cam.energy.heat_cam1"), True, "**differs**"),
        (runner(float("nan")), True, "**differs**"),
        (runner(ticks=4), True, "**differs**"),
        (failing(Missing("no network")), False, "skipped: no network"),
        (failing(Failed("exit 1")), True, "**fails**: exit 1"),
    ],
)
def test_verdicts(examples, run, wrong, verdict):
    master = ssp_run.Master("ecos", "ecospy", run)
    expected = {name: np.zeros(5) for name in WATCHED}
    outcome = ssp_run.run_in(master, examples["robot_joint"].system, expected)
    assert (outcome.wrong, outcome.cells[-1]) == (wrong, verdict)
    assert len(outcome.cells) == len(ssp_run.MASTER_HEAD)


def test_verdicts_of_checkers(examples):
    seen = []
    assert not ssp_run.check("a checker", seen.append).wrong
    assert seen == [part.path for part in parts.PARTS]
    assert not ssp_run.check("a checker", failing(Missing("no java"))).wrong
    found = ssp_run.check("a checker", failing(Failed("no units")))
    assert found.wrong
    assert found.cells == ("a checker", "**Motor**: no units")


def test_the_story_is_compared():
    time = np.linspace(0.0, 1.0, 11)
    told = systems.Run(time, time + 1e-3, time, time, time, begin=5)
    assert told.figures() == pytest.approx(
        {
            "largest error [mrad]": 1.0,
            "motor heat [J]": 0.6,
            "from the supply [J]": 0.6,
            "heat in the cam [J]": 0.6,
        }
    )
    assert not any(row.wrong for row in ssp_run.compare("x", told, told))
    hot = replace(told, motor_heat=1.04 * time)
    assert [row.wrong for row in ssp_run.compare("x", hot, told)] == [False, False, True, False, False]
    late = replace(told, angle=time + 2e-4, reference=told.reference + 2e-4)
    assert [row.wrong for row in ssp_run.compare("x", late, told)] == [True, False, False, False, False]


def test_times_of_harmonics_and_variables_agree_with_the_c_code():
    text = (compilation.SOURCES / "reference.h").read_text()
    assert f"HARMONICS = {variables.HARMONICS}," in text
    for part in parts.PARTS:  # coefficients stand in a row: the C code takes them as an array
        names = [v.name for v in part.variables]
        for first in (n for n in names if n.endswith(".mean")):
            series = names[names.index(first) :][: 1 + 2 * variables.HARMONICS]
            assert {n.partition(".")[0] for n in series} == {first.partition(".")[0]}
            pairs = [n.partition(".")[2] for n in series[1:]]
            assert [(c, s) for c, s in pairwise(pairs)][::2] == [
                (f"cos{n}", f"sin{n}") for n in range(1, variables.HARMONICS + 1)
            ]
