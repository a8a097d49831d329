"""The FMU's C code through a whole life (native/lifecycle.c), under sanitizers and under valgrind."""

import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
DRIVERS = ROOT / "build" / "native"


@pytest.fixture(scope="module")
def references() -> list[str]:
    """Builds both drivers; returns their arguments, `name=value reference` of every variable."""
    build = [sys.executable, ROOT / "fmu_src/build_fmu.py", "--sanitize"]
    made = subprocess.run(build, capture_output=True, text=True)
    assert made.returncode == 0, made.stdout + made.stderr
    variables = ET.parse(ROOT / "modelDescription/DualCamForward.xml").iter("ScalarVariable")
    return [f"{v.attrib['name']}={v.attrib['valueReference']}" for v in variables]


def live(command: list[str | Path]) -> None:
    # Leaks count under AddressSanitizer too; halt_on_error is what the compiler flags ask for already.
    environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "print_stacktrace=1"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, f"exit {done.returncode}\n{done.stdout}\n{done.stderr[-5000:]}"
    assert "all as it must be" in done.stdout


def test_sanitizers_find_nothing(references: list[str]) -> None:
    live([DRIVERS / "lifecycle-sanitized", *references])


@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind is not installed")
def test_valgrind_finds_nothing(references: list[str]) -> None:
    valgrind = ["valgrind", "--quiet", "--leak-check=full", "--show-leak-kinds=all", "--error-exitcode=9"]
    live([*valgrind, DRIVERS / "lifecycle", *references])
