"""The scenario of a table in a file; the scenario may still be wrong."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from dualcam.study.history import History, Number
from dualcam.study.problem import Place, StudyError, unchecked
from dualcam.study.reading.context import Context
from dualcam.study.reading.quantities import in_si, in_unit
from dualcam.study.sampling.formula import is_formula
from dualcam.study.scenario import Controller, Scenario

UNITS = {"time": "s", "frequency": "Hz", "phase": "rad"}  # of numbers of an input; others have the input's
LISTED = ("time", "value")
SINGLE = ("mean", "amplitude", "frequency", "phase")


def scenario_of(context: Context, content: Mapping[str, Any] | None) -> Scenario | None:
    """The scenario of a table, unchecked, None in place of numbers that are refused. None without a table."""
    if content is None:
        return None
    times = {
        key: _number(context, ("scenario", key), f"scenario: {key}", content[key], "s")
        for key in ("stop", "step")
        if key in content
    }
    control = _controller(context, content["controller"]) if "controller" in content else None
    return unchecked(
        Scenario,
        stop=times.get("stop"),
        inputs={name: _history(context, name, each) for name, each in content.get("inputs", {}).items()},
        step=times.get("step"),
        tolerance=content.get("tolerance"),
        controller=control,
    )


def _history(context: Context, name: str, content: Any) -> History:  # noqa: ANN401
    place, where = ("scenario", "inputs", name), f"scenario: {name}"
    if not isinstance(content, Mapping):
        content = {"time": [0.0], "value": [content]}
    unit = (context.units[name] or "1") if name in context.units else None
    found = dict(content)
    for key in (*LISTED, *SINGLE):
        if key not in found:
            continue
        own = UNITS.get(key, unit)
        values = [
            _number(context, (*place, key), f"{where}: {key}", each, own)
            for each in (found[key] if key in LISTED else [found[key]])
        ]
        found[key] = values if key in LISTED else values[0]
    return unchecked(History, **found, **_stand_ins(context, place, found))


def _stand_ins(context: Context, place: Place, found: Mapping[str, Any]) -> dict[str, Any]:
    """In place of keys that are refused, so that the others can be checked."""
    refused = [
        key
        for key in (*LISTED, *SINGLE, "shape")
        if key not in found and not context.findings.is_sound(*place, key)
    ]
    length = max([len(found[key]) for key in LISTED if key in found], default=1)
    instead = {**dict.fromkeys(LISTED, [None] * length), **dict.fromkeys(SINGLE)}
    instead["shape"] = "sine" if any(key in found for key in SINGLE) else "linear"
    return {key: instead[key] for key in refused if key not in LISTED or not _is_wave(found)}


def _is_wave(found: Mapping[str, Any]) -> bool:
    return any(key in found for key in (*SINGLE, "derivative_of"))


def _number(context: Context, place: Place, where: str, value: Any, unit: str | None) -> Number:  # noqa: ANN401
    """A number or a formula; a text with a unit becomes a number; None for one that is refused.

    `unit` None: any unit of the SI will do."""
    if not isinstance(value, str) or not _is_quantity(value):
        return value
    if unit is None:
        return context.findings.attempt(place, in_si, where, value)
    return context.findings.attempt(place, in_unit, where, value, unit)


def _is_quantity(text: str) -> bool:
    """Whether a text is meant as a number with a unit: no formula, and a digit comes first."""
    return not is_formula(text) and text.strip().lstrip("+-.")[:1].isdigit()


def _controller(context: Context, content: Mapping[str, Any]) -> Controller:
    place: Place = ("scenario", "controller")
    law = None
    if "create_law" in content:
        law = context.findings.attempt((*place, "create_law"), _imported, content["create_law"])
    arguments = {
        name: _number(context, (*place, "arguments", name), f"controller: {name}", value, None)
        for name, value in content.get("arguments", {}).items()
    }
    period = None
    if "period" in content:
        period = _number(context, (*place, "period"), "controller: period", content["period"], "s")
    return unchecked(
        Controller,
        create_law=law,
        period=period,
        reads=content.get("reads", ()),
        writes=content.get("writes", ()),
        arguments=arguments,
    )


def _imported(text: str) -> Any:  # noqa: ANN401
    """The function of a text module:function."""
    module, _, function = text.partition(":")
    try:
        return getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError, ValueError) as error:
        raise StudyError(f"controller: create_law = {text!r}: allowed is module:function: {error}") from error
