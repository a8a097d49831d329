"""The FMUs' C code through a whole life (native/lifecycle/), under sanitizers and under valgrind."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from driver import ROOT, models

DRIVERS = ROOT / "build" / "native"
VALGRIND = ["valgrind", "--quiet", "--leak-check=full", "--show-leak-kinds=all", "--error-exitcode=9"]


@pytest.fixture(scope="session", params=models.values(), ids=repr)
def model(request):
    return request.param


@pytest.fixture(scope="module")
def built() -> None:
    build = [sys.executable, ROOT / "fmu_src/tools/build_fmu.py", "--sanitize"]
    made = subprocess.run(build, capture_output=True, text=True)
    assert made.returncode == 0, made.stdout + made.stderr


@pytest.fixture
def live(built, model, tmp_path):
    """Runs a driver of the FMU under test, behind the words of `prefix`."""
    references = [f"{v.name}={v.reference}" for v in model.variables.values()]

    def run(program: str, prefix: list[str | Path] = ()) -> None:
        # Leaks count under AddressSanitizer too; halt_on_error is what the compiler flags ask for already.
        environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "print_stacktrace=1"}
        command = [*prefix, DRIVERS / program, tmp_path, *references]
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
        assert done.returncode == 0, f"exit {done.returncode}\n{done.stdout}\n{done.stderr[-5000:]}"
        assert "all as it must be" in done.stdout

    return run


def test_sanitizers_find_nothing(live, model):
    live(f"{model.identifier}-sanitized")


@pytest.mark.long
@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind is not installed")
def test_valgrind_finds_nothing(live, model):
    live(model.identifier, VALGRIND)
