"""Numbers, names, vectors and sections of WebAssembly's binary format."""

from __future__ import annotations

from collections.abc import Iterable


def unsigned(number: int) -> bytes:
    """LEB128: seven bits a byte, the lowest first."""
    content = bytearray()
    while True:
        byte, number = number & 0x7F, number >> 7
        content.append(byte | (0x80 if number else 0))
        if not number:
            return bytes(content)


def signed(number: int) -> bytes:
    """Signed LEB128. An index of a type is signed where a primitive type, a negative number, may stand
    too."""
    content = bytearray()
    while True:
        byte, number = number & 0x7F, number >> 7
        last = number == (-1 if byte & 0x40 else 0)
        content.append(byte | (0 if last else 0x80))
        if last:
            return bytes(content)


def name(text: str) -> bytes:
    content = text.encode()
    return unsigned(len(content)) + content


def vector(items: Iterable[bytes]) -> bytes:
    listed = list(items)
    return unsigned(len(listed)) + b"".join(listed)


def section(number: int, content: bytes) -> bytes:
    return bytes([number]) + unsigned(len(content)) + content
