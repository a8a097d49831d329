"""Results of a benchmark: options of its command, tables on the console, a CSV file."""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from benchmarks.harness.repository import RESULTS

Rows = Sequence[Mapping[str, str]]


def options(
    doc: str | None,
    name: str,
    rounds: int | None = None,
    picture: Path | None = None,
    folder: Path = RESULTS,
) -> argparse.ArgumentParser:
    """--output, --rounds if there is a default for it, --picture if there is a place for one.

    `doc`: of the benchmark's module, whose first line describes it. `name`: of its CSV file in `folder`."""
    parser = argparse.ArgumentParser(description=(doc or "").split("\n")[0])
    if rounds is not None:
        parser.add_argument("--rounds", type=int, default=rounds, help=f"rounds of blocks ({rounds})")
    parser.add_argument("--output", type=Path, default=folder / f"{name}.csv", help="the CSV file")
    if picture is not None:
        parser.add_argument("--picture", type=Path, default=picture)
    return parser


def new_console() -> Console:
    return Console() if sys.stdout.isatty() else Console(width=120)


def say(console: Console, *lines: str) -> None:
    """Plain text as it is."""
    for line in lines:
        console.print(line, highlight=False, markup=False)


def table(title: str, *columns: str) -> Table:
    """An empty table: the first column to the left, all others to the right."""
    made = Table(title=title, box=SIMPLE, title_justify="left", pad_edge=False)
    for number, column in enumerate(columns):
        made.add_column(column, no_wrap=True, justify="left" if number == 0 else "right")
    return made


def verdict(value: float, target: float | None) -> str:
    """Whether `value` is at most `target`. Empty without a target."""
    return "" if target is None else f"{target:g} {'met' if value <= target else 'MISSED'}"


def say_facts(facts: Mapping[str, str], console: Console) -> None:
    say(console, *(f"{name}: {value}" for name, value in facts.items()))


def write_csv(rows: Rows, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def publish(
    rows: Rows,
    facts: Mapping[str, str],
    output: Path,
    console: Console,
    picture: Path | None = None,
) -> None:
    """Prints the circumstances of a benchmark and writes its rows, each with the circumstances, as CSV.

    `picture`: the picture that has been drawn of them."""
    say_facts(facts, console)
    write_csv([{**row, **facts} for row in rows], output)
    say(console, f"written: {output} and {picture}" if picture else f"written: {output}")
