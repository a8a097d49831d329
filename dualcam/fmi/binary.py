"""The binary of an FMU: unpacked, found for this platform, loaded."""

from __future__ import annotations

import _ctypes
import ctypes
import os
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Literal

from dualcam.errors import FmuError
from dualcam.fmi.model_description import Interface, ModelDescription
from dualcam.fmi.platforms import binary_folders, folders_of, library_suffix, platform_tuple

SEARCH_LIBRARY_FOLDER = 0x8  # LOAD_WITH_ALTERED_SEARCH_PATH: libraries beside the FMU's are found (Windows)

Use = Literal["co-simulation", "model exchange"]


def interface_of(path: Path, description: ModelDescription, use: Use) -> Interface:
    """What the FMU can do in a use. FmuError if the FMU has no such use."""
    found = description.co_simulation if use == "co-simulation" else description.model_exchange
    if found is None:
        raise FmuError(f"{path} has no {use}: use an FMU that has, or the handle for its other use")
    return found


class Unpacked:
    """A new folder with an FMU's resources and this platform's binary, which a forked child leaves alone."""

    def __init__(self, path: Path, fmi_major: int) -> None:
        """FmuError if these parts of the FMU are damaged or there is no room."""
        wanted = ("resources/", *(f"binaries/{folder}/" for folder in binary_folders(fmi_major)))
        self._process = os.getpid()
        self.folder = Path(tempfile.mkdtemp(prefix="dualcam_")).resolve()
        try:
            with zipfile.ZipFile(path) as archive:
                names = [name for name in archive.namelist() if name.startswith(wanted)]
                archive.extractall(self.folder, names)
            (self.folder / "resources").mkdir(exist_ok=True)
        except Exception as error:  # zipfile's, zlib's and the system's
            self.delete()
            raise FmuError(f"{path} cannot be unpacked into {self.folder}: {error}") from error

    @property
    def is_own(self) -> bool:
        """Whether this process made the folder."""
        return os.getpid() == self._process

    def delete(self) -> None:
        """Delete the folder, in the process that made it."""
        if self.is_own:
            shutil.rmtree(self.folder, ignore_errors=True)


def library_file(path: Path, directory: Path, interface: Interface, fmi_major: int) -> Path:
    """This platform's library in an unpacked FMU. FmuError if the FMU has none."""
    name = interface.model_identifier + library_suffix()
    folders = binary_folders(fmi_major)
    for folder in folders:
        file = directory / "binaries" / folder / name
        if file.is_file():
            return file
    others = folders_of(path)
    raise FmuError(
        f"{path} has no library for this platform ({platform_tuple()}), no binaries/{folders[0]}/{name}:"
        f" the FMU has {', '.join(others) or 'no binaries at all'}"
    )


def load(kind: type[ctypes.CDLL] | type[ctypes.PyDLL], path: Path, file: Path) -> ctypes.CDLL:
    """The loaded library. FmuError if the system refuses."""
    try:
        return kind(str(file), winmode=SEARCH_LIBRARY_FOLDER)
    except OSError as error:
        raise FmuError(f"{path}: the library cannot be loaded: {error}") from error


def unload(handle: int) -> None:
    """Unload a library that `load` has loaded, by its `_handle`."""
    if sys.platform == "win32":
        _ctypes.FreeLibrary(handle)
    else:
        _ctypes.dlclose(handle)
