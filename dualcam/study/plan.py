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
    """The values of one variable: a range, or a list.

    Parameters
    ----------
    low, high : float
        Ends of the range, in the FMU's unit.
    count : int
        Of a grid: values from `low` to `high`, both included, 2 or more.
    log : bool
        Whether the values are spread evenly in the logarithm.
    values : sequence of float
        These values, instead of a range.

    Examples
    --------
    >>> from dualcam.study import Vary
    >>> Vary(0.5, 1.0, count=3).points().tolist()
    [0.5, 0.75, 1.0]
    >>> Vary(values=[0.08, 0.14]).size()
    2
    """

    low: float = math.nan
    high: float = math.nan
    count: int = 0
    log: bool = False
    values: Sequence[float] = ()

    def problem(self, in_grid: bool) -> str | None:
        """What is wrong with the values, if anything is.

        Parameters
        ----------
        in_grid : bool
            Whether the plan is a grid, which needs a count.

        Returns
        -------
        str or None
            What is given and what is allowed.
        """
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
        """Least and greatest value.

        Returns
        -------
        tuple of float
            In the FMU's unit.
        """
        values = self.values if len(self.values) > 0 else (self.low, self.high)
        return float(min(values)), float(max(values))

    def at(self, share: Array) -> Array:
        """Values at shares of the way through the range.

        Parameters
        ----------
        share : ndarray, shape (n,)
            Shares in [0, 1].

        Returns
        -------
        ndarray, shape (n,)
            Values, in the FMU's unit.
        """
        if len(self.values) > 0:
            chosen = np.minimum((share * len(self.values)).astype(int), len(self.values) - 1)
            return np.asarray(self.values, float)[chosen]
        if self.log:
            grown = self.low * (self.high / self.low) ** share
        else:
            grown = self.low + (self.high - self.low) * share
        return np.clip(grown, self.low, self.high)  # rounding must not leave the range

    def size(self) -> int:
        """How many values there are in a grid.

        Returns
        -------
        int
            Number of values.
        """
        return len(self.values) or self.count

    def points(self) -> Array:
        """The values in a grid.

        Returns
        -------
        ndarray, shape (size,)
            Values, in the FMU's unit.
        """
        if len(self.values) > 0:
            return np.asarray(self.values, float)
        return self.at(np.linspace(0.0, 1.0, self.count))


@dataclass(frozen=True)
class Plan:
    """Which values each run has: rows by the number of the run, made when they are asked for.

    Parameters
    ----------
    kind : {"grid", "latin", "sobol", "indices", "table"}
        "grid": every combination of the values, the last variable fastest. "latin": `runs` runs of a Latin
        hypercube. "sobol": `runs` runs of a scrambled Sobol sequence. "indices": the runs for Sobol's
        indices, see Notes. "table": the rows of `table`.
    vary : mapping of str to Vary
        Values by the name of the variable.
    runs : int
        Number of runs of "latin" and "sobol"; a power of 2 for "indices".
    seed : int
        Start of the random numbers, 0 or more.
    table : array_like, shape (runs, variables), optional
        Of "table": values, columns in the order of `vary`.
    same_as : mapping of str to str
        Variables that get the value of another one in every run.

    Raises
    ------
    StudyError
        An unknown kind, a number or a range outside of what is allowed, a table of another shape, or no runs.

    Notes
    -----
    "indices" makes `runs` times (variables + 2) runs, as Saltelli puts them: all of A, all of B, then for
    each variable all of A with B's column of that variable.

    Examples
    --------
    >>> from dualcam.study import Plan, Vary
    >>> preload = Vary(50.0, 70.0, count=3)  # N
    >>> plan = Plan("grid", {"cam1.friction": Vary(values=[0.1, 0.2]), "spring.preload": preload})
    >>> plan.count
    6
    >>> plan.rows(0, 2).tolist()
    [[0.1, 50.0], [0.1, 60.0]]
    """

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
        """A plan of kind "table" from a CSV file.

        Parameters
        ----------
        path : str or Path
            File whose first line names the variables. Each other line has the numbers of a run, in the FMU's
            units.

        Returns
        -------
        Plan
            One run for each line.

        Raises
        ------
        StudyError
            The file is no table of numbers, or names a variable twice.
        """
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
        """The variables that get values, those of `same_as` last."""
        return [*self.vary, *self.same_as]

    @cached_property
    def count(self) -> int:
        """The number of runs."""
        if self.kind == "grid":
            return math.prod(vary.size() for vary in self.vary.values())
        if self.kind == "table":
            return len(self._rows)
        return self.runs * (len(self.vary) + 2 if self.kind == "indices" else 1)

    def limits(self) -> dict[str, tuple[float, float]]:
        """Least and greatest value of each variable.

        Returns
        -------
        dict of str to tuple of float
            Least and greatest value by the name of the variable, in the FMU's units.
        """
        if self.kind == "table":
            ends = [(float(column.min()), float(column.max())) for column in self._rows.T if len(column)]
            found = dict(zip(self.vary, ends, strict=False))
        else:
            found = {name: vary.limits() for name, vary in self.vary.items()}
        return found | {name: found[other] for name, other in self.same_as.items()}

    def is_whole(self, name: str) -> bool:
        """Whether a variable gets whole numbers only.

        Parameters
        ----------
        name : str
            One of `names`.

        Returns
        -------
        bool
            True for whole numbers.
        """
        source = self.same_as.get(name, name)
        if self.kind == "table":
            values = self._rows[:, list(self.vary).index(source)]
        else:
            values = np.asarray(self.vary[source].values, float)
        return len(values) > 0 and bool(np.all(values == np.round(values)))

    def rows(self, start: int, stop: int) -> Array:
        """The values of some runs.

        Parameters
        ----------
        start, stop : int
            First run, and the run after the last one.

        Returns
        -------
        ndarray, shape (stop - start, names)
            A row for each run, columns in the order of `names`.
        """
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
        """What the plan is, to be compared with that of a study begun earlier.

        Returns
        -------
        dict
            Plain data.
        """
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
