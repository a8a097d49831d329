"""The rooms of benchmarks/: who imports whom; and the commit that results carry."""

import ast
import subprocess
from pathlib import Path

import pytest
from driver import ROOT

from benchmarks.harness import circumstances
from benchmarks.harness.repository import BENCHMARKS

MOST_LINES = 500
OUTSIDE = ("dualcam", "fmu_src", "masters", "system_examples")


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


def test_only_two_places_change_the_path_of_imports():
    places = [path.name for path in BENCHMARKS.rglob("*.py") if "sys.path.insert" in path.read_text()]
    assert sorted(places) == ["core.py", "oracles.py"]


@pytest.fixture
def repository(tmp_path):
    """A repository with one commit."""
    (tmp_path / "code.c").write_text("int x;\n")
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs/page.md").write_text("old\n")
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    commit(tmp_path, "first")
    return tmp_path


def git(folder: Path, *words: str) -> str:
    identity = ["-c", "user.name=test", "-c", "user.email=test@example.org"]
    done = subprocess.run(["git", *identity, *words], cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def commit(folder: Path, message: str, *words: str) -> None:
    git(folder, "commit", "-q", "--no-gpg-sign", "-m", message, *words)


def test_the_recorded_commit_is_the_one_that_is_checked_out(repository):
    recorded = circumstances.commit(repository)
    assert git(repository, "rev-parse", "HEAD").startswith(recorded) and len(recorded) >= 12
    assert circumstances.is_in_history(recorded, repository)


def test_a_changed_or_a_new_file_is_told(repository):
    clean = circumstances.commit(repository)
    (repository / "docs/page.md").write_text("written by a benchmark\n")
    assert circumstances.commit(repository) == clean
    for name in ("code.c", "new.c"):
        (repository / name).write_text("int y;\n")
        changed = circumstances.commit(repository)
        assert changed == clean + circumstances.CHANGED
        assert not circumstances.is_in_history(changed, repository)
        git(repository, "add", ".")
        commit(repository, name)
        clean = circumstances.commit(repository)


def test_an_amended_commit_leaves_the_history(repository):
    recorded = circumstances.commit(repository)
    (repository / "code.c").write_text("int z;\n")
    commit(repository, "amended", "-a", "--amend")
    assert not circumstances.is_in_history(recorded, repository)


def test_without_a_repository_the_commit_is_unknown(tmp_path):
    found = circumstances.commit(tmp_path)
    assert found == "unknown" and not circumstances.is_in_history(found, tmp_path)
