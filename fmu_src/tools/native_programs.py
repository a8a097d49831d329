"""Programs of the tests that are linked with the C code of an FMU: a whole life (tests/native/lifecycle) and
the target of the fuzzer (tests/native/fuzz), each under the sanitizers of a compiler.

Objects of the rooms that all FMUs share are compiled once for a compiler and its options.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from compiler import ZIG, compiler_options, into_place, is_shared, run, sanitizing_compiler
from fmus import Fmu, identity
from platforms import TARGET, executable
from workspace import (
    BUILD,
    CORE,
    ROOT,
    build_program,
    fingerprint,
    headers,
    is_fresh,
    relative,
    say,
    set_stamp,
)

FOLDER = BUILD / "native"
LIFECYCLE, FUZZ = ROOT / "tests/native/lifecycle", ROOT / "tests/native/fuzz"  # sources of test programs
# The compiler may be the system's, whose warnings differ by version: they are switched off here, and on for
# the pinned compiler of the FMUs. -g1 keeps the lines that a sanitizer or valgrind names. With -g1 the
# compiler needs three quarters of the time of -g.
OPTIONS = ("-g1", "-O1", "-w")


@dataclass(frozen=True)
class Toolchain:
    """A compiler, its options for the C code of the FMU, those for the sources of the test program, and what
    is linked besides."""

    name: str
    command: tuple[str, ...]
    of_core: tuple[str, ...] = ()
    of_test: tuple[str, ...] = ()
    linked: tuple[str, ...] = ()

    @property
    def folder(self) -> Path:
        return FOLDER / "parts" / fingerprint([], *self.command, *self.of_core, *self.of_test)[:16]


def sanitized() -> Toolchain:
    """The strictest sanitizers that work on this machine."""
    compiler, flags, name = sanitizing_compiler(FOLDER)
    return Toolchain(name, tuple(compiler), tuple(flags), tuple(flags), tuple(flags))


def plain() -> Toolchain:
    """The same compiler without sanitizers, for valgrind."""
    compiler = sanitizing_compiler(FOLDER)[0]
    return Toolchain("no sanitizer", tuple(compiler if compiler != ZIG else [*ZIG, *TARGET]))


def _object(source: Path, toolchain: Toolchain, fmu: Fmu) -> Path:
    shared, is_test = is_shared(source), CORE not in source.parents
    own = "shared" if shared else f"{fmu.identifier}-{fmu.version}"
    part = toolchain.folder / own / f"{relative(source)}.o"
    options = [*OPTIONS, *(toolchain.of_test if is_test else toolchain.of_core)]
    options += [] if shared else [*fmu.defines, *identity(fmu)]
    used = [source, *headers(), *build_program(), *(source.parent.glob("*.h") if is_test else [])]
    stamp = fingerprint(used, *toolchain.command, *options)
    if not is_fresh(part, stamp):
        part.parent.mkdir(parents=True, exist_ok=True)
        command = [*toolchain.command, *compiler_options(), *options, "-c", relative(source), "-o", str(part)]
        run(command, f"compile {relative(source)}")
        set_stamp(part, stamp)
    return part


def build_test_program(fmu: Fmu, name: str, sources: Sequence[Path], toolchain: Toolchain) -> Path:
    """The program build/native/<name> of the FMU's C code and these sources."""
    program = executable(FOLDER / name)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        parts = list(pool.map(lambda source: _object(source, toolchain, fmu), [*fmu.sources, *sources]))
    stamp = fingerprint([*fmu.sources, *sources, *headers(), *build_program()], str(toolchain), *fmu.defines)
    stamp = fingerprint([], stamp, *(part.with_name(part.name + ".stamp").read_text() for part in parts))
    if not is_fresh(program, stamp):
        say(f"link {relative(program)} ({toolchain.name})")
        into_place([*toolchain.command, *toolchain.linked, *map(str, parts)], program, ["-lm"])
        set_stamp(program, stamp)
    return program


def build_lifecycle(fmu: Fmu, toolchain: Toolchain, suffix: str = "") -> Path:
    """The whole life of an FMU of FMI 2.0."""
    return build_test_program(fmu, f"{fmu.identifier}{suffix}", sorted(LIFECYCLE.glob("*.c")), toolchain)


def fuzz_name(fmu: Fmu) -> str:
    return f"{fmu.identifier}-fmi{fmu.version}"


def build_fuzz_target(fmu: Fmu, toolchain: Toolchain, suffix: str, main: str | None) -> Path:
    """The target of the fuzzer with the file `main`.c of its folder as main program, or with none."""
    mains = ("replay", "driver")
    sources = [path for path in sorted(FUZZ.glob("*.c")) if path.stem == main or path.stem not in mains]
    return build_test_program(fmu, f"{fuzz_name(fmu)}-{suffix}", sources, toolchain)
