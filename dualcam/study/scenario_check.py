"""All that is wrong with a scenario, as far as it does not depend on the run, at once."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from dualcam.study.entries import hint
from dualcam.study.history import problem_of_number
from dualcam.study.problem import Findings

if TYPE_CHECKING:
    from dualcam.study.scenario import Controller, Scenario


def check_scenario(scenario: Scenario, findings: Findings) -> None:
    """Notes what is wrong with a scenario, each message with the value and what is allowed.

    What depends on a place that is not sound is left out. The places are those of the section [scenario]."""
    for key in ("stop", "step", "tolerance"):
        if findings.is_sound("scenario", key):
            _note(findings, key, problem_of_number(key, getattr(scenario, key)))
    for name, history in scenario.inputs.items():
        _note(findings, "inputs", [f"{name}: {problem}" for problem in history.problems()], name)
    for name, history in scenario.inputs.items():
        if history.derivative_of and findings.is_sound("scenario", "inputs", name):
            _note(findings, "inputs", _problems_of_source(scenario, name), name)
    if scenario.controller is not None:
        _check_controller(scenario, scenario.controller, findings)


def _note(findings: Findings, key: str, problems: list[str], *within: str) -> None:
    findings.note(("scenario", key, *within), *(f"scenario: {problem}" for problem in problems))


def _problems_of_source(scenario: Scenario, name: str) -> list[str]:
    """What is wrong with the history whose derivative an input is."""
    other = scenario.inputs[name].derivative_of
    if other not in scenario.inputs:
        return [f"{name}: derivative of {other}, which has no history{hint(other, scenario.inputs)}"]
    chain = [name]
    while other:
        if other in chain:
            circle = ", ".join(sorted(chain[chain.index(other) :]))
            return [f"{circle} are derivatives of each other in a circle: allowed is one with time and value"]
        chain.append(other)
        other = scenario.inputs[other].derivative_of if other in scenario.inputs else ""
    return []


def _check_controller(scenario: Scenario, control: Controller, findings: Findings) -> None:
    law, place = control.create_law, ("scenario", "controller", "create_law")
    if findings.is_sound(*place) and not hasattr(law, "__qualname__"):
        text = f"create_law = {law!r}: allowed is a function of a module"
        _note(findings, "controller", [text], "create_law")
    if findings.is_sound("scenario", "controller", "period"):
        _note(findings, "controller", problem_of_number("controller.period", control.period), "period")
    for name, number in control.arguments.items():
        if findings.is_sound("scenario", "controller", "arguments", name):
            problems = problem_of_number(f"argument {name}", number, above=-math.inf)
            _note(findings, "controller", problems, "arguments", name)
    for name in control.writes:
        if name in scenario.inputs:
            text = f"{name} has a history and a controller: allowed is one of them"
            _note(findings, "controller", [text], "writes")
