"""The start values of a cam in a system, judged as commands judge a design file."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from dualcam.checking import check_design
from dualcam.common.archive import read_members
from dualcam.common.unit_guards import unit_warning
from dualcam.design_file import DesignFile, Finding
from dualcam.export.changed import RESOURCES
from dualcam.fmi.model_description import ModelDescription, Scalar
from dualcam.fmi.variables import all_parameters
from dualcam.ssp.system_structure import Component, Value

ADVICE = "if this is meant: an FMU that `dualcam export` makes from a design file is packed as it is"


class JudgedStart(NamedTuple):
    """Sentences about a component."""

    errors: list[str]
    warnings: list[str]


def judged(component: Component, description: ModelDescription) -> JudgedStart:
    """What `dualcam check` finds where the values of a component change an FMU of this project. Errors that
    the FMU has without these values do not count: whoever exported the FMU meant them."""
    if component.members is None:
        return JudgedStart([], [])
    with tempfile.TemporaryDirectory() as folder:
        for name, content in read_members(component.fmu).items():
            if name.startswith(RESOURCES) and name.endswith(".csv"):
                (Path(folder) / Path(name).name).write_bytes(content)
        verdict = check_design(_design(component.fmu, description, Path(folder), component.values))
        errors = verdict.errors
        if errors:
            before = check_design(_design(component.fmu, description, Path(folder), {})).errors
            errors = tuple(one for one in errors if one.kind not in {other.kind for other in before})
    texts = [f"component {component.name!r}: {finding}" for finding in errors]
    return JudgedStart(
        [*texts, ADVICE] if texts else [],
        [f"component {component.name!r}: {finding}" for finding in verdict.warnings],
    )


def _design(
    fmu: Path, description: ModelDescription, folder: Path, values: Mapping[str, Value]
) -> DesignFile:
    """The design of an FMU with these values; its tables are in the folder."""
    known = {variable.name: variable for variable in description.variables}
    start: dict[str, Scalar] = {}
    for name in all_parameters():
        told = known[name].start if name in known else None
        if told is not None:
            start[name] = str(folder / told) if isinstance(told, str) and told else told
    model = "forward" if known["tau"].causality == "input" else "inverse"
    found = [(name, value, unit_warning(name, value)) for name, value in values.items()]
    strange = [Finding("warning", name, value, text, kind="unit") for name, value, text in found if text]
    return DesignFile(fmu, start | dict(values), model, warnings=tuple(strange))
