"""The harness of the benchmarks: processes, limits in the C sources, the commit that results carry."""

import os
import subprocess
import time
from pathlib import Path

import pytest

from benchmarks.harness import circumstances
from benchmarks.harness.processes import TooLong, time_limit
from benchmarks.rates.measure import MICROSECOND, Group, Limit, Measure
from verification.processes import Lost, in_processes


def square_or_fail(number):
    if number == 3:
        os._exit(7)
    if number == 4:
        time.sleep(60.0)
    return number * number


def test_a_process_that_crashes_or_hangs_is_a_result_and_the_others_go_on():
    found = dict(in_processes(range(8), lambda: square_or_fail, workers=2, longest=1.5))
    assert found.pop(3) == Lost("crash: exit code 7")
    assert found.pop(4) == Lost("hangs: more than 1.5 s")
    assert found == {n: n * n for n in (0, 1, 2, 5, 6, 7)}


def test_the_time_limit_ends_work_and_leaves_no_alarm():
    with pytest.raises(TooLong), time_limit(0.05):
        time.sleep(5.0)
    with time_limit(0.05):
        pass
    time.sleep(0.1)


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


NOTES = {"plain": "a", "quick": "b"}
GROUP = Group("10", {"plain": [2e-6, 4e-6, 2e-6], "quick": [1e-6, 1e-6, 0.5e-6]}, NOTES)


def test_a_row_has_the_median_of_the_times_and_of_the_ratios_of_each_round():
    """Ratios 0.5, 0.25 and 0.25."""
    measure = Measure("x", "X", lambda rounds, console: iter([GROUP]), 3, against="plain", note="more")
    _, quick = measure.rows(GROUP)
    assert (quick["what"], quick["way"], quick["more"]) == ("10", "quick", "b")
    assert (float(quick["us"]), float(quick["ratio"])) == (1.0, 0.25)
    assert (float(quick["lower_quartile"]), float(quick["upper_quartile"])) == (0.25, 0.375)
    alone = Measure("x", "X", measure.take, 3).row(GROUP, "plain")
    assert "ratio" not in alone and float(alone["lower_quartile"]) == 2.0


@pytest.mark.parametrize(
    "limit, met",
    [
        (Limit("10", "quick", "plain", 0.51), True),
        (Limit("10", "quick", "plain", 0.49), False),
        (Limit("10", "plain", MICROSECOND, 2.1), True),
    ],
)
def test_a_limit_compares_medians(limit, met):
    ((words, found),) = Measure("x", "X", iter, 3, limits=(limit,)).judged(GROUP)
    assert found is met and ("met" if met else "MISSED") in words
    assert Measure("x", "X", iter, 3, limits=(limit,)).judged(Group("100", GROUP.times)) == []
