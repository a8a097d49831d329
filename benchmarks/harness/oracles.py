"""All that the benchmarks take from tests/: the reference solutions, their scenes and the driver of C
functions."""

from __future__ import annotations

import cut_dependence
import driver
import general_scenes
import random_scenes
import reference
from reference import Interval

__all__ = ["Interval", "cut_dependence", "driver", "general_scenes", "random_scenes", "reference"]
