"""Builds the FMUs: variables.def -> modelDescription.xml -> shared library -> .fmu.

    python fmu_src/build_fmu.py             build/DualCamForward.fmu, DualCamInverse.fmu and NullFmu.fmu
    python fmu_src/build_fmu.py --all       the same, but the first two for every platform
    python fmu_src/build_fmu.py --check     as without, but fail if the committed XML is not fresh
    python fmu_src/build_fmu.py --sanitize  the native test drivers, with sanitizers and without

The compiler is the one in the `ziglang` wheel, so any machine with Python builds the same binaries, for
all platforms. Nothing is done when no input has changed since the last time.
"""

from __future__ import annotations

import argparse
import fcntl
import hashlib
import importlib.metadata
import importlib.util
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import archive
import document

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build"
DESCRIPTIONS = ROOT / "modelDescription"
LIFECYCLE = ROOT / "tests/native/lifecycle.c"

NEWEST_GLIBC = (2, 17)
GLIBC = "gnu.{}.{}".format(*NEWEST_GLIBC)
TARGET = ["-target", f"x86_64-linux-{GLIBC}"]
WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror"]
# -ffp-contract=off: no fused multiply-add, so the last digit is the same on every processor.
# -fno-math-errno: nobody reads errno, and sqrt becomes one instruction. Every other IEEE rule stays
# (-ffast-math would let the compiler undo compensated sums and NaN checks).
ARITHMETIC = ["-std=c17", "-ffp-contract=off", "-fno-math-errno"]
# -z defs: an undefined symbol fails here, not in a master (on Windows and macOS it always does).
LIBRARY = ["-O3", "-fPIC", "-shared", "-fvisibility=hidden", "-s"]
LTO = "-flto"  # one concept per file costs no call
SMALL = "-fno-unroll-loops"  # a tenth smaller, for the promised size
SMALLER = ("-fno-vectorize", "-fno-slp-vectorize")  # and some more, where that is not enough
LEAN = ("-fno-unwind-tables", "-fno-asynchronous-unwind-tables")  # only C++ exceptions would read them
LINUX = (LTO, *LEAN, "-Wl,-z,defs")
SHARED = [*LIBRARY, *LINUX]


@dataclass(frozen=True)
class Platform:
    """Where an FMU runs: its directory in `binaries` and how it is compiled for it."""

    folder: str
    targets: tuple[str, ...]  # several: one binary that holds them all
    suffix: str
    flags: tuple[str, ...]

    def library(self, identifier: str) -> Path:
        return BUILD / self.folder / f"{identifier}{self.suffix}"


# FMI 2.0 names linux64, win64, win32 and darwin64. It has no name for Linux on ARM: this one is FMI 3's.
# Windows: 10 and newer, where the C library (ucrt) belongs to the system. macOS: its linker knows no -flto.
PLATFORMS = (
    Platform("linux64", (f"x86_64-linux-{GLIBC}",), ".so", LINUX),
    Platform("aarch64-linux", (f"aarch64-linux-{GLIBC}",), ".so", LINUX),
    Platform("win64", ("x86_64-windows-gnu",), ".dll", (LTO, SMALL, *SMALLER)),
    Platform("win32", ("x86-windows-gnu",), ".dll", (LTO, SMALL)),
    Platform("darwin64", ("x86_64-macos.11.0", "aarch64-macos.11.0"), ".dylib", (SMALL,)),
)
HERE = PLATFORMS[:1]
PAGE_BITS = 14  # a memory page of the newest Macs

HOST_SOURCES = {"emit_xml.c"}  # run while building, not part of an FMU

# Both FMUs are compiled from the same files, but for the one that hands the FMI calls on (see model.h).
MODELS = {"DualCamForward": "forward", "DualCamInverse": "inverse"}


class BuildError(Exception):
    pass


@dataclass(frozen=True)
class Fmu:
    """One FMU: what it is compiled from and where its description comes from."""

    identifier: str
    sources: list[Path]
    description: str
    guid: str
    extra: dict[str, Path] = field(default_factory=dict)  # name in the archive -> file
    texts: dict[str, str] = field(default_factory=dict)  # name in the archive -> content made by the build
    defines: list[str] = field(default_factory=list)

    @property
    def path(self) -> Path:
        return BUILD / f"{self.identifier}.fmu"


def say(text: str) -> None:
    print(f"-- {text}", flush=True)


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def fmi_headers() -> Path:
    """The FMI 2.0 headers, which FMPy's wheel holds. Found without importing FMPy, which takes a second."""
    spec = importlib.util.find_spec("fmpy")
    if spec is None or spec.origin is None:
        raise BuildError("fmpy is not installed: run ./build.sh, or pip install -e .")
    return Path(spec.origin).parent / "c-code"


def model_define(identifier: str) -> str:
    return f"-DMODEL_BUILT=MODEL_{MODELS[identifier].upper()}"


def core_sources(identifier: str) -> list[Path]:
    others = {f"model_{model}.c" for name, model in MODELS.items() if name != identifier}
    return sorted(p for p in (ROOT / "fmu_src").glob("*.c") if p.name not in HOST_SOURCES | others)


def headers() -> list[Path]:
    return [*(ROOT / "fmu_src").glob("*.h"), *(ROOT / "fmu_src").glob("*.def")]


def fingerprint(files: Iterable[Path], *words: str) -> str:
    """Hash of everything that a product depends on: files, flags, versions."""
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(f"{relative(path)}\0{path.stat().st_mode & 0o111}\0".encode())
        digest.update(path.read_bytes() + b"\0")
    for word in (*words, *(importlib.metadata.version(p) for p in ("ziglang", "fmpy"))):
        digest.update(f"{word}\0".encode())
    return digest.hexdigest()


def is_fresh(product: Path, stamp: str) -> bool:
    stamp_file = product.with_name(product.name + ".stamp")
    return product.exists() and stamp_file.exists() and stamp_file.read_text() == stamp


def set_stamp(product: Path, stamp: str) -> None:
    product.with_name(product.name + ".stamp").write_text(stamp)


def run(command: Sequence[str | Path], purpose: str) -> str:
    """Runs `command` in ROOT, so that file names in messages are short and none ends up in a binary."""
    environment = os.environ.copy()
    for name in ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR"):
        environment.setdefault(name, str(BUILD / "zig-cache"))
    result = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    if result.returncode != 0:
        words = " ".join(map(str, command))
        raise BuildError(f"{purpose} failed\n{words}\n{result.stdout}{result.stderr}".rstrip())
    sys.stderr.write(result.stderr)
    return result.stdout


def compile_c(compiler: Sequence[str], flags: Sequence[str], sources: Iterable[Path], product: Path) -> None:
    product.parent.mkdir(parents=True, exist_ok=True)
    inputs = [relative(s) for s in sources]
    common = [*WARNINGS, *ARITHMETIC, "-isystem", str(fmi_headers()), "-Ifmu_src"]
    # Under its own name, which gets into some formats; and the linker may leave other files beside it.
    with tempfile.TemporaryDirectory(dir=product.parent, prefix=f"{product.name}.") as scratch:
        unfinished = Path(scratch) / product.name
        run([*compiler, *common, *flags, *inputs, "-o", str(unfinished), "-lm"], f"compile {product.name}")
        unfinished.replace(product)


ZIG = [sys.executable, "-m", "ziglang", "cc"]


def emit_description(identifier: str, check: bool) -> str:
    """The modelDescription.xml of `identifier`: emitted by emit_xml.c from variables.def and compared
    with the committed file, which is rewritten (or, with `check`, refused) if it differs."""
    committed = DESCRIPTIONS / f"{identifier}.xml"
    emitter, included = ROOT / "fmu_src/emit_xml.c", ROOT / "fmu_src/variables.c"
    fresh = BUILD / "description" / committed.name
    names = [source.name for source in core_sources(identifier)]
    stamp = fingerprint([emitter, included, *headers()], *names)
    if not is_fresh(fresh, stamp):
        say(f"emit {relative(committed)}")
        program = BUILD / "host" / f"emit_{identifier}"
        compile_c(ZIG, ["-O1", model_define(identifier)], [emitter], program)
        fresh.parent.mkdir(parents=True, exist_ok=True)
        fresh.write_bytes(run([program, *names], "emit_xml").encode())
        set_stamp(fresh, stamp)
    if not committed.exists() or committed.read_bytes() != fresh.read_bytes():
        if check:
            raise BuildError(f"{relative(committed)} is out of date: run ./build.sh and commit it")
        committed.parent.mkdir(exist_ok=True)
        shutil.copyfile(fresh, committed)
        say(f"{relative(committed)} was missing or out of date: rewritten, commit it")
    return committed.read_text(encoding="utf-8")


def dual_cam(identifier: str, check: bool) -> Fmu:
    description = emit_description(identifier, check)
    guid = ET.fromstring(description).attrib["guid"]
    sources, defines = core_sources(identifier), [model_define(identifier)]
    extra = {"documentation/licenses/license.txt": ROOT / "LICENSE", "model.png": DESCRIPTIONS / "model.png"}
    extra |= archive.sources([*sources, *headers()]) | archive.reference(DESCRIPTIONS, identifier)
    texts = {
        "documentation/index.html": document.page(description, DESCRIPTIONS / "reference"),
        "sources/identity.h": archive.identity_header(identifier, MODELS[identifier], guid),
    }
    return Fmu(identifier, sources, description, guid, extra, texts, defines)


def null_fmu(like: Fmu) -> Fmu:
    """The do-nothing FMU: `like`'s variables, plain co-simulation without any capability."""
    identifier = "NullFmu"
    guid = hashlib.sha256(like.description.encode()).hexdigest()[:32]
    root = ET.fromstring(like.description)
    root.attrib.update(modelName=identifier, guid=guid, description="Does nothing: what FMI itself costs")
    for kind in [*root.findall("ModelExchange"), *root.findall("CoSimulation")]:
        position = list(root).index(kind)
        root.remove(kind)
    root.insert(position, ET.Element("CoSimulation", modelIdentifier=identifier))
    ET.indent(root)
    count = 1 + max(int(v.attrib["valueReference"]) for v in root.iter("ScalarVariable"))
    return Fmu(
        identifier,
        [ROOT / "benchmarks/null_fmu/null_fmu.c"],
        '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n",
        guid,
        defines=[f"-DVALUE_COUNT={count}"],
    )


def check_glibc(library: Path) -> None:
    """Refuses a library that needs a newer glibc than promised. The versions it needs stand as plain
    text in the string table of Linux's."""
    needed = [tuple(map(int, m.split(b"."))) for m in re.findall(rb"\0GLIBC_([0-9.]+)", library.read_bytes())]
    newer = [v for v in needed if v > NEWEST_GLIBC]
    if newer:
        raise BuildError(f"{library.name} needs GLIBC {max(newer)}, newer than {NEWEST_GLIBC}")


def write_archive(path: Path, members: dict[str, bytes]) -> None:
    """A zip that depends on its members alone: sorted, no clock, no owner, and stored, since what
    deflate writes depends on the zlib at hand."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name in sorted(members):
            info = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            info.create_system = 3  # Unix, whatever the host: the permissions below are Unix ones
            info.external_attr = (0o100755 if name.startswith("binaries/") else 0o100644) << 16
            archive.writestr(info, members[name])


def validate(path: Path) -> None:
    from fmpy.validation import validate_fmu

    findings = validate_fmu(str(path))
    if findings:
        raise BuildError(f"{relative(path)} is not a valid FMU:\n" + "\n".join(findings))


def universal(slices: Sequence[bytes]) -> bytes:
    """One Mach-O file for several processors: a table of where each one's is, big-endian, then these, each
    at the start of a memory page."""
    page = 1 << PAGE_BITS
    table, body = struct.pack(">II", 0xCAFEBABE, len(slices)), b""
    for content in slices:
        kind, subkind = struct.unpack_from("<II", content, 4)
        body += bytes(-len(body) % page)
        table += struct.pack(">IIIII", kind, subkind, page + len(body), len(content), PAGE_BITS)
        body += content
    return table.ljust(page, b"\0") + body


def build_library(fmu: Fmu, platform: Platform) -> Path:
    """The binary of `fmu` for `platform`."""
    library = platform.library(fmu.identifier)
    flags = [*LIBRARY, *platform.flags, *fmu.defines, *identity(fmu)]
    if platform.suffix == ".dylib":
        flags.append(f"-Wl,-install_name,@rpath/{library.name}")  # else it is the path of the output
    stamp = fingerprint([*fmu.sources, *headers(), Path(__file__).resolve()], *platform.targets, *flags)
    if is_fresh(library, stamp):
        return library
    say(f"compile {platform.folder}/{library.name} ({len(fmu.sources)} files)")
    parts = [BUILD / "parts" / target / library.name for target in platform.targets]
    for target, part in zip(platform.targets, parts, strict=True):
        compile_c(ZIG, ["-target", target, *flags], fmu.sources, part)
        check_glibc(part)
    contents = [part.read_bytes() for part in parts]
    library.parent.mkdir(parents=True, exist_ok=True)
    library.write_bytes(contents[0] if len(contents) == 1 else universal(contents))
    set_stamp(library, stamp)
    return library


def build(fmu: Fmu, platforms: Sequence[Platform] = HERE) -> None:
    """Makes the FMU for `platforms`, unless it is there already, for these or for all."""
    inputs = [*fmu.sources, *fmu.extra.values(), *headers(), Path(__file__).resolve()]

    def stamp(held: Sequence[Platform]) -> str:
        folders = [platform.folder for platform in held]
        texts = [*fmu.texts, *fmu.texts.values()]
        return fingerprint(inputs, fmu.description, *fmu.defines, *fmu.extra, *texts, *folders)

    if any(is_fresh(fmu.path, stamp(held)) for held in (platforms, PLATFORMS)):
        return
    members = {name: path.read_bytes() for name, path in fmu.extra.items()}
    members |= {name: text.encode() for name, text in fmu.texts.items()}
    members["modelDescription.xml"] = fmu.description.encode()
    for platform in platforms:
        library = build_library(fmu, platform)
        members[f"binaries/{platform.folder}/{library.name}"] = library.read_bytes()
    unfinished = BUILD / f"{fmu.identifier}.{os.getpid()}.fmu"
    try:
        write_archive(unfinished, members)
        validate(unfinished)
        unfinished.replace(fmu.path)
    finally:
        unfinished.unlink(missing_ok=True)
    set_stamp(fmu.path, stamp(platforms))
    say(f"{relative(fmu.path)} ({fmu.path.stat().st_size // 1024} kB, valid)")


def identity(fmu: Fmu) -> list[str]:
    return [f'-DMODEL_GUID="{fmu.guid}"', f"-DMODEL_IDENTIFIER={fmu.identifier}"]


def sanitizing_compiler(scratch: Path) -> tuple[list[str], list[str], str]:
    """The strictest at hand that works: a system compiler with AddressSanitizer, else zig's UBSan (zig
    ships no AddressSanitizer runtime)."""
    probe = scratch / "probe.c"
    scratch.mkdir(parents=True, exist_ok=True)
    probe.write_text("int main(void) { return 0; }\n")
    flags = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    for compiler in ("gcc", "clang"):
        if shutil.which(compiler) is None:
            continue
        program = scratch / "probe"
        made = subprocess.run([compiler, *flags, probe, "-o", program], capture_output=True)
        if made.returncode == 0 and subprocess.run([program], capture_output=True).returncode == 0:
            return [compiler], flags, f"{compiler} address,undefined"
    return ZIG, ["-fsanitize=undefined", "-fno-sanitize-recover=all"], "zig undefined"


def build_native_drivers(fmu: Fmu) -> None:
    """tests/native/lifecycle.c linked with the FMU's sources: `<identifier>-sanitized`, and `<identifier>`
    for valgrind. Warnings are left to the pinned compiler: those of a system's gcc differ by version."""
    folder = BUILD / "native"
    compiler, sanitizers, name = sanitizing_compiler(folder)
    plain = compiler if compiler != ZIG else [*ZIG, *TARGET]
    for program, command, flags in (
        (folder / f"{fmu.identifier}-sanitized", compiler, sanitizers),
        (folder / fmu.identifier, plain, []),
    ):
        flags = ["-g", "-O1", "-w", *flags, *fmu.defines, *identity(fmu)]
        stamp = fingerprint([*fmu.sources, LIFECYCLE, *headers(), Path(__file__).resolve()], *command, *flags)
        if not is_fresh(program, stamp):
            say(f"compile {relative(program)} ({name if sanitizers[0] in flags else 'no sanitizer'})")
            compile_c(command, flags, [*fmu.sources, LIFECYCLE], program)
            set_stamp(program, stamp)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--all", action="store_true", help="for every platform, not this one only")
    parser.add_argument("--check", action="store_true", help="fail if the committed XML is not fresh")
    parser.add_argument("--sanitize", action="store_true", help="build the native test drivers instead")
    arguments = parser.parse_args()
    BUILD.mkdir(exist_ok=True)
    try:
        with (BUILD / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # parallel test workers may ask at the same time
            forward, inverse = (dual_cam(identifier, arguments.check) for identifier in MODELS)
            if arguments.sanitize:
                build_native_drivers(forward)
                build_native_drivers(inverse)
            else:
                build(forward, PLATFORMS if arguments.all else HERE)
                build(inverse, PLATFORMS if arguments.all else HERE)
                build(null_fmu(forward))
    except BuildError as error:
        print(f"build_fmu: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
