"""Random and hard arguments at which the elementary functions of the core are compared with 60 digits."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import cache, partial

import mpmath
import numpy as np

Array = np.ndarray
Sampler = Callable[[np.random.Generator, int], Array]
MP = mpmath.MPContext()
MP.dps = 60
LEAST_NORMAL, LARGEST = sys.float_info.min, sys.float_info.max


def uniform(low: float, high: float) -> Sampler:
    return lambda r, count: r.uniform(low, high, count)


def sizes(low: float, high: float, sign: bool = True) -> Sampler:
    """Sizes from `low` to `high`, equally likely by their logarithm; of any sign, or positive."""

    def sample(r: np.random.Generator, count: int) -> Array:
        found = np.exp(r.uniform(math.log(low), math.log(high), count))
        return found * r.choice([-1.0, 1.0], count) if sign else found

    return sample


def near_one(low: float, high: float) -> Sampler:
    """1 plus or minus these sizes."""
    sample = sizes(low, high)
    return lambda r, count: 1.0 + sample(r, count)


ANGLES = [uniform(-0.8, 0.8), uniform(-100.0, 100.0), sizes(1e-9, 1e6), sizes(1e6, 1e308)]
EXPONENTS = [uniform(-1.0, 1.0), uniform(-745.1, 709.7), sizes(1e-20, 700.0)]
ANY = [uniform(-1.1, 1.1), sizes(0.01, 100.0), sizes(1e-308, 1e308)]
# function -> how its arguments are drawn; every kind gives an equal share
RANDOM: dict[str, list[Sampler]] = {
    "exp": EXPONENTS,
    "expm1": EXPONENTS,
    "log": [uniform(0.5, 2.0), near_one(1e-15, 0.1), sizes(1e-320, 1e308, sign=False)],
    "log1p": [uniform(-0.99, 1.0), sizes(1e-20, 0.05), sizes(1e-10, 1e308, sign=False)],
    "sin": ANGLES,
    "cos": ANGLES,
    "tan": ANGLES,
    "atan": ANY,
    "cbrt": ANY,
    "exp of two": [uniform(-1.0, 1.0), uniform(-700.0, 700.0)],
    "small exp of two": [uniform(-0.1, 0.1), sizes(1e-20, 0.1)],
    "log of two": [uniform(0.5, 2.0), near_one(1e-15, 0.1), sizes(1e-300, 1e300, sign=False)],
    "atan2": [uniform(-1.0, 1.0), sizes(1e-3, 1e3), sizes(1e-100, 1e100)],
}


def random_arguments(name: str, r: np.random.Generator, count: int) -> tuple[Array, Array]:
    """`count` arguments, or a few more, and second ones for atan2(x, second)."""
    kinds = RANDOM[name]
    each = -(-count // len(kinds))
    first, second = (np.concatenate([sample(r, each) for sample in kinds]) for _ in range(2))
    return first, second


# ---- hard arguments ----


@cache
def near_multiples_of_a_right_angle(step: int = 1) -> tuple[float, ...]:
    """For every exponent, or each `step`-th, the double closest to a multiple of pi/2: of the continued
    fraction of 2^e/(pi/2), the last convergent whose denominator has at most 53 bits."""
    context = MP.clone()
    context.prec = 2500
    two_by_pi, bits = int(context.floor(2 / context.pi * context.mpf(2) ** 2400)), 2400
    found = []
    for e in range(-51, 972, step):
        numerator, rest = two_by_pi << max(e, 0) >> max(-e, 0), 1 << bits
        numerator %= rest << 60
        older, newer = 1, 0  # denominators of the convergents
        while rest > 0 and newer < 2**53:
            whole = numerator // rest
            numerator, rest = rest, numerator - whole * rest
            older, newer = newer, older + whole * newer
        found += [math.ldexp(older, e), math.ldexp(older * ((2**53 - 1) // older), e)]
    return tuple(x for x in found if x >= 0.7)


def steps_of_bits(low: float, high: float, bits: int) -> Array:
    """Positive numbers whose last `bits` binary digits are zero."""
    first, last = (int(np.float64(x).view(np.uint64)) for x in (low, high))
    return np.arange(first >> bits << bits, last, 1 << bits, dtype=np.uint64).view(np.float64)


def ends_of_exponents() -> Array:
    """The powers of two."""
    return np.array([math.ldexp(1.0, e) for e in range(-1074, 1024)])


def with_neighbours(x: Array) -> Array:
    """Each number, and two doubles on each side."""
    with np.errstate(over="ignore"):
        below, above = np.nextafter(x, -np.inf), np.nextafter(x, np.inf)
        both = [np.nextafter(below, -np.inf), below, x, above, np.nextafter(above, np.inf)]
    found = np.unique(np.concatenate(both))
    return found[np.isfinite(found) & (found != 0.0)]


def both_signs(*parts: Array) -> Array:
    x = np.concatenate(parts)
    return np.concatenate([x, -x])


def hard_exponents() -> Array:
    """Halfway between the powers in the table, and the ends of ranges."""
    halves = (np.arange(-69000, 65600) + 0.5) * (math.log(2.0) / 64.0)
    ends = [0.25, 40.0, 60.0, 700.0, 708.3964185322641, 709.782712893384, 745.1332191019411]
    x = with_neighbours(np.concatenate([halves, both_signs(np.array(ends), ends_of_exponents())]))
    return x[(x > -745.13) & (x < 709.78271289338)]


def hard_logarithms() -> Array:
    """The borders of the steps of all binades, subnormal numbers, and the doubles next to 1."""
    near = 1.0 + np.arange(-1000, 1000) * 2.0**-52
    borders = np.concatenate([ends_of_exponents(), steps_of_bits(LEAST_NORMAL, LARGEST, 45), near])
    x = with_neighbours(borders)
    return x[(x > 0.0) & (x != 1.0)]


def within(x: Array, low: float, high: float) -> Array:
    """The numbers from `low` to `high`."""
    return x[(low <= x) & (x <= high)]


def hard_exponents_of_two() -> Array:
    """Halfway between multiples of log 2, too."""
    halves = with_neighbours((np.arange(-1009, 1009) + 0.5) * math.log(2.0))
    return within(np.concatenate([halves, hard_exponents()]), -700.0, 700.0)


def hard_logarithms_of_two() -> Array:
    """sqrt(2) times powers of 2, too; no subnormal numbers."""
    borders = with_neighbours(math.sqrt(2.0) * ends_of_exponents())
    return within(np.concatenate([borders, hard_logarithms()]), LEAST_NORMAL, LARGEST)


def hard_logarithms_less_one() -> Array:
    ends = np.array([-9 / 256, 5 / 128, 2.0**-53 - 1.0])
    borders = steps_of_bits(2.0**-53, 2.0**60, 45) - 1.0
    x = with_neighbours(np.concatenate([borders, ends, both_signs(ends_of_exponents())]))
    return x[x > -1.0]


def hard_angles() -> Array:
    """Close to multiples of pi/2, halfway between two of them, the borders of steps, the ends of ranges."""
    quarters = (np.arange(200_000) + 0.5) * (math.pi / 2.0)
    near = np.array(near_multiples_of_a_right_angle())
    ends = np.array([2.0**-27, 2.0**20, LARGEST])
    return both_signs(
        with_neighbours(np.concatenate([quarters, near, ends, steps_of_bits(0.06, 2.0, 47)])),
        ends_of_exponents(),
    )


def hard_tangents() -> Array:
    return both_signs(with_neighbours(steps_of_bits(0.03, 40.0, 47)), with_neighbours(ends_of_exponents()))


def hard_roots() -> Array:
    cubes = np.arange(1.0, 200_000.0) ** 3
    return both_signs(with_neighbours(cubes), with_neighbours(ends_of_exponents()))


HARD: dict[str, Callable[[], Array]] = {
    "exp": hard_exponents,
    "expm1": hard_exponents,
    "log": hard_logarithms,
    "log1p": hard_logarithms_less_one,
    **dict.fromkeys(("sin", "cos", "tan"), hard_angles),
    "atan": hard_tangents,
    "cbrt": hard_roots,
    "exp of two": hard_exponents_of_two,
    "small exp of two": lambda: within(hard_exponents(), -0.1, 0.1),
    "log of two": hard_logarithms_of_two,
    "atan2": partial(steps_of_bits, 2.0**-12, 2.0**12, 46),
}


def hard_arguments(name: str) -> tuple[Array, Array]:
    """The same of hard cases: borders between two ways of computing, and both ends of each exponent."""
    x = HARD[name]()
    if name == "atan2":  # x is the tangent of the angle
        across = np.random.default_rng(3).uniform(1.0, 2.0, len(x)) * np.where(
            np.arange(len(x)) % 2, 1.0, -1.0
        )
        return with_quotient(x, across)
    return x, np.ones_like(x)


def with_quotient(quotient: Array, across: Array) -> tuple[Array, Array]:
    """y and x with y/x close to the quotient, and beside it."""
    up = quotient * across
    parts = [np.nextafter(up, -np.inf), up, np.nextafter(up, np.inf)]
    return np.concatenate(parts), np.concatenate([across] * 3)
