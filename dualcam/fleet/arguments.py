"""Arguments of a fleet's methods, checked."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import Array, positive_number
from dualcam.errors import FmuError

TOLERANCES = "a finite number > 0, or None"


def relative_tolerance(tolerance: float | None) -> float:
    """The tolerance as the C loop takes it: 0 for the FMU's default."""
    return 0.0 if tolerance is None else positive_number(tolerance, "tolerance", TOLERANCES)


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


def steps_of(u: ArrayLike) -> int:
    """The number of steps in a history of inputs; 1 where `u` is none, which `real_array` refuses."""
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
