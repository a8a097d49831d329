"""A copy of the repository, in which the C code may be changed and built."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from wheel_backend import module_folders

from benchmarks.harness.repository import ROOT

TREES = ROOT / "build" / "test_strength"
LEFT_OUT = ("build", "dist", ".git", ".venv", "__pycache__", ".hypothesis", ".mypy_cache", ".ruff_cache")
QUICKLY = {
    'OPTIMISATION = "-O3"': 'OPTIMISATION = "-O1"',
    'LTO = "-flto"': 'LTO = "-O1"',
    "LIBRARY = (": 'LIBRARY = ("-fsanitize=bounds", "-fsanitize-trap=bounds", ',
}
BUILD = """
import build_fmu
for version in build_fmu.ALL:
    for name in build_fmu.MODELS:
        build_fmu.build(build_fmu.dual_cam(name, False, version))
build_fmu.build_fleets()
"""


def copy(name: str) -> Path:
    """A fresh copy. What an earlier copy of this name has built stays."""
    tree = TREES / name
    for path in tree.iterdir() if tree.exists() else ():
        if path.name != "build":
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    tree.mkdir(parents=True, exist_ok=True)
    for path in ROOT.iterdir():
        if path.name in LEFT_OUT:
            continue
        if path.is_dir():
            shutil.copytree(path, tree / path.name, ignore=shutil.ignore_patterns(*LEFT_OUT))
        else:
            shutil.copy2(path, tree / path.name)
    compile_quickly(tree)
    return tree


def compile_quickly(tree: Path) -> None:
    """Half a minute of compiling instead of two minutes: without link-time optimisation. A function that
    leaves the bounds of an array ends the program, as under the sanitizers of tests/test_native.py."""
    path = tree / "fmu_src" / "tools" / "platforms.py"
    text = path.read_text()
    for before, after in QUICKLY.items():
        if before not in text:
            raise SystemExit(f"{path} has no {before}")
        text = text.replace(before, after)
    path.write_text(text)


def environment(tree: Path, extra: Mapping[str, str] | None = None) -> dict[str, str]:
    path = os.pathsep.join(str(tree / folder) for folder in module_folders())
    threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    return {**os.environ, "PYTHONPATH": path, **threads, **(extra or {})}


def build(tree: Path) -> str:
    """Builds the FMUs of the copy for this machine; what the compiler says if the build fails, else ""."""
    made = subprocess.run(
        [sys.executable, "-c", BUILD], cwd=tree, env=environment(tree), capture_output=True, text=True
    )
    return made.stdout + made.stderr if made.returncode != 0 else ""


def run_pytest(tree: Path, words: Sequence[str], extra: Mapping[str, str]) -> int:
    """Runs tests of the copy; its exit code."""
    command = [sys.executable, "-m", "pytest", "-p", "no:xdist", "-p", "no:cacheprovider", *words]
    return subprocess.run(command, cwd=tree, env=environment(tree, extra)).returncode
