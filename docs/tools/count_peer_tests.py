"""Counts tests in the repositories of other projects, for docs/trust-tables.md.

python docs/tools/count_peer_tests.py NAME=CLONE ...

NAME: a key of PEERS. CLONE: the folder of a clone of its repository, in which the commit to be counted is
checked out or is HEAD. Writes tests/verification/results/peer_tests.csv.
"""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

RESULT = Path(__file__).resolve().parents[2] / "tests/verification/results/peer_tests.csv"


@dataclass(frozen=True)
class Count:
    """`pattern`: of a line that begins a test; empty: each file counts. `files`: of paths."""

    what: str
    files: str
    pattern: str = ""


PEERS = {
    "SUNDIALS": (
        "https://github.com/LLNL/sundials",
        [
            Count("programs of unit tests", r"test/unit_tests/.*test[^/]*\.(c|cpp|f90|cu)"),
            Count("answer files", r"(examples|test)/.*\.out"),
        ],
    ),
    "MuJoCo": (
        "https://github.com/google-deepmind/mujoco",
        [
            Count("test cases in C++", r"test/.*\.cc", r"\s*TEST(_F|_P)?\("),
            Count("test functions in Python", r".*\.py", r"\s*def test"),
        ],
    ),
    "Box2D": (
        "https://github.com/erincatto/box2d",
        [Count("test functions", r"test/.*\.c", r"\s*RUN_SUBTEST\(")],
    ),
}


def git(clone: str, *words: str) -> str:
    return subprocess.run(
        ["git", "-C", clone, *words], capture_output=True, text=True, check=True, errors="replace"
    ).stdout


def number(clone: str, count: Count) -> int:
    paths = [path for path in git(clone, "ls-tree", "-r", "--name-only", "HEAD").splitlines()]
    chosen = [path for path in paths if re.fullmatch(count.files, path)]
    if not count.pattern:
        return len(chosen)
    lines = (line for path in chosen for line in git(clone, "show", f"HEAD:{path}").splitlines())
    return sum(re.match(count.pattern, line) is not None for line in lines)


def rows_of(name: str, clone: str) -> list[dict[str, str]]:
    address, counts = PEERS[name]
    commit, date = git(clone, "log", "-1", "--format=%h %ad", "--date=short").split()
    return [
        {
            "project": name,
            "what": count.what,
            "number": str(number(clone, count)),
            "date": date,
            "source": f"{address}/tree/{commit}",
        }
        for count in counts
    ]


def main() -> int:
    clones = dict(word.split("=", 1) for word in sys.argv[1:] if "=" in word)
    if not clones or set(clones) - set(PEERS):
        print(__doc__)
        return 2
    rows = [row for name, clone in clones.items() for row in rows_of(name, clone)]
    with RESULT.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"written: {RESULT}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
