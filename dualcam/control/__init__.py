"""The cam as a plant of python-control: nonlinear and linear models, describing functions, limit cycles of
sampled loops.

    linearize, OperatingPoint                   the linear model about a point, and that point
    to_nonlinear_io_system                      the plant
    CamHysteresis                               the friction hysteresis
    LimitCycles, LimitCycle, LoopMotion         what CamHysteresis.limit_cycles finds

May import common, fmi.
"""

from dualcam.control.bridge import to_nonlinear_io_system
from dualcam.control.harmonic_balance import LimitCycle
from dualcam.control.hysteresis import CamHysteresis
from dualcam.control.limit_cycles import LimitCycles
from dualcam.control.linear import OperatingPoint, linearize
from dualcam.control.sampled_loop import LoopMotion

__all__ = [
    "CamHysteresis",
    "LimitCycle",
    "LimitCycles",
    "LoopMotion",
    "OperatingPoint",
    "linearize",
    "to_nonlinear_io_system",
]
