"""`dualcam info`: the variables of an FMU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from dualcam.cli.options import as_json, example, fmi_version
from dualcam.cli.output import print_json, print_table, say
from dualcam.errors import DualcamError

if TYPE_CHECKING:
    from dualcam.model_description import ModelDescription, Variable

GROUPS = {
    "input": "Inputs",
    "output": "Outputs",
    "parameter": "Parameters",
    "local": "Local variables, to be read at any time",
}


@click.command(
    epilog=example("dualcam info", "dualcam info inverse", "dualcam info MyCam.fmu --variables spring --json")
)
@click.argument("fmu", default="forward", metavar="[FMU]")
@fmi_version
@click.option("--variables", default="", metavar="TEXT", help="Only variables whose name contains this text.")
@as_json
def command(fmu: str, fmi: str, variables: str, as_json: bool) -> None:
    """List the variables of an FMU with units, start values and ranges.

    FMU is "forward" (the default), "inverse", or the file of any FMU (FMI 2.0 or 3.0).
    """
    from dualcam.library import fmu_path
    from dualcam.model_description import read_model_description

    path = fmu_path(fmu, int(fmi)) if fmu in ("forward", "inverse") else fmu
    description = read_model_description(path)
    listed = [variable for variable in description.variables if variables in variable.name]
    if not listed and description.variables:
        raise DualcamError(f"no variable of {path} has {variables!r} in its name: give a part of a name")
    if as_json:
        print_json({"file": path, **_head(description), "variables": [asdict(each) for each in listed]})
        return
    head = _head(description)
    say(f"{path}\n{head['model']}, FMI {head['fmi']}, {', '.join(head['uses'])}: {description.description}")
    known = [*GROUPS, *sorted({each.causality for each in listed} - set(GROUPS))]
    for causality in known:
        rows = [_row(variable) for variable in listed if variable.causality == causality]
        if rows:
            say(f"\n{GROUPS.get(causality, causality)}")
            print_table(("name", "unit", "start", "allowed", "description"), rows)


def _head(description: ModelDescription) -> dict[str, str | Sequence[str]]:
    uses = {"co-simulation": description.co_simulation, "model exchange": description.model_exchange}
    return {
        "model": description.model_name,
        "fmi": description.fmi_version,
        "uses": [name for name, interface in uses.items() if interface is not None],
        "guid": description.guid,
    }


def _row(variable: Variable) -> tuple[str, ...]:
    text = variable.description + ("; tunable" if variable.variability == "tunable" else "")
    unit = variable.unit or ("" if variable.kind == "real" else variable.kind)
    return variable.name, unit, _number(variable.start), _range(variable), text


def _number(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return "" if value is None else str(value)


def _range(variable: Variable) -> str:
    low, high = _number(variable.min), _number(variable.max)
    if low and high:
        return f"{low} to {high}"
    return f">= {low}" if low else f"<= {high}" if high else ""
