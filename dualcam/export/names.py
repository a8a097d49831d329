"""Names of an exported FMU: the path of its file, and the identifier of the model in C."""

from __future__ import annotations

import re
from pathlib import Path

from dualcam.common.paths import path_of
from dualcam.errors import ExportError

SUFFIX = ".fmu"


def target_path(path: str | Path) -> Path:
    """The absolute path of the FMU to be written. ExportError for a bad ending, sign or folder."""
    target = path_of(path, "the FMU").expanduser().absolute()
    if target.suffix.lower() != SUFFIX or not target.stem.isprintable():
        raise ExportError(
            f"{str(path)!r}: allowed is a file name that ends in {SUFFIX}, such as MyCam{SUFFIX}"
        )
    try:
        is_folder, has_folder = target.is_dir(), target.parent.is_dir()
    except OSError as error:  # as a name that is too long
        raise ExportError(f"{target} cannot be written: {error.strerror}") from error
    if is_folder:
        raise ExportError(
            f"{target} is a folder: allowed is the name of a file; remove the folder or choose another"
        )
    if not has_folder:
        raise ExportError(
            f"the folder {target.parent} does not exist: create it first, or choose another folder"
        )
    return target


def model_identifier(name: str) -> str:
    """The C identifier of a model: FMI demands one for the names of binaries and functions.

    Parameters
    ----------
    name
        Model name, which may be any text with a letter from a to z or a digit.

    Returns
    -------
    str
        `name`, with "_" instead of each character that is not allowed, and before a digit at the beginning.

    Raises
    ------
    ExportError
        No letter from a to z and no digit is in the name.

    Examples
    --------
    >>> model_identifier("my cam")
    'my_cam'
    """
    if not re.search(r"[A-Za-z0-9]", name):
        raise ExportError(f"name {name!r}: allowed is a name with at least one letter from a to z or digit")
    identifier = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return f"_{identifier}" if identifier[0].isdigit() else identifier
