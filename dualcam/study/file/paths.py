"""Files that a plan names, relative to its folder."""

from __future__ import annotations

from pathlib import Path
from zipfile import BadZipFile, ZipFile

from dualcam.common.paths import near_names
from dualcam.errors import DualcamError
from dualcam.fmi.library import source_path


def missing_file(folder: Path, text: str) -> str | None:
    """What to say of a file that is not there: its name, the folder searched, and the nearest name."""
    path = folder / text
    try:
        if path.exists():
            return None
        searched = path.parent.resolve()
        names = [each.name for each in searched.iterdir()] if searched.is_dir() else None
    except (OSError, ValueError) as error:
        return f"the file cannot be read: {error}"
    if names is None:
        return f"there is no folder {searched}"
    close = near_names(path.name, names, 2)
    then = f"did you mean {' or '.join(close)}?" if close else "allowed is a path, relative to the plan"
    return f"there is no file {path.name} in the folder {searched}: {then}"


def is_file_name(text: str) -> bool:
    """Whether a text looks like the name of a file, and not like a name for a law."""
    return bool(Path(text).suffix) and "\n" not in text


def resources_of(fmu: str | Path) -> set[str]:
    """The files in the folder resources of an FMU, which texts may name, too."""
    try:
        with ZipFile(source_path(fmu)) as archive:
            names = archive.namelist()
    except (DualcamError, OSError, BadZipFile):
        return set()
    return {name.removeprefix("resources/") for name in names if name.startswith("resources/")}
