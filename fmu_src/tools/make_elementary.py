"""Writes the coefficients and tables of fmu_src/elementary, computed at 60 digits.

    python fmu_src/tools/make_elementary.py [--check]

A polynomial is the one whose greatest relative error is least, found by the exchange of E. Remez (J.-M.
Muller, Elementary Functions, 3rd ed., section 3.6). The script refuses a polynomial whose error is more than
2^-57 of the function; rounding of the coefficients counts too.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import generated
import mpmath
import numpy as np

ROOM = Path(__file__).resolve().parent.parent / "elementary"
MP = mpmath.MPContext()
MP.dps = 60
Number = Any  # of MP
Function = Callable[[Number], Number]
LARGEST_ERROR = 2.0**-57
GRID, EXCHANGES = 400, 6
EXP_STEPS, LOG_BITS, ATAN_BITS, TAN_BITS = 64, 6, 3, 3
LOG_NEAR_BELOW, LOG_NEAR_ABOVE = 4, 2  # steps beside that of 1
SPARE_BITS = 5


def rounded(x: Number) -> Number:
    return MP.mpf(float(x))


def multiple(x: Number, unit: Number) -> Number:
    """The multiple of `unit` that is nearest to x."""
    return MP.nint(x / unit) * unit


def parts(x: Number, *bits: int) -> list[Number]:
    """Numbers that add up to x: of so many bits each, and the rest as a double."""
    found = []
    for count in bits:
        unit = MP.mpf(2) ** (int(MP.floor(MP.log(abs(x), 2))) + 1 - count)
        found.append(multiple(x, unit))
        x -= found[-1]
    return [*found, rounded(x)]


def extremes(values: Sequence[Number]) -> list[int]:
    """Where |values| is largest between changes of sign."""
    found = [0]
    for k, x in enumerate(values):
        if x * values[found[-1]] < 0:
            found.append(k)
        elif abs(x) > abs(values[found[-1]]):
            found[-1] = k
    return found


def series(f: Function, degree: int, low: Number, high: Number, weight: Function) -> list[Number]:
    """Rounded coefficients of the polynomial whose greatest weighted error on [low, high] is least.

    `weight(x)`: what one unit of error in the polynomial does to the function, relative to the function. In
    each exchange the polynomial gets errors of one size and alternating signs at `degree + 2` points. Then
    these points move to the extremes of the error.

    Raises
    ------
    ValueError
        The relative error of the function is more than LARGEST_ERROR.
    """
    middle, half = (high + low) / 2, (high - low) / 2
    grid = [middle - half * MP.cos(MP.pi * k / GRID) for k in range(GRID + 1)]
    exact, weights = [f(x) for x in grid], [weight(x) for x in grid]
    points = [(GRID * k + GRID // 7) // (degree + 2) for k in range(degree + 2)]
    for _ in range(EXCHANGES):
        rows = [
            [weights[k] * grid[k] ** n for n in range(degree + 1)] + [(-1) ** i] for i, k in enumerate(points)
        ]
        right = MP.matrix([weights[k] * exact[k] for k in points])
        found = list(MP.lu_solve(MP.matrix(rows), right))[: degree + 1]
        errors = [w * (y - MP.polyval(found[::-1], x)) for x, y, w in zip(grid, exact, weights, strict=True)]
        turns = extremes(errors)
        while len(turns) > degree + 2:
            turns.pop(0 if abs(errors[turns[0]]) < abs(errors[turns[-1]]) else -1)
        if len(turns) < degree + 2:
            break
        points = turns
    found = [rounded(c) for c in found]
    worst = max(
        abs(w * (y - MP.polyval(found[::-1], x))) for x, y, w in zip(grid, exact, weights, strict=True)
    )
    if worst > LARGEST_ERROR:
        raise ValueError(f"a polynomial of degree {degree} has an error of 2^{float(MP.log(worst, 2)):.1f}")
    return found


def text(x: Number) -> str:
    value = float(x)
    assert MP.mpf(value) == x
    return "0" if value == 0.0 else value.hex().replace("0000000p", "p")


def constant(name: str, x: Number) -> str:
    return f"static const double {name} = {text(x)};\n"


def wrapped(entries: Iterable[str], indent: int) -> str:
    """As many entries a line as fit into 120 columns."""
    found = [" " * indent]
    for entry in entries:
        if len(found[-1]) + len(entry) > 118:
            found.append(" " * indent)
        found[-1] += f"{entry}, "
    return "".join(f"{line.rstrip()}\n" for line in found)


def lines(numbers: Sequence[Number], indent: int) -> str:
    return wrapped(map(text, numbers), indent)


def pairs(entries_of: Iterable[Sequence[Number]]) -> str:
    return wrapped((f"{{{', '.join(map(text, entry))}}}" for entry in entries_of), 4)


def constants(name: str, numbers: Sequence[Number]) -> str:
    return f"static const double {name}[{len(numbers)}] = {{\n{lines(numbers, 4)}}};\n"


def rows(kind: str, name: str, fields: str, entries_of: Iterable[Sequence[Number]]) -> str:
    entries = list(entries_of)
    struct = f"typedef struct {{\n    double {fields};\n}} {kind};\n\n"
    return f"{struct}static const {kind} {name}[{len(entries)}] = {{\n{pairs(entries)}}};\n"


def exponential() -> str:
    def tail(x: Number, terms: int) -> Number:
        """The series of exp(x) from x^terms/terms! on, over x^terms."""
        return MP.nsum(lambda n: x**n / MP.factorial(n + terms), [0, 40])

    step = MP.log(2) / EXP_STEPS
    high, low = parts(step, 36)
    powers = [MP.mpf(2) ** (MP.mpf(k) / EXP_STEPS) for k in range(EXP_STEPS)]
    near = step * MP.mpf("0.501")
    quarter = MP.mpf(1) / 4
    return "\n".join(
        [
            f"enum {{ EXP_STEPS = {EXP_STEPS} }}; /* of one binade */\n",
            constant("EXP_STEPS_PER_UNIT", rounded(1 / step)),
            constant("EXP_STEP_HIGH", high) + constant("EXP_STEP_LOW", low),
            "/* The largest x with a finite exp(x), and the least with exp(x) above half of the least number"
            " */",
            constant("EXP_OVERFLOW", rounded(1024 * MP.log(2)))
            + constant("EXP_UNDERFLOW", rounded(-1075 * MP.log(2))),
            "/* (exp(x) - 1 - x)/x^2 */",
            constants("EXP_SERIES", series(lambda x: tail(x, 2), 3, -near, near, lambda x: x * x)),
            "/* (exp(x) - 1 - x - x^2/2)/x^3 */",
            constants(
                "EXPM1_SERIES",
                series(lambda x: tail(x, 3), 8, -quarter, quarter, lambda x: x**3 / MP.expm1(x) if x else x),
            ),
            "/* 2^(k/EXP_STEPS) and the relative rounding */",
            rows(
                "ExpPower",
                "EXP_POWER",
                "power, tail",
                [(rounded(p), rounded(p / rounded(p) - 1)) for p in powers],
            ),
        ]
    )


def near_doubles(x: Number, *functions: Function) -> Number:
    """The number of 26 bits nearest to x at which each function is a double up to 2^-(53 + SPARE_BITS).

    So a table needs no second parts (S. Gal, Computing elementary functions: a new approach for achieving
    high accuracy and good performance, Springer LNCS 235, 1986)."""
    unit = MP.mpf(2) ** (int(MP.floor(MP.log(x, 2))) - 25)
    for k in range(20 * 2 ** (SPARE_BITS * len(functions))):
        at = multiple(x, unit) + (-1) ** k * ((k + 1) // 2) * unit
        values = (f(at) for f in functions)
        if all(abs(value / rounded(value) - 1) < MP.mpf(2) ** (-53 - SPARE_BITS) for value in values):
            return at
    raise ValueError(f"no number near {float(x)}")


def near_multiple_of_log(x: Number, unit: Number, allowed: Number) -> Number:
    """The first x + k 2^-40 whose logarithm is a multiple of `unit` up to what is allowed.

    The logarithm in units, less its whole part, is the sum of its value at x, of k times the first derivative
    (integers of 64 bits leave out whole units) and of the next terms of its series."""
    step = MP.mpf(2) ** -40
    limit = float(allowed / unit)
    at, slope = (np.uint64(int(MP.floor(value / unit * 2**64)) % 2**64) for value in (MP.log(x), step / x))
    second, third = (float((-1) ** (n + 1) * (step / x) ** n / n / unit) for n in (2, 3))
    for block in range(16):
        k = np.arange(block << 18, (block + 1) << 18, dtype=np.uint64)
        of_k = k.astype(float)
        units = (at + slope * k).astype(float) * 2.0**-64 + of_k * of_k * (second + third * of_k)
        hits = np.flatnonzero(abs(units - np.rint(units)) < limit)
        if hits.size:
            return x + int(k[hits[0]]) * step
    raise ValueError(f"no number near {float(x)}")


def arrays(kind: str, name: str, fields: Mapping[str, Sequence[Number]]) -> str:
    """A struct of arrays: one index reaches them all."""
    count = len(next(iter(fields.values())))
    members = ", ".join(f"{field}[{count}]" for field in fields)
    struct = f"typedef struct {{\n    double {members};\n}} {kind};\n\n"
    body = "".join(f"    .{field} = {{\n{lines(numbers, 8)}    }},\n" for field, numbers in fields.items())
    return f"{struct}static const {kind} {name} = {{\n{body}}};\n"


def logarithm() -> str:
    count = 2**LOG_BITS
    first = MP.mpf(float.fromhex("0x1.6ap-1"))

    def edge(j: int) -> Number:
        """The j-th border of the steps of m. Steps are equal in the bits of m."""
        half_units = MP.mpf(j) / count * 2 + (first - MP.mpf(1) / 2) * 4  # above 1/2, in units of 1/4
        return MP.mpf(1) / 2 + half_units / 4 if half_units <= 2 else 1 + (half_units - 2) / 2

    at_one = next(j for j in range(count) if edge(j) < 1 < edge(j + 1))
    near = range(at_one - LOG_NEAR_BELOW, at_one + LOG_NEAR_ABOVE + 1)
    least = min(abs(MP.log(edge(near[0]))), MP.log(edge(near[-1] + 1)))  # of |log m| outside of `near`
    unit = MP.mpf(2) ** -42
    middle = [(edge(j) + edge(j + 1)) / 2 for j in range(count)]
    # Numbers m in the steps around 1 come with n log 2, n != 0: then the result is at least 0.65.
    results = [MP.mpf("0.65") if j in near else abs(MP.log(c)) for j, c in enumerate(middle)]
    centre = [
        near_multiple_of_log(c, unit, result * MP.mpf(2) ** -57)
        for c, result in zip(middle, results, strict=True)
    ]
    widest = max(max(c - edge(j), edge(j + 1) - c) / c for j, c in enumerate(centre))
    low_edge, high_edge = edge(near[0]) - 1, edge(near[-1] + 1) - 1
    two_high = multiple(MP.log(2), unit)

    def rest(r: Number) -> Number:
        """(log(1 + r) - r)/r^2"""
        return -MP.nsum(lambda n: (-r) ** n / (n + 2), [0, 60])

    def of_value(r: Number) -> Number:
        return r * r / MP.log1p(r) if r else r

    return "\n".join(
        [
            f"enum {{ LOG_BITS = {LOG_BITS} }}; /* the steps of a binade are 2^LOG_BITS */\n",
            "/* The steps around 1, which have the series of their own: the first one, and how many */",
            f"enum {{ LOG_NEAR = {near[0]}, LOG_NEAR_STEPS = {len(near)} }};\n",
            "/* log 2 in two parts. Multiples of 2^-42 add up without rounding. */",
            constant("LOG_2_HIGH", two_high) + constant("LOG_2_LOW", rounded(MP.log(2) - two_high)),
            f"/* (log(1 + r) - r)/r^2, |r| < {float(widest):.5f} */",
            constants("LOG_SERIES", series(rest, 5, -widest, widest, lambda r: r * r / least)),
            f"/* The same, {float(low_edge):.5f} <= r <= {float(high_edge):.5f} */",
            constant("LOG_NEAR_LOW", low_edge) + constant("LOG_NEAR_HIGH", high_edge),
            constants("LOG_NEAR_SERIES", series(rest, 8, low_edge, high_edge, of_value)),
            "/* c near the middle of a step, 1/c, and log c, a multiple of 2^-42 up to 2^-57 of results */",
            arrays(
                "LogSteps",
                "LOG_STEPS",
                {
                    "centre": centre,
                    "inverse": [rounded(1 / c) for c in centre],
                    "log": [multiple(MP.log(c), unit) for c in centre],
                },
            ),
        ]
    )


def two_by_pi(words: int) -> list[int]:
    context = MP.clone()
    context.prec = 32 * words + 100
    bits = int(context.floor(2 / context.pi * context.mpf(2) ** (32 * words)))
    return [bits >> 32 * (words - 1 - k) & 0xFFFFFFFF for k in range(words)]


def trigonometric() -> str:
    zero, quarter = MP.mpf(0), (MP.pi / 4 * MP.mpf("1.0001")) ** 2

    def sine(z: Number) -> Number:
        return MP.nsum(lambda n: (-1) ** int(n + 1) * z**n / MP.factorial(2 * n + 3), [0, 30])

    def cosine(z: Number) -> Number:
        return MP.nsum(lambda n: (-1) ** int(n) * z**n / MP.factorial(2 * n + 4), [0, 30])

    of_sine = series(sine, 5, zero, quarter, lambda z: z)
    of_cosine = series(cosine, 5, zero, quarter, lambda z: z * z)
    words = two_by_pi(37)
    digits = wrapped((f"0x{word:08x}" for word in words), 4)
    first, second, third, fourth = parts(MP.pi / 2, 33, 33, 33)
    return "\n".join(
        [
            constant("TWO_BY_PI_ROUNDED", rounded(2 / MP.pi)),
            "/* pi/2 in four parts, of which three have 33 bits, and in two parts */",
            constant("HALF_PI_1", first) + constant("HALF_PI_2", second),
            constant("HALF_PI_3", third) + constant("HALF_PI_4", fourth),
            constant("HALF_PI_HIGH", rounded(MP.pi / 2))
            + constant("HALF_PI_LOW", rounded(MP.pi / 2 - rounded(MP.pi / 2))),
            "/* (sin(x) - x)/x^3 and (cos(x) - 1 + x^2/2)/x^4 as polynomials in x^2, side by side */",
            "typedef double Pair __attribute__((vector_size(16)));\n",
            f"static const Pair SIN_COS_SERIES[{len(of_sine)}] = {{\n"
            + pairs(zip(of_sine, of_cosine, strict=True))
            + "};\n",
            "/* The binary digits of 2/pi, 32 in a word */",
            f"static const uint32_t TWO_BY_PI[{len(words)}] = {{\n{digits}}};\n",
        ]
    )


def tangent() -> str:
    def rest(z: Number) -> Number:
        x = MP.sqrt(z)
        return (MP.tan(x) - x) / x**3 if z > MP.mpf(10) ** -12 else MP.mpf(1) / 3 + z * 2 / 15

    first, count = MP.mpf(1) / 8, 2**TAN_BITS
    edges = [first * 2 ** (j // count) * (1 + MP.mpf(j % count) / count) for j in range(3 * count)]
    edges = edges[: 1 + sum(1 for x in edges if x < MP.pi / 4)]
    centre = [near_doubles((a + b) / 2, MP.tan, MP.cot) for a, b in pairwise(edges)]
    return "\n".join(
        [
            f"enum {{ TAN_BITS = {TAN_BITS} }}; /* the steps of a binade are 2^TAN_BITS */\n",
            constant("TAN_FIRST", first),
            "/* (tan(x) - x)/x^3 as a polynomial in x^2, |x| <= 1/8 */",
            constants("TAN_SERIES", series(rest, 5, MP.mpf(0), first**2, lambda z: z)),
            "/* c near the middle of a step, of 26 bits. Its tangent and its cotangent are doubles up to"
            f" 2^-{53 + SPARE_BITS} of themselves */",
            arrays(
                "TanSteps",
                "TAN_STEPS",
                {
                    "centre": centre,
                    "tangent": [rounded(MP.tan(c)) for c in centre],
                    "cotangent": [rounded(MP.cot(c)) for c in centre],
                },
            ),
        ]
    )


def arctangent() -> str:
    def rest(z: Number) -> Number:
        return MP.nsum(lambda n: (-1) ** int(n + 1) * z**n / (2 * n + 3), [0, 60])

    def pair(name: str, x: Number) -> str:
        return (
            f"static const DoubleDouble {name} = {{{text(rounded(x))}, {text(rounded(x - rounded(x)))}}};\n"
        )

    count = 2**ATAN_BITS
    lowest, highest = -3 * count, 3 * count
    edges = [MP.mpf(2) ** (j // count) * (1 + MP.mpf(j % count) / count) for j in range(lowest, highest + 1)]
    centre = [near_doubles((a + b) / 2, MP.atan) for a, b in pairwise(edges)]
    farthest = max(max(abs(x - c) / (1 + c * x) for x in edges[j : j + 2]) for j, c in enumerate(centre))
    zero, least = MP.mpf(0), edges[0]
    return "\n".join(
        [
            f"enum {{ ATAN_BITS = {ATAN_BITS} }}; /* the steps of a binade are 2^ATAN_BITS */\n",
            constant("ATAN_FIRST", edges[0]) + constant("ATAN_LAST", edges[-1]),
            pair("PI", MP.pi) + pair("HALF_PI", MP.pi / 2),
            f"/* (atan(t) - t)/t^3 as a polynomial in t^2, |t| <= {float(farthest):.5f} */",
            constants("ATAN_SERIES", series(rest, 3, zero, farthest**2, lambda z: z**1.5 / least)),
            "/* The same, |t| <= 1/8 */",
            constants("ATAN_NEAR_SERIES", series(rest, 5, zero, least**2, lambda z: z)),
            "/* c near the middle of a step, of 26 bits, and its angle, which is a double up to"
            f" 2^-{53 + SPARE_BITS} of itself */",
            arrays(
                "AtanSteps",
                "ATAN_STEPS",
                {"centre": centre, "angle": [rounded(MP.atan(c)) for c in centre]},
            ),
        ]
    )


def roots() -> str:
    def start(m: Number) -> Number:
        return MP.cbrt(m)

    one, eight = MP.mpf(1), MP.mpf(8)
    middle = (one + eight) / 2
    nodes = [middle + (eight - one) / 2 * MP.cos(MP.pi * (2 * k + 1) / 8) for k in range(4)]
    powers = MP.matrix([[x**n for n in range(4)] for x in nodes])
    found = [rounded(c) for c in MP.lu_solve(powers, MP.matrix([start(x) for x in nodes]))]
    return "/* The third root of m, 1 <= m <= 8, to two digits */\n" + constants("CBRT_START", found)


def of_two() -> str:
    def half_coth(z: Number) -> Number:
        """(x coth(x/2) - 2)/x^2 at z = x^2, by its series with the numbers of Bernoulli"""
        return MP.nsum(lambda n: 2 * MP.bernoulli(2 * n + 2) * z**n / MP.factorial(2 * n + 2), [0, 20])

    def artanh(z: Number) -> Number:
        """(2 artanh(s) - 2 s)/s^3 at z = s^2"""
        return MP.nsum(lambda n: 2 * z**n / (2 * n + 3), [0, 80])

    def exp_series(terms: int, largest: Number) -> list[Number]:
        # exp(x) = 1 + 2 x/(x coth(x/2) - x)
        return series(half_coth, terms - 1, MP.mpf(0), largest**2, lambda z: z * MP.sqrt(z) / 2)

    half_binade, small = MP.log(2) / 2 * MP.mpf("1.0001"), MP.mpf(1) / 10
    largest = (MP.sqrt(2) - 1) / (MP.sqrt(2) + 1) * MP.mpf("1.0001")
    high = parts(MP.log(2), 32)[0]
    return "\n".join(
        [
            "/* log 2 in two parts, of which the first has 32 bits */",
            constant("OF_TWO_LOG_2_HIGH", high) + constant("OF_TWO_LOG_2_LOW", rounded(MP.log(2) - high)),
            "/* (x coth(x/2) - 2)/x^2 as a polynomial in x^2, |x| <= log(2)/2 */",
            constants("OF_TWO_EXP_SERIES", exp_series(5, half_binade)),
            f"/* The same, |x| <= {float(small)} */",
            constant("OF_TWO_EXP_SMALL", rounded(small)),
            constants("OF_TWO_EXP_SMALL_SERIES", exp_series(3, small)),
            "/* (2 artanh(s) - 2 s)/s^3 as a polynomial in s^2, |s| <= (sqrt(2) - 1)/(sqrt(2) + 1) */",
            constants("OF_TWO_LOG_SERIES", series(artanh, 6, MP.mpf(0), largest**2, lambda z: z)),
        ]
    )


def texts() -> dict[Path, str]:
    made = {
        "exponential": ("", exponential()),
        "logarithm": ("", logarithm()),
        "trigonometric": ("#include <stdint.h>\n\n", trigonometric()),
        "tangent": ("", tangent()),
        "arctangent": ('#include "elementary/double_double.h"\n\n', arctangent()),
        "roots": ("", roots()),
        "of_two": ("", of_two()),
    }
    head = generated.head_of(__file__)
    return {ROOM / f"{name}_table.h": f"{head}{includes}{body}" for name, (includes, body) in made.items()}


if __name__ == "__main__":
    sys.exit(generated.write_or_check(texts, __file__))
