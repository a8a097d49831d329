"""What the FMUs hold besides binary and description: sources, documentation, icon, reference results."""

import csv
import io
import math
import re
import struct
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from html.parser import HTMLParser

import build_fmu
import fmpy
import numpy as np
import pytest
import reference_results
from driver import ROOT, Driver, load, models
from reference_results import FORWARD_IN

from dualcam.common.archive import read_members, write_archive

FORWARD, INVERSE = models.values()
REFERENCE = ROOT / "modelDescription/reference"


@pytest.fixture(scope="session", params=models.values(), ids=repr)
def model(request):
    return request.param


@pytest.fixture(scope="session")
def unzipped(model, tmp_path_factory):
    directory = tmp_path_factory.mktemp(f"unzipped-{model}")
    with zipfile.ZipFile(model.fmu) as archive:
        archive.extractall(directory)
    return directory


def test_nothing_is_in_it_that_should_not(unzipped):
    """The FMI headers are those of the importer; nothing of another FMU; no leftovers."""
    top = {"binaries", "documentation", "extra", "model.png", "modelDescription.xml", "sources"}
    assert {p.name for p in unzipped.iterdir()} == top | {"terminalsAndIcons"}
    assert not list(unzipped.rglob("fmi2*.h")) and not list(unzipped.rglob("emit*"))
    assert (unzipped / "documentation/licenses/license.txt").read_text() == (ROOT / "LICENSE").read_text()


def test_building_again_writes_the_same_bytes(model, tmp_path):
    members = read_members(model.fmu)
    with zipfile.ZipFile(model.fmu) as archive:
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    build_fmu.write_archive(tmp_path / "again.fmu", members)
    assert (tmp_path / "again.fmu").read_bytes() == model.fmu.read_bytes()
    write_archive(tmp_path / "package.fmu", members)  # the exporter's, which has no part of the build
    assert (tmp_path / "package.fmu").read_bytes() == model.fmu.read_bytes()
    made = build_fmu.dual_cam(model.identifier, check=True)
    assert all(members[name] == text.encode() for name, text in made.texts.items())
    assert all(members[name] == path.read_bytes() for name, path in made.extra.items())


# ---- sources ----


def c_files(folder):
    """From there: room/file.c."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.c"))


def test_source_files_are_all_c_files_of_the_folder(model, unzipped):
    (co_simulation,) = model.document.findall("CoSimulation")
    listed = [file.attrib["name"] for file in co_simulation.find("SourceFiles")]
    assert listed == c_files(unzipped / "sources")


def fmi_headers(directory):
    """A copy, so that nothing else of the wheel is on the way."""
    directory.mkdir()
    for name in ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"):
        (directory / name).write_bytes((build_fmu.fmi_headers() / name).read_bytes())
    return directory


@pytest.fixture(scope="session")
def compiled(model, unzipped, tmp_path_factory):
    """The sources as they are in the FMU. Those of the forward FMU with the command that they and the
    documentation name. Those of the inverse FMU as other tools compile: from another folder, and without
    optimisation, which takes a third of the time and must give the same digits."""
    directory = tmp_path_factory.mktemp(f"compiled-{model}")
    library = directory / f"{model}.so"
    level, folder = (["-O2"], "sources") if model is FORWARD else (["-O0", "-fno-sanitize=undefined"], ".")
    sources = c_files(unzipped / folder)
    options = ["-std=c17", *level, "-ffp-contract=off", "-fPIC", "-shared"]
    options += ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    options += ["-DCO_SIMULATION", "-DMODEL_EXCHANGE"]  # as FMPy's create_cmake_project has it
    headers = fmi_headers(directory / "headers")
    command = [*build_fmu.ZIG, *options, "-isystem", headers, *sources, "-lm", "-o", library]
    subprocess.run(command, cwd=unzipped / folder, check=True, capture_output=True, text=True)
    return library


def test_the_command_is_the_one_that_is_documented(model, unzipped):
    options = "-std=c17 -O2 -ffp-contract=off -fPIC -shared -I<FMI headers>"
    command = f"cc {options} {{}}*/*.c -lm -o {model}.so"
    assert command.format("") in (unzipped / "sources/identity.h").read_text()
    page = (unzipped / "documentation/index.html").read_text().replace("&lt;", "<").replace("&gt;", ">")
    assert command.format("sources/") in page


def test_the_sources_compile_from_there_alone_and_run_alike(model, compiled, libraries):
    """Every variable, to the last digit."""
    inputs = {FORWARD: {"tau": 5.0, "F_ext": 3.0}, INVERSE: {"theta": 0.02, "omega": 2.0, "alpha": 1.0}}
    values = []
    for library in (load(compiled), libraries[model.identifier]):
        driver = Driver(library, model=model).start()
        driver.step(0.02, **inputs[model])
        values.append({name: driver.get(name) for name in model.variables})
        driver.free()
    assert values[0] == values[1]
    assert values[0]["z"] > 0


def test_the_functions_can_have_the_prefix_that_static_linking_needs(model, unzipped, tmp_path):
    """FMPy's copy of the header has no prefixes; here it gets those of the standard's header."""
    headers = fmi_headers(tmp_path / "headers")
    plain = "#define fmi2FullName(name) name\n"
    paste = """\
#define fmi2Paste(a,b) a ## b
#define fmi2PasteB(a,b) fmi2Paste(a,b)
#define fmi2FullName(name) fmi2PasteB(FMI2_FUNCTION_PREFIX, name)
"""
    header = headers / "fmi2Functions.h"
    text = header.read_text()
    assert text.count(plain) == 1
    header.write_text(text.replace(plain, paste))
    product = tmp_path / "fmi2.o"
    options = ["-std=c17", f"-DFMI2_FUNCTION_PREFIX={model}_", "-isystem", headers]
    command = [*build_fmu.ZIG, *options, "-c", "fmi/fmi2.c", "-o", product]
    subprocess.run(command, cwd=unzipped / "sources", check=True)
    assert f"\0{model}_fmi2DoStep\0".encode() in product.read_bytes()


# ---- documentation ----


class Page(HTMLParser):
    """Checks that tags are closed in order, and collects what matters."""

    VOID = ("meta", "br", "img", "link", "hr")

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.links, self.text = [], [], [], []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.links += [value for name, value in attributes if name in ("href", "src", "xlink:href")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, self.getpos()

    def handle_data(self, data):
        self.text.append(data)


def test_documentation(model, unzipped):
    folder = unzipped / "documentation"
    text = (folder / "index.html").read_text(encoding="utf-8")
    page = Page()
    page.feed(text)
    page.close()
    assert not page.open
    assert page.links and all((folder / link).is_file() for link in page.links)  # nothing from elsewhere
    assert not re.search(r"@import|url\(|<script|\$\w", text)
    assert page.tags.count("svg") == 2
    rows = re.findall(r"<tr><td><code>([^<]+)</code>", text)
    assert sorted(rows) == sorted(variable.name for variable in model.listed)
    words = "".join(page.text)
    for element in model.document.iter("ScalarVariable"):
        assert element.attrib["description"] in words


def test_the_figures_stay_in_their_frames(unzipped):
    text = (unzipped / "documentation/index.html").read_text(encoding="utf-8")
    for figure in re.findall(r"<svg.*?</svg>", text, flags=re.S):
        for entity in ("theta", "tau", "gamma", "middot"):
            figure = figure.replace(f"&{entity};", "x")
        root = ET.fromstring(figure)
        width, height = map(float, root.attrib["viewBox"].split()[2:])
        for path in root.iter("{http://www.w3.org/2000/svg}path"):
            numbers = re.findall(r"(-?[\d.]+) (-?[\d.]+)", path.attrib["d"])
            assert all(0 <= float(x) <= width and 0 <= float(y) <= height for x, y in numbers)


def test_icon(unzipped):
    content = (unzipped / "model.png").read_bytes()
    assert content[:8] == b"\x89PNG\r\n\x1a\n" and len(content) < 20_000
    assert struct.unpack(">II", content[16:24]) == (192, 192)


# ---- reference results ----


def columns(text):
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def assert_alike(found, wanted, tolerance):
    """Every column, in units of its largest value."""
    assert list(found) == list(wanted)
    for name, column in wanted.items():
        error = np.max(np.abs(found[name] - column))
        assert error <= tolerance * np.max(np.abs(column)), name


@pytest.fixture(scope="session")
def recomputed():
    return reference_results.results()


def test_reference_results_are_what_the_reference_says(model, recomputed):
    for name, text in recomputed.items():
        if name.startswith(model.identifier):
            assert_alike(columns((REFERENCE / name).read_text()), columns(text), 1e-13)


@pytest.fixture
def given_and_wanted(model, unzipped):
    folder = unzipped / "extra/reference"
    assert (folder / "README.txt").is_file()
    return [columns((folder / f"{model}_{kind}.csv").read_text()) for kind in ("in", "ref")]


@pytest.mark.parametrize("model", [FORWARD], indirect=True)
def test_forward_reference_result(make_model, model, given_and_wanted):
    given, wanted = given_and_wanted
    knots = given["time"]
    fmu = make_model(model).start()
    found = {name: [] for name in wanted}
    for k, time in enumerate(wanted["time"]):
        if k > 0:
            begin = wanted["time"][k - 1]
            j = np.searchsorted(knots, begin + 1e-9) - 1  # the straight piece that begins at or before
            slopes = {n: (given[n][j + 1] - given[n][j]) / (knots[j + 1] - knots[j]) for n in FORWARD_IN}
            fmu.set({n: given[n][j] + slopes[n] * (begin - knots[j]) for n in FORWARD_IN})
            fmu.set_rates(**slopes)
            fmu.step(time - begin)
        for name in wanted:
            found[name].append(time if name == "time" else fmu.get(name))
    assert_alike({name: np.array(column) for name, column in found.items()}, wanted, 1e-11)
    assert set(wanted["mode"]) == {1, 2, 3, 4}  # sticks, loads, lets go, rests on the stop


@pytest.mark.parametrize("model", [FORWARD], indirect=True)
def test_forward_reference_result_where_inputs_are_held(model, given_and_wanted):
    """What README.txt says of a master that does not give derivatives."""
    given, wanted = given_and_wanted
    result = fmpy.simulate_fmu(
        str(model.fmu),
        stop_time=1.0,
        step_size=1e-3,
        output_interval=1e-3,
        input=np.rec.fromarrays(list(given.values()), names=list(given)),
        output=["theta"],
    )
    assert np.max(np.abs(result["theta"][::10] - wanted["theta"])) == pytest.approx(0.005, abs=0.001)


@pytest.mark.parametrize("model", [INVERSE], indirect=True)
def test_inverse_reference_result(make_model, model, given_and_wanted):
    given, wanted = given_and_wanted
    names = [name for name in given if name != "time"]
    fmu = make_model(model)
    found = {name: [] for name in wanted}
    for k, time in enumerate(given["time"]):
        inputs = {name: given[name][k] for name in names}
        if k == 0:
            fmu.start(inputs)
        else:
            fmu.step(time - given["time"][k - 1], **inputs)
        for name in wanted:
            found[name].append(time if name == "time" else fmu.get(name))
    assert_alike({name: np.array(column) for name, column in found.items()}, wanted, 1e-11)
    assert math.isclose(wanted["tau"].max(), 8.9, rel_tol=0.02)
