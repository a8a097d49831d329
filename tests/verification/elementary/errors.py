"""Errors of computed values: fast by reference.c, and by 60 digits."""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Callable, Sequence

import mpmath
import numpy as np

from benchmarks.harness import core
from benchmarks.harness.repository import VERIFICATION
from verification.elementary.arguments import MP, Array

EXACT: dict[str, Callable[..., mpmath.mpf]] = {  # in the order of reference.c
    "exp": MP.exp,
    "expm1": MP.expm1,
    "log": MP.log,
    "log1p": MP.log1p,
    "sin": MP.sin,
    "cos": MP.cos,
    "tan": MP.tan,
    "atan": MP.atan,
    "cbrt": lambda x: MP.sign(x) * MP.cbrt(abs(x)),
    "atan2": MP.atan2,
}
OF_TWO = {"exp of two": "exp", "small exp of two": "exp", "log of two": "log"}  # elementary/vector2.h
LIKE_X = ("expm1", "log1p", "sin", "tan", "atan")  # f(x) = x + ... near 0
TERMS, WORDS = 31, 22


class Constants(ctypes.Structure):
    _fields_ = (
        ("inverse_factorial", ctypes.c_double * 2 * TERMS),
        ("log_2", ctypes.c_double * 3),
        ("half_pi", ctypes.c_double * 2),
        ("two_by_pi", ctypes.c_uint64 * WORDS),
    )


def cut(x: mpmath.mpf, bits: int) -> mpmath.mpf:
    """x with so many binary digits."""
    unit = MP.mpf(2) ** (int(MP.floor(MP.log(x, 2))) + 1 - bits)
    return MP.floor(x / unit) * unit


def pair(x: mpmath.mpf) -> tuple[float, float]:
    return float(x), float(x - MP.mpf(float(x)))


def constants() -> Constants:
    first = cut(MP.log(2), 40)
    second = cut(MP.log(2) - first, 40)
    context = MP.clone()
    context.prec = 64 * WORDS + 64
    digits = int(context.floor(2 / context.pi * context.mpf(2) ** (64 * (WORDS - 1))))
    made = Constants()
    for n in range(TERMS):
        made.inverse_factorial[n][:] = pair(1 / MP.factorial(n))
    made.log_2[:] = [float(first), float(second), float(MP.log(2) - first - second)]
    made.half_pi[:] = pair(MP.pi / 2)
    made.two_by_pi[:] = [digits >> 64 * (WORDS - 1 - k) & (2**64 - 1) for k in range(WORDS)]
    return made


class Reference:
    """The functions of reference.c."""

    def __init__(self, flags: Sequence[str] = ("-O3", "-fPIC", "-shared")) -> None:
        source, product = VERIFICATION / "elementary/reference.c", core.BUILD / "loops/reference.so"
        self.library = ctypes.CDLL(str(core.compile_c(flags, [source], product)))
        self.constants = constants()

    def errors(self, name: str, x: Array, second: Array, y: Array) -> Array:
        """Of computed y, in units of the last place of the exact value; exact value less y."""
        found = np.empty_like(x)
        arrays = [ctypes.c_void_p(numbers.ctypes.data) for numbers in (x, second, y, found)]
        name = OF_TWO.get(name, name)
        number, like_x = list(EXACT).index(name), ctypes.c_int(name in LIKE_X)
        self.library.errors(ctypes.byref(self.constants), number, like_x, ctypes.c_size_t(len(x)), *arrays)
        return found


def exact_error(name: str, x: float, second: float, y: float) -> float:
    """The same by 60 digits."""
    numbers = (x, second) if name == "atan2" else (x,)
    exact = EXACT[OF_TWO.get(name, name)](*map(MP.mpf, numbers))
    unit = max(math.ulp(float(exact)), math.ulp(0.0)) if abs(exact) < sys.float_info.max else math.ulp(y)
    return float((exact - MP.mpf(y)) / unit)
