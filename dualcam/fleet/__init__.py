"""Thousands of instances of one FMU, stepped by one call.

Fleet        the instances, with arrays of inputs and outputs
FleetState   saved states of a fleet
FleetError   which instances failed, and why

May import common, fmi.
"""

from dualcam.errors import FleetError
from dualcam.fleet.core import FleetState
from dualcam.fleet.fleet import Fleet

__all__ = ["Fleet", "FleetError", "FleetState"]
