"""`dualcam design`: the groove that makes a wanted torque, and grooves for a workshop."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import click

from dualcam.cli.check import tell_findings
from dualcam.cli.groove_export import GrooveExport, export_options
from dualcam.cli.options import anyway, as_json, design_file, example, judge, output_file
from dualcam.cli.output import count, keep_files_of, print_json, refuse_to_overwrite, say, warn, warnings_said
from dualcam.common.groove_laws import PARAMETERS, TABLE
from dualcam.errors import DesignError, DualcamWarning

if TYPE_CHECKING:
    from dualcam.checking import Verdict
    from dualcam.design import Design, Mechanism
    from dualcam.design_file import DesignFile
    from dualcam.fmi.model_description import Scalar

NUMBER_FIRST = re.compile(r"\s*[+-]?[.,]?\d")
GROOVE2 = ("equal", "given")


@click.command(
    "design",
    epilog=example(
        "dualcam design my.toml --torque 5 -o groove.csv",
        "dualcam design my.toml --torque torque.csv --direction releasing -o groove.csv",
        "dualcam design my.toml --export groove.dxf --export cam.step",
    ),
)
@design_file
@output_file("CSV file for the table of the groove that makes the wanted torque.", required=False)
@click.option(
    "--torque",
    metavar="N.m|FILE.csv",
    help="Wanted torque: a number in N.m, or with its unit as '6 N.m'; or a CSV file with a header such as"
    " theta_deg,torque_Nm and 4 or more rows.",
)
@click.option(
    "--direction",
    type=click.Choice(["loading", "releasing", "frictionless"]),
    default="loading",
    show_default=True,
    help="In which direction the mechanism makes this torque.",
)
@click.option(
    "--groove2",
    type=click.Choice(GROOVE2),
    help="equal: both grooves become the same, the default if the radii are equal. given: groove 2 is that of"
    " the design file, the default if not.",
)
@export_options
@click.option("--force", is_flag=True, help="Replace existing files.")
@anyway
@as_json
def command(
    design_file: Path,
    output: Path | None,
    torque: str | None,
    direction: str,
    groove2: str | None,
    force: bool,
    anyway: bool,
    as_json: bool,
    **export: Any,  # noqa: ANN401
) -> None:
    """Find the groove that makes a wanted torque, all friction included; or cut grooves.

    With --torque: spring, friction, radius and the upper stop are those of the design file. The command
    writes the table of the groove and prints the lines that put the table into the design file. Then the
    command prints what `dualcam check` finds in the design with this groove; findings do not change the exit
    code, and only --export refuses such a design.

    With --export: the command writes the path of the pin and the flanks of both grooves for a workshop. The
    grooves are those of the design file, or those for the wanted torque.
    """
    from dualcam.design_file import read_design

    exported = GrooveExport.from_options(**export)
    if torque is None and not exported.files:
        raise click.UsageError(
            "nothing to do: give --torque and --output for a groove that makes a torque, or --export for the"
            " grooves of the design file"
        )
    if (output is None) != (torque is None) and not (torque and exported.files):
        text = "-o is the table of a groove for a wanted torque: give --torque and --output together"
        raise click.UsageError(text)
    if output is not None:
        refuse_to_overwrite(output, force)
    exported.prepare(force)
    design = read_design(design_file)
    given = design.mechanism()
    keeps_groove2 = _keeps_groove2(given, groove2)
    cams = (1,) if keeps_groove2 else (1, 2)
    wanted = None if torque is None else _wanted(torque)
    made = [] if wanted is None else [f"cam{cam}.table" for cam in cams]
    data = wanted if isinstance(wanted, Path) else None
    keep_files_of(design, output, *exported.written_files, data=data, made=made)
    found = None if wanted is None else _designed(given, wanted, direction, keeps_groove2)
    doubts = tuple(warnings_said())
    with _with_groove(design, found, cams) as judged:
        if exported.files:
            judge(judged, anyway, as_json)
        verdict = None if exported.files else _verdict(judged)
    mechanism = given if found is None else found.mechanism
    files = exported.write(design, mechanism)
    if found is not None and output is not None:
        found.table.write(output)
    if as_json:
        designed = {} if found is None else _facts(found, output, cams)
        if verdict is not None:
            designed |= {"good": verdict.good, "findings": [one.as_dict() for one in verdict.findings]}
        print_json({**designed, "files": files} if exported.files else designed)
        return
    if found is not None:
        say(found.summary())
    if output is not None:
        _say_how_to_use(output, design, cams)
    if files:
        exported.say_written(design, mechanism)
    if verdict is not None:
        _tell(verdict, design_file)
        for doubt in doubts:
            say(f"But first clear up this warning: {doubt}")


def _verdict(design: DesignFile) -> Verdict:
    """Of `dualcam check`, without the warnings of the file, which are said here."""
    from dualcam.checking import check_design

    for warning in design.warnings:
        warn(f"{design.path}: {warning}")
    verdict = check_design(design)
    # the cams of a new groove are not swapped
    others = tuple(one for one in verdict.findings if one not in design.warnings and one.kind != "swapped")
    return replace(verdict, findings=others)


def _tell(verdict: Verdict, design_file: Path) -> None:
    if not verdict.findings and verdict.good:
        say(f"{design_file} with this groove works: `dualcam check` finds nothing")
        return
    tell_findings(verdict)
    works = "works" if verdict.good else "does not work"
    numbers = [(len(verdict.errors), "error"), (len(verdict.warnings), "warning")]
    counted = " and ".join(count(number, what) for number, what in numbers if number)
    say(f"{design_file} with this groove {works}: `dualcam check` finds {counted}")


@contextmanager
def _with_groove(design: DesignFile, found: Design | None, cams: tuple[int, ...]) -> Iterator[DesignFile]:
    """The design with the table of a new groove, as long as the context lasts; else the design itself."""
    if found is None:
        yield design
        return
    with TemporaryDirectory() as folder:
        table = Path(folder) / "groove.csv"
        found.table.write(table)
        groove: dict[str, Scalar] = {"profile": TABLE.number, "table": str(table)}
        new = {f"cam{cam}.{key}": value for cam in cams for key, value in groove.items()}
        yield replace(design, parameters=design.parameters | new)


def _facts(found: Design, table: Path | None, cams: tuple[int, ...]) -> dict[str, Any]:
    """The result of a design as plain data."""
    band = found.torque_band()
    return {
        "table": table,
        "cams": cams,
        "samples": len(found.table.psi),
        "largest_error": found.largest_error,
        "self_locking": band.self_locking,
        "jams": band.jams,
    }


def _say_how_to_use(table: Path, design: DesignFile, cams: tuple[int, ...]) -> None:
    tables = " and ".join(f"[cam{cam}]" for cam in cams)
    others = (name for name in PARAMETERS if name not in TABLE.parameters)
    given = [name for name in others if any(f"cam{cam}.{name}" in design.parameters for cam in cams)]
    lines = f"{', '.join(['profile', *given])} and table"
    say(f"{table} written. Replace the lines {lines} in your {tables} of {design.path}:")
    for cam in cams:
        say(f'[cam{cam}]\nprofile = "table"\ntable = "{_path_from(design.path, table)}"')


def _path_from(design_file: Path, table: Path) -> str:
    """The table's path for the design file, which counts relative paths from its own folder."""
    if table.is_absolute():
        return table.as_posix()
    target, folder = table.resolve(), design_file.resolve().parent
    try:
        return Path(os.path.relpath(target, folder)).as_posix()
    except ValueError:  # on another drive of Windows
        return target.as_posix()


def _keeps_groove2(mechanism: Mechanism, groove2: str | None) -> bool:
    """Whether groove 2 is that of the design file. DesignError for equal grooves of unequal radii."""
    radius1, radius2 = mechanism.radius
    if groove2 == "equal" and radius1 != radius2:
        raise DesignError(
            f"cam1.radius = {radius1:g} m, cam2.radius = {radius2:g} m: equal grooves need equal radii; or"
            " give --groove2 given"
        )
    return groove2 == "given" or radius1 != radius2


def _designed(mechanism: Mechanism, wanted: float | Path, direction: str, keeps_groove2: bool) -> Design:
    from dualcam.design import design_groove

    if mechanism.lower < 0.0:
        raise DesignError(
            f"stop.lower = {mechanism.lower:.6g} rad: allowed is 0 or more with --torque, since the groove"
            " begins at theta = 0"
        )
    if any(mechanism.load_laws):
        mu1, mu2 = mechanism.friction
        text = f"the groove takes friction {mu1:.4g} and {mu2:.4g}, without the dependence on the load"
        warnings.warn(text, DualcamWarning, stacklevel=1)
    return design_groove(
        wanted,
        mechanism.spring,
        mechanism.upper,
        direction=direction,
        groove2=mechanism.grooves[1] if keeps_groove2 else None,
        friction=mechanism.friction,
        radius=mechanism.radius[0],
        contacts=mechanism.contacts,
    )


def _wanted(torque: str) -> float | Path:
    """A torque in N.m, or the path of a file."""
    try:
        return float(torque)
    except ValueError:
        path = Path(torque)
    if path.suffix.lower() in (".csv", ".txt", ".tsv") or path.exists() or not NUMBER_FIRST.match(torque):
        return path
    from dualcam.common.written_units import quantity

    if re.fullmatch(r"[+-]?\d+,\d+", torque.strip()):
        raise DesignError(f"--torque {torque}: a decimal comma: write {torque.replace(',', '.')}")
    try:
        return quantity(torque, "N.m")
    except DesignError as error:
        raise DesignError(f'--torque "{torque}": {error}; or give a CSV file') from None
