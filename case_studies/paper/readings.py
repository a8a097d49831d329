"""What hand-read torques, other friction laws and a misaligned lever would show."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from case_studies.paper.cams import Statics, pair
from case_studies.paper.published import RANGE, READINGS, TILT, UNCERTAINTY
from case_studies.paper.varying import FrictionLaw, turning
from dualcam.design.statics import Array


def rms(values: Array) -> float:
    """Root mean square."""
    return math.sqrt(float(np.mean(np.square(values))))


DRAWS: dict[str, tuple[Callable[[np.random.Generator, tuple[int, ...]], Array], float]] = {
    "anywhere, all alike": (lambda random, shape: random.uniform(0.0, 1.0, shape), math.sqrt(1 / 3)),
    "rather near the line (triangular)": (
        lambda random, shape: random.triangular(0.0, 0.0, 1.0, shape),
        math.sqrt(1 / 6),
    ),
    "in the near half": (lambda random, shape: random.uniform(0.0, 0.5, shape), math.sqrt(1 / 12)),
    "in the near quarter": (lambda random, shape: random.uniform(0.0, 0.25, shape), math.sqrt(1 / 48)),
}  # distribution of the distance from the line as a share of the band; root mean square of that share


@dataclass(frozen=True)
class Readings:
    """RMSE of many series of hand-read torques against one edge of the band, N.m."""

    mean: float
    low: float  # 2.5 % of the series are below
    high: float  # 2.5 % are above
    exact: float  # limit for many readings


def readings(
    band: Array, draw: str, series: int = 4000, seed: int = 2
) -> tuple[Readings, tuple[float, float]]:
    """RMSE of `series` series with one reading at each angle of `band` [N.m], drawn as DRAWS[draw]; and the
    95 % range of the ratio of two such RMSEs."""
    sample, share = DRAWS[draw]
    random = np.random.default_rng(seed)
    errors = np.sqrt(np.mean(np.square(band * sample(random, (2, series, band.size))), axis=2))
    low, high = np.quantile(errors, [0.025, 0.975])
    ratio = np.quantile(errors[0] / errors[1], [0.025, 0.975])
    return (
        Readings(float(np.mean(errors)), float(low), float(high), share * rms(band)),
        (float(ratio[0]), float(ratio[1])),
    )


def friction_for(statics: Statics, friction: float, direction: int, error: float, sign: int) -> float:
    """The friction, larger (sign +1) or smaller (-1), whose torque deviates by the RMSE `error` [N.m]; nan if
    there is none."""
    line = statics.torque(direction, friction)

    def miss(other: float) -> float:
        return rms(statics.torque(direction, other) - line) - error

    limit = 0.6 if sign > 0 else 0.0
    if miss(limit) < 0.0:
        return math.nan
    return float(brentq(miss, friction, limit, xtol=1e-13))


def law_error(
    statics: Statics, friction: float, exponent: float, direction: int
) -> tuple[float, float, float]:
    """RMSE [N.m] between friction that falls with the load and constant friction, if both agree at the least,
    at the mean, and at the largest nominal load."""
    loads = np.concatenate(statics.nominal_loads())
    line = statics.torque(direction, friction)

    def error(load: float) -> float:
        law = FrictionLaw(friction, load_exponent=-exponent, load=load)
        return rms(turning(statics, law, direction).torque - line)

    return error(float(loads.min())), error(float(loads.mean())), error(float(loads.max()))


def largest_change(ratio: float) -> float:
    """Largest change of exp(-v/v_s) while v grows by `ratio`, any v_s: at v/v_s = ln(ratio)/(ratio - 1)."""
    return ratio ** (-1.0 / (ratio - 1.0)) * (1.0 - 1.0 / ratio)


def band_at_readings(name: str, friction: float, count: int = READINGS) -> Array:
    """Width of the stick band at the angles of `count` readings [N.m], shape (count,)."""
    return Statics(pair(name), np.linspace(0.0, RANGE, count)).band(friction)


def share_needed(error: float, band: Array) -> float:
    """Part of the band, next to the line, over which evenly spread readings have the RMSE `error` [N.m]."""
    return math.sqrt(3.0) * error / rms(band)


@dataclass(frozen=True)
class Budget:
    """Relative uncertainties of the torque."""

    as_sine: float  # of the misalignment, as the paper has it
    as_cosine: float  # of the misalignment, right
    rest: float  # all but the misalignment, root of squares
    printed_total: float
    bias: float  # mean loss of torque, all tilts within the limits equally likely
    spread: float  # standard deviation of that loss


def uncertainty_budget() -> Budget:
    """The uncertainties with the misalignment TILT, and the total UNCERTAINTY."""
    sine, cosine = math.sin(TILT), 1.0 - math.cos(TILT)
    rest = math.sqrt(UNCERTAINTY**2 - cosine**2)
    mean = math.sin(TILT) / TILT  # of cos over -TILT..TILT
    square = 0.5 + math.sin(2.0 * TILT) / (4.0 * TILT)  # of cos^2
    return Budget(sine, cosine, rest, math.hypot(rest, sine), 1.0 - mean, math.sqrt(square - mean**2))
