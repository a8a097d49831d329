"""Groove tables that a design file names: read, checked, and converted to the FMU's format where needed."""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from pathlib import Path

from dualcam.design.groove_files import HEADER, GrooveFile, read_groove
from dualcam.errors import DesignError


def fmu_table(path: Path) -> tuple[GrooveFile, Path]:
    """The samples of a groove table, and a file of them that the FMU reads.

    A file in the FMU's format is that file itself. Another file stays as it is: its samples are written to
    the user's cache folder, under a name that follows from the samples. DesignError for a file that cannot
    be understood or written."""
    groove = read_groove(path)
    if groove.is_fmu_format:
        return groove, path
    rows = [f"{float(p)!r},{float(z)!r}\n" for p, z in zip(groove.psi, groove.z, strict=True)]
    text = HEADER + "\n" + "".join(rows)
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    stem = re.sub(r"[^A-Za-z0-9_-]", "_", path.stem)[:40]
    converted = _cache_folder() / f"{stem}-{digest}.csv"
    if not converted.is_file() or converted.read_text(encoding="utf-8") != text:
        _write(converted, text)
    return groove, converted


def _cache_folder() -> Path:
    from platformdirs import user_cache_path

    return user_cache_path("dualcam", appauthor=False) / "tables"


def _write(path: Path, text: str) -> None:
    """The file appears whole or not at all: other processes may read it."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent)
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
        os.replace(name, path)
    except OSError as error:
        raise DesignError(
            f"the groove table cannot be written for the FMU: {error}; give a table with the header {HEADER}"
        ) from None
