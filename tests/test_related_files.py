"""The related files of FMI-LS-REF in each FMU, read as a master would."""

import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from driver import ROOT
from fmpy import fmi2, fmi3

from dualcam import export_fmu, read_design

LS = "{http://fmi-standard.org/fmi-ls-manifest}"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
NAMES = ("DualCamForward", "DualCamInverse")
FMUS = {
    f"{name} {v}": ROOT / "build" / ("" if v == 2 else "fmi3") / f"{name}.fmu"
    for name in NAMES
    for v in (2, 3)
}
ROLES = ("document", "experiment/smoke-test", "result", "parameter", "serialized-state/")


@pytest.fixture(scope="module", params=FMUS.values(), ids=FMUS)
def fmu(request, tmp_path_factory):
    """An FMU, unpacked."""
    folder = tmp_path_factory.mktemp("related")
    with zipfile.ZipFile(request.param) as archive:
        archive.extractall(folder)
    return folder


def manifest_of(fmu: Path) -> tuple[Path, ET.Element]:
    path = fmu / "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"
    return path.parent, ET.parse(path).getroot()


def files_of(fmu: Path, role: str) -> list[Path]:
    base, root = manifest_of(fmu)
    return [(base / r.attrib["source"]).resolve() for r in root if r.attrib["role"].startswith(role)]


def columns(path: Path) -> np.ndarray:
    return np.genfromtxt(path, delimiter=",", names=True)


def slave_of(fmu: Path, values: dict[str, float]):
    """An instance after its initialization, and the value references."""
    description = fmpy.read_model_description(str(fmu))
    kind = fmi3.FMU3Slave if description.fmiVersion.startswith("3") else fmi2.FMU2Slave
    identifier = description.coSimulation.modelIdentifier
    slave = kind(
        guid=description.guid, unzipDirectory=str(fmu), modelIdentifier=identifier, instanceName="related"
    )
    slave.instantiate()
    variables = {v.name: v for v in description.modelVariables}
    for name, value in values.items():
        variable = variables[name]
        getattr(slave, f"set{variable.type}")([variable.valueReference], [value])
    if kind is fmi2.FMU2Slave:
        slave.setupExperiment()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    return slave, {name: v.valueReference for name, v in variables.items()}


def get(slave, reference: int) -> float:
    read = slave.getFloat64 if isinstance(slave, fmi3.FMU3Slave) else slave.getReal
    return read([reference])[0]


def test_the_manifest_says_which_standard_it_follows(fmu):
    _, root = manifest_of(fmu)
    assert root.tag == "fmiReferences"
    assert root.attrib[f"{LS}fmi-ls-name"] == "org.fmi-standard.fmi-ls-ref"
    assert root.attrib[f"{LS}fmi-ls-version"] == "1.0.0-alpha.1"
    assert root.attrib[f"{LS}fmi-ls-description"]


def test_every_related_file_is_there(fmu):
    base, root = manifest_of(fmu)
    listed = files_of(fmu, "")
    assert all(path.is_file() for path in listed)
    assert all(related.attrib["role"].startswith(ROLES) for related in root)
    assert {r.attrib["role"].split("/")[0] for r in root} == {r.split("/")[0] for r in ROLES}
    assert {path for path in base.iterdir() if path.name != "fmi-ls-manifest.xml"} <= set(listed)


def experiment_of(fmu: Path):
    """Start, stop and step [s], inputs and results of the smoke test."""
    (path,) = files_of(fmu, "experiment/smoke-test")
    (experiment,) = ET.parse(path).getroot()
    settings = experiment.find("TransientSimulation").attrib
    given, wanted = (
        path.parent / experiment.find(kind).attrib["source"] for kind in ("Stimuli", "References")
    )
    return (
        *(float(settings[n]) for n in ("startTime", "stopTime", "stepSize")),
        columns(given),
        columns(wanted),
    )


def test_the_smoke_test_runs(fmu):
    """By FMPy alone, which holds the inputs of a step's beginning.

    The forward FMU then lags behind by at most a step, the inverse FMU by exactly one."""
    start, stop, step, given, wanted = experiment_of(fmu)
    found = fmpy.simulate_fmu(
        str(fmu),
        start_time=start,
        stop_time=stop,
        output_interval=step,
        input=given,
        output=[name for name in wanted.dtype.names if name != "time"],
        fmi_type="CoSimulation",
    )
    np.testing.assert_allclose(found["time"], wanted["time"], atol=1e-12)
    if "theta" in wanted.dtype.names:
        way = step * np.abs(wanted["omega"]).max()
        np.testing.assert_allclose(found["theta"], wanted["theta"], rtol=0.0, atol=way)
    else:
        for name in ("tau", "z", "v"):
            size = np.abs(wanted[name]).max()
            np.testing.assert_allclose(found[name][1:], wanted[name][:-1], rtol=0.0, atol=1e-11 * size)


def values_of(parameter_set: Path) -> dict[str, float]:
    root = ET.parse(parameter_set).getroot()
    numbers = {p.attrib["name"]: p[0] for p in root.iter(f"{SSV}Parameter")}
    return {
        name: (int if n.tag == f"{SSV}Integer" else float)(n.attrib["value"]) for name, n in numbers.items()
    }


def test_parameter_sets_are_accepted_and_their_units_are_the_fmu_s(fmu):
    variables = {v.name: v for v in fmpy.read_model_description(str(fmu)).modelVariables}
    sets = files_of(fmu, "parameter")
    assert len(sets) == 3
    for path in sets:
        for parameter in ET.parse(path).getroot().iter(f"{SSV}Parameter"):
            assert variables[parameter.attrib["name"]].unit == parameter[0].attrib.get("unit")
        slave, _ = slave_of(fmu, values_of(path))
        slave.doStep(0.0, 1e-3)
        slave.terminate()
        slave.freeInstance()


def test_the_serialized_state_is_that_of_the_page(fmu):
    """One step of 0.2 s under the inputs that documentation/fmi-ls-ref.html names, and both go on alike."""
    (path,) = files_of(fmu, "serialized-state/")
    names = {v.name for v in fmpy.read_model_description(str(fmu)).modelVariables if v.causality == "input"}
    inputs = {"tau": 8.0} if "tau" in names else {"theta": 0.7, "omega": 2.0}
    fresh, references = slave_of(fmu, inputs)
    restored, _ = slave_of(fmu, {})
    fresh.doStep(0.0, 0.2)
    state = restored.deserializeFMUState(path.read_bytes())
    restored.setFMUState(state)
    restored.freeFMUState(state)
    for slave in (fresh, restored):
        slave.doStep(0.2, 0.1)
    for name in ("z", "v", "energy.spring", "energy.heat_cam1"):
        assert get(fresh, references[name]) == get(restored, references[name])
    for slave in (fresh, restored):
        slave.terminate()
        slave.freeInstance()


def test_an_exported_fmu_lists_its_own_files(tmp_path):
    design = tmp_path / "mine.toml"
    design.write_text("[cam1]\nfriction = 0.1\n")
    path = export_fmu(read_design(design), tmp_path / "Mine.fmu")
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    assert all(file.is_file() for file in files_of(folder, ""))
    assert [p.name for p in files_of(folder, "result")] == ["Mine_ref.csv"]
    assert not files_of(folder, "parameter") and not files_of(folder, "serialized-state")
    *_, given, wanted = experiment_of(folder)
    assert given["time"][-1] == wanted["time"][-1] == 1.0
