"""The SSP package of the spring clamp: parts beside the Python version, connections to parameters."""

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from driver import ROOT
from fmpy.ssp.simulation import simulate_ssp
from lxml import etree
from ssp_structures import connections_of

from dualcam import Fmu
from dualcam.errors import FmuError
from dualcam.systems.blocks.grease import CELSIUS
from dualcam.systems.machines import clamp
from system_examples.ssp import clamp as system_module
from system_examples.ssp import clamp_runs, compilation, parts
from system_examples.ssp.coupling import couple
from verification.masters.hosts import package
from verification.masters.install import Failed, Missing

CYCLES = 40
SCHEMAS = Path(fmpy.__file__).parent / "ssp/schema"
CAM = ROOT / "build/DualCamForward.fmu"


@pytest.fixture(scope="module")
def package_of():
    compilation.build()
    found = {}
    for connected in (True, False):
        found[connected] = system_module.clamp_system(CYCLES, parameter_connections=connected)
        found[connected].write()
    return found


@pytest.fixture(scope="module")
def coupled(package_of):
    steps = clamp.SAMPLES_PER_CYCLE
    return couple(package_of[True].path, clamp.SAMPLE, CYCLES * steps, system_module.WATCHED, steps)


@pytest.fixture(scope="module")
def record():
    with Fmu(CAM) as fmu:
        return clamp.run(fmu, CYCLES)


# ---- the run ----


@pytest.mark.parametrize("name", ["contact", "housing"])
def test_temperatures_are_those_of_the_python_version(coupled, record, name):
    expected = np.array([getattr(state, name) for state in record.thermal[1:]])
    assert expected[-1] > expected[0] + 0.1
    assert np.max(np.abs(coupled[f"thermal.temperature.{name}"] - expected)) < 1e-9


@pytest.mark.parametrize("name", ["heat_in", "heat_out"])
def test_heat_from_the_energy_balance_is_that_of_the_ledger(coupled, record, name):
    """The part computes the heat from torque and motion, the Python version reads the FMU's ledger."""
    expected = np.array([getattr(state, name) for state in record.thermal[1:]])
    assert np.max(np.abs(coupled[f"thermal.{name}"] - expected)) < 1e-11 * record.ledger_heat
    ledger = coupled["cam.energy.heat_cam1"] + coupled["cam.energy.heat_cam2"]
    assert np.max(np.abs(coupled["thermal.heat_in"] - ledger)) < 1e-11 * record.ledger_heat


def test_without_the_connections_the_friction_stays_cold(package_of, coupled, record):
    steps = clamp.SAMPLES_PER_CYCLE
    cold = couple(package_of[False].path, clamp.SAMPLE, CYCLES * steps, system_module.WATCHED, steps)
    assert cold["thermal.heat_in"][-1] > 1.2 * coupled["thermal.heat_in"][-1]
    with Fmu(CAM) as fmu:
        expected = clamp.run(fmu, CYCLES, warming=False).thermal[-1]
    assert cold["thermal.temperature.contact"][-1] == pytest.approx(expected.contact, abs=1e-9)


def test_thermal_network_balances_and_settles():
    """A part that gets a constant torque over a constant motion, without spring: the power is tau omega."""
    values = {"spring.preload": 0.0, "spring.stiffness": 0.0, "inertia": 0.0, "air": 300.0, "period": 10.0}
    with Fmu(parts.THERMAL_NETWORK.path) as fmu:
        fmu.start(values | {"tau": 2.0})
        inputs = fmu.reals("tau", "theta", "omega", "z")
        for k in range(1, 8001):
            fmu.step(10.0)
            inputs.values = [2.0, 2.5 * 10.0 * k, 2.5, 0.0]
            inputs.write()
        housing = 300.0 + 5.0 / 0.25
        assert fmu.real("temperature.housing") == pytest.approx(housing, rel=1e-9)
        assert fmu.real("temperature.contact") == pytest.approx(housing + 5.0 / 0.5, rel=1e-9)
        kept = 50.0 * (fmu.real("temperature.contact") - 300.0) + 500.0 * (housing - 300.0)
        assert fmu.real("heat_in") == pytest.approx(5.0 * 10.0 * 7999, rel=1e-12)
        assert fmu.real("heat_out") + kept == pytest.approx(fmu.real("heat_in"), rel=1e-9)


def test_thermal_network_refuses_what_has_no_meaning(package_of, capsys):
    with Fmu(parts.THERMAL_NETWORK.path) as fmu:
        with pytest.raises(FmuError):
            fmu.start({"oil.span": 0.0})
        for name in ("capacity.contact", "conductance.air", "period"):
            fmu.start({name: 0.0})
            with pytest.raises(FmuError):
                fmu.step(1.0)


# ---- connections that end at parameters ----


def test_a_tunable_parameter_takes_values_between_steps():
    """What a connection to a parameter needs of the FMU: FMI 2.0 allows tunable parameters between steps."""
    with Fmu(CAM) as fmu:
        fmu.start(clamp.plant_parameters(CELSIUS + 5.0) | {"tau": 25.0})
        friction = fmu.reals("cam1.friction_viscous")
        fmu.step(0.1)
        cold = fmu.real("cam1.friction_coefficient")
        friction.values[0] = 0.5 * friction.read()[0]
        friction.write()
        warm = fmu.real("cam1.friction_coefficient")
        rise = 0.5 * clamp.GREASE.law(CELSIUS + 5.0)[1] * abs(fmu.real("cam1.sliding_speed"))
        assert cold - warm == pytest.approx(rise, rel=1e-9)


@pytest.mark.parametrize("connected", [True, False])
def test_structure_is_valid_and_ends_at_inputs_and_tunable_parameters(package_of, connected):
    with zipfile.ZipFile(package_of[connected].path) as archive:
        text = archive.read("SystemStructure.ssd")
    etree.XMLSchema(etree.parse(str(SCHEMAS / "SystemStructureDescription.xsd"))).assertValid(
        etree.fromstring(text)
    )
    kinds = []
    for start, end in connections_of(ElementTree.fromstring(text)):
        assert start.attrib["kind"] == "output"
        kinds.append(end.attrib["kind"])
    assert kinds.count("parameter") == (4 if connected else 0)
    assert kinds.count("input") == 7
    with Fmu(CAM) as fmu:
        for _, end in system_module.FRICTION_CONNECTIONS:
            assert fmu.variable(end.partition(".")[2]).variability == "tunable"


def test_fmpy_ignores_connections_to_parameters(package_of):
    """FMPy also ignores start values: all FMUs have their own, and the cam moves nevertheless."""
    runs = [simulate_ssp(str(system.path), stop_time=1.0, step_size=1e-3) for system in package_of.values()]
    assert np.ptp(runs[0]["cam.theta"]) > 0.1
    assert runs[0]["thermal.friction_viscous"][1] > 0.5
    assert np.array_equal(runs[0]["cam.theta"], runs[1]["cam.theta"])


# ---- what runs the masters, without the masters ----


def test_a_script_is_told_what_to_pass_on(monkeypatch):
    words = ["package.ssp", "start", "0.005", "3", "600", "rows.csv", "cam.theta", "thermal.a->cam.cam1.b"]
    monkeypatch.setattr("sys.argv", ["host", *words])
    work = package.from_arguments()
    assert (work.watched, work.passed) == (["cam.theta"], [("thermal.a", "cam.cam1.b")])


def failing(reason):
    def run(*_):
        raise reason

    return run


REFUSAL = "Only variables with causality 'input' may be used as target variables in a connection."


@pytest.mark.parametrize(
    ("host", "refused", "wrong", "verdict"),
    [
        (lambda words, file: ROWS, False, False, "agrees"),
        (lambda words, file: ROWS | {"cam.theta": np.full(3, 2e-7)}, False, True, "**differs**"),
        (lambda words, file: ROWS, True, True, "**accepts parameters**"),
        (failing(Failed(REFUSAL)), True, False, "refuses parameters"),
        (failing(Failed(REFUSAL)), False, True, f"**fails**: {REFUSAL}"),
        (failing(Failed("exit 1")), True, True, "**fails**: exit 1"),
        (failing(Missing("no network")), True, False, "skipped: no network"),
    ],
)
def test_verdicts(package_of, host, refused, wrong, verdict):
    case = clamp_runs.Case("ecos", "ecospy", host, clamp_runs.CONNECTIONS, refused)
    outcome = clamp_runs.run_case(case, {clamp_runs.CONNECTIONS: package_of[True]}, ROWS)
    assert (outcome.wrong, outcome.cells[-1]) == (wrong, verdict)
    assert len(outcome.cells) == len(clamp_runs.HEAD)


ROWS = {name: np.zeros(3) for name in system_module.WATCHED}


def test_only_a_script_passes_values_on(package_of):
    told = []

    def host(words, file):
        told.append([word for word in words if "->" in str(word)])
        return ROWS

    for passed_by in (clamp_runs.CONNECTIONS, clamp_runs.SCRIPT):
        clamp_runs.rows_of(clamp_runs.Case("x", "x", host, passed_by), package_of[True], 3)
    assert [len(words) for words in told] == [0, 4]


def test_the_row_beside_python_is_the_coupled_run(coupled):
    outcome = clamp_runs.beside_python(coupled)
    assert not outcome.wrong
    hot = coupled | {"thermal.heat_in": coupled["thermal.heat_in"] + 1.0}
    assert clamp_runs.beside_python(hot).wrong
