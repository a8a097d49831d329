"""All that the benchmarks take from tests/: the reference solutions, their scenes and the driver of C
functions."""

from __future__ import annotations

import driver
import general_scenes
import reference
from reference import Interval

__all__ = ["Interval", "driver", "general_scenes", "reference"]
