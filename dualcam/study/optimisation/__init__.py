"""Optimisation: the best design instead of a cloud of points.

A design is a row of values. Its runs are those of a study. Several parts of each design, as made, give a
percentile. The search (`gradient`, `evolution`) asks for batches of designs. The record keeps them.
"""

from dualcam.study.optimisation.designs import Deviation, FmuRuns
from dualcam.study.optimisation.file import read_optimisation
from dualcam.study.optimisation.optimum import Optimum
from dualcam.study.optimisation.run import optimise
from dualcam.study.optimisation.task import Optimisation

__all__ = ["Deviation", "FmuRuns", "Optimisation", "Optimum", "optimise", "read_optimisation"]
