"""Types of the component model, and how a scope of the binary format lists them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from webassembly.encoding import name, signed, unsigned, vector

PRIMITIVES = {
    "bool": -1, "s8": -2, "u8": -3, "s16": -4, "u16": -5, "s32": -6, "u32": -7, "s64": -8, "u64": -9,
    "f32": -10, "f64": -11, "string": -13,
}  # fmt: skip


@dataclass(frozen=True)
class Named:
    """A type that the interface gives a name."""

    name: str


@dataclass(frozen=True)
class Record:
    fields: tuple[tuple[str, Type], ...]


@dataclass(frozen=True)
class Enumeration:
    cases: tuple[str, ...]


@dataclass(frozen=True)
class List:
    element: Type


@dataclass(frozen=True)
class Tuple:
    elements: tuple[Type, ...]


@dataclass(frozen=True)
class Option:
    content: Type


@dataclass(frozen=True)
class Result:
    good: Type
    refused: Type


@dataclass(frozen=True)
class Handle:
    """Of a resource: to keep (owned), or for the time of a call."""

    resource: str
    owned: bool


Type = str | Named | Record | Enumeration | List | Tuple | Option | Result | Handle


@dataclass(frozen=True)
class Function:
    """A function of an interface."""

    name: str
    parameters: tuple[tuple[str, Type], ...]
    result: Type | None = None


class Scope:
    """The numbered types of a component, or of the description of an instance.

    Parameters
    ----------
    declare
        Writes one definition of a type, which gets the next number.
    """

    def __init__(self, declare: Callable[[bytes], None]) -> None:
        self._declare = declare
        self._numbers: dict[Type | Function, int] = {}
        self._count = 0
        self.named: dict[str, int] = {}

    def take_number(self) -> int:
        """The number of a type that is imported, exported or an alias."""
        self._count += 1
        return self._count - 1

    def rename(self, named: str, number: int) -> None:
        """From here on the name means this number: types that are made of it are defined anew."""
        self.named[named] = number
        self._numbers.clear()

    def define(self, definition: bytes) -> int:
        self._declare(definition)
        return self.take_number()

    def number(self, wanted: Type | Function) -> int:
        """The number of a type that has none of its own yet; it is defined where needed."""
        if isinstance(wanted, Named):
            return self.named[wanted.name]
        if isinstance(wanted, Function):
            wanted = Function("", wanted.parameters, wanted.result)  # functions of one type share the type
        if wanted not in self._numbers:
            self._numbers[wanted] = self.define(self._definition(wanted))
        return self._numbers[wanted]

    def reference(self, wanted: Type) -> bytes:
        """A type as it stands inside another one."""
        if isinstance(wanted, str):
            return signed(PRIMITIVES[wanted])
        return signed(self.number(wanted))

    def _fields(self, fields: tuple[tuple[str, Type], ...]) -> bytes:
        return vector([name(label) + self.reference(content) for label, content in fields])

    def _definition(self, wanted: Type | Function) -> bytes:
        match wanted:
            case Function(_, parameters, None):
                return b"\x40" + self._fields(parameters) + b"\x01\0"
            case Function(_, parameters, Named() | str() as result):
                return b"\x40" + self._fields(parameters) + b"\0" + self.reference(result)
            case Function(_, parameters, result) if result is not None:
                return b"\x40" + self._fields(parameters) + b"\0" + self.reference(result)
            case Record(fields):
                return b"\x72" + self._fields(fields)
            case Enumeration(cases):
                return b"\x6d" + vector([name(case) for case in cases])
            case List(element):
                return b"\x70" + self.reference(element)
            case Tuple(elements):
                return b"\x6f" + vector([self.reference(element) for element in elements])
            case Option(content):
                return b"\x6b" + self.reference(content)
            case Result(good, refused):
                return b"\x6a\x01" + self.reference(good) + b"\x01" + self.reference(refused)
            case Handle(resource, owned):
                return (b"\x69" if owned else b"\x68") + unsigned(self.named[resource])
            case str():
                return signed(PRIMITIVES[wanted])
        raise TypeError(wanted)
