"""Exported FMUs: names, GUID and start values of XML and binary, the same motion as with parameters set by
hand, sources, tables, page, reference result, and what is refused."""

import math
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from itertools import pairwise
from pathlib import Path

import build_fmu
import driver
import driver3
import exported_fmus
import fmpy
import numpy as np
import pytest
from exported_fmus import FACTORY, HELIX, IDENTIFIERS, Design, Exported, factory_members
from fmpy.validation import validate_fmu
from scipy.interpolate import CubicSpline

from dualcam import Fmu
from dualcam.common.groove_laws import LAWS
from dualcam.design_file import DesignFile
from dualcam.errors import DualcamError, DualcamWarning, ExportError, FmuError
from dualcam.export import export_fmu, model_identifier
from dualcam.fmi.library import fmu_path
from dualcam.fmi.model_description import read_model_description
from dualcam.fmi.variables import inputs_of
from dualcam.scenario.scenario import History, Scenario
from dualcam.simulation.run import simulate

DESIGNS = ("helix", "ellipse", "table")
each = pytest.mark.parametrize
each_design = each("design", DESIGNS)
each_model = each("model", IDENTIFIERS)
each_version = each("fmi", [2, 3])


@pytest.fixture(scope="module")
def parameters(tmp_path_factory):
    return exported_fmus.designs(tmp_path_factory.mktemp("grooves"))


@pytest.fixture(scope="module")
def exported(parameters, tmp_path_factory):
    """Exported FMUs by design, model and version of FMI, each made once."""
    made = {}

    def export(design="helix", model="forward", fmi=2) -> Exported:
        key = design, model, fmi
        if key not in made:
            folder = tmp_path_factory.mktemp("exported")
            path = export_fmu(Design(parameters[design], model), folder / f"My_{design}.fmu", fmi)
            made[key] = Exported(path, fmi, folder / "unpacked")
        return made[key]

    return export


@pytest.fixture(scope="module")
def factory(tmp_path_factory):
    """Instances of the project's FMUs."""
    libraries = {}

    def make(model, fmi, **options):
        drivers = driver if fmi == 2 else driver3
        description = FACTORY[fmi, IDENTIFIERS[model]]
        if (model, fmi) not in libraries:
            folder = tmp_path_factory.mktemp("factory")
            with zipfile.ZipFile(description.fmu) as archive:
                name = f"binaries/{exported_fmus.FOLDERS[fmi]}/{description.identifier}.so"
                libraries[model, fmi] = drivers.load(Path(archive.extract(name, folder)))
        return drivers.Driver(libraries[model, fmi], model=description, **options)

    return make


# ---- what is in the FMU ----


@each_version
@each_model
@each_design
def test_valid_for_fmpy(exported, design, model, fmi):
    assert validate_fmu(str(exported(design, model, fmi).path)) == []


@each_version
@each_model
@each_design
def test_binary_has_the_names_and_start_values_of_the_description(exported, parameters, design, model, fmi):
    """To the last bit, for every variable with a start value."""
    fmu = exported(design, model, fmi)
    instance = fmu.instance()
    assert instance.instance  # the GUID of the description is the one of the binary
    assert fmu.model.document.attrib["modelName"] == f"My_{design}" == fmu.binary.stem
    for name, variable in fmu.model.variables.items():
        if variable.start is not None:
            assert instance.get(name) == variable.start, name
    given = {n: v for n, v in parameters[design].items() if not n.endswith(".table")}
    assert given == {name: instance.get(name) for name in given}
    instance.free()


@each_version
@each_model
def test_only_values_of_attributes_differ_in_the_description(exported, model, fmi):
    """Elements, attributes and their order are those of the original; so is the model structure."""
    fmu = exported("table", model, fmi)
    made, original = (path.read_text() for path in (fmu.model.xml, FACTORY[fmi, IDENTIFIERS[model]].xml))
    assert re.sub(r'="[^"]*"', '=""', made) == re.sub(r'="[^"]*"', '=""', original)
    assert made.partition("<ModelStructure>")[2] == original.partition("<ModelStructure>")[2]
    changed = [a for a, b in zip(made.splitlines(), original.splitlines(), strict=True) if a != b]
    design = [line for line in changed if "start=" in line or "<Start " in line]
    others = ("modelName", "guid", "instantiationToken", "description", "generationTool", "modelIdentifier")
    assert all(line.split("=")[0].strip() in others for line in changed if line not in design)


@each_version
@each_model
def test_members(exported, model, fmi):
    """Those of the original under new names, and the tables; not its parameter sets and its state."""
    related = ("documentation/fmi-ls-ref.html", ".ssv", ".state")
    original = {name for name in factory_members(fmi, model) if not name.endswith(related)}
    renamed = {name.replace(IDENTIFIERS[model], "My_table") for name in original}
    fmu = exported("table", model, fmi)
    assert set(fmu.names) == renamed | {"resources/cam1.csv", "resources/cam2.csv"}
    assert not [name for name in exported("helix", model, fmi).names if name.startswith("resources")]


def test_tables_are_the_bytes_of_the_files(exported, parameters):
    for cam in ("cam1", "cam2"):
        made = exported("table").folder / f"resources/{cam}.csv"
        assert made.read_bytes() == Path(parameters["table"][f"{cam}.table"]).read_bytes()


def test_the_same_design_gives_the_same_bytes(exported, parameters, tmp_path):
    fmu = exported("table", "forward", 3)
    again = export_fmu(Design(parameters["table"]), tmp_path / fmu.path.name, fmi=3)
    assert again.read_bytes() == fmu.path.read_bytes()


def test_guids_differ_where_anything_differs(exported, parameters, tmp_path):
    """Also where only a table differs, whose name in the FMU is always the same."""
    other = exported_fmus.write_table(tmp_path / "other.csv", 0.0201, 0.002)
    changed = parameters["table"] | {"cam1.table": str(other)}
    more = Exported(export_fmu(Design(changed), tmp_path / "My_table.fmu"), 2, tmp_path / "unpacked")
    fmus = [exported(design, m, fmi) for design in DESIGNS for m in IDENTIFIERS for fmi in (2, 3)]
    guids = [fmu.model.guid for fmu in [*fmus, more]] + [model.guid for model in FACTORY.values()]
    assert len(set(guids)) == len(guids)
    assert all(re.fullmatch(r"\{[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\}", guid) for guid in guids)


# ---- the same motion, bit for bit ----


def drive(instance, model):
    """Every variable after the start and after each of 200 steps that load, release and meet the stops."""
    seen = [instance.everything()]
    for k in range(200):
        t = 0.01 * k
        if model == "forward":
            instance.step(0.01, tau=12.0 * math.sin(3.0 * t) + 4.0, F_ext=5.0 * t)
        else:
            end = 3.0 * (t + 0.01)
            motion = {"omega": 1.2 * math.sin(end), "alpha": 3.6 * math.cos(end)}
            instance.step(0.01, theta=0.4 * (1.0 - math.cos(end)), F_ext=5.0 * t, **motion)
        seen.append(instance.everything())
    return seen


def by_name_of_file(seen, given):
    """Without the paths of tables, which differ on purpose: absolute by hand, a name in the exported FMU."""
    return [{name: value for name, value in row.items() if name not in given} for row in seen]


TABLE_NAMES = ("cam1.table", "cam2.table")


@each_version
@each_model
@each_design
def test_co_simulation(exported, factory, parameters, design, model, fmi):
    fmu = exported(design, model, fmi)
    mine, by_hand = fmu.instance(), factory(model, fmi)
    seen = drive(mine.start(), model)
    wanted = drive(by_hand.start(parameters[design]), model)
    assert by_name_of_file(seen, TABLE_NAMES) == by_name_of_file(wanted, TABLE_NAMES)
    observed = [float.fromhex(row["z" if model == "forward" else "tau"]) for row in seen]
    assert max(observed) - min(observed) > 1e-3  # something happens
    mine.free()
    by_hand.free()


def at_states(instance, fmi, states):
    """All variables, derivatives and event indicators at some states of model exchange."""
    numbers = (driver.c_double * 7)()
    prefix = "fmi2" if fmi == 2 else ""
    derivatives = "fmi2GetDerivatives" if fmi == 2 else "GetContinuousStateDerivatives"
    seen = []
    for theta, omega, tau in states:
        instance.set({"tau": tau})
        instance.ok(f"{prefix}SetContinuousStates", (driver.c_double * 2)(theta, omega), 2)
        instance.ok(f"{prefix}EnterEventMode")
        instance.settle()
        if fmi == 3:
            instance.ok("EnterContinuousTimeMode")
        instance.ok(derivatives, numbers, 2)
        seen.append([x.hex() for x in list(numbers)[:2]])
        instance.ok(f"{prefix}GetEventIndicators", numbers, 7)
        seen.append([x.hex() for x in numbers])
        seen += by_name_of_file([driver.Calls.everything(instance)], TABLE_NAMES)
    return seen


def begin_model_exchange(instance, fmi, values=None):
    if fmi == 2:
        instance.start(values)
        instance.settle()
    else:
        instance.initialize(values)
        instance.settle()
        instance.ok("EnterContinuousTimeMode")
    return instance


@each_version
@each_design
def test_model_exchange(exported, factory, parameters, design, fmi):
    kind = {"kind": driver.MODEL_EXCHANGE} if fmi == 2 else {"exchange": True}
    mine = begin_model_exchange(exported(design, "forward", fmi).instance(**kind), fmi)
    by_hand = begin_model_exchange(factory("forward", fmi, **kind), fmi, parameters[design])
    states = [(0.1, 0.0, 3.0), (0.3, 0.5, 8.0), (0.5, -0.4, 1.0), (0.7, 0.0, 30.0)]
    seen = at_states(mine, fmi, states)
    assert seen == at_states(by_hand, fmi, states)
    assert any(float.fromhex(seen[k][1]) != 0.0 for k in range(0, len(seen), 3))  # an acceleration
    mine.free()
    by_hand.free()


def test_reset_brings_back_the_start_values_of_the_design(exported):
    instance = exported("table").instance()
    fresh = instance.everything()
    instance.start(
        {"spring.stiffness": 1e5, "cam1.table": str(exported("table").folder / "resources/cam2.csv")}
    )
    instance.step(0.1, tau=5.0)
    instance.ok("fmi2Reset")
    assert instance.everything() == fresh
    assert instance.get("cam1.table") == "cam1.csv"
    instance.free()


def test_two_exported_fmus_in_one_process(exported, parameters):
    first, second = exported("helix").instance().start(), exported("ellipse").instance().start()
    for _ in range(50):
        first.step(0.01, tau=5.0)
        second.step(0.01, tau=5.0)
    assert first.get("theta") != second.get("theta")
    for instance, design in ((first, "helix"), (second, "ellipse")):
        for name, value in parameters[design].items():
            assert instance.get(name) == value
    first.free()
    second.free()


@each_version
def test_a_serialized_state_of_another_fmu_is_refused(exported, factory, fmi):
    first, second = (exported(design, fmi=fmi).instance().start() for design in ("helix", "ellipse"))
    content = first.to_bytes(state := first.take())
    function = "fmi2DeSerializeFMUstate" if fmi == 2 else "DeserializeFMUState"
    for other in (second, factory("forward", fmi).start()):
        loaded = driver.c_void_p()
        text = other.refused(function, content, len(content), driver.byref(loaded))
        assert other.model.guid in text
    first.ok(function, content, len(content), driver.byref(again := driver.c_void_p()))
    first.free_state(again)
    first.free_state(state)


@each_version
def test_only_the_own_guid_is_accepted(exported, fmi):
    fmu = exported("helix", fmi=fmi)
    option = "guid" if fmi == 2 else "token"
    refused = fmu.instance(**{option: FACTORY[fmi, "DualCamForward"].guid})
    assert not refused.instance
    assert f"allowed is only {fmu.model.guid}" in refused.messages[0].text


# ---- tables in the resources ----


@each(
    "form",
    ["file://{}", "file:///{}", "file:{}/", "file://localhost{}", "file:{}", "FILE://{}/", "file://{}//"],
)
def test_tables_are_found_in_odd_forms_of_the_location(exported, tmp_path, form):
    """The folder's name has a blank, which masters send raw or as %20."""
    folder = tmp_path / "a folder"
    shutil.copytree(exported("table").folder / "resources", folder)
    for path in (str(folder), str(folder).replace(" ", "%20")):
        instance = exported("table").instance(resources=form.format(path))
        instance.start()
        instance.free()


@each_version
@each("location", [None, ""])
def test_without_a_location_a_relative_table_is_refused(exported, fmi, location):
    instance = exported("table", fmi=fmi).instance(resources=location)
    instance.set({"cam1.friction": 0.1})
    if fmi == 2:
        text = instance.refused_start()
    else:
        instance.ok("EnterInitializationMode", False, 0.0, 0.0, False, 0.0)
        assert instance.call("ExitInitializationMode") == driver.ERROR
        text = instance.messages[-1].text
    assert "cam1.table" in text and "cam1.csv" in text and "resources" in text
    instance.free()


def test_start_values_edited_in_the_description_alone_do_nothing(tmp_path):
    """What the documentation of every FMU says."""
    members = factory_members(2, "forward")
    xml = members["modelDescription.xml"].decode()
    (edited,) = {xml.replace('start="50000"', 'start="70000"')} - {xml}
    build_fmu.write_archive(tmp_path / "edited.fmu", members | {"modelDescription.xml": edited.encode()})
    with Fmu(tmp_path / "edited.fmu") as fmu:
        fmu.start()
        assert fmu.get("spring.stiffness") == 50000.0
    page = members["documentation/index.html"].decode()
    assert "changes nothing by itself" in page and "dualcam export" in page


# ---- sources ----


def block_of(content: bytes) -> bytes:
    """The block of start values in a binary or an object file: mark, size, and what follows."""
    mark = b"dualcam start values, layout 1\n\0"
    assert content.count(mark) == 1
    at = content.index(mark)
    return content[at : at + int.from_bytes(content[at + 32 : at + 36], "little")]


@each_version
@each_model
@each_design
def test_the_sources_give_the_block_of_the_binary(exported, tmp_path, design, model, fmi):
    """The compiler makes from the exported sources the bytes that the export wrote into the binary."""
    fmu, product = exported(design, model, fmi), tmp_path / "variables.o"
    options = ["-std=c17", "-O1", "-Wall", "-Werror", "-isystem", build_fmu.fmi_headers()]
    command = [*build_fmu.ZIG, *options, *build_fmu.TARGET, "-c", "fmi/variables.c", "-o", product]
    subprocess.run(command, cwd=fmu.folder / "sources", check=True, capture_output=True)
    assert block_of(product.read_bytes()) == block_of(fmu.binary.read_bytes())


def test_the_sources_compile_to_the_same_fmu(exported, tmp_path):
    """With the name of the exported FMU, every variable to the last digit."""
    fmu = exported("table")
    library = tmp_path / fmu.binary.name
    sources = sorted(p.relative_to(fmu.folder / "sources") for p in (fmu.folder / "sources").rglob("*.c"))
    options = ["-std=c17", "-O0", "-fno-sanitize=undefined", "-ffp-contract=off", "-fPIC", "-shared"]
    headers = ["-isystem", build_fmu.fmi_headers()]
    command = [*build_fmu.ZIG, *options, *headers, *sources, "-lm", "-o", library]
    subprocess.run(command, cwd=fmu.folder / "sources", check=True, capture_output=True)
    compiled = driver.Driver(driver.load(library), model=fmu.model, resources=fmu.resources)
    mine = fmu.instance()
    assert drive(compiled.start(), "forward") == drive(mine.start(), "forward")
    compiled.free()
    mine.free()


@each_version
def test_the_sources_name_the_exported_model(exported, fmi):
    folder = exported("helix", fmi=fmi).folder / "sources"
    assert "#define MODEL_IDENTIFIER My_helix\n" in (folder / "identity.h").read_text()
    if fmi == 3:
        root = ET.parse(folder / "buildDescription.xml").getroot()
        assert root.find("BuildConfiguration").attrib["modelIdentifier"] == "My_helix"
    assert not [p for p in folder.rglob("*") if p.is_file() and b"DualCamForward" in p.read_bytes()]


# ---- reference result and page ----


def rows_of(path: Path) -> tuple[list[str], list[list[float]]]:
    names, *rows = [line.split(",") for line in path.read_text().splitlines()]
    return names, [[float(x) for x in row] for row in rows]


@each_version
@each_design
def test_forward_reference_result(exported, factory, parameters, design, fmi):
    """The original with parameters by hand gives the same result, to the last digit."""
    folder = exported(design, fmi=fmi).folder / "extra/reference"
    _, knots = rows_of(folder / f"My_{design}_in.csv")
    names, wanted = rows_of(folder / f"My_{design}_ref.csv")
    fmu = factory("forward", 2).start(parameters[design])
    found = [[0.0, *(fmu.get(name) for name in names[1:])]]
    for (t0, *u0), (t1, *u1) in pairwise(knots):
        rates = [(b - a) / (t1 - t0) for a, b in zip(u0, u1, strict=True)]
        for k in range(round(100 * (t1 - t0))):
            fmu.set({n: a + r * k * 0.01 for n, a, r in zip(("tau", "F_ext"), u0, rates, strict=True)})
            fmu.set_rates(tau=rates[0], F_ext=rates[1])
            fmu.step(round(t0 + (k + 1) * 0.01, 9) - round(t0 + k * 0.01, 9))
            found.append([round(t0 + (k + 1) * 0.01, 9), *(fmu.get(name) for name in names[1:])])
    assert found == wanted
    theta = [row[1] for row in wanted]
    assert max(theta) > 0.3 * parameters[design].get("stop.upper", 1.3963)  # it moves, and comes back
    assert theta[-1] < 0.5 * max(theta)
    fmu.free()


@each_design
def test_inverse_reference_result(exported, factory, parameters, design):
    folder = exported(design, "inverse").folder / "extra/reference"
    names, given = rows_of(folder / f"My_{design}_in.csv")
    outputs, wanted = rows_of(folder / f"My_{design}_ref.csv")
    fmu = factory("inverse", 2)
    found = []
    for k, (t, *values) in enumerate(given):
        inputs = dict(zip(names[1:], values, strict=True))
        if k == 0:
            fmu.start(parameters[design] | inputs)
        else:
            fmu.step(t - given[k - 1][0], **inputs)
        found.append([t, *(fmu.get(name) for name in outputs[1:])])
    assert found == wanted
    fmu.free()


@each_version
@each_model
def test_page(exported, model, fmi):
    fmu = exported("ellipse", model, fmi)
    page = (fmu.folder / "documentation/index.html").read_text(encoding="utf-8")
    assert "<title>My_ellipse</title>" in page and "<h1>My_ellipse</h1>" in page
    assert "start values of the design trial" in page and "-o My_ellipse.so" in page
    assert '<code>cam1.ellipse_a</code></td><td>m</td><td class="number">0.1 [100 mm]</td>' in page
    assert '<code>cam1.profile</code></td><td>Integer</td><td class="number">2</td>' in page.replace(
        "Int32", "Integer"
    )
    assert "changes nothing by itself" in page and "this\nFMU itself" in page
    assert IDENTIFIERS[model] not in page
    assert not re.search(r"@import|<script|<image|\$\w", page)
    drawn = re.findall(r"<svg.*?</svg>", page, flags=re.DOTALL)
    assert len(drawn) == 4
    words = "".join(text for svg in drawn for text in ET.fromstring(svg).itertext())
    for word in ("T_load", "T_release", "efficiency", "cam 1, loading", "cam 2, releasing", "z [mm]"):
        assert word in words
    names = re.findall(r'\bid="([^"]*)"', page)
    assert len(names) == len(set(names))
    assert page.count('<td class="number">-1 or 1</td>') == 2
    assert all(
        (fmu.folder / "documentation" / link).is_file() for link in re.findall(r'href="([^#"]+)"', page)
    )


def test_curves_are_those_of_the_closed_form():
    """Two helices: T = (F0 + k z)/kappa, section 3 of docs/mechanism.md."""
    from dualcam.export.reference import slow_motion_curves

    curves = slow_motion_curves({"stop.lower": -0.2, "inertia.follower_mass": 2.0, "initial.theta": 0.1})
    assert (curves.theta[0], curves.theta[-1]) == (-0.2, 1.3963)
    force = 50.0 + 50000.0 * 0.01 * curves.theta  # two grooves of 45 deg: z = r theta/2
    for name, friction in (("torque_load", 0.14), ("torque_release", -0.14)):
        wanted = 0.01 * (1 + friction) / (1 - friction) * force
        found = curves.values[name]
        assert all(
            f == pytest.approx(w, rel=1e-9) for f, w, n in zip(found, wanted, force, strict=True) if n > 0
        )
    # at 45 deg a contact with normal force R lifts by R (1 - mu)/sqrt 2; four contacts share the force
    assert curves.reactions["loading"][:, -1] == pytest.approx(
        [force[-1] * math.sqrt(2.0) / (1 - 0.14) / 4] * 2, rel=1e-6
    )


# ---- names and places ----


@each(
    ("name", "identifier"),
    [("MyCam", "MyCam"), ("my cam", "my_cam"), ("1st", "_1st"), ("a.b-c", "a_b_c"), ("Nut ü2", "Nut__2")],
)
def test_identifier(name, identifier):
    assert model_identifier(name) == identifier
    assert identifier.isascii() and identifier.isidentifier()


@each("name", ["", "...", "ü", "- -"])
def test_a_name_without_letters_is_refused(name):
    with pytest.raises(ExportError, match="at least one letter"):
        model_identifier(name)


@each("stem", ["my cam & <co>", "1st"])
def test_a_name_that_is_no_identifier(tmp_path, stem):
    """The model keeps the name, the binaries get an identifier, and a warning says so."""
    with pytest.warns(UserWarning, match="is no C identifier") as warned:
        path = export_fmu(Design(HELIX), tmp_path / f"{stem}.fmu")
    assert warned[0].filename == __file__
    fmu = Exported(path, 2, tmp_path / "unpacked")
    assert fmu.binary.stem == model_identifier(stem)
    assert fmu.model.document.attrib["modelName"] == stem
    result = fmpy.simulate_fmu(str(path), stop_time=0.1, start_values={"tau": 8.0}, output=["theta"])
    assert result["theta"][-1] > 0.01


def refused(error, match, *arguments, **options):
    with pytest.raises(error, match=match) as caught:
        export_fmu(*arguments, **options)
    assert isinstance(caught.value, DualcamError)


def test_refused_places(tmp_path):
    folder = tmp_path / "folder.fmu"
    folder.mkdir()
    design = Design(HELIX)
    refused(ExportError, "is a folder: allowed is the name of a file", design, folder)
    refused(ExportError, "does not exist: create it first", design, tmp_path / "none/MyCam.fmu")
    refused(ExportError, r"ends in \.fmu, such as", design, tmp_path / "MyCam.zip")
    refused(ExportError, r"ends in \.fmu, such as", design, tmp_path / "My\nCam.fmu")
    refused(ExportError, "cannot be written: File name too long", design, tmp_path / f"{300 * 'a'}.fmu")
    refused(ExportError, "project's own FMU", design, fmu_path("forward"))
    refused(ExportError, "project's own FMU", design, fmu_path("inverse", 3), fmi=3)
    refused(FmuError, r"fmi=1\): allowed are 2 \(FMI 2.0\) and 3", design, tmp_path / "MyCam.fmu", fmi=1)
    refused(FmuError, "kind='backward'.: allowed are", design, tmp_path / "a.fmu", model="backward")
    assert list(tmp_path.iterdir()) == [folder]


def test_refused_designs(tmp_path):
    """The messages are the FMU's. Nothing is left behind, and an older file stays as it was."""
    path = tmp_path / "MyCam.fmu"
    path.write_bytes(b"older")
    missing = str(tmp_path / "none.csv")
    for parameters, words in (
        ({"cam1.radius": -1.0}, "cam1.radius"),
        ({"cam1.frction": 0.1}, "did you mean cam1.friction"),
        ({"cam1.profile": 99}, f"1 to {max(LAWS)}"),
        ({"cam1.friction": 2.0, "cam2.friction": 2.0}, "jam"),
        ({"stop.lower": 0.5, "stop.upper": 0.2}, "stop"),
        ({"cam1.profile": 3, "cam1.table": missing}, "none.csv"),
        ({"cam1.table": missing}, "cam1.table = .*none.csv"),
        ({"cam1.radius": "wide"}, "allowed is a number"),
        ({"shaft.stifness": 100.0}, "no variable"),
    ):
        refused(DualcamError, words, Design(parameters), path)
    assert path.read_bytes() == b"older"
    assert list(tmp_path.iterdir()) == [path]


def test_an_existing_file_is_replaced(tmp_path):
    path = tmp_path / "MyCam.fmu"
    path.write_bytes(b"older")
    assert export_fmu(Design(HELIX), str(path)) == path
    assert zipfile.is_zipfile(path) and list(tmp_path.iterdir()) == [path]


def test_the_word_model_overrides_the_design(tmp_path):
    """In the inverse FMU the start of the motion becomes the start values of two inputs."""
    given = HELIX | {"stop.lower": 0.1, "initial.theta": 0.2, "initial.omega": 0.1}
    path = export_fmu(Design(given, "forward"), tmp_path / "MyCam.fmu", model="inverse")
    with Fmu(path) as fmu:
        assert "initial.theta" not in fmu.names
        fmu.start()
        assert [fmu.get(n) for n in ("theta", "omega", "inertia.shaft")] == [0.2, 0.1, HELIX["inertia.shaft"]]


def test_an_fmu_that_fails_in_its_reference_run_is_refused(tmp_path, monkeypatch):
    def fail(fmu, size):
        raise FmuError("no step is possible")

    monkeypatch.setattr(Fmu, "step", fail)
    refused(ExportError, "reference run at 0 s: no step is possible", Design(HELIX), tmp_path / "MyCam.fmu")
    assert not list(tmp_path.iterdir())


def test_a_parameter_of_the_other_model_is_left_out_with_a_warning(tmp_path):
    design = Design({"shaft.stiffness": 100.0, "cam1.friction": 0.1})
    with pytest.warns(DualcamWarning, match=r"shaft.stiffness = 100.0 is not used: the forward"):
        export_fmu(design, tmp_path / "A.fmu")
    export_fmu(design, tmp_path / "B.fmu", model="inverse")
    with Fmu(tmp_path / "B.fmu") as fmu:
        fmu.start()
        assert fmu.real("shaft.stiffness") == 100.0


# ---- the scenario of the design ----


def texts(path: Path, *members: str) -> list[str]:
    with zipfile.ZipFile(path) as archive:
        return [archive.read(member).decode() for member in members]


PAGE, SCENARIO = "documentation/index.html", "extra/scenario_in.csv"

DRIVEN = {
    "forward": {"tau": History((0.0, 0.5, 0.5, 0.8), (0.0, 8.0, 3.0, 0.0)), "F_ext": History((0.0,), (4.0,))},
    "inverse": {
        "theta": History((0.0, 0.6, 1.0), (0.0, 0.9, 0.2), "smooth"),
        "omega": History(derivative_of="theta"),
        "alpha": History(derivative_of="omega"),
    },
}


@each_version
@each_model
def test_the_lines_on_the_page_play_the_scenario(tmp_path, monkeypatch, model, fmi):
    """FMPy finds what `dualcam simulate` finds, but for the lag of inputs that are held over a step."""
    scenario = Scenario(1.0, DRIVEN[model])
    path = export_fmu(Design(HELIX, model, scenario=scenario), tmp_path / "MyCam.fmu", fmi)
    page, rows = texts(path, PAGE, SCENARIO)
    assert rows.splitlines()[0].split(",")[1:] == list(inputs_of(model))
    (lines,) = re.findall(r"<pre>(import fmpy.*?)</pre>", page, flags=re.DOTALL)
    monkeypatch.chdir(tmp_path)
    left: dict = {}
    exec(lines, left)
    result = left["result"]
    design = DesignFile(tmp_path / "my.toml", dict(HELIX), model, scenario, output_interval=0.0005)
    wanted = simulate(design, ["tau", "theta"])
    assert len(result) == len(wanted.values)
    assert np.max(wanted["theta"]) > 0.1
    if model == "forward":
        lag = np.max(np.abs(result["theta"] - wanted["theta"]))
        assert lag <= 0.0005 * np.max(np.abs(result["omega"]))
    else:
        # The FMU takes the inputs as those of the end of a step, so FMPy is one step late. Lines between rows
        # of 1 ms miss theta by up to alpha h^2/8 = 23 rad/s^2 * (1 ms)^2/8 = 3e-6 rad, of 0.9 rad.
        late = result["tau"][1:] - wanted["tau"][:-1]
        assert np.max(np.abs(late)) <= 3e-6 / 0.9 * np.max(wanted["tau"])


def test_the_file_of_the_scenario_has_the_corners_and_jumps(tmp_path):
    path = export_fmu(Design(HELIX, scenario=Scenario(1.0, DRIVEN["forward"])), tmp_path / "MyCam.fmu")
    (rows,) = texts(path, SCENARIO)
    assert rows.splitlines() == ["time,tau,F_ext", "0,0,4", "0.5,8,4", "0.5,3,4", "0.8,0,4", "1,0,4"]


def test_a_curved_input_is_sampled_on_its_curve(tmp_path):
    design = Design(HELIX, "inverse", scenario=Scenario(1.0, DRIVEN["inverse"]))
    (rows,) = texts(export_fmu(design, tmp_path / "MyCam.fmu"), SCENARIO)
    time, theta, omega = np.loadtxt(rows.splitlines(), delimiter=",", skiprows=1).T[:3]
    curve = CubicSpline((0.0, 0.6, 1.0), (0.0, 0.9, 0.2), bc_type="clamped")
    assert time[0] == 0.0 and time[-1] == 1.0 and len(time) >= 1000
    assert np.allclose(theta, curve(time), rtol=0.0, atol=1e-11)
    assert np.allclose(omega, curve(time, 1), rtol=0.0, atol=1e-10)


@each(
    "model, scenario",
    [
        ("forward", None),
        ("forward", Scenario(1.0)),
        ("forward", Scenario(1.0, DRIVEN["inverse"])),
        ("inverse", Scenario(1.0, DRIVEN["forward"])),
    ],
)
def test_no_file_without_a_scenario_for_the_model(tmp_path, model, scenario):
    path = export_fmu(Design(HELIX, model, scenario=scenario), tmp_path / "MyCam.fmu")
    with zipfile.ZipFile(path) as archive:
        assert SCENARIO not in archive.namelist()
    assert 'id="scenario"' not in texts(path, PAGE)[0]


@each_version
def test_the_default_experiment_ends_with_the_scenario(tmp_path, fmi):
    """Without a scenario it ends as that of the original does."""
    for scenario, stop in ((Scenario(4.0, DRIVEN["forward"]), 4.0), (Scenario(0.25), 0.25), (None, 1.0)):
        path = export_fmu(Design(HELIX, scenario=scenario), tmp_path / "MyCam.fmu", fmi)
        assert read_model_description(path).default_experiment.stop_time == stop
        assert not validate_fmu(path)


@each_version
def test_the_title_stands_in_description_and_page(tmp_path, fmi):
    path = export_fmu(Design(HELIX, title="Elbow <A&B>"), tmp_path / "MyCam.fmu", fmi)
    description, page = texts(path, "modelDescription.xml", PAGE)
    assert (
        ET.fromstring(description)
        .attrib["description"]
        .endswith('start values of the design trial, "Elbow <A&B>"')
    )
    assert "start values of the design trial, &quot;Elbow &lt;A&amp;B&gt;&quot;" in page


@each_model
def test_the_caption_says_which_force_acts_in_the_reference(exported, model):
    folder = exported("ellipse", model).folder
    names, rows = rows_of(folder / "extra/reference/My_ellipse_in.csv")
    force = max(row[names.index("F_ext")] for row in rows)
    page = (folder / "documentation/index.html").read_text(encoding="utf-8")
    assert force > 0.0 and f"of up to {force:g} N." in page.replace("\n", " ")
