"""Arguments of a fleet, checked, and values for each instance, laid out as the C loop reads them."""

from collections.abc import Mapping, Sequence
from ctypes import addressof, c_char_p
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import Array, real_array
from dualcam.errors import FmuError
from dualcam.fleet.native import Values, address
from dualcam.fmi.handle import suitable_value
from dualcam.fmi.model_description import Kind, Variable

NUMBERS: dict[Kind, type[np.generic]] = {"real": np.float64, "integer": np.intc, "boolean": np.intc}
KINDS: tuple[Kind, ...] = ("real", "integer", "boolean", "string")
FleetValue = ArrayLike | str | Sequence[str]


class Layout:
    """Values of variables, shape () or (count,), for `count` instances. `struct` points into this object."""

    def __init__(self, variables: Sequence[Variable], values: Mapping[str, FleetValue], count: int) -> None:
        self.struct = Values()
        self._kept: list[Any] = []
        for kind in KINDS:
            chosen = [variable for variable in variables if variable.kind == kind]
            columns = [column_of(variable, values[variable.name], count) for variable in chosen]
            references = np.array([variable.value_reference for variable in chosen], np.uintc)
            self._put(f"{kind}_references", references)
            setattr(self.struct, f"{kind}_count", len(chosen))
            if kind == "string":
                self._put_texts(columns)
            else:
                self._put(f"{kind}s", np.ascontiguousarray(np.transpose(columns), NUMBERS[kind]))

    def _put(self, member: str, array: NDArray[Any]) -> None:
        self._kept.append(array)
        setattr(self.struct, member, address(array))

    def _put_texts(self, columns: list[NDArray[Any]]) -> None:
        rows = [text.encode() for row in np.transpose(columns) for text in row]
        pointers = (c_char_p * len(rows))(*rows)
        self._kept.append(pointers)
        self.struct.strings = addressof(pointers)


def column_of(variable: Variable, value: FleetValue, count: int) -> NDArray[Any]:
    """One value per instance, shape (count,), each of the variable's kind."""
    is_number = variable.kind in ("real", "integer")
    given = real_array(value, variable.name, FmuError) if is_number else np.asarray(value)
    if given.ndim == 0:
        return np.full(count, suitable_value(variable, given.item()), dtype=_dtype(variable))
    if given.shape != (count,):
        raise FmuError(
            f"{variable.name} has shape {given.shape}: allowed are one value for all instances, or"
            f" the shape ({count},), one value per instance"
        )
    if variable.kind == "real":
        return given
    items = [_numbered(variable, i, item) for i, item in enumerate(given.tolist())]
    return np.array(items, dtype=_dtype(variable))


def _numbered(variable: Variable, instance: int, value: object) -> object:
    try:
        return suitable_value(variable, value)
    except FmuError as error:
        raise FmuError(f"instance {instance}: {error}") from None


def _dtype(variable: Variable) -> type:
    return object if variable.kind == "string" else NUMBERS[variable.kind]


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
        text = f"instances = {instances!r}: allowed are numbers from 0 to {count - 1}, or {count} booleans"
        raise FmuError(text)
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
