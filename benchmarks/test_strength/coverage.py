"""Branch coverage: which branches of the C code do the tests take?

    ./build.sh coverage

A branch is a condition with one of its two values. In a copy of the repository, each condition of physics and
FMI layer marks what came out (decisions.py). The tests run there. Several evaluations of a decision with more
than one condition also show MC/DC: that each condition alone changes the outcome. unreached.toml names
branches that no test takes, with the reason.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness import results
from benchmarks.harness.circumstances import circumstances
from benchmarks.test_strength import decisions, tree
from benchmarks.test_strength.choice import GENERATED, ROOMS
from benchmarks.test_strength.decisions import Decision
from benchmarks.test_strength.mutants import TESTS

TARGET = 97.0  # % of the branches
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


def measure(tests: Sequence[str]) -> tuple[list[Taken], int]:
    """The branches of all decisions, and the exit code of the tests."""
    copy = tree.copy("branches")
    found = decisions.write(copy / "fmu_src", files_of(copy / "fmu_src"))
    message = tree.build(copy)
    if message:
        raise SystemExit(f"coverage: the copy does not build:\n{message[-3000:]}")
    marks = tree.TREES / "branches.marks"
    marks.write_bytes(bytes(found[-1].place + found[-1].size))
    folder = str(tree.TREES / "branches-run")
    code = tree.run_pytest(copy, ["--basetemp", folder, *tests], {decisions.SEEN: str(marks)})
    seen = marks.read_bytes()
    return [Taken(d, d.branches(seen), d.independent(seen)) for d in found], code


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
    console.print(shown)


def main(words: Sequence[str] | None = None) -> int:
    parser = results.options(__doc__, "coverage")
    parser.add_argument("tests", nargs="*", default=TESTS.read_text().split())
    arguments = parser.parse_args(words)
    console = results.new_console()
    measured, code = measure(arguments.tests)
    rows = rows_of(measured)
    report(rows, measured, console)
    results.publish(rows, circumstances("coverage"), arguments.output, console)
    if code != 0:
        results.say(console, f"pytest ended with {code}: some tests fail in the copy")
    return 0 if float(rows[-1]["branches_percent"]) >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
