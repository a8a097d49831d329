"""Builds the FMUs: variables.def -> modelDescription.xml -> shared library -> .fmu.

    python fmu_src/tools/build_fmu.py             build/DualCamForward.fmu and DualCamInverse.fmu (FMI 2.0), the
                                            same in build/fmi3 (FMI 3.0), and NullFmu.fmu
    python fmu_src/tools/build_fmu.py --all       the same, but all except the last for every platform
    python fmu_src/tools/build_fmu.py --check     as without, but fail if the committed XML is not fresh
    python fmu_src/tools/build_fmu.py --sanitize  the native test drivers, with sanitizers and without

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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import archive
import document

ROOT = Path(__file__).resolve().parent.parent.parent
CORE = ROOT / "fmu_src"
BUILD = ROOT / "build"
DESCRIPTIONS = ROOT / "modelDescription"
LIFECYCLE = ROOT / "tests/native/lifecycle"
BARE = ROOT / "benchmarks/null_fmu"  # FMI 2.0 as small as it can be, also for FMUs that are built elsewhere

NEWEST_GLIBC = (2, 17)
GLIBC = "gnu.{}.{}".format(*NEWEST_GLIBC)
TARGET = ["-target", f"x86_64-linux-{GLIBC}"]
WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror"]
# -ffp-contract=off: no fused multiply-add, so the last digit is the same on every processor.
# -fno-math-errno: nobody reads errno, and sqrt becomes one instruction. Every other IEEE rule stays
# (-ffast-math would let the compiler undo compensated sums and NaN checks).
ARITHMETIC = ["-std=c17", "-ffp-contract=off", "-fno-math-errno"]
# Nobody unwinds through a frame of an FMU: it has no exceptions, and calls a master only to be followed.
NO_TABLES = ("-fno-asynchronous-unwind-tables", "-fno-unwind-tables")
LIBRARY = ["-fPIC", "-fvisibility=hidden"]
LTO = "-flto"  # one concept per file costs no call
# Size is promised, and so is the time of a step and of a run. What is not on their way is compiled for size,
# and apart, so that it is not drawn into what is; what is on it, for speed, with loops unrolled where that
# was measured to matter; what only hands on, or is for steps with events (where unrolling was measured to
# gain nothing), for size, but together with its callers.
FOR_SIZE, FOR_SPEED = "-Os", "-O3"
SMALL = "-fno-unroll-loops"
OUTLINED = ("-mllvm", "-enable-machine-outliner=always")  # what functions have in common becomes one
SECTIONS = ("-ffunction-sections", "-fdata-sections")  # the linker drops what nobody calls
OFF_THE_WAY = {
    *("dependencies", "ode", "groove", "groove_csv", "groove_table", "inverse_derivatives"),
    *("inverse_sensitivity", "jet", "platform", "play", "motion_derivatives", "resources", "sensitivity"),
    *("radau_variation", "step_sensitivity", "taylor"),
}
WITH_LOOPS = {"balance", "linear_slip", "lobatto_step", "lobatto_system", "instance", "step", "radau"}
WITH_EVENTS = {"bernstein", "lu", "radau_system", "radau_edge", "radau_step", "radau_peaks", "step_energy"}
WITH_EVENTS |= {"breakpoint", "step_control", "step_indicator", "event_location"}
HANDING_ON = {"fmi3", "fmi3_unsupported", "fmi3_variables", "model_forward", "model_inverse"}
# On macOS, whose linker knows no -flto, only these are compiled for speed.
NUMERIC = {"balance", "linear_segment", "linear_peaks", "linear_slip", "lobatto_step", "lobatto_system"}
NUMERIC |= {"mechanism", "oscillator"}
# Windows binaries hold a part of the C library: there only these for speed, all others outlined.
NUMERIC_WINDOWS = {"linear_slip", "lobatto_step", "lobatto_system", "oscillator"}
WITH_LOOPS |= {"slip_mode", "balance_rates", "balance_partials"}


@dataclass(frozen=True)
class Platform:
    """Where an FMU runs: its directory in `binaries` and how it is compiled for it."""

    folder: str
    targets: tuple[str, ...]  # several: one binary that holds them all
    suffix: str
    flags: tuple[str, ...]
    version: int = 2  # of FMI: the names of directories differ

    def library(self, identifier: str) -> Path:
        return place(self.version) / self.folder / f"{identifier}{self.suffix}"

    def compilation(self, source: Path) -> list[str]:
        name = source.stem
        if self.suffix == ".dll":
            return self.compilation_for_windows(name)
        if name in OFF_THE_WAY:
            return [FOR_SIZE, *SECTIONS]
        if self.suffix == ".dylib":
            return [*([FOR_SPEED, SMALL] if name in NUMERIC else [FOR_SIZE]), *SECTIONS]
        if name in HANDING_ON | WITH_EVENTS:
            return [FOR_SIZE, LTO]
        return [FOR_SPEED, LTO] if name in WITH_LOOPS else [FOR_SPEED, SMALL, LTO]

    @staticmethod
    def compilation_for_windows(name: str) -> list[str]:
        if name in NUMERIC_WINDOWS:
            return [FOR_SPEED, SMALL, *SECTIONS]
        return [FOR_SIZE, *OUTLINED, *SECTIONS]

    @property
    def library_for(self) -> str:
        """What the functions of the C library that a binary holds itself are compiled for."""
        return FOR_SIZE if self.suffix == ".dll" else FOR_SPEED

    def linking(self, identifier: str) -> list[str]:
        if self.suffix == ".dylib":
            name = f"@rpath/{identifier}{self.suffix}"  # else it is the path of the output
            return ["-Wl,-dead_strip", f"-Wl,-install_name,{name}"]
        # -z defs: an undefined symbol fails here, not in a master (on Windows and macOS it always does)
        return ["-Wl,--gc-sections", *([LTO, "-Wl,-z,defs"] if self.suffix == ".so" else [])]


def place(version: int) -> Path:
    """Where the products for that version of FMI are."""
    return BUILD if version == 2 else BUILD / f"fmi{version}"


# Windows: 10 and newer, where the C library (ucrt) belongs to the system.
WINDOWS = ("-fno-vectorize", "-fno-slp-vectorize", *NO_TABLES)
X86_LINUX, ARM_LINUX = f"x86_64-linux-{GLIBC}", f"aarch64-linux-{GLIBC}"
X86_MAC, ARM_MAC = "x86_64-macos.11.0", "aarch64-macos.11.0"

# FMI 2.0 names linux64, win64, win32 and darwin64. It has no name for Linux on ARM: this one is FMI 3's.
PLATFORMS = (
    Platform("linux64", (X86_LINUX,), ".so", NO_TABLES),
    Platform("aarch64-linux", (ARM_LINUX,), ".so", NO_TABLES),
    Platform("win64", ("x86_64-windows-gnu",), ".dll", WINDOWS),
    Platform("win32", ("x86-windows-gnu",), ".dll", WINDOWS),
    Platform("darwin64", (X86_MAC, ARM_MAC), ".dylib", NO_TABLES),
)
PLATFORMS_3 = (
    Platform("x86_64-linux", (X86_LINUX,), ".so", NO_TABLES, 3),
    Platform("aarch64-linux", (ARM_LINUX,), ".so", NO_TABLES, 3),
    Platform("x86_64-windows", ("x86_64-windows-gnu",), ".dll", WINDOWS, 3),
    Platform("x86_64-darwin", (X86_MAC,), ".dylib", NO_TABLES, 3),
    Platform("aarch64-darwin", (ARM_MAC,), ".dylib", NO_TABLES, 3),
)
ALL = {2: PLATFORMS, 3: PLATFORMS_3}
SHARED = [FOR_SPEED, *LIBRARY, "-shared", "-s", LTO, "-Wl,-z,defs"]  # for a variant of an FMU, in one command
PAGE_BITS = 14  # a memory page of the newest Macs

HOST_SOURCES = {"emit.c", "emit.h", "emit_fmi2.c", "emit_fmi3.c"}  # run while building, not part of an FMU
ONLY_IN = {  # by version of FMI
    2: {"fmi2.c"},
    3: {
        *("fmi3.c", "fmi3_unsupported.c", "fmi3_variables.c"),
        *("dependencies.c", "dependencies.def", "dependencies.h"),
    },
}

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
    version: int = 2  # of FMI

    @property
    def path(self) -> Path:
        return place(self.version) / f"{self.identifier}.fmu"


def say(text: str) -> None:
    print(f"-- {text}", flush=True)


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def fmi_headers() -> Path:
    """The FMI headers, which FMPy's wheel holds. Found without importing FMPy, which takes a second."""
    spec = importlib.util.find_spec("fmpy")
    if spec is None or spec.origin is None:
        raise BuildError("fmpy is not installed: run ./build.sh, or pip install -e .")
    return Path(spec.origin).parent / "c-code"


def model_defines(identifier: str, version: int) -> list[str]:
    return [f"-DMODEL_BUILT=MODEL_{MODELS[identifier].upper()}", f"-DFMI_VERSION={version}"]


def core_files(identifier: str, version: int, suffixes: Sequence[str]) -> list[Path]:
    """The files of that FMU in fmu_src."""
    others = {f"model_{model}.c" for name, model in MODELS.items() if name != identifier} | HOST_SOURCES
    others |= set().union(*(names for v, names in ONLY_IN.items() if v != version))
    files = [p for p in CORE.rglob("*") if p.suffix in suffixes and p.parent.name != "tools"]
    return sorted(p for p in files if p.name not in others)


def core_sources(identifier: str, version: int = 2) -> list[Path]:
    return core_files(identifier, version, [".c"])


def headers() -> list[Path]:
    return [*CORE.rglob("*.h"), *CORE.rglob("*.def"), *BARE.glob("*.h")]


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


@contextmanager
def locked() -> Iterator[None]:
    """Nobody else builds meanwhile: parallel test workers may ask at the same time."""
    BUILD.mkdir(exist_ok=True)
    with (BUILD / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


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


ZIG = [sys.executable, "-m", "ziglang", "cc"]


def compiler_options() -> list[str]:
    return [*WARNINGS, *ARITHMETIC, "-isystem", str(fmi_headers()), "-Ifmu_src"]


def into_place(command: Sequence[str | Path], product: Path, end: Sequence[str] = ()) -> None:
    """Runs a command that writes `product`, under its own name, which gets into some formats; a linker may
    leave other files beside it."""
    product.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=product.parent, prefix=f"{product.name}.") as scratch:
        unfinished = Path(scratch) / product.name
        run([*command, "-o", str(unfinished), *end], f"compile {product.name}")
        unfinished.replace(product)


def compile_c(compiler: Sequence[str], flags: Sequence[str], sources: Iterable[Path], product: Path) -> None:
    inputs = [relative(s) for s in sources]
    into_place([*compiler, *compiler_options(), *flags, *inputs], product, ["-lm"])


def compile_library(
    platform: Platform, target: str, defines: Sequence[str], sources: Sequence[Path], product: Path
) -> None:
    """A shared library, each file optimized for what it is for."""
    folder = product.with_suffix(".parts")
    folder.mkdir(parents=True, exist_ok=True)

    def compile_one(source: Path) -> Path:
        part = folder / f"{source.stem}.o"
        flags = [*LIBRARY, *platform.flags, *platform.compilation(source), *compiler_options(), *defines]
        run([*ZIG, "-target", target, *flags, "-c", relative(source), "-o", part], f"compile {source.name}")
        return part

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        parts = list(pool.map(compile_one, sources))
    options = ["-target", target, platform.library_for, "-shared", "-s", *platform.linking(product.stem)]
    into_place([*ZIG, *options, *map(str, parts)], product, ["-lm"])


def emit_description(identifier: str, version: int, check: bool) -> str:
    """The modelDescription.xml of `identifier`: emitted from variables.def and compared with the committed
    file, which is rewritten (or, with `check`, refused) if it differs."""
    committed = DESCRIPTIONS / ("" if version == 2 else f"fmi{version}") / f"{identifier}.xml"
    files = ("tools/emit.c", f"tools/emit_fmi{version}.c", "fmi/variables.c", "fmi/dependencies.c")
    emitter = [CORE / name for name in files]
    fresh = BUILD / "description" / f"fmi{version}" / committed.name
    names = [source.relative_to(CORE).as_posix() for source in core_sources(identifier, version)]
    defines = model_defines(identifier, version)
    stamp = fingerprint([*emitter, *headers()], *defines, *names)
    if not is_fresh(fresh, stamp):
        say(f"emit {relative(committed)}")
        program = BUILD / "host" / f"emit_{identifier}_{version}"
        compile_c(ZIG, ["-O1", *defines], emitter, program)
        fresh.parent.mkdir(parents=True, exist_ok=True)
        fresh.write_bytes(run([program, *names], "emit").encode())
        set_stamp(fresh, stamp)
    if not committed.exists() or committed.read_bytes() != fresh.read_bytes():
        if check:
            raise BuildError(f"{relative(committed)} is out of date: run ./build.sh and commit it")
        committed.parent.mkdir(exist_ok=True)
        shutil.copyfile(fresh, committed)
        say(f"{relative(committed)} was missing or out of date: rewritten, commit it")
    return committed.read_text(encoding="utf-8")


def dual_cam(identifier: str, check: bool, version: int = 2) -> Fmu:
    description = emit_description(identifier, version, check)
    guid = ET.fromstring(description).attrib["guid" if version == 2 else "instantiationToken"]
    sources, defines = core_sources(identifier, version), model_defines(identifier, version)
    icon = DESCRIPTIONS / "model.png"
    extra = {"documentation/licenses/license.txt": ROOT / "LICENSE", "terminalsAndIcons/icon.png": icon}
    extra |= {"model.png": icon} if version == 2 else {}
    extra |= archive.reference(DESCRIPTIONS, identifier)
    texts = archive.sources(CORE, core_files(identifier, version, [".c", ".h", ".def"])) | {
        "documentation/index.html": document.page(description, DESCRIPTIONS / "reference"),
        "sources/identity.h": archive.identity_header(identifier, MODELS[identifier], guid, version),
        "terminalsAndIcons/terminalsAndIcons.xml": archive.terminals(MODELS[identifier]),
    }
    if version == 3:
        names = [source.relative_to(CORE).as_posix() for source in sources]
        texts["sources/buildDescription.xml"] = archive.build_description(identifier, names)
    return Fmu(identifier, sources, description, guid, extra, texts, defines, version)


def bare_fmu(
    like: Fmu, identifier: str, source: Path, what: str, settings: Mapping[str, float] | None = None
) -> Fmu:
    """An FMU for comparison: `like`'s variables and some more, plain co-simulation without any capability.
    Its value references are handed to the compiler as VR_group_name."""
    guid = hashlib.sha256(like.description.encode()).hexdigest()[:32]
    root = ET.fromstring(like.description)
    root.attrib.update(modelName=identifier, guid=guid, description=what)
    for kind in [*root.findall("ModelExchange"), *root.findall("CoSimulation")]:
        position = list(root).index(kind)
        root.remove(kind)
    root.insert(position, ET.Element("CoSimulation", modelIdentifier=identifier))
    references = {v.attrib["name"]: int(v.attrib["valueReference"]) for v in root.iter("ScalarVariable")}
    for name, start in (settings or {}).items():
        references[name] = 1 + max(references.values())
        variable = ET.Element("ScalarVariable", name=name, valueReference=str(references[name]))
        variable.attrib.update(causality="parameter", variability="fixed")
        ET.SubElement(variable, "Real", start=repr(start))
        next(root.iter("ModelVariables")).append(variable)
    ET.indent(root)
    return Fmu(
        identifier,
        [source],
        '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n",
        guid,
        defines=[
            f"-DVALUE_COUNT={1 + max(references.values())}",
            *(
                f"-DVR_{name.replace('.', '_')}={v}"
                for name, v in references.items()
                if name.isascii() and name.replace(".", "_").isidentifier()
            ),
        ],
    )


def null_fmu(like: Fmu) -> Fmu:
    return bare_fmu(like, "NullFmu", BARE / "null_fmu.c", "Does nothing: what FMI itself costs")


def hand_written_fmu(like: Fmu) -> Fmu:
    """A peer of benchmarks/work_precision.py, built by it."""
    source = ROOT / "benchmarks/hand_written/hand_written.c"
    settings = {"solver.step": 1e-4, "solver.threshold": 1e-3}
    return bare_fmu(like, "HandWritten", source, "Fixed steps of semi-implicit Euler", settings)


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
    defines = [*fmu.defines, *identity(fmu)]
    stamp = fingerprint(
        [*fmu.sources, *headers(), Path(__file__).resolve()], platform.folder, *platform.targets, *defines
    )
    if is_fresh(library, stamp):
        return library
    say(f"compile {relative(library)} ({len(fmu.sources)} files)")
    parts = [BUILD / "parts" / f"fmi{fmu.version}" / target / library.name for target in platform.targets]
    for target, part in zip(platform.targets, parts, strict=True):
        compile_library(platform, target, defines, fmu.sources, part)
        check_glibc(part)
    contents = [part.read_bytes() for part in parts]
    library.parent.mkdir(parents=True, exist_ok=True)
    library.write_bytes(contents[0] if len(contents) == 1 else universal(contents))
    set_stamp(library, stamp)
    return library


def build(fmu: Fmu, for_all: bool = False) -> None:
    """Makes the FMU for this machine or all platforms, unless it is there already, for these or for all."""
    inputs = [*fmu.sources, *fmu.extra.values(), *headers(), Path(__file__).resolve()]
    every = ALL[fmu.version]
    platforms = every if for_all else every[:1]

    def stamp(held: Sequence[Platform]) -> str:
        folders = [platform.folder for platform in held]
        texts = [*fmu.texts, *fmu.texts.values()]
        return fingerprint(inputs, fmu.description, *fmu.defines, *fmu.extra, *texts, *folders)

    if any(is_fresh(fmu.path, stamp(held)) for held in (platforms, every)):
        return
    members = {name: path.read_bytes() for name, path in fmu.extra.items()}
    members |= {name: text.encode() for name, text in fmu.texts.items()}
    members["modelDescription.xml"] = fmu.description.encode()
    for platform in platforms:
        library = build_library(fmu, platform)
        members[f"binaries/{platform.folder}/{library.name}"] = library.read_bytes()
    unfinished = fmu.path.with_suffix(f".{os.getpid()}.fmu")
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
    """tests/native/lifecycle/*.c linked with the FMU's sources: `<identifier>-sanitized`, and `<identifier>`
    for valgrind. Warnings are left to the pinned compiler: those of a system's gcc differ by version."""
    folder, sources = BUILD / "native", [*fmu.sources, *sorted(LIFECYCLE.glob("*.c"))]
    compiler, sanitizers, name = sanitizing_compiler(folder)
    plain = compiler if compiler != ZIG else [*ZIG, *TARGET]
    for program, command, flags in (
        (folder / f"{fmu.identifier}-sanitized", compiler, sanitizers),
        (folder / fmu.identifier, plain, []),
    ):
        flags = ["-g", "-O1", "-w", *flags, *fmu.defines, *identity(fmu)]
        used = [*sources, *sorted(LIFECYCLE.glob("*.h")), *headers(), Path(__file__).resolve()]
        stamp = fingerprint(used, *command, *flags)
        if not is_fresh(program, stamp):
            say(f"compile {relative(program)} ({name if sanitizers[0] in flags else 'no sanitizer'})")
            compile_c(command, flags, sources, program)
            set_stamp(program, stamp)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--all", action="store_true", help="for every platform, not this one only")
    parser.add_argument("--check", action="store_true", help="fail if the committed XML is not fresh")
    parser.add_argument("--sanitize", action="store_true", help="build the native test drivers instead")
    arguments = parser.parse_args()
    try:
        with locked():
            fmus = [dual_cam(name, arguments.check, version) for version in ALL for name in MODELS]
            if arguments.sanitize:
                for fmu in fmus:
                    if fmu.version == 2:
                        build_native_drivers(fmu)
            else:
                for fmu in fmus:
                    build(fmu, arguments.all)
                build(null_fmu(fmus[0]))
    except BuildError as error:
        print(f"build_fmu: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
