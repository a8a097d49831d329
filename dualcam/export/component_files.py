"""Tables of grooves and friction inside a WebAssembly component (fmu_src/component/resource_files.h).

The component reads no files of the host. Its compiled core has a block of bytes that begins with a mark and
says for four files

    char name[32]; uint32 address, size;

The content of the files goes behind the memory that the core begins with, in memory pages of its own.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping

from dualcam.errors import ExportError
from dualcam.export.description import AGAIN

MARK = b"dualcam table files, layout 2\n".ljust(32, b"\0")
FILE = struct.Struct("<32sII")
FILE_COUNT = 4
HEAD = 8  # bytes before the first section, of a component and of a module
PAGE = 1 << 16
CORE_MODULE, MEMORY, DATA, DATA_COUNT = 1, 5, 11, 12  # numbers of sections
ALIGNMENT = 16

Section = tuple[int, bytes]


def with_files(component: bytes, files: Mapping[str, bytes]) -> bytes:
    """A component that holds these files.

    Parameters
    ----------
    component
        WebAssembly component of the project's FMU.
    files
        Name -> content; up to four files.

    Returns
    -------
    bytes
        The component; the same one where there are no files.

    Raises
    ------
    ExportError
        The component has no place for files, or there are too many of them.
    """
    if not files:
        return component
    if len(files) > FILE_COUNT:
        raise ExportError(f"{len(files)} tables for one component: allowed are up to {FILE_COUNT}")
    sections = _sections(component)
    holders = [i for i, (kind, content) in enumerate(sections) if kind == CORE_MODULE and MARK in content]
    if len(holders) != 1 or component.count(MARK) != 1:
        raise ExportError(
            f"the component has {component.count(MARK)} places for tables, allowed is one: {AGAIN}"
        )
    (holder,) = holders
    sections[holder] = (CORE_MODULE, _module_with_files(sections[holder][1], files))
    return component[:HEAD] + _joined(sections)


def _module_with_files(module: bytes, files: Mapping[str, bytes]) -> bytes:
    sections = _sections(module)
    kinds = [kind for kind, _ in sections]
    if kinds.count(MEMORY) != 1 or kinds.count(DATA) != 1:
        raise ExportError(f"the core of the component lacks memory or data: {AGAIN}")
    memory, data = kinds.index(MEMORY), kinds.index(DATA)
    pages = _least_pages(sections[memory][1])
    first = pages * PAGE
    block, content = MARK, b""
    for name, text in files.items():
        block += FILE.pack(_name(name), first + len(content), len(text))
        content += text.ljust(-(-len(text) // ALIGNMENT) * ALIGNMENT, b"\0")
    pages += -(-len(content) // PAGE)
    sections[memory] = (MEMORY, b"\x01\0" + _unsigned(pages))
    count, at = _number(sections[data][1], 0)
    segments = sections[data][1][at:]
    place = segments.index(MARK)
    segments = segments[:place] + block + segments[place + len(block) :]
    # A segment for memory 0 at an address: `i32.const address`, `end`.
    segments += b"\0\x41" + _signed(first) + b"\x0b" + _unsigned(len(content)) + content
    sections[data] = (DATA, _unsigned(count + 1) + segments)
    counted = (DATA_COUNT, _unsigned(count + 1))
    return module[:HEAD] + _joined(counted if kind == DATA_COUNT else (kind, c) for kind, c in sections)


def _name(name: str) -> bytes:
    content = name.encode()
    if len(content) >= 32:
        raise ExportError(f"table {name!r} has a name of {len(content)} bytes: allowed are up to 31")
    return content


def _least_pages(memories: bytes) -> int:
    """Of the one memory, which has no greatest number of pages."""
    pages, at = _number(memories, 2)
    if memories[:2] != b"\x01\0" or at != len(memories):
        raise ExportError(f"the core of the component has a memory {memories.hex()}: {AGAIN}")
    return pages


def _sections(binary: bytes) -> list[Section]:
    """Number and content of each section, of a component or of a module."""
    found, at = [], HEAD
    while at < len(binary):
        kind = binary[at]
        size, at = _number(binary, at + 1)
        found.append((kind, binary[at : at + size]))
        at += size
    return found


def _joined(sections: Iterable[Section]) -> bytes:
    return b"".join(bytes([kind]) + _unsigned(len(content)) + content for kind, content in sections)


# ---- numbers (LEB128: seven bits a byte, the lowest first) ----


def _number(content: bytes, at: int) -> tuple[int, int]:
    """The number at `at`, and where it ends."""
    number, shift = 0, 0
    while True:
        byte = content[at]
        number |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return number, at


def _unsigned(number: int) -> bytes:
    content = bytearray()
    while number >= 0x80:
        content.append(0x80 | number & 0x7F)
        number >>= 7
    return bytes([*content, number])


def _signed(number: int) -> bytes:
    """Of a number that is not negative: bit 6 of the last byte is its sign."""
    content = bytearray()
    while number >= 0x40:
        content.append(0x80 | number & 0x7F)
        number >>= 7
    return bytes([*content, number])
