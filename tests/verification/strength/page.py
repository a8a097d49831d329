"""Writes docs/test-strength.md from the results of mutants and coverage.

python -m verification.strength.page
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Mapping, Sequence

from benchmarks.harness.repository import DOCS, VERIFICATION
from verification.strength import coverage, mutants

PAGE = DOCS / "test-strength.md"
RESULTS = VERIFICATION / "results"
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
HEAD = """\
# How well the tests test

Read this page to judge how far a green run of the tests can be trusted. Two commands measure that on a copy
of the C code. `./build.sh run mutants` makes small mistakes and looks which of them a test notices.
`./build.sh run coverage` looks which branches the tests take. Both need the compiler of the `ziglang` wheel
and tree-sitter, which parses C, from PyPI. Both run on Linux. `tests/verification/strength/page.py` writes
this page. [Reliability](reliability.md) tells what else is tested.
"""
MUTANTS = """
## Mutants

A mutant is the C code with one small mistake. {count} places in the code of physics and of FMI are drawn with
a fixed seed (`tests/verification/strength/choice.py`), equally many of each kind as far as the compiler takes
the mistake. All mutants are compiled into one library per FMU, and a switch puts one of them in force. A
mutant is killed if a test fails, crashes, or takes five times the processor time that it takes without the
mutant, and 2 s more. A function that leaves the bounds of an array crashes. An end counts only if the same
test passes alone without the mutant. An end by time must happen again, with no other test beside it and four
times this limit. Of the tests only those are run in which the mistaken place is reached with another outcome
than that of the true code: a test that never compares two equal numbers cannot tell `<` from `<=`. The tests
are those of `tests/verification/strength/tests.txt`, {tests} files and folders of the suite. They compare
with closed forms, with solutions by other programs, with the account of energy and with the law of friction,
not with earlier results of the FMU.

| verdict | meaning |
| --- | --- |
| killed | a test notices the mistake |
| equivalent | no test can notice: the mistake changes no result beyond rounding |
| cost only | the mistake changes iterations or segments, and results only within their tolerance |
| survives | the mistake can change a result, and no test notices |

Equivalent mutants and those of cost were judged by hand (`tests/verification/strength/equivalent.toml`). A
verdict names the text of its line, and the run lists verdicts whose code has changed. A mutant with such a
verdict meets {judged:g} s of the tests in which the mistake makes a difference, the most promising ones
first; any other mutant meets all of them.
"""


def read(name: str) -> list[dict[str, str]]:
    with (RESULTS / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def cell(text: str) -> str:
    """C code in a cell."""
    return "`" + (text or "nothing").replace("|", "\\|") + "`"


def measured(row: Mapping[str, str]) -> str:
    core = f"C sources with the hash {row['core']}, " if row.get("core") else ""
    since = f"`git log {row['commit']}.. -- fmu_src` lists what has changed in the C code since then"
    return f"Measured on {row['date']}, {core}{row['machine']}, {row['versions']}. {since}.\n"


def mutants_part(rows: Sequence[dict[str, str]]) -> str:
    counts = {
        kind: Counter(row["verdict"] for row in rows if kind in ("all", row["kind"]))
        for kind in [*KINDS, "all"]
    }
    lines = [
        [kind, KINDS.get(kind, ""), *(count[verdict] for verdict in mutants.VERDICTS)]
        for kind, count in counts.items()
    ]
    text = MUTANTS.format(
        count=len(rows),
        tests=len(mutants.TESTS.read_text().split()),
        judged=mutants.JUDGED_LIMIT,
    )
    text += "\n" + table(["kind", "mistake", *mutants.VERDICTS], lines)
    text += SHARES.format(
        share=mutants.share_killed(rows), target=mutants.TARGET, **shares_of(counts["all"]), all=len(rows)
    )
    text += measured(rows[0])
    return text + SURVIVE + mutants_table([row for row in rows if row["verdict"] == "survives"])


def shares_of(counts: Mapping[str, int]) -> dict[str, float]:
    """%, of killed mutants: of all, and of those that change a result or the cost."""
    killed, cost = counts["killed"], counts["cost only"]
    return {
        "of_all": 100.0 * killed / sum(counts.values()),
        "with_cost": 100.0 * killed / (killed + cost + counts["survives"]),
    }


def mutants_table(rows: Sequence[dict[str, str]]) -> str:
    places = [
        [f"{row['file']}, `{row['function']}()`", cell(row["original"]), cell(row["mutated"]), row["reason"]]
        for row in rows
    ]
    return table(["place", "code", "mutant", "reason"], places) if places else "None.\n"


SHARES = """
**{share:.1f} %** of the mutants that are neither equivalent nor of cost only are killed; the target is
{target:g} %. With the mutants of cost only the share is {with_cost:.1f} %, of all {all} mutants
{of_all:.1f} %.
`tests/verification/results/mutants.csv` has each mutant, with the test that kills it, or with the reason of
a verdict by hand. """
SURVIVE = """
### Mutants that survive

"""
BRANCHES = """
## Branches

A branch is a condition of the C code with one of its two values. The marks are set in the source text, so
that optimisation does not change the counts. Macros and generated tables have no marks. MC/DC asks more: for
each condition of a decision, two evaluations show that this condition alone changes the decision. Conditions
that `&&` and `||` leave out may differ ("masking" MC/DC). A condition with one possible value has no branches
of its own: a call that logs a refusal is always false, and a macro is constant. The tests are those of
`tests/verification/strength/branch_tests.txt`, {tests} test files and folders. They drive the FMUs, functions
of the C code, and the native programs that let allocations fail and replay the inputs of the fuzzer.

"""


def coverage_part(rows: Sequence[dict[str, str]]) -> str:
    lines = [
        [
            f"**{row['part']}**" if row["part"] == "all" else f"`{row['part']}`",
            *(row[name] for name in ("branches", "taken", "branches_percent", "mcdc_percent", "unexplained")),
        ]
        for row in rows
    ]
    head = ["room or file", "branches", "taken", "%", "MC/DC, %", "not taken, without a reason"]
    text = BRANCHES.format(tests=len(coverage.TESTS.read_text().split())) + table(head, lines)
    text += f"\nThe target is {coverage.TARGET:g} % of the branches, in each room. " + measured(rows[0])
    text += "`tests/verification/strength/unreached.toml` gives the reason for branches that no test takes.\n"
    return text


def main() -> None:
    parts = {"mutants": mutants_part, "coverage": coverage_part}
    text = HEAD
    for name, part in parts.items():
        if (RESULTS / f"{name}.csv").exists():
            text += part(read(name))
        else:
            print(f"{RESULTS / name}.csv is missing, the page leaves this part out: ./build.sh {name}")
    PAGE.write_text(text)


if __name__ == "__main__":
    main()
