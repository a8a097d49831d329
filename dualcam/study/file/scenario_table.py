"""The scenario of a table in a file."""

import importlib
from collections.abc import Mapping
from typing import Any

from dualcam.common.mistakes import Findings, StudyError
from dualcam.scenario.formula import is_formula
from dualcam.scenario.history import History, Number
from dualcam.scenario.scenario import Controller, Scenario
from dualcam.study.file.context import Context, in_si, in_unit

UNITS = {"time": "s", "frequency": "Hz", "phase": "rad"}  # of numbers of an input; others have the input's
LISTED = ("time", "value")
SINGLE = ("mean", "amplitude", "frequency", "phase")
STILL = History([0.0], [0.0])  # in place of an input that is refused, so that the rest can be checked


def scenario_of(context: Context, content: Mapping[str, Any]) -> Scenario:
    """The scenario of a table. StudyError with all that is wrong with its values."""
    findings = Findings()
    found = {
        key: findings.attempt(_number, f"scenario: {key}", content[key], "s")
        for key in ("stop", "step")
        if key in content
    }
    inputs = {
        name: findings.attempt(_history, context, name, each) or STILL
        for name, each in content.get("inputs", {}).items()
    }
    control = findings.attempt(_controller, content["controller"]) if "controller" in content else None
    stop = 1.0 if found["stop"] is None else found["stop"]
    scenario = findings.attempt(Scenario, stop, inputs, found.get("step"), content.get("tolerance"), control)
    return findings.result(scenario)


def _history(context: Context, name: str, content: Any) -> History:  # noqa: ANN401
    if not isinstance(content, Mapping):
        content = {"time": [0.0], "value": [content]}
    findings, where = Findings(), f"scenario: {name}"
    unit = (context.units[name] or "1") if name in context.units else None
    found = dict(content)
    for key in (*LISTED, *SINGLE):
        if key not in found:
            continue
        given = found[key] if key in LISTED else [found[key]]
        own = UNITS.get(key, unit)
        values = [findings.attempt(_number, f"{where}: {key}", each, own) for each in given]
        found[key] = values if key in LISTED else values[0]
    findings.refuse()
    return History(**found)


def _number(where: str, value: Number, unit: str | None) -> Number:
    """A number or a formula; a text with a unit becomes a number. `unit` None: any unit of the SI will do."""
    if not isinstance(value, str) or not _is_quantity(value):
        return value
    return in_si(where, value) if unit is None else in_unit(where, value, unit)


def _is_quantity(text: str) -> bool:
    """Whether a text is meant as a number with a unit: no formula, and a digit comes first."""
    return not is_formula(text) and text.strip().lstrip("+-.")[:1].isdigit()


def _controller(content: Mapping[str, Any]) -> Controller:
    findings = Findings()
    law = findings.attempt(_imported, content["create_law"])
    period = findings.attempt(_number, "controller: period", content["period"], "s")
    arguments = {
        name: findings.attempt(_number, f"controller: {name}", value, None)
        for name, value in content.get("arguments", {}).items()
    }
    return Controller(findings.result(law), period, content["reads"], content["writes"], arguments)


def _imported(text: str) -> Any:  # noqa: ANN401
    """The function of a text module:function."""
    module, _, function = text.partition(":")
    try:
        return getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError, ValueError) as error:
        raise StudyError(f"controller: create_law = {text!r}: allowed is module:function: {error}") from error
