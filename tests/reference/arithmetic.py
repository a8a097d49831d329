"""Number types of the event logic, and polynomials in them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import mpmath
from scipy.optimize import brentq

Number = Any  # float, or mpf: the event logic works on either
Polynomial = tuple[Number, ...]  # coefficients, from the constant one


@dataclass(frozen=True)
class Arithmetic:
    """A number type. `tiny` is the relative size below which a balance counts as zero; `probe` is the
    look-ahead, in units of the fastest time constant, that tells the sign which a zero is about to take."""

    number: Callable[[Any], Number]
    tan: Callable[[Number], Number]
    tiny: Number
    probe: Number
    still: Number  # speed relative to the peak speed; below this value new inputs find the mechanism at rest


MP = mpmath.MPContext()
MP.dps = 60
DOUBLE = Arithmetic(float, math.tan, 1e-12, 1e-5, 0.0)
SIXTY_DIGITS = Arithmetic(MP.mpf, MP.tan, MP.mpf("1e-40"), MP.mpf("1e-16"), MP.mpf("1e-25"))


def sign(x: Number) -> int:
    return (x > 0) - (x < 0)


def poly(c: Sequence[Number], t: Number) -> Number:
    total = c[-1]
    for a in c[-2::-1]:
        total = total * t + a
    return total


def poly_derivative(c: Sequence[Number]) -> Polynomial:
    return tuple(k * a for k, a in enumerate(c) if k) or (c[0] * 0,)


def poly_shift(c: Sequence[Number], t: Number) -> Polynomial:
    """Coefficients of the same polynomial in the variable s with s = 0 at t."""
    found, factorial = [], 1
    d = tuple(c)
    for k in range(len(c)):
        factorial *= max(k, 1)
        found.append(poly(d, t) / factorial)
        d = poly_derivative(d)
    return tuple(found)


def poly_zeros(c: Sequence[Number], a: Number, b: Number) -> list[Number]:
    """Sign changes in (a, b). Between two zeros of the derivative the polynomial is monotone, and Brent's
    method finds its zero."""
    c = list(c)
    while len(c) > 1 and c[-1] == 0:
        c.pop()
    if len(c) == 1:
        return []
    if len(c) == 2:
        return [t for t in [-c[0] / c[1]] if a < t < b]
    knots = [a, *poly_zeros(poly_derivative(c), a, b), b]
    values = [poly(c, t) for t in knots]
    pieces = zip(pairwise(knots), pairwise(values), strict=True)
    return [
        brentq(lambda t: poly(c, t), *ends, xtol=1e-16 * (b - a), rtol=1e-15)
        for ends, (f, g) in pieces
        if sign(f) * sign(g) < 0
    ]
