"""The component around the compiled core, in the binary format of the component model.

Parts, in this order: what the host provides; the core and the two small modules of core.py; how the functions
of the core and of the host are translated (`lift` and `lower`); one instance for each interface.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from workspace import BuildError

from webassembly import core
from webassembly.encoding import name, section, unsigned, vector
from webassembly.interface import (
    CO_SIMULATION,
    COMMON,
    LOG_MESSAGE,
    MODEL_EXCHANGE,
    PACKAGE,
    STATUS,
    TYPES,
    VERSION,
    Interface,
)
from webassembly.types import Function, Scope

COMPONENT = b"\0asm\x0d\0\x01\0"
# Numbers of sections.
CORE_MODULE, CORE_INSTANCE, INNER, INSTANCE, ALIAS, TYPE, CANON, IMPORT, EXPORT = 1, 2, 4, 5, 6, 7, 8, 10, 11
# Kinds of what is imported, exported, or an argument.
CORE_FUNCTION, CORE_TABLE, CORE_MEMORY = b"\0", b"\x01", b"\x02"
CORE, FUNCTION_KIND, TYPE_KIND, INSTANCE_KIND = b"\0", b"\x01", b"\x03", b"\x05"
CORE_INSTANCE_KIND = b"\x12"
EQUAL, NEW_RESOURCE = b"\x03\0", b"\x03\x01"  # an imported or exported type

INTERFACES = (CO_SIMULATION, MODEL_EXCHANGE)
HOST = "host"  # the module from which the core imports
SYSTEM = b"wasi_snapshot_preview1"  # the module of system calls
START, ALLOCATE, RELEASE, DROP = "_initialize", "allocate", "release", "drop"  # functions of the core
LATE = (core.Late(LOG_MESSAGE.name, ("i32",) * 7), core.Late(DROP, ("i32",)))


def interface_name(interface: str) -> str:
    return f"{PACKAGE}/{interface}@{VERSION}"


def extern(text: str) -> bytes:
    """The name of an import or export of a component."""
    return b"\0" + name(text)


class Component:
    """A component that grows by sections. Each kind of thing is numbered from 0."""

    def __init__(self) -> None:
        self.content = COMPONENT
        self._counts: dict[str, int] = {}
        self.types = Scope(lambda definition: self.add(TYPE, definition))

    def add(self, number: int, *entries: bytes) -> None:
        self.content += section(number, vector(entries))

    def next(self, kind: str) -> int:
        """The number of a new thing."""
        number = self._counts.get(kind, 0)
        self._counts[kind] = number + 1
        return number

    # ---- modules and instances of the core ----

    def core_module(self, content: bytes) -> int:
        self.content += section(CORE_MODULE, content)
        return self.next("core module")

    def core_instance(self, module: int, arguments: Mapping[str, int]) -> int:
        given = vector([name(k) + CORE_INSTANCE_KIND + unsigned(i) for k, i in arguments.items()])
        self.add(CORE_INSTANCE, b"\0" + unsigned(module) + given)
        return self.next("core instance")

    def core_exports(self, exports: Mapping[str, bytes]) -> int:
        """An instance that passes on what others export. Values: kind of the core and number."""
        self.add(CORE_INSTANCE, b"\x01" + vector([name(k) + what for k, what in exports.items()]))
        return self.next("core instance")

    def core_alias(self, instance: int, exported: str, kind: bytes = CORE_FUNCTION) -> int:
        self.add(ALIAS, CORE + kind + b"\x01" + unsigned(instance) + name(exported))
        return self.next(f"core {kind.hex()}")

    def lower(self, function: int, memory: int) -> int:
        options = vector([b"\0", b"\x03" + unsigned(memory)])  # UTF-8, memory
        self.add(CANON, b"\x01\0" + unsigned(function) + options)
        return self.next(f"core {CORE_FUNCTION.hex()}")

    def new_handle(self, resource: int) -> int:
        self.add(CANON, b"\x02" + unsigned(resource))
        return self.next(f"core {CORE_FUNCTION.hex()}")

    # ---- the component model ----

    def lift(self, function: int, options: Sequence[bytes], kind: Function) -> int:
        kind_number = self.types.number(kind)
        self.add(CANON, b"\0\0" + unsigned(function) + vector(options) + unsigned(kind_number))
        return self.next("function")

    def resource(self, resource: str, drop: int) -> None:
        definition = b"\x3f\x7f\x01" + unsigned(drop)  # stands for an i32
        self.types.rename(resource, self.types.define(definition))

    def import_instance(self, interface: str, description: bytes) -> int:
        kind = self.types.define(description)
        self.add(IMPORT, extern(interface_name(interface)) + INSTANCE_KIND + unsigned(kind))
        return self.next("instance")

    def alias(self, instance: int, exported: str, kind: bytes) -> bytes:
        self.add(ALIAS, kind + b"\0" + unsigned(instance) + name(exported))
        return kind

    def alias_type(self, instance: int, exported: str) -> None:
        self.alias(instance, exported, TYPE_KIND)
        self.types.rename(exported, self.types.take_number())

    def alias_function(self, instance: int, exported: str) -> int:
        self.alias(instance, exported, FUNCTION_KIND)
        return self.next("function")

    def import_type(self, label: str, named: str, bound: bytes) -> None:
        self.add(IMPORT, extern(label) + bound)
        self.types.rename(named, self.types.take_number())

    def import_function(self, label: str, kind: Function) -> int:
        number = self.types.number(kind)
        self.add(IMPORT, extern(label) + FUNCTION_KIND + unsigned(number))
        return self.next("function")

    def export_type(self, named: str) -> None:
        self.add(EXPORT, extern(named) + TYPE_KIND + unsigned(self.types.named[named]) + b"\0")
        self.types.rename(named, self.types.take_number())

    def export_function(self, label: str, function: int, kind: Function) -> None:
        number = self.types.number(kind)
        self.add(
            EXPORT,
            extern(label) + FUNCTION_KIND + unsigned(function) + b"\x01" + FUNCTION_KIND + unsigned(number),
        )
        self.next("function")

    def export_instance(self, interface: str, inner: Component, arguments: Mapping[str, bytes]) -> None:
        """Makes an instance of an inner component and exports it under the name of an interface."""
        self.content += section(INNER, inner.content)
        component = self.next("component")
        given = vector([name(label) + what for label, what in arguments.items()])
        self.add(INSTANCE, b"\0" + unsigned(component) + given)
        made = self.next("instance")
        self.add(EXPORT, extern(interface_name(interface)) + INSTANCE_KIND + unsigned(made) + b"\0")
        self.next("instance")


# ---- descriptions of what the host provides ----


class Description:
    """The description of an instance: a list of declarations."""

    def __init__(self) -> None:
        self.declarations: list[bytes] = []
        self.types = Scope(lambda definition: self.declarations.append(b"\x01" + definition))

    def export_type(self, named: str, number: int) -> None:
        self.declarations.append(b"\x04" + extern(named) + EQUAL + unsigned(number))
        self.types.rename(named, self.types.take_number())

    def outer_type(self, named: str, number: int) -> None:
        """A type of the component around the description, under its name."""
        self.declarations.append(b"\x02" + TYPE_KIND + b"\x02\x01" + unsigned(number))
        self.export_type(named, self.types.take_number())

    def export_function(self, function: Function) -> None:
        number = self.types.number(function)
        self.declarations.append(b"\x04" + extern(function.name) + FUNCTION_KIND + unsigned(number))

    def content(self) -> bytes:
        return b"\x42" + vector(self.declarations)


def described_types() -> bytes:
    description = Description()
    for named, content in TYPES.items():
        number = description.types.number(content)
        description.export_type(named, number)
    return description.content()


def described_callbacks(status: int) -> bytes:
    description = Description()
    description.outer_type(STATUS.name, status)
    description.export_function(LOG_MESSAGE)
    return description.content()


# ---- the interfaces that the component provides ----


def inner_component(interface: Interface) -> Component:
    """A component that gets types and functions, and exports them: so the functions use the exported types.
    The names of what it gets are seen by nobody: numbered, they are short."""
    inner = Component()
    for i, (known, content) in enumerate(interface.types.items()):
        number = inner.types.number(content)
        inner.import_type(f"type{i}", known, EQUAL + unsigned(number))
    if interface.resource:
        inner.import_type("resource", interface.resource, NEW_RESOURCE)
    imported = [inner.import_function(f"function{i}", f) for i, f in enumerate(interface.functions)]
    for exported in interface.exported_types:
        inner.export_type(exported)
    for number, function in zip(imported, interface.functions, strict=True):
        inner.export_function(function.name, number, function)
    return inner


def wrapped(module: bytes) -> bytes:
    """The component around a compiled core, which exports the functions of the room fmu_src/component.

    Raises
    ------
    BuildError
        The core imports a system call, because its C library makes one that the room does not answer.
    """
    if SYSTEM in module:
        raise BuildError(
            "the core of the component imports a system call that system_calls.c does not answer"
        )
    it = Component()
    types = it.import_instance("types", described_types())
    for named in TYPES:
        it.alias_type(types, named)
    callbacks = it.import_instance("callbacks", described_callbacks(it.types.named[STATUS.name]))

    compiled = it.core_module(module)
    calling = it.core_instance(it.core_module(core.callers(LATE)), {})
    filling = it.core_module(core.filler(LATE, START))
    log_message, drop = (it.core_alias(calling, late.name) for late in LATE)
    given = {LOG_MESSAGE.name: CORE_FUNCTION + unsigned(log_message)}
    for interface in INTERFACES:
        it.resource(interface.resource, drop)
        new = it.new_handle(it.types.named[interface.resource])
        given[f"new-{interface.resource}"] = CORE_FUNCTION + unsigned(new)
        for own, content in interface.own_types.items():
            it.types.rename(own, it.types.number(content))
    core_functions = it.core_instance(compiled, {HOST: it.core_exports(given)})

    memory = it.core_alias(core_functions, "memory", CORE_MEMORY)
    lowered = it.lower(it.alias_function(callbacks, LOG_MESSAGE.name), memory)
    late = {LOG_MESSAGE.name: CORE_FUNCTION + unsigned(lowered)}
    for own in (DROP, START):
        late[own] = CORE_FUNCTION + unsigned(it.core_alias(core_functions, own))
    late[core.TABLE_NAME] = CORE_TABLE + unsigned(it.core_alias(calling, core.TABLE_NAME, CORE_TABLE))
    it.core_instance(filling, {"": it.core_exports(late)})

    allocate, release = (it.core_alias(core_functions, own) for own in (ALLOCATE, RELEASE))
    # UTF-8; where texts and lists are; how to allocate them; what to call when the host has read a result.
    options = [
        b"\0",
        *(n + unsigned(i) for n, i in ((b"\x03", memory), (b"\x04", allocate), (b"\x05", release))),
    ]

    def lifted(function: Function) -> bytes:
        own = function.name.partition(".")[2] or function.name
        return FUNCTION_KIND + unsigned(it.lift(it.core_alias(core_functions, own), options, function))

    for interface in (COMMON, *INTERFACES):
        arguments = {f"type{i}": it.types.named[known] for i, known in enumerate(interface.types)}
        arguments |= {"resource": it.types.named[interface.resource]} if interface.resource else {}
        given = {label: TYPE_KIND + unsigned(number) for label, number in arguments.items()}
        given |= {f"function{i}": lifted(f) for i, f in enumerate(interface.functions)}
        it.export_instance(interface.name, inner_component(interface), given)
    return it.content
