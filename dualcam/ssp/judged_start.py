"""The start values of a cam in a system, judged as commands judge a design file."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import NamedTuple

from dualcam.checking import check_design
from dualcam.checking.rules import EQUAL_RADII
from dualcam.common.unit_guards import unit_warning
from dualcam.design import Limits
from dualcam.design_file import DesignFile, Finding
from dualcam.export.changed import RESOURCES
from dualcam.fmi.model_description import ModelDescription, Scalar
from dualcam.fmi.variables import all_parameters
from dualcam.ssp.system_structure import Component

# A component has no wishes about its cam: self-locking and any lead angle are allowed.
ALL_ALLOWED = Limits(lead_angle=(0.0, 0.5 * math.pi), self_locking=True)


class JudgedStart(NamedTuple):
    """Sentences about a component."""

    errors: list[str]
    warnings: list[str]


def judged(component: Component, description: ModelDescription) -> JudgedStart:
    """What `dualcam check` finds in an FMU of this project, apart from [limits] and equal radii."""
    if component.members is None:
        return JudgedStart([], [])
    with tempfile.TemporaryDirectory() as folder:
        for name, content in component.members.items():
            if name.startswith(RESOURCES) and name.endswith(".csv"):
                (Path(folder) / Path(name).name).write_bytes(content)
        verdict = check_design(_design(component, description, Path(folder)))
    errors, warnings = (
        [f"component {component.name!r}: {finding}" for finding in findings if finding.kind != EQUAL_RADII]
        for findings in (verdict.errors, verdict.warnings)
    )
    return JudgedStart(errors, warnings)


def _design(component: Component, description: ModelDescription, folder: Path) -> DesignFile:
    """The design of a component's FMU with its values; the tables are in the folder."""
    known = {variable.name: variable for variable in description.variables}
    start: dict[str, Scalar] = {}
    for name in all_parameters():
        told = known[name].start if name in known else None
        if told is not None:
            start[name] = str(folder / told) if isinstance(told, str) and told else told
    model = "forward" if known["tau"].causality == "input" else "inverse"
    found = [(name, value, unit_warning(name, value)) for name, value in component.values.items()]
    strange = [Finding("warning", name, value, text, kind="unit") for name, value, text in found if text]
    parameters = start | dict(component.values)
    return DesignFile(component.fmu, parameters, model, limits=ALL_ALLOWED, warnings=tuple(strange))
