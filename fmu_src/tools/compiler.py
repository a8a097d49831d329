"""Compiles and links: the C compiler of the `ziglang` wheel, which any machine with Python has."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from platforms import ARITHMETIC, NEWEST_GLIBC, WARNINGS, Platform, executable
from workspace import (
    BUILD,
    CORE,
    ROOT,
    BuildError,
    build_program,
    fingerprint,
    headers,
    is_fresh,
    relative,
    set_stamp,
)

ZIG = [sys.executable, "-m", "ziglang", "cc"]
# The one room of fmu_src whose files depend on the FMU: on its model, its GUID and its version of FMI.
ROOM_OF_THE_FMU = CORE / "fmi"
PAGE_BITS = 14  # the memory pages of the newest Macs have 2^14 bytes


def run(command: Sequence[str | Path], purpose: str) -> str:
    """The standard output of `command`. The command runs in ROOT with relative names of source files, so that
    messages are short and no binary holds a path of this machine."""
    environment = os.environ.copy()
    for name in ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR"):
        environment.setdefault(name, str(BUILD / "zig-cache"))
    words = [str(word) for word in command]
    result = subprocess.run(
        words, cwd=ROOT, env=environment, capture_output=True, text=True, encoding="utf-8", errors="replace"
    )
    if result.returncode != 0:
        raise BuildError(f"{purpose} failed\n{' '.join(words)}\n{result.stdout}{result.stderr}".rstrip())
    sys.stderr.write(result.stderr)
    return result.stdout


def fmi_headers() -> Path:
    """The folder of the FMI headers in FMPy's wheel. FMPy is not imported, which would take a second."""
    spec = importlib.util.find_spec("fmpy")
    if spec is None or spec.origin is None:
        raise BuildError("fmpy is not installed: run ./build.sh, or pip install -e .")
    return Path(spec.origin).parent / "c-code"


def compiler_options() -> list[str]:
    return [*WARNINGS, *ARITHMETIC, "-isystem", str(fmi_headers()), "-Ifmu_src"]


def into_place(command: Sequence[str | Path], product: Path, end: Sequence[str] = ()) -> None:
    """Runs a command that writes `product`, in a scratch folder and under the product's own name: some
    formats hold the name, and a linker may leave other files beside the product."""
    product.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=product.parent, prefix=f"{product.name}.") as scratch:
        unfinished = Path(scratch) / product.name
        run([*command, "-o", unfinished, *end], f"compile {product.name}")
        unfinished.replace(product)


def compile_c(compiler: Sequence[str], flags: Sequence[str], sources: Iterable[Path], product: Path) -> None:
    """Compiles and links `sources` to a program or library, in one command."""
    into_place([*compiler, *compiler_options(), *flags, *map(relative, sources)], product, ["-lm"])


def compile_program(flags: Sequence[str], sources: Iterable[Path], name: str) -> Path:
    """A program that runs on this machine during the build."""
    program = executable(BUILD / "host" / name)
    compile_c(ZIG, flags, sources, program)
    return program


def is_shared(source: Path) -> bool:
    """Is the object of this file the same in all FMUs?"""
    return CORE in source.parents and ROOM_OF_THE_FMU not in source.parents


def compile_library(
    platform: Platform, target: str, defines: Sequence[str], sources: Sequence[Path], product: Path
) -> None:
    """A shared library for one processor, its files compiled in parallel. Objects that all FMUs share are
    compiled for the first FMU, without `defines`, and kept for the others."""
    common = fingerprint([*headers(), *build_program()], target)

    def compile_one(source: Path) -> Path:
        shared = is_shared(source)
        folder = BUILD / "parts/shared" / target if shared else product.with_suffix(".parts")
        part = folder / f"{relative(source)}.o"  # two rooms may have a file of the same name
        stamp = fingerprint([source], common)
        if shared and is_fresh(part, stamp):
            return part
        part.parent.mkdir(parents=True, exist_ok=True)
        options = [*platform.compilation, *compiler_options(), *(() if shared else defines)]
        command = [*ZIG, "-target", target, *options, "-c", relative(source), "-o", str(part)]
        run(command, f"compile {relative(source)}")
        set_stamp(part, stamp)
        return part

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        parts = list(pool.map(compile_one, sources))
    options = ["-target", target, *platform.linking(product.stem)]
    into_place([*ZIG, *options, *map(str, parts)], product, ["-lm"])
    check_glibc(product)


def check_glibc(library: Path) -> None:
    """Refuses a library that needs a newer glibc than NEWEST_GLIBC. A library for Linux holds the versions
    that it needs as plain text in its string table."""
    needed = [tuple(map(int, m.split(b"."))) for m in re.findall(rb"\0GLIBC_([0-9.]+)", library.read_bytes())]
    newer = [version for version in needed if version > NEWEST_GLIBC]
    if newer:
        raise BuildError(f"{library.name} needs GLIBC {max(newer)}, newer than {NEWEST_GLIBC}")


def universal(slices: Sequence[bytes]) -> bytes:
    """One Mach-O file for several processors: a big-endian table of the slices' places, then the slices,
    each at the start of a memory page."""
    page = 1 << PAGE_BITS
    table, body = struct.pack(">II", 0xCAFEBABE, len(slices)), b""
    for content in slices:
        kind, subkind = struct.unpack_from("<II", content, 4)
        body += bytes(-len(body) % page)
        table += struct.pack(">IIIII", kind, subkind, page + len(body), len(content), PAGE_BITS)
        body += content
    return table.ljust(page, b"\0") + body


def sanitizing_compiler(scratch: Path) -> tuple[list[str], list[str], str]:
    """The strictest compiler that works here, its options and its name: a system compiler with
    AddressSanitizer, else zig with UBSan alone (the wheel holds no AddressSanitizer runtime)."""
    scratch.mkdir(parents=True, exist_ok=True)
    probe, program = scratch / "probe.c", executable(scratch / "probe")
    probe.write_text("int main(void) { return 0; }\n", encoding="utf-8")
    flags = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    for compiler in ("gcc", "clang"):
        if shutil.which(compiler) is None:
            continue
        made = subprocess.run([compiler, *flags, str(probe), "-o", str(program)], capture_output=True)
        if made.returncode == 0 and subprocess.run([str(program)], capture_output=True).returncode == 0:
            return [compiler], flags, f"{compiler} address,undefined"
    return ZIG, ["-fsanitize=undefined", "-fno-sanitize-recover=all"], "zig undefined"
