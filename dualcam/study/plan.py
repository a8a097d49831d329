"""Which values the runs of a study have."""

from __future__ import annotations

import csv
import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.fmu import Array
from dualcam.study.entries import is_whole
from dualcam.study.problem import StudyError

RUNS_MAX = 10**9  # the names of the files of results are in order up to there
KINDS = ("grid", "latin", "sobol", "indices", "table")


@dataclass(frozen=True)
class Vary:
    """The values of one variable: from `low` to `high` (in a grid `count` of them, evenly, or evenly in the
    logarithm), or one of `values`."""

    low: float = math.nan
    high: float = math.nan
    count: int = 0
    log: bool = False
    values: Sequence[float] = ()

    def problem(self, in_grid: bool) -> str | None:
        """What is wrong with it, if anything is."""
        if len(self.values) > 0:
            strange = [value for value in self.values if not math.isfinite(value)]
            return f"values with {strange[0]}: allowed are finite numbers" if strange else None
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            return (
                f"from {self.low:g} to {self.high:g}: allowed are finite numbers, the first below the "
                "second, or values"
            )
        if self.log and self.low <= 0.0:
            return f"from {self.low:g} on a logarithmic scale: allowed is above 0"
        if in_grid and not (is_whole(self.count) and self.count >= 2):
            return f"count = {self.count!r}: a grid needs a whole number, 2 or more, or values"
        return None

    def limits(self) -> tuple[float, float]:
        values = self.values if len(self.values) > 0 else (self.low, self.high)
        return float(min(values)), float(max(values))

    def at(self, share: Array) -> Array:
        """Values at these shares, in [0, 1], of the way through the range."""
        if len(self.values) > 0:
            chosen = np.minimum((share * len(self.values)).astype(int), len(self.values) - 1)
            return np.asarray(self.values, float)[chosen]
        if self.log:
            grown = self.low * (self.high / self.low) ** share
        else:
            grown = self.low + (self.high - self.low) * share
        return np.clip(grown, self.low, self.high)  # rounding must not leave the range

    def size(self) -> int:
        """How many values it has in a grid."""
        return len(self.values) or self.count

    def points(self) -> Array:
        """Its values in a grid."""
        if len(self.values) > 0:
            return np.asarray(self.values, float)
        return self.at(np.linspace(0.0, 1.0, self.count))


@dataclass(frozen=True)
class Plan:
    """Runs by number, row by row, made when they are asked for.

    grid     every combination of the values, the last variable fastest
    latin    `runs` runs of a Latin hypercube
    sobol    `runs` runs of a scrambled Sobol sequence
    indices  what Sobol's indices need: `runs` (a power of 2) times (variables + 2) runs, as Saltelli puts
             them: all of A, all of B, then for each variable all of A with B's column of that variable
    table    the rows of `table`, shape (runs, variables), in the order of `vary`'s names
    `same_as` gives variables the value of another one in every run."""

    kind: str
    vary: Mapping[str, Vary] = field(default_factory=dict)
    runs: int = 0
    seed: int = 0
    table: ArrayLike | None = None
    same_as: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise StudyError(f"plan of kind {self.kind!r}: allowed are {', '.join(KINDS)}")
        if not self.vary:
            raise StudyError("the plan varies nothing: name at least one variable in vary")
        for name, number in (("runs", self.runs), ("seed", self.seed)):
            if not is_whole(number):
                raise StudyError(f"plan: {name} = {number!r}: allowed is a whole number")
        if self.seed < 0:
            raise StudyError(f"plan: seed = {self.seed}: allowed is 0 or more")
        if self.kind == "table":
            self._check_table()
        else:
            for name, vary in self.vary.items():
                if problem := vary.problem(self.kind == "grid"):
                    raise StudyError(f"plan: {name}: {problem}")
        for name, other in self.same_as.items():
            if name in self.vary or other not in self.vary:
                raise StudyError(
                    f"plan: {name} the same as {other}: allowed is one that varies, for one that does not"
                )
        if self.kind == "indices" and (self.runs < 2 or self.runs & (self.runs - 1)):
            raise StudyError(f"plan: runs = {self.runs}: Sobol's indices need a power of 2, at least 2")
        if not 1 <= self.count <= RUNS_MAX:
            raise StudyError(
                f"the plan, of kind {self.kind}, has {self.count} runs: allowed are 1 to {RUNS_MAX:,}"
            )

    def _check_table(self) -> None:
        rows = self._rows
        if rows.ndim != 2 or rows.shape[1] != len(self.vary):
            raise StudyError(f"plan: table of shape {rows.shape}: allowed is (runs, {len(self.vary)})")
        for row, column in np.argwhere(~np.isfinite(rows)):
            raise StudyError(
                f"plan: run {row} of the table (from 0) has {list(self.vary)[column]} = {rows[row, column]}: "
                "allowed are finite numbers"
            )

    @classmethod
    def from_csv(cls, path: str | Path) -> Plan:
        """A table whose first line names the variables."""
        try:
            with Path(path).open(newline="", encoding="utf-8-sig") as file:
                reader = csv.reader(file)
                names = [name.strip() for name in next(reader, [])]
                if not names:
                    raise ValueError("it is empty")
                table = np.array([_numbers(row, names, reader.line_num) for row in reader if any(row)])
        except (OSError, ValueError) as error:
            raise StudyError(f"plan: {path} is no table of numbers under a line of names: {error}") from error
        if twice := {name for name in names if names.count(name) > 1}:
            raise StudyError(f"plan: {path} has two columns {', '.join(twice)}: allowed is one")
        return cls("table", {name: Vary() for name in names}, table=table.reshape(-1, len(names)))

    @property
    def names(self) -> list[str]:
        return [*self.vary, *self.same_as]

    @cached_property
    def count(self) -> int:
        if self.kind == "grid":
            return math.prod(vary.size() for vary in self.vary.values())
        if self.kind == "table":
            return len(self._rows)
        return self.runs * (len(self.vary) + 2 if self.kind == "indices" else 1)

    def limits(self) -> dict[str, tuple[float, float]]:
        """Least and greatest value of each variable."""
        if self.kind == "table":
            ends = [(float(column.min()), float(column.max())) for column in self._rows.T if len(column)]
            found = dict(zip(self.vary, ends, strict=False))
        else:
            found = {name: vary.limits() for name, vary in self.vary.items()}
        return found | {name: found[other] for name, other in self.same_as.items()}

    def is_whole(self, name: str) -> bool:
        """Whether that variable gets whole numbers only."""
        source = self.same_as.get(name, name)
        if self.kind == "table":
            values = self._rows[:, list(self.vary).index(source)]
        else:
            values = np.asarray(self.vary[source].values, float)
        return len(values) > 0 and bool(np.all(values == np.round(values)))

    def rows(self, start: int, stop: int) -> Array:
        """Runs start to stop - 1, shape (stop - start, names)."""
        numbers = np.arange(start, min(stop, self.count))
        if self.kind == "grid":
            points = [vary.points() for vary in self.vary.values()]
            places = np.unravel_index(numbers, [len(each) for each in points])
            columns = [each[place] for each, place in zip(points, places, strict=True)]
        elif self.kind == "table":
            columns = list(self._rows[numbers].T)
        else:
            shares = self._mixed(numbers) if self.kind == "indices" else self._shares[numbers]
            columns = [vary.at(share) for vary, share in zip(self.vary.values(), shares.T, strict=True)]
        by_name = dict(zip(self.vary, columns, strict=True))
        return np.column_stack([*columns, *(by_name[other] for other in self.same_as.values())])

    @cached_property
    def _rows(self) -> Array:
        return np.asarray(self.table, float)

    @cached_property
    def _shares(self) -> Array:
        from scipy.stats import qmc

        width = len(self.vary) * (2 if self.kind == "indices" else 1)
        try:
            if self.kind == "latin":
                return qmc.LatinHypercube(width, rng=self.seed).random(self.runs)
            whole = qmc.Sobol(width, rng=self.seed).random_base2((self.runs - 1).bit_length())
        except MemoryError:
            raise StudyError(
                f"plan: runs = {self.runs}: their table does not fit into memory: take fewer, or a grid"
            ) from None
        return whole[: self.runs]

    def _mixed(self, numbers: NDArray[np.int_]) -> Array:
        width = len(self.vary)
        block, row = np.divmod(numbers, self.runs)
        first, second = self._shares[row, :width], self._shares[row, width:]
        from_second = (block[:, None] == 1) | (block[:, None] - 2 == np.arange(width))
        return np.where(from_second, second, first)

    def facts(self) -> dict[str, Any]:
        """What the plan is, to be compared with that of a study begun earlier."""
        table = hashlib.sha256(self._rows.tobytes()).hexdigest() if self.kind == "table" else ""
        vary = {
            name: [v.low, v.high, v.count, v.log, [float(x) for x in v.values]]
            for name, v in self.vary.items()
        }
        if self.kind == "table":
            vary = {name: [] for name in self.vary}
        return {
            "kind": self.kind,
            "vary": vary,
            "runs": self.runs,
            "seed": self.seed,
            "table": table,
            "same_as": dict(self.same_as),
        }


def _numbers(row: Sequence[str], names: Sequence[str], line: int) -> list[float]:
    if len(row) != len(names):
        raise ValueError(f"line {line} has {len(row)} cells, the first line {len(names)}")
    try:
        return [float(cell) for cell in row]
    except ValueError as error:
        raise ValueError(f"line {line}: {error}") from error
