"""Examples, case studies and dualcam.systems import only what their place allows, and are short."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SYSTEMS = sorted((ROOT / "dualcam/systems").rglob("*.py"))
EXAMPLES = sorted(path for path in (ROOT / "system_examples").glob("*.py") if path.stem != "__init__")
SSP = sorted((ROOT / "system_examples/ssp").glob("*.py"))
CASE_STUDIES = sorted((ROOT / "case_studies").rglob("*.py"))
REPOSITORY = {"benchmarks", "build_fmu", "case_studies", "system_examples", "tests", "verification"}


def name(path):
    return str(path.relative_to(ROOT))


def lines(path):
    return len(path.read_text(encoding="utf-8").splitlines())


def imported(path):
    """Full names of imported modules."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module


def top_levels(path):
    return {module.partition(".")[0] for module in imported(path)}


@pytest.mark.parametrize("path", SYSTEMS, ids=name)
def test_systems_need_nothing_outside_dualcam(path):
    assert not top_levels(path) & REPOSITORY


def test_systems_are_imported_without_matplotlib():
    """Nor python-control, whose import takes seconds."""
    modules = [".".join(path.relative_to(ROOT).with_suffix("").parts) for path in SYSTEMS]
    code = f"import sys, {', '.join(modules)}; print({{'matplotlib', 'control'}} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert run.stdout.strip() == "set()"


@pytest.mark.parametrize("path", EXAMPLES, ids=name)
def test_an_example_stands_alone(path):
    assert not top_levels(path) & REPOSITORY
    assert 80 <= lines(path) <= 250


@pytest.mark.parametrize("path", SSP, ids=name)
def test_ssp_packages_do_not_import_other_examples(path):
    modules = [module for module in imported(path) if module.startswith(("system_examples", "case_studies"))]
    assert all(module.startswith("system_examples.ssp") for module in modules)
    assert lines(path) <= 250


@pytest.mark.parametrize("path", CASE_STUDIES, ids=name)
def test_case_studies_import_dualcam_alone(path):
    assert not top_levels(path) & (REPOSITORY - {"case_studies"})
    assert lines(path) <= 500


@pytest.mark.parametrize("path", [*SYSTEMS, *EXAMPLES, *SSP, *CASE_STUDIES], ids=name)
def test_nothing_changes_the_module_path(path):
    assert "sys.path" not in path.read_text(encoding="utf-8")
