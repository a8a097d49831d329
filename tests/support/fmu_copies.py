"""Copies of FMUs with other members."""

import re
import zipfile
from collections.abc import Callable
from pathlib import Path


def has_no_binary(name: str) -> bool:
    return not name.startswith("binaries/")


def without(element: str) -> Callable[[bytes], bytes]:
    """Leaves an element out of a description."""

    def edit(description: bytes) -> bytes:
        pattern = rf"<{element}\s.*?</{element}>".encode()
        description, count = re.subn(pattern, b"", description, flags=re.DOTALL)
        assert count == 1
        return description

    return edit


def edited(
    source: Path | str,
    target: Path | str,
    edit: Callable[[bytes], bytes] = lambda description: description,
    keeps: Callable[[str], bool] = lambda name: True,
) -> Path:
    """A copy with modelDescription.xml edited, of the members whose name `keeps` takes."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        for name in filter(keeps, old.namelist()):
            content = old.read(name)
            new.writestr(name, edit(content) if name == "modelDescription.xml" else content)
    return Path(target)
