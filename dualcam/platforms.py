"""The folders of an FMU's binaries that suit the running Python."""

from __future__ import annotations

import platform
import struct
import sys

PROCESSORS = {"amd64": "x86_64", "x64": "x86_64", "arm64": "aarch64", "i386": "x86", "i686": "x86"}
SYSTEMS = {"linux": "linux", "win32": "windows", "cygwin": "windows", "darwin": "darwin"}
SUFFIXES = {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}
FOLDERS_2 = {
    "x86_64-linux": "linux64", "x86-linux": "linux32",
    "x86_64-windows": "win64", "x86-windows": "win32",
    "x86_64-darwin": "darwin64", "aarch64-darwin": "darwin64",
}  # fmt: skip


def platform_tuple() -> str:
    """FMI 3.0's name of the running Python's platform, such as "x86_64-linux".

    On Windows and Linux a Python of 32 bits on a processor of 64 bits loads binaries of 32 bits.
    """
    machine = platform.machine().lower()
    processor = PROCESSORS.get(machine, machine)
    if processor == "x86_64" and struct.calcsize("P") == 4:
        processor = "x86"
    system = next((name for start, name in SYSTEMS.items() if sys.platform.startswith(start)), sys.platform)
    return f"{processor}-{system}"


def binary_folders(fmi_major: int) -> tuple[str, ...]:
    """Names of the folders below `binaries` that can hold this platform's library, the usual one first.

    FMI 2.0 has no name for Linux on ARM. FMUs then use FMI 3.0's name.
    """
    name = platform_tuple()
    return (FOLDERS_2[name], name) if fmi_major == 2 and name in FOLDERS_2 else (name,)


def library_suffix() -> str:
    """The end of a library's file name on this platform."""
    return SUFFIXES.get(platform_tuple().partition("-")[2], ".so")
