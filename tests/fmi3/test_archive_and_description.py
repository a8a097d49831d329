"""FMI 3.0: the archive, its description and its sources."""

import re
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import build_fmu
import driver as fmi2
import driver3
import fmpy.validation
import pytest
from driver import ERROR, OK, ROOT
from driver3 import FORWARD, Driver
from fmi3_scenes import GENERAL, each_model
from lxml import etree

SCHEMAS = Path(fmpy.__file__).parent / "schema/fmi3"


@each_model
def test_xml_is_valid_by_the_schemas_of_the_standard(unzipped3, model):
    place = unzipped3[model.identifier]
    for name, schema in (
        ("modelDescription.xml", "fmi3ModelDescription"),
        ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3TerminalsAndIcons"),
        ("sources/buildDescription.xml", "fmi3BuildDescription"),
    ):
        checker = etree.XMLSchema(file=str(SCHEMAS / f"{schema}.xsd"))
        assert checker.validate(etree.parse(str(place / name))), checker.error_log
    assert fmpy.validation.validate_fmu(str(model.fmu)) == []
    assert (place / "modelDescription.xml").read_bytes() == model.xml.read_bytes()


@each_model
def test_nothing_is_in_it_that_should_not(unzipped3, model):
    place = unzipped3[model.identifier]
    top = {"binaries", "documentation", "extra", "modelDescription.xml", "sources", "terminalsAndIcons"}
    assert {p.name for p in place.iterdir()} == top
    assert not [p for p in (place / "sources").iterdir() if re.match(r"fmi2|emit|fmi3.*\.h", p.name)]
    assert (place / "documentation/licenses/license.txt").read_text() == (ROOT / "LICENSE").read_text()
    assert (place / "terminalsAndIcons/icon.png").read_bytes() == (
        ROOT / "modelDescription/model.png"
    ).read_bytes()
    listed = [
        e.attrib["name"]
        for e in ET.parse(place / "sources/buildDescription.xml").getroot().iter("SourceFile")
    ]
    sources = place / "sources"
    assert listed == sorted(path.relative_to(sources).as_posix() for path in sources.rglob("*.c"))


@each_model
def test_description_is_fresh(model):
    made = build_fmu.dual_cam(model.identifier, check=True, version=3)
    assert made.description.encode() == model.xml.read_bytes()
    assert made.path == model.fmu


@each_model
def test_variables_are_those_of_fmi2_and_some_more(model):
    types = {"Real": "Float64", "Integer": "Int32"}
    old = fmi2.models[model.identifier].variables
    for name, variable in old.items():
        mine = model.variables[name]
        assert mine.type == types.get(variable.type, variable.type)
        for attribute in ("reference", "causality", "variability", "start", "min", "max", "unit"):
            assert getattr(mine, attribute) == getattr(variable, attribute), name
    extra = set(model.variables) - set(old)
    assert extra == {n for n in model.variables if n == "time" or n.startswith("indicator.")}
    assert [n for n in model.variables if model.variables[n].causality == "independent"] == ["time"]
    references = [v.reference for v in model.variables.values()]
    assert len(set(references)) == len(references)


@each_model
def test_terminals_refer_to_variables_that_can_be_connected(unzipped3, model):
    path = unzipped3[model.identifier] / "terminalsAndIcons/terminalsAndIcons.xml"
    with zipfile.ZipFile(fmi2.models[model.identifier].fmu) as old:
        assert old.read("terminalsAndIcons/terminalsAndIcons.xml") == path.read_bytes()
    terminals = {t.attrib["name"]: t for t in ET.parse(path).getroot().iter("Terminal")}
    assert set(terminals) == {"shaft", "follower"}
    members = {
        name: {m.attrib["memberName"]: (m.attrib["variableName"], m.attrib["variableKind"]) for m in terminal}
        for name, terminal in terminals.items()
    }
    for listed in members.values():
        for variable, _ in listed.values():
            assert model.variables[variable].causality in ("input", "output")
    assert members["shaft"]["tau"] == ("tau", "inflow") and members["shaft"]["phi"] == ("theta", "signal")
    assert members["follower"]["f"] == ("F_ext", "outflow") and members["follower"]["s"] == ("z", "signal")


@each_model
def test_capabilities(model):
    common = {
        "modelIdentifier": model.identifier,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
        "providesAdjointDerivatives": "true",
        "providesPerElementDependencies": "true",
    }
    early = "true" if model is FORWARD else "false"
    old = fmi2.models[model.identifier].document.find("CoSimulation").attrib
    assert model.document.find("ModelExchange").attrib == common | {"needsCompletedIntegratorStep": "true"}
    assert model.document.find("CoSimulation").attrib == common | {
        "canHandleVariableCommunicationStepSize": "true",
        "maxOutputDerivativeOrder": old["maxOutputDerivativeOrder"],
        "providesIntermediateUpdate": "true",
        "mightReturnEarlyFromDoStep": early,
        "canReturnEarlyAfterIntermediateUpdate": early,
        "hasEventMode": "true",
    }
    inside = {e.attrib["name"] for e in model.document.iter() if e.attrib.get("intermediateUpdate") == "true"}
    causalities = ["input", "output"] if model is FORWARD else ["output"]
    assert inside == set(model.names(causality=causalities))
    states = {e.attrib["name"] for e in model.document.iter() if e.attrib.get("reinit") == "true"}
    assert states == ({"theta", "omega"} if model is FORWARD else set())


@each_model
def test_documentation(unzipped3, model):
    text = (unzipped3[model.identifier] / "documentation/index.html").read_text(encoding="utf-8")
    rows = re.findall(r"<tr><td><code>([^<]+)</code>", text)
    assert sorted(rows) == sorted(model.variables)
    assert "FMI 3.0" in text and "FMI 2" not in text and "fmi2" not in text and "$" not in text


@pytest.mark.parametrize("model", [FORWARD], ids=repr)
def test_the_sources_compile_from_there_alone_and_run_alike(unzipped3, libraries3, tmp_path, model):
    folder, headers = unzipped3[model.identifier] / "sources", tmp_path / "headers"
    headers.mkdir()
    for name in ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"):
        (headers / name).write_bytes((build_fmu.fmi_headers() / name).read_bytes())
    # without optimisation, which takes a third of the time and must give the same digits
    options = ["-std=c17", "-O0", "-fno-sanitize=undefined", "-ffp-contract=off", "-fPIC", "-shared"]
    options += ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    # as FMPy's create_cmake_project has it
    options += ["-DCO_SIMULATION", "-DMODEL_EXCHANGE", "-DFMI3_OVERRIDE_FUNCTION_PREFIX"]
    library = tmp_path / f"{model.identifier}.so"
    sources = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.c"))
    command = [*build_fmu.ZIG, *options, "-isystem", headers, *sources, "-lm", "-o", library]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    values = []
    for loaded in (driver3.load(library), libraries3[model.identifier]):
        fmu = Driver(loaded, model).start(GENERAL)
        fmu.step(0.02, tau=5.0, F_ext=3.0)
        values.append(fmu.everything())
        fmu.free()
    assert values[0] == values[1]


def test_all_functions_of_the_header_are_known():
    header = (build_fmu.fmi_headers() / "fmi3Functions.h").read_text()
    declared = set(re.findall(r"FMI3_Export \w+TYPE\s+(fmi3\w+);", header))
    assert declared == driver3.FUNCTIONS and len(declared) > 70


def test_statuses_are_those_of_fmi2():
    header = (build_fmu.fmi_headers() / "fmi3FunctionTypes.h").read_text()
    names = re.search(r"typedef enum \{([^}]*)\} fmi3Status", header).group(1).replace(",", " ").split()
    assert (names.index("fmi3OK"), names.index("fmi3Error")) == (OK, ERROR)
