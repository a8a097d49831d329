"""The FMU as a WebAssembly module in wasmtime, which counts the operations of each call and ends a call that
needs too many. So a test bounds the work of a call on any machine by a number that repeats, not by a time.

The module is that of a page in a browser (build/web): the code of the FMU of FMI 2.0, and a function that
keeps the last message.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
from driver import CO_SIMULATION, ERROR, MODEL_EXCHANGE, OK, ROOT, Model

wasmtime = pytest.importorskip(
    "wasmtime", reason="counting operations needs wasmtime: pip install -e '.[test]'"
)

CODES = {"Real": "d", "Integer": "i", "Boolean": "i"}  # of the module struct
ROOM = 1 << 16  # bytes, for the arguments of a call
# Times the operations of a step: reading its derivatives makes each segment again, with derivatives.
DERIVATIVES_OF_STEP = 2


class TooMuchWork(Exception):
    """A call needed more operations than allowed."""


class FuelledModule:
    """One model, in which instances live one after the other. `folder`: files that the model may read."""

    def __init__(self, model: Model, fuel: int, folder: Path) -> None:
        path = ROOT / "build" / "web" / f"{model.identifier}.wasm"
        if not path.exists():
            pytest.skip(f"{path.name} is missing: run ./build.sh")
        configuration = wasmtime.Config()
        configuration.consume_fuel = True
        engine = wasmtime.Engine(configuration)
        self.model, self.fuel, self.most, self.longest = model, fuel, 0, ""
        linker = wasmtime.Linker(engine)
        linker.define_wasi()
        self.store = wasmtime.Store(engine)
        wasi = wasmtime.WasiConfig()
        wasi.preopen_dir(str(folder), "/")
        self.store.set_wasi(wasi)
        self.store.set_fuel(fuel)
        module = wasmtime.Module.from_file(engine, str(path))
        self.exports = linker.instantiate(self.store, module).exports(self.store)
        self.memory = self.exports["memory"]
        self.run("_initialize")
        self.room = self.run("malloc", ROOM)
        self.used = 0
        self.instance = 0

    def run(self, name: str, *arguments: float, share: int = 1) -> int:
        """A call within `share` times the limit of operations."""
        fuel = share * self.fuel
        self.store.set_fuel(fuel)
        try:
            result = self.exports[name](self.store, *arguments)
        except wasmtime.Trap as trap:
            raise TooMuchWork(f"{name}: {trap}") from trap
        work = fuel - self.store.get_fuel()
        if work > self.most:
            self.most, self.longest = work, name
        return result

    # memory

    def write(self, code: str, values: Sequence[float]) -> int:
        """The address of these values, until release()."""
        content = struct.pack(f"<{len(values)}{code}", *values)
        place = self.room + self.used
        self.used += -(-len(content) // 8) * 8
        assert self.used <= ROOM
        self.memory.write(self.store, content, place)
        return place

    def read(self, code: str, place: int, count: int) -> list[float]:
        size = struct.calcsize(f"<{count}{code}")
        return list(struct.unpack(f"<{count}{code}", self.memory.read(self.store, place, place + size)))

    def text(self, text: str) -> int:
        return self.write("B", [*text.encode(), 0])

    def message(self) -> str:
        place = self.run("web_message")
        return bytes(self.memory.read(self.store, place, place + 2048)).split(b"\0")[0].decode()

    # the FMI interface

    def call(self, name: str, *arguments: float, share: int = 1) -> int:
        status = self.run(f"fmi2{name}", self.instance, *arguments, share=share)
        self.used = 0
        return status

    def begin(self, kind: int = CO_SIMULATION) -> None:
        """A new instance. In model exchange no message is kept."""
        if self.instance:
            self.run("fmi2FreeInstance", self.instance)
        guid, resources = self.text(self.model.guid), self.text("file:///")
        if kind == MODEL_EXCHANGE:
            callbacks = self.write("i", [0] * 5)
            self.instance = self.run("fmi2Instantiate", guid, kind, guid, resources, callbacks, 0, 0)
        else:
            self.instance = self.run("web_instantiate", guid, resources)
        self.used = 0
        assert self.instance

    def references(self, names: Sequence[str]) -> int:
        return self.write("I", [self.model.variables[name].reference for name in names])

    def set(self, name: str, value: float | str) -> int:
        kind = self.model.variables[name].type
        if kind == "String":
            place = self.write("I", [self.text(str(value))])
        else:
            place = self.write(CODES[kind], [value])
        return self.call(f"Set{kind}", self.references([name]), 1, place)

    def get(self, names: Sequence[str]) -> list[float] | None:
        """The values of Real variables; None: refused."""
        place = self.write("d", [0.0] * len(names))
        share = DERIVATIVES_OF_STEP if any(name.startswith("step.d") for name in names) else 1
        status = self.call("GetReal", self.references(names), len(names), place, share=share)
        return self.read("d", place, len(names)) if status == OK else None

    def set_derivatives(self, name: str, rates: Sequence[float]) -> int:
        count = len(rates)
        orders, place = self.write("i", range(1, count + 1)), self.write("d", rates)
        return self.call("SetRealInputDerivatives", self.references([name] * count), count, orders, place)

    def output_derivative(self, name: str, order: int) -> list[float] | None:
        place = self.write("d", [0.0])
        orders = self.write("i", [order])
        status = self.call("GetRealOutputDerivatives", self.references([name]), 1, orders, place)
        return self.read("d", place, 1) if status == OK else None

    def partial_derivative(self, unknown: str, known: str) -> list[float] | None:
        place = self.write("d", [0.0])
        one = self.write("d", [1.0])
        known_place, unknown_place = self.references([known]), self.references([unknown])
        status = self.call("GetDirectionalDerivative", unknown_place, 1, known_place, 1, one, place)
        return self.read("d", place, 1) if status == OK else None

    def vector(self, function: str, count: int) -> list[float] | None:
        """What GetDerivatives or GetEventIndicators gives."""
        place = self.write("d", [0.0] * count)
        return self.read("d", place, count) if self.call(function, place, count) == OK else None

    def start(self, values: Mapping[str, float | str]) -> str:
        """To the end of initialization mode. Why the values are refused, or nothing."""
        refused = any(self.set(name, value) != OK for name, value in values.items())
        if not refused:
            assert self.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0) == OK
            assert self.call("EnterInitializationMode") == OK
            refused = self.call("ExitInitializationMode") == ERROR
        return self.message() if refused else ""
