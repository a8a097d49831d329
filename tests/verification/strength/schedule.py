"""What the fork server knows about tests and mutants, and the order of the tests for one mutant."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Item = Any  # pytest.Item, whose parts for a second run are not typed
OVERHEAD = 0.01  # s of a test beside its own work
SLOWER, PATIENCE = 5.0, 2.0  # a test of a mutant may take so many times the processor time, and s on top
LONGER = 4.0  # times this limit, where an end by time is to happen again
# How much a killed mutant raises the hope that the same test kills another mutant of the same place.
HOPE = {"function": 8.0, "file": 3.0, "room": 1.0}


def function_of(test: str) -> str:
    """The test without its parameters."""
    return test.partition("[")[0]


@dataclass
class Schedule:
    """The work that mutants.py orders, and what the first pass finds, kept in the file `reach`."""

    numbers: list[int]
    names: dict[int, tuple[str, str]]  # file and function of each mutant
    hints: dict[int, str]  # the test that killed the mutant in an earlier run
    reach: Path
    status: Path  # folder: one file for each mutant
    limit: float  # s of tests for one mutant
    processes: int
    core: str  # hash of the C sources
    judged: list[int] = field(default_factory=list)  # mutants of which a reason tells what they change
    judged_limit: float = 0.0  # s of tests for one of them
    seconds: dict[str, float] = field(default_factory=dict)
    reached: dict[str, list[int]] = field(default_factory=dict)  # where the mistake makes a difference
    alone: dict[str, float] = field(default_factory=dict)  # s in a process of its own, with all fixtures
    touched: list[int] = field(default_factory=list)  # places that any test reaches
    failed: list[str] = field(default_factory=list)
    kills: dict[str, Counter[str]] = field(default_factory=dict)  # by function, file or room: tests
    slow: dict[str, float] = field(default_factory=dict)  # s that a test function has taken to fail

    KEPT = ("seconds", "alone", "reached", "touched", "failed")

    def save(self) -> None:
        self.reach.write_text(json.dumps({name: getattr(self, name) for name in self.KEPT}))

    def load(self) -> None:
        if self.reach.exists():
            for name, value in json.loads(self.reach.read_text()).items():
                setattr(self, name, value)

    def places_of(self, number: int) -> dict[str, str]:
        file, function = self.names[number]
        return {"function": f"{file} {function}", "file": file, "room": file.partition("/")[0]}

    def learn_hints(self) -> None:
        """What kills a mutant may kill another one of the same place."""
        for number, test in self.hints.items():
            self.note_kill(number, test, 0.0)

    def by_length(self) -> list[int]:
        """Mutants that no test has killed before come first: their runs are long, and end beside others."""
        return sorted(self.numbers, key=lambda number: number in self.hints)

    def note_kill(self, number: int, test: str, seconds: float) -> None:
        """A test may take long to fail, where it first asks whether the scene has another answer, too."""
        function = function_of(test)
        self.slow[function] = max(seconds, self.slow.get(function, 0.0))
        for place in self.places_of(number).values():
            self.kills.setdefault(place, Counter())[test] += 1

    def tests_of(self, number: int, items: Sequence[Item], passed: Sequence[str]) -> list[Item]:
        """The tests in which the mutant makes a difference, without those of an earlier run, as many as
        the limit allows. First the test that killed this mutant in an earlier run, then by hope per
        second: of tests that killed mutants nearby, and of one test of each file before the second one."""
        turns: Counter[str] = Counter()
        order: list[tuple[float, int, Item]] = []
        near = [(HOPE[kind], self.kills.get(place)) for kind, place in self.places_of(number).items()]
        known = [(weight, kills) for weight, kills in near if kills]
        for item in sorted(items, key=lambda item: self.seconds[item.nodeid]):
            if number not in self.reached.get(item.nodeid, ()) or item.nodeid in passed:
                continue
            turns[item.location[0]] += 1
            hope = 1.0 / turns[item.location[0]] + sum(weight * kills[item.nodeid] for weight, kills in known)
            rate = hope / (
                OVERHEAD + max(self.seconds[item.nodeid], self.slow.get(function_of(item.nodeid), 0.0))
            )
            order.append((0.0 if item.nodeid == self.hints.get(number) else -rate, len(order), item))
        order.sort(key=lambda entry: (entry[0] != 0.0, entry[:2]))
        limit = min(self.limit, self.judged_limit) if number in self.judged else self.limit
        return self.within_limit([item for *_, item in order], limit)

    def limits_of(self, tests: Sequence[Item]) -> list[float]:
        """s of the processor that each test may take, if they run in this order."""
        begun: set[str] = set()
        limits = []
        for item in tests:
            function = function_of(item.nodeid)
            limits.append(SLOWER * self.usual_seconds(item, function not in begun) + PATIENCE)
            begun.add(function)
        return limits

    def longer_limit(self, alone: float) -> float:
        return LONGER * (SLOWER * alone + PATIENCE)

    def usual_seconds(self, item: Item, first_of_function: bool) -> float:
        """Without a mutant. The first test of a function also makes the fixtures of the file that this
        function uses: another one had made them when the times were noted, within the time of the longest
        test of the file."""
        if not first_of_function:
            return self.seconds[item.nodeid]
        begin = item.location[0] + "::"
        return max(seconds for test, seconds in self.seconds.items() if test.startswith(begin))

    def within_limit(self, tests: Sequence[Item], limit: float) -> list[Item]:
        taken: list[Item] = []
        total = 0.0
        for item in tests:
            if not taken or total + self.seconds[item.nodeid] <= limit:
                total += self.seconds[item.nodeid]
                taken.append(item)
        return taken
