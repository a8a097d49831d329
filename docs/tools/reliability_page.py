"""Writes docs/reliability.md and docs/elementary-functions.md from the results of the commands they name.

python docs/tools/reliability_page.py
"""

from __future__ import annotations

import base64
import csv
import re
import tomllib
import zipfile
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "tests/verification/results"
CORPUS = ROOT / "tests/fuzz_corpus"

Rows = list[dict[str, str]]

HEAD = """\
# How reliable are the FMUs?

Read this page to decide whether the FMUs may run in your process, and whether their numbers can be trusted.
The first section has the answers, the others say what was tried, what came out, and which command tries it
again. `docs/tools/reliability_page.py` writes this page from their results. Each measurement names its
commit; `git log COMMIT.. -- fmu_src` lists what has changed in the C code since then.
"""


def read(name: str) -> Rows:
    """A CSV file of results; nothing where there is none yet."""
    path = RESULTS / f"{name}.csv"
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def measured(rows: Rows) -> str:
    last = rows[-1]
    return f"Measured on {last['date']}: {last['machine']}; {last['versions']}; commit {last['commit']}.\n"


def states() -> str:
    """Cells of both state machines."""
    rows = []
    for version in ("fmi2", "fmi3"):
        with (ROOT / f"tests/{version}/states.csv").open(newline="") as file:
            cells = [row for row in csv.reader(file)]
        body = cells[2:]  # below the names of the states and their sections
        counts = Counter(cell.split()[0] for row in body for cell in row[3:] if cell.strip())
        rows.append(
            [version.replace("fmi", "FMI ") + ".0", len(body), sum(counts.values()), counts["lenient"]]
        )
    columns = (
        "version",
        "functions or groups of them",
        "cells",
        "cells where the FMU answers and the standard asks for a refusal",
    )
    return f"""\
## Calls in every state

Each function of the standard is called in each state that the FMU can reach, for co-simulation and model
exchange. Each refusal must give one message and change nothing in the saved state, bit for bit. The tables
`tests/fmi2/states.csv` and `tests/fmi3/states.csv` have the section of the standard for each function.
Command: `./build.sh test tests/fmi2 tests/fmi3`.

{table(columns, rows)}"""


@dataclass
class Outcome:
    """Of one row of the stress table."""

    varied: str
    runs: int
    judged: int
    wrong: int
    refused: int


def outcomes() -> list[Outcome]:
    text = (ROOT / "docs/stress.md").read_text(encoding="utf-8")
    lines = next(part for part in text.split("\n\n") if part.startswith("| varied | runs |")).splitlines()
    rows = [line.strip("| ").split(" | ") for line in lines[2:]]
    return [Outcome(row[0], int(row[1]), int(row[2]), int(row[4]), int(row[5])) for row in rows]


def long_fuzzing() -> str:
    """What the last long runs found, a sentence."""
    runs = read("fuzz_runs")
    if not runs or runs[-1]["findings"] != "0":
        return "Long fuzzing with other scenes still finds wrong ones."
    clean = sum(run["findings"] == "0" for run in runs)
    return (
        f"Of {len(runs)} long runs of fuzzing with other scenes, {clean} found nothing, "
        "among them the last one."
    )


def long_runs() -> str:
    """The table of long runs."""
    runs = read("fuzz_runs")
    if not runs:
        return ""
    keys = ("seed", "commit", "minutes", "examples", "findings")
    rows = [[f"{int(run[key]):,}" if key == "examples" else run[key] for key in keys] for run in runs]
    return f"""\
Recorded runs of `./build.sh run fuzz`, by `./build.sh run fuzz-record --seed N`. A finding is a test that
failed.

{table(keys, rows)}
{measured(runs)}"""


def verdict() -> str:
    laws = {
        "everything at random": "Coulomb friction",
        "everything and friction laws": "friction by speed",
        "load laws at": "friction by load",
    }
    of_random = [(words, row) for key, words in laws.items() for row in outcomes() if key in row.varied]
    counts = ", ".join(f"{row.wrong} of {row.runs:,} ({words})" for words, row in of_random)
    amount = "a few are" if any(row.wrong for _, row in of_random) else "none is"
    refused = sum(row.refused for _, row in of_random)
    number = sum(row.runs for _, row in of_random)
    builds = read("trajectory_hash")
    equal = sum(row["scenes_that_differ"] == "0" for row in builds)
    return f"""\
## Answers

- **Do the numbers follow from the equations?** Yes, to the bounds of [accuracy.md](accuracy.md) in ordinary
  scenes. Of the {number:,} extreme random scenes of [stress.md](stress.md) {amount} wrong: {counts}.
  {refused:,} of them are refused with a message: [limits.md](limits.md#when-a-step-is-refused) has the
  remedies. {long_fuzzing()}
  [Fuzzing](#fuzzing) has the runs.
- **Do the equations describe a real cam?** Not shown. No hardware was measured for this project. The paper
  behind it compares its model with a bench: [paper.md](paper.md). Clearance of the grooves, an elastic pin
  and heat are not in the FMUs: [limits.md](limits.md#of-the-model).
- **What is known to be wrong?** [stress.md](stress.md#wrong) lists runs that came out wrong,
  [limits.md](limits.md) what the model leaves out.
- **Can an FMU end or block my process?** No way is known in a host that masks floating-point traps, as hosts
  do: [hosts.md](hosts.md). Each step ends after a bounded number of operations, about two seconds at most.
  A fault of the host gives a message.
- **Are the numbers the same elsewhere?** {equal} of {len(builds)} builds for Linux, Windows and WebAssembly
  give equal bits. The binaries for macOS were never run.
- **Do the tests notice a mistake in the code?** Most: [test-strength.md](test-strength.md) counts.
"""


def scenes() -> str:
    """The stress table, in a sentence."""
    rows = outcomes()
    names = ("runs", "judged", "wrong", "refused")
    runs, judged, wrong, refused = (sum(getattr(row, name) for row in rows) for name in names)
    return f"""\
## Scenes

{runs:,} runs over many decades of every parameter, {judged:,} of them compared with an independent solution
or with a second run whose steps are cut differently: {wrong} came out wrong, and {refused:,} were refused.
[stress.md](stress.md) has the table, and lists wrong runs and messages. Command: `./build.sh run stress`.
"""


def inputs_of_fuzzing() -> tuple[int, int]:
    """Number of all inputs, and their bytes."""
    findings = tomllib.loads((CORPUS / "findings.toml").read_text(encoding="utf-8"))
    sizes = [len(base64.b64decode(text)) for kept in findings.values() for text in kept.values()]
    for path in CORPUS.glob("*.zip"):
        with zipfile.ZipFile(path) as archive:
            sizes += [member.file_size for member in archive.infolist()]
    return len(sizes), sum(sizes)


def fuzzing() -> str:
    count, size = inputs_of_fuzzing()
    return f"""\
## Fuzzing

libFuzzer drives both interfaces of both FMI versions with random calls, values and sizes, and the readers
of tables and of saved states. Sanitizers watch addresses and undefined behaviour. After each call the
target checks: no NaN under OK, each step ends at its time, no energy from nothing, a refused call changes
nothing, a restored state repeats its step bit for bit, a reset instance equals a new one. The corpus has
{count} inputs, {size // 1000} kB; the suite plays them all. Commands: `./build.sh run fuzz-calls`, and
`./build.sh run fuzz` for mechanisms, extreme values, design files and plans.

{long_runs()}"""


FAULTS = """\
## Faults of the host

`tests/test_faults.py` lets each allocation fail in turn, gives stacks of 64 kB, loggers that leave by longjmp
or by a C++ exception, other rounding modes, flushing to zero, floating-point traps, and locales with a
comma in numbers. `tests/test_full_disk.py` fills the disk. [hosts.md](hosts.md) says what comes out.
Command: `./build.sh test tests/test_faults.py tests/test_full_disk.py`.
"""


def endurance() -> str:
    rows = read("endurance")
    if not rows:
        return ""
    last = {(row["scene"], row["what"]): row for row in rows}
    lines = [[r["scene"], f"{int(r['count']):,}", r["what"], r["value"]] for r in last.values()]
    return f"""\
## Endurance

Lives are instances that are made, started, reset and freed. Errors of time, phase and energy are against the
closed form. They are rounding, and grow with the number of steps. The angle of stick-slip is compared with
that after the first period. Energies are relative: to that of the oscillation, and to the work done.
Command: `./build.sh run endurance`.

{table(["scene", "steps or lives", "what", "value"], lines)}
{measured(rows)}"""


def hashes() -> str:
    rows = read("trajectory_hash")
    if not rows:
        return ""
    lines = [[r["platform"], r["compiler"], f"`{r['hash']}`", r["scenes_that_differ"]] for r in rows]
    return f"""\
## Platforms

One hash of every bit of all outputs, of both FMUs, over {rows[0]["scenes"]} scenes. The core has its own exp,
sin and so on ([elementary-functions.md](elementary-functions.md)), and no compiler may fuse operations.
Command: `./build.sh run hash`.

{table(["platform", "compiler", "hash", "scenes that differ"], lines)}
{measured(rows)}"""


def strength() -> str:
    """Coverage and mutants, of which docs/test-strength.md has the details."""
    branches, mutants = read("coverage"), read("mutants")
    text = ""
    if branches:
        columns = ("part", "branches", "branches_percent", "mcdc_percent")
        lines = [[row[column] for column in columns] for row in branches]
        text += f"{table(['part', 'branches', 'taken, %', 'MC/DC, %'], lines)}\n{measured(branches)}"
    if mutants:
        counts = Counter(row["verdict"] for row in mutants)
        killed = counts["killed"] / (counts["killed"] + counts["survives"])
        text += f"""
Of {len(mutants)} mutants {counts["killed"]} were noticed by a test, {counts["equivalent"]} change nothing,
{counts["cost only"]} only the cost, {counts["survives"]} survive: {100 * killed:.0f} % of those
that change a result are noticed.

{measured(mutants)}"""
    if not text:
        return ""
    commands = "Commands: `./build.sh run coverage`, `./build.sh run mutants`."
    return f"## Coverage and mutants\n\n{commands}\n\n{text}"


STATIC = """\
## Static analysis

clang-tidy (bugprone, cert, clang-analyzer), cppcheck and gcc -fanalyzer find nothing. The findings that are
false stand with their reasons in `.clang-tidy` and `fmu_src/tools/static_analysis.py`.
Command: `./build.sh check`.
"""


def own_tests() -> int:
    """The number of test functions of this project."""
    files = [path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("test_*.py")]
    return sum(len(re.findall(r"^\s*def test_", text, re.M)) for text in files)


def figures() -> dict[str, int | str]:
    """What stands for the braces of peer_testing.toml."""
    found: dict[str, int | str] = {
        f"{row['project']} {row['what']}": int(row["number"]) for row in read("peer_tests")
    }
    whole = [row for row in read("coverage") if row["part"] == "all"]
    found["coverage"] = f"{whole[0]['branches_percent']} %" if whole else "`./build.sh run coverage` counts"
    thousands = own_tests() // 1000 * 1000  # so that a new test does not change the page
    return {**found, "own": thousands}


def peers() -> str:
    plan = tomllib.loads((ROOT / "docs/tools/peer_testing.toml").read_text(encoding="utf-8"))
    projects = [source["project"] for source in plan["source"]]
    numbers = figures()
    lines = [[row["what"], *(row[k].format_map(numbers) for k in ("here", *projects))] for row in plan["row"]]
    links = [f"- {source['project']}: <{link}>" for source in plan["source"] for link in source["links"]]
    dates = ", ".join(sorted({f"{row['project']} {row['date']}" for row in read("peer_tests")}))
    return f"""\
## Beside other projects

What SQLite, SUNDIALS, MuJoCo and Box2D publish about their own tests. "Not published": neither the pages
below nor the repository tell. `docs/tools/count_peer_tests.py` counted the tests in the repositories
({dates}). Test functions of different projects differ in size, so
their numbers do not compare projects. This project has no test of power loss, since the FMUs write no files.

{table(["what", "this project", *projects], lines)}
Sources:

{chr(10).join(links)}
"""


def elementary_functions() -> str:
    """The page of its own about exp, sin and so on."""
    rows, steps = read("elementary"), read("elementary_shares")
    compared = [row for row in rows if row["arguments"]]
    lines = [
        [
            row["function"],
            row["greatest_error_ulp"],
            *(f"{row[key]} / {row[f'{key}_library']}" for key in ("instructions", "ns")),
            row["instructions_library_not_fused"],
        ]
        for row in rows
    ]
    fewest = min(int(float(row["arguments"])) for row in compared)
    greatest = max(float(row["greatest_error_ulp"]) for row in compared)
    share = max(float(row["share_percent"]) for row in steps)
    return f"""\
# Elementary functions of the core

Read this page if you want to know how exact and how fast exp, log, sin and so on of the FMUs are. The C
core has functions of its own, so that all platforms give equal bits
([reliability.md](reliability.md#platforms)). `docs/tools/reliability_page.py` writes this page.

The greatest error is {greatest:.2f} units in the last place (ulp). It was looked for at {fewest:,}
arguments or more of each function, random and hard ones. Double-double arithmetic gives the errors. Sixty
digits confirm them at 10,000 arguments of each function, and wherever an error is above 0.8 ulp.

Instructions and ns are those of a call: own / C library. The own functions fuse no operations. The C library
of this machine may fuse multiplication and addition; the last column has its instructions without that. The
functions "of two" are for the friction of both cams at once, and their costs are those of two values. "small
exp" takes arguments up to 0.1.

Steps call all of these functions but tan, which the start of a run calls. No step calls sin or cos alone.
In {len(steps)} scenes with steps of 1 ms, at most {share:.1f} % of the instructions are in these functions,
those "of two" apart. sin and cos share one vector register.
Command: `./build.sh run elementary`.

{table(["function", "error, ulp", "instructions", "ns", "C library, not fused"], lines)}
{measured(rows)}"""


def page() -> str:
    parts = [HEAD, verdict(), scenes(), hashes(), endurance(), FAULTS, states(), fuzzing(), strength()]
    parts += [STATIC, peers()]
    return "\n".join(part for part in parts if part)


PAGES = {"reliability.md": page, "elementary-functions.md": elementary_functions}


def main() -> None:
    for name, text in PAGES.items():
        (ROOT / "docs" / name).write_text(text(), encoding="utf-8")
        print(f"written: docs/{name}")


if __name__ == "__main__":
    main()
