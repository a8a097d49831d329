"""All that the benchmarks take from tests/: the reference solutions, their scenes and the driver of C
functions."""

from __future__ import annotations

import cut_dependence  # type: ignore[import-not-found]
import driver  # type: ignore[import-not-found]
import general_scenes  # type: ignore[import-not-found]
import random_scenes  # type: ignore[import-not-found]
import reference  # type: ignore[import-not-found]
from reference import Interval

__all__ = ["Interval", "cut_dependence", "driver", "general_scenes", "random_scenes", "reference"]
