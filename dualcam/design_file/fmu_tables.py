"""Tables that a design file names: read, checked, and converted to the FMU's format where needed."""

import hashlib
import os
import re
import sys
import tempfile
from pathlib import Path

from dualcam.common.tables import GROOVE_HEADER, fmu_text
from dualcam.design.groove_files import GrooveFile, read_groove
from dualcam.design_file.friction_tables import FrictionTable, read_friction_table
from dualcam.errors import DesignError


def fmu_groove(path: Path) -> tuple[GrooveFile, Path]:
    """The samples of a groove table, and a file of them that the FMU reads."""
    groove = read_groove(path)
    if groove.is_fmu_format:
        return groove, path
    return groove, _written(path, fmu_text(GROOVE_HEADER, groove.psi, groove.z))


def fmu_friction(path: Path) -> tuple[FrictionTable, Path]:
    """A friction table, and a file of it that the FMU reads."""
    table = read_friction_table(path)
    return table, path if table.is_fmu_format else _written(path, table.fmu_text())


def _written(path: Path, text: str) -> Path:
    """A file of the text, which stands for the table at `path`, in the user's cache folder or in a temporary
    one."""
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    stem = re.sub(r"[^A-Za-z0-9_-]", "_", path.stem)[:40]
    return _cached(f"{stem}-{digest}.csv", text)


def _cached(name: str, text: str) -> Path:
    """A file of that name and text in the first folder that has the file already or can be written."""
    refusals = []
    for folder in _cache_folders():
        path = folder / name
        try:
            if not path.is_file() or path.read_text(encoding="utf-8") != text:
                _write(path, text)
        except (OSError, UnicodeDecodeError) as error:
            refusals.append(str(error))
        else:
            return path
    raise DesignError(
        f"the table cannot be written for the FMU: {'; '.join(refusals)}; give a table in the FMU's format"
    )


def _cache_folders() -> list[Path]:
    """The user's cache folder, where there is one, and a temporary folder of this user."""
    from platformdirs import user_cache_path

    user = os.getuid() if sys.platform != "win32" else "own"  # Windows has one temporary folder for each user
    temporary = Path(tempfile.gettempdir()).resolve() / f"dualcam-{user}" / "tables"
    try:
        usual = user_cache_path("dualcam", appauthor=False) / "tables"
    except RuntimeError:  # the user has no home; older versions of platformdirs give a relative path
        return [temporary]
    return [usual, temporary] if usual.is_absolute() else [temporary]


def _write(path: Path, text: str) -> None:
    """The file appears whole or not at all: other processes may read it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent)
    with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
        file.write(text)
    os.replace(name, path)
