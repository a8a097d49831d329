"""Paths as arguments of functions, and files that are written wholly or not at all."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path

from dualcam.errors import DualcamError, FileError


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


def near_names(name: str, names: Iterable[str], count: int = 1) -> list[str]:
    """Those of the names of files whose stems are like that of `name`, whatever the endings."""
    stem, known = Path(name).stem, sorted(names)
    stems = get_close_matches(stem, {Path(one).stem for one in known}, n=count, cutoff=0.6)
    return get_close_matches(name, [one for one in known if Path(one).stem in stems], n=count, cutoff=0.0)


def check_picture(path: Path) -> None:
    """DualcamError unless the name ends like one of the kinds of pictures that are written."""
    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise DualcamError(f"{path}: allowed are names that end in .png, .svg or .pdf")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """The name of a file to be written, which becomes `path` at the end of the `with` block. If the block
    fails, it is removed, and a file at `path` stays as it was.

    FileError where the system refuses. A device such as /dev/stdout is written directly."""
    target = path.resolve()
    is_device = target.exists() and not target.is_file()
    unfinished = target if is_device else target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        yield unfinished
        if not is_device:
            unfinished.replace(target)
    except OSError as error:
        raise FileError(error, path) from error
    finally:
        if not is_device:
            unfinished.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a whole file in UTF-8, or none. FileError where the system refuses."""
    with whole_file(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")
