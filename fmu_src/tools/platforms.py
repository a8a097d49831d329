"""The platforms for which the FMUs are built, and how the compiler is called for each.

Every C file is compiled with the same options on every platform. Only the linkers differ.
"""

from __future__ import annotations

import platform
import struct
from dataclasses import dataclass
from pathlib import Path

from workspace import BuildError, place

NEWEST_GLIBC = (2, 17)  # the newest version of the GNU C library that a binary may need
GLIBC = "gnu.{}.{}".format(*NEWEST_GLIBC)
X86_LINUX, ARM_LINUX = f"x86_64-linux-{GLIBC}", f"aarch64-linux-{GLIBC}"
X86_MAC, ARM_MAC = "x86_64-macos.11.0", "aarch64-macos.11.0"
# Windows 10 and newer, where the C library (ucrt) belongs to the system.
X86_WINDOWS, X86_32_WINDOWS = "x86_64-windows-gnu", "x86-windows-gnu"

WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror")
# -ffp-contract=off forbids fused multiply-add: all bits are the same on every processor (./build.sh run
# hash). On 32-bit x86 the baseline of the compiler in zig has SSE2; elementary/elementary.h refuses to
# compile without. -fno-math-errno lets sqrt become one instruction; no code reads errno after a mathematical
# function. All other rules of IEEE 754 hold: -ffast-math would break compensated sums and the tests for NaN.
ARITHMETIC = ("-std=c17", "-ffp-contract=off", "-fno-math-errno")
# The compiler in zig keeps a frame pointer in each function, unless told otherwise. Without frame pointers a
# step takes 1 to 8 % fewer instructions. Debuggers and profilers unwind by tables: .eh_frame on Linux and
# macOS, .pdata on 64-bit Windows.
FRAMES = "-fomit-frame-pointer"
LIBRARY = ("-fPIC", "-fvisibility=hidden", FRAMES)
OPTIMISATION = "-O3"
# Link-time optimisation inlines across files and drops functions that nobody calls. The linker for macOS has
# none. On Windows a binary would grow by a tenth.
LTO = "-flto"
# Without LTO, the linker drops functions that nobody calls where each function has a section of its own.
SECTIONS = ("-ffunction-sections", "-fdata-sections")


@dataclass(frozen=True)
class Platform:
    """One directory below `binaries` of an FMU.

    `folder` is the name of the directory, `targets` are the compiler's names of the processors and systems
    (several: one binary that holds code for each), `version` is the version of FMI, which names the folders.
    """

    folder: str
    targets: tuple[str, ...]
    suffix: str
    version: int = 2

    def library(self, identifier: str) -> Path:
        """The product for the model `identifier`."""
        return place(self.version) / self.folder / f"{identifier}{self.suffix}"

    @property
    def compilation(self) -> list[str]:
        """Options for each C file."""
        return [OPTIMISATION, *LIBRARY, *([LTO] if self.suffix == ".so" else SECTIONS)]

    def linking(self, identifier: str) -> list[str]:
        """Options that make one library from the compiled files."""
        options = [OPTIMISATION, "-shared", "-s"]
        if self.suffix == ".so":  # -z defs: an undefined symbol is an error, as on the other systems anyway
            return [*options, LTO, "-Wl,-z,defs"]
        if self.suffix == ".dylib":  # without this name the binary would hold the path of the product
            return [*options, "-Wl,-dead_strip", f"-Wl,-install_name,@rpath/{identifier}{self.suffix}"]
        return [*options, "-Wl,--gc-sections"]


# FMI 2.0 names linux64, win64, win32 and darwin64 for x86, and since 2.0.4 (section 2.3) aarch64-darwin.
# darwin64 holds ARM too: FMPy 0.3.32 looks there on every Mac.
PLATFORMS = (
    Platform("linux64", (X86_LINUX,), ".so"),
    Platform("aarch64-linux", (ARM_LINUX,), ".so"),
    Platform("win64", (X86_WINDOWS,), ".dll"),
    Platform("win32", (X86_32_WINDOWS,), ".dll"),
    Platform("darwin64", (X86_MAC, ARM_MAC), ".dylib"),
    Platform("aarch64-darwin", (ARM_MAC,), ".dylib"),
)
PLATFORMS_3 = (
    Platform("x86_64-linux", (X86_LINUX,), ".so", 3),
    Platform("aarch64-linux", (ARM_LINUX,), ".so", 3),
    Platform("x86_64-windows", (X86_WINDOWS,), ".dll", 3),
    Platform("x86-windows", (X86_32_WINDOWS,), ".dll", 3),
    Platform("x86_64-darwin", (X86_MAC,), ".dylib", 3),
    Platform("aarch64-darwin", (ARM_MAC,), ".dylib", 3),
)
ALL = {2: PLATFORMS, 3: PLATFORMS_3}

# ---- the machine on which the build runs ----

PROCESSORS = {"amd64": "x86_64", "arm64": "aarch64", "i386": "x86", "i686": "x86"}  # other names of the same
HOST_TARGETS = {
    ("Linux", "x86_64"): X86_LINUX,
    ("Linux", "aarch64"): ARM_LINUX,
    ("Windows", "x86_64"): X86_WINDOWS,
    ("Windows", "x86"): X86_32_WINDOWS,
    ("Darwin", "x86_64"): X86_MAC,
    ("Darwin", "aarch64"): ARM_MAC,
}


def pointer_bits() -> int:
    """32 or 64, of the running Python, which is what loads the FMUs."""
    return 8 * struct.calcsize("P")


def host() -> tuple[str, str]:
    """System and processor of the running Python, as HOST_TARGETS names them."""
    machine = platform.machine().lower()
    processor = PROCESSORS.get(machine, machine)
    if processor == "x86_64" and pointer_bits() == 32:
        processor = "x86"
    return platform.system(), processor


def host_target() -> str | None:
    """The compiler's name of this machine, or None for a machine that no FMU is built for."""
    return HOST_TARGETS.get(host())


def host_platform(version: int = 2) -> Platform:
    """The platform of this machine.

    Raises
    ------
    BuildError
        No FMU is built for this machine.
    """
    target = host_target()
    for candidate in ALL[version]:
        if target in candidate.targets:
            return candidate
    names = ", ".join(" ".join(words) for words in HOST_TARGETS)
    raise BuildError(
        f"no FMU is built for {' '.join(host())}, only for {names}; `build_fmu.py all` builds for these"
    )


def executable(path: Path) -> Path:
    """The file name that a program of this name has on this machine."""
    return path.with_name(path.name + ".exe") if platform.system() == "Windows" else path


def host_options() -> list[str]:
    """Compiles for this machine like the FMUs; for a machine without FMUs, as the compiler chooses."""
    target = host_target()
    return [] if target is None else ["-target", target]


def shared_options() -> list[str]:
    """Compiles and links a library for this machine in one command, for a variant of an FMU."""
    elf = platform.system() == "Linux"
    return [OPTIMISATION, *LIBRARY, "-shared", "-s", *([LTO, "-Wl,-z,defs"] if elf else [])]


TARGET = host_options()
SHARED = shared_options()
