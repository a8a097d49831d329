"""Friction tables that a design file names: read and checked as the FMU does."""

from __future__ import annotations

import math
from pathlib import Path

from dualcam.design.groove_files import decoded_text
from dualcam.errors import DesignError

HEADER = "v_m_s,mu"
LEAST, MOST = 3, 500  # samples
LARGEST = 10.0  # mu
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


def read_friction_table(path: Path) -> list[tuple[float, float]]:
    """Pairs of sliding speed [m/s] and friction coefficient [1]; the first pair is that at rest.

    DesignError, with the line, for a file that the FMU would refuse."""
    text, is_utf8 = decoded_text(path, "friction table")
    if not is_utf8:
        raise DesignError(f"{path.name} is not in UTF-8: save the table as CSV in UTF-8")
    header, *lines = text.rstrip().split("\n") if text.strip() else [""]
    if header.strip() != HEADER:
        raise DesignError(f"line 1, {header.strip()[:40]!r}, must be the header {HEADER!r}")
    samples: list[tuple[float, float]] = []
    for number, line in enumerate(lines, 2):
        sample = _sample(line, number)
        _check(sample, samples, number)
        samples.append(sample)
    if not LEAST <= len(samples) <= MOST:
        raise DesignError(f"{len(samples)} points: allowed are {LEAST} to {MOST}")
    return samples


def _sample(line: str, number: int) -> tuple[float, float]:
    try:
        v, mu = (float(cell) for cell in line.split(","))
    except ValueError:
        v = mu = math.nan
    if not (math.isfinite(v) and math.isfinite(mu)):
        raise DesignError(
            f'line {number}, {line.strip()[:40]!r}, must be two finite numbers "{HEADER}", like "0.01,0.12"'
        )
    return v, mu


def _check(sample: tuple[float, float], before: list[tuple[float, float]], number: int) -> None:
    v, mu = sample
    if not before and v != 0.0:
        raise DesignError(
            f"line {number}: v_m_s = {v:g} must be 0 in the first line of numbers, which holds the static"
            " coefficient"
        )
    if before and not v > before[-1][0]:
        raise DesignError(
            f"line {number}: v_m_s = {v:g} must be > {before[-1][0]:g}, that of the line before"
        )
    if not 0.0 < mu <= LARGEST:
        raise DesignError(
            f"line {number}: mu = {mu:g} must be > 0 and <= {LARGEST:g}; without friction leave out the table"
            " and set the friction to 0"
        )
