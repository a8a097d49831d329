"""One measure: its ways, their times, the rows of its CSV file, and its limits."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from rich.console import Console

from benchmarks.harness.results import verdict
from benchmarks.harness.timing import Ratio

MICROSECOND = "1 us"
Row = dict[str, str]


@dataclass(frozen=True)
class Group:
    """Ways that were timed in turns. `what`: their size or subject."""

    what: str
    times: Mapping[str, list[float]]  # seconds of one unit of work in every round, by way
    notes: Mapping[str, str] = field(default_factory=dict)  # another number of a way


@dataclass(frozen=True)
class Limit:
    """`way` may take `most` times the time of `other`, a way or MICROSECOND."""

    what: str
    way: str
    other: str
    most: float

    def judged(self, group: Group) -> tuple[str, bool]:
        """A sentence, and whether the limit is met."""
        other = [1e-6] if self.other == MICROSECOND else group.times[self.other]
        ratio = statistics.median(group.times[self.way]) / statistics.median(other)
        words = f"{self.what}, {self.way}: {ratio:.3f} times {self.other}, target {verdict(ratio, self.most)}"
        return words, ratio <= self.most


@dataclass(frozen=True)
class Measure:
    name: str  # of the command and of the CSV file
    title: str
    take: Callable[[int, Console], Iterator[Group]]  # a number of rounds
    rounds: int
    against: str = ""  # the way of a group to whose times the ratios are
    note: str = ""  # what the notes are
    packages: tuple[str, ...] = ()
    limits: tuple[Limit, ...] = ()

    def rows(self, group: Group) -> list[Row]:
        return [self.row(group, way) for way in group.times]

    def row(self, group: Group, way: str) -> Row:
        seconds = group.times[way]
        row = {"what": group.what, "way": way, "us": f"{1e6 * statistics.median(seconds):.5g}"}
        spread = Ratio.of(seconds, group.times[self.against] if self.against else [1e-6] * len(seconds))
        if self.against:
            row["ratio"] = f"{spread.median:.4g}"
        row |= {"lower_quartile": f"{spread.lower:.4g}", "upper_quartile": f"{spread.upper:.4g}"}
        return row | ({self.note: group.notes[way]} if self.note else {})

    def judged(self, group: Group) -> list[tuple[str, bool]]:
        return [limit.judged(group) for limit in self.limits if limit.what == group.what]
