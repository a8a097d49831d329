"""The examples as SSP packages: their files, their parts, and what they do when coupled."""

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
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from lxml import etree

sys.path.insert(0, str(ROOT / "masters/hosts"))
sys.path.insert(0, str(ROOT / "masters"))
sys.path.insert(0, str(ROOT / "system_examples"))

import blocks
import car_door
import package
import players
import prosthetic_knee
import robot_joint
import ssp_packages
import ssp_parts
import ssp_run
import ssp_systems
from fmu import Slave
from install import Failed, Missing
from ssp_packages import couple, split, tag
from ssp_systems import PER_TICK, STEP, WATCHED

NAMES = list(ssp_systems.EXAMPLES)
SCHEMAS = Path(fmpy.__file__).parent / "ssp/schema"
TICK = 1e-3  # s
CAM = ROOT / "build/DualCamForward.fmu"


@pytest.fixture(scope="module")
def examples():
    ssp_parts.build()
    found = {name: make() for name, make in ssp_systems.EXAMPLES.items()}
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


def variables(archive, source):
    """Of an FMU in a package, by name."""
    with archive.open(source) as file, zipfile.ZipFile(file) as fmu:
        root = ElementTree.fromstring(fmu.read("modelDescription.xml"))
    return {v.attrib["name"]: v for v in root.iter("ScalarVariable")}


def test_connectors_are_variables_and_connections_join_equal_units(example, structure):
    connectors = {}
    declared = {unit.attrib["name"] for unit in structure.iter(tag("ssc:Unit"))}
    with zipfile.ZipFile(example.system.path) as archive:
        for component in structure.iter(tag("ssd:Component")):
            known = variables(archive, component.attrib["source"])
            for connector in component.iter(tag("ssd:Connector")):
                variable = known[connector.attrib["name"]]
                assert connector.attrib["kind"] == variable.attrib["causality"]
                assert connector[0].tag == tag(f"ssc:{variable[0].tag}")
                assert connector[0].attrib.get("unit") == variable[0].attrib.get("unit")
                assert connector[0].attrib.get("unit") in declared | {None}
                connectors[component.attrib["name"], connector.attrib["name"]] = connector
    read = []
    for connection in structure.iter(tag("ssd:Connection")):
        start, end = (
            connectors[connection.attrib[f"{side}Element"], connection.attrib[f"{side}Connector"]]
            for side in ("start", "end")
        )
        assert (start.attrib["kind"], end.attrib["kind"]) == ("output", "input")
        assert start[0].attrib["unit"] == end[0].attrib["unit"]
        read.append(end)
    inputs = [connector for connector in connectors.values() if connector.attrib["kind"] == "input"]
    assert len(read) == len(inputs) == len({id(end) for end in read})  # each is connected, once


def test_parameter_sets_have_one_name_and_set_parameters_in_their_units(example, structure):
    with zipfile.ZipFile(example.system.path) as archive:
        for component in structure.iter(tag("ssd:Component")):
            known = variables(archive, component.attrib["source"])
            (binding,) = component.iter(tag("ssd:ParameterBinding"))
            values = ElementTree.fromstring(archive.read(binding.attrib["source"]))
            assert values.attrib["name"] == ssp_packages.START
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
        ssp_packages.parameters(wrong)


# ---- the parts ----


@pytest.fixture(params=ssp_parts.PARTS, ids=lambda part: part.identifier)
def part(request, examples):
    return request.param


@pytest.fixture
def slave(part):
    with Slave(part.path) as made:
        yield made


def test_parts_are_valid_and_export_all_functions(part, tmp_path):
    assert validate_fmu(str(part.path)) == []
    with zipfile.ZipFile(part.path) as archive:
        library = archive.extract(f"binaries/linux64/{part.identifier}.so", tmp_path)
    header = (ssp_parts.build_fmu.fmi_headers() / "fmi2Functions.h").read_text()
    *_, common, _, for_co_simulation = re.split("Functions for FMI2 for .*", header)  # _: model exchange
    wanted = re.findall(r"FMI2_Export \w+TYPE +(\w+);", common + for_co_simulation)
    assert len(wanted) > 30
    exported = ctypes.CDLL(library)
    for name in wanted:
        assert hasattr(exported, name), name


def test_start_values_of_xml_and_binary_agree_and_reset_brings_them_back(part, slave):
    rows = [v for v in part.variables if v.causality != ssp_parts.OUTPUT]

    def values():
        return [slave.get(v.name) for v in rows]

    assert values() == [v.start for v in rows]
    settable = [v.name for v in rows if v.causality in (ssp_parts.PARAMETER, ssp_parts.INPUT)]
    slave.start({name: 0.75 for name in settable})
    assert [slave.get(name) for name in settable] == [0.75] * len(settable)
    slave._fmu.reset()
    assert values() == [v.start for v in rows]


def test_what_cannot_be_is_refused(part, slave):
    for name, value in (("omega", math.nan), ("omega", math.inf)):
        with pytest.raises(FMICallException):
            slave.set(name, value)
    slave.start({})
    fixed = next(v for v in part.variables if v.causality == ssp_parts.PARAMETER)
    output = next(v for v in part.variables if v.causality == ssp_parts.OUTPUT)
    before = [slave.get(v.name) for v in part.variables]
    for refused in (
        lambda: slave.set(fixed.name, 2.0),
        lambda: slave.set(output.name, 2.0),
        lambda: slave._fmu.setReal([len(part.variables)], [1.0]),
        lambda: slave._fmu.getReal([len(part.variables)]),
        lambda: slave._fmu.getInteger([0]),
        lambda: slave.step(0.0),
        lambda: slave.step(math.nan),
        lambda: slave._fmu.enterInitializationMode(),
    ):
        with pytest.raises(FMICallException):
            refused()
    assert [slave.get(v.name) for v in part.variables] == before
    slave.step(STEP)


def test_a_controller_refuses_to_skip_a_sample(part, slave):
    slave.start({})
    if "tick" not in [v.name for v in part.variables]:
        slave.step(2.0 * TICK)
        return
    with pytest.raises(FMICallException):
        slave.step(1.1 * TICK)
    slave.step(TICK)


@pytest.mark.parametrize("step", [1e-3, 2.5e-4, 3e-4, 5e-5, 7e-5])
def test_a_controller_samples_once_per_tick(examples, step):
    with Slave(ssp_parts.KNEE_CONTROLLER.path) as slave:
        slave.start({})
        for k in range(round(0.2 / step)):
            slave.step(step)
            end = (k + 0.5) * step  # a sample is taken by the step that begins nearest to it
            assert slave.get("samples") == math.floor(end / TICK + 1e-9) + 1


# ---- coupled: against the building blocks of the Python versions ----


def side_by_side(start, controller, motor, load, load_torque, count, ratio=1.0):
    """The Python classes in the order of an explicit master: each takes what the others gave at the beginning
    of the step. `controller(tick, theta, omega)`, `load(time, theta)`."""
    loop = blocks.CurrentLoop(motor, robot_joint.CURRENT_BANDWIDTH, robot_joint.CURRENT_RATE, STEP)
    rows = np.empty((count // PER_TICK, 4))
    command, pull, tau = 0.0, load_torque, load_torque / ratio
    heat = energy = 0.0
    with Slave(CAM) as slave:
        drive, sensors = slave.reals("tau"), slave.reals("theta", "omega")
        slave.start(start)
        theta, omega = sensors.read()
        for k in range(count):
            done = loop.run(command, omega / ratio)
            acting, tau = tau, (done.torque + pull) / ratio
            pull = load((k + 2.5) * STEP, theta + 2.5 * STEP * omega)
            if k % PER_TICK == 0:
                command = controller(k // PER_TICK, theta, omega)
            drive.values[0] = acting
            drive.write()
            slave.step(STEP)
            theta, omega = sensors.read()
            heat += done.heat
            energy += done.energy
            if (k + 1) % PER_TICK == 0:
                rows[k // PER_TICK] = theta, tau, heat, energy
    return dict(zip(("cam.theta", "motor.tau", "motor.heat", "motor.energy"), rows.T, strict=True))


def elbow(ticks):
    e = robot_joint
    cam, load = e.design_cam(), e.gravity(1.5)
    believed = e.JointController(
        inertia=e.AK80_6.inertia + e.arm_inertia(1.5 + e.PAYLOAD_ERROR),
        load=e.gravity(1.5 + e.PAYLOAD_ERROR),
        cam=e.with_friction(cam, e.FRICTION_BELIEVED),
        limit=e.AK80_6.peak_torque,
    )
    angle, speed = e.MOTION.sample(TICK * np.arange(ticks + 1))
    plan = list(zip(angle.tolist(), speed.tolist(), strict=True))
    start = {
        **cam.parameters(),
        "inertia.shaft": e.AK80_6.inertia + e.arm_inertia(1.5),
        "stop.upper": e.RANGE,
        "initial.theta": e.MOTION.start,
    }
    return side_by_side(
        start,
        lambda tick, theta, omega: believed.torque(theta, omega, plan[tick], plan[tick + 1]),
        e.AK80_6,
        lambda time, theta: load.torque(theta),
        load.torque(e.MOTION.start),
        ticks * PER_TICK,
    )


def door(ticks):
    e = car_door
    hold, load = e.design(), e.weight(e.NOSE_UP)
    believed = e.SpeedController(
        e.weight(e.NOSE_UP, e.MASS_BELIEVED * e.MASS),
        replace(hold, cam=e.with_friction(hold.cam, e.FRICTION_BELIEVED)),
    )
    plan = e.MOTION.sample(e.MOTION.dwell + TICK * np.arange(ticks + 1))[1].tolist()
    start = {
        **hold.parameters(),
        "inertia.shaft": e.INERTIA / e.RATIO**2,
        "stop.upper": e.RATIO * e.OPEN,
        "initial.theta": e.RATIO * (e.OPEN - e.MOTION.start),
    }

    def angle(theta):
        return e.OPEN - theta / e.RATIO

    return side_by_side(
        start,
        lambda tick, theta, omega: believed.torque(
            angle(theta), -omega / e.RATIO, plan[tick], plan[tick + 1]
        ),
        e.MOTOR,
        lambda time, theta: load.torque(angle(theta)),
        load.torque(e.MOTION.start),
        ticks * PER_TICK,
        -e.RATIO,
    )


def knee(ticks):
    e = prosthetic_knee
    walker, cam = e.DESIGN_WALKER, e.design_cam()
    swing, pendulum = e.swing(walker, 1.0), walker.pendulum
    inertia = pendulum.inertia + e.AK80_6_BELT.inertia
    impedance = e.impedance(inertia)
    count = ticks * PER_TICK
    since = e.SWING[0] * walker.stride + STEP * (np.arange(count) + 2.5)
    thigh, forward, upward = (
        blocks.Periodic(curve, walker.stride) for curve in (walker.thigh, walker.forward, walker.upward)
    )
    tilt = np.column_stack([thigh.sample(since, order) for order in range(5)]).tolist()
    ahead, above = (
        np.column_stack([path.sample(since, order) for order in (2, 3, 4)]).tolist()
        for path in (forward, upward)
    )

    def load(time, theta):
        k = round(time / STEP - 2.5)
        hinge = blocks.HingeMotion(tilt[k], ahead[k], above[k])
        return pendulum.drive(hinge, theta + swing.extension)[0]

    def controller(tick, theta, omega):
        wanted = impedance.torque(theta - swing.angle[tick], omega - swing.speed[tick])
        return max(wanted, 0.0) if theta <= 0.0 else wanted

    start = {
        **cam.parameters(),
        "inertia.shaft": inertia,
        "stop.upper": e.RANGE,
        "initial.theta": swing.angle[0],
        "initial.omega": swing.speed[0],
    }
    first = pendulum.drive(swing.hinge[0], swing.angle[0] + swing.extension)[0]
    return side_by_side(start, controller, e.AK80_6_BELT, load, first, count)


# The elbow lowers and holds the arm, the door opens and is held: the controllers move and rest in this time.
PYTHON = {"robot_joint": (elbow, 3000), "prosthetic_knee": (knee, 418), "car_door": (door, 3500)}


@pytest.fixture(scope="module")
def runs(examples):
    """Of the packages, by name and communication step; so long as in PYTHON."""
    return {
        (name, step): couple(
            example.system.path, step, round(PYTHON[name][1] * TICK / step), WATCHED, round(TICK / step)
        )
        for name, example in examples.items()
        for step in (STEP, 2.0 * STEP)
    }


@pytest.mark.parametrize("name", NAMES)
def test_parts_in_c_do_what_the_python_classes_do(runs, name):
    """Sums are taken in other orders; the knee's cam is integrated to 1e-9, which amplifies rounding."""
    make, ticks = PYTHON[name]
    assert ticks <= round(ssp_systems.EXAMPLES[name]().system.duration / TICK)
    package_run, python = runs[name, STEP], make(ticks)
    for column, allowed in (
        ("cam.theta", 1e-12),
        ("motor.tau", 1e-9),
        ("motor.heat", 1e-10),
        ("motor.energy", 1e-10),
    ):
        assert np.max(np.abs(package_run[column] - python[column])) < allowed, column


@pytest.mark.parametrize("name", NAMES)
def test_what_differs_from_the_python_version_is_the_steps_doing(examples, runs, name):
    """The delay is two steps. At twice the step the distance is twice as large, and extrapolated to none it
    is less than a fifth; what remains is the motor's torque averaged over a tick in Python."""
    example = examples[name]
    fine, coarse = (example.course(runs[name, step]) for step in (STEP, 2.0 * STEP))
    original = example.original()
    ticks = len(fine.angle)
    assert np.max(np.abs(fine.reference - original.reference[:ticks])) < 1e-12
    distances = [np.max(np.abs(run.angle - original.angle[:ticks])) for run in (fine, coarse)]
    assert distances[0] < ssp_run.ANGLE_APART
    assert 1.8 < distances[1] / distances[0] < 2.2
    vanishing = 2.0 * fine.angle - coarse.angle - original.angle[:ticks]
    assert np.max(np.abs(vanishing)) < 0.2 * distances[0]
    for account in ("motor_heat", "supply", "cam_heat"):
        found, told = (getattr(run, account)[ticks - 1] for run in (fine, original))
        assert found == pytest.approx(told, rel=ssp_run.NUMBERS_APART)


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
    assert (work.package, work.start, work.step) == (str(system.path), ssp_packages.START, system.step)
    assert (work.rows, work.every, work.watched) == (7, PER_TICK, list(WATCHED))
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
    outcome = ssp_run.play(master, examples["robot_joint"].system, expected)
    assert (outcome.wrong, outcome.cells[-1]) == (wrong, verdict)
    assert len(outcome.cells) == len(ssp_run.MASTER_HEAD)


def test_the_story_is_compared():
    time = np.linspace(0.0, 1.0, 11)
    told = ssp_systems.Course(time, time + 1e-3, time, time, time, begin=5)
    assert told.numbers() == pytest.approx(
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


def test_the_page_lists_every_run():
    lines = (ROOT / "docs/ssp.md").read_text().split("\n")
    for name in NAMES:
        for master in ssp_run.MASTERS:
            row = f"| {name} | {master.name} | {master.version} |"
            assert any(re.sub(" +", " ", line).startswith(row) for line in lines)
    assert not any("**" in line for line in lines if line.startswith("|"))


def test_times_of_harmonics_and_variables_agree_with_the_c_code():
    text = (ssp_parts.SOURCES / "reference.h").read_text()
    assert f"HARMONICS = {ssp_parts.HARMONICS}," in text
    for part in ssp_parts.PARTS:  # coefficients stand in a row: the C code takes them as an array
        names = [v.name for v in part.variables]
        for first in (n for n in names if n.endswith(".mean")):
            series = names[names.index(first) :][: 1 + 2 * ssp_parts.HARMONICS]
            assert {n.partition(".")[0] for n in series} == {first.partition(".")[0]}
            pairs = [n.partition(".")[2] for n in series[1:]]
            assert [(c, s) for c, s in pairwise(pairs)][::2] == [
                (f"cos{n}", f"sin{n}") for n in range(1, ssp_parts.HARMONICS + 1)
            ]
