"""Friction tables that a design file names: read and checked as the FMU does."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dualcam.common.tables import FRICTION_HEADERS, ColumnKind, TableKind, fmu_text, read_table
from dualcam.errors import DesignError

SPEED = ("v", "speed", "velocity", "sliding speed", "geschwindigkeit", "gleitgeschwindigkeit")
MU = ("mu", "µ", "μ", "friction", "friction coefficient", "cof", "reibwert", "reibungszahl")
FRICTION = TableKind(
    what="friction table",
    quantities={
        "v": ColumnKind("velocity", SPEED, rule="table.v"),
        "R": ColumnKind("force", ("r", "load", "force", "reaction", "last", "normalkraft"), needed=False),
        "mu": ColumnKind("ratio", MU, rule="table.mu"),
    },
    example=" or ".join(FRICTION_HEADERS),
    error=DesignError,
)
LEAST, MOST = 3, 2000  # speeds, lines
LEAST_LOADS, MOST_LOADS = 2, 16
LARGEST = 10.0  # mu
LARGEST_POWER = 0.9  # of the load, to which mu is proportional
# Keys of a cam that are not used with a friction table.
ANALYTIC_FRICTION = (
    "friction",
    "friction_peak",
    "stribeck_velocity",
    "stribeck_exponent",
    "friction_viscous",
    "friction_load_exponent",
    "friction_load",
)


class FrictionSample(NamedTuple):
    """One line of a friction table."""

    speed: float  # m/s
    load: float  # N, nominal load of one contact; 0 where the table has no loads
    mu: float


@dataclass(frozen=True)
class FrictionTable:
    """A friction table, and how its file was understood."""

    by_load: list[list[FrictionSample]]  # from the least load, over the speed; one where there are no loads
    notes: tuple[str, ...]  # what was guessed
    warnings: tuple[str, ...]  # numbers that look as if they were in another unit
    is_fmu_format: bool  # whether the FMU can read the file as it is

    @property
    def static_samples(self) -> tuple[list[float], list[float]]:
        """Loads [N], growing, and mu at rest under each; one load, 0, where the table has none."""
        at_rest = [samples[0] for samples in self.by_load]
        return [sample.load for sample in at_rest], [sample.mu for sample in at_rest]

    def fmu_text(self) -> str:
        """The table as the FMU reads it."""
        speed, load, mu = np.array([sample for samples in self.by_load for sample in samples]).T
        plain, with_load = FRICTION_HEADERS
        return fmu_text(with_load, speed, load, mu) if load.any() else fmu_text(plain, speed, mu)


def read_friction_table(path: Path) -> FrictionTable:
    """A friction table from a file. DesignError, with the line, for a table that the FMU would refuse."""
    table = read_table(path, FRICTION)
    speeds, mus = table.columns["v"], table.columns["mu"]
    has_loads = "R" in table.columns
    loads = table.columns["R"] if has_loads else np.zeros(len(mus))
    samples = [FrictionSample(*row) for row in np.column_stack([speeds, loads, mus]).tolist()]
    try:
        by_load = _by_load(samples, table.lines.tolist(), has_loads)
    except DesignError as error:
        raise DesignError(f"{path}: {error}") from None
    return FrictionTable(by_load, table.notes, table.warnings, table.is_for_the_fmu(FRICTION_HEADERS))


def _by_load(
    samples: Sequence[FrictionSample], lines: Sequence[int], has_loads: bool
) -> list[list[FrictionSample]]:
    if len(samples) > MOST:
        raise DesignError(f"{len(samples)} points: allowed are up to {MOST}")
    by_load: list[list[FrictionSample]] = []
    for number, sample in zip(lines, samples, strict=True):
        _check_sample(sample, number, has_loads)
        begins = not by_load or (has_loads and sample.speed == 0.0)
        if begins:
            _check_load(sample, by_load, number)
            by_load.append([])
        else:
            _check_speed(sample, by_load, number)
        by_load[-1].append(sample)
    _check_whole(by_load, has_loads)
    return by_load


def _check_sample(sample: FrictionSample, number: int, has_loads: bool) -> None:
    if has_loads and not sample.load > 0.0:
        raise DesignError(f"line {number}: R = {sample.load:g} N must be > 0")
    if not 0.0 < sample.mu <= LARGEST:
        raise DesignError(
            f"line {number}: mu = {sample.mu:g} must be > 0 and <= {LARGEST:g}; without friction leave out"
            " the table and set the friction to 0"
        )


def _check_load(sample: FrictionSample, by_load: list[list[FrictionSample]], number: int) -> None:
    """A sample that begins a load."""
    if not by_load and sample.speed != 0.0:
        raise DesignError(
            f"line {number}: v = {sample.speed:g} m/s must be 0 in the first line of numbers, which holds the"
            " static coefficient"
        )
    if by_load and not sample.load > by_load[-1][-1].load:
        before = by_load[-1][-1].load
        raise DesignError(f"line {number}: R = {sample.load:g} N must be > {before:g}, the load before")
    if len(by_load) == MOST_LOADS:
        raise DesignError(f"line {number}: too many loads, allowed are up to {MOST_LOADS}")


def _check_speed(sample: FrictionSample, by_load: list[list[FrictionSample]], number: int) -> None:
    before = by_load[-1][-1]
    if sample.load != before.load:
        raise DesignError(
            f"line {number}: R = {sample.load:g} N must be {before.load:g} N: a load begins with v = 0 and"
            " has all speeds"
        )
    if not sample.speed > before.speed:
        must = f"must be > {before.speed:g}, that of the line before"
        raise DesignError(f"line {number}: v = {sample.speed:g} m/s {must}")


def _check_whole(by_load: list[list[FrictionSample]], has_loads: bool) -> None:
    if not by_load or len(by_load[0]) < LEAST:
        count = len(by_load[0]) if by_load else 0
        raise DesignError(f"{count} points: there must be at least {LEAST}")
    if has_loads and len(by_load) < LEAST_LOADS:
        raise DesignError("one load: there must be at least 2; for one, leave out the column of the load")
    speeds = [sample.speed for sample in by_load[0]]
    for samples in by_load:
        if [sample.speed for sample in samples] != speeds:
            raise DesignError(f"R = {samples[0].load:g} N: each load must have the speeds of the first load")
    for low, high in pairwise(by_load):
        for a, b in zip(low, high, strict=True):
            power = math.log(b.mu / a.mu) / math.log(b.load / a.load)
            if abs(power) > LARGEST_POWER:
                raise DesignError(
                    f"at v = {a.speed:g} m/s mu goes with the power {power:.3g} of the load from"
                    f" R = {a.load:g} to {b.load:g} N: allowed are powers from {-LARGEST_POWER:g} to"
                    f" {LARGEST_POWER:g}"
                )
