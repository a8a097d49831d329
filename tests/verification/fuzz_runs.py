"""`./build.sh run fuzz` from a given seed, and its row in tests/verification/results/fuzz_runs.csv.

    ./build.sh run fuzz-record --seed N    # an hour

The row counts the examples that hypothesis drew and names the tests that failed. Rows of earlier runs stay.
"""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.harness import results
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import ROOT, VERIFICATION

EXAMPLES = re.compile(r"(\d+) passing, (\d+) failing, and \d+ invalid")
FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)
FINISHED = (0, 1)  # exit codes of pytest: all tests passed, some failed
COUNT = re.compile(r"(\d+) (passed|failed|error)")


def played(pytest: Sequence[str], seed: int) -> Iterator[str]:
    """What pytest prints, piece by piece: its line of dots shows the progress."""
    words = [*pytest, f"--hypothesis-seed={seed}", "--hypothesis-show-statistics"]
    command = [sys.executable, "-m", "pytest", *words]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE) as run:
        assert run.stdout is not None
        while piece := os.read(run.stdout.fileno(), 65536):
            yield piece.decode(errors="replace")
    if run.returncode not in FINISHED:
        raise SystemExit(
            f"pytest ended with {run.returncode} before all tests were played: no row is written"
        )


def row_of(text: str, seed: int, seconds: float) -> dict[str, str]:
    """`text`: all that pytest printed."""
    counts = {word: int(number) for number, word in COUNT.findall(text.rstrip().rsplit("\n", 1)[-1])}
    findings = FAILED.findall(text)
    return {
        "seed": str(seed),
        "minutes": f"{seconds / 60.0:.0f}",
        "tests": str(sum(counts.values())),
        "examples": str(sum(int(number) for pair in EXAMPLES.findall(text) for number in pair)),
        "findings": str(len(findings)),
        "failed": " ".join(name.split("::")[-1] for name in findings),
    }


def earlier(path: Path) -> list[dict[str, str]]:
    """The rows of the file, none where there is no file."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def main() -> int:
    parser = results.options(__doc__, "fuzz_runs", folder=VERIFICATION / "results")
    parser.add_argument("--seed", type=int, required=True, help="of hypothesis")
    arguments, pytest = parser.parse_known_args()
    console, facts, begin, text = results.new_console(), circumstances("fuzz-record"), time.monotonic(), ""
    for piece in played(pytest, arguments.seed):
        text += piece
        print(piece, end="", flush=True)
    row = row_of(text, arguments.seed, time.monotonic() - begin)
    facts["command"] = f"./build.sh run fuzz-record --seed {arguments.seed}"
    results.say_facts(facts, console)
    results.write_csv([*earlier(arguments.output), row | facts], arguments.output)
    results.say(console, f"written: {arguments.output}")
    return int(row["findings"] != "0")


if __name__ == "__main__":
    sys.exit(main())
