"""The library of the C loops, dualcam/fleet/fleet.h and runs.h: its structs and functions for ctypes."""

import ctypes
from collections.abc import Callable
from ctypes import POINTER, byref, c_char, c_char_p, c_double, c_int, c_long, c_size_t, c_uint, c_void_p
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dualcam.errors import FmuError
from dualcam.fmi.library import fleet_library_path

TEXT = 512  # FLEET_TEXT
GETTERS = {"real": "fleet_get_reals", "integer": "fleet_get_integers", "boolean": "fleet_get_booleans"}
FATAL, NOT_FINITE, ALL_FAILED = -1, -2, -3  # FLEET_FATAL, FLEET_NOT_FINITE, FLEET_ALL_FAILED

# Members of FleetFunctions, in order
FUNCTIONS = (
    *("fmi2Instantiate", "fmi2FreeInstance", "fmi2SetupExperiment", "fmi2EnterInitializationMode"),
    *("fmi2ExitInitializationMode", "fmi2Reset", "fmi2SetReal", "fmi2SetInteger", "fmi2SetBoolean"),
    *("fmi2SetString", "fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean", "fmi2DoStep"),
)
STATE_FUNCTIONS = ("fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate")


class Functions(ctypes.Structure):
    """FleetFunctions."""

    _fields_ = tuple((name, c_void_p) for name in (*FUNCTIONS, *STATE_FUNCTIONS))


class Experiment(ctypes.Structure):
    """FleetExperiment."""

    _fields_ = (
        *((name, c_char_p) for name in ("model", "guid", "resources")),
        *((name, c_double) for name in ("start_time", "tolerance")),
    )


class Values(ctypes.Structure):
    """FleetValues."""

    _fields_ = (
        *((f"{kind}_count", c_size_t) for kind in ("real", "integer", "boolean", "string")),
        *((f"{kind}_references", c_void_p) for kind in ("real", "integer", "boolean", "string")),
        *((f"{kind}s", c_void_p) for kind in ("real", "integer", "boolean", "string")),
    )


class Ports(ctypes.Structure):
    """FleetPorts."""

    _fields_ = (
        *((name, c_size_t) for name in ("input_count", "output_count")),
        *((name, c_void_p) for name in ("input_references", "output_references")),
    )


class Report(ctypes.Structure):
    """FleetReport."""

    _fields_ = (("instance", c_size_t), ("text", c_char * TEXT))


class RunsCall(ctypes.Structure):
    """RunsCall."""

    _fields_ = (
        *((name, c_int) for name in ("kind", "has_tolerance")),
        *((name, c_void_p) for name in ("function", "references", "orders")),
        ("count", c_size_t),
        *((name, c_void_p) for name in ("numbers", "target", "values")),
        ("line_size", c_size_t),
    )


class RunsEnd(ctypes.Structure):
    """RunsEnd."""

    _fields_ = (("run", c_size_t), ("call", c_size_t), ("status", c_int))


SIGNATURES = {
    "fleet_open": (c_void_p, (POINTER(Functions), POINTER(Experiment), c_size_t, c_uint)),
    "fleet_close": (None, (c_void_p,)),
    "fleet_instantiate": (c_long, (c_void_p,)),
    **dict.fromkeys(("fleet_start", "fleet_set"), (c_long, (c_void_p, POINTER(Values), c_void_p))),
    **dict.fromkeys(GETTERS.values(), (c_long, (c_void_p, c_uint, c_void_p))),
    "fleet_roll": (c_long, (c_void_p, c_void_p, c_void_p, c_size_t, c_double, c_void_p)),
    **dict.fromkeys(("fleet_save", "fleet_restore"), (c_long, (c_void_p, c_void_p, c_void_p, c_void_p))),
    "fleet_free_states": (c_long, (c_void_p, c_void_p)),
    **dict.fromkeys(("fleet_failed", "fleet_times"), (None, (c_void_p, c_void_p))),
    "fleet_reports": (c_size_t, (c_void_p, POINTER(POINTER(Report)))),
    "runs_make": (None, (c_void_p, c_size_t, c_void_p, c_size_t, c_size_t, POINTER(RunsEnd))),
}


@cache
def native() -> ctypes.CDLL:
    """The library, loaded once; its calls release Python's lock. FmuError if there is none."""
    path = fleet_library_path()
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise FmuError(f"{path} cannot be loaded: {error}") from error
    for name, (result, arguments) in SIGNATURES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


def functions_of(library: ctypes.CDLL, saves_states: bool) -> Functions:
    """The addresses of an FMU's functions. FmuError if the library lacks one."""
    wanted = (*FUNCTIONS, *(STATE_FUNCTIONS if saves_states else ()))
    try:
        return Functions(**{name: ctypes.cast(library[name], c_void_p) for name in wanted})
    except AttributeError as error:
        raise FmuError(f"the library lacks an FMI function: {error}") from error


def address(array: NDArray[np.generic]) -> int:
    """Where the elements of an array begin."""
    place: int = array.__array_interface__["data"][0]  # takes half as long as array.ctypes.data
    return place


_first_byte: Callable[[Any], c_char] = c_char.from_buffer


def pointer_to(array: NDArray[np.generic]) -> object:
    """Elements of a C-contiguous array as an argument of a function; takes a fifth as long as `address`."""
    return byref(_first_byte(array)) if array.flags.writeable and array.size else address(array)
