"""What the programs that run an SSP package in a master are told, and what they write back.

Arguments: package, name of its parameter sets, step size in s, number of rows, steps per row, file for the
rows, and the variables to watch as component.variable. The file is CSV with a header. An argument
"component.output->component.parameter" asks the program to pass that value on itself after each row, for a
master that cannot connect parameters.
This module needs nothing but Python: it runs beside the master, in the master's own environment.
"""

import csv
import sys
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass
class Work:
    package: str
    start: str
    step: float
    rows: int
    every: int
    file: str
    watched: list[str]
    passed: list[tuple[str, str]]  # from, to

    def save(self, rows: Iterable[Iterable[float]]) -> None:
        with open(self.file, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(self.watched)
            writer.writerows(rows)


def from_arguments() -> Work:
    package, start, step, rows, every, file, *names = sys.argv[1:]
    pairs = [name.partition("->") for name in names]
    watched = [source for source, arrow, _ in pairs if not arrow]
    passed = [(source, target) for source, arrow, target in pairs if arrow]
    return Work(package, start, float(step), int(rows), int(every), file, watched, passed)
