"""Arguments of a fleet's methods, checked."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.errors import FmuError
from dualcam.reals import Array, number_of

TOLERANCES = "a finite number > 0, or None"


def relative_tolerance(tolerance: float | None) -> float:
    """The tolerance as the C loop takes it: 0 for the FMU's default."""
    if tolerance is None:
        return 0.0
    relative = number_of(tolerance, "tolerance", TOLERANCES)
    if relative <= 0.0:
        raise FmuError(f"tolerance = {tolerance!r}: allowed is {TOLERANCES}")
    return relative


def chosen_instances(instances: ArrayLike | None, count: int) -> NDArray[np.uint8]:
    """1 where an instance is chosen, shape (count,)."""
    if instances is None:
        return np.ones(count, np.uint8)
    given = np.asarray(instances)
    if given.dtype == bool and given.shape == (count,):
        return given.astype(np.uint8)
    chosen = np.zeros(count, np.uint8)
    if given.size == 0:
        return chosen
    is_list = given.dtype.kind in "iu" and given.ndim == 1
    if not is_list or not 0 <= given.min() <= given.max() < count:
        raise FmuError(
            f"instances = {instances!r}: allowed are numbers from 0 to {count - 1}, or {count} booleans"
        )
    chosen[given] = 1
    return chosen


def whole_number(value: object, name: str, allowed: str, most: float) -> int:
    """`value` as an int from 1 to `most`."""
    number = value.item() if isinstance(value, np.integer) else value
    if type(number) is not int or not 0 < number <= most:
        raise FmuError(f"{name} = {value!r}: allowed is {allowed}")
    return number


def numbers_of(u: ArrayLike, shape: tuple[int, ...]) -> Array:
    """`u` as a C-contiguous array of float64; the same array where `u` is one."""
    if type(u) is np.ndarray and u.dtype == np.float64 and u.shape == shape and u.flags.c_contiguous:
        return u
    try:
        given = np.asarray(u)
    except ValueError:  # rows of different lengths
        given = np.asarray(None)
    if given.dtype.kind not in "fiu":
        raise FmuError(f"u has elements of type {given.dtype}: allowed are real numbers, shape {shape}")
    if given.shape != shape:
        raise FmuError(f"u has shape {given.shape}: allowed is {shape}")
    return np.ascontiguousarray(given, np.float64)


def steps_of(u: ArrayLike) -> int:
    """The number of steps in a history of inputs; 1 where `u` is none, which `numbers_of` refuses."""
    try:
        shape = np.shape(u)
    except ValueError:  # rows of different lengths
        return 1
    return shape[1] if len(shape) == 3 else 1


def output_buffer(out: object, shape: tuple[int, ...]) -> Array:
    """`out`, where it can take the outputs."""
    suits = isinstance(out, np.ndarray) and out.dtype == np.float64 and out.shape == shape
    if not (isinstance(out, np.ndarray) and suits and out.flags.c_contiguous and out.flags.writeable):
        raise FmuError(f"out: allowed is a writeable, C-contiguous array of float64 with shape {shape}")
    return out
