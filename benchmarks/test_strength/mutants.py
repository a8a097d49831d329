"""Mutants: which small mistakes in the C code do the tests notice?

    ./build.sh mutants

400 places of physics and FMI layer are drawn (choice.py): an operator of arithmetic, a comparison, a logical
operator, a constant, a sign, a statement left out, a condition negated, two arguments of one type swapped.
All mutants are compiled into the FMUs of a copy of the repository at once, each behind a switch (switch.py).
The tests run in that copy (fork_server.py). A mutant is killed if a test fails, crashes or takes five times
as long. equivalent.toml names mutants that no test can notice, and mutants that change only the cost, with
the reason. What came of each mutant is kept in build/test_strength. `--again` continues a run that was
interrupted. `--survivors` lets the survivors meet tests that are new or changed. `--report` judges again.
"""

from __future__ import annotations

import csv
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
LIMIT = 1000.0  # s of tests for one mutant: all tests
TARGET = 95.0  # % of the mutants that change a result
IDENTITY = ("file", "function", "kind", "original", "mutated", "nth")  # of a mutant's place
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
ROUNDS = 20  # of drawing again for places where the compiler refuses the mistake
# Quick tests of the FMUs and of the core: statics, accuracy, ledger, inclusion, states, derivatives, files.
TESTS = Path(__file__).with_name("tests.txt")
RUN = tree.TREES / "mutants-run"
VERDICTS = ("killed", "equivalent", "cost only", "survives")

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
    survivors: bool
    report: bool  # nothing is run
    output: Path


def hints_of(places: Mapping[int, Site], output: Path) -> dict[int, str]:
    """The test that killed each mutant, by the results of an earlier run."""
    if not output.exists():
        return {}
    with output.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["verdict"] == "killed"]
    known = {tuple(row[name] for name in IDENTITY): row["test"] for row in rows}
    return {number: known[site.identity] for number, site in places.items() if site.identity in known}


def job_of(options: Options, places: Mapping[int, Site], numbers: Sequence[int]) -> dict[str, object]:
    return {
        "numbers": list(numbers),
        "names": {number: (site.file, site.function) for number, site in places.items()},
        "hints": hints_of(places, options.output),
        "reach": str(RUN / "reach.json"),
        "status": str(RUN / "status"),
        "limit": options.limit,
        "processes": options.processes,
    }


def play(options: Options, copy: Path, places: Mapping[int, Site], numbers: Sequence[int]) -> None:
    """Runs the tests. The end of each mutant stands in a file of its own."""
    if not (options.again or options.survivors):
        shutil.rmtree(RUN, ignore_errors=True)
    (RUN / "status").mkdir(parents=True, exist_ok=True)
    job, marks = RUN / "job.json", RUN / "marks"
    job.write_text(json.dumps(job_of(options, places, numbers)))
    marks.write_bytes(bytes(max(places) + 1))
    extra = {"DUALCAM_MUTANTS_JOB": str(job), switch.ACTIVE: "-1", switch.REACHED: str(marks)}
    plugin = ["-p", "benchmarks.test_strength.fork_server", "--basetemp", str(RUN / "pytest")]
    words = [*plugin, "--tb=native", "-p", "no:faulthandler", *options.tests]
    code = tree.run_pytest(copy, words, extra)
    if code != 0:
        raise SystemExit(f"mutants: pytest ended with {code}")


def ends(places: Mapping[int, Site]) -> dict[int, tuple[str, str]]:
    """What came of the tests of each mutant that has been run, and the last test."""
    found = {}
    for number in places:
        path = RUN / "status" / str(number)
        if path.exists():
            read = json.loads(path.read_text())
            found[number] = (read["end"], read["test"])
    return found


# ---- new tests for survivors ----


def changed_tests(copy: Path) -> list[str]:
    """Copies tests that are new or changed; their files. Other files of the tests must be as in the copy."""
    changed = []
    for path in sorted((ROOT / "tests").rglob("*")):
        name = path.relative_to(ROOT).as_posix()
        if not path.is_file() or "__pycache__" in path.parts:
            continue
        if not (copy / name).exists() or (copy / name).read_bytes() != path.read_bytes():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, copy / name)
            changed.append(name)
    others = [name for name in changed if not Path(name).name.startswith("test_")]
    for name in others:
        print(f"changed: {name}; the results of tests that use this file are those of the old one")
    return changed


def forget(changed: Sequence[str]) -> None:
    """What is known of changed tests."""

    def kept(test: str) -> bool:
        return test.partition("::")[0] not in changed

    path = RUN / "reach.json"
    known = json.loads(path.read_text())
    for name in ("seconds", "reached"):
        known[name] = {test: value for test, value in known[name].items() if kept(test)}
    known["failed"] = [test for test in known["failed"] if kept(test)]
    path.write_text(json.dumps(known))
    for path in (RUN / "status").iterdir():
        if path.suffix == "":
            read = json.loads(path.read_text())
            read["passed"] = [test for test in read["passed"] if kept(test)]
            path.write_text(json.dumps(read))


# ---- the judgement ----


def judged() -> dict[tuple[str, ...], tuple[str, str]]:
    """The verdict "equivalent" or "cost only" and its reason, by the identity of the mutant's place."""
    listed = tomllib.loads(EQUIVALENT.read_text())["mutant"]
    judgements = {}
    for entry in listed:
        identity = tuple(str(entry.get(name, 1)) for name in IDENTITY)
        judgements[identity] = entry.get("verdict", "equivalent"), entry["reason"]
    return judgements


def rows_of(places: Mapping[int, Site], found: Mapping[int, tuple[str, str]]) -> list[Row]:
    known = judged()
    rows = []
    for number, (end, test) in sorted(found.items()):
        site = places[number]
        verdict, reason = known.get(site.identity, ("survives", ""))
        if end != "survives":
            verdict = "killed"
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
    """%, of the mutants that change a result."""
    counts = Counter(row["verdict"] for row in rows)
    return 100.0 * counts["killed"] / max(1, counts["killed"] + counts["survives"])


def report(rows: Sequence[Row], seconds: float, console: results.Console) -> None:
    shown = results.table("Mutants", "kind", *VERDICTS)
    for kind in [*sorted({row["kind"] for row in rows}), "all"]:
        counts = Counter(row["verdict"] for row in rows if kind in ("all", row["kind"]))
        shown.add_row(kind, *(str(counts[verdict]) for verdict in VERDICTS))
    console.print(shown)
    for row in rows:
        if row["verdict"] == "survives":
            place = f"{row['mutant']}: {row['file']}:{row['line']} {row['function']}()"
            mistake = f"{row['kind']}: {row['original']} -> {row['mutated']} ({row['test']})"
            results.say(console, f"{place} {mistake}")
    share = share_killed(rows)
    met = "met" if share >= TARGET else "MISSED"
    results.say(console, f"killed: {share:.1f} % (target {TARGET:g} % {met}), {seconds:.0f} s")


def options_of(words: Sequence[str] | None) -> Options:
    parser = results.options(__doc__, "mutants")
    parser.add_argument("--count", type=int, default=COUNT, help=f"number of mutants ({COUNT})")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--limit", type=float, default=LIMIT, help=f"s of tests for one mutant ({LIMIT:g})")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--only", type=int, nargs="+", default=[], help="numbers of mutants")
    parser.add_argument("--again", action="store_true", help="continue the last run")
    parser.add_argument("--survivors", action="store_true", help="run survivors and changed tests")
    parser.add_argument("--report", action="store_true", help="judge the results of the last run again")
    parser.add_argument("--tests", nargs="+", default=TESTS.read_text().split(), help="test files")
    return Options(**vars(parser.parse_args(words)))


def begin(options: Options) -> tuple[Path, dict[int, Site], list[int]]:
    """The copy of the repository, its mutants, and the numbers of those to run."""
    if not (options.again or options.survivors or options.report):
        copy, places = prepare(options.count, options.seed)
        (tree.TREES / "places.json").write_text(json.dumps({n: vars(site) for n, site in places.items()}))
        return copy, places, list(options.only or places)
    copy = tree.TREES / "mutants"
    kept = json.loads((tree.TREES / "places.json").read_text())
    places = {int(number): Site(**site) for number, site in kept.items()}
    done = ends(places)
    if options.survivors:
        forget(changed_tests(copy))
        return (
            copy,
            places,
            [n for n in options.only or places if done.get(n, ("survives",))[0] == "survives"],
        )
    return copy, places, list(options.only) or [number for number in places if number not in done]


def main(words: Sequence[str] | None = None) -> int:
    options = options_of(words)
    console, started = results.new_console(), time.monotonic()
    copy, places, numbers = begin(options)
    if not options.report:
        play(options, copy, places, numbers)
    rows = rows_of(places, ends(places))
    if not rows:
        return 0
    report(rows, time.monotonic() - started, console)
    results.publish(rows, circumstances("mutants"), options.output, console)
    return 0 if share_killed(rows) >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
