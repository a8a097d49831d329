"""Parameters of a design from a recording of time, angle and torque.

identify            the fit: values, 95 % intervals, what the data cannot tell apart
Identification      its result: table, picture, report, design file
FittedParameter     one value with its interval
Ambiguity           unknowns that can change together without a change of the torque
Recording           samples; `read_recording` reads a CSV file
fitted_names        what can be fitted

May import common, fmi, design_file, plots, checking.
"""

from dualcam.identification.ambiguity import Ambiguity
from dualcam.identification.fit import identify
from dualcam.identification.identification import Identification
from dualcam.identification.recording import Recording, read_recording
from dualcam.identification.result import FittedParameter
from dualcam.identification.unknowns import fitted_names

__all__ = [
    "Ambiguity",
    "FittedParameter",
    "Identification",
    "Recording",
    "fitted_names",
    "identify",
    "read_recording",
]
