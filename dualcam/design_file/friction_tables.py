"""Friction tables that a design file names: read and checked as the FMU does."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from dualcam.design.groove_files import decoded_text
from dualcam.errors import DesignError

FORMS = {  # header -> a line as an example
    "v_m_s,mu": "0.01,0.12",
    "v_m_s,R_N,mu": "0.01,100,0.12",
}
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


def read_friction_table(path: Path) -> list[list[FrictionSample]]:
    """For each load, from the least one, the samples over the speed; one list where the table has no loads.

    DesignError, with the line, for a file that the FMU would refuse."""
    text, is_utf8 = decoded_text(path, "friction table")
    if not is_utf8:
        raise DesignError(f"{path.name} is not in UTF-8: save the table as CSV in UTF-8")
    header, *lines = text.rstrip().split("\n") if text.strip() else [""]
    header = header.strip()
    if header not in FORMS:
        allowed = " or ".join(f'"{form}"' for form in FORMS)
        raise DesignError(f"line 1, {header[:40]!r}, must be the header {allowed}")
    by_load: list[list[FrictionSample]] = []
    if len(lines) > MOST:
        raise DesignError(f"{len(lines)} points: allowed are up to {MOST}")
    for number, line in enumerate(lines, 2):
        sample = _sample(line, header, number)
        begins = not by_load or (sample.load > 0.0 and sample.speed == 0.0)
        if begins:
            _check_load(sample, by_load, number)
            by_load.append([])
        else:
            _check_speed(sample, by_load, number)
        by_load[-1].append(sample)
    _check_whole(by_load, header)
    return by_load


def static_samples(path: Path) -> tuple[list[float], list[float]]:
    """Loads [N], growing, and mu at rest under each; one load, 0, where the table has none."""
    at_rest = [samples[0] for samples in read_friction_table(path)]
    return [sample.load for sample in at_rest], [sample.mu for sample in at_rest]


def _sample(line: str, header: str, number: int) -> FrictionSample:
    try:
        cells = [float(cell) for cell in line.split(",")]
    except ValueError:
        cells = []
    if len(cells) != header.count(",") + 1 or not all(map(math.isfinite, cells)):
        raise DesignError(
            f'line {number}, {line.strip()[:40]!r}, must be finite numbers "{header}", like "{FORMS[header]}"'
        )
    speed, *load, mu = cells
    if load and not load[0] > 0.0:
        raise DesignError(f"line {number}: R_N = {load[0]:g} must be > 0")
    if not 0.0 < mu <= LARGEST:
        raise DesignError(
            f"line {number}: mu = {mu:g} must be > 0 and <= {LARGEST:g}; without friction leave out the table"
            " and set the friction to 0"
        )
    return FrictionSample(speed, load[0] if load else 0.0, mu)


def _check_load(sample: FrictionSample, by_load: list[list[FrictionSample]], number: int) -> None:
    """A sample that begins a load."""
    if not by_load and sample.speed != 0.0:
        raise DesignError(
            f"line {number}: v_m_s = {sample.speed:g} must be 0 in the first line of numbers, which holds the"
            " static coefficient"
        )
    if by_load and not sample.load > by_load[-1][-1].load:
        raise DesignError(
            f"line {number}: R_N = {sample.load:g} must be > {by_load[-1][-1].load:g}, the load before"
        )
    if len(by_load) == MOST_LOADS:
        raise DesignError(f"line {number}: too many loads, allowed are up to {MOST_LOADS}")


def _check_speed(sample: FrictionSample, by_load: list[list[FrictionSample]], number: int) -> None:
    before = by_load[-1][-1]
    if sample.load != before.load:
        raise DesignError(
            f"line {number}: R_N = {sample.load:g} must be {before.load:g}: a load begins with v_m_s = 0 and"
            " has all speeds"
        )
    if not sample.speed > before.speed:
        raise DesignError(
            f"line {number}: v_m_s = {sample.speed:g} must be > {before.speed:g}, that of the line before"
        )


def _check_whole(by_load: list[list[FrictionSample]], header: str) -> None:
    if not by_load or len(by_load[0]) < LEAST:
        count = len(by_load[0]) if by_load else 0
        raise DesignError(f"{count} points: there must be at least {LEAST}")
    if header.count(",") == 2 and len(by_load) < LEAST_LOADS:
        raise DesignError("one load: there must be at least 2; for one, leave out the column R_N")
    speeds = [sample.speed for sample in by_load[0]]
    for samples in by_load:
        if [sample.speed for sample in samples] != speeds:
            raise DesignError(f"R_N = {samples[0].load:g}: each load must have the speeds of the first load")
    for low, high in pairwise(by_load):
        for a, b in zip(low, high, strict=True):
            power = math.log(b.mu / a.mu) / math.log(b.load / a.load)
            if abs(power) > LARGEST_POWER:
                raise DesignError(
                    f"at v_m_s = {a.speed:g} mu goes with the power {power:.3g} of the load from"
                    f" R_N = {a.load:g} to {b.load:g}: allowed are powers from {-LARGEST_POWER:g} to"
                    f" {LARGEST_POWER:g}"
                )
