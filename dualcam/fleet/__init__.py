"""Thousands of instances of one FMU, stepped by one call.

Fleet        the instances, with arrays of inputs and outputs
FleetState   saved states of a fleet

May import common, fmi.
"""

from typing import TYPE_CHECKING

from dualcam.common.moved import old_names
from dualcam.fleet.core import FleetState
from dualcam.fleet.fleet import Fleet

__all__ = ["Fleet", "FleetState"]

if not TYPE_CHECKING:  # type checkers report the old names
    __getattr__ = old_names(__name__, {"FleetError": "errors.FleetError"})
