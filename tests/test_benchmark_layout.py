"""The rooms of benchmarks/: who imports whom."""

import ast

import pytest
from driver import ROOT

from benchmarks.harness.repository import BENCHMARKS

MOST_LINES = 500
OUTSIDE = ("dualcam", "fmu_src", "system_examples", "case_studies")


def imported(path):
    """The modules that a file imports; of `from a import b` both a and a.b."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def question_of(path):
    """The module or package directly below benchmarks/."""
    return path.relative_to(BENCHMARKS).parts[0].removesuffix(".py")


@pytest.mark.parametrize("folder", OUTSIDE)
def test_nothing_outside_imports_benchmarks(folder):
    files = [path for path in (ROOT / folder).rglob("*.py")]
    assert files
    assert not [path for path in files if any(n.split(".")[0] == "benchmarks" for n in imported(path))]


def test_the_harness_imports_no_benchmark():
    for path in (BENCHMARKS / "harness").glob("*.py"):
        names = [name for name in imported(path) if name.startswith("benchmarks.")]
        assert all(name.startswith("benchmarks.harness") for name in names), path


def test_benchmarks_import_one_another_without_a_circle():
    known = {question_of(path) for path in BENCHMARKS.rglob("*.py")}
    arrows = {name: set() for name in known}
    for path in BENCHMARKS.rglob("*.py"):
        used = {name.split(".")[1] for name in imported(path) if name.startswith("benchmarks.")}
        arrows[question_of(path)] |= (used & known) - {question_of(path)}
    while leaves := [name for name, used in arrows.items() if not used]:
        arrows = {name: used - set(leaves) for name, used in arrows.items() if name not in leaves}
    assert not arrows


def test_no_file_is_long():
    files = [path for path in BENCHMARKS.rglob("*") if path.suffix in (".py", ".c", ".h")]
    assert not [path for path in files if len(path.read_text().splitlines()) > MOST_LINES]
