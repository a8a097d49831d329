"""Binaries for macOS: the parts of a file for several processors, and the signature of one part.

A Mac with an ARM processor loads only signed code. The linker signs without a certificate ("ad hoc"): the
signature is a list of SHA-256 hashes, one for each page of the file (Apple, cs_blobs.h and
mach-o/loader.h). A changed page needs a new hash.
"""

import hashlib
import struct

from dualcam.errors import ExportError

UNIVERSAL, THIN = bytes.fromhex("cafebabe"), bytes.fromhex("cffaedfe")
LC_CODE_SIGNATURE = 0x1D
SIGNATURE, CODE_DIRECTORY, CERTIFICATE = 0xFADE0CC0, 0xFADE0C02, 0xFADE0B01
HEAD_OF_BLOB = 8  # bytes: magic number and length
SHA256 = 2


def parts(binary: bytes) -> list[tuple[int, int]]:
    """(offset, size) in bytes of the code for each processor, in a universal file."""
    (count,) = struct.unpack_from(">I", binary, 4)
    return [struct.unpack_from(">II", binary, 8 + 20 * i + 8) for i in range(count)]


def sign_again(part: bytearray) -> None:
    """Sign the pages of a 64-bit Mach-O file anew. ExportError but for SHA-256 hashes without certificate."""
    at = _signature(part)
    if at is None:
        return
    for offset in _blobs(part, at):
        magic, length = struct.unpack_from(">II", part, offset)
        if magic == CODE_DIRECTORY:
            _hash_pages(part, offset)
        elif magic == CERTIFICATE and length > HEAD_OF_BLOB:
            raise ExportError("the binary for macOS is signed with a certificate: allowed is one without")


def _signature(part: bytes | bytearray) -> int | None:
    """Offset of the signature, or None."""
    (count,) = struct.unpack_from("<I", part, 16)
    at = 32
    for _ in range(count):
        kind, size = struct.unpack_from("<II", part, at)
        if kind == LC_CODE_SIGNATURE:
            (offset,) = struct.unpack_from("<I", part, at + 8)
            return int(offset)
        at += size
    return None


def _blobs(part: bytes | bytearray, at: int) -> list[int]:
    """Offsets of the parts of the signature at `at`."""
    magic, _, count = struct.unpack_from(">III", part, at)
    if magic != SIGNATURE:
        raise ExportError(f"the signature of the binary for macOS begins with {magic:#x}: unknown")
    return [at + struct.unpack_from(">II", part, at + 12 + 8 * i)[1] for i in range(count)]


def _hash_pages(part: bytearray, directory: int) -> None:
    """Fill the page hashes of one list of hashes."""
    hashes, _, _, count, limit = struct.unpack_from(">IIIII", part, directory + 16)
    size, kind, _, page_bits = struct.unpack_from(">BBBB", part, directory + 36)
    if kind != SHA256:
        text = f"the signature of the binary for macOS has hashes of type {kind}: allowed is {SHA256}"
        raise ExportError(text)
    page = 1 << page_bits
    for i in range(count):
        content = part[i * page : min((i + 1) * page, limit)]
        place = directory + hashes + i * size
        part[place : place + size] = hashlib.sha256(content).digest()[:size]
