"""The FMUs' binaries for each platform: size, what they depend on and export, the same bytes from the same
files, and runs in an emulator.

A plain build holds the binary for this machine alone. After `./build.sh run all` these tests see the others
too. With DUALCAM_REBUILD=all they compile every binary a second time, in another directory.
"""

import os
import re
import shutil
import struct
import subprocess
import sys
import urllib.parse
import zipfile
from dataclasses import dataclass
from pathlib import Path

import build_fmu
import compiler
import driver3
import platforms
import products
import pytest
import workspace
from driver import ARGUMENTS, FORWARD, ROOT, models

LARGEST = 500_000  # bytes, for one processor
FUNCTIONS = {
    2: {*ARGUMENTS, *("fmi2Instantiate", "fmi2FreeInstance", "fmi2GetVersion", "fmi2GetTypesPlatform")},
    3: driver3.FUNCTIONS,
}
LINKER_MARKS = {"__dso_handle", "_mh_dylib_header"}  # zig's, in every dylib
PLATFORMS = {p.folder: p for p in build_fmu.PLATFORMS}
VERSIONS = {2: models, 3: driver3.models}
REBUILD_ALL = os.environ.get("DUALCAM_REBUILD") == "all"


# ---- readers of the three formats: only what is asked below ----


@dataclass
class Binary:
    machine: str
    needs: set[str]  # libraries
    exports: set[str]
    name: str = ""  # its own, where it has one
    signed: bool = False


def text_at(content: bytes, offset: int) -> str:
    return content[offset : content.index(b"\0", offset)].decode()


def read_elf(content: bytes) -> Binary:
    machine = {62: "x86_64", 183: "aarch64"}[struct.unpack_from("<H", content, 18)[0]]
    (table,) = struct.unpack_from("<Q", content, 40)
    size, count = struct.unpack_from("<HH", content, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", content, table + i * size) for i in range(count)]
    needs, exports = set(), set()
    for _, kind, _, _, offset, length, link, *_ in sections:
        strings = sections[link][4]
        if kind == 6:  # dynamic
            entries = struct.iter_unpack("<QQ", content[offset : offset + length])
            needs |= {text_at(content, strings + value) for tag, value in entries if tag == 1}
        if kind == 11:  # dynamic symbols
            for at in range(offset + 24, offset + length, 24):
                name, _, _, section = struct.unpack_from("<IBBH", content, at)
                if section != 0:
                    exports.add(text_at(content, strings + name))
    return Binary(machine, needs, exports)


def read_pe(content: bytes) -> Binary:
    (pe,) = struct.unpack_from("<I", content, 60)
    kind, sections = struct.unpack_from("<HH", content, pe + 4)
    (optional,) = struct.unpack_from("<H", content, pe + 20)
    machine = {0x8664: "x86_64", 0x14C: "x86"}[kind]
    directories = pe + 24 + {"x86_64": 112, "x86": 96}[machine]

    def place(address: int) -> int:
        for i in range(sections):
            size, start, length, offset = struct.unpack_from("<IIII", content, pe + 32 + optional + 40 * i)
            if start <= address < start + max(size, length):
                return address - start + offset
        raise ValueError(f"address {address} is in no section")

    exported, _, imported, _ = struct.unpack_from("<IIII", content, directories)
    table = struct.unpack_from("<IIIIIIIIIII", content, place(exported))
    names = struct.unpack_from(f"<{table[6]}I", content, place(table[8]))
    needs, at = set(), place(imported)
    while (library := struct.unpack_from("<IIIII", content, at)[3]) != 0:
        needs.add(text_at(content, place(library)))
        at += 20
    return Binary(
        machine, needs, {text_at(content, place(n)) for n in names}, text_at(content, place(table[3]))
    )


def read_mach_o(content: bytes) -> Binary:
    machine = {0x01000007: "x86_64", 0x0100000C: "aarch64"}[struct.unpack_from("<I", content, 4)[0]]
    (count,) = struct.unpack_from("<I", content, 16)
    found, at = Binary(machine, set(), set()), 32
    for _ in range(count):
        kind, size = struct.unpack_from("<II", content, at)
        if kind in (0x0C, 0x80000018):  # load this library, or go without
            found.needs.add(text_at(content, at + struct.unpack_from("<I", content, at + 8)[0]))
        elif kind == 0x0D:  # what it is called
            found.name = text_at(content, at + struct.unpack_from("<I", content, at + 8)[0])
        elif kind == 0x1D:
            found.signed = True
        elif kind == 0x02:  # symbols; without debugging ones, those that are external and in a section
            symbols, number, strings, _ = struct.unpack_from("<IIII", content, at + 8)
            for i in range(number):
                name, flags = struct.unpack_from("<IB", content, symbols + 16 * i)
                if flags & 0xE0 == 0 and flags & 0x01 and flags & 0x0E == 0x0E and not flags & 0x10:
                    found.exports.add(text_at(content, strings + name).removeprefix("_"))
        at += size
    return found


def slices(content: bytes) -> list[bytes]:
    """The parts of a universal binary; of any other, itself."""
    if content[:4] != bytes.fromhex("cafebabe"):
        return [content]
    (count,) = struct.unpack_from(">I", content, 4)
    places = [struct.unpack_from(">IIIII", content, 8 + 20 * i) for i in range(count)]
    assert all(offset % (1 << bits) == 0 for _, _, offset, _, bits in places)
    return [content[offset : offset + size] for _, _, offset, size, _ in places]


# ---- what is in the archive ----


def shipped(model, platform) -> bytes:
    """The binary as it is in the FMU."""
    name = platform.library(model.identifier).name
    with zipfile.ZipFile(model.fmu) as archive:
        member = f"binaries/{platform.folder}/{name}"
        if member not in archive.namelist():
            pytest.skip(f"{model.fmu.name} was not built for {platform.folder}: run ./build.sh run all")
        return archive.read(member)


each_model = pytest.mark.parametrize("model", models.values(), ids=repr)
each_binary = pytest.mark.parametrize(
    ("model", "platform"),
    [(m, p) for version, found in VERSIONS.items() for m in found.values() for p in platforms.ALL[version]],
    ids=lambda one: repr(one) if hasattr(one, "fmu") else f"{one.folder}-{one.version}",
)


@each_binary
def test_size(model, platform):
    for part in slices(shipped(model, platform)):
        assert len(part) <= LARGEST


@each_binary
def test_depends_on_the_c_library_alone(model, platform):
    content, functions = shipped(model, platform), FUNCTIONS[platform.version]
    machine = "aarch64" if platform.folder.startswith("aarch64") else "x86_64"
    if platform.suffix == ".so":
        binary = read_elf(content)
        assert binary.machine == machine
        assert binary.needs <= {"libc.so.6", "libm.so.6"}
        assert binary.exports == functions
    elif platform.suffix == ".dll":
        binary = read_pe(content)
        assert binary.machine == ("x86" if platform.folder in ("win32", "x86-windows") else machine)
        assert all(n == "KERNEL32.dll" or n.startswith("api-ms-win-crt-") for n in binary.needs), binary.needs
        assert binary.exports == functions
        assert binary.name == f"{model.identifier}.dll"
    else:
        parts = [read_mach_o(part) for part in slices(content)]
        assert [part.machine for part in parts] == (["x86_64", "aarch64"] if len(parts) == 2 else [machine])
        assert len(parts) == len(platform.targets)
        assert all(part.signed for part in parts if part.machine == "aarch64")  # such Macs load nothing else
        for binary in parts:
            assert binary.needs == {"/usr/lib/libSystem.B.dylib"}
            assert binary.exports == functions | LINKER_MARKS
            assert binary.name == f"@rpath/{model.identifier}.dylib"


@each_binary
def test_names_no_place(model, platform):
    content = shipped(model, platform)
    for place in (ROOT, build_fmu.fmi_headers()):
        assert str(place).encode() not in content


@pytest.mark.parametrize("version", VERSIONS)
def test_a_plain_build_leaves_one_for_all_alone(version):
    model = VERSIONS[version][FORWARD.identifier]
    for platform in build_fmu.ALL[version]:
        shipped(model, platform)
    before = model.fmu.stat().st_mtime_ns
    build_fmu.build(build_fmu.dual_cam(model.identifier, check=True, version=version))
    assert model.fmu.stat().st_mtime_ns == before


# ---- the same bytes ----


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory):
    """Runs Python code after `import build_fmu` in a copy of the sources, in a directory whose name has
    spaces; returns that directory. The two places share only the compiler's cache of its own C library."""
    root = tmp_path_factory.mktemp("another") / "place of longer name"
    for folder in ("fmu_src", "modelDescription", "benchmarks/null_fmu"):
        shutil.copytree(ROOT / folder, root / folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "LICENSE", root)
    shared = os.environ.get("ZIG_GLOBAL_CACHE_DIR", str(build_fmu.BUILD / "zig-cache"))
    caches = {"ZIG_GLOBAL_CACHE_DIR": shared, "ZIG_LOCAL_CACHE_DIR": str(root / "zig-cache")}

    def run(code: str) -> Path:
        command = [sys.executable, "-c", f"import build_fmu\n{code}"]
        environment = {**os.environ, **caches, "PYTHONPATH": str(root / "fmu_src/tools")}
        done = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        return root

    return run


def test_another_directory_gives_the_same_bytes(elsewhere):
    model, platform = models["DualCamInverse"], PLATFORMS["linux64"]  # the smaller one
    made = f"build_fmu.dual_cam({model.identifier!r}, check=True)"
    root = elsewhere(f"build_fmu.build_library({made}, build_fmu.PLATFORMS[0])")
    library = root / platform.library(model.identifier).relative_to(ROOT)
    assert library.read_bytes() == shipped(model, platform)


@pytest.mark.skipif(not REBUILD_ALL, reason="takes minutes: DUALCAM_REBUILD=all runs it")
@pytest.mark.parametrize("version", VERSIONS)
@each_model
def test_another_directory_gives_the_same_fmu(elsewhere, model, version):
    model = VERSIONS[version][model.identifier]
    for platform in build_fmu.ALL[version]:
        shipped(model, platform)
    made = f"build_fmu.dual_cam({model.identifier!r}, check=True, version={version})"
    root = elsewhere(f"build_fmu.build({made}, for_all=True)")
    fmu = root / model.fmu.relative_to(ROOT)
    assert fmu.read_bytes() == model.fmu.read_bytes()


def test_objects_that_all_fmus_share_know_no_fmu():
    """The build compiles them once, without the macros that say which FMU is built. Headers of the room that
    uses the macros are out of reach: test_house.py."""
    shared = [path for path in build_fmu.core_sources("DualCamForward") if compiler.is_shared(path)]
    rooms = {path.parent for path in shared}
    assert len(shared) > 50 and ROOT / "fmu_src/fmi" not in rooms
    macros = re.compile(r"\b(MODEL_(BUILT|GUID|IDENTIFIER|FORWARD|INVERSE)|FMI_VERSION)\b")
    for path in [file for room in rooms for file in room.glob("*.[ch]")]:
        assert not macros.search(path.read_text(encoding="utf-8")), path


# ---- the machine on which the build runs ----

# system, machine and bits of a pointer, as Python names them -> target, folders for FMI 2.0 and 3.0, suffix
MACHINES = {
    ("Linux", "x86_64", 64): (platforms.X86_LINUX, "linux64", "x86_64-linux", ".so"),
    ("Linux", "aarch64", 64): (platforms.ARM_LINUX, "aarch64-linux", "aarch64-linux", ".so"),
    ("Windows", "AMD64", 64): ("x86_64-windows-gnu", "win64", "x86_64-windows", ".dll"),
    ("Windows", "AMD64", 32): ("x86-windows-gnu", "win32", "x86-windows", ".dll"),
    ("Windows", "x86", 32): ("x86-windows-gnu", "win32", "x86-windows", ".dll"),
    ("Darwin", "x86_64", 64): ("x86_64-macos.11.0", "darwin64", "x86_64-darwin", ".dylib"),
    ("Darwin", "arm64", 64): ("aarch64-macos.11.0", "darwin64", "aarch64-darwin", ".dylib"),
}
UNSUPPORTED = [
    ("Windows", "ARM64", 64),
    ("Linux", "riscv64", 64),
    ("Linux", "x86_64", 32),
    ("FreeBSD", "amd64", 64),
]


@pytest.fixture
def on(monkeypatch):
    """Makes the build believe that it runs on that machine."""

    def machine(system: str, processor: str, bits: int) -> None:
        monkeypatch.setattr("platform.system", lambda: system)
        monkeypatch.setattr("platform.machine", lambda: processor)
        monkeypatch.setattr(platforms, "pointer_bits", lambda: bits)

    return machine


@pytest.mark.parametrize("machine", MACHINES, ids=str)
def test_the_platform_of_the_machine(on, machine):
    on(*machine)
    target, *folders, suffix = MACHINES[machine]
    assert platforms.host_options() == ["-target", target]
    for version, folder in zip(VERSIONS, folders, strict=True):
        platform = platforms.host_platform(version)
        assert (platform.folder, platform.suffix, platform.version) == (folder, suffix, version)
        assert target in platform.targets
        assert platform.library("Cam").name == f"Cam{suffix}"
        assert platform.library("Cam").parent.name == folder


@pytest.mark.parametrize("machine", UNSUPPORTED, ids=str)
def test_a_machine_without_a_platform_is_told_what_there_is(on, machine):
    on(*machine)
    assert platforms.host_options() == []
    with pytest.raises(build_fmu.BuildError, match=r"no FMU is built for .* all"):
        platforms.host_platform()


@pytest.mark.parametrize("machine", MACHINES, ids=str)
def test_options_of_the_machine(on, machine):
    """The same optimisation everywhere; options of a linker only where that linker knows them."""
    on(*machine)
    platform = platforms.host_platform()
    compilation, linking = platform.compilation, platform.linking("Cam")
    assert "-O3" in compilation and "-O3" in linking and "-O3" in platforms.shared_options()
    for options in (compilation, linking, platforms.shared_options()):
        assert ("-flto" in options) == (platform.suffix == ".so")
    assert ("-Wl,-z,defs" in linking) == (platform.suffix == ".so")
    assert ("-Wl,-install_name,@rpath/Cam.dylib" in linking) == (platform.suffix == ".dylib")


@pytest.mark.parametrize("machine", MACHINES, ids=str)
def test_programs_of_the_build_end_as_the_system_wants(on, machine, tmp_path):
    on(*machine)
    assert platforms.executable(tmp_path / "emit_2").name == (
        "emit_2.exe" if machine[0] == "Windows" else "emit_2"
    )


@pytest.mark.parametrize("machine", MACHINES, ids=str)
def test_a_plain_build_is_for_the_machine_alone(on, machine, monkeypatch, tmp_path):
    """No compiler runs here: the libraries that the build asks for, and the members of the FMU."""
    on(*machine)
    monkeypatch.setattr(workspace, "BUILD", tmp_path)
    asked = []

    def library(fmu, platform):
        asked.append(platform.folder)
        product = platform.library(fmu.identifier)
        product.parent.mkdir(parents=True, exist_ok=True)
        product.write_bytes(b"compiled")
        return product

    for module, name, replacement in (
        (products, "build_library", library),
        (products, "validate", lambda path: None),
        (products, "relative", str),
    ):
        monkeypatch.setattr(module, name, replacement)
    _, *folders, suffix = MACHINES[machine]
    for version, folder in zip(VERSIONS, folders, strict=True):
        fmu = build_fmu.Fmu("Cam", [], "<description/>", "guid", version=version)
        build_fmu.build(fmu)
        with zipfile.ZipFile(fmu.path) as archive:
            assert set(archive.namelist()) == {"modelDescription.xml", f"binaries/{folder}/Cam{suffix}"}
    assert asked == folders


def test_all_by_word_and_by_option(monkeypatch):
    asked = []
    monkeypatch.setattr(
        build_fmu, "build", lambda fmu, for_all=False: asked.append((fmu.identifier, for_all))
    )
    for words in ([], ["all"], ["--all"]):
        asked.clear()
        assert build_fmu.main([*words, "--check"]) == 0
        expected = [(name, bool(words)) for _ in VERSIONS for name in models]
        assert asked == [*expected, ("NullFmu", False)]


def test_two_builds_wait_for_each_other():
    code = "import build_fmu\nwith build_fmu.locked(): print('mine')"
    command = [sys.executable, "-c", code]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "fmu_src/tools")}
    with build_fmu.locked():
        other = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
        with pytest.raises(subprocess.TimeoutExpired):
            other.wait(2.0)
    assert other.communicate(timeout=60)[0] == "mine\n"


# ---- runs ----

ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")


def table() -> str:
    angles = [k / 10 for k in range(-20, 21)]
    return "psi_rad,z_m\n" + "".join(f"{a!r},{0.02 * a + 0.0011 * a * a!r}\n" for a in angles)


def emulator(folder: str) -> list[str]:
    """The words before the host's, or a skip that says what is missing."""
    if folder == "aarch64-linux":
        program = shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static")
        if program is None:
            pytest.skip("qemu-aarch64 is not installed (Debian: qemu-user)")
        if not ARM_LIBRARIES.is_dir():
            pytest.skip(f"{ARM_LIBRARIES} is missing (Debian: libc6-arm64-cross)")
        return [program, "-L", str(ARM_LIBRARIES)]
    program = shutil.which("wine64") or shutil.which("wine")
    if program is None:
        pytest.skip("wine is not installed (Debian: wine, wine64)")
    return [program]


@pytest.fixture(scope="module")
def play(tmp_path_factory):
    """Runs native/host.c with the forward FMU's binary of a platform; returns its words, line by line."""
    folder = tmp_path_factory.mktemp("play")
    resources = folder / "résources 1 %"  # in UTF-8 everywhere, also on Windows
    resources.mkdir()
    for place in (resources, folder):
        (place / "groove.csv").write_text(table())

    def run(platform, before: list[str] = (), root: str = "") -> list[list[str]]:
        home = folder / platform.folder
        home.mkdir()
        library, host = home / platform.library(FORWARD.identifier).name, home / "host.exe"
        library.write_bytes(shipped(FORWARD, platform))
        flags = ["-O1", "-target", platform.targets[0], *(["-ldl"] if platform.suffix == ".so" else [])]
        build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "tests/native/host.c"], host)
        location = f"file://{root and '/' + root}{urllib.parse.quote(str(resources))}"
        references = [f"{v.name}={v.reference}" for v in FORWARD.variables.values()]
        words = [f"{root}{library}", FORWARD.guid, location, f"{root}{folder}/groove.csv", *references]
        environment = {**os.environ, "WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all"}
        done = subprocess.run(
            [*before, host, *words], capture_output=True, text=True, env=environment, timeout=300
        )
        assert done.returncode == 0, f"exit {done.returncode}\n{done.stderr[-3000:]}"
        if platform.folder == "win32" and not done.stdout:  # Debian's wine without its part for 32 bits
            pytest.skip("wine for 32 bits is not installed (Debian: wine32:i386)")
        return [line.split() for line in done.stdout.splitlines()]

    return run


@pytest.fixture(scope="module")
def here(play):
    return play(PLATFORMS["linux64"])


def test_the_host_sees_stick_slip(here):
    assert len(here) == 150
    for scene in ("closed_form", "general", "absolute"):
        assert max(int(line[4]) for line in here if line[0] == scene) > 10
        assert any(float(line[3]) > 1.0 for line in here if line[0] == scene)
        assert any(float(line[3]) < -1.0 for line in here if line[0] == scene)


@pytest.mark.parametrize(
    ("folder", "root"),
    [
        ("aarch64-linux", ""),
        pytest.param("win64", "Z:", marks=pytest.mark.long),  # wine starts in a minute
        pytest.param("win32", "Z:", marks=pytest.mark.long),
    ],
)
def test_runs_alike(play, here, folder, root):
    """All digits are equal."""
    assert play(PLATFORMS[folder], emulator(folder), root) == here
