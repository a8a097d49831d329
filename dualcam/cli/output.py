"""What commands print: text and tables for people, JSON for programs."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dualcam.errors import DualcamError

if TYPE_CHECKING:
    from dualcam.design_file import DesignFile

MARKS = {"error": "x", "warning": "!"}


def say(text: str) -> None:
    click.echo(text)


def say_written(*paths: Path | None) -> None:
    """A line for each file of a result."""
    for path in filter(None, paths):
        say(f"{path} written")


def count(number: int, what: str) -> str:
    """Such as "1 error" or "2 errors"."""
    return f"{number} {what}{'s' if number != 1 else ''}"


def warnings_said() -> list[str]:
    """The warnings of this command so far."""
    context = click.get_current_context(silent=True)
    return [] if context is None else context.meta.setdefault("dualcam.warnings", list[str]())


def warn(text: str) -> None:
    """A warning on stderr; once, also where several parts of a command find the same."""
    said = warnings_said()
    if not any(text in earlier for earlier in said):
        said.append(text)
        click.echo(f"dualcam: warning: {text}", err=True)


def say_where_it_runs(fmu: Path) -> None:
    """A line where the FMU from which others are made runs on this machine's platform alone."""
    from dualcam.fmi.binary import folders_of, is_for_this_platform_alone

    if is_for_this_platform_alone(fmu):
        say(
            f"only for {', '.join(folders_of(fmu))}: the clone was built for this machine. For Linux, "
            "Windows and macOS run ./build.sh run all in the clone and repeat the command, or use the wheel"
        )


def print_json(content: Mapping[str, Any]) -> None:
    """One JSON object. Numbers that JSON has no word for become null."""
    click.echo(json.dumps(_plain(content), indent=2, allow_nan=False))


def refusal_for_json(error: Exception) -> dict[str, Any]:
    """The message of an error, and its findings."""
    findings = [finding.as_dict() for finding in getattr(error, "findings", ())]
    return {"error": str(error), "findings": findings}


def print_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Columns with heads; those of numbers are flush right."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for k, head in enumerate(heads):
        numeric = all(_is_number(row[k]) for row in rows)
        table.add_column(head, justify="right" if numeric else "left", overflow="fold")
    for row in rows:
        table.add_row(*row)
    Console(highlight=False, markup=False).print(table)


def require_folder_of(*paths: Path | None) -> None:
    """DualcamError unless the folder of each file exists, and the path is no folder."""
    for path in filter(None, paths):
        if path.is_dir():
            raise DualcamError(f"{path} is a folder: give the name of a file, such as {path / 'my'}")
        if not path.resolve().parent.is_dir():
            text = f"{path}: the folder {path.parent} does not exist: make the folder, or give another"
            raise DualcamError(text)


def keep_files_of(
    design: DesignFile, *outputs: Path | None, data: Path | None = None, made: Sequence[str] = ()
) -> None:
    """DualcamError if a result would replace the design file, its tables but those `made` anew, or `data`."""
    keys = [f"cam{cam}.{table}" for cam in (1, 2) for table in ("table", "friction_table")]
    tables = (design.value(key) for key in keys if key not in made)
    read = {design.path.resolve(), *(Path(table).resolve() for table in tables if table)}
    for path in filter(None, outputs):
        if path.resolve() in read:
            raise DualcamError(f"{path} belongs to the design {design.path}: give the result another name")
        if data is not None and path.resolve() == data.resolve():
            raise DualcamError(f"{path} is read by this command: give the result another name")


def keep_other_tables(path: Path, *headers: str) -> None:
    """DualcamError if a file of text exists that begins with none of the headers of the command's results."""
    if not path.is_file() or path.suffix.lower() == ".parquet":
        return
    with path.open(encoding="utf-8", errors="replace") as file:
        first = file.readline().strip()
    if first and first not in headers:
        raise DualcamError(
            f"{path} exists, and its first line is not that of this result: give another name, or remove the"
            " file"
        )


def refuse_to_overwrite(path: Path, force: bool) -> None:
    """DualcamError if the file exists and `force` is not given."""
    require_folder_of(path)
    if path.exists() and not force:
        raise DualcamError(f"{path} exists: give another name, or --force to replace the file")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return text in ("", "-")
    return True


def _plain(content: Any) -> Any:  # noqa: ANN401
    if isinstance(content, Mapping):
        return {str(key): _plain(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_plain(value) for value in content]
    if hasattr(content, "tolist"):
        return _plain(content.tolist())
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content if isinstance(content, str | int | float | bool | None) else str(content)
