"""Drives one FMU by its C functions and records every bit that it returns, for `compare.py`.

FMI 2.0 and FMI 3.0 share one class: the names of their functions differ by a prefix and by some letters, and
FMI 3.0 passes the length of an array of values. A refused call raises nothing: its status is recorded.
"""

from __future__ import annotations

import ctypes
import struct
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Callable, Mapping, Sequence
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Scalar = float | int | bool | str
OK = 0
KIND_OF_TAG = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean", "String": "String"}
STATUS_LABELS = ("status", "log messages")
FORMATS = {"Real": "d", "Integer": "i", "Boolean": "i"}

_LOGGER_2 = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
_LOGGER_3 = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
_UPDATE = ctypes.CFUNCTYPE(
    None, c_void_p, c_double, c_bool, c_bool, c_bool, c_bool, ctypes.POINTER(c_bool), ctypes.POINTER(c_double)
)


class Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", _LOGGER_2),
        ("allocateMemory", c_void_p),
        ("freeMemory", c_void_p),
        ("stepFinished", c_void_p),
        ("componentEnvironment", c_void_p),
    )


class EventInfo(ctypes.Structure):
    """fmi2EventInfo."""

    _fields_ = (*((f"flag{k}", c_int) for k in range(5)), ("nextEventTime", c_double))


@dataclass(frozen=True)
class Variable:
    reference: int
    kind: str  # Real, Integer, Boolean, String
    causality: str
    variability: str


@dataclass(frozen=True)
class Names:
    """What is read of a model at a communication point, by name."""

    reals: tuple[str, ...]
    integers: tuple[str, ...]
    booleans: tuple[str, ...]
    step: tuple[str, ...]  # the derivatives of the latest step, which cost as much as the step
    outputs: tuple[str, ...]
    unknowns: tuple[str, ...]  # of directional derivatives
    knowns: tuple[str, ...]
    states: int  # continuous states of model exchange
    indicators: int


class Fmu:
    """One FMU, unpacked into `folder`, with its library loaded. Names of variables are those of its XML."""

    def __init__(self, path: Path, folder: Path, version: int) -> None:
        self.path, self.version = path, version
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        root = ET.parse(folder / "modelDescription.xml").getroot()
        self.identifier = root.attrib["modelName"]
        self.token = root.attrib["guid" if version == 2 else "instantiationToken"].encode()
        self.resources = folder / "resources"
        self.resources.mkdir(exist_ok=True)
        self.variables = dict(_variables(root))
        self.indicators = int(root.attrib.get("numberOfEventIndicators", "0")) or sum(
            name.startswith("indicator.") for name in self.variables
        )
        platform = "linux64" if version == 2 else "x86_64-linux"
        self.library = ctypes.CDLL(str(folder / "binaries" / platform / f"{self.identifier}.so"))
        for name in ("fmi2Instantiate", "fmi3InstantiateCoSimulation", "fmi3InstantiateModelExchange"):
            if hasattr(self.library, name):
                getattr(self.library, name).restype = c_void_p

    def names(self) -> Names:
        """All that can be read of it."""
        chosen = {n: v for n, v in self.variables.items() if v.causality in ("output", "local")}

        def of(kind: str) -> tuple[str, ...]:
            return tuple(n for n, v in chosen.items() if v.kind == kind and not n.startswith("step."))

        outputs = tuple(n for n, v in chosen.items() if v.causality == "output")
        forward = "alpha" in chosen
        known = [
            n
            for n, v in self.variables.items()
            if v.kind == "Real" and (v.causality == "input" or v.variability == "tunable")
        ]
        return Names(
            of("Real"),
            of("Integer"),
            of("Boolean"),
            tuple(n for n in chosen if n.startswith("step.")),
            outputs,
            (*outputs, "alpha") if forward else outputs,
            (*known, "theta", "omega") if forward else tuple(known),
            2 if forward else 0,
            self.indicators,
        )


def _variables(root: ET.Element) -> list[tuple[str, Variable]]:
    listed = root.find("ModelVariables")
    assert listed is not None
    found = []
    for element in listed:
        kind = element[0].tag if element.tag == "ScalarVariable" else KIND_OF_TAG[element.tag]
        given = element.attrib
        place = int(given["valueReference"]), kind, given["causality"], given.get("variability", "continuous")
        found.append((given["name"], Variable(*place)))
    return found


class Record:
    """What one scene returned: rows of (time, what was read, bytes)."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, str, bytes]] = []
        self.values = 0
        self.refusals: dict[int, str] = {}  # by index of a row: message of the call that failed
        self.labels: dict[str, tuple[tuple[str, ...], str]] = {}  # of a row: names and format of its values

    def add(self, time: float, what: str, data: bytes, labels: Sequence[str], kind: str = "d") -> None:
        """`kind`: the format of struct, d or i."""
        if what not in self.labels:
            self.labels[what] = tuple(labels), kind
        self.rows.append((time, what, data))
        self.values += len(labels)

    def add_reals(self, time: float, what: str, values: Sequence[float], labels: Sequence[str]) -> None:
        self.add(time, what, struct.pack(f"{len(values)}d", *values), labels)


class _Buffer:
    """Value references and memory of a group of variables, laid out once."""

    def __init__(self, fmu: Fmu, names: Sequence[str], kind: str) -> None:
        self.names, self.kind, self.count = tuple(names), kind, len(names)
        self.references = (c_uint * self.count)(*(fmu.variables[n].reference for n in names))
        boolean_3 = kind == "Boolean" and fmu.version == 3
        element: Any = c_bool if boolean_3 else c_double if kind == "Real" else c_int
        self.values: Any = (element * self.count)()
        self.sizes = (c_size_t(self.count),) if fmu.version == 3 else ()


class Instance:
    """One instance and the record of what it returned."""

    def __init__(self, fmu: Fmu, names: Names, record: Record, use: str, *, events: bool = False) -> None:
        """use: `co-simulation` or `exchange`. events (FMI 3.0): with event mode and early return."""
        self.fmu, self.names, self.record, self.use, self.events = fmu, names, record, use, events
        self.time, self.messages, self.text = 0.0, 0, ""
        self.input_at: Callable[[float], Mapping[str, float]] | None = None
        self._prefix = f"fmi{fmu.version}"
        self._state = "FMUstate" if fmu.version == 2 else "FMUState"
        self._groups: dict[tuple[str, ...], _Buffer] = {}
        self._states: list[c_void_p] = []
        self._keep: Any = None
        self.component = c_void_p(self._instantiate())
        self._reads = [
            (what, self._buffer(group, kind))
            for what, group, kind in (
                ("reals", names.reals, "Real"),
                ("integers", names.integers, "Integer"),
                ("booleans", names.booleans, "Boolean"),
            )
            if group
        ]

    def _instantiate(self) -> int:
        library, token = self.fmu.library, self.fmu.token
        if self.fmu.version == 2:
            logger = _LOGGER_2(lambda *message: self._log(message[-1]))
            callbacks = Callbacks(logger=logger)
            self._keep = logger, callbacks
            kind, uri = int(self.use == "co-simulation"), self.fmu.resources.as_uri().encode()
            return library.fmi2Instantiate(b"scene", kind, token, uri, byref(callbacks), 0, 0)
        resources = f"{self.fmu.resources}/".encode()
        logger_3 = _LOGGER_3(lambda *message: self._log(message[-1]))
        texts = b"scene", token, resources, c_bool(False), c_bool(False)
        if self.use == "exchange":
            self._keep = logger_3
            return library.fmi3InstantiateModelExchange(*texts, None, logger_3)
        update = _UPDATE(self._update) if self.events else _UPDATE()
        self._keep = logger_3, update
        sampled = [n for n, v in self.fmu.variables.items() if v.causality == "input"] if self.events else []
        references = (c_uint * len(sampled))(*(self.fmu.variables[n].reference for n in sampled))
        flags = c_bool(self.events), c_bool(self.events)
        return library.fmi3InstantiateCoSimulation(
            *texts, *flags, references, c_size_t(len(sampled)), None, logger_3, update
        )

    def _log(self, text: bytes) -> None:
        self.messages += 1
        self.text = text.decode(errors="replace")

    def _update(self, _environment: object, time: float, asks: bool, *_: object) -> None:
        """fmi3IntermediateUpdate: the inputs at the times at which the FMU asks for them."""
        if asks and self.input_at is not None:
            for name, value in self.input_at(time).items():
                self._set_one(name, value)

    def _buffer(self, names: Sequence[str], kind: str) -> _Buffer:
        key = (kind, *names)
        if key not in self._groups:
            self._groups[key] = _Buffer(self.fmu, names, kind)
        return self._groups[key]

    def _function(self, name: str) -> Callable[..., int]:
        return getattr(self.fmu.library, self._prefix + name)

    def call(self, name: str, *arguments: object) -> int:
        """Call that function; its status and the number of log messages so far are recorded."""
        status = self._function(name)(self.component, *arguments)
        self._record_status(f"{self._prefix}{name}", status)
        return status

    def _record_status(self, what: str, status: int) -> None:
        if status != OK:
            self.record.refusals[len(self.record.rows)] = self.text
        self.record.add(self.time, what, struct.pack("2i", status, self.messages), STATUS_LABELS, "i")

    # ---- start ----

    def enter(self, parameters: Mapping[str, Scalar], tolerance: float | None) -> bool:
        """To initialization mode. False if the FMU refuses."""
        self.set(parameters)
        given, value = tolerance is not None, c_double(tolerance or 0.0)
        if self.fmu.version == 2:
            self.call("SetupExperiment", c_int(given), value, c_double(0.0), c_int(0), c_double(0.0))
            return self.call("EnterInitializationMode") == OK
        times = c_double(0.0), c_bool(False), c_double(0.0)
        return self.call("EnterInitializationMode", c_bool(given), value, *times) == OK

    def leave(self) -> bool:
        """Initialization mode, and event mode behind it. False if the FMU refuses."""
        if self.call("ExitInitializationMode") != OK:
            return False
        if self.events or self.use == "exchange":
            self.settle()
        return True

    def start(self, parameters: Mapping[str, Scalar], tolerance: float | None) -> bool:
        """To the end of initialization mode. False if the FMU refuses."""
        return self.enter(parameters, tolerance) and self.leave()

    def reset(self) -> None:
        self.call("Reset")
        self.time = 0.0

    # ---- variables ----

    def _set_one(self, name: str, value: Scalar) -> int:
        variable = self.fmu.variables[name]
        kind = variable.kind
        content: Any
        if kind == "Real":
            content = c_double(value)  # type: ignore[arg-type]
        elif kind == "String":
            content = c_char_p(str(value).encode())
        else:
            content = (c_bool if kind == "Boolean" and self.fmu.version == 3 else c_int)(value)  # type: ignore[arg-type]
        sizes = (c_size_t(1),) if self.fmu.version == 3 else ()
        verb = {"Real": "Float64", "Integer": "Int32"}.get(kind, kind) if self.fmu.version == 3 else kind
        reference = c_uint(variable.reference)
        return self._function(f"Set{verb}")(
            self.component, byref(reference), c_size_t(1), byref(content), *sizes
        )

    def set(self, values: Mapping[str, Scalar]) -> None:
        """A refused value is recorded."""
        for name, value in values.items():
            status = self._set_one(name, value)
            if status != OK:
                self._record_status(f"set {name}", status)

    def set_derivatives(self, derivatives: Mapping[str, Sequence[float]]) -> None:
        """FMI 2.0: derivatives of inputs by time, orders 1 to 3, for the next step."""
        flat = [(n, k, d) for n, ds in derivatives.items() for k, d in enumerate(ds, start=1)]
        if not flat:
            return
        count = len(flat)
        references = (c_uint * count)(*(self.fmu.variables[n].reference for n, _, _ in flat))
        orders = (c_int * count)(*(k for _, k, _ in flat))
        values = (c_double * count)(*(d for _, _, d in flat))
        self.call("SetRealInputDerivatives", references, c_size_t(count), orders, values)

    def _read(self, what: str, group: _Buffer) -> None:
        kind = group.kind
        verb = {"Real": "Float64", "Integer": "Int32"}.get(kind, kind) if self.fmu.version == 3 else kind
        status = self._function(f"Get{verb}")(
            self.component, group.references, c_size_t(group.count), group.values, *group.sizes
        )
        data = bytes(group.values)
        if kind == "Boolean" and self.fmu.version == 3:
            data = struct.pack(f"{group.count}i", *group.values)
        if status != OK:
            self._record_status(f"get {what}", status)
        self.record.add(self.time, what, data, group.names, FORMATS[kind])

    def read(self) -> None:
        """All outputs and locals, those of the latest step apart."""
        for what, group in self._reads:
            self._read(what, group)

    def read_step(self) -> None:
        """The derivatives of the latest step."""
        if self.names.step:
            self._read("step", self._buffer(self.names.step, "Real"))

    def read_output_derivatives(self) -> None:
        """Of all outputs, orders 1 and 2. FMI 3.0 has the function in co-simulation alone."""
        if self.fmu.version == 3 and self.use == "exchange":
            return
        name = "GetRealOutputDerivatives" if self.fmu.version == 2 else "GetOutputDerivatives"
        group = self._buffer(self.names.outputs, "Real")
        for order in (1, 2):
            orders = (c_int * group.count)(*[order] * group.count)
            function = self._function(name)
            size = c_size_t(group.count)
            status = function(self.component, group.references, size, orders, group.values, *group.sizes)
            what = f"output derivatives of order {order}"
            if status != OK:
                self._record_status(f"status of {what}", status)
            self.record.add(self.time, what, bytes(group.values), group.names)

    def read_jacobian(self) -> None:
        """Partial derivatives of all unknowns by all knowns; where they are refused together, one by one."""
        for known in self.names.knowns:
            if self.read_derivatives(self.names.unknowns, known) != OK:
                for unknown in self.names.unknowns:
                    self.read_derivatives((unknown,), known)

        if self.fmu.version == 3:
            self._read_adjoint()

    def _read_adjoint(self) -> None:
        """FMI 3.0: partial derivatives of each unknown by all knowns."""
        columns = self._buffer(self.names.knowns, "Real")
        seed, one = byref(c_double(1.0)), c_size_t(1)
        for unknown in self.names.unknowns:
            reference = byref(c_uint(self.fmu.variables[unknown].reference))
            pair = reference, one, columns.references, c_size_t(columns.count)
            result = columns.values, c_size_t(columns.count)
            if self.call("GetAdjointDerivative", *pair, seed, one, *result) == OK:
                what = f"adjoint derivatives of {unknown}"
                self.record.add(self.time, what, bytes(columns.values), columns.names)

    def read_derivatives(self, unknowns: tuple[str, ...], known: str) -> int:
        """Partial derivatives by `known`; the status."""
        rows = self._buffer(unknowns, "Real")
        reference, seed = byref(c_uint(self.fmu.variables[known].reference)), byref(c_double(1.0))
        arguments = rows.references, c_size_t(rows.count), reference, c_size_t(1), seed
        sizes = (c_size_t(1), rows.values, c_size_t(rows.count)) if rows.sizes else (rows.values,)
        status = self._function("GetDirectionalDerivative")(self.component, *arguments, *sizes)
        what = f"derivative{'s' if len(unknowns) > 1 else f' of {unknowns[0]}'} by {known}"
        if status == OK:
            self.record.add(self.time, what, bytes(rows.values), rows.names)
        else:
            self._record_status(f"status of {what}", status)
        return status

    # ---- co-simulation ----

    def step(self, length: float) -> bool:
        """One step; with early return, up to `length`. False if the FMU refuses."""
        if self.fmu.version == 2:
            status = self.call("DoStep", c_double(self.time), c_double(length), c_int(1))
            self.time += length if status == OK else 0.0
            return status == OK
        flags, reached = [c_bool() for _ in range(3)], c_double()
        pointers = [byref(flag) for flag in flags]
        status = self.call(
            "DoStep", c_double(self.time), c_double(length), c_bool(True), *pointers, byref(reached)
        )
        if status == OK:
            self.time = reached.value
            ends = (*(float(flag.value) for flag in flags), self.time)
            self.record.add_reals(
                self.time, "end of step", ends, ("event handling", "terminate", "early", "time")
            )
            if self.events and flags[0].value:
                self.call("EnterEventMode")
                self.settle()
        return status == OK

    def settle(self) -> None:
        """Event mode to its end."""
        if self.fmu.version == 2:
            info = EventInfo()
            self.call("NewDiscreteStates", byref(info))
            flags = [float(getattr(info, f"flag{k}")) for k in range(5)]
        else:
            found, time = [c_bool() for _ in range(5)], c_double()
            self.call("UpdateDiscreteStates", *(byref(flag) for flag in found), byref(time))
            flags = [float(flag.value) for flag in found]
        self.record.add_reals(self.time, "discrete states", flags, [f"flag {k}" for k in range(5)])
        self.call("EnterContinuousTimeMode" if self.use == "exchange" else "EnterStepMode")

    # ---- model exchange ----

    def set_continuous(self, time: float, states: Sequence[float]) -> None:
        self.time = time
        self.call("SetTime", c_double(time))
        self.call("SetContinuousStates", (c_double * len(states))(*states), c_size_t(len(states)))

    def vector(self, function: str, count: int, what: str) -> list[float]:
        """What a function such as fmi2GetDerivatives writes, recorded."""
        values = (c_double * count)()
        self.call(function, values, c_size_t(count))
        self.record.add(self.time, what, bytes(values), [f"{what}[{k}]" for k in range(count)])
        return list(values)

    def completed_step(self) -> bool:
        """Does it ask for event mode?"""
        flag = c_int if self.fmu.version == 2 else c_bool
        enter, terminate = flag(), flag()
        self.call("CompletedIntegratorStep", flag(1), byref(enter), byref(terminate))
        data = float(enter.value), float(terminate.value)
        self.record.add_reals(self.time, "completed step", data, ("enter event mode", "terminate"))
        return bool(enter.value)

    # ---- FMU states ----

    def take_state(self) -> c_void_p:
        state = c_void_p()
        self.call(f"Get{self._state}", byref(state))
        self._states.append(state)
        return state

    def restore_state(self, state: c_void_p, time: float) -> None:
        self.call(f"Set{self._state}", state)
        self.time = time

    def serialized_size(self, state: c_void_p) -> int:
        size = c_size_t()
        self._function(f"Serialized{self._state}Size" if self.fmu.version == 2 else "SerializedFMUStateSize")(
            self.component, state, byref(size)
        )
        return size.value

    def copy_state(self, state: c_void_p) -> c_void_p:
        """Through bytes."""
        size, copy = self.serialized_size(state), c_void_p()
        content = ctypes.create_string_buffer(size)
        self.call(f"Serialize{self._state}", state, content, c_size_t(size))
        name = "DeSerializeFMUstate" if self.fmu.version == 2 else "DeserializeFMUState"
        self.call(name, content, c_size_t(size), byref(copy))
        self._states.append(copy)
        return copy

    def free(self) -> None:
        for state in self._states:
            self._function(f"Free{self._state}")(self.component, byref(state))
        self._function("FreeInstance")(self.component)
