"""FMUs from Python: the calls of FMI 2.0 and 3.0, handles with names instead of value references, model
descriptions, and where this package's own FMUs are. Physics is in the FMU alone.

    Fmu, ContinuousFmu, FmuState                            instances, and their saved states
    Reals, RepeatedStart                                    variables and start values as arrays
    read_model_description, ModelDescription, Variable      what an FMU says of itself
    fmu_path                                                where this package's FMUs are

May import common.
"""

from dualcam.fmi.continuous_fmu import ContinuousFmu
from dualcam.fmi.fmu import Fmu, RepeatedStart
from dualcam.fmi.handle import FmuState
from dualcam.fmi.library import fmu_path
from dualcam.fmi.model_description import ModelDescription, Variable, read_model_description
from dualcam.fmi.reals import Reals

__all__ = [
    "ContinuousFmu",
    "Fmu",
    "FmuState",
    "ModelDescription",
    "Reals",
    "RepeatedStart",
    "Variable",
    "fmu_path",
    "read_model_description",
]
