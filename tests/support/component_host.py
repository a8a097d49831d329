"""A host for the WebAssembly component of an FMU of FMI 3.0: wasmtime, which shares no code with the build.

The functions have the names of the draft fmi-ls-wasm, with underscores. A refused call raises Refused with
the status and the FMU's message.
"""

from __future__ import annotations

import zipfile
from functools import cache
from pathlib import Path

import pytest

wasmtime = pytest.importorskip(
    "wasmtime", reason="the WebAssembly component needs wasmtime: pip install -e '.[test]'"
)
from wasmtime.component import Component, Linker  # noqa: E402

FOLDER = "binaries/wasm32-wasip2"
CALLBACKS = "fmi:fmi3/callbacks@3.0.0"
STATUS = ("ok", "warning", "discard", "error", "fatal")


class Refused(Exception):
    """What a call returned in place of a result, and the messages since the call before."""


def component_of(fmu: Path) -> bytes:
    """The component in an FMU."""
    with zipfile.ZipFile(fmu) as archive:
        name = f"{FOLDER}/{fmu.stem}.wasm"
        if name not in archive.namelist():
            pytest.skip(f"{fmu.name} was not built for wasm32-wasip2: run ./build.sh run all")
        return archive.read(name)


ENGINE = wasmtime.Engine()


@cache
def compiled(content: bytes) -> Component:
    return Component(ENGINE, content)


class Host:
    """One instance of the component, with a log and at most `memory` bytes."""

    def __init__(self, content: bytes, memory: int = -1) -> None:
        self.component, self.engine = compiled(content), ENGINE
        self.store, self.log = wasmtime.Store(ENGINE), []
        self.store.set_limits(memory_size=memory)
        linker = Linker(ENGINE)
        with linker.root() as root, root.add_instance(CALLBACKS) as callbacks:
            callbacks.add_func("log-message", lambda _, *message: self.log.append(message))
        self.instance = linker.instantiate(self.store, self.component)
        self.functions = {}

    def call(self, interface: str, name: str, *arguments):
        """The result of a function; a status other than ok is an error."""
        key = (interface, name)
        if key not in self.functions:
            place = self.instance.get_export_index(self.store, f"fmi:fmi3/{interface}@3.0.0")
            index = self.instance.get_export_index(self.store, name, place)
            assert index is not None, f"{interface} has no function {name}"
            self.functions[key] = self.instance.get_func(self.store, index)
        before = len(self.log)
        result = self.functions[key](self.store, *arguments)
        self.functions[key].post_return(self.store)
        if isinstance(result, str) and result in STATUS[1:]:
            raise Refused(result, self.log[before:])
        return result

    def instantiate(self, token: str, interface: str = "co-simulation", path: str = "", **options) -> Handle:
        own = {"event_mode": False, "early_return": False, "required": []} | options
        arguments = ["one", token, path, False, False]
        arguments += own.values() if interface == "co-simulation" else []
        name = f"[static]{interface}-instance.instantiate-{interface}"
        handle = self.call(interface, name, *arguments)
        if handle is None:
            raise Refused("none", self.log[-1:])
        return Handle(self, interface, handle)


class Handle:
    """One instance of the FMU. `handle.do_step(...)` is the method `do-step` of its resource."""

    def __init__(self, host: Host, interface: str, handle) -> None:
        self._host, self._interface, self._handle = host, interface, handle

    def __getattr__(self, name: str):
        method = f"[method]{self._interface}-instance.{name.replace('_', '-')}"
        return lambda *arguments: self._host.call(self._interface, method, self._handle, *arguments)

    def drop(self) -> None:
        self._handle.drop(self._host.store)


TYPES = {
    "real": ("float64", float),
    "integer": ("int32", int),
    "boolean": ("boolean", bool),
    "string": ("string", str),
}


class Run:
    """Co-simulation by the names of variables, with the methods of dualcam.Fmu that the tests use."""

    def __init__(
        self, content: bytes, description, parameters=None, start_time: float = 0.0, **options
    ) -> None:
        self.host = Host(content)
        self.variables = {v.name: v for v in description.variables}
        self.handle = self.host.instantiate(description.guid, **options)
        self.time = 0.0
        for name, value in (parameters or {}).items():
            self.set(name, value)
        self.handle.enter_initialization_mode(None, 0.0, None)
        self.handle.exit_initialization_mode()

    def _method(self, verb: str, name: str):
        return getattr(self.handle, f"{verb}_{TYPES[self.variables[name].kind][0]}")

    def get(self, name: str):
        return self._method("get", name)([self.variables[name].value_reference])[0]

    def set(self, name: str, value) -> None:
        self._method("set", name)(
            [self.variables[name].value_reference], [TYPES[self.variables[name].kind][1](value)]
        )

    def reals(self, names) -> list[float]:
        return self.handle.get_float64([self.variables[name].value_reference for name in names])

    def step(self, size: float):
        result = self.handle.do_step(self.time, size, True)
        self.time = getattr(result, "last-successful-time")
        return result
