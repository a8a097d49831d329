"""The calls of FMI 2.0."""

import ctypes
import sys
from ctypes import CFUNCTYPE, byref, c_char_p, c_double, c_int, c_size_t, c_void_p
from functools import partial
from typing import Any, ClassVar

from dualcam.errors import FmuError
from dualcam.fmi.binary import Use
from dualcam.fmi.instance import Function, Instance, Orders, Reals, References
from dualcam.fmi.model_description import ModelDescription

LOGGER = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
ALLOCATE = CFUNCTYPE(c_void_p, c_size_t, c_size_t)
FREE = CFUNCTYPE(None, c_void_p)
KINDS: dict[Use, int] = {"model exchange": 0, "co-simulation": 1}


class Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", LOGGER),
        ("allocate_memory", ALLOCATE),
        ("free_memory", FREE),
        ("step_finished", c_void_p),
        ("environment", c_void_p),
    )


class EventInfo(ctypes.Structure):
    """fmi2EventInfo."""

    _fields_ = (
        *((name, c_int) for name in ("again", "ends_simulation", "nominals_changed", "states_changed")),
        ("next_time_defined", c_int),
        ("next_time", c_double),
    )


class Fmi2Instance(Instance):
    """An instance of an FMI 2.0 FMU."""

    VERSION, ENUMERATION = 2, "Integer"
    GET_REAL, SET_REAL, DO_STEP = "fmi2GetReal", "fmi2SetReal", "fmi2DoStep"
    RESET, EXIT_INITIALIZATION, SET_STATE = "fmi2Reset", "fmi2ExitInitializationMode", "fmi2SetFMUstate"
    CTYPES: ClassVar[dict[str, Any]] = {
        "Real": c_double,
        "Integer": c_int,
        "Enumeration": c_int,
        "Boolean": c_int,
        "String": c_char_p,
    }
    step_end = (c_int(1),)  # noSetFMUStatePriorToCurrentPoint

    def _instantiate(self, description: ModelDescription, use: Use) -> int | None:
        messages = self.messages

        def log(_: object, name: bytes, status: int, category: bytes, text: bytes) -> None:
            # FMI doubles the characters % and #, which its printf format would interpret
            messages.append((text or b"").decode(errors="replace").replace("%%", "%").replace("##", "#"))

        memory = ctypes.cdll.msvcrt if sys.platform == "win32" else ctypes.CDLL(None)
        allocate, free = ctypes.cast(memory.calloc, ALLOCATE), ctypes.cast(memory.free, FREE)
        self._callbacks = Callbacks(LOGGER(log), allocate, free, None, None)
        instantiate = self.library.fmi2Instantiate
        instantiate.restype = c_void_p
        instantiate.argtypes = (c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int)
        address: int | None = instantiate(
            description.model_name.encode(),
            KINDS[use],
            description.guid.encode(),
            (self.directory / "resources").as_uri().encode(),
            ctypes.addressof(self._callbacks),
            0,
            0,
        )
        return address

    def _loop_functions(self) -> tuple[Function, Function, Function]:
        step = self.step_function()
        step.argtypes = (c_void_p, c_double, c_double, c_int)  # type: ignore[attr-defined]
        return self.function(self.GET_REAL), self.function(self.SET_REAL), step

    def input_derivatives_call(self, references: References, orders: Orders, values: Reals) -> partial[int]:
        function = self.brief_function("fmi2SetRealInputDerivatives")
        count = len(references)
        return partial(
            function, self.component, references, c_size_t(count), (c_int * count)(*orders), values
        )

    def update_discrete_states(self) -> bool:
        info = EventInfo()
        self.call("fmi2NewDiscreteStates", byref(info))
        if info.ends_simulation:
            raise FmuError("; ".join(["the FMU ends the simulation", *self.messages]))
        return bool(info.again)
