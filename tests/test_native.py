"""The FMUs' C code under sanitizers and under valgrind: a whole life (native/lifecycle/), and inputs that the
fuzzer has found to reach most code (native/fuzz/, FMI 2.0 and 3.0)."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from driver import ROOT, models
from fuzz_corpus import inputs_of

DRIVERS = ROOT / "build" / "native"
VALGRIND = ["valgrind", "--quiet", "--leak-check=full", "--show-leak-kinds=all", "--error-exitcode=9"]


@pytest.fixture(scope="session", params=models.values(), ids=repr)
def model(request):
    return request.param


def build(what: str) -> None:
    command = [sys.executable, ROOT / "fmu_src/tools/build_fmu.py", "--sanitize", what]
    made = subprocess.run(command, capture_output=True, text=True)
    assert made.returncode == 0, made.stdout + made.stderr


@pytest.fixture(scope="module")
def sanitized() -> None:
    build("sanitized")


@pytest.fixture(scope="module")
def plain() -> None:
    build("plain")


# Leaks count under AddressSanitizer too; halt_on_error is what the compiler flags ask for already.
STRICT = {"ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "print_stacktrace=1"}


def run_to_its_end(command: list[str | Path], **environment: str) -> None:
    done = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, **STRICT, **environment}
    )
    assert done.returncode == 0, f"exit {done.returncode}\n{done.stdout[-500:]}\n{done.stderr[-5000:]}"
    assert "all as it must be" in done.stdout


@pytest.fixture
def live(model, tmp_path):
    """Runs a driver of the FMU under test, behind the words of `prefix`."""
    references = [f"{v.name}={v.reference}" for v in model.variables.values()]

    def run(program: str, prefix: list[str | Path] = ()) -> None:
        run_to_its_end([*prefix, DRIVERS / program, tmp_path, *references])

    return run


def test_sanitizers_find_nothing(sanitized, live, model):
    live(f"{model.identifier}-sanitized")


@pytest.mark.long
@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind is not installed (Debian: valgrind)")
def test_valgrind_finds_nothing(plain, live, model):
    live(model.identifier, VALGRIND)


@pytest.mark.parametrize("version", [2, 3])
def test_inputs_of_the_fuzzer_break_nothing(sanitized, model, version, tmp_path):
    """Each input stands for calls in any order, a table, or a changed saved state; the program checks what
    native/fuzz/guard.h and laws.h say."""
    name = f"{model.identifier}-fmi{version}"
    inputs = inputs_of(name, tmp_path)
    assert len(inputs) >= 50
    run_to_its_end([DRIVERS / f"{name}-replay", *inputs], FUZZ_DIRECTORY=str(tmp_path))
