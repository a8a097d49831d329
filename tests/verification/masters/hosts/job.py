"""What the programs inside other masters are told, and what they write back.

Arguments: FMU, step size in s, file of the inputs, file for the outputs, names of the outputs with commas in
between, and any number of start values as name=value. Both files are CSV with a header; the inputs have a row
for each communication point, the first column is its time. A row of inputs holds until the next point.
This module needs nothing but Python: it runs beside the master, in the master's own environment.
"""

import csv
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

INTEGERS = ("mode",)  # outputs that are no Real
Row = dict[str, float]
Value = float | int | str


@dataclass
class Job:
    fmu: str
    step: float
    inputs: list[Row]
    outputs: list[str]
    start: dict[str, Value]
    file: Path

    def save(self, rows: Iterable[Iterable[float]]) -> None:
        """The outputs at each communication point."""
        with self.file.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(self.outputs)
            writer.writerows(rows)


def typed(text: str) -> Value:
    """An Integer, a Real, or else a String."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


def from_arguments() -> Job:
    fmu, step, inputs, file, outputs, *start = sys.argv[1:]
    with open(inputs, newline="") as lines:
        rows = [{n: float(v) for n, v in row.items() if n != "time"} for row in csv.DictReader(lines)]
    first = {name: typed(text) for name, text in (word.split("=", 1) for word in start)} | rows[0]
    return Job(fmu, float(step), rows, outputs.split(","), first, Path(file))
