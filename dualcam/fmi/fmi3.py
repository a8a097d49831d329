"""The calls of FMI 3.0: co-simulation without event mode, and model exchange."""

import ctypes
import os
from ctypes import CFUNCTYPE, byref, c_bool, c_char_p, c_double, c_int, c_int32, c_size_t, c_void_p
from functools import partial
from typing import Any, ClassVar

from dualcam.errors import FmuError
from dualcam.fmi.binary import Use
from dualcam.fmi.instance import Function, Instance, Orders, Reals, References
from dualcam.fmi.model_description import ModelDescription

LOGGER = CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
DISCARD = 2  # FMI's status


class Fmi3Instance(Instance):
    """An instance of an FMI 3.0 FMU."""

    VERSION, ENUMERATION = 3, "Int64"
    GET_REAL, SET_REAL, DO_STEP = "fmi3GetFloat64", "fmi3SetFloat64", "fmi3DoStep"
    RESET, EXIT_INITIALIZATION, SET_STATE = "fmi3Reset", "fmi3ExitInitializationMode", "fmi3SetFMUState"
    CTYPES: ClassVar[dict[str, Any]] = {
        "Float64": c_double, "Float32": ctypes.c_float,
        "Int8": ctypes.c_int8, "Int16": ctypes.c_int16, "Int32": c_int32, "Int64": ctypes.c_int64,
        "UInt8": ctypes.c_uint8, "UInt16": ctypes.c_uint16, "UInt32": ctypes.c_uint32,
        "UInt64": ctypes.c_uint64, "Enumeration": ctypes.c_int64,
        "Boolean": c_bool, "String": c_char_p,
    }  # fmt: skip

    def _instantiate(self, description: ModelDescription, use: Use) -> int | None:
        messages = self.messages

        def log(_: object, status: int, category: bytes, text: bytes) -> None:
            messages.append((text or b"").decode(errors="replace"))

        self._logger = LOGGER(log)
        self._needs_event, self._ends, self._is_early = c_bool(), c_bool(), c_bool()
        self._reached = c_double()  # s
        self.step_end = (
            c_bool(True),  # noSetFMUStatePriorToCurrentPoint
            *(byref(flag) for flag in (self._needs_event, self._ends, self._is_early)),
            byref(self._reached),
        )
        texts = [c_char_p(text.encode()) for text in (description.model_name, description.guid)]
        resources = c_char_p(f"{self.directory / 'resources'}{os.sep}".encode())
        no = c_bool(False)
        if use == "co-simulation":
            # not visible, no debug log, no event mode, no early return, no intermediate variables
            arguments = [*texts, resources, no, no, no, no, None, c_size_t(0), None, self._logger, None]
            instantiate = self.library.fmi3InstantiateCoSimulation
        else:
            arguments = [*texts, resources, no, no, None, self._logger]
            instantiate = self.library.fmi3InstantiateModelExchange
        instantiate.restype = c_void_p
        address: int | None = instantiate(*arguments)
        return address

    def _loop_functions(self) -> tuple[Function, Function, Function]:
        step = self.function(self.DO_STEP)
        step.argtypes = (c_void_p, c_double, c_double, c_bool, *[c_void_p] * 4)  # type: ignore[attr-defined]
        return self.function(self.GET_REAL), self.function(self.SET_REAL), self._unless_ended(step)

    def step_function(self) -> Function:
        return self._unless_ended(self.function(self.DO_STEP))

    def _unless_ended(self, step: Function) -> Function:
        """The step with a status that says when the FMU ends the simulation."""
        ends, messages = self._ends, self.messages

        def step_unless_ended(*arguments: object) -> int:
            status = step(*arguments)
            if ends.value and status < DISCARD:
                messages.append("the FMU ends the simulation")
                return DISCARD
            return status

        step_unless_ended.__name__ = self.DO_STEP
        return step_unless_ended

    def input_derivatives_call(self, references: References, orders: Orders, values: Reals) -> partial[int]:
        raise FmuError(
            "FMI 3.0 has no derivatives of inputs: allowed are values that are constant over a step; take the"
            " FMI 2.0 FMU, or shorter steps"
        )

    def update_discrete_states(self) -> bool:
        again, ends, *_ = flags = [c_bool() for _ in range(5)]
        time = c_double()
        self.call("fmi3UpdateDiscreteStates", *(byref(flag) for flag in flags), byref(time))
        if ends.value:
            raise FmuError("; ".join(["the FMU ends the simulation", *self.messages]))
        return again.value
