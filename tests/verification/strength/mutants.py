"""Mutants: which small mistakes in the C code do the tests notice?

    ./build.sh run mutants

400 places of physics and FMI layer are drawn (choice.py): an operator of arithmetic, a comparison, a logical
operator, a constant, a sign, a statement left out, a condition negated, two arguments of one type swapped.
All mutants are compiled into the FMUs of a copy of the repository at once, each behind a switch (switch.py).
The tests run in that copy (fork_server.py). A mutant is killed if a test fails, crashes or takes much longer;
children.py confirms each such end. equivalent.toml names mutants that no test can notice, and mutants that
change only the cost, with the reason; verdicts whose code has changed are listed. Such a mutant meets the
most promising tests for some seconds, any other one all tests. What came of each mutant is kept in
build/test_strength, with the hash of the C sources. `--again` continues a run that was interrupted; if the C
sources have changed, it runs all mutants of today's. `--survivors` lets the survivors meet tests that are new
or changed. `--report` judges again. The CSV file is written once all mutants have run.
"""

from __future__ import annotations

import csv
import json
import re
import shutil
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness import results
from benchmarks.harness.circumstances import circumstances, core_of
from benchmarks.harness.repository import ROOT, VERIFICATION
from verification.strength import choice, judgements, switch, tree
from verification.strength.judgements import IDENTITY, VERDICTS
from verification.strength.sites import Site

COUNT, SEED = 400, 1
LIMIT = 1000.0  # s of tests for one mutant: all tests
JUDGED_LIMIT = 15.0  # s of tests for one mutant of which a reason tells that no test can notice it
TARGET = 95.0  # % of the mutants that change a result
ROUNDS = 20  # of drawing again for places where the compiler refuses the mistake
# Quick tests of the FMUs and of the core: statics, accuracy, ledger, inclusion, states, derivatives, files.
TESTS = Path(__file__).with_name("tests.txt")
RUN = tree.TREES / "mutants-run"
PLACES = tree.TREES / "places.json"

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


@dataclass(frozen=True)
class Copy:
    """The repository with all mutants. `core`: the hash of the C sources that it was made of."""

    tree: Path
    places: dict[int, Site]
    core: str


def prepare(count: int, seed: int) -> Copy:
    """The copy of the repository with `count` mutants, built. What is known of an earlier copy goes away."""
    PLACES.unlink(missing_ok=True)
    shutil.rmtree(RUN, ignore_errors=True)
    core = core_of(ROOT)
    order = choice.ordered(choice.all_sites(ROOT / "fmu_src"), seed)
    refused: set[Site] = set()
    for _ in range(ROUNDS):
        places = choice.chosen(order, count, refused)
        copy = tree.copy("mutants")
        switch.write(copy / "fmu_src", places)
        message = tree.build(copy)
        if not message:
            kept = {"core": core, "places": {n: vars(site) for n, site in places.items()}}
            PLACES.write_text(json.dumps(kept))
            return Copy(copy, places, core)
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
    judged_limit: float
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


def job_of(options: Options, copy: Copy, numbers: Sequence[int]) -> dict[str, object]:
    known = judgements.listed()
    found = {number: judgements.judgement_of(site, known) for number, site in copy.places.items()}
    return {
        "numbers": list(numbers),
        "names": {number: (site.file, site.function) for number, site in copy.places.items()},
        "hints": hints_of(copy.places, options.output),
        "reach": str(RUN / "reach.json"),
        "status": str(RUN / "status"),
        "limit": options.limit,
        "judged": [number for number, one in found.items() if one is not None and one.verdict != "survives"],
        "judged_limit": options.judged_limit,
        "processes": options.processes,
        "core": copy.core,
    }


def play(options: Options, copy: Copy, numbers: Sequence[int]) -> None:
    """Runs the tests. The end of each mutant stands in a file of its own."""
    (RUN / "status").mkdir(parents=True, exist_ok=True)
    job, marks = RUN / "job.json", RUN / "marks"
    job.write_text(json.dumps(job_of(options, copy, numbers)))
    marks.write_bytes(bytes(max(copy.places) + 1))
    extra = {"DUALCAM_MUTANTS_JOB": str(job), switch.ACTIVE: "-1", switch.REACHED: str(marks)}
    plugin = ["-p", "verification.strength.fork_server", "--basetemp", str(RUN / "pytest")]
    words = [*plugin, "--tb=native", "-p", "no:faulthandler", *options.tests]
    code = tree.run_pytest(copy.tree, words, extra)
    if code != 0:
        raise SystemExit(f"mutants: pytest ended with {code}")


def ends(copy: Copy) -> dict[int, tuple[str, str]]:
    """What came of the tests of each mutant that has been run with this core, and the last test. An end that
    is not confirmed does not count (children.py)."""
    found = {}
    for number in copy.places:
        path = RUN / "status" / str(number)
        if path.exists():
            read = json.loads(path.read_text())
            if read["core"] == copy.core and read.get("confirmed"):
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
    for name in ("seconds", "alone", "reached"):
        known[name] = {test: value for test, value in known[name].items() if kept(test)}
    known["failed"] = [test for test in known["failed"] if kept(test)]
    path.write_text(json.dumps(known))
    for path in (RUN / "status").iterdir():
        if path.suffix == "":
            read = json.loads(path.read_text())
            read["passed"] = [test for test in read["passed"] if kept(test)]
            path.write_text(json.dumps(read))


# ---- the judgement ----


def rows_of(copy: Copy, found: Mapping[int, tuple[str, str]]) -> list[Row]:
    known = judgements.listed()
    rows = []
    for number, (end, test) in sorted(found.items()):
        site = copy.places[number]
        judgement = judgements.judgement_of(site, known)
        verdict = judgement.verdict if judgement is not None else "survives"
        reason = judgement.reason if judgement is not None else ""
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
        rows.append({"mutant": str(number), **place, **mistake, **outcome, "core": copy.core})
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
    known = judgements.listed()
    for text in judgements.refuted(known, rows):
        results.say(console, f"a test kills a mutant of equivalent.toml: {text}")
    for text in judgements.without_place(known, choice.all_sites(ROOT / "fmu_src")):
        results.say(console, f"equivalent.toml judges code that is gone: {text}")
    share = share_killed(rows)
    met = "met" if share >= TARGET else "MISSED"
    results.say(console, f"killed: {share:.1f} % (target {TARGET:g} % {met}), {seconds:.0f} s")


def options_of(words: Sequence[str] | None) -> Options:
    parser = results.options(__doc__, "mutants", folder=VERIFICATION / "results")
    parser.add_argument("--count", type=int, default=COUNT, help=f"number of mutants ({COUNT})")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--limit", type=float, default=LIMIT, help=f"s of tests for one mutant ({LIMIT:g})")
    parser.add_argument(
        "--judged-limit",
        type=float,
        default=JUDGED_LIMIT,
        help=f"s of tests for a mutant that equivalent.toml judges ({JUDGED_LIMIT:g})",
    )
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--only", type=int, nargs="+", default=[], help="numbers of mutants")
    parser.add_argument("--again", action="store_true", help="continue the last run")
    parser.add_argument("--survivors", action="store_true", help="run survivors and changed tests")
    parser.add_argument("--report", action="store_true", help="judge the results of the last run again")
    parser.add_argument("--tests", nargs="+", default=TESTS.read_text().split(), help="test files")
    return Options(**vars(parser.parse_args(words)))


def kept_copy() -> Copy:
    """That of the last run."""
    if not PLACES.exists():
        raise SystemExit("mutants: there is no earlier run to go on with: run ./build.sh run mutants")
    kept = json.loads(PLACES.read_text())
    places = {int(number): Site(**site) for number, site in kept["places"].items()}
    return Copy(tree.TREES / "mutants", places, kept["core"])


def begin(options: Options) -> tuple[Copy, list[int]]:
    """The copy of the repository with its mutants, and the numbers of those to run."""
    if not (options.again or options.survivors or options.report):
        copy = prepare(options.count, options.seed)
        return copy, list(options.only or copy.places)
    copy, core = kept_copy(), core_of(ROOT)
    if copy.core != core:
        print(f"The last run is of core {copy.core}, the C sources are core {core}.", flush=True)
        if options.survivors:
            raise SystemExit("mutants: ./build.sh run mutants runs all mutants of the C sources of today")
        if options.again:
            copy = prepare(options.count, options.seed)
    done = ends(copy)
    if options.survivors:
        forget(changed_tests(copy.tree))
        wanted = options.only or copy.places
        return copy, [number for number in wanted if done.get(number, ("survives",))[0] == "survives"]
    return copy, list(options.only) or [number for number in copy.places if number not in done]


def main(words: Sequence[str] | None = None) -> int:
    options = options_of(words)
    console, started = results.new_console(), time.monotonic()
    copy, numbers = begin(options)
    if not options.report:
        play(options, copy, numbers)
    rows = rows_of(copy, ends(copy))
    report(rows, time.monotonic() - started, console)
    left = len(copy.places) - len(rows)
    if left:
        results.say(console, f"{left} mutants have not run: nothing is written; --again runs them")
        return 1
    results.publish(rows, circumstances("mutants") | {"core": copy.core}, options.output, console)
    return 0 if share_killed(rows) >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
