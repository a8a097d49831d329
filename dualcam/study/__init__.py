"""Parameter studies: many runs of one co-simulation FMU, hundreds of thousands per second and core.

A study is a plan (which values), a scenario (what is done to the mechanism) and results (what is read, and
when):

    from dualcam.study import History, Plan, Scenario, Study, Vary

    study = Study(
        "forward",
        Plan("sobol", {"cam1.lead_angle": Vary(0.5, 1.1), "cam2.lead_angle": Vary(0.5, 1.1)}, runs=4096),
        Scenario(0.4, {"tau": History([0.0, 0.2, 0.2, 0.4], [0.0, 8.0, 0.0, 0.0])}),
        ["efficiency", "energy.heat_cam1", "theta@0.2"],
    )
    table = study.run("results/sobol")

Everything goes through FMI alone: it works with any FMU of FMI 2.0 or FMI 3.0. `dualcam study
plan.toml` is the same on the command line.
"""

from dualcam.module_calls import explain_call_of
from dualcam.study.evaluator import Evaluator
from dualcam.study.optimisation import Deviation, FmuRuns, Optimisation, Optimum, optimise, read_optimisation
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError
from dualcam.study.reading.study_file import read_study
from dualcam.study.results import Results, read_results
from dualcam.study.sampling.correlation import Correlation
from dualcam.study.sampling.vary import Vary
from dualcam.study.scenario import Controller, History, Scenario
from dualcam.study.study import Study

__all__ = [
    "Controller",
    "Correlation",
    "Deviation",
    "Evaluator",
    "FmuRuns",
    "History",
    "Optimisation",
    "Optimum",
    "Plan",
    "Results",
    "Scenario",
    "Study",
    "StudyError",
    "Vary",
    "optimise",
    "read_optimisation",
    "read_results",
    "read_study",
]

explain_call_of(__name__)
