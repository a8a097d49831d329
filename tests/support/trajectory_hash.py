"""One trajectory on every platform: the same scenes in programs for many platforms, one hash of all bits.

    ./build.sh run hash [--quick] [word ...]

The program tests/native/hash plays the scenes of tests/native/lifecycle with both FMUs and prints a hash of
every bit of every output, scene by scene. This module compiles the program with the C code of the FMUs, by
several compilers and at several optimisations, or with a loader of the FMUs' binaries, runs each build and
compares. What a machine lacks (a compiler, an emulator, the binary of a platform) is reported.
"""

from __future__ import annotations

import hashlib
import math
import os
import platform as machine
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from decimal import ROUND_DOWN, ROUND_UP, Context, Decimal, getcontext
from pathlib import Path

import build_fmu
import platforms
import web_build
from compiler import ZIG, compile_library, compiler_options, is_shared, run
from driver import ROOT, Model, models
from fmus import Fmu, identity
from platforms import LTO, OPTIMISATION
from workspace import BUILD, build_program, fingerprint, headers, is_fresh, relative, set_stamp

NATIVE = ROOT / "tests/native"
SCENES = [NATIVE / f"lifecycle/{name}.c" for name in ("run", "scenes", "support")]
PROGRAM, LOADER = NATIVE / "hash/hash.c", NATIVE / "hash/loaded.c"
MEMORY_OF_32_BITS = NATIVE / "hash/memory_of_32_bits.c"
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
X86, ARM, WINDOWS, WINDOWS_32, WASM = "x86-64", "aarch64", "Windows", "Windows, 32 bits", "WebAssembly"
X86_32 = "x86, 32 bits"  # of the same instructions as WINDOWS_32, and of as badly aligned memory
TARGETS = {
    X86: platforms.X86_LINUX,
    X86_32: "x86-linux-musl",
    ARM: platforms.ARM_LINUX,
    WINDOWS: platforms.X86_WINDOWS,
    WINDOWS_32: platforms.X86_32_WINDOWS,
    WASM: web_build.WASM,
}
FOLDERS = {X86: "linux64", ARM: "aarch64-linux", WINDOWS: "win64", WINDOWS_32: "win32"}  # of FMI 2.0
DIGITS = 55
LEVELS = ("-O0", "-O2", "-O3")


class Missing(Exception):
    """What this machine lacks for a build or a run."""


@dataclass(frozen=True)
class Build:
    """`make(fmu)` gives the program, `run(program, model, tables)` its output. Both may raise Missing."""

    platform: str
    compiler: str
    make: Callable[[Fmu], Path]
    run: Callable[[Path, Model, Path], str]

    @property
    def name(self) -> str:
        return f"{self.platform}, {self.compiler}"


# ---- tables ----


def half_way(value: float, k: int) -> str:
    """The number half-way between `value` and the next double, or its first DIGITS digits, up or down by k.

    A reader of numbers must look at the last digit to round right."""
    if value == 0.0:
        return "0"
    middle = (Decimal(value) + Decimal(math.nextafter(value, math.inf))) / 2
    return f"{Context(DIGITS, (ROUND_DOWN, ROUND_UP)[k % 2]).plus(middle):f}"


def write_tables(folder: Path) -> None:
    """The tables of the scenes of tests/native/lifecycle; the positions lie half-way between doubles."""
    getcontext().prec = 200
    for name, slope, bend in (("one.csv", 0.02, 1e-4), ("two.csv", 0.021, -2e-4)):
        rows = []
        for k in range(-20, 21):
            z = slope * 0.1 * k + bend * 0.01 * k * k
            rows.append(f"{0.1 * k!r},{half_way(z, k)}")
        (folder / name).write_text("\n".join(["psi_rad,z_m", *rows]) + "\n")
    (folder / "speed.csv").write_text("v_m_s,mu\n0,0.2\n0.005,0.17\n0.02,0.12\n0.1,0.115\n0.2,0.13\n")
    rows = ["0,50,0.2", "0.02,50,0.15", "0.2,50,0.14", "0,200,0.17", "0.02,200,0.13", "0.2,200,0.12"]
    (folder / "load.csv").write_text("\n".join(["v_m_s,R_N,mu", *rows]) + "\n")


# ---- programs ----


def programs_folder(label: str) -> Path:
    return BUILD / "hash" / "".join(c if c.isalnum() else "-" for c in label)


class WebProgram(web_build.WebAssembly):
    """A program of the same objects as the module for a page."""

    def linking(self, identifier: str) -> list[str]:
        del identifier
        return [OPTIMISATION, LTO]


def with_objects_of_the_page(fmu: Fmu) -> Path:
    """The pinned compiler at the page's optimisation. Objects of the page's modules are used again."""
    program = programs_folder("WebAssembly fmu") / f"{fmu.identifier}.exe"
    sources, defines = [*fmu.sources, *SCENES, PROGRAM], [*fmu.defines, *identity(fmu)]
    stamp = fingerprint([*sources, *headers(), *build_program()], web_build.WASM, *defines)
    if not is_fresh(program, stamp):
        platform = WebProgram("hash", (web_build.WASM,), ".wasm")
        compile_library(platform, web_build.WASM, defines, sources, program)
        set_stamp(program, stamp)
    return program


def compiled(
    platform: str, label: str, command: Sequence[str] | None, flags: Sequence[str]
) -> Callable[[Fmu], Path]:
    """A build from the sources alone; `command` None: the compiler is missing."""

    def make(fmu: Fmu) -> Path:
        if command is None:
            raise Missing(f"{label} is not installed")
        folder = programs_folder(f"{platform} {label} {' '.join(flags)}")
        program = folder / f"{fmu.identifier}.exe"
        memory = [MEMORY_OF_32_BITS] if platform == X86_32 else []
        sources, own = [*fmu.sources, *SCENES, PROGRAM, *memory], [*fmu.defines, *identity(fmu)]
        options = [*command, *compiler_options(), "-w", *flags]

        def compile_one(source: Path) -> Path:
            shared = is_shared(source)
            part = folder / ("core" if shared else fmu.identifier) / f"{relative(source)}.o"
            stamp = fingerprint([source, *headers()], *options, *(() if shared else own))
            if not is_fresh(part, stamp):
                part.parent.mkdir(parents=True, exist_ok=True)
                words = [*options, *(() if shared else own), "-c", relative(source), "-o", str(part)]
                run(words, f"compile {relative(source)}")
                set_stamp(part, stamp)
            return part

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            parts = list(pool.map(compile_one, sources))
        run([*command, *flags, *map(str, parts), "-lm", "-o", str(program)], f"link {program.name}")
        return program

    return make


def with_binary(platform: str) -> Callable[[Fmu], Path]:
    """The loader, for the binary of the FMU that the build of all FMUs has made."""

    def make(fmu: Fmu) -> Path:
        if not binary_of(platform, fmu.identifier).exists():
            raise Missing("the binary is not built: ./build.sh run all")
        program = programs_folder(f"{platform} loader") / f"{fmu.identifier}.exe"
        flags = [
            "-O1",
            "-target",
            TARGETS[platform],
            *identity(fmu),
            *(["-ldl"] if "linux" in TARGETS[platform] else []),
        ]
        sources = [*SCENES, PROGRAM, LOADER]
        stamp = fingerprint([*sources, NATIVE / "library.h", *headers()], *flags)
        if not is_fresh(program, stamp):
            build_fmu.compile_c(ZIG, flags, sources, program)
            set_stamp(program, stamp)
        return program

    return make


def binary_of(platform: str, identifier: str) -> Path:
    folder = next(p for p in platforms.PLATFORMS if p.folder == FOLDERS[platform])
    return folder.library(identifier)


# ---- runs ----


def words_for(model: Model) -> list[str]:
    """The value references, for the command line of the program."""
    variables = model.variables.values()
    usual = ("mode", "theta", "omega", "alpha", "tau")
    words = [f"{v.name}={v.reference}" for v in variables if v.causality in ("parameter", "input")]
    words += [f"{name}={model.variables[name].reference}" for name in usual]
    seen = [v for v in variables if v.causality in ("output", "local", "calculatedParameter")]
    words += [f"real={v.reference}" for v in seen if v.type == "Real"]
    return words + [f"integer={v.reference}" for v in seen if v.type == "Integer"]


def emulator(platform: str) -> list[str]:
    """The words before the program's; raises Missing."""
    if platform == X86 or (platform == X86_32 and machine.machine() in ("x86_64", "AMD64")):
        return []
    if platform == X86_32:
        raise Missing("the processor is another")
    if platform == ARM:
        found = shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static")
        if found is None or not ARM_LIBRARIES.is_dir():
            raise Missing("qemu-aarch64 is not installed (Debian: qemu-user, libc6-arm64-cross)")
        return [found, "-L", str(ARM_LIBRARIES)]
    names = ("wine", "wine64") if platform == WINDOWS else ("wine",)
    found = next((path for name in names if (path := shutil.which(name))), None)
    if found is None:
        raise Missing("wine is not installed (Debian: wine)")
    return [found]


def in_process(platform: str, loads: bool = False) -> Callable[[Path, Model, Path], str]:
    def play(program: Path, model: Model, tables: Path) -> str:
        prefix, root = emulator(platform), "Z:" if platform in (WINDOWS, WINDOWS_32) else ""
        prepared = BUILD / "hash" / f"wine of {FOLDERS.get(platform)}"
        environment = {**os.environ, "WINEPREFIX": str(prepared), "WINEDEBUG": "-all"}
        if loads:
            environment["FMU_BINARY"] = f"{root}{binary_of(platform, model.identifier)}"
        directory = f"/{root}{tables}" if root else str(tables)
        words = [*prefix, str(program), directory, *words_for(model)]
        try:
            done = subprocess.run(words, capture_output=True, text=True, env=environment, timeout=600)
        except OSError as error:  # a Linux without 32-bit programs
            raise Missing(f"this system does not run the program: {error}") from error
        if done.returncode != 0:
            raise RuntimeError(
                f"exit {done.returncode} of {program}\n{done.stdout[-500:]}{done.stderr[-2000:]}"
            )
        return done.stdout

    return play


def in_wasmtime(program: Path, model: Model, tables: Path) -> str:
    try:
        import wasmtime
    except ImportError as error:
        raise Missing("wasmtime is not installed: pip install -e '.[test]'") from error
    with tempfile.TemporaryDirectory() as folder:
        output, errors = Path(folder, "output"), Path(folder, "errors")
        engine = wasmtime.Engine()
        store, linker, configuration = wasmtime.Store(engine), wasmtime.Linker(engine), wasmtime.WasiConfig()
        configuration.argv = ["hash", "/tables", *words_for(model)]
        configuration.preopen_dir(str(tables), "/tables")
        configuration.stdout_file, configuration.stderr_file = str(output), str(errors)
        linker.define_wasi()
        store.set_wasi(configuration)
        instance = linker.instantiate(store, wasmtime.Module.from_file(engine, str(program)))
        try:
            instance.exports(store)["_start"](store)
        except wasmtime.ExitTrap as end:
            if end.code != 0:
                raise RuntimeError(f"exit {end.code} of {program}\n{errors.read_text()}") from end
        return output.read_text()


NODE = """
const { WASI } = require("node:wasi"), fs = require("node:fs");
const [program, tables, ...words] = process.argv.slice(1);
const args = ["hash", "/tables", ...words], preopens = { "/tables": tables };
const wasi = new WASI({ version: "preview1", args, preopens });
const made = WebAssembly.instantiate(fs.readFileSync(program), wasi.getImportObject());
made.then(({ instance }) => wasi.start(instance));
"""


def in_node(program: Path, model: Model, tables: Path) -> str:
    node = shutil.which("node")
    if node is None:
        raise Missing("node is not installed (Debian: nodejs)")
    words = [node, "--no-warnings", "-e", NODE, str(program), str(tables), *words_for(model)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        raise RuntimeError(f"exit {done.returncode} of {program} in node\n{done.stderr[-2000:]}")
    return done.stdout


# ---- all builds ----


def pinned(platform: str, flags: Sequence[str]) -> Build:
    runner = in_wasmtime if platform == WASM else in_process(platform)
    command = [*ZIG, "-target", TARGETS[platform]]
    return Build(platform, f"zig {' '.join(flags)}", compiled(platform, "zig", command, flags), runner)


def system(platform: str, names: Sequence[str], flags: Sequence[str]) -> Build:
    found = next((path for name in names if (path := shutil.which(name))), None)
    command = [found] if found else None
    return Build(
        platform,
        f"{names[0]} {' '.join(flags)}",
        compiled(platform, names[0], command, flags),
        in_process(platform),
    )


def of_fmus(platform: str) -> Build:
    return Build(platform, "binary of the FMU", with_binary(platform), in_process(platform, loads=True))


def webassembly(host: str, runner: Callable[[Path, Model, Path], str]) -> Build:
    return Build(WASM, f"zig -O3, in {host}", with_objects_of_the_page, runner)


QUICK = (of_fmus(X86), webassembly("wasmtime", in_wasmtime), pinned(X86_32, ["-O3"]))


def all_builds() -> list[Build]:
    return [
        *(of_fmus(platform) for platform in FOLDERS),
        *(pinned(X86, [level]) for level in LEVELS),
        *(system(X86, ["gcc"], [level]) for level in LEVELS),
        *(system(X86, ["clang", "clang-14"], [level]) for level in LEVELS),
        # gcc 12 forms vfmaddsub where the processor has it, although -ffp-contract=off forbids that
        system(X86, ["gcc"], ["-O3", "-march=native", "-mno-fma", "-mno-avx512f"]),
        system(ARM, ["aarch64-linux-gnu-gcc"], ["-O2"]),
        *(pinned(platform, ["-O0"]) for platform in (X86_32, ARM, WINDOWS, WINDOWS_32, WASM)),
        pinned(X86_32, ["-O3"]),
        webassembly("wasmtime", in_wasmtime),
        webassembly("node", in_node),
    ]


def hashes(build: Build, tables: Path) -> dict[str, str]:
    """Scene -> hash, of both FMUs. Raises Missing."""
    found = {}
    for identifier, model in models.items():
        fmu = build_fmu.dual_cam(identifier, check=False)
        for line in build.run(build.make(fmu), model, tables).splitlines():
            scene, _, value = line.rpartition(", ")
            found[f"{identifier}: {scene}"] = value
    if not found:  # Debian's wine without its package for 32 bits ends with success
        raise Missing(f"the programs for {build.name} print nothing: this emulator does not run them")
    return found


def total(found: dict[str, str]) -> str:
    return hashlib.sha256("\n".join(f"{k} {v}" for k, v in found.items()).encode()).hexdigest()[:16]
