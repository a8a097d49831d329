"""The best designs as design files, which all other commands read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dualcam.model_description import Scalar
from dualcam.study.optimisation.task import Design, FmuRuns, Optimisation
from dualcam.study.sampling.formula import formula
from dualcam.study.scenario import History, Scenario

PROFILES = {1: "helix", 2: "ellipse", 3: "table"}


def fits_design_file(task: Optimisation) -> bool:
    """Whether the design's values are keys of design files."""
    if not isinstance(task.model, FmuRuns):
        return False
    from dualcam.variables import all_inputs, all_parameters

    known = {**all_parameters(), **all_inputs()}
    used = {*task.model.scenario.names}  # serve the scenario or other values
    for text in [*task.model.derived.values(), *task.model.conditions.values()]:
        used |= set(formula(text).names)
    names = [*task.designed, *task.same_as, *task.model.derived, *task.model.parameters]
    return all(name in known or name in used for name in names)


def design_text(task: Optimisation, design: Design, head: str) -> str:
    """A design file: fixed values, this design's values, and the scenario where a design file can have it."""
    from dualcam.variables import all_inputs, all_parameters

    assert isinstance(task.model, FmuRuns)
    values: dict[str, Scalar] = {**task.model.parameters, **design}
    lines = [f"# {line}" for line in head.splitlines()] + ["# All values are in SI units."]
    groups: dict[str, list[str]] = {}
    parameters = all_parameters()
    for name, value in values.items():
        if name not in parameters:
            continue
        group, _, key = name.rpartition(".")
        unit = parameters[name].unit
        comment = f"  # {unit}" if unit not in (None, "", "1") else ""
        groups.setdefault(group, []).append(f"{key} = {_literal(name, value)}{comment}")
    for group in sorted(groups):  # keys without a table first
        lines += ["", *([f"[{group}]"] if group else []), *groups[group]]
    held = {name: float(value) for name, value in values.items() if name in all_inputs()}
    lines += _scenario_lines(_numbers(task, design), held)
    return "\n".join(lines) + "\n"


def _numbers(task: Optimisation, design: Design) -> Scenario:
    """The scenario of this design; what happens by chance has its median."""
    assert isinstance(task.model, FmuRuns)
    chance = {name: float(vary.at(np.array([0.5]))[0]) for name, vary in task.chance.items()}
    return task.model.scenario.at({**chance, **design})


def _literal(name: str, value: Scalar) -> str:
    if name.endswith(".profile") and not isinstance(value, str) and int(value) in PROFILES:
        return f'"{PROFILES[int(value)]}"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return (
            "'" + value + "'"
            if "'" not in value
            else '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
        )
    return repr(int(value) if float(value).is_integer() and isinstance(value, int) else float(value))


def _scenario_lines(scenario: Scenario, held: Mapping[str, float]) -> list[str]:
    if scenario.controller is not None:
        return ["", "# The scenario has a controller in Python, which a design file cannot have."]
    if any(history.shape == "sine" for history in scenario.inputs.values()):
        return ["", "# The scenario has a sine, which a design file cannot have."]
    lines = ["", "[scenario]", f"stop = {scenario.stop!r}  # s"]
    lines += [f"{name} = {value!r}" for name in ("step", "tolerance") if (value := getattr(scenario, name))]
    for name, history in scenario.inputs.items():
        if not history.derivative_of:
            lines.append(f'inputs."{name}" = {_history(history)}')
    lines += [f'inputs."{name}" = {{time = [0.0], value = [{value!r}]}}' for name, value in held.items()]
    return lines


def _history(history: History) -> str:
    time, value = ([float(x) for x in numbers] for numbers in (history.time, history.value))
    shape = "" if history.shape == "linear" else f', shape = "{history.shape}"'
    return f"{{time = {time}, value = {value}{shape}}}"


def write_design(path: Path, task: Optimisation, design: Design, head: str) -> Path:
    """Write it, and give its path."""
    path.write_text(design_text(task, design, head), encoding="utf-8")
    return path
