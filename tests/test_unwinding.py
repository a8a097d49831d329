"""Unwinding tables in the binaries: an exception of the host's C++, thrown in a callback, finds its way
through the frames of the FMU (docs/hosts.md). Without a table the process ends.

tests/test_faults.py throws such exceptions, on Linux and on Windows.
"""

import struct

import build_fmu
import pytest
from driver import models
from driver3 import models as models3

NAMES = {
    2: ("Instantiate", "ExitInitializationMode", "SetReal", "GetReal", "DoStep", "SetFMUstate"),
    3: (
        "InstantiateCoSimulation",
        "ExitInitializationMode",
        "SetFloat64",
        "GetFloat64",
        "DoStep",
        "SetFMUState",
    ),
}
CASES = [
    (model, platform)
    for version, found in ((2, models), (3, models3))
    for model in found.values()
    for platform in build_fmu.ALL[version]
    if platform.suffix == ".so" or platform.targets == ("x86_64-windows-gnu",)
]


def text_at(content: bytes, offset: int) -> str:
    return content[offset : content.index(b"\0", offset)].decode()


def elf_functions(content: bytes) -> tuple[dict[str, int], set[int]]:
    """Exported functions with their addresses, and the addresses where entries of .eh_frame_hdr begin."""
    (table,) = struct.unpack_from("<Q", content, 40)
    size, count, names = struct.unpack_from("<HHH", content, 58)
    rows = [struct.unpack_from("<IIQQQQ", content, table + i * size) for i in range(count)]
    sections = {text_at(content, rows[names][4] + row[0]): row[3:] for row in rows}
    address, offset, _ = sections[".eh_frame_hdr"]
    assert (
        content[offset : offset + 4] == b"\x01\x1b\x03\x3b"
    )  # version; pairs of offsets from the table itself
    (entries,) = struct.unpack_from("<I", content, offset + 8)
    begins = {address + struct.unpack_from("<i", content, offset + 12 + 8 * k)[0] for k in range(entries)}
    _, symbols, length = sections[".dynsym"]
    exported = {}
    for at in range(symbols + 24, symbols + length, 24):
        name, _, _, section, value = struct.unpack_from("<IBBHQ", content, at)
        if section != 0:
            exported[text_at(content, sections[".dynstr"][1] + name)] = value
    return exported, begins


def pe_functions(content: bytes) -> tuple[dict[str, int], set[int]]:
    """The same from .pdata, the exception directory of 64-bit Windows."""
    (pe,) = struct.unpack_from("<I", content, 60)
    (count,), (optional,) = (struct.unpack_from("<H", content, pe + at) for at in (6, 20))
    sections = [struct.unpack_from("<IIII", content, pe + 32 + optional + 40 * i) for i in range(count)]

    def place(address: int) -> int:
        return next(
            address - start + at for size, start, _, at in sections if start <= address < start + size
        )

    directories = pe + 24 + 112
    exports, _, *_, table, length = struct.unpack_from("<8I", content, directories)
    begins = {entry[0] for entry in struct.iter_unpack("<III", content[place(table) : place(table) + length])}
    number, addresses, names, ordinals = struct.unpack_from("<4I", content, place(exports) + 24)
    exported = {}
    for k in range(number):
        (name,) = struct.unpack_from("<I", content, place(names) + 4 * k)
        (ordinal,) = struct.unpack_from("<H", content, place(ordinals) + 2 * k)
        exported[text_at(content, place(name))] = struct.unpack_from(
            "<I", content, place(addresses) + 4 * ordinal
        )[0]
    return exported, begins


@pytest.mark.parametrize(("model", "platform"), CASES, ids=lambda one: getattr(one, "folder", repr(one)))
def test_functions_that_call_the_host_can_be_unwound(model, platform):
    """On Windows a function that keeps nothing on the stack has no entry and needs none."""
    library = platform.library(model.identifier)
    if not library.exists():
        pytest.skip(f"{library.name} is not built for {platform.folder}: run ./build.sh run all")
    read = elf_functions if platform.suffix == ".so" else pe_functions
    exported, begins = read(library.read_bytes())
    calling = {f"fmi{platform.version}{name}" for name in NAMES[platform.version]}
    assert calling <= exported.keys()
    assert not {name for name in calling if exported[name] not in begins}
    if platform.suffix == ".so":
        assert not {name for name, address in exported.items() if address not in begins}
