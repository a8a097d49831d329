"""The best designs as design files, which all other commands read."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from copy import deepcopy
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dualcam.common.groove_laws import LAWS
from dualcam.fmi.model_description import Scalar
from dualcam.scenario.formula import formula
from dualcam.scenario.scenario import History
from dualcam.study.optimisation.designs import Design, FmuRuns
from dualcam.study.optimisation.task import Optimisation

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile

BARE = re.compile(r"[A-Za-z0-9_-]+")


def fits_design_file(task: Optimisation) -> bool:
    """Whether the design's values are keys of design files."""
    if not isinstance(task.model, FmuRuns):
        return False
    from dualcam.fmi.variables import all_inputs, all_parameters

    known = {**all_parameters(), **all_inputs()}
    formulas = [*task.model.derived.values(), *task.model.conditions.values()]
    used = {*task.model.scenario.names, *(name for text in formulas for name in formula(text).names)}
    names = [*task.designed, *task.same_as, *task.model.derived, *task.model.parameters]
    return all(name in known or name in used for name in names)


def sections_of(design: DesignFile) -> dict[str, Any]:
    """The tables of a design file but [study], with absolute paths."""
    from dualcam.design_file.toml_text import parse, read_text

    content = parse(design.path, read_text(design.path))
    for cam in ("cam1", "cam2"):
        for key in ("table", "friction_table"):
            if content.get(cam, {}).get(key):
                content[cam][key] = str((design.path.parent / content[cam][key]).absolute())
    return {name: value for name, value in content.items() if name != "study"}


def write_design(path: Path, task: Optimisation, design: Design, head: str) -> None:
    """Write a design file: the sections of the original one, or fixed values; this design's values; and the
    scenario where a design file can have it."""
    assert isinstance(task.model, FmuRuns)
    content: dict[str, Any] = deepcopy(dict(task.model.sections))
    fixed = {} if content else task.model.parameters
    _set_values(content, {**fixed, **design})
    content, remark = _with_scenario(content, task, design)
    comments = [f"# {line}" for line in [*head.splitlines(), "Numbers are in SI units.", *remark]]
    path.write_text("\n".join([*comments, *toml_lines(content)]) + "\n", encoding="utf-8")


def _set_values(content: dict[str, Any], values: Mapping[str, Scalar]) -> None:
    """Put the values of parameters into the tables of a design file."""
    from dualcam.fmi.variables import all_parameters

    for name in sorted(set(values) & set(all_parameters())):
        group, _, key = name.rpartition(".")
        table = content.setdefault(group, {}) if group else content
        table[key] = LAWS[int(values[name])].word if key == "profile" else values[name]


def _with_scenario(
    content: dict[str, Any], task: Optimisation, design: Design
) -> tuple[dict[str, Any], list[str]]:
    """The content with the numbers of the scenario, and a remark where a design file cannot have it."""
    from dualcam.fmi.variables import all_inputs

    assert isinstance(task.model, FmuRuns)
    median = {name: float(vary.at(np.array([0.5]))[0]) for name, vary in task.chance.items()}
    scenario, before = task.model.scenario.at({**median, **design}), content.pop("scenario", {})
    if scenario.controller is not None:
        return content, ["The scenario has a controller in Python, which a design file cannot have."]
    if any(history.shape == "sine" for history in scenario.inputs.values()):
        return content, ["The scenario has a sine, which a design file cannot have."]
    table: dict[str, Any] = {"stop": scenario.stop}
    table |= {name: value for name in ("step", "tolerance") if (value := getattr(scenario, name))}
    if "output_interval" in before:
        table["output_interval"] = before["output_interval"]
    held = {**task.model.parameters, **design}
    given = {name: each for name, each in scenario.inputs.items() if not each.derivative_of}
    inputs: dict[str, Any] = {name: _history(each) for name, each in given.items()}
    inputs |= {name: float(held[name]) for name in all_inputs() if name in held}
    return content | {"scenario": table | ({"inputs": inputs} if inputs else {})}, []


def _history(history: History) -> dict[str, Any]:
    time, value = ([float(x) for x in numbers] for numbers in (history.time, history.value))
    shape = {} if history.shape == "linear" else {"shape": history.shape}
    return {"time": time, "value": value, **shape}


def toml_lines(table: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[str]:
    """The lines of a TOML table, then of the tables inside. The unit of a parameter is a comment."""
    for name, value in table.items():
        if not isinstance(value, Mapping):
            yield f"{_key(name)} = {_literal(value)}{_unit_comment((*path, name), value)}"
    for name, value in table.items():
        if isinstance(value, Mapping):
            inner = (*path, name)
            yield from ["", f"[{'.'.join(map(_key, inner))}]", *toml_lines(value, inner)]


def _unit_comment(path: tuple[str, ...], value: object) -> str:
    from dualcam.fmi.variables import all_parameters

    parameter = all_parameters().get(".".join(path))
    if parameter is None or isinstance(value, str | bool) or parameter.unit in ("", "1"):
        return ""
    return f"  # {parameter.unit}"


def _key(name: str) -> str:
    return name if BARE.fullmatch(name) else json.dumps(name)


def _literal(value: object) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_literal, value))}]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(name)} = {_literal(each)}" for name, each in value.items()) + "}"
    return repr(value)
