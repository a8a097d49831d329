"""`dualcam info`: the variables of an FMU."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import asdict, astuple
from textwrap import fill
from typing import TYPE_CHECKING

import click

from dualcam.cli.options import as_json, example
from dualcam.cli.output import print_json, print_table, say, warn
from dualcam.errors import UnknownVariableError

if TYPE_CHECKING:
    from dualcam.fmi.model_description import DefaultExperiment, ModelDescription, Variable

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
@click.option("--fmi", type=click.Choice(["2", "3"]), help="FMI version of forward and inverse. Default: 2.")
@click.option("--variables", default="", metavar="TEXT", help="Only variables whose name contains this text.")
@click.option("--all", "shows_all", is_flag=True, help="All variables, with their descriptions.")
@as_json
def command(fmu: str, fmi: str | None, variables: str, shows_all: bool, as_json: bool) -> None:
    """List the variables of an FMU with units, start values and ranges.

    Without --all and --variables: inputs and outputs; of all others names and start values.

    FMU is "forward" (the default), "inverse", or the file of any FMU (FMI 2.0 or 3.0).

    The binary of an FMU of this project holds the start values. Other start values in its
    modelDescription.xml are a warning.
    """
    from dualcam.export.start_block import edited_start_values
    from dualcam.fmi.binary import folders_of
    from dualcam.fmi.library import MODELS, source_path
    from dualcam.fmi.model_description import read_model_description

    if fmi is not None and fmu not in MODELS:
        raise click.UsageError(
            f"--fmi {fmi} with {fmu}: a file says its version itself. Leave out --fmi, or give"
            f" {' or '.join(MODELS)}."
        )
    path = source_path(fmu, None if fmi is None else int(fmi))
    description = read_model_description(path)
    listed = _listed(description, variables)
    edited, platforms = edited_start_values(path, description), folders_of(path)
    if as_json:
        print_json(
            {
                "file": path,
                **_head(description),
                "default_experiment": asdict(description.default_experiment),
                "platforms": platforms,
                "warnings": edited,
                "variables": [asdict(each) for each in listed],
            }
        )
        return
    head = _head(description)
    say(f"{path}\n{head['model']}, FMI {head['fmi']}, {', '.join(head['uses'])}: {description.description}")
    say(f"Platforms: {', '.join(platforms) or 'none, no binaries'}")
    say(f"Default experiment: {_experiment(description.default_experiment)}")
    for text in edited:
        warn(text)
    known = [*GROUPS, *sorted({each.causality for each in listed} - set(GROUPS))]
    for causality in known:
        group = [variable for variable in listed if variable.causality == causality]
        if group:
            say(f"\n{GROUPS.get(causality, causality)}")
            if shows_all or variables or causality in ("input", "output"):
                print_table(("name", "unit", "start", "allowed", "description"), [_row(one) for one in group])
            else:
                say(_short(group))
    if not (shows_all or variables):
        say(
            "\n--all: each variable with unit, start value, range and description. --variables spring: those"
            " with this text in their names."
        )


def _listed(description: ModelDescription, text: str) -> list[Variable]:
    """The variables with the text in their name; an error where there is none."""
    listed = [variable for variable in description.variables if text in variable.name]
    if not listed and text:
        names = [variable.name for variable in description.variables]
        near = difflib.get_close_matches(text, names, n=3, cutoff=0.5)
        guess = f": did you mean {', '.join(near)}?" if near else "; leave out --variables to see all"
        said = f"{description.model_name} has no variable with {text!r} in its name{guess}"
        raise UnknownVariableError(said)
    return listed


def _short(variables: Sequence[Variable]) -> str:
    """Names and start values in lines, those of one group, such as `cam1.`, together."""
    groups: dict[str, list[str]] = {}
    for variable in variables:
        name, start = variable.name, _number(variable.start)
        unit = "" if variable.unit in (None, "", "1") else f"\xa0{variable.unit}"
        text = f"{name}\xa0=\xa0{start}{unit}" if start else name
        groups.setdefault(name.partition(".")[0] if "." in name else "", []).append(text)
    lines = [fill(", ".join(group), 100, subsequent_indent="  ") for group in groups.values()]
    return "\n".join(lines).replace("\xa0", " ")  # where no line may break


def _experiment(experiment: DefaultExperiment) -> str:
    """The given values in words."""
    words = zip(
        ("start", "stop", "step", "tolerance"), astuple(experiment), (" s", " s", " s", ""), strict=True
    )
    return ", ".join(f"{word} {value:g}{unit}" for word, value, unit in words if value is not None) or "none"


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
