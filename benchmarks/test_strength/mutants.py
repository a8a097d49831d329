"""Mutants: which small mistakes in the C code do the tests notice?

    ./build.sh mutants

400 places of physics and FMI layer are drawn (choice.py): an operator of arithmetic, a comparison, a logical
operator, a constant, a sign, a statement left out, a condition negated, two arguments of one type swapped.
All mutants are compiled into the FMUs of a copy of the repository at once, each behind a switch (switch.py).
The tests run in that copy (fork_server.py). A mutant is killed if a test fails, crashes or takes five times
as long. equivalent.toml names mutants that no test can notice, with the reason.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness import results
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import ROOT
from benchmarks.test_strength import choice, switch, tree
from benchmarks.test_strength.sites import Site

COUNT, SEED = 400, 1
LIMIT = 60.0  # s of tests for one mutant
TARGET = 95.0  # % of the mutants that are not equivalent
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
ROUNDS = 20  # of drawing again for places where the compiler refuses the mistake
# Quick tests of the FMUs and of the core: statics, accuracy, ledger, inclusion, states, derivatives, files.
TESTS = Path(__file__).with_name("tests.txt")

Row = dict[str, str]


# ---- the program with all mutants ----


def refused_places(message: str, places: Mapping[int, Site]) -> set[Site]:
    """The places at which the compiler found errors."""
    found = set()
    for name, line in re.findall(r"fmu_src/(\S+?):(\d+):\d+: error", message):
        at = int(line) - switch.LINES_BEFORE
        lines = {number: site.line + site.original.count("\n") for number, site in places.items()}
        found |= {s for n, s in places.items() if s.file == name and s.line <= at <= lines[n]}
    return found


def prepare(count: int, seed: int) -> tuple[Path, dict[int, Site]]:
    """The copy of the repository with `count` mutants, built."""
    order = choice.ordered(choice.all_sites(ROOT / "fmu_src"), seed)
    refused: set[Site] = set()
    for _ in range(ROUNDS):
        places = choice.chosen(order, count, refused)
        copy = tree.copy("mutants")
        switch.write(copy / "fmu_src", places)
        message = tree.build(copy)
        if not message:
            return copy, places
        found = refused_places(message, places)
        if not found:
            raise SystemExit(f"mutants: the copy does not build:\n{message[-3000:]}")
        print(f"{len(found)} mistakes that the compiler refuses", flush=True)
        refused |= found
    raise SystemExit(f"mutants: after {ROUNDS} rounds the compiler still refuses mistakes")


# ---- the run ----


@dataclass(frozen=True)
class Options:
    count: int
    seed: int
    limit: float
    processes: int
    tests: Sequence[str]
    only: Sequence[int]
    again: bool  # the copy and the first pass are those of the last run


def job_of(options: Options, folder: Path, numbers: Sequence[int]) -> dict[str, object]:
    return {
        "numbers": list(numbers),
        "reach": str(folder / "reach.json"),
        "status": str(folder / "status"),
        "limit": options.limit,
        "processes": options.processes,
    }


def play(options: Options, copy: Path, places: Mapping[int, Site], numbers: Sequence[int]) -> None:
    """Runs the tests. The end of each mutant stands in a file of its own."""
    folder = copy.parent / "mutants-run"
    if not options.again:
        shutil.rmtree(folder, ignore_errors=True)
    (folder / "status").mkdir(parents=True, exist_ok=True)
    job, marks = folder / "job.json", folder / "marks"
    job.write_text(json.dumps(job_of(options, folder, numbers)))
    marks.write_bytes(bytes(max(places) + 1))
    extra = {"DUALCAM_MUTANTS_JOB": str(job), switch.ACTIVE: "-1", switch.REACHED: str(marks)}
    plugin = ["-p", "benchmarks.test_strength.fork_server", "--basetemp", str(folder / "pytest")]
    words = [*plugin, *options.tests]
    code = tree.run_pytest(copy, words, extra)
    if code != 0:
        raise SystemExit(f"mutants: pytest ended with {code}")


def ends(places: Mapping[int, Site]) -> dict[int, tuple[str, str]]:
    """What came of the tests of each mutant that has been run, and the last test."""
    found = {}
    for number in places:
        path = tree.TREES / "mutants-run" / "status" / str(number)
        if path.exists() and path.read_text().startswith("{"):  # else the run was interrupted
            read = json.loads(path.read_text())
            found[number] = (read["end"], read["test"])
    return found


# ---- the judgement ----


def reasons() -> dict[tuple[str, ...], str]:
    """Why a mutant is equivalent, by the identity of its place."""
    names = ("file", "function", "kind", "original", "mutated")
    listed = tomllib.loads(EQUIVALENT.read_text())["mutant"]
    return {(*(entry[name] for name in names), str(entry.get("nth", 1))): entry["reason"] for entry in listed}


def rows_of(places: Mapping[int, Site], found: Mapping[int, tuple[str, str]]) -> list[Row]:
    known = reasons()
    rows = []
    for number, (end, test) in sorted(found.items()):
        site = places[number]
        reason = known.get(site.identity, "")
        verdict = ("equivalent" if reason else "survives") if end == "survives" else "killed"
        place = {"file": site.file, "line": str(site.line), "function": site.function}
        mistake = {
            "kind": site.kind,
            "original": site.original,
            "mutated": site.mutated,
            "nth": str(site.nth),
        }
        outcome = {"verdict": verdict, "by": "" if end == "survives" else end, "test": test, "reason": reason}
        rows.append({"mutant": str(number), **place, **mistake, **outcome})
    return rows


def share_killed(rows: Sequence[Row]) -> float:
    """%, of the mutants that are not equivalent."""
    counts = Counter(row["verdict"] for row in rows)
    return 100.0 * counts["killed"] / max(1, counts["killed"] + counts["survives"])


def report(rows: Sequence[Row], seconds: float, console: results.Console) -> None:
    shown = results.table("Mutants", "kind", "killed", "equivalent", "survive")
    for kind in [*sorted({row["kind"] for row in rows}), "all"]:
        counts = Counter(row["verdict"] for row in rows if kind in ("all", row["kind"]))
        shown.add_row(kind, *(str(counts[verdict]) for verdict in ("killed", "equivalent", "survives")))
    console.print(shown)
    for row in rows:
        if row["verdict"] == "survives":
            place = f"{row['mutant']}: {row['file']}:{row['line']} {row['function']}()"
            mistake = f"{row['kind']}: {row['original']} -> {row['mutated']} ({row['test']})"
            results.say(console, f"{place} {mistake}")
    share = share_killed(rows)
    met = "met" if share >= TARGET else "MISSED"
    results.say(console, f"killed: {share:.1f} % (target {TARGET:g} % {met}), {seconds:.0f} s")


def options_of(words: Sequence[str] | None) -> tuple[Options, Path]:
    parser = results.options(__doc__, "mutants")
    parser.add_argument("--count", type=int, default=COUNT, help=f"number of mutants ({COUNT})")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--limit", type=float, default=LIMIT, help=f"s of tests for one mutant ({LIMIT:g})")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--only", type=int, nargs="+", default=[], help="numbers of mutants")
    parser.add_argument("--again", action="store_true", help="without a new copy, only what has not run yet")
    parser.add_argument("--tests", nargs="+", default=TESTS.read_text().split(), help="test files")
    a = parser.parse_args(words)
    return Options(a.count, a.seed, a.limit, a.processes, a.tests, a.only, a.again), a.output


def main(words: Sequence[str] | None = None) -> int:
    options, output = options_of(words)
    console, begin = results.new_console(), time.monotonic()
    if options.again:
        copy = tree.TREES / "mutants"
        kept = json.loads((tree.TREES / "places.json").read_text())
        places = {int(number): Site(**site) for number, site in kept.items()}
    else:
        copy, places = prepare(options.count, options.seed)
        (tree.TREES / "places.json").write_text(json.dumps({n: vars(site) for n, site in places.items()}))
    done = ends(places) if options.again else {}
    numbers = options.only or [number for number in places if number not in done]
    play(options, copy, places, numbers)
    rows = rows_of(places, ends(places))
    if not rows:
        return 0
    report(rows, time.monotonic() - begin, console)
    results.publish(rows, circumstances("mutants"), output, console)
    return 0 if share_killed(rows) >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
