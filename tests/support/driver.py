"""Drives the FMU's C functions by name, without hiding a status or a message.

fmpy's FMU2Slave raises on the first error and supplies its own logger; here an error is often what is
wanted, so the binary is called directly.
"""

import ctypes
import math
import xml.etree.ElementTree as ET
from ctypes import CFUNCTYPE, POINTER, Structure, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

OK, DISCARD, ERROR = 0, 2, 3
MODEL_EXCHANGE, CO_SIMULATION = 0, 1
DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED = range(4)
UNKNOWN_REFERENCE = 4_000_000_000

INSTANTIATED, INITIALIZATION, STEP, END = "instantiated", "initialization mode", "step mode", "terminated"
PHASES = [INSTANTIATED, INITIALIZATION, STEP, END]


@dataclass(frozen=True)
class Variable:
    name: str
    reference: int
    type: str
    causality: str
    variability: str
    start: float | int | bool | str | None
    min: float
    max: float
    unit: str | None
    index: int  # place in the XML, from 1


def _number(element: ET.Element, name: str, default: float) -> float:
    return float(element.attrib[name]) if name in element.attrib else default


def _variable(element: ET.Element, index: int) -> Variable:
    kind = element[0]
    read = {"Real": float, "Integer": int, "Boolean": lambda text: text == "true", "String": str}[kind.tag]
    return Variable(
        element.attrib["name"],
        int(element.attrib["valueReference"]),
        kind.tag,
        element.attrib["causality"],
        element.attrib["variability"],
        read(kind.attrib["start"]) if "start" in kind.attrib else None,
        _number(kind, "min", -math.inf),
        _number(kind, "max", math.inf),
        kind.attrib.get("unit"),
        index,
    )


class Description:
    """An FMU as its modelDescription.xml describes it."""

    FOLDER = ""  # subfolder of build/ and of modelDescription/
    TOKEN = "guid"

    def __init__(self, identifier: str) -> None:
        self.identifier = identifier
        self.fmu = ROOT / "build" / self.FOLDER / f"{identifier}.fmu"
        self.xml = ROOT / "modelDescription" / self.FOLDER / f"{identifier}.xml"

    def __repr__(self) -> str:
        return self.identifier

    @cached_property
    def document(self) -> ET.Element:
        return ET.parse(self.xml).getroot()

    @cached_property
    def guid(self) -> str:
        return self.document.attrib[self.TOKEN]

    @cached_property
    def variables(self) -> dict[str, Variable]:
        raise NotImplementedError

    def names(self, **wanted: list[str]) -> list[str]:
        """Names of the variables with these attributes."""
        return [n for n, v in self.variables.items() if all(getattr(v, k) in w for k, w in wanted.items())]

    def references(self, names):
        """C array of the value references of these names. A number among the names is a value reference."""
        return (c_uint * len(names))(
            *(self.variables[n].reference if isinstance(n, str) else n for n in names)
        )


class Model(Description):
    """Description of an FMU of FMI 2.0."""

    @cached_property
    def listed(self) -> list[Variable]:
        """All variables of the XML. At its end, states and their derivatives have a second name."""
        elements = enumerate(self.document.iter("ScalarVariable"), start=1)
        return [_variable(element, index) for index, element in elements]

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """Variables by their first name."""
        first: dict[int, Variable] = {}
        for variable in self.listed:
            first.setdefault(variable.reference, variable)
        return {v.name: v for v in first.values()}

    @cached_property
    def by_index(self) -> dict[int, str]:
        """First name of the variable at each place of the XML, from 1."""
        first = {v.reference: v.name for v in self.variables.values()}
        return {v.index: first[v.reference] for v in self.listed}


models = {name: Model(name) for name in ("DualCamForward", "DualCamInverse")}

# Most tests are about the forward FMU.
FORWARD = models["DualCamForward"]
FMU, XML, GUID, VARIABLES = FORWARD.fmu, FORWARD.xml, FORWARD.guid, FORWARD.variables
VALUE = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}

LOGGER = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


class Callbacks(Structure):
    _fields_ = (
        ("logger", LOGGER),
        ("allocateMemory", c_void_p),
        ("freeMemory", c_void_p),
        ("stepFinished", c_void_p),
        ("componentEnvironment", c_void_p),
    )


class EventInfo(Structure):
    _fields_ = (
        *((name, c_int) for name in (
            "newDiscreteStatesNeeded", "terminateSimulation", "nominalsOfContinuousStatesChanged",
            "valuesOfContinuousStatesChanged", "nextEventTimeDefined",
        )),
        ("nextEventTime", c_double),
    )  # fmt: skip


_REFERENCES, _ORDERS = POINTER(c_uint), POINTER(c_int)
_VECTOR = (POINTER(c_double), c_size_t)
_ACCESS = {
    f"fmi2{way}{t}": (_REFERENCES, c_size_t, POINTER(VALUE[t])) for t in VALUE for way in ("Get", "Set")
}
_STATUS = {"": c_int, "Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}
# arguments after the instance
ARGUMENTS = {
    **_ACCESS,
    **{f"fmi2Get{t}Status": (c_int, POINTER(value)) for t, value in _STATUS.items()},
    "fmi2SetDebugLogging": (c_int, c_size_t, POINTER(c_char_p)),
    "fmi2SetupExperiment": (c_int, c_double, c_double, c_int, c_double),
    "fmi2EnterInitializationMode": (),
    "fmi2ExitInitializationMode": (),
    "fmi2Terminate": (),
    "fmi2Reset": (),
    "fmi2GetFMUstate": (POINTER(c_void_p),),
    "fmi2SetFMUstate": (c_void_p,),
    "fmi2FreeFMUstate": (POINTER(c_void_p),),
    "fmi2SerializedFMUstateSize": (c_void_p, POINTER(c_size_t)),
    "fmi2SerializeFMUstate": (c_void_p, c_char_p, c_size_t),
    "fmi2DeSerializeFMUstate": (c_char_p, c_size_t, POINTER(c_void_p)),
    "fmi2GetDirectionalDerivative": (
        _REFERENCES, c_size_t, _REFERENCES, c_size_t, POINTER(c_double), POINTER(c_double),
    ),
    "fmi2SetRealInputDerivatives": (_REFERENCES, c_size_t, _ORDERS, POINTER(c_double)),
    "fmi2GetRealOutputDerivatives": (_REFERENCES, c_size_t, _ORDERS, POINTER(c_double)),
    "fmi2DoStep": (c_double, c_double, c_int),
    "fmi2CancelStep": (),
    "fmi2EnterEventMode": (),
    "fmi2NewDiscreteStates": (POINTER(EventInfo),),
    "fmi2EnterContinuousTimeMode": (),
    "fmi2CompletedIntegratorStep": (c_int, POINTER(c_int), POINTER(c_int)),
    "fmi2SetTime": (c_double,),
    "fmi2SetContinuousStates": _VECTOR,
    "fmi2GetContinuousStates": _VECTOR,
    "fmi2GetDerivatives": _VECTOR,
    "fmi2GetEventIndicators": _VECTOR,
    "fmi2GetNominalsOfContinuousStates": _VECTOR,
}  # fmt: skip


def load(binary: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(binary))
    for name, arguments in ARGUMENTS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = c_int, (c_void_p, *arguments)
    library.fmi2Instantiate.restype = c_void_p
    library.fmi2Instantiate.argtypes = (
        c_char_p, c_int, c_char_p, c_char_p, POINTER(Callbacks), c_int, c_int,
    )  # fmt: skip
    library.fmi2FreeInstance.restype = None
    library.fmi2FreeInstance.argtypes = (c_void_p,)
    for name in ("fmi2GetVersion", "fmi2GetTypesPlatform"):
        getattr(library, name).restype = c_char_p
    return library


references = FORWARD.references


def layout_code(structures: list[type[Structure]]) -> str:
    """C code that compiles only if these have the members, places and sizes of the C structs of the same
    names. Past the end of a structure that lacks one, C writes into whatever is there: Python fails later."""
    lines = []
    for structure in structures:
        name = structure.__name__
        places = {f"sizeof({name})": ctypes.sizeof(structure)}
        for member, *_ in structure._fields_:
            field = getattr(structure, member)
            places[f"offsetof({name}, {member})"] = field.offset
            places[f"sizeof((({name} *)0)->{member})"] = field.size
        lines += [f'_Static_assert({place} == {n}, "{name}");' for place, n in places.items()]
    return "\n".join(lines) + "\n"


def to_c(type_, values, types=VALUE):
    encoded = [v.encode() if isinstance(v, str) else v for v in values]
    return (types[type_] * len(encoded))(*encoded)


@dataclass(frozen=True)
class Message:
    instance: str
    status: int
    category: str
    text: str


class Calls:
    """One instance, whatever the version of FMI. `set`, `get`, `start`, `step` and the like insist on OK;
    `call` and the `try_` forms return the status; `refused` insists on an error that is what it should be.
    Names of functions may lack their prefix."""

    PREFIX: str
    VALUE: dict[str, type]  # C type of each type of variable
    STATE: str  # the word for an FMU state in names of functions
    WITH_SIZE: bool  # is an array of values followed by its length in a call?
    REASONS: tuple[str, ...]  # the message of a refusal has one of these words

    def __init__(self, library: ctypes.CDLL, model: Description) -> None:
        self.library, self.model, self.variables = library, model, model.variables
        self.instance: int | None = None
        self.messages: list[Message] = []
        self.time = 0.0

    def full(self, function: str) -> str:
        return function if function.startswith(self.PREFIX) else f"{self.PREFIX}{function}"

    def free(self) -> None:
        self.call("FreeInstance")
        self.instance = None

    def call(self, function: str, *arguments) -> int:
        return getattr(self.library, self.full(function))(self.instance, *arguments)

    def ok(self, function: str, *arguments) -> None:
        status = self.call(function, *arguments)
        assert status == OK, f"{function}: {status}, {self.messages[-1:]}"

    def refused(self, function: str, *arguments, mentions: tuple[str, ...] = ()) -> str:
        """The call is an error with exactly one message and has changed nothing."""
        before, count = self.everything(), len(self.messages)
        assert self.call(function, *arguments) == ERROR
        assert len(self.messages) == count + 1
        message = self.messages[-1]
        assert (message.status, message.category) == (ERROR, "logStatusError")
        assert self.full(function) in message.text
        assert any(word in message.text for word in self.REASONS)
        for word in mentions:
            assert word in message.text
        assert self.everything() == before
        return message.text

    # variables

    def type_of(self, names) -> str:
        """The type that all these variables share."""
        (type_,) = {self.variables[n].type for n in names}
        return type_

    def access(self, names, values: ctypes.Array):
        """Arguments of a call that reads or sets these variables."""
        n = len(names)
        return self.model.references(names), n, values, *([n] if self.WITH_SIZE else [])

    def arguments(self, values: dict):
        """Arguments of a call that sets `values`, which must be of one type."""
        return self.access(list(values), to_c(self.type_of(values), list(values.values()), self.VALUE))

    def try_set(self, values: dict) -> int:
        """Sets all values in one call. They must be of one type."""
        return self.call(f"Set{self.type_of(values)}", *self.arguments(values))

    def set(self, values: dict) -> None:
        for name, value in values.items():
            assert self.try_set({name: value}) == OK, self.messages[-1:]

    def refused_set(self, values: dict, mentions: tuple[str, ...] = ()) -> str:
        function = f"Set{self.type_of(values)}"
        return self.refused(function, *self.arguments(values), mentions=mentions)

    def try_get(self, names: list[str]):
        """Status and values of a call that reads these variables. They must be of one type."""
        type_ = self.type_of(names)
        values = (self.VALUE[type_] * len(names))()
        return self.call(f"Get{type_}", *self.access(names, values)), list(values)

    def get(self, name: str):
        status, (value,) = self.try_get([name])
        assert status == OK, f"{name}: {self.messages[-1:]}"
        type_ = self.variables[name].type
        return bool(value) if type_ == "Boolean" else value.decode() if type_ == "String" else value

    def everything(self) -> dict:
        """Every variable with its exact value, or "refused" where the FMU refuses to give the value."""
        quiet = len(self.messages)
        values: dict = {}
        for name in self.variables:
            status, (value,) = self.try_get([name])
            values[name] = "refused" if status != OK else value.hex() if isinstance(value, float) else value
        del self.messages[quiet:]
        return values

    # states

    def take(self) -> c_void_p:
        state = c_void_p()
        self.ok(f"Get{self.STATE}", byref(state))
        return state

    def restore(self, state: c_void_p) -> None:
        self.ok(f"Set{self.STATE}", state)

    def free_state(self, state: c_void_p) -> None:
        self.ok(f"Free{self.STATE}", byref(state))

    def to_bytes(self, state: c_void_p) -> bytes:
        size = c_size_t()
        self.ok(f"Serialized{self.STATE}Size", state, byref(size))
        room = ctypes.create_string_buffer(size.value)
        self.ok(f"Serialize{self.STATE}", state, room, size)
        return room.raw

    def state_bytes(self) -> bytes:
        """The present state, serialized."""
        state = self.take()
        content = self.to_bytes(state)
        self.free_state(state)
        return content


class Driver(Calls):
    """One instance of FMI 2.0."""

    PREFIX, VALUE, STATE, WITH_SIZE = "fmi2", VALUE, "FMUstate", False
    REASONS = ("allowed", "must", "jam")

    def __init__(
        self,
        library: ctypes.CDLL,
        name: str | None = "dualcam",
        guid: str | None = "",
        kind: int = CO_SIMULATION,
        resources: str | None = "file:///resources",
        logging: int = 0,
        model: Model = FORWARD,
    ) -> None:
        """`guid` "" stands for the GUID of `model`."""
        super().__init__(library, model)

        def log(_environment, instance, status, category, text):
            self.messages.append(Message(instance.decode(), status, category.decode(), text.decode()))

        self._logger = LOGGER(log)
        callbacks = Callbacks(logger=self._logger)
        guid = model.guid if guid == "" else guid
        encoded = [None if text is None else text.encode() for text in (name, guid, resources)]
        self.instance = library.fmi2Instantiate(
            encoded[0], kind, encoded[1], encoded[2], byref(callbacks), 0, logging
        )
        # The FMU must use its own copy of the callbacks.
        ctypes.memset(byref(callbacks), 0, ctypes.sizeof(callbacks))

    def refused_start(self, values: dict | None = None) -> str:
        """With these values the FMU cannot leave initialization mode; returns why."""
        self.set(values or {})
        self.ok("fmi2EnterInitializationMode")
        count = len(self.messages)
        assert self.call("fmi2ExitInitializationMode") == ERROR
        assert len(self.messages) == count + 1
        assert self.messages[-1].status == ERROR
        return self.messages[-1].text

    def everything(self) -> dict:
        values, time = super().everything(), c_double()
        self.ok("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, byref(time))
        return values | {"time": time.value.hex()}

    def partial(self, unknown: str, known: str, seed: float = 1.0) -> float:
        """The partial derivative, times the seed."""
        result, references = (c_double * 1)(), self.model.references
        arguments = references([unknown]), 1, references([known]), 1, to_c("Real", [seed]), result
        self.ok("fmi2GetDirectionalDerivative", *arguments)
        return result[0]

    # life

    def setup(self, time: float = 0.0, tolerance: float | None = None) -> None:
        self.ok("fmi2SetupExperiment", int(tolerance is not None), tolerance or 0.0, time, 0, 0.0)
        self.time = time

    def enter(self, phase: str) -> "Driver":
        """From instantiated to `phase`."""
        steps = ["fmi2EnterInitializationMode", "fmi2ExitInitializationMode", "fmi2Terminate"]
        for function in steps[: PHASES.index(phase)]:
            self.ok(function)
        return self

    def start(
        self, values: dict | None = None, time: float = 0.0, tolerance: float | None = None
    ) -> "Driver":
        self.set(values or {})
        self.setup(time, tolerance)
        return self.enter(STEP)

    def step(self, h: float, **inputs: float) -> None:
        """One step of h seconds with these inputs, which stay until they are set again."""
        self.set(inputs)
        self.ok("fmi2DoStep", self.time, h, 1)
        self.time += h

    def try_set_derivatives(self, derivatives: dict[str, list[float]]) -> int:
        flat = [(n, k, d) for n, ds in derivatives.items() for k, d in enumerate(ds, start=1)]
        names, orders, values = zip(*flat, strict=True)
        return self.call(
            "fmi2SetRealInputDerivatives",
            self.model.references(names),
            len(flat),
            (c_int * len(flat))(*orders),
            to_c("Real", list(values)),
        )

    def set_derivatives(self, derivatives: dict[str, list[float]]) -> None:
        """Time derivatives of inputs, of orders 1, 2, ..., for the next step."""
        assert self.try_set_derivatives(derivatives) == OK, self.messages[-1:]

    def set_rates(self, **rates: float) -> None:
        self.set_derivatives({name: [rate] for name, rate in rates.items()})

    def output_derivative(self, name: str, order: int) -> float:
        value = c_double()
        references = self.model.references([name])
        self.ok("fmi2GetRealOutputDerivatives", references, 1, (c_int * 1)(order), byref(value))
        return value.value

    # model exchange

    def vector(self, function: str, n: int) -> list[float]:
        """The n numbers that a function such as fmi2GetDerivatives writes."""
        values = (c_double * n)()
        self.ok(function, values, n)
        return list(values)

    def set_vector(self, function: str, values: list[float]) -> None:
        self.ok(function, (c_double * len(values))(*values), len(values))

    def settle(self) -> EventInfo:
        """Event mode until the discrete states are settled, then continuous-time mode."""
        info = EventInfo()
        self.ok("fmi2NewDiscreteStates", byref(info))
        assert not info.newDiscreteStatesNeeded
        assert not info.terminateSimulation
        assert not info.nextEventTimeDefined
        self.ok("fmi2EnterContinuousTimeMode")
        return info

    # states

    def try_from_bytes(self, content: bytes):
        state = c_void_p()
        return self.call("fmi2DeSerializeFMUstate", content, len(content), byref(state)), state
