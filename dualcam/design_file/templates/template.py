"""Writes a commented design file to begin with."""

from importlib.resources import files
from pathlib import Path

from dualcam.common.groove_laws import NUMBERS
from dualcam.common.paths import whole_file
from dualcam.errors import DesignError, DualcamError

TEMPLATES = {
    "minimal": "two equal helices, with the FMU's defaults",
    "robot": "the elbow of a robot: a spring carries the arm's weight",
    "knee": "a prosthetic knee: elliptical grooves, spring and damper",
    "door": "the door of a car: friction holds the door where it is let go",
}


def write_template(name: str, path: str | Path, overwrite: bool = False) -> Path:
    """Write a commented design file.

    Parameters
    ----------
    name : Which design: "minimal", "robot", "knee" or "door".
    path : The file to write, such as `my.toml`.
    overwrite : Whether an existing file may be replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    DesignError
        For another name, a file that exists, or no name of a file.
    FileError
        The system refuses to write the file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = write_template("robot", Path(folder) / "my.toml")
    >>> path.name
    'my.toml'
    """
    if name not in TEMPLATES:
        raise DesignError(f"template {name!r}: allowed are {', '.join(TEMPLATES)}")
    path = Path(path)
    text = (files(__package__) / f"{name}.toml").read_text(encoding="utf-8")
    text = text.replace("{groove laws}", ", ".join(f'"{word}"' for word in NUMBERS))
    try:
        if path.exists() and not overwrite:
            raise DesignError(f"{path} exists already: choose another name, or remove the file")
        with whole_file(path) as unfinished:
            unfinished.write_text(text, encoding="utf-8", newline="\n")
    except DualcamError:
        raise
    except (OSError, ValueError) as error:
        raise DesignError(f"{path} cannot be written: {error}") from None
    return path
