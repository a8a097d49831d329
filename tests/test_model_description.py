"""modelDescription.xml of both FMUs: fresh, valid, complete, and true."""

import difflib
import math
import re
import subprocess
import tomllib
import zipfile
from pathlib import Path

import build_fmu
import fmus
import pytest
from driver import OK, ROOT, models
from fmpy.validation import validate_fmu

FORWARD, INVERSE = models.values()


@pytest.fixture(scope="session", params=models.values(), ids=repr)
def model(request):
    return request.param


def for_each(items):
    """Parametrizes `item` over items(model) of each FMU."""
    pairs = [(m, item) for m in models.values() for item in items(m)]
    return pytest.mark.parametrize(("model", "item"), pairs, indirect=["model"], ids=str)


def test_the_committed_file_is_what_the_emitter_prints(model):
    build_fmu.emit_description(model.identifier, 2, check=True)
    sources = build_fmu.core_sources(model.identifier)
    names = [source.relative_to(build_fmu.CORE).as_posix() for source in sources]
    emitter = ROOT / f"build/host/emit_{model.identifier}_2"
    printed = subprocess.run([emitter, *names], capture_output=True, check=True)
    assert printed.stdout == model.xml.read_bytes()


def test_the_fmu_holds_the_committed_file(model):
    with zipfile.ZipFile(model.fmu) as archive:
        assert archive.read("modelDescription.xml") == model.xml.read_bytes()


def test_fmpy_finds_nothing(model):
    assert validate_fmu(str(model.fmu)) == []


def fnv1a(content, basis):
    for byte in content:
        basis = (basis ^ byte) * 0x100000001B3 % 2**64
    return basis


def test_the_guid_is_a_hash_of_the_content(model):
    blank = model.xml.read_bytes().replace(model.guid.encode(), b"")
    digits = "".join(f"{fnv1a(blank, basis):016x}" for basis in (0xCBF29CE484222325, 0x6C62272E07BB0142))
    assert model.guid.strip("{}").replace("-", "") == digits
    assert [len(part) for part in model.guid.strip("{}").split("-")] == [8, 4, 4, 4, 12]


def test_the_version_is_that_of_the_project(model):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert model.document.attrib["version"] == project["version"]
    assert model.document.attrib["license"] == project["license"]


def test_references_are_unique_and_rise(model):
    references = [v.reference for v in model.variables.values()]
    assert references == sorted(set(references))


def emitted_with(row: str, model, version: int, folder: Path) -> list[str]:
    """The lines of the XML without GUID, if variables.def had one more row among the first parameters."""
    rows = (build_fmu.CORE / "variables.def").read_text(encoding="utf-8")
    first, parameters = rows.split("VARIABLE(BOTH, EACH(5, 6),")
    (folder / "variables.def").write_text(f"{first}{row}\nVARIABLE(BOTH, EACH(5, 6),{parameters}")
    emitter = ("tools/emit", f"tools/emit_fmi{version}", "fmi/variables", "fmi/dependencies", "model/fault")
    sources = [build_fmu.CORE / f"{name}.c" for name in emitter]
    flags = ["-iquote", str(folder), *fmus.model_defines(model.identifier, version), '-DMODEL_GUID=""']
    build_fmu.compile_c(build_fmu.ZIG, flags, sources, folder / "emit")
    names = build_fmu.names_of(build_fmu.core_sources(model.identifier, version))
    printed = subprocess.run([folder / "emit", *names], capture_output=True, check=True, encoding="utf-8")
    return without_guid(printed.stdout)


def without_guid(text: str) -> list[str]:
    return [line for line in text.splitlines() if not re.search(r"guid=|instantiationToken=", line)]


def next_reference() -> int:
    """After the largest one of all rows."""
    rows = (build_fmu.CORE / "variables.def").read_text(encoding="utf-8")
    found = re.findall(r"^VARIABLE\(\w+, (?:EACH\((\d+), (\d+)\)|(\d+)),", rows, re.MULTILINE)
    return 1 + max(int(number) for numbers in found for number in numbers if number)


@pytest.mark.parametrize("version", build_fmu.ALL)
def test_a_new_row_changes_its_own_lines_alone(model, version, tmp_path):
    """It stands before rows of smaller value references."""
    row = (
        f'VARIABLE(BOTH, {next_reference()}, REAL, NEW, PARAMS, cam[0].radius, "cam1.new", PARAMETER, FIXED, '
        'METRE, 0.02, 0, 1, 1, "New")'
    )
    folder = ROOT / "modelDescription" / ("" if version == 2 else "fmi3")
    before = without_guid((folder / f"{model.identifier}.xml").read_text(encoding="utf-8"))
    after = emitted_with(row, model, version, tmp_path)
    changes = [line for line in difflib.ndiff(before, after) if line[0] in "+-"]
    assert len(changes) == (3 if version == 2 else 1)
    assert all(line.startswith("+") for line in changes)
    assert f'name="cam1.new" valueReference="{next_reference()}"' in changes[0]


def test_two_rows_of_one_reference_do_not_compile(tmp_path):
    row = 'VARIABLE(FORWARD, 9, REAL, NEW, STATE, omega.hi, "new", LOCAL, FIXED, ONE, NAN, 0, 1, 1, "")'
    with pytest.raises(build_fmu.BuildError, match="initializer overrides"):
        emitted_with(row, FORWARD, 2, tmp_path)


# kg, m, s, rad
BASE = {
    "1": (0, 0, 0, 0),
    "kg": (1, 0, 0, 0),
    "m": (0, 1, 0, 0),
    "s": (0, 0, 1, 0),
    "rad": (0, 0, 0, 1),
    "N": (1, 1, -2, 0),
    "J": (1, 2, -2, 0),
    "W": (1, 2, -3, 0),
}


def exponents(unit):
    total = [0, 0, 0, 0]
    numerator, _, denominator = unit.partition("/")
    for sign, part in ((1, numerator), (-1, denominator)):
        for factor in filter(None, part.strip("()").split(".")):
            symbol, power = re.fullmatch(r"(1|[A-Za-z]+)(\d*)", factor).groups()
            for i, exponent in enumerate(BASE[symbol]):
                total[i] += sign * exponent * int(power or 1)
    return total


def test_units_of_the_jacobian_of_a_step_are_quotients():
    for name, variable in FORWARD.variables.items():
        if name.startswith("step."):
            output, known = (
                FORWARD.variables[n].unit for n in re.fullmatch(r"step\.d(\w+)_d(.+)", name).groups()
            )
            quotient = [a - b for a, b in zip(exponents(output), exponents(known), strict=True)]
            assert exponents(variable.unit) == quotient, name


def test_units_used_are_the_units_defined(model):
    defined = [u.attrib["name"] for u in model.document.iter("Unit")]
    assert len(set(defined)) == len(defined)
    assert set(defined) == {v.unit for v in model.variables.values()} - {None}
    assert all(v.unit for v in model.variables.values() if v.type == "Real")


@for_each(lambda m: [u.attrib["name"] for u in m.document.iter("Unit")])
def test_unit_is_what_its_name_says(model, item):
    element = next(u for u in model.document.iter("Unit") if u.attrib["name"] == item)
    attributes = element.find("BaseUnit").attrib
    assert [int(attributes.get(base, 0)) for base in ("kg", "m", "s", "rad")] == exponents(item)
    assert set(attributes) <= {"kg", "m", "s", "rad"}


DISPLAYED = {"deg": math.degrees(1), "rpm": 30 / math.pi, "rad": 1.0, "rad/s": 1.0, "mm": 1e3}


def ratio(unit, display):
    """How many `display` are one `unit`, by their names."""
    if unit in DISPLAYED and display in DISPLAYED:
        return DISPLAYED[display] / DISPLAYED[unit]
    factor = 1.0
    for name, way in ((display, 1), (unit, -1)):
        numerator, _, denominator = name.partition("/")
        for part, side in ((numerator, 1), (denominator, -1)):
            for symbol, power in re.findall(r"([A-Za-z]+)(\d*)", part):
                factor *= DISPLAYED.get(symbol, 1.0) ** (way * side * int(power or 1))
    return factor


def test_display_units_are_what_their_names_say(model):
    shown = {
        unit.attrib["name"]: (display.attrib["name"], float(display.attrib["factor"]))
        for unit in model.document.iter("Unit")
        for display in unit.iter("DisplayUnit")
    }
    assert {"rad": "deg", "rad/s": "rpm", "m": "mm"}.items() <= {u: d for u, (d, _) in shown.items()}.items()
    for unit, (display, factor) in shown.items():
        assert factor == pytest.approx(ratio(unit, display), rel=1e-15), unit


def test_types_give_quantity_unit_and_display_unit(model):
    displays = {
        u.attrib["name"]: [d.attrib["name"] for d in u.iter("DisplayUnit")]
        for u in model.document.iter("Unit")
    }
    types = {t.attrib["name"]: t[0].attrib for t in model.document.iter("SimpleType")}
    assert not set(types) & set(model.variables)
    for name, attributes in types.items():
        assert attributes["quantity"] == name
        assert [attributes[k] for k in ("displayUnit",) if k in attributes] == displays[attributes["unit"]]
    reals = [v[0] for v in model.document.iter("ScalarVariable") if v[0].tag == "Real"]
    assert {r.attrib["declaredType"] for r in reals} == set(types)
    assert all(r.attrib["unit"] == types[r.attrib["declaredType"]]["unit"] for r in reals)


def test_nominals_are_orders_of_magnitude_of_the_default_mechanism(make, model):
    """Within 30 times, over a quick load and release with a damper (without it damper.force is 0)."""
    nominal = {
        v.attrib["name"]: float(v[0].attrib["nominal"])
        for v in model.document.iter("ScalarVariable")
        if "nominal" in v[0].attrib and v.attrib["name"] in model.variables
    }
    unstarted = {"output", "local", "input"}
    assert set(nominal) == {
        n for n, v in model.variables.items() if v.type == "Real" and v.causality in unstarted
    }
    wearing = {"cam1.wear": 1e-14, "cam2.wear": 1e-14}
    fmu = make().start({"damper.c_load": 200.0, "damper.c_release": 200.0} | wearing)
    largest = dict.fromkeys(nominal, 0.0)
    for k in range(200):
        t = 1e-3 * (k + 1)
        if model is FORWARD:
            fmu.step(1e-3, tau=6.0 * math.sin(10 * math.pi * t) ** 2)
        else:
            angle = 20 * math.pi * t
            imposed = {
                "theta": 0.4 * (1 - math.cos(angle)),
                "omega": 8 * math.pi * math.sin(angle),
                "alpha": 160 * math.pi**2 * math.cos(angle),
            }
            fmu.step(1e-3, **imposed)
        for name in nominal:
            largest[name] = max(largest[name], abs(fmu.get(name)))
    quiet = {"F_ext", "energy.residual"} | {n for n, size in largest.items() if size == 0}
    laws = ("friction_peak", "stribeck_velocity", "friction_load")  # without effect in Coulomb's law
    without_effect = {f"step.d{o}_dcam{i}.{law}" for o in ("theta", "omega") for i in "12" for law in laws}
    assert quiet <= without_effect | {
        "F_ext", "energy.residual", "energy.work_ext", "energy.work_tuning", "energy.shaft",
        "energy.heat_shaft", "energy.heat_stop",
    }  # fmt: skip
    wrong = {n: largest[n] for n in nominal if n not in quiet and not 1 / 30 < largest[n] / nominal[n] < 30}
    assert not wrong


def test_default_experiment_and_log_categories(model):
    experiment = model.document.find("DefaultExperiment").attrib
    assert {k: float(v) for k, v in experiment.items()} == {
        "startTime": 0.0, "stopTime": 1.0, "stepSize": 1e-3, "tolerance": 1e-9,
    }  # fmt: skip
    categories = [c.attrib["name"] for c in model.document.iter("Category")]
    assert categories == ["logStatusError", "logStatusWarning"]


def test_initial_is_what_fmi_allows(model):
    expected = {"parameter": "exact", "input": None, "output": "calculated", "local": "calculated"}
    for element in model.document.iter("ScalarVariable"):
        initial = expected[element.attrib["causality"]]
        assert element.attrib.get("initial") == initial
        assert ("start" in element[0].attrib) == (initial != "calculated")


def test_start_values_are_in_range(model):
    for variable in model.variables.values():
        if isinstance(variable.start, float | int):
            assert variable.min <= variable.start <= variable.max


def test_capabilities(model):
    (co_simulation,) = model.document.findall("CoSimulation")
    (exchange,) = model.document.findall("ModelExchange")
    common = {
        "modelIdentifier": model.identifier,
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "true",
    }
    assert exchange.attrib == common | {"completedIntegratorStepNotNeeded": "false"}
    assert co_simulation.attrib == common | {
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "true",
        "maxOutputDerivativeOrder": "2",
        "canRunAsynchronuously": "false",
    }


def test_states_and_their_rates(model):
    """theta and omega are the forward FMU's states; the rate of one is the other."""
    elements = list(model.document.iter("ScalarVariable"))
    rates = {
        model.by_index[index]: model.by_index[int(element[0].attrib["derivative"])]
        for index, element in enumerate(elements, start=1)
        if "derivative" in element[0].attrib
    }
    assert rates == ({"omega": "theta", "alpha": "omega"} if model is FORWARD else {})
    second = {e.attrib["name"]: model.by_index[i] for i, e in enumerate(elements, start=1)}
    second = {name: first for name, first in second.items() if name != first}
    if model is FORWARD:
        assert second == {
            "state.theta": "theta",
            "state.omega": "omega",
            "der(state.theta)": "omega",
            "der(state.omega)": "alpha",
        }
    jumping = {e.attrib["name"] for e in elements if e[0].attrib.get("reinit") == "true"}
    assert jumping == {name for name in second if name.startswith("state.")}
    listed = unknowns(model, "Derivatives") if rates else {}
    assert set(listed) == set(rates)
    assert listed.get("alpha", set()) <= {"tau", "F_ext", "theta", "omega"}
    assert model.document.attrib["numberOfEventIndicators"] == ("7" if model is FORWARD else "1")


# ---- what depends on what ----


def unknowns(model, kind):
    name = model.by_index
    return {
        name[int(u.attrib["index"])]: {name[int(i)] for i in u.attrib["dependencies"].split()}
        for u in model.document.find("ModelStructure").find(kind)
    }


def test_kinds_of_dependency(make, model):
    """All depend in no particular way, but for the states, which are themselves, and the start angle, which
    is that of the parameter."""
    kinds = {}
    for unknown in [*model.document.find("ModelStructure").iter("Unknown")]:
        dependencies = unknown.attrib["dependencies"].split()
        named = unknown.attrib.get("dependenciesKind", "").split()
        assert len(named) == len(dependencies)
        of = model.by_index[int(unknown.attrib["index"])]
        kinds |= {(of, model.by_index[int(d)]): k for d, k in zip(dependencies, named, strict=True)}
    constant = [pair for pair, kind in kinds.items() if kind != "dependent"]
    if model is INVERSE:
        assert not constant
        return
    assert constant == [("theta", "theta"), ("omega", "omega"), ("theta", "initial.theta")]
    for start in (0.0, 0.1, 1.3):
        for scene in ({}, MASSLESS, ELLIPSES | {"stop.upper": 1.5, "inertia.shaft": 0.0}):
            fmu = make()
            fmu.set(scene | {"initial.theta": start, "tau": 30.0})
            assert fmu.get("theta") == start


ELLIPSES = {f"cam{i}.profile": 2 for i in (1, 2)} | {"stop.upper": 0.6}
TABLES = {f"cam{i}.{n}": v for i in (1, 2) for n, v in (("profile", 3), ("table", "a.csv"))}
CYCLOIDS = {"cam1.profile": 4, "cam2.profile": 4, "stop.lower": 0.1}
MASSLESS = {"inertia.shaft": 0.0}
MOVING = {"theta": 0.25, "omega": 3.0, "alpha": 5.0, "F_ext": 2.0, "shaft.damping": 0.01}
HEAVY = {f"inertia.{n}": v for n, v in (("shaft", 0.001), ("follower_mass", 0.2), ("follower", 0.001))}
DAMPED = {f"damper.{c}_{way}": 10.0 for c in "cq" for way in ("load", "release")}
CUBIC = {"spring.stiffness2": 1e4, "spring.stiffness3": 1e6}
ELASTIC = MOVING | CUBIC | {"shaft.stiffness": 20.0, "omega": -3.0}
STARTING = {"initial.theta": 0.25, "initial.omega": 3.0}
RETURNING = {"initial.theta": 0.25, "initial.omega": -3.0}

# Together they show every dependency.
RUBBED = {
    f"cam{i}.{name}": value
    for i in (1, 2)
    for name, value in (("friction_peak", 1.5), ("stribeck_velocity", 0.05), ("friction_viscous", 0.3))
}
LOADED = {f"cam{i}.friction_load_exponent": 0.2 for i in (1, 2)}
SCENES = {
    FORWARD: [
        STARTING,
        STARTING | ELLIPSES,
        STARTING | CYCLOIDS,
        STARTING | TABLES,
        STARTING | {"inertia.shaft": 0.0, "inertia.follower_mass": 1.0},
        STARTING | {"inertia.shaft": 0.0, "inertia.follower": 1.0},
        STARTING | DAMPED | CUBIC,
        RETURNING | DAMPED | CUBIC,
        {"tau": -20.0},
        {"initial.theta": 1.3963, "tau": 30.0},
        STARTING | RUBBED,
        STARTING | RUBBED | {"initial.omega": 1.0},
        STARTING | LOADED,
    ],
    INVERSE: [
        *(
            MOVING | HEAVY | DAMPED | CUBIC | grooves | {"omega": omega}
            for omega in (3.0, -3.0)
            for grooves in ({}, ELLIPSES, TABLES, CYCLOIDS, RUBBED, LOADED)
        ),
        ELASTIC,
        ELASTIC | LOADED,
        ELASTIC | ELLIPSES,
        ELASTIC | TABLES,
        ELASTIC | {"theta": 1.4, "stop.upper": 1.0},
        *(ELASTIC | {"theta": theta} for theta in (-0.8, 0.01)),
    ],
}
# the second value of what is neither real nor at its start value in the scenes
OTHER = {"contacts": 1, "ledger": False}
for _cam in ("cam1", "cam2"):
    OTHER |= {f"{_cam}.profile": 2, f"{_cam}.ellipse_curvature": 1, f"{_cam}.table": "b.csv"}
    OTHER |= {f"{_cam}.friction_table": "law.csv"}
    OTHER |= {f"{_cam}.stribeck_exponent": 1, f"{_cam}.friction_load_exponent": 0.1}


def another(name, value):
    """A value with which the mechanism is possible, too. Of an inertia it may only count if it is there."""
    if name in OTHER:
        return OTHER[name]
    if name.startswith("inertia"):
        return 0.0 if value else 1.0
    if name == "initial.theta":
        return value * 0.8 + 0.01
    return -0.5 if name == "stop.lower" else value * 1.25 + 0.01


@pytest.fixture
def resources(tmp_path):
    for name, slope in (("a", 0.02), ("b", 0.021)):
        rows = [f"{k / 10},{slope * k / 10 + 1e-4 * (k / 10) ** 2}" for k in range(-20, 21)]
        (tmp_path / f"{name}.csv").write_text("\n".join(["psi_rad,z_m", *rows]))
    (tmp_path / "law.csv").write_text("v_m_s,mu\n0,0.2\n0.05,0.25\n0.5,0.3\n")
    return f"file://{tmp_path}"


def changes(fmu, name, outputs, scene):
    """The outputs whose start value changes with that variable in that scene."""
    fmu.ok("fmi2Reset")
    fmu.set(scene)
    if "profile" in name and scene.get(name) == 2:
        return set()
    if name == "stop.lower" and scene.get("cam1.profile") == 4:
        return set()  # a cycloid begins at the angle 0
    if name.endswith("friction_table") and scene.get("inertia.shaft") == 0.0:
        return set()
    varies = (
        name.endswith(("friction_peak", "friction_viscous", "friction_table"))
        or "cam1.friction_peak" in scene
    )
    if varies and (name in ("inertia.shaft", "shaft.stiffness") or scene.get("shaft.stiffness")):
        return set()  # friction that varies with the speed needs inertia and a rigid shaft
    before = {output: fmu.get(output) for output in outputs}
    fmu.set({name: another(name, fmu.get(name))})
    values = {output: fmu.try_get([output]) for output in outputs}
    assert all(status == OK for status, _ in values.values()), fmu.messages
    # the stops decide where the polynomials of the geometry begin and end: that moves the last digits
    return {out for out in outputs if not math.isclose(values[out][1][0], before[out], rel_tol=1e-11)}


@for_each(lambda m: m.names(causality=["parameter", "input"]))
def test_start_values_depend_on_what_the_structure_says(make, model, resources, item):
    known = unknowns(model, "InitialUnknowns")
    fmu = make(resources=resources)
    changed = set().union(*(changes(fmu, item, list(known), scene) for scene in SCENES[model]))
    assert changed == {output for output in known if item in known[output]}


def test_outputs_depend_on_what_the_structure_says(make, model):
    known = unknowns(model, "Outputs")
    assert set(known) == set(model.names(causality=["output"]))
    if model is FORWARD:
        assert set().union(*known.values()) == {"theta", "omega"}  # the states: no input passes through
        for scene in ({}, MASSLESS, MASSLESS | {"damper.c_load": 100.0, "damper.c_release": 100.0}):
            fmu = make().start(scene)
            fmu.step(0.01, tau=5.0, F_ext=1.0)
            before = {output: fmu.get(output) for output in known}
            for inputs in ({"tau": 9.0}, {"tau": -9.0}, {"F_ext": 500.0}, {"F_ext": -500.0}):
                fmu.set(inputs)
                assert {output: fmu.get(output) for output in known} == before
        return
    seen: dict = {output: set() for output in known}
    for scene in (ELLIPSES | {"shaft.damping": 0.1}, ELLIPSES | {"shaft.stiffness": 20.0}):
        fmu = make().start(scene)
        fmu.step(0.1, theta=0.3, omega=1.0)
        before = {output: fmu.get(output) for output in known}
        for name in model.names(causality=["input"]):
            value = fmu.get(name)
            for change in (-0.1, 0.1):
                fmu.set({name: value + change})
                for output in known:
                    if fmu.get(output) != before[output]:
                        seen[output].add(name)
            fmu.set({name: value})
    assert seen == known
