"""The archive that is the FMU: a zip file whose bytes depend on its members alone."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

from workspace import BuildError, relative


def write_archive(path: Path, members: Mapping[str, bytes]) -> None:
    """Writes a zip of `members` (name -> content): sorted by name, all of the same date, without owner. The
    members are stored, since the output of deflate depends on the installed version of zlib."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name in sorted(members):
            info = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            info.create_system = 3  # Unix on every machine: the permissions in the next line are Unix's
            info.external_attr = (0o100755 if name.startswith("binaries/") else 0o100644) << 16
            archive.writestr(info, members[name])


def validate(path: Path) -> None:
    """Refuses an FMU in which FMPy finds a fault."""
    from fmpy.validation import validate_fmu

    findings = validate_fmu(str(path))
    if findings:
        raise BuildError(f"{relative(path)} is not a valid FMU:\n" + "\n".join(findings))
