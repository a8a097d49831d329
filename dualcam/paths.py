"""Paths as arguments of functions."""

from __future__ import annotations

from pathlib import Path

from dualcam.errors import DualcamError


def path_of(path: object, what: str) -> Path:
    """`path` as a Path. DualcamError where `path` is neither a text nor a Path; `what` names the file."""
    if not isinstance(path, str | Path):
        raise DualcamError(f"{what} {path!r}: allowed is the path of a file (str or Path)")
    return Path(path)


def page_path_of(path: object, what: str) -> Path:
    """As `path_of`, for an HTML page. DualcamError also for a name with another ending."""
    page = path_of(path, what)
    if page.suffix.lower() not in (".html", ".htm"):
        raise DualcamError(f"{page}: allowed are names that end in .html")
    return page
