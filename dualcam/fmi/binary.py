"""The binary of an FMU: unpacked, found for this platform, loaded."""

import _ctypes
import ctypes
import os
import platform
import shutil
import struct
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Literal

from dualcam.errors import FmuError
from dualcam.fmi.model_description import Interface, ModelDescription

SEARCH_LIBRARY_FOLDER = 0x8  # LOAD_WITH_ALTERED_SEARCH_PATH: libraries beside the FMU's are found (Windows)

Use = Literal["co-simulation", "model exchange"]
PROCESSORS = {"amd64": "x86_64", "x64": "x86_64", "arm64": "aarch64", "i386": "x86", "i686": "x86"}
SYSTEMS = {"linux": "linux", "win32": "windows", "cygwin": "windows", "darwin": "darwin"}
SUFFIXES = {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}
FOLDERS_2 = {
    "x86_64-linux": "linux64", "x86-linux": "linux32",
    "x86_64-windows": "win64", "x86-windows": "win32",
    "x86_64-darwin": "darwin64", "aarch64-darwin": "darwin64",
}  # fmt: skip


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


def platform_tuple() -> str:
    """FMI 3.0's name of the running Python's platform, such as "x86_64-linux"."""
    machine = platform.machine().lower()
    processor = PROCESSORS.get(machine, machine)
    if processor == "x86_64" and struct.calcsize("P") == 4:
        processor = "x86"
    system = next((name for start, name in SYSTEMS.items() if sys.platform.startswith(start)), sys.platform)
    return f"{processor}-{system}"


def binary_folders(fmi_major: int) -> tuple[str, ...]:
    """Folders below `binaries` that can hold this platform's library, the usual one first.

    FMI 2.0 has names of FMI 3.0 for other processors than x86; older FMUs for macOS have `darwin64`."""
    name = platform_tuple()
    return (FOLDERS_2[name], name) if fmi_major == 2 and name in FOLDERS_2 else (name,)


def library_suffix() -> str:
    """The end of a library's file name on this platform."""
    return SUFFIXES.get(platform_tuple().partition("-")[2], ".so")


def folders_of(path: Path) -> list[str]:
    """Names of the folders below `binaries` in an FMU: the platforms for which the FMU has a binary."""
    members = [member.split("/") for member in _members(path)]
    return sorted({parts[1] for parts in members if parts[0] == "binaries" and len(parts) > 2 and parts[2]})


def is_for_this_platform_alone(path: Path) -> bool:
    """Whether an FMU has binaries for the running Python's platform and for no other."""
    own = {*binary_folders(2), *binary_folders(3)}
    return set(folders_of(path)) <= own


def own_binary(path: Path, description: ModelDescription) -> bytes | None:
    """The content of an FMU's library for the running Python's platform; None where the FMU has none."""
    uses = (description.co_simulation, description.model_exchange)
    names = [
        f"binaries/{folder}/{use.model_identifier}{library_suffix()}"
        for folder in binary_folders(description.fmi_major)
        for use in uses
        if use is not None
    ]
    present = set(_members(path))
    name = next((name for name in names if name in present), None)
    if name is None:
        return None
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.read(name)
    except Exception as error:  # zipfile's, zlib's and the system's
        raise FmuError(f"{path}: {name} cannot be read: {error}") from error


def _members(path: Path) -> list[str]:
    with zipfile.ZipFile(path) as archive:
        return archive.namelist()
