"""modelDescription.xml: fresh, valid, complete, and true."""

import re
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
import zipfile

import pytest
from driver import FMU, GUID, ROOT, VARIABLES, XML
from fmpy.validation import validate_fmu

sys.path.insert(0, str(ROOT / "fmu_src"))
import build_fmu

DOCUMENT = ET.parse(XML).getroot()

# The names that others rely on, with unit, start value and causality.
INTERFACE = """
tau N.m 0 input
F_ext N 0 input
theta rad - output
omega rad/s - output
z m - output
v m/s - output
cam1.radius m 0.02 fixed
cam2.radius m 0.02 fixed
cam1.profile - 1 fixed
cam2.profile - 1 fixed
cam1.lead_angle rad 0.7853981633974483 fixed
cam2.lead_angle rad 0.7853981633974483 fixed
cam1.ellipse_a m 0.05 fixed
cam2.ellipse_a m 0.05 fixed
cam1.ellipse_b m 0.05 fixed
cam2.ellipse_b m 0.05 fixed
cam1.ellipse_curvature - -1 fixed
cam2.ellipse_curvature - -1 fixed
cam1.table - "" fixed
cam2.table - "" fixed
cam1.friction 1 0.14 tunable
cam2.friction 1 0.14 tunable
spring.preload N 50 tunable
spring.stiffness N/m 50000 tunable
spring.stiffness2 N/m2 0 tunable
spring.stiffness3 N/m3 0 tunable
damper.c_load N.s/m 0 tunable
damper.q_load N.s2/m2 0 tunable
damper.c_release N.s/m 0 tunable
damper.q_release N.s2/m2 0 tunable
inertia.shaft kg.m2 0.002 fixed
inertia.follower_mass kg 0 fixed
inertia.follower kg.m2 0 fixed
shaft.damping N.m.s/rad 0 fixed
stop.lower rad 0 fixed
stop.upper rad 1.3963 fixed
stop.restitution 1 0 fixed
initial.theta rad 0 fixed
initial.omega rad/s 0 fixed
contacts - 2 fixed
ledger - true fixed
alpha rad/s2 - local
gamma rad - local
spring.force N - local
damper.force N - local
cam1.reaction N - local
cam2.reaction N - local
cam1.sliding_speed m/s - local
cam2.sliding_speed m/s - local
torque_load N.m - local
torque_release N.m - local
efficiency 1 - local
mode - - local
events - - local
energy.work_in J - local
energy.work_ext J - local
energy.work_tuning J - local
energy.spring J - local
energy.kinetic J - local
energy.heat_cam1 J - local
energy.heat_cam2 J - local
energy.heat_damper J - local
energy.heat_shaft J - local
energy.heat_stop J - local
energy.residual J - local
peak.torque N.m - local
peak.omega rad/s - local
peak.reaction1 N - local
peak.reaction2 N - local
"""


def test_the_committed_file_is_what_the_emitter_prints():
    build_fmu.emit_description("DualCamForward", check=True)
    printed = subprocess.run(
        [ROOT / "build/host/emit_xml", "DualCamForward"], capture_output=True, check=True
    )
    assert printed.stdout == XML.read_bytes()


def test_the_fmu_holds_the_committed_file():
    with zipfile.ZipFile(FMU) as archive:
        assert archive.read("modelDescription.xml") == XML.read_bytes()


def test_fmpy_finds_nothing():
    assert validate_fmu(str(FMU)) == []


def fnv1a(content, basis):
    for byte in content:
        basis = (basis ^ byte) * 0x100000001B3 % 2**64
    return basis


def test_the_guid_is_a_hash_of_the_content():
    blank = XML.read_bytes().replace(GUID.encode(), b"")
    digits = "".join(f"{fnv1a(blank, basis):016x}" for basis in (0xCBF29CE484222325, 0x6C62272E07BB0142))
    assert GUID.strip("{}").replace("-", "") == digits
    assert [len(part) for part in GUID.strip("{}").split("-")] == [8, 4, 4, 4, 12]


def test_the_version_is_that_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert DOCUMENT.attrib["version"] == project["version"]
    assert DOCUMENT.attrib["license"] == project["license"]


@pytest.mark.parametrize("row", INTERFACE.split("\n")[1:-1])
def test_interface(row):
    name, unit, start, role = row.split()
    variable = VARIABLES[name]
    assert role in (variable.causality, variable.variability)
    assert (variable.unit or "-") == unit
    element = next(v for v in DOCUMENT.iter("ScalarVariable") if v.attrib["name"] == name)[0]
    assert (element.attrib.get("start", "-") or '""') == start


def test_nothing_is_missing_from_the_list_above():
    assert sorted(VARIABLES) == sorted(row.split()[0] for row in INTERFACE.split("\n")[1:-1])


def test_references_are_unique():
    assert len({v.reference for v in VARIABLES.values()}) == len(VARIABLES)


# kg, m, s, rad
BASE = {
    "1": (0, 0, 0, 0),
    "kg": (1, 0, 0, 0),
    "m": (0, 1, 0, 0),
    "s": (0, 0, 1, 0),
    "rad": (0, 0, 0, 1),
    "N": (1, 1, -2, 0),
    "J": (1, 2, -2, 0),
}


def exponents(unit):
    total = [0, 0, 0, 0]
    numerator, _, denominator = unit.partition("/")
    for sign, part in ((1, numerator), (-1, denominator)):
        for factor in filter(None, part.split(".")):
            symbol, power = re.fullmatch(r"(1|[A-Za-z]+)(\d*)", factor).groups()
            for i, exponent in enumerate(BASE[symbol]):
                total[i] += sign * exponent * int(power or 1)
    return total


def test_units_used_are_the_units_defined():
    defined = [u.attrib["name"] for u in DOCUMENT.iter("Unit")]
    assert len(set(defined)) == len(defined)
    assert set(defined) == {v.unit for v in VARIABLES.values()} - {None}
    assert all(v.unit for v in VARIABLES.values() if v.type == "Real")


@pytest.mark.parametrize("unit", [u.attrib["name"] for u in DOCUMENT.iter("Unit")])
def test_unit_is_what_its_name_says(unit):
    element = next(u for u in DOCUMENT.iter("Unit") if u.attrib["name"] == unit)
    attributes = element.find("BaseUnit").attrib
    assert [int(attributes.get(base, 0)) for base in ("kg", "m", "s", "rad")] == exponents(unit)
    assert set(attributes) <= {"kg", "m", "s", "rad"}


@pytest.mark.parametrize("element", list(DOCUMENT.iter("ScalarVariable")), ids=lambda e: e.attrib["name"])
def test_initial_is_what_fmi_allows(element):
    expected = {"parameter": "exact", "input": None, "output": "calculated", "local": "calculated"}
    assert element.attrib.get("initial") == expected[element.attrib["causality"]]
    assert ("start" in element[0].attrib) == (expected[element.attrib["causality"]] != "calculated")


@pytest.mark.parametrize("name", [n for n, v in VARIABLES.items() if isinstance(v.start, float | int)])
def test_start_values_are_in_range(name):
    variable = VARIABLES[name]
    assert variable.min <= variable.start <= variable.max


def test_capabilities():
    (co_simulation,) = DOCUMENT.findall("CoSimulation")
    assert DOCUMENT.find("ModelExchange") is None
    assert co_simulation.attrib == {
        "modelIdentifier": "DualCamForward",
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "true",
        "maxOutputDerivativeOrder": "2",
        "canRunAsynchronuously": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "false",
    }


def unknowns(kind):
    by_index = {v.index: name for name, v in VARIABLES.items()}
    return {
        by_index[int(u.attrib["index"])]: {by_index[int(i)] for i in u.attrib["dependencies"].split()}
        for u in DOCUMENT.find("ModelStructure").find(kind)
    }


def test_no_input_passes_through():
    assert unknowns("Outputs") == {name: set() for name in ("theta", "omega", "z", "v")}


def another(name, value):
    """A value of that parameter with which the mechanism is possible, too."""
    if VARIABLES[name].min == VARIABLES[name].max:
        return value
    return -0.5 if name == "stop.lower" else value * 1.25 + 0.01


@pytest.mark.parametrize(
    "name", [n for n, v in VARIABLES.items() if v.start is not None and v.type == "Real"]
)
def test_start_values_depend_on_what_the_structure_says(fmu, name):
    inertia = name if name.startswith("inertia") else "inertia.shaft"
    fmu.set({"initial.theta": 0.25, "initial.omega": 3.0, "inertia.shaft": 0.0, inertia: 1.0})
    known = unknowns("InitialUnknowns")
    before = {output: fmu.get(output) for output in known}
    # of an inertia it only counts whether there is any
    fmu.set({name: 0.0 if name.startswith("inertia") else another(name, fmu.get(name))})
    for output in known:
        changed = fmu.get(output) != before[output]
        assert changed == (name in known[output]), output
