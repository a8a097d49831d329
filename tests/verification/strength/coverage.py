"""Branch coverage: which branches of the C code do the tests take?

    ./build.sh run coverage            all pieces anew
    ./build.sh run coverage --again    only the test files that changed, or that an interrupted run left out

A branch is a condition with one of its two values. In a copy of the repository, each condition of physics and
FMI layer marks what came out (decisions.py). The tests run there, one file after the other; the marks of each
file are kept. Several evaluations of a decision with more than one condition also show MC/DC: that each
condition alone changes the outcome. unreached.toml names branches that no test takes, with the reason.
"""

from __future__ import annotations

import hashlib
import shutil
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness import results
from benchmarks.harness.circumstances import circumstances, core_of
from benchmarks.harness.repository import ROOT, VERIFICATION
from verification.strength import decisions, tree
from verification.strength.choice import GENERATED, ROOMS
from verification.strength.decisions import Decision

TARGET = 97.0  # % of the branches
# They drive the C core. The longest ones stand first: two processes then end at the same time. Left out are
# files of the suite that are long and take no branch that others do not take.
TESTS = Path(__file__).with_name("branch_tests.txt")
PATIENT = ("-q", "--no-header", "-o", "faulthandler_timeout=0")  # marks make sanitizers slow
NO_FAILURE = (0, 5)  # exit codes of pytest: all pass, none is to run
UNREACHED = Path(__file__).with_name("unreached.toml")
# Files with a line of their own: the decision of the mode, and the state machine of the FMI calls.
DECISIVE = ("forward/decide.c", "fmi/simulation.c", "fmi/instance.c", "fmi/fmi2.c", "fmi/fmi3.c")

Row = dict[str, str]
Branch = tuple[str, str, str, bool]  # file, function, condition, value


@dataclass(frozen=True)
class Taken:
    """The branches of one decision."""

    decision: Decision
    branches: list[tuple[str, bool, bool]]
    independent: list[tuple[str, bool]]

    def missing(self) -> list[Branch]:
        d = self.decision
        return [(d.file, d.function, text, value) for text, value, seen in self.branches if not seen]


def files_of(core: Path) -> list[Path]:
    listed = (path for room in ROOMS for path in sorted((core / room).glob("*.[ch]")))
    return [path for path in listed if path.name not in GENERATED]


@dataclass(frozen=True)
class Copy:
    """The repository with marks. `decisions` stand in the order of their places."""

    tree: Path
    decisions: list[Decision]

    @property
    def size(self) -> int:
        return self.decisions[-1].place + self.decisions[-1].size


def fingerprint(files: Iterable[Path]) -> str:
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:12]


def prepare() -> Copy:
    copy = tree.copy("branches")
    found = decisions.write(copy / "fmu_src", files_of(copy / "fmu_src"))
    message = tree.build(copy)
    if message:
        raise SystemExit(f"coverage: the copy does not build:\n{message[-3000:]}")
    return Copy(copy, found)


def prepared() -> Copy:
    """The copy of the last run, with the tests of today."""
    copy, core, found, place = tree.TREES / "branches", ROOT / "fmu_src", [], 0
    for path in files_of(core):
        _, some, place = decisions.marked(path, path.relative_to(core).as_posix(), place)
        found += some
    shutil.copytree(ROOT / "tests", copy / "tests", dirs_exist_ok=True)
    return Copy(copy, found)


def pieces_of(tests: Iterable[str]) -> list[str]:
    """The test files, also those of the folders."""
    listed = (sorted((ROOT / name).rglob("test_*.py")) or [ROOT / name] for name in tests)
    return list(dict.fromkeys(path.relative_to(ROOT).as_posix() for paths in listed for path in paths))


def run_piece(copy: Copy, piece: str, kept: Path) -> tuple[bytes, int]:
    """The marks of a test file, and the exit code of its tests. Both are kept."""
    name = f"{piece.removesuffix('.py').replace('/', '.')}-{fingerprint([ROOT / piece])}"
    ended = kept / f"{name}.ended"
    marks = kept / f"{name}.marks"
    if not ended.exists():
        marks.write_bytes(bytes(copy.size))
        with tempfile.TemporaryDirectory() as folder:  # its name is short enough for parameters of the FMU
            words = [*PATIENT, "--basetemp", f"{folder}/run", piece]
            code = tree.run_pytest(copy.tree, words, {decisions.SEEN: str(marks)})
        ended.write_text(str(code))
    return marks.read_bytes(), int(ended.read_text())


def measure(tests: Sequence[str], again: bool, processes: int) -> tuple[list[Taken], list[str]]:
    """The branches of all decisions, and the test files in which tests fail."""
    kept = tree.TREES / f"branches-{core_of(ROOT)}"
    if again and not kept.exists():
        print(f"No marks are known of the C sources, core {core_of(ROOT)}: all tests run.", flush=True)
    again = again and kept.exists()
    copy = prepared() if again else prepare()
    for old in tree.TREES.glob("branches-*") if not again else ():
        shutil.rmtree(old)
    kept.mkdir(exist_ok=True)
    pieces, failed, seen = pieces_of(tests), [], 0
    with ThreadPoolExecutor(processes) as pool:
        ended = pool.map(lambda piece: run_piece(copy, piece, kept), pieces)
        for piece, (marks, code) in zip(pieces, ended, strict=True):
            seen |= int.from_bytes(marks, "little")
            failed += [piece] if code not in NO_FAILURE else []
    united = seen.to_bytes(copy.size, "little")
    return [Taken(d, d.branches(united), d.independent(united)) for d in copy.decisions], failed


def reasons() -> dict[Branch, str]:
    """Why no test takes a branch."""
    listed = tomllib.loads(UNREACHED.read_text())["branch"]
    return {(e["file"], e["function"], e["condition"], e["value"]): e["reason"] for e in listed}


def row_of(name: str, part: Sequence[Taken]) -> Row:
    """The share of branches, and of conditions that change their decision alone, in some decisions."""
    branches = [seen for taken in part for _, _, seen in taken.branches]
    alone = [seen for taken in part for _, seen in taken.independent]
    known = reasons()
    unexplained = [branch for taken in part for branch in taken.missing() if branch not in known]
    return {
        "part": name,
        "decisions": str(len(part)),
        "branches": str(len(branches)),
        "taken": str(sum(branches)),
        "unexplained": str(len(unexplained)),
        "branches_percent": f"{100.0 * sum(branches) / max(1, len(branches)):.2f}",
        "conditions": str(len(alone)),
        "independent": str(sum(alone)),
        "mcdc_percent": f"{100.0 * sum(alone) / max(1, len(alone)):.2f}",
    }


def within(measured: Iterable[Taken], part: str) -> list[Taken]:
    """The decisions in a room or a file."""
    return [taken for taken in measured if f"{taken.decision.file}/".startswith(f"{part}/")]


def rows_of(measured: Sequence[Taken]) -> list[Row]:
    parts = [row_of(part, within(measured, part)) for part in (*ROOMS, *DECISIVE)]
    return [*parts, row_of("all", measured)]


def report(rows: Sequence[Row], measured: Sequence[Taken], console: results.Console) -> None:
    shown = results.table("Branches", "part", "branches", "taken", "%", "unexplained", "MC/DC, %")
    for row in rows:
        names = ("part", "branches", "taken", "branches_percent", "unexplained", "mcdc_percent")
        shown.add_row(*(row[name] for name in names))
    known = reasons()
    for taken in measured:
        for branch in taken.missing():
            file, function, text, value = branch
            place = f"{file}:{taken.decision.line} {function}()"
            results.say(console, f"{place} {text} is never {str(value).lower()}: {known.get(branch, '')}")
    left = {branch for taken in measured for branch in taken.missing()}
    for file, function, text, value in known.keys() - left:
        results.say(
            console, f"{file} {function}() {text} is {str(value).lower()} now: remove it from {UNREACHED}"
        )
    console.print(shown)


def main(words: Sequence[str] | None = None) -> int:
    parser = results.options(__doc__, "coverage", folder=VERIFICATION / "results")
    parser.add_argument("tests", nargs="*", default=TESTS.read_text().split())
    parser.add_argument("--again", action="store_true", help="without a new copy, only what has not run yet")
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args(words)
    console = results.new_console()
    facts = circumstances("coverage")
    measured, failed = measure(arguments.tests, arguments.again, arguments.processes)
    rows = rows_of(measured)
    report(rows, measured, console)
    results.publish(rows, facts, arguments.output, console)
    for piece in failed:
        results.say(console, f"{piece}: some tests fail in the copy")
    return 0 if float(rows[-1]["branches_percent"]) >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
