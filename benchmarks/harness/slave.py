"""The structures of slave.h and inputs.c, and an FMU 2.0 stepped without a master.

Only ctypes is imported, so that little else runs under callgrind.
"""

from __future__ import annotations

import ctypes


class SlaveStruct(ctypes.Structure):
    """`Slave` of slave.h."""

    _fields_ = [
        ("set_real", ctypes.c_void_p),
        ("do_step", ctypes.c_void_p),
        ("get_real", ctypes.c_void_p),
        ("set_state", ctypes.c_void_p),
        ("component", ctypes.c_void_p),
        ("input", ctypes.c_uint),
        ("outputs", ctypes.c_uint * 2),
    ]


class InputsStruct(ctypes.Structure):
    """`Inputs` of inputs.c."""

    _fields_ = [
        ("tau", ctypes.c_void_p),
        ("tau_rate", ctypes.c_void_p),
        ("F_ext", ctypes.c_void_p),
        ("step", ctypes.c_double),
        ("first", ctypes.c_size_t),
        ("count", ctypes.c_size_t),
    ]


class InstanceStruct(ctypes.Structure):
    """`Instance` of inputs.c."""

    _fields_ = [
        ("slave", SlaveStruct),
        ("set_rate", ctypes.c_void_p),
        ("inputs", ctypes.c_uint * 2),
    ]


def address(library: ctypes.CDLL, name: str) -> int | None:
    return ctypes.cast(getattr(library, name), ctypes.c_void_p).value


def slave_struct(library: ctypes.CDLL, component: object, references: dict[str, int]) -> SlaveStruct:
    names = ("fmi2SetReal", "fmi2DoStep", "fmi2GetReal", "fmi2SetFMUstate")
    return SlaveStruct(
        *(address(library, name) for name in names),
        component,
        references["tau"],
        (ctypes.c_uint * 2)(references["theta"], references["omega"]),
    )


def instance_struct(library: ctypes.CDLL, component: object, references: dict[str, int]) -> InstanceStruct:
    return InstanceStruct(
        slave_struct(library, component, references),
        address(library, "fmi2SetRealInputDerivatives"),
        (ctypes.c_uint * 2)(references["tau"], references["F_ext"]),
    )


class Callbacks(ctypes.Structure):
    _fields_ = [(n, ctypes.c_void_p) for n in ("logger", "allocate", "free", "finished", "environment")]


LOG = ctypes.CFUNCTYPE(None)(lambda: None)


class Bare:
    """An instance in step mode with its start values. SystemExit if a call of FMI fails."""

    def __init__(self, path: str, guid: str, resources: str) -> None:
        libc = ctypes.CDLL(None)
        self.library = ctypes.CDLL(path)
        self.callbacks = Callbacks(
            ctypes.cast(LOG, ctypes.c_void_p).value,
            address(libc, "calloc"),
            address(libc, "free"),
            None,
            None,
        )
        self.library.fmi2Instantiate.restype = ctypes.c_void_p
        words = (b"cam", 1, guid.encode(), resources.encode())
        self.component = ctypes.c_void_p(
            self.library.fmi2Instantiate(*words, ctypes.byref(self.callbacks), 0, 0)
        )
        zero = ctypes.c_double(0.0)
        for name, *arguments in (
            ("SetupExperiment", 0, zero, zero, 0, zero),
            ("EnterInitializationMode",),
            ("ExitInitializationMode",),
        ):
            self.expect_ok(name, *arguments)

    def expect_ok(self, name: str, *arguments: object) -> None:
        status = getattr(self.library, "fmi2" + str(name))(self.component, *arguments)
        if status != 0:
            raise SystemExit(f"fmi2{name}: status {status}")

    def state(self, serialized: bytes) -> ctypes.c_void_p:
        made = ctypes.c_void_p()
        size = ctypes.c_size_t(len(serialized))
        self.expect_ok("DeSerializeFMUstate", serialized, size, ctypes.byref(made))
        return made

    def restore(self, serialized: bytes) -> None:
        self.expect_ok("SetFMUstate", self.state(serialized))
