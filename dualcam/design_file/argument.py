"""Designs as arguments of functions: read already, or as the path of their file."""

from __future__ import annotations

import warnings
from pathlib import Path

from dualcam.design_file.design import DesignFile
from dualcam.design_file.reader import read_design
from dualcam.errors import DesignError, DualcamWarning

DesignSource = DesignFile | str | Path


def as_design(design: DesignSource, shows_findings: bool = False) -> DesignFile:
    """The design of an argument.

    Parameters
    ----------
    design : DesignFile, str or Path
        A design from `read_design`, or the path of a design file.
    shows_findings : bool
        Whether the result of the caller has the warnings of the design. Else the warnings of a file that is
        read here become Python warnings.

    Returns
    -------
    DesignFile
        `design` itself, or the design of the file.

    Raises
    ------
    DesignError
        `design` is something else.
    DesignFileError
        The file is refused.

    Warns
    -----
    DualcamWarning
        For each warning about a file that is read here.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.design_file import write_template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     as_design(write_template("minimal", Path(folder) / "my.toml")).name
    'my'
    """
    if isinstance(design, DesignFile):
        return design
    if not isinstance(design, str | Path):
        raise DesignError(
            f"design {design!r}: allowed is a design from read_design, or the path of a design file"
            " (str or Path)"
        )
    read = read_design(design)
    for finding in () if shows_findings else read.warnings:
        warnings.warn(f"{read.path}: {finding}", DualcamWarning, stacklevel=3)
    return read
