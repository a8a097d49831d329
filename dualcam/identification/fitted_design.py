"""The design file with fitted values: the other lines, with their comments, stay."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dualcam.checking import check_design
from dualcam.common.paths import path_of, write_text
from dualcam.design_file import read_design
from dualcam.design_file.toml_text import ENTRY, HEADER, line_of, lines_of_keys, read_text
from dualcam.errors import DualcamError, IdentificationError
from dualcam.identification.doubts import recording_faults
from dualcam.identification.result import OPEN
from dualcam.identification.unknowns import GROUPS

if TYPE_CHECKING:
    from dualcam.identification.result import Fit, FittedParameter


def write_fitted(found: Fit, path: str | Path) -> Path:
    """Write the design file with the fitted values to `path`; relative paths of groove tables count from its
    folder. IdentificationError or DesignFileError for what must not be written."""
    path = path_of(path, "the fitted design")
    source = found.design.path
    if path.resolve() == source.resolve():
        raise IdentificationError(f"{path} is the design of the start values: give another name")
    if faults := recording_faults(found):
        raise IdentificationError(f"{path} is not written. {faults[0]}")
    existing = path.read_bytes() if path.exists() else None
    write_text(path, _text(found, read_text(source)))
    try:
        _check(found, path)
    except DualcamError:
        if existing is None:
            path.unlink()
        else:
            path.write_bytes(existing)
        raise
    return path


def _text(found: Fit, text: str) -> str:
    """The text of the design file, with the lines of fitted values replaced or added."""
    for parameter in found.parameters:
        for key in parameter.keys:
            text = _with_value(text, key, _line(key, parameter, found))
    return text


def _line(key: str, parameter: FittedParameter, found: Fit) -> str:
    """A line of the file. The number is the shortest that reads as the fitted value again."""
    name = key.rpartition(".")[2]
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    if parameter.status == OPEN:
        value = found.design.value(key)
        source = found.recording.source
        return f"{name} = {value!r}  # start value: not determined by the recording {source}"
    doubt = f"{parameter.interval}{unit}"
    return f"{name} = {parameter.value!r}  # identified from {found.recording.source}, 95 %: {doubt}"


def _with_value(text: str, key: str, line: str) -> str:
    group, _, _ = key.partition(".")
    known = lines_of_keys(text)
    lines = text.split("\n")
    place = known.get(tuple(key.split(".")))
    if place is not None and (entry := ENTRY.match(lines[place - 1])):
        indent = lines[place - 1][: len(lines[place - 1]) - len(lines[place - 1].lstrip())]
        prefix = entry[1].rpartition(".")[0]
        lines[place - 1] = f"{indent}{prefix}.{line}" if prefix else indent + line
        return "\n".join(lines)
    table = known.get((group,))
    if table is None:
        return "\n".join([text.rstrip("\n"), "", f"[{group}]", line, ""])
    if not HEADER.match(lines[table - 1]):
        raise IdentificationError(
            f"line {line_of(known, (group,))}, {lines[table - 1].strip()[:60]!r}: allowed is a table"
            f" [{group}] with one key per line, into which the fitted values can be written"
        )
    return "\n".join([*lines[:table], line, *lines[table:]])


def _check(found: Fit, path: Path) -> None:
    """An error unless the written file has the fitted values, and the others of the design."""
    design = read_design(path)
    read = design.parameters
    fitted = {
        key: found.design.value(key) if one.status == OPEN else one.value
        for one in found.parameters
        for key in one.keys
    }
    wanted = found.design.parameters | fitted
    different = [key for key in wanted if read.get(key) != wanted[key]]
    if different:
        raise IdentificationError(
            f"{path}: {', '.join(different)} would not be read as fitted: write each of the tables"
            f" {', '.join(GROUPS)} with one key per line, and the new file into the folder of"
            f" {found.design.path}"
        )
    if check_design(found.design).good and not (verdict := check_design(design)).good:
        raise IdentificationError(
            f"{path} is not written: `dualcam check` would refuse the fitted values: {verdict.errors[0]}"
        )
