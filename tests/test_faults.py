"""The FMUs in hosts that do not help (native/faults/): unusual arithmetic, no memory, small stacks, loggers
that do not return, several threads. Each check drives the binaries of both versions of FMI."""

import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path

import build_fmu
import pytest
from driver import ROOT, models
from driver3 import models as models3
from platforms import ALL, X86_WINDOWS, Platform

pytestmark = pytest.mark.skipif(platform.system() != "Linux", reason="the driver replaces functions of glibc")

FOLDER = ROOT / "tests/native"
USED = ("derivatives", "run", "scenes", "support")  # of the lifecycle test
SOURCES = sorted([*(FOLDER / "faults").glob("*.c"), *(FOLDER / "lifecycle" / f"{name}.c" for name in USED)])
FLAGS = ["-O1", "-g", "-w", "-rdynamic", "-pthread", '-DMODEL_GUID=getenv("MODEL_GUID")']
DESCRIPTIONS = [*models.values(), *models3.values()]


@pytest.fixture(scope="session")
def program():
    """One program for all FMUs: the environment tells it the GUID."""
    product = build_fmu.BUILD / "native" / "faults"
    flags = [*build_fmu.TARGET, *FLAGS]
    with build_fmu.locked():
        stamp = build_fmu.fingerprint([*SOURCES, *FOLDER.rglob("*.h")], *flags)
        if not build_fmu.is_fresh(product, stamp):
            build_fmu.compile_c(build_fmu.ZIG, flags, SOURCES, product)
            build_fmu.set_stamp(product, stamp)
    return product


def run_check(
    program: Path, name: str, model, binary: Path, folder: Path, environment: dict[str, str]
) -> str:
    """Runs a check of the driver with a binary of the FMU `model`; returns what the driver prints."""
    references = [f"{v.name}={v.reference}" for v in model.variables.values()]
    command = [program, folder, name, binary, *references]
    return finished(command, {**os.environ, "MODEL_GUID": model.guid, **environment})


def finished(command: list, environment: dict[str, str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, f"exit {done.returncode}\n{done.stdout}\n{done.stderr[-5000:]}"
    assert "all as it must be" in done.stdout
    return done.stdout


@pytest.fixture(params=DESCRIPTIONS, ids=repr)
def check(request, program, tmp_path):
    """Runs a check of the driver with the FMU under test."""
    model = request.param
    version = 3 if model.FOLDER == "fmi3" else 2
    binary = build_fmu.host_platform(version).library(model.identifier)
    return lambda name, **environment: run_check(program, name, model, binary, tmp_path, environment)


def test_arithmetic_of_the_host_changes_nothing(check):
    check("arithmetic")


def test_an_allocation_that_fails_is_a_refused_call(check):
    """Each allocation of a life in turn, alone and with all later ones."""
    failed = int(check("memory").split()[0])
    assert failed > 200


def test_a_thread_with_a_stack_of_64_kB_is_enough(check):
    """The page about hosts names the deepest call: 31 kB."""
    assert int(re.search(r"deepest call: (\d+)", check("stack"))[1]) < 32_000


def test_loggers_that_leave_or_call_back_do_no_harm(check):
    check("loggers")


THROWN = {"throwing_logger.cpp": (2, models), "throwing_update.cpp": (3, models3)}
each_thrower = pytest.mark.parametrize("source", THROWN)


def run_thrower(source: str, compiler: list[str], platform: Platform, place: Path, *before: str) -> None:
    """Compiles a program that throws in a callback, and runs it with the forward FMU's binary."""
    model, program = THROWN[source][1]["DualCamForward"], place / "thrower.exe"
    words = ["-std=c++17", "-isystem", build_fmu.fmi_headers(), FOLDER / source, "-o", program]
    subprocess.run([*compiler, *words, *([] if before else ["-ldl"])], check=True)
    library = platform.library(model.identifier)
    if not library.exists():
        pytest.skip(f"{library.name} is not built for {platform.folder}: run ./build.sh run all")
    environment = {**os.environ, "WINEPREFIX": str(place / "wine"), "WINEDEBUG": "-all"}
    finished([*before, program, f"{'Z:' if before else ''}{library}", model.guid], environment)


@each_thrower
def test_an_exception_of_cpp_goes_through_a_call(source, tmp_path):
    if shutil.which("g++") is None:
        pytest.skip("g++ is not installed (Debian: g++)")
    run_thrower(source, ["g++"], build_fmu.host_platform(THROWN[source][0]), tmp_path)


@pytest.mark.long  # the compiler makes its library of C++ first, once: minutes
@each_thrower
def test_an_exception_of_cpp_goes_through_a_call_on_windows(source, tmp_path):
    wine = shutil.which("wine64") or shutil.which("wine")
    if wine is None:
        pytest.skip("wine is not installed (Debian: wine, wine64)")
    windows = next(p for p in ALL[THROWN[source][0]] if p.targets == (X86_WINDOWS,))
    compiler = [sys.executable, "-m", "ziglang", "c++", "-target", X86_WINDOWS]
    run_thrower(source, compiler, windows, tmp_path, wine)


def test_threads_give_the_bits_of_a_run_alone(check):
    check("threads")


@pytest.fixture(scope="module")
def german(tmp_path_factory):
    """The folder of a locale with a decimal comma, which is made here: few machines have one."""
    folder = tmp_path_factory.mktemp("locale")
    command = ["localedef", "-i", "de_DE", "-f", "UTF-8", folder / "de_DE.UTF-8"]
    if shutil.which("localedef") is None or subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("localedef cannot make the locale de_DE.UTF-8 (Debian: locales)")
    return folder


def test_a_decimal_comma_of_the_host_changes_no_number(check, german):
    """Tables are read again under the locale."""
    check("locale", LOCPATH=str(german), LC_ALL="de_DE.UTF-8")


# ---- ThreadSanitizer ----


@pytest.fixture(scope="module")
def race_finder(tmp_path_factory):
    """Compiles with gcc's ThreadSanitizer, which also sees races that did not change a number."""
    folder = tmp_path_factory.mktemp("races")
    flags = ["-fsanitize=thread", *FLAGS]
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed (Debian: gcc)")

    def compiled(name: str, sources: list[Path], *options: str) -> Path:
        build_fmu.compile_c(["gcc"], [*flags, *options], sources, folder / name)
        return folder / name

    (folder / "probe.c").write_text("int main(void) { return 0; }\n")
    made = subprocess.run(["gcc", *flags, folder / "probe.c", "-o", folder / "probe"], capture_output=True)
    if made.returncode != 0 or subprocess.run([folder / "probe"], capture_output=True).returncode != 0:
        pytest.skip("gcc has no ThreadSanitizer that runs here")
    return compiled


@pytest.mark.long
@pytest.mark.parametrize("model", models.values(), ids=repr)
def test_thread_sanitizer_finds_no_race(race_finder, model, tmp_path):
    """In the FMU and, with the forward FMU, in the threads of a fleet."""
    fmu = build_fmu.dual_cam(model.identifier, check=True)
    options = ["-fPIC", "-shared", *fmu.defines, *build_fmu.identity(fmu)]
    binary = race_finder(f"{model.identifier}.so", fmu.sources, *options)
    strict = {"TSAN_OPTIONS": "halt_on_error=1"}
    run_check(race_finder("faults", SOURCES), "threads", model, binary, tmp_path, strict)
    if model.identifier == "DualCamForward":
        sources = [FOLDER / "fleet_threads.c", *sorted((ROOT / "dualcam/fleet").glob("*.c"))]
        ports = [str(model.variables[name].reference) for name in ("tau", "theta")]
        program = race_finder("fleet", sources)
        finished([program, binary, model.guid, *ports], {**os.environ, **strict})
