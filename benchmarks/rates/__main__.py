"""The command: one measure, its table on the console and its CSV file."""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path

from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import RESULTS
from benchmarks.rates.measure import Measure

COLUMNS = ("what", "way", "us", "ratio")
NAMES = ("loop", "fleet", "gym", "creep", "web", "view")  # modules beside this file


def measure_of(name: str) -> Measure:
    """Imports the module of that measure alone: others need other packages."""
    return importlib.import_module(f"benchmarks.rates.{name}").MEASURE


def main() -> int:
    parser = argparse.ArgumentParser(description="What does a step cost, through each way to have it?")
    parser.add_argument("name", choices=NAMES)
    parser.add_argument("--rounds", type=int, help="rounds of blocks")
    parser.add_argument("--output", type=Path, help="the CSV file")
    arguments = parser.parse_args()
    measure, console = measure_of(arguments.name), harness.new_console()
    table = harness.table(measure.title, *COLUMNS, measure.note)
    rows, judged = [], []
    for group in measure.take(arguments.rounds or measure.rounds, console):
        judged += measure.judged(group)
        for row in measure.rows(group):
            rows.append(row)
            table.add_row(*(row.get(column, "") for column in COLUMNS), row.get(measure.note, ""))
    console.print(table)
    harness.say(console, *(words for words, _ in judged))
    output = arguments.output or RESULTS / f"{measure.name}.csv"
    harness.publish(rows, circumstances("", *measure.packages), output, console)
    return 0 if all(met for _, met in judged) else 1


if __name__ == "__main__":
    sys.exit(main())
