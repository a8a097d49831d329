"""The wheel and the source archive: contents, installation, and a run without a compiler. Pins, versions and
the workflows that publish the wheel.

The wheel is built once, in place, by the build backend. Its FMUs are those for all platforms in build/. FMUs
that are out of date are compiled first (a minute or two).
"""

import base64
import csv
import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import build_fmu
import platforms
import pytest
import wheel_backend
from driver import ROOT
from filelock import FileLock
from packaging.metadata import Metadata
from packaging.requirements import Requirement

pytestmark = pytest.mark.platforms

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
VERSION = PROJECT["version"]
SMOKE = ROOT / "tests/support/smoke.py"
LARGEST = 8_000_000  # bytes of the wheel
WITH_NETWORK = os.environ.get("DUALCAM_NETWORK") == "1"
PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input"]


def run(*words: str | Path, **options) -> str:
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def backend(hook: str, folder: Path) -> Path:
    """The archive that a hook of the build backend makes."""
    code = f"import wheel_backend; print(wheel_backend.{hook}({str(folder)!r}))"
    return folder / run(sys.executable, "-c", code, cwd=ROOT).splitlines()[-1]


@pytest.fixture(scope="session")
def dist(tmp_path_factory):
    """The folder with wheel and source archive. All test workers share it."""
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    folder = base / "dist"
    with FileLock(base / "dist.lock"):
        if not folder.exists():
            unfinished = base / "unfinished"
            unfinished.mkdir()
            backend("build_sdist", unfinished)
            run(*PIP, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", unfinished, ROOT)
            unfinished.rename(folder)
    return folder


@pytest.fixture(scope="session")
def wheel(dist):
    (path,) = dist.glob("*.whl")
    return path


@pytest.fixture(scope="session")
def members(wheel):
    """Name in the wheel -> content."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


# ---- contents ----


def test_one_wheel_for_all_systems(dist, wheel):
    assert wheel.name == f"dualcam-{VERSION}-py3-none-any.whl"
    assert {path.name for path in dist.iterdir()} == {wheel.name, f"dualcam-{VERSION}.tar.gz"}
    assert wheel.stat().st_size < LARGEST


@pytest.mark.parametrize("version", build_fmu.ALL)
@pytest.mark.parametrize("model", build_fmu.MODELS)
def test_all_fmus_for_all_platforms(members, model, version):
    fmu = members[f"dualcam/fmus/fmi{version}/{model}.fmu"]
    assert fmu == (build_fmu.place(version) / f"{model}.fmu").read_bytes()
    with zipfile.ZipFile(io.BytesIO(fmu)) as archive:
        binaries = {name for name in archive.namelist() if name.startswith("binaries/")}
    assert binaries == {
        f"binaries/{platform.folder}/{model}{platform.suffix}" for platform in build_fmu.ALL[version]
    }


FOR_A_PAGE = {f"dualcam/web/{m}.wasm": f"{m}.wasm" for m in build_fmu.MODELS} | {
    f"dualcam/web/three/{file}": f"three/{file}"
    for file in ("LICENSE", "three.core.min.js", "three.module.min.js")
}


@pytest.mark.parametrize("name", FOR_A_PAGE)
def test_files_for_a_page(members, name):
    """Those of the build folder; the licence of three.js beside its code."""
    assert members[name] == (build_fmu.BUILD / "web" / FOR_A_PAGE[name]).read_bytes()


def test_nothing_else_but_the_package(members):
    """No test, no C file, no product; every file of the package, whatever its kind."""
    package = ROOT / "dualcam"
    files = [p for p in package.rglob("*") if p.is_file() and "__pycache__" not in p.parts]
    expected = {path.relative_to(ROOT).as_posix() for path in files if path.suffix not in (".c", ".h")}
    fmus = {f"dualcam/fmus/fmi{version}/{m}.fmu" for version in build_fmu.ALL for m in build_fmu.MODELS}
    about = f"dualcam-{VERSION}.dist-info/"
    fleets = {
        f"dualcam/fleet/lib/{platform.folder}/dualcam_fleet{platform.suffix}"
        for platform in platforms.PLATFORMS_3
    }
    others = fmus | fleets | set(FOR_A_PAGE)
    assert {name for name in members if not name.startswith(about)} == expected | others
    assert "dualcam/py.typed" in expected and not any((package / n).exists() for n in ("fmus", "web"))


def test_record_lists_every_file_with_its_hash(members):
    record = f"dualcam-{VERSION}.dist-info/RECORD"
    rows = {name: kept for name, kept, _ in csv.reader(io.StringIO(members[record].decode()))}
    assert set(rows) == set(members)
    for name, content in members.items():
        if name != record:
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
            assert rows[name] == f"sha256={digest}", name


def test_metadata(members):
    about = f"dualcam-{VERSION}.dist-info/"
    found = Metadata.from_email(members[about + "METADATA"], validate=True)
    assert (found.name, str(found.version)) == ("dualcam", VERSION)
    assert found.license_expression == PROJECT["license"]
    assert members[about + "licenses/LICENSE"] == (ROOT / "LICENSE").read_bytes()
    assert found.author in (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert found.description == (ROOT / "README.md").read_text(encoding="utf-8")
    assert found.description_content_type == "text/markdown"
    assert found.keywords and found.summary and found.classifiers
    assert members[about + "entry_points.txt"].decode().split() == [
        "[console_scripts]",
        *("dualcam", "=", "dualcam.__main__:main"),
    ]


def test_no_compiler_is_needed_to_run(members):
    lines = re.findall(
        r"^Requires-Dist: (.*)$", members[f"dualcam-{VERSION}.dist-info/METADATA"].decode(), re.M
    )
    needed = {r.name for r in map(Requirement, lines) if r.marker is None}
    assert {"numpy", "scipy", "click"} <= needed
    assert not needed & {"ziglang", "fmpy", "setuptools"}
    extras = {str(r.marker) for r in map(Requirement, lines) if r.marker is not None}
    named = {
        name for name in PROJECT["optional-dependencies"] for extra in extras if f'extra == "{name}"' in extra
    }
    assert named == {*PROJECT["optional-dependencies"]} and all("extra == " in extra for extra in extras)


def test_packing_again_gives_the_same_bytes(wheel, tmp_path):
    assert backend("build_wheel", tmp_path).read_bytes() == wheel.read_bytes()


def test_the_source_archive_holds_what_a_build_needs(dist):
    """Every file on which a product depends, and no test."""
    with tarfile.open(dist / f"dualcam-{VERSION}.tar.gz") as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    folders = ("fmu_src", "modelDescription", "benchmarks/null_fmu", "dualcam")
    files = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.is_file()]
    needed = {p.relative_to(ROOT).as_posix() for p in files if "__pycache__" not in p.parts}
    assert needed | {"LICENSE", "README.md", "pyproject.toml", "CHANGELOG.md", "CITATION.cff"} <= names
    assert not any(name.startswith(("tests/", "build/", ".")) for name in names)


def test_an_editable_installation_finds_the_developers_modules(tmp_path):
    """The file of paths is listed in RECORD, so that pip removes it. The wheel has none (see above)."""
    with zipfile.ZipFile(backend("build_editable", tmp_path)) as archive:
        content = archive.read("dualcam_development.pth")
        record = archive.read(f"dualcam-{VERSION}.dist-info/RECORD").decode()
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
    assert f"dualcam_development.pth,sha256={digest},{len(content)}" in record.split("\n")
    folders = [Path(line) for line in content.decode().splitlines()]
    modules = ("programs", "build_fmu", "robot_joint", "driver", "verification/__init__")
    assert [any((folder / f"{name}.py").is_file() for folder in folders) for name in modules] == [True] * 5
    assert all(folder.is_relative_to(ROOT) for folder in folders)


# ---- installation ----


@pytest.fixture(scope="session")
def installed(wheel, tmp_path_factory):
    """The wheel in a folder of its own."""
    folder = tmp_path_factory.mktemp("installed")
    run(*PIP, "install", "--no-deps", "--no-index", "--target", folder, wheel)
    return folder


def test_first_commands_without_a_compiler(installed, tmp_path):
    """Outside of the clone: no program is on the PATH, and ziglang and FMPy cannot be imported."""
    environment = {name: value for name, value in os.environ.items() if name not in ("PATH", "PYTHONPATH")}
    environment |= {"PYTHONPATH": str(installed), "PATH": str(tmp_path)}
    printed = run(sys.executable, SMOKE, cwd=tmp_path, env=environment, timeout=280)
    assert f"dualcam {VERSION} in {installed / 'dualcam'}" in printed


@pytest.mark.skipif(not WITH_NETWORK, reason="downloads packages, takes minutes: DUALCAM_NETWORK=1 runs it")
def test_a_new_environment(tmp_path):
    """`pip install .` in a new virtual environment, from a copy of the sources; then the first commands. pip
    fetches the compiler for the build alone."""
    clone, venv = tmp_path / "clone", tmp_path / "venv"
    folders = ("dualcam", "fmu_src", "modelDescription", "benchmarks")
    for folder in folders:
        shutil.copytree(ROOT / folder, clone / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "MANIFEST.in", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, clone)
    run(sys.executable, "-m", "venv", venv)
    python = venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    run(python, "-m", "pip", "install", clone, env=environment, timeout=1500)
    run(python, SMOKE, cwd=tmp_path, env=environment)


# ---- pins, versions, workflows ----


def test_a_build_asks_for_the_packages_of_its_extra():
    """Each pin stands once; that of setuptools, which must be there before pyproject.toml is read, twice."""
    extra = PROJECT["optional-dependencies"]["build"]
    asked = wheel_backend.get_requires_for_build_wheel()
    assert set(extra) <= set(asked)
    assert not set(extra) & set(wheel_backend.get_requires_for_build_editable())
    document = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert document["build-system"]["requires"] == [pin for pin in extra if pin.startswith("setuptools")]


def test_versions_agree():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (.*)$", citation, re.M)[1] == VERSION
    released = re.search(r"^date-released: (.*)$", citation, re.M)[1]
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    newest = re.findall(r"^## \[(\d[^]]*)\](?: - (.*))?$", changes, re.M)[0]
    assert newest == (VERSION, released)


WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.name)
@pytest.mark.parametrize(
    "linter",
    [
        ("zizmor", "--offline", "--no-progress", "--persona=pedantic"),
        ("check-jsonschema", "--builtin-schema", "vendor.github-workflows"),
    ],
    ids=lambda words: words[0],
)
def test_workflows_are_valid(linter, workflow):
    program, *options = linter
    run(Path(sys.executable).with_name(program), *options, workflow, cwd=ROOT)


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.name)
def test_workflows_name_what_exists(workflow):
    """Files, jobs and columns of a matrix: the linters do not look for these."""
    text = workflow.read_text(encoding="utf-8")
    named = set(re.findall(r"\b(?:tests|fmu_src)/[\w./-]+", text))
    assert named and {name for name in named if not (ROOT / name).exists()} == set()
    jobs = set(re.findall(r"^  ([\w-]+):$", text[text.index("\njobs:") :], re.M))
    needed = [
        name for names in re.findall(r"^    needs: \[?(.*?)\]?$", text, re.M) for name in names.split(", ")
    ]
    assert needed and set(needed) <= jobs
    columns = set(re.findall(r"^        (\w+): \[", text, re.M))
    assert set(re.findall(r"matrix\.(\w+)", text)) == columns
