"""Drives the C functions of the FMI 3.0 FMUs by name, as driver.py drives those of FMI 2.0."""

import ctypes
import math
import xml.etree.ElementTree as ET
from ctypes import (
    CFUNCTYPE,
    POINTER,
    byref,
    c_bool,
    c_char_p,
    c_double,
    c_int,
    c_int32,
    c_size_t,
    c_uint,
    c_void_p,
)
from functools import cached_property
from pathlib import Path

from driver import Calls, Description, Message, Variable

VALUE = {"Float64": c_double, "Int32": c_int32, "Boolean": c_bool, "String": c_char_p}
# types of FMI 3.0 without a variable in these FMUs
OTHER = {
    "Float32": ctypes.c_float, "Int8": ctypes.c_int8, "UInt8": ctypes.c_uint8, "Int16": ctypes.c_int16,
    "UInt16": ctypes.c_uint16, "UInt32": ctypes.c_uint32, "Int64": ctypes.c_int64, "UInt64": ctypes.c_uint64,
}  # fmt: skip
READ = {"Float64": float, "Int32": int, "Boolean": lambda text: text == "true", "String": str}
CONSTANT, DEPENDENT = 1, 5

LOG = CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
UPDATE = CFUNCTYPE(
    None, c_void_p, c_double, c_bool, c_bool, c_bool, c_bool, POINTER(c_bool), POINTER(c_double)
)  # fmt: skip

_REFERENCES, _REALS, _SIZES = POINTER(c_uint), POINTER(c_double), POINTER(c_size_t)
_ARRAY = (_REFERENCES, c_size_t)
_COUNTERS = (POINTER(ctypes.c_uint64), POINTER(ctypes.c_uint64))
_JACOBIAN = (*_ARRAY, *_ARRAY, _REALS, c_size_t, _REALS, c_size_t)
_FLAG = POINTER(c_bool)
# arguments after the instance
ARGUMENTS = {
    **{f"Get{t}": (*_ARRAY, POINTER(v), c_size_t) for t, v in (VALUE | OTHER).items()},
    **{f"Set{t}": (*_ARRAY, POINTER(v), c_size_t) for t, v in (VALUE | OTHER).items()},
    **{f"{way}Binary": (*_ARRAY, _SIZES, POINTER(c_void_p), c_size_t) for way in ("Get", "Set")},
    **{f"{way}Clock": (*_ARRAY, _FLAG) for way in ("Get", "Set")},
    "SetDebugLogging": (c_bool, c_size_t, POINTER(c_char_p)),
    "EnterInitializationMode": (c_bool, c_double, c_double, c_bool, c_double),
    "ExitInitializationMode": (),
    "EnterEventMode": (),
    "Terminate": (),
    "Reset": (),
    "GetNumberOfVariableDependencies": (c_uint, _SIZES),
    "GetVariableDependencies": (c_uint, _SIZES, _REFERENCES, _SIZES, POINTER(c_int), c_size_t),
    "GetFMUState": (POINTER(c_void_p),),
    "SetFMUState": (c_void_p,),
    "FreeFMUState": (POINTER(c_void_p),),
    "SerializedFMUStateSize": (c_void_p, _SIZES),
    "SerializeFMUState": (c_void_p, c_char_p, c_size_t),
    "DeserializeFMUState": (c_char_p, c_size_t, POINTER(c_void_p)),
    "GetDirectionalDerivative": _JACOBIAN,
    "GetAdjointDerivative": _JACOBIAN,
    "EnterConfigurationMode": (),
    "ExitConfigurationMode": (),
    "GetIntervalDecimal": (*_ARRAY, _REALS, POINTER(c_int)),
    "GetIntervalFraction": (*_ARRAY, *_COUNTERS, POINTER(c_int)),
    "GetShiftDecimal": (*_ARRAY, _REALS),
    "GetShiftFraction": (*_ARRAY, *_COUNTERS),
    "SetIntervalDecimal": (*_ARRAY, _REALS),
    "SetIntervalFraction": (*_ARRAY, *_COUNTERS),
    "SetShiftDecimal": (*_ARRAY, _REALS),
    "SetShiftFraction": (*_ARRAY, *_COUNTERS),
    "EvaluateDiscreteStates": (),
    "UpdateDiscreteStates": (_FLAG, _FLAG, _FLAG, _FLAG, _FLAG, _REALS),
    "EnterContinuousTimeMode": (),
    "CompletedIntegratorStep": (c_bool, _FLAG, _FLAG),
    "SetTime": (c_double,),
    "SetContinuousStates": (_REALS, c_size_t),
    "GetContinuousStateDerivatives": (_REALS, c_size_t),
    "GetEventIndicators": (_REALS, c_size_t),
    "GetContinuousStates": (_REALS, c_size_t),
    "GetNominalsOfContinuousStates": (_REALS, c_size_t),
    "GetNumberOfEventIndicators": (_SIZES,),
    "GetNumberOfContinuousStates": (_SIZES,),
    "EnterStepMode": (),
    "GetOutputDerivatives": (*_ARRAY, POINTER(c_int32), _REALS, c_size_t),
    "DoStep": (c_double, c_double, c_bool, _FLAG, _FLAG, _FLAG, _REALS),
    "ActivateModelPartition": (c_uint, c_double),
}  # fmt: skip
_TEXTS = (c_char_p, c_char_p, c_char_p, c_bool, c_bool)
MAKERS = {
    "InstantiateModelExchange": (*_TEXTS, c_void_p, LOG),
    "InstantiateCoSimulation": (*_TEXTS, c_bool, c_bool, _REFERENCES, c_size_t, c_void_p, LOG, UPDATE),
    "InstantiateScheduledExecution": (*_TEXTS, c_void_p, LOG, c_void_p, c_void_p, c_void_p),
}
FUNCTIONS = {f"fmi3{name}" for name in (*ARGUMENTS, *MAKERS, "FreeInstance", "GetVersion")}


def load(binary: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(binary))
    for name, arguments in ARGUMENTS.items():
        function = getattr(library, f"fmi3{name}")
        function.restype, function.argtypes = c_int, (c_void_p, *arguments)
    for name, arguments in MAKERS.items():
        function = getattr(library, f"fmi3{name}")
        function.restype, function.argtypes = c_void_p, arguments
    library.fmi3FreeInstance.restype, library.fmi3FreeInstance.argtypes = None, (c_void_p,)
    library.fmi3GetVersion.restype = c_char_p
    return library


def _variable(element: ET.Element, index: int) -> Variable:
    given = element.attrib
    start = [s.attrib["value"] for s in element.iter("Start")] or [given[k] for k in ("start",) if k in given]
    return Variable(
        given["name"],
        int(given["valueReference"]),
        element.tag,
        given["causality"],
        given["variability"],
        READ[element.tag](start[0]) if start else None,
        float(given.get("min", -math.inf)),
        float(given.get("max", math.inf)),
        given.get("unit"),
        index,
    )


class Model(Description):
    """Description of an FMU of FMI 3.0."""

    FOLDER, TOKEN = "fmi3", "instantiationToken"

    def __repr__(self) -> str:
        return f"{self.identifier}-3"

    @cached_property
    def variables(self) -> dict[str, Variable]:
        listed = enumerate(self.document.find("ModelVariables"), start=1)
        return {v.name: v for v in (_variable(element, index) for index, element in listed)}


models = {name: Model(name) for name in ("DualCamForward", "DualCamInverse")}
FORWARD, INVERSE = models.values()


def reals(values) -> ctypes.Array:
    return (c_double * len(values))(*values)


class Driver(Calls):
    """One instance of FMI 3.0."""

    PREFIX, VALUE, STATE, WITH_SIZE, REASONS = "fmi3", VALUE, "FMUState", True, ("allowed",)

    def __init__(
        self,
        library: ctypes.CDLL,
        model: Model = FORWARD,
        exchange: bool = False,
        events: bool = False,
        early: bool = False,
        update=None,
        required: tuple[str, ...] = (),
        resources: str | None = "/resources/",
        name: str | None = "dualcam",
        token: str | None = "",
        log: bool = True,
    ) -> None:
        """`update`: called with this driver, time, and the flags of fmi3IntermediateUpdateCallback; returns
        when the step is to end, or None."""
        super().__init__(library, model)
        self.events, self.exchange = events, exchange
        self.failures: list[BaseException] = []

        def on_message(_environment, status, category, text):
            self.messages.append(Message("", status, category.decode(), text.decode()))

        def on_update(_environment, time, asks, may_read, finished, may_end, requested, end):
            try:
                wanted = update(self, time, asks, may_read, finished, may_end)
            except BaseException as failure:  # C code would lose the exception
                self.failures.append(failure)
                return
            if wanted is not None:
                requested[0], end[0] = True, wanted

        self._log = LOG(on_message) if log else LOG()
        self._update = UPDATE(on_update) if update else UPDATE()
        token = model.guid if token == "" else token
        texts = [None if text is None else text.encode() for text in (name, token, resources)]
        if exchange:
            self.instance = library.fmi3InstantiateModelExchange(*texts, False, False, None, self._log)
        else:
            references = model.references(list(required))
            self.instance = library.fmi3InstantiateCoSimulation(
                *texts, False, False, events, early, references, len(required), None, self._log, self._update
            )

    def ok(self, function: str, *arguments) -> None:
        super().ok(function, *arguments)
        if self.failures:
            raise self.failures[0]

    # life

    def initialize(
        self, values: dict | None = None, time: float = 0.0, tolerance: float | None = None
    ) -> "Driver":
        """From instantiated to the phase after initialization mode."""
        self.set(values or {})
        self.ok("EnterInitializationMode", tolerance is not None, tolerance or 0.0, time, False, 0.0)
        self.ok("ExitInitializationMode")
        self.time = time
        return self

    def start(self, values: dict | None = None, **options) -> "Driver":
        """`initialize`, and out of event mode if the instance uses event mode."""
        self.initialize(values, **options)
        if self.events:
            self.settle()
            self.ok("EnterStepMode")
        return self

    @staticmethod
    def _update_arguments():
        flags, time = [c_bool(True) for _ in range(5)], c_double()
        return (*(byref(flag) for flag in flags), byref(time)), flags

    def settle(self) -> dict[str, bool]:
        arguments, flags = self._update_arguments()
        self.ok("UpdateDiscreteStates", *arguments)
        names = ("again", "terminate", "nominals", "moved", "timed")
        return dict(zip(names, (flag.value for flag in flags), strict=True))

    def step(self, h: float, **inputs: float) -> tuple[bool, bool]:
        """One step of at most h seconds with these inputs. Returns eventHandlingNeeded and earlyReturn."""
        self.set(inputs)
        event, end, early, time = c_bool(), c_bool(True), c_bool(), c_double()
        self.ok("DoStep", self.time, h, True, byref(event), byref(end), byref(early), byref(time))
        assert not end.value
        self.time = time.value
        return event.value, early.value

    def handle_event(self) -> dict[str, bool]:
        """Through event mode and back to step mode."""
        self.ok("EnterEventMode")
        flags = self.settle()
        self.ok("EnterStepMode")
        return flags

    # derivatives

    def product(self, kind: str, unknowns: list[str], knowns: list[str], seed: list[float]) -> list[float]:
        """kind: Directional or Adjoint."""
        n = len(unknowns if kind == "Directional" else knowns)
        found = (c_double * n)()
        rows, columns = self.model.references(unknowns), self.model.references(knowns)
        self.ok(
            f"Get{kind}Derivative",
            rows,
            len(unknowns),
            columns,
            len(knowns),
            reals(seed),
            len(seed),
            found,
            n,
        )
        return list(found)

    def output_derivative(self, name: str, order: int) -> float:
        value = c_double()
        self.ok(
            "GetOutputDerivatives", self.model.references([name]), 1, (c_int32 * 1)(order), byref(value), 1
        )
        return value.value

    def dependencies(self, name: str) -> dict[str, int]:
        """Kind of the dependency on each known, in the order of the FMU."""
        n, reference = c_size_t(), self.variables[name].reference
        self.ok("GetNumberOfVariableDependencies", reference, byref(n))
        whole, parts = (c_size_t * n.value)(*[9] * n.value), (c_size_t * n.value)(*[9] * n.value)
        knowns, kinds = (c_uint * n.value)(), (c_int * n.value)()
        self.ok("GetVariableDependencies", reference, whole, knowns, parts, kinds, n)
        assert set(whole) | set(parts) <= {0}
        by_reference = {v.reference: n for n, v in self.variables.items()}
        return {by_reference[known]: kind for known, kind in zip(knowns, kinds, strict=True)}
