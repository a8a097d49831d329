"""Arrays and numbers that a user hands in: real numbers, or an error that says what was given instead."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.errors import DualcamError, FmuError

Array = NDArray[np.float64]

REAL = "fiu"  # kinds of NumPy's types
TIME, TRUTH = REAL + "m", REAL + "b"
PLAIN = frozenset((np.ndarray, np.float64, float, int, list, tuple))  # types without units and masks
BOOLEANS, NUMBERS = frozenset((bool, np.bool_)), frozenset((float, int, np.float64))
SEQUENCES = (list, tuple)  # list | tuple would be made at each call
CARRIES_UNIT = ("magnitude", "to_value")  # attributes of the quantities of pint, astropy and unyt
SECOND = np.timedelta64(1, "s")
REMEDIES = {  # kind of NumPy's types -> what to do
    "m": ". In seconds they are: t / np.timedelta64(1, 's')",
    "M": ". In seconds they are: (t - t[0]) / np.timedelta64(1, 's')",
    "b": ". As numbers they are: x.astype(float)",
}


def real_array(
    values: ArrayLike,
    name: str,
    error: type[DualcamError] = DualcamError,
    shape: tuple[int, ...] | None = None,
    kinds: str = REAL,
) -> Array:
    """`values` as an array of float64: the same array where it is one. `error` for anything but real numbers.

    `kinds` are NumPy's kinds of types: with "m" durations become seconds, with "b" True becomes 1."""
    if type(values) not in PLAIN:
        _refuse_what_arrays_leave_out(values, name, error)
    try:
        given = np.asarray(values)
    except Exception as reason:  # rows of different lengths; types of other packages have errors of their own
        raise error(f"{name} is no array of real numbers: {reason}") from None
    may_mix = "b" in kinds and given.ndim > 1  # a column of booleans beside one of numbers
    if given is not values and given.dtype.kind in REAL and not may_mix and _has_boolean(values):
        raise error(f"{name} has elements of type {_type_of(np.empty(0, bool))}")
    if given.dtype.kind not in kinds:
        raise error(f"{name} has elements of type {_type_of(given)}")
    if shape is not None and given.shape != shape:
        raise error(f"{name} has shape {given.shape}: allowed is {shape}")
    return given / SECOND if given.dtype.kind == "m" else given.astype(np.float64, copy=False)


def _refuse_what_arrays_leave_out(values: ArrayLike, name: str, error: type[DualcamError]) -> None:
    """An error for units and for masks."""
    if any(hasattr(type(values), word) for word in CARRIES_UNIT):
        raise error(f"{name} = {values!r:.80} has a unit: allowed are real numbers in the documented unit")
    if np.ma.is_masked(values):
        raise error(f"{name} has masked values: allowed are real numbers. Leave out masked samples")


def _has_boolean(values: object) -> bool:
    """Whether a list has booleans among its numbers, which NumPy makes numbers, too."""
    if isinstance(values, np.ndarray):
        return values.dtype.kind == "b"
    if not isinstance(values, SEQUENCES):
        return False
    if NUMBERS.issuperset(map(type, values)):  # the usual case, in a loop that sets values
        return False
    return any(type(value) in BOOLEANS or _has_boolean(value) for value in values)


def _type_of(given: NDArray[np.generic]) -> str:
    """The type of elements, and the end of a message about them."""
    kind = given.dtype.kind
    shown = "text" if kind in "SUT" else str(given.dtype)
    if kind in "SUTO" and given.size > 0:
        shown += f", such as {given.ravel()[:1].tolist()[0]!r:.40}"
    return f"{shown}: allowed are real numbers{REMEDIES.get(kind, '')}"


def number_of(
    value: object, name: str, allowed: str = "a finite number", error: type[DualcamError] = FmuError
) -> float:
    """`value` as a finite number. `error` for anything that `real_array` refuses, and for another shape."""
    try:
        number = float(real_array(value, name, error, ()))  # type: ignore[arg-type]
    except DualcamError:
        number = math.nan
    if not math.isfinite(number):
        raise error(f"{name} = {value!r}: allowed is {allowed}")
    return number


def given_once(**named: float | None) -> tuple[str, float | None]:
    """Name and value of an argument that has several names: the first one where none is given.

    FmuError where two are given."""
    given = {name: value for name, value in named.items() if value is not None}
    if len(given) > 1:
        text = " and ".join(f"{name} = {value!r}" for name, value in given.items())
        raise FmuError(f"{text}: allowed is one of them, they mean the same")
    return next(iter((given or named).items()))


def positive_number(
    value: object, name: str, allowed: str = "a finite number > 0", error: type[DualcamError] = FmuError
) -> float:
    """`value` as a finite number > 0. `error` for anything else."""
    number = number_of(value, name, allowed, error)
    if number <= 0.0:
        raise error(f"{name} = {value!r}: allowed is {allowed}")
    return number
