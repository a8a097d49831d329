"""The times at which a scenario is sampled."""

from __future__ import annotations

import math

import numpy as np

from dualcam.common.arrays import Array
from dualcam.errors import DesignError

DEFAULT_SAMPLES = 1000  # where the scenario gives no output interval
MOST_SAMPLES = 2_000_000


def sample_times(stop: float, interval: float | None) -> Array:
    """Times [s] of the samples: multiples of the output interval, and the end.

    Raises
    ------
    DesignError
        For an interval that is not above 0, or gives too many samples.
    """
    interval = stop / DEFAULT_SAMPLES if interval is None else interval
    if not (math.isfinite(interval) and interval > 0.0):
        raise DesignError(f"scenario.output_interval = {interval} s: allowed is a finite number above 0")
    if stop / interval > MOST_SAMPLES:
        raise DesignError(
            f"scenario.output_interval = {interval:g} s gives {stop / interval:.3g} samples: allowed are up"
            f" to {MOST_SAMPLES:,}, from {stop / MOST_SAMPLES:.3g} s on"
        )
    count = math.ceil(stop / interval * (1.0 - 1e-12))
    return np.minimum(np.arange(count + 1) * interval, stop)
