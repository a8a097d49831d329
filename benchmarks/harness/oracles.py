"""All that the benchmarks take from tests/: the reference solutions, their scenes and the driver of C
functions."""

from __future__ import annotations

import sys

from benchmarks.harness.repository import ROOT

sys.path.insert(0, str(ROOT / "tests"))  # whose modules import one another without a package
import driver  # type: ignore[import-not-found]
import general_scenes  # type: ignore[import-not-found]
import reference  # type: ignore[import-not-found]
from reference import Interval

__all__ = ["Interval", "driver", "general_scenes", "reference"]
