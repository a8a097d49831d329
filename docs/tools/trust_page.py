"""Writes docs/trust-tables.md and the numbers of docs/trust.md from the results of the commands they name.

python docs/tools/trust_page.py
"""

from __future__ import annotations

import base64
import csv
import tomllib
import zipfile
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.harness.circumstances import FACTS
from benchmarks.harness.old_figures import with_line

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "tests/verification/results"
CORPUS = ROOT / "tests/fuzz_corpus"

PAGE = ROOT / "docs/trust.md"
VERDICTS = ("killed", "equivalent", "cost only", "survives")
KINDS = {
    "arguments": "two arguments of one type swapped",
    "arithmetic": "`+` for `-`, `*` for `/`, and back",
    "comparison": "`<` for `<=`, `<` for `>`, `==` for `!=`, and back",
    "condition": "a condition negated",
    "constant": "an integer 1 larger or smaller, a number times 1.5",
    "logic": "`&&` for `||`, and back",
    "sign": "a minus left out, `+=` for `-=`, and back",
    "statement": "a statement left out",
}

Rows = list[dict[str, str]]

HEAD = """\
# The long tables behind the page of trust

[trust.md](trust.md) has the answers. Here stands what was tried, what came out, and which command tries it
again. `docs/tools/trust_page.py` writes this page from `tests/verification/results`.
"""


def read(name: str) -> Rows:
    with (RESULTS / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def measured(name: str) -> str:
    """When, where and of which core. benchmarks/harness/old_figures.py looks for the name of the file."""
    last = read(name)[-1]
    return (
        f"`tests/verification/results/{name}.csv`, measured on {last['date']}: {last['machine']}; "
        f"{last['versions']}; commit {last['commit']}.\n"
    )


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


def total(column: str, rows: Rows) -> int:
    return sum(int(row[column]) for row in rows)


def long_fuzzing() -> str:
    """What the last long runs found, a sentence."""
    runs = read("fuzz_runs")
    if runs[-1]["findings"] != "0":
        return "Long fuzzing with other scenes still finds wrong ones."
    clean = sum(run["findings"] == "0" for run in runs)
    return (
        f"Of {len(runs)} long runs of fuzzing with other scenes, {clean} found nothing, "
        "among them the last one."
    )


def long_runs() -> str:
    """The table of long runs."""
    runs = read("fuzz_runs")
    keys = ("seed", "commit", "minutes", "examples", "findings")
    rows = [[f"{int(run[key]):,}" if key == "examples" else run[key] for key in keys] for run in runs]
    return f"""\
Recorded runs of `./build.sh run fuzz`, by `./build.sh run fuzz-record --seed N`. A finding is a test that
failed.

{table(keys, rows)}
{measured("fuzz_runs")}"""


def answers() -> str:
    laws = {
        "everything at random": "Coulomb friction",
        "everything and friction laws": "friction by speed",
        "load laws at": "friction by load",
    }
    found = [(words, row) for key, words in laws.items() for row in read("stress") if key in row["varied"]]
    rows = [row for _, row in found]
    counts = ", ".join(f"{row['wrong']} of {int(row['runs']):,} ({words})" for words, row in found)
    amount = "a few are" if total("wrong", rows) else "none is"
    builds = read("trajectory_hash")
    equal = sum(row["scenes_that_differ"] == "0" for row in builds)
    return f"""\
- **Do the numbers follow from the equations?** Yes, to the bounds [below](#how-exact) in ordinary scenes. Of
  the {total("runs", rows):,} [extreme random scenes](#extreme-parameters) {amount} wrong:
  {counts}.
  {total("refused", rows):,} of them are refused with a message, and
  [limits.md](limits.md#when-a-step-is-refused) has the remedies. {long_fuzzing()}
  [Fuzzing](trust-tables.md#fuzzing) has the runs.
- **Do the equations describe a real cam?** Not shown. No hardware was measured for this project. The paper
  behind it compares its model with a bench: [paper.md](paper.md). Clearance of the grooves, an elastic pin
  and heat are not in the FMUs: [limits.md](limits.md#of-the-model).
- **What is known to be wrong?** [A list](trust-tables.md#wrong) has the runs that came out wrong,
  [limits.md](limits.md) what the model leaves out.
- **Can an FMU end or block my process?** No way is known in a host that masks floating-point traps, as hosts
  do: [hosts.md](hosts.md). Each step ends after a bounded number of operations, about two seconds at most.
  A fault of the host gives a message.
- **Are the numbers the same elsewhere?** {equal} of {len(builds)} builds for Linux, Windows and WebAssembly
  give equal bits. The binaries for macOS were never run.
- **Do the tests notice a mistake in the code?** {share_of_mutants()} % of the small mistakes that
  change a result: [mutants](trust-tables.md#mutants).
"""


def scenes() -> str:
    """The stress table, in a sentence."""
    rows = read("stress")
    return f"""\
{total("runs", rows):,} runs over many decades of every parameter, {total("judged", rows):,} of them
compared with an independent solution or with a second run whose steps are cut differently:
{total("wrong", rows)} came out wrong, and {total("refused", rows):,} were refused.
Command: `./build.sh run stress`.
"""


STRESS = """\
## Extreme parameters

The table has elliptical and tabulated grooves, nonlinear springs and dampers, and masses. Each row has the
range of the varied quantity, and counts what came out of the runs. The scenes are far harder than those of
[the bounds](trust.md#how-exact): parameters go over many decades. Command: `./build.sh run stress`.

- *Judged*: compared with an independent solution. In the rows "at random" a run is compared with a second
  run of the FMU, whose intervals are cut differently. Other runs are held to the laws alone, such as the
  balance of energy. `tests/verification/stress/__init__.py` describes judges and laws.
- *Right*: not refused, all laws hold, and a judged run differs by at most 100 tolerances. A scene that
  depends strongly on its data has a wider limit: the run is repeated with parameters and inputs changed by
  one tolerance. If its results change by d, then 10 d is allowed.
- *Wrong*: neither right nor refused. [The list](#wrong) is below.
- *Refused*: the step or the start ends with a message. [The messages](#refused) are below.
- *Worst error*: the largest error of angle, speed and accounts among the right runs, relative to the largest
  angle, speed and energy of the scene. The tolerance is 1e-9 unless the row says otherwise. In the rows
  "against the limit" it is the distance from the limit. Elsewhere an error above 1e-7 belongs to a scene that
  depends strongly on the data.
- *Energy residual*: relative to the largest account, among the right runs.
- *Longest step*: processor time of the longest doStep.
- *ms per second*: the most processor time for a simulated second. Short steps count
  most: 0.01 ms for a step of 1e-9 s are 1e7 ms per second.
"""
WORDS_OF_WRONG = """\
Wrong runs are no part of the columns "worst error" and "energy residual". The words of the list:

- *interval*: a part of a scene with one polynomial for each input. The intervals of a scene are numbered
  from 0.
- *cutting changes E*: the FMU runs the scene twice, in steps that cut the intervals differently. The
  results differ by E, relative to the largest size in the scene. The quantity that differs most follows,
  with the values of both runs.
- *data amplify A*: the FMU runs the scene again with parameters and inputs changed by the tolerance and by
  ten times the tolerance. The results change by at most A times the tolerance.
- *in pieces*: the finding belongs to the run with more cuts.
- *energy.residual X of Y*: the accounts miss X of the balance of energy, and Y is the largest account.
- *a doStep of T*: one step computes for longer than 2 s.
"""


def parts_of(cell: str) -> list[str]:
    """The messages or wrong runs of one cell of stress.csv."""
    return cell.split(" | ") if cell else []


def stress() -> str:
    rows = read("stress")
    head = [column for column in rows[0] if column not in (*FACTS, "messages", "wrong runs")]
    messages = [[row["varied"], *part.split(" ", 1)] for row in rows for part in parts_of(row["messages"])]
    wrong = [f"- {row['varied']}: {part}" for row in rows for part in parts_of(row["wrong runs"])]
    none = f"None of the {total('runs', rows):,} runs came out wrong."
    return f"""\
{STRESS}
{table(head, [[row[column] for column in head] for row in rows])}
{measured("stress")}
### Refused

Numbers of runs that are refused, by the message.

{table(["varied", "refused", "message"], messages)}
### Wrong

{WORDS_OF_WRONG + chr(10) + chr(10).join(wrong) if wrong else none}
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


def endurance() -> str:
    rows = read("endurance")
    last = {(row["scene"], row["what"]): row for row in rows}
    lines = [[r["scene"], f"{int(r['count']):,}", r["what"], r["value"]] for r in last.values()]
    return f"""\
## Endurance

Lives are instances that are made, started, reset and freed. Errors of time, phase and energy are against the
closed form. They are rounding, and grow with the number of steps: the phase by the rounding of the angular
frequency, 8e-17 of its value. The angle of stick-slip is compared with
that after the first period. Energies are relative: to that of the oscillation, and to the work done.
Command: `./build.sh run endurance`.

{table(["scene", "steps or lives", "what", "value"], lines)}
{measured("endurance")}"""


def hashes() -> str:
    rows = read("trajectory_hash")
    lines = [[r["platform"], r["compiler"], f"`{r['hash']}`", r["scenes_that_differ"]] for r in rows]
    return f"""\
## Platforms

One hash of every bit of all outputs, of both FMUs, over {rows[0]["scenes"]} scenes. The core has its own exp,
sin and so on ([below](#elementary-functions)), and no compiler may fuse operations.
Command: `./build.sh run hash`.

{table(["platform", "compiler", "hash", "scenes that differ"], lines)}
{measured("trajectory_hash")}"""


def share_of_mutants() -> str:
    counts = Counter(row["verdict"] for row in read("mutants"))
    return f"{100 * counts['killed'] / (counts['killed'] + counts['survives']):.1f}"


def code(text: str) -> str:
    """C code in a cell."""
    return "`" + (text or "nothing").replace("|", "\\|") + "`"


def mutants() -> str:
    rows = read("mutants")
    counts = {
        kind: Counter(row["verdict"] for row in rows if kind in ("all", row["kind"]))
        for kind in (*KINDS, "all")
    }
    lines = [[kind, KINDS.get(kind, ""), *(n[verdict] for verdict in VERDICTS)] for kind, n in counts.items()]
    survivors = [
        [f"{row['file']}, `{row['function']}()`", code(row["original"]), code(row["mutated"]), row["reason"]]
        for row in rows
        if row["verdict"] == "survives"
    ]
    return f"""\
## Mutants

A mutant is the C code with one small mistake, and a test that fails kills it:
[the method](development.md#how-well-the-tests-test). *Equivalent*: the mistake changes no result beyond
rounding. *Cost only*: it changes iterations or segments, and results only within their tolerance. *Survives*:
it can change a result, and no test notices. The CSV file has each mutant, with the test that kills it or the
reason of a verdict by hand. Command: `./build.sh run mutants`.

{table(["kind", "mistake", *VERDICTS], lines)}
**{share_of_mutants()} %** of the mutants that are neither equivalent nor of cost only are killed; the target
is 95 %.

{measured("mutants")}
### Mutants that survive

{table(["place", "code", "mutant", "reason"], survivors) if survivors else "None." + chr(10)}"""


def branches() -> str:
    rows = read("coverage")
    columns = ("part", "branches", "taken", "branches_percent", "mcdc_percent", "unexplained")
    head = ("room or file", "branches", "taken", "%", "MC/DC, %", "not taken, without a reason")
    return f"""\
## Branches

A branch is a condition of the C code with one of its two values. The target is 97 % in each room.
`tests/verification/strength/unreached.toml` gives the reason for branches that no test takes.
Command: `./build.sh run coverage`.

{table(head, [[row[column] for column in columns] for row in rows])}
{measured("coverage")}"""


def elementary_functions() -> str:
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
## Elementary functions

The C core has functions of its own for exp, log, sin and so on, so that all platforms give equal bits
([platforms](#platforms)).

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
{measured("elementary")}"""


def tables() -> str:
    """docs/trust-tables.md."""
    parts = (HEAD, stress(), hashes(), endurance(), states(), fuzzing(), mutants(), branches())
    return "\n".join((*parts, elementary_functions()))


def answered() -> str:
    """docs/trust.md with fresh numbers."""
    text = PAGE.read_text(encoding="utf-8")
    for name, part in (("answers", answers()), ("scenes", scenes())):
        begin, end = f"<!-- {name}: generated -->\n", f"<!-- end of {name} -->\n"
        before, rest = text.split(begin)
        text = before + begin + "\n" + part + "\n" + end + rest.split(end)[1]
    return text


PAGES = {"trust.md": answered, "trust-tables.md": tables}


def main() -> None:
    for name, text in PAGES.items():
        (ROOT / "docs" / name).write_text(with_line(text()), encoding="utf-8")
        print(f"written: docs/{name}")


if __name__ == "__main__":
    main()
