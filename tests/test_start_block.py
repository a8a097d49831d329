"""The block of GUID and start values in binaries for all platforms, and the signature for macOS."""

import hashlib
import struct
import subprocess
import zipfile

import build_fmu
import platforms
import pytest
from exported_fmus import FACTORY, compile_options

from dualcam.errors import ExportError
from dualcam.export import mach_o
from dualcam.export.start_block import MARK, replace_start_values

TARGETS = {platforms.X86_LINUX, *(target for p in build_fmu.PLATFORMS for target in p.targets)}
GUID = "{00000000-1111-2222-3333-444444444444}"


def numbers_of(fmi):
    """Value reference -> another start value, for all parameters that are no texts."""
    variables = FACTORY[fmi, "DualCamForward"].variables.values()
    return {v.reference: 0.1 + v.reference for v in variables if v.start is not None and v.type != "String"}


def texts_of(fmi):
    variables = FACTORY[fmi, "DualCamForward"].variables
    return {variables[f"cam{i}.table"].reference: f"cam{i}.csv" for i in (1, 2)}


def shipped(fmi, platform) -> bytes:
    """The binary in the forward FMU."""
    name = f"binaries/{platform.folder}/DualCamForward{platform.suffix}"
    with zipfile.ZipFile(FACTORY[fmi, "DualCamForward"].fmu) as archive:
        if name not in archive.namelist():
            pytest.skip(f"the FMU was not built for {platform.folder}: run ./build.sh run all")
        return archive.read(name)


each_binary = pytest.mark.parametrize(
    ("fmi", "platform"),
    [(version, p) for version, all_of_it in build_fmu.ALL.items() for p in all_of_it],
    ids=lambda one: getattr(one, "folder", one),
)


def compiled(tmp_path, target: str, *options: str) -> bytes:
    """fmi/variables.c for another platform."""
    product = tmp_path / "variables"
    command = [*build_fmu.ZIG, "-target", target, *compile_options(2, "forward", GUID), *options]
    names = ["fmi/variables.c", *(["model/fault.c"] if "-shared" in options else [])]
    sources = [build_fmu.CORE / name for name in names]
    subprocess.run([*command, *sources, "-o", product], check=True, capture_output=True)
    return product.read_bytes()


# ---- layout ----


@pytest.mark.parametrize("target", sorted(TARGETS))
def test_the_layout_is_the_same_on_every_platform(tmp_path, target):
    """Little-endian numbers and no padding, also where pointers have 32 bits."""
    binary = compiled(tmp_path, target, "-c")
    assert binary.count(MARK) == 1
    at = binary.index(MARK)
    size, numbers, texts, text_size = struct.unpack_from("<4I", binary, at + 32)
    variables = FACTORY[2, "DualCamForward"].variables
    reach = 1 + max(v.reference for v in variables.values() if v.causality != "local")
    assert (numbers, texts, text_size) == (reach, 4, 128)
    assert size == 112 + 8 * numbers + texts * text_size
    assert binary[at + 48 : at + 112] == GUID.encode().ljust(64, b"\0")
    starts = struct.unpack_from(f"<{numbers}d", binary, at + 112)
    for v in variables.values():
        if v.type in ("Real", "Integer", "Boolean") and v.start is not None:
            assert starts[v.reference] == v.start, v.name
    names = [f"cam{i}.{kind}" for i in (1, 2) for kind in ("table", "friction_table")]
    assert [starts[variables[name].reference] for name in names] == [0, 1, 2, 3]
    assert binary[at + 112 + 8 * numbers : at + size] == bytes(4 * 128)


# ---- binaries of the FMUs ----


@each_binary
def test_the_same_values_give_the_same_bytes(fmi, platform):
    """GUID and start values as before. For macOS this includes the linker's signature."""
    model = FACTORY[fmi, "DualCamForward"]
    content = shipped(fmi, platform)
    starts = {v.reference: v for v in model.variables.values() if v.start is not None}
    numbers = {r: float(v.start) for r, v in starts.items() if v.type != "String"}
    texts = {r: "" for r, v in starts.items() if v.type == "String"}
    assert replace_start_values(content, model.guid, numbers, texts) == content


@each_binary
def test_only_the_block_and_hashes_change(fmi, platform):
    before = shipped(fmi, platform)
    after = replace_start_values(before, GUID, numbers_of(fmi), texts_of(fmi))
    assert len(after) == len(before)
    old = FACTORY[fmi, "DualCamForward"].guid.encode()
    parts = len(platform.targets)
    assert (before.count(old), after.count(old)) == (parts, 0)  # nothing else in the binary holds the GUID
    assert (before.count(GUID.encode()), after.count(GUID.encode())) == (0, parts)
    changed = [i for i in range(len(before)) if before[i] != after[i]]
    if platform.suffix != ".dylib":
        at = before.index(MARK)
        assert at + 48 <= changed[0] and changed[-1] < at + int.from_bytes(
            before[at + 32 : at + 36], "little"
        )


def test_a_binary_for_windows_has_no_checksum():
    """Otherwise the export would have to compute it anew."""
    for fmi, all_of_it in build_fmu.ALL.items():
        for platform in all_of_it:
            if platform.suffix == ".dll":
                content = shipped(fmi, platform)
                (pe,) = struct.unpack_from("<I", content, 60)
                assert content[pe : pe + 4] == b"PE\0\0"
                assert struct.unpack_from("<I", content, pe + 24 + 64) == (0,)


# ---- the signature for macOS ----


@pytest.fixture(scope="module")
def signed(tmp_path_factory):
    """A small library for a Mac with an ARM processor, signed by the linker."""
    return compiled(tmp_path_factory.mktemp("signed"), platforms.ARM_MAC, "-shared")


def hashes_of(part: bytes) -> list[tuple[bytes, bytes]]:
    """For each page the hash in the signature, and the hash of the page: read by hand from the format."""
    (count,) = struct.unpack_from("<I", part, 16)
    at, signature = 32, None
    for _ in range(count):
        kind, size = struct.unpack_from("<II", part, at)
        if kind == 0x1D:
            (signature,) = struct.unpack_from("<I", part, at + 8)
        at += size
    directory = part.index(bytes.fromhex("fade0c02"), signature)
    (first,) = struct.unpack_from(">I", part, directory + 16)
    pages, limit = struct.unpack_from(">II", part, directory + 28)
    page = 1 << part[directory + 39]
    found = []
    for i in range(pages):
        place = directory + first + 32 * i
        content = part[i * page : min((i + 1) * page, limit)]
        found.append((part[place : place + 32], hashlib.sha256(content).digest()))
    assert len(found) == -(-limit // page)
    return found


def test_the_linker_signs_as_the_test_reads(signed):
    assert len(hashes_of(signed)) > 1
    assert all(stored == computed for stored, computed in hashes_of(signed))


def test_signing_an_unchanged_library_changes_nothing(signed):
    part = bytearray(signed)
    mach_o.sign_again(part)
    assert part == signed


def test_a_changed_library_has_a_valid_signature(signed):
    changed = replace_start_values(signed, "{another}", numbers_of(2), texts_of(2))
    assert changed != signed and len(changed) == len(signed)
    assert all(stored == computed for stored, computed in hashes_of(changed))


def universal(*parts: bytes) -> bytes:
    head, body = struct.pack(">II", 0xCAFEBABE, len(parts)), b""
    for part in parts:
        head += struct.pack(">IIIII", 0, 0, 4096 + len(body), len(part), 0)
        body += part
    return head.ljust(4096, b"\0") + body


def test_every_part_of_a_universal_file_is_changed(signed):
    once = replace_start_values(signed, "{another}", numbers_of(2), {})
    both = replace_start_values(universal(signed, signed), "{another}", numbers_of(2), {})
    assert both == universal(once, once)


def test_other_signatures_are_refused(signed):
    directory = signed.index(bytes.fromhex("fade0c02"))
    other_hash = bytearray(signed)
    other_hash[directory + 37] = 1  # SHA-1
    with pytest.raises(ExportError, match="hashes of type 1"):
        mach_o.sign_again(other_hash)
    certified = bytearray(signed)
    blob = struct.unpack_from(">II", signed, directory)
    certified[directory : directory + 8] = struct.pack(">II", 0xFADE0B01, blob[1])
    with pytest.raises(ExportError, match="certificate"):
        mach_o.sign_again(certified)


# ---- what is refused ----


def test_binaries_that_cannot_be_changed(tmp_path):
    binary = compiled(tmp_path, platforms.X86_LINUX, "-c")
    with pytest.raises(ExportError, match=r"0 times, allowed is once: .* build the FMUs again"):
        replace_start_values(binary.replace(MARK, bytes(32)), GUID, {}, {})
    with pytest.raises(ExportError, match="2 times, allowed is once"):
        replace_start_values(binary + MARK, GUID, {}, {})
    at = binary.index(MARK) + 32
    with pytest.raises(ExportError, match="another layout"):
        replace_start_values(binary[:at] + b"\1\0\0\0" + binary[at + 4 :], GUID, {}, {})
    with pytest.raises(ExportError, match="allowed are ELF, PE and Mach-O"):
        replace_start_values(b"!<arch>\n" + binary, GUID, {}, {})
    with pytest.raises(ExportError, match="has 64 bytes: allowed are up to 63"):
        replace_start_values(binary, "g" * 64, {}, {})
    with pytest.raises(ExportError, match="has 128 bytes: allowed are up to 127"):
        replace_start_values(binary, GUID, {}, {next(iter(texts_of(2))): "ü" * 64})
