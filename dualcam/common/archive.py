"""Zip files, such as FMUs and SSP packages, whose bytes depend on their members alone."""

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path

DATE = (1980, 1, 1, 0, 0, 0)
UNIX = 3  # the system whose permissions are written, on every machine
PROGRAM, FILE = 0o100755, 0o100644  # permissions


def read_members(path: Path) -> dict[str, bytes]:
    """Name -> content of all files in an archive."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}


def write_archive(path: Path, members: Mapping[str, bytes]) -> None:
    """Write an archive, stored: compressed bytes would depend on the version of zlib."""
    path.write_bytes(archive_bytes(members))


def archive_bytes(members: Mapping[str, bytes]) -> bytes:
    """The content of the archive that `write_archive` writes."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for name in sorted(members):
            info = zipfile.ZipInfo(name, date_time=DATE)
            info.create_system = UNIX
            info.external_attr = (PROGRAM if name.startswith("binaries/") else FILE) << 16
            archive.writestr(info, members[name])
    return file.getvalue()
