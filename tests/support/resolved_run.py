"""What one row of a plan means for its run, plainly; the runner does the same for many rows, faster."""

from dataclasses import dataclass

from dualcam.study.plan.rows import values_of, violated_by


@dataclass(frozen=True)
class ResolvedRun:
    """Start values of the FMU by name, the scenario without formulas, the arguments of the controller's law,
    and messages of the constraints that the row violates."""

    start_values: dict
    scenario: object
    law_arguments: dict
    violated: tuple


def resolve(names, row, scenario, variables, texts=None, constraints=None):
    values = values_of(names, row, texts or {})
    violated = violated_by(constraints or {}, values)
    numbers = scenario.at(values)
    law_arguments = dict(numbers.controller.arguments) if numbers.controller else {}
    start_values = {name: value for name, value in values.items() if name in variables}
    return ResolvedRun(start_values, numbers, law_arguments, violated)
