"""The block of bytes in a finished binary that holds GUID and start values (fmu_src/fmi/variables.h).

A mark begins the block. All numbers are little-endian, on every platform of the FMUs:

    char mark[32]; uint32 size, number_count, text_count, text_size; char guid[64];
    double number[number_count]; char text[text_count][text_size];

`number` has one place for each value reference. The place of a text holds the index of the text.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from dualcam.errors import DualcamError, ExportError
from dualcam.export import mach_o
from dualcam.export.description import AGAIN
from dualcam.fmi.binary import own_binary
from dualcam.fmi.model_description import ModelDescription, Variable

MARK = b"dualcam start values, layout 1\n\0"
HEAD = struct.Struct("<32s4I64s")
GUID_AT, GUID_SIZE = 48, 64
ONE_PART = (b"\x7fELF", b"MZ", mach_o.THIN)  # beginnings of binaries with one block


def replace_start_values(
    binary: bytes, guid: str, numbers: Mapping[int, float], texts: Mapping[int, str]
) -> bytes:
    """A binary with another GUID and other start values, by value reference, for macOS signed again.

    ExportError unless the block is there once for each processor, or for a long text."""
    content = bytearray(binary)
    for begin, size in _parts(binary):
        part = content[begin : begin + size]
        _replace(part, guid, numbers, texts)
        if part.startswith(mach_o.THIN):
            mach_o.sign_again(part)
        content[begin : begin + size] = part
    return bytes(content)


def _parts(binary: bytes) -> list[tuple[int, int]]:
    """(offset, size) of the code for each processor."""
    if binary.startswith(mach_o.UNIVERSAL):
        return mach_o.parts(binary)
    if binary.startswith(ONE_PART):
        return [(0, len(binary))]
    raise ExportError(f"a binary begins with {binary[:4].hex()}: allowed are ELF, PE and Mach-O")


@dataclass(frozen=True)
class StartValues:
    """The block in a binary, by value reference. Places of texts hold an index into `texts`."""

    at: int  # offset of the block
    text_size: int
    numbers: tuple[float, ...]
    texts: tuple[str, ...]

    def value(self, reference: int, is_text: bool) -> float | str:
        """The start value of a variable."""
        number = self.numbers[reference]
        return self.texts[int(number)] if is_text else number


def read_start_values(binary: bytes) -> StartValues | None:
    """The start values in a binary; None without a block. ExportError for another layout or many blocks."""
    if MARK not in binary:
        return None
    begin, size = _parts(binary)[0]
    return _block(binary[begin : begin + size])


def _block(part: bytes | bytearray) -> StartValues:
    found = part.count(MARK)
    if found != 1:
        raise ExportError(f"a binary holds the block of start values {found} times, allowed is once: {AGAIN}")
    at = part.index(MARK)
    _, size, number_count, text_count, text_size, _ = HEAD.unpack_from(part, at)
    if size != HEAD.size + 8 * number_count + text_count * text_size or at + size > len(part):
        raise ExportError(f"the block of start values has {size} bytes, with another layout: {AGAIN}")
    numbers = struct.unpack_from(f"<{number_count}d", part, at + HEAD.size)
    first_text = at + HEAD.size + 8 * number_count
    places = range(first_text, first_text + text_count * text_size, text_size)
    texts = tuple(bytes(part[p : p + text_size]).split(b"\0")[0].decode(errors="replace") for p in places)
    return StartValues(at, text_size, numbers, texts)


def _replace(part: bytearray, guid: str, numbers: Mapping[int, float], texts: Mapping[int, str]) -> None:
    block = _block(part)
    at = block.at
    part[at + GUID_AT : at + GUID_AT + GUID_SIZE] = _padded("GUID", guid, GUID_SIZE)
    first_number, first_text = at + HEAD.size, at + HEAD.size + 8 * len(block.numbers)
    for reference, number in numbers.items():
        struct.pack_into("<d", part, first_number + 8 * reference, number)
    for reference, text in texts.items():
        place = first_text + block.text_size * int(block.numbers[reference])
        part[place : place + block.text_size] = _padded("text", text, block.text_size)


def _padded(what: str, text: str, size: int) -> bytes:
    """`text` and zeros, `size` bytes together."""
    content = text.encode()
    if len(content) >= size:
        raise ExportError(f"{what} {text!r} has {len(content)} bytes: allowed are up to {size - 1}")
    return content.ljust(size, b"\0")


def edited_start_values(path: Path, description: ModelDescription) -> list[str]:
    """One sentence for each start value in the XML that is not that of the binary for this machine."""
    try:
        binary = own_binary(path, description)
        block = None if binary is None else read_start_values(binary)
        return [] if block is None else _differences(description, block)
    except (DualcamError, IndexError) as error:
        return [f"the start values in the binary cannot be read: {error}"]


def _differences(description: ModelDescription, block: StartValues) -> list[str]:
    return [
        f"{variable.name}: modelDescription.xml says {variable.start!r}, but the FMU starts from"
        f" {_in_words(variable, used)}, the value in its binary: change the design file and export again"
        for variable in description.variables
        if variable.start is not None
        and (used := block.value(variable.value_reference, variable.kind == "string")) != variable.start
    ]


def _in_words(variable: Variable, value: float | str) -> str:
    """The value by the variable's type."""
    if isinstance(value, str) or variable.kind == "real":
        return repr(value)
    return repr(bool(value) if variable.kind == "boolean" else int(value))
