"""The two small core modules around the compiled core.

The compiled core imports functions of the host. These functions read texts from the core's memory, so they
can only be made once the core exists. A table breaks this circle: the core gets functions that call through
the table; when the core exists, the table is filled. Resources and the core's function that frees what stands
behind a handle need the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from webassembly.encoding import name, section, unsigned, vector

MODULE = b"\0asm\x01\0\0\0"
KINDS = {"i32": b"\x7f", "i64": b"\x7e", "f32": b"\x7d", "f64": b"\x7c"}
FUNCTION, TABLE = b"\0", b"\x01"  # what an import or export is
FUNCREF = b"\x70"
LOCAL_GET, CALL_INDIRECT, I32_CONST, END = b"\x20", b"\x11", b"\x41", b"\x0b"
TABLE_NAME = "table"


@dataclass(frozen=True)
class Late:
    """A function without result that is put into the table when the core exists."""

    name: str
    parameters: tuple[str, ...]  # kinds of core WebAssembly


def _types(functions: Sequence[Late]) -> bytes:
    return section(
        1, vector(b"\x60" + vector(KINDS[p] for p in f.parameters) + vector([]) for f in functions)
    )


def _table(count: int) -> bytes:
    return FUNCREF + b"\x01" + unsigned(count) + unsigned(count)


def callers(functions: Sequence[Late]) -> bytes:
    """A module with one function for each of `functions`, which calls through the table; it exports both."""

    def body(index: int, function: Late) -> bytes:
        arguments = b"".join(LOCAL_GET + unsigned(i) for i in range(len(function.parameters)))
        call = I32_CONST + unsigned(index) + CALL_INDIRECT + unsigned(index) + b"\0"
        code = vector([]) + arguments + call + END
        return unsigned(len(code)) + code

    exports = [name(f.name) + FUNCTION + unsigned(i) for i, f in enumerate(functions)]
    exports.append(name(TABLE_NAME) + TABLE + b"\0")
    return b"".join(
        [
            MODULE,
            _types(functions),
            section(3, vector(unsigned(i) for i in range(len(functions)))),
            section(4, vector([_table(len(functions))])),
            section(7, vector(exports)),
            section(10, vector(body(i, f) for i, f in enumerate(functions))),
        ]
    )


def filler(functions: Sequence[Late], start: str) -> bytes:
    """A module that imports the table and `functions`, puts them into the table, and calls the function
    `start`."""
    initialise = Late(start, ())
    imported = [*functions, initialise]
    imports = [name("") + name(f.name) + FUNCTION + unsigned(i) for i, f in enumerate(imported)]
    imports.append(name("") + name(TABLE_NAME) + TABLE + _table(len(functions)))
    elements = b"\0" + I32_CONST + b"\0" + END + vector(unsigned(i) for i in range(len(functions)))
    return b"".join(
        [
            MODULE,
            _types(imported),
            section(2, vector(imports)),
            section(8, unsigned(len(functions))),
            section(9, vector([elements])),
        ]
    )
