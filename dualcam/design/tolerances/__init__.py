"""What tolerances do to the torque band: percentiles, yield, and which tolerance matters.

    Tolerance               distribution of a parameter: from SciPy, by name, or from the limits on a drawing
    analyse, Limit          torque band of a mechanism under tolerances, and its yield against limits
    propagate               the same for any function of parameters

Everything is slow motion, in SI units. Page docs/design-tolerances.md shows the use.
"""

from dualcam.design.tolerances.analysis import ToleranceAnalysis, analyse
from dualcam.design.tolerances.limits import Limit, Yield, yield_of
from dualcam.design.tolerances.propagation import Budget, Propagation, propagate
from dualcam.design.tolerances.tolerance import Tolerance

__all__ = [
    "Budget",
    "Limit",
    "Propagation",
    "Tolerance",
    "ToleranceAnalysis",
    "Yield",
    "analyse",
    "propagate",
    "yield_of",
]
