"""What is to be optimised."""

from __future__ import annotations

from dataclasses import dataclass

from dualcam.common.mistakes import refuse
from dualcam.study.optimisation.check import problems_of_task
from dualcam.study.optimisation.fields import TaskFields


@dataclass(frozen=True)
class Optimisation(TaskFields):
    """The search for the best design.

    Parameters
    ----------
    model : FmuRuns or callable
        Runs of an FMU; or a function of a module that gets one design, a dict of values by name, and returns
        results by name. What the function refuses with a DualcamError is no design.
    vary : mapping of str to Vary
        What is designed: bounds, or values to choose from. What has a distribution is not chosen but happens,
        differently in each part as made.
    objectives : mapping of str to str
        "minimise" or "maximise" for each result, or formula over results and varied values.
    constraints : mapping of str to tuple
        Least and greatest value of results or formulas; None: no limit on this side.
    method : {"slsqp", "evolution", "nsga2"}, optional
        SLSQP with gradients, differential evolution, or NSGA-II, which is the one for several objectives.
        Default: "evolution" for one objective, "nsga2" for several.
    budget : int
        Most designs that are evaluated, those for gradients included.
    population : int, optional
        Designs in a generation. Default: ten for each varied value, at least 20 and at most 100.
    starts : int
        Of "slsqp": searches from different designs.
    start : mapping of str to float or str
        Design with which the search begins. Default: the model's own, else the middle of the bounds.
    seed : int
        Start of the random numbers, 0 or more.
    tolerances : mapping of str to Deviation
        Of varied values and of fixed ones. With these, and with distributions in `vary`, an objective is a
        percentile over parts as made.
    percentile : float
        Share of the parts [%] that are as good as the objective says, and keep each constraint.
    samples : int
        Parts made of each design; all designs have the same deviations.
    difference : float
        Step of the gradients' differences, as a share of the bounds' distance.
    same_as : mapping of str to str
        Variables that get the value of another one, which varies.
    correlations : sequence of Correlation
        Of what has a distribution.
    results : sequence of str
        Results to be shown beside those in objectives and constraints, as those of `Study` but for series;
        objectives and constraints may use their names.
    units : mapping of str to str
        Units in which the command and its messages show values, by the name or by the text of a constraint;
        without one the FMU's unit.

    Raises
    ------
    StudyError
        All that is wrong, at once.

    Examples
    --------
    >>> from dualcam.study import FmuRuns, Optimisation, Scenario, Vary
    >>> angles = {"cam1.lead_angle": Vary(0.4, 1.2), "cam2.lead_angle": Vary(0.4, 1.2)}
    >>> task = Optimisation(FmuRuns("forward", Scenario(0.001)), angles, {"efficiency": "maximise"})
    >>> task.method_used
    'evolution'
    """

    def __post_init__(self) -> None:
        refuse(f"optimise: {problem}" for problem in problems_of_task(self))
