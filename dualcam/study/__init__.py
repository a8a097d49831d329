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

May import common, fmi, fleet, scenario, design, design_file, checking, report.
"""

from typing import TYPE_CHECKING

from dualcam.common.module_calls import explain_call_of
from dualcam.common.moved import moved_name
from dualcam.scenario.scenario import Controller, History, Scenario
from dualcam.study.plan.correlation import Correlation
from dualcam.study.plan.plan import Plan
from dualcam.study.plan.vary import Vary
from dualcam.study.run.evaluator import Evaluator
from dualcam.study.store.results import Results, read_results
from dualcam.study.study import Study

if TYPE_CHECKING:
    from dualcam.study.file.study_file import read_study
    from dualcam.study.optimisation import (
        Deviation,
        FmuRuns,
        Optimisation,
        Optimum,
        optimise,
        read_optimisation,
    )

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
    "Vary",
    "optimise",
    "read_optimisation",
    "read_results",
    "read_study",
]

# Loaded at the first use: a process that only computes runs does without them and without pydantic.
_MODULE_OF = dict.fromkeys(
    ("Deviation", "FmuRuns", "Optimisation", "Optimum", "optimise", "read_optimisation"), "optimisation"
) | {"read_study": "file.study_file"}

if not TYPE_CHECKING:  # type checkers see the imports above, and report other names

    def __getattr__(name: str) -> object:
        from importlib import import_module

        if name == "StudyError":
            return moved_name(__name__, name, "errors.StudyError", stacklevel=2)
        if name not in _MODULE_OF:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = globals()[name] = getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
        return value

    def __dir__() -> list[str]:
        return sorted(__all__)


explain_call_of(__name__)
