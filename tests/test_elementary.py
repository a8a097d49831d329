"""The elementary functions of the core against 60 digits, and no others in the core."""

import ctypes
import math
import random
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache

import house
import mpmath
import pytest
from driver import ROOT

MP = mpmath.MPContext()
MP.dps = 60
COUNT = 1000  # arguments of each function
LARGEST, LEAST_NORMAL, LEAST = sys.float_info.max, sys.float_info.min, math.ulp(0.0)
INFINITY, NAN = math.inf, math.nan


@pytest.fixture(scope="module")
def functions(core):
    """The functions by name: exp, sin, max, ..."""
    code = """
        double shim_sin(double x) { return elementary_sin_cos(x).sin; }
        double shim_cos(double x) { return elementary_sin_cos(x).cos; }
        double shim_max(double x, double y) { return max_of(x, y); }
        double shim_min(double x, double y) { return min_of(x, y); }\n"""
    library = core(["elementary/elementary"], [], code)
    names = {name: f"elementary_{name}" for name in ("atan2", *EXACT) if name not in ("sin", "cos")}
    names |= {name: f"shim_{name}" for name in ("sin", "cos", "max", "min")}
    found = {}
    for name, symbol in names.items():
        found[name] = getattr(library, symbol)
        found[name].restype = ctypes.c_double
        count = 2 if name in ("atan2", "max", "min") else 1
        found[name].argtypes = (ctypes.c_double,) * count
    return found


def error(computed: float, exact) -> float:
    """In units of the last place of the exact value."""
    nearest = float(exact)
    unit = math.ulp(nearest) if abs(nearest) >= LEAST_NORMAL else LEAST
    return float(abs(MP.mpf(computed) - exact) / unit)


def sizes(r: random.Random, low: float, high: float) -> float:
    """A number of any sign; sizes from `low` to `high` are equally likely by their logarithm."""
    return r.choice((-1.0, 1.0)) * math.exp(r.uniform(math.log(low), math.log(high)))


def angles(r: random.Random) -> Iterator[float]:
    while True:
        yield r.uniform(-0.8, 0.8)
        yield sizes(r, 1e-9, 100.0)
        yield sizes(r, 1.0, 1e6)
        yield sizes(r, 1e6, 1e300)


def exponents(r: random.Random) -> Iterator[float]:
    while True:
        yield r.uniform(-1.0, 1.0)
        yield r.uniform(-745.0, 709.0)
        yield sizes(r, 1e-20, 700.0)


def positive(r: random.Random) -> Iterator[float]:
    while True:
        yield r.uniform(0.5, 2.0)
        yield 1.0 + sizes(r, 1e-15, 0.1)
        yield abs(sizes(r, 1e-320, 1e300))


def above_minus_one(r: random.Random) -> Iterator[float]:
    while True:
        yield r.uniform(-0.99, 1.0)
        yield r.uniform(-0.02, 0.02)
        yield abs(sizes(r, 1e-20, 1e300))


def any_size(r: random.Random) -> Iterator[float]:
    while True:
        yield r.uniform(-1.1, 1.1)
        yield sizes(r, 0.01, 100.0)
        yield sizes(r, 1e-320, 1e300)


EXACT = {
    "exp": (MP.exp, exponents),
    "expm1": (MP.expm1, exponents),
    "log": (MP.log, positive),
    "log1p": (MP.log1p, above_minus_one),
    "sin": (MP.sin, angles),
    "cos": (MP.cos, angles),
    "tan": (MP.tan, angles),
    "atan": (MP.atan, any_size),
    "cbrt": (lambda x: MP.sign(x) * MP.cbrt(abs(x)), any_size),
}


@pytest.mark.parametrize("name", EXACT)
def test_less_than_a_unit_in_the_last_place(functions, name):
    exact, arguments = EXACT[name]
    numbers = arguments(random.Random(1))
    for x in (next(numbers) for _ in range(COUNT)):
        assert error(functions[name](x), exact(MP.mpf(x))) < 1.0, x.hex()


def test_less_than_a_unit_of_an_angle_of_two_coordinates(functions):
    r = random.Random(2)
    for k in range(COUNT):
        y = sizes(r, 1e-300, 1e300) if k % 3 == 0 else r.uniform(-1.0, 1.0)
        x = sizes(r, 1e-320, 1e308) if k % 5 == 0 else y * sizes(r, 1e-3, 1e3)
        assert error(functions["atan2"](y, x), MP.atan2(MP.mpf(y), MP.mpf(x))) < 1.0, (y.hex(), x.hex())


@cache
def near_multiples_of_a_right_angle() -> list[float]:
    """For every eighth exponent the double closest to a multiple of pi/2: of the continued fraction of
    2^e/(pi/2), the last convergent whose denominator has at most 53 bits."""
    context = MP.clone()
    context.prec = 1400
    found, bits = [], 1300
    for e in range(-51, 972, 8):
        numerator, rest = int(context.floor(2 / context.pi * context.mpf(2) ** (e + bits))), 2**bits
        older, newer = 1, 0  # denominators of the convergents
        while rest > 0 and newer < 2**53:
            whole = numerator // rest
            numerator, rest = rest, numerator - whole * rest
            older, newer = newer, older + whole * newer
        found += [math.ldexp(older, e), math.ldexp(older * ((2**53 - 1) // older), e)]
    return [x for x in found if x >= 0.7]


@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
def test_near_multiples_of_a_right_angle(functions, name):
    """The closest of all doubles is 6381956970095103 2^797, by 4.7e-19."""
    numbers = near_multiples_of_a_right_angle()
    assert math.ldexp(6381956970095103, 797) in numbers
    exact = EXACT[name][0]
    for x in numbers:
        assert error(functions[name](x), exact(MP.mpf(x))) < 1.0, x.hex()


def test_at_the_ends_of_tables_and_ranges(functions):
    """The doubles beside each border between two ways of computing."""
    halves = [(k + 0.5) * math.log(2.0) / 64 for k in range(-70, 70)]
    steps = [0.70703125 + 0.0078125 * k for k in range(40)] + [1.0 + 0.0078125 * k for k in range(60)]
    borders = {
        "exp": [*halves, 700.0, -700.0, 709.782712893384, -708.3964185322641, -745.1332191019411],
        "expm1": [*halves, 0.25, -0.25, 2.0**-54, -40.0, 60.0],
        "log": [*steps, 2.0, 4.0, LEAST_NORMAL, 2.0 * LEAST, LARGEST],
        "log1p": [*(s - 1.0 for s in steps), 2.0**-54, 2.0**60, 2.0**-52 - 1.0],
        "sin": [math.pi / 4, 2.0**-27, 2.0**20, LARGEST],
        "cos": [math.pi / 4, 2.0**-27, 2.0**20, LARGEST],
        "tan": [math.pi / 4, 2.0**-27, 2.0**20, LARGEST],
        "atan": [*((k + 0.5) / 32 for k in range(33)), 1 / 16, 1.0, 16.0, 2.0**60, LARGEST, LEAST],
        "cbrt": [1.0, 2.0, 8.0, 27.0, LEAST, LEAST_NORMAL, LARGEST],
    }
    for name, numbers in borders.items():
        exact = EXACT[name][0]
        for number in numbers:
            for x in (math.nextafter(number, -INFINITY), number, math.nextafter(number, INFINITY)):
                if math.isfinite(x) and x != 0.0 and not (name == "exp" and x > 709.782712893384):
                    assert error(functions[name](x), exact(MP.mpf(x))) <= 1.0, (name, x.hex())


# function, arguments -> value
SPECIAL = [
    *[("exp", (x,), y) for x, y in ((0.0, 1.0), (-0.0, 1.0), (INFINITY, INFINITY), (-INFINITY, 0.0))],
    *[("exp", (x,), y) for x, y in ((709.8, INFINITY), (-745.2, 0.0), (1e300, INFINITY), (LEAST, 1.0))],
    *[("expm1", (x,), y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INFINITY, INFINITY), (-INFINITY, -1.0))],
    *[("expm1", (x,), y) for x, y in ((LEAST, LEAST), (-LEAST, -LEAST), (800.0, INFINITY))],
    *[("log", (x,), y) for x, y in ((1.0, 0.0), (0.0, -INFINITY), (-0.0, -INFINITY), (INFINITY, INFINITY))],
    *[("log", (x,), NAN) for x in (-1.0, -INFINITY, -LEAST)],
    *[("log1p", (x,), y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (-1.0, -INFINITY), (INFINITY, INFINITY))],
    *[("log1p", (x,), y) for x, y in ((LEAST, LEAST), (-1.5, NAN))],
    *[("sin", (x,), y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (LEAST, LEAST), (INFINITY, NAN))],
    *[("cos", (x,), y) for x, y in ((0.0, 1.0), (LEAST, 1.0), (-INFINITY, NAN))],
    *[("tan", (x,), y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (-LEAST, -LEAST), (INFINITY, NAN))],
    *[("atan", (x,), y) for x, y in ((-0.0, -0.0), (LEAST, LEAST), (INFINITY, math.pi / 2))],
    ("atan", (-INFINITY,), -math.pi / 2),
    *[
        ("cbrt", (x,), y)
        for x, y in ((-0.0, -0.0), (INFINITY, INFINITY), (-INFINITY, -INFINITY), (27.0, 3.0))
    ],
    *[(name, (NAN,), NAN) for name in EXACT],
    *[
        ("atan2", (y, x), math.atan2(y, x))
        for y in (0.0, -0.0, 1.0, -1.0, LEAST, INFINITY, -INFINITY, NAN)
        for x in (0.0, -0.0, 1.0, -1.0, INFINITY, -INFINITY, NAN)
    ],
    *[("max", pair, 2.0) for pair in ((1.0, 2.0), (2.0, 1.0), (2.0, NAN), (NAN, 2.0), (-INFINITY, 2.0))],
    *[("min", pair, 1.0) for pair in ((1.0, 2.0), (2.0, 1.0), (1.0, NAN), (NAN, 1.0), (INFINITY, 1.0))],
    *[("max", pair, pair[1]) for pair in ((0.0, -0.0), (-0.0, 0.0))],
    *[("min", pair, pair[1]) for pair in ((0.0, -0.0), (-0.0, 0.0))],
    ("max", (NAN, NAN), NAN),
]


@pytest.mark.parametrize(("name", "arguments", "value"), SPECIAL)
def test_zeros_infinities_and_nan(functions, name, arguments, value):
    found = functions[name](*arguments)
    if math.isnan(value):
        assert math.isnan(found)
    else:
        assert (found, math.copysign(1.0, found)) == (value, math.copysign(1.0, value))


def test_tables_are_what_their_script_computes():
    command = [sys.executable, str(ROOT / "fmu_src/tools/make_elementary.py"), "--check"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


# ---- no others in the core ----

OF_THE_FMUS = {room for room in house.MAY_INCLUDE if room not in ("tools", *house.OUTSIDE_THE_FMUS)}
# Functions of math.h. IEEE 754 fixes the bits of sqrt, fabs, floor, ceil, trunc and copysign.
LEFT_TO_THE_LIBRARY = re.compile(
    r"\b(a?(?:sin|cos|tan)h?|atan2|exp2?|expm1|log(?:2|10|1p|b)?|pow|hypot|cbrt|erfc?|[lt]gamma|fm(?:in|ax|od|a)|"
    r"fdim|remainder|remquo|l?l?r(?:ound|int)|nearbyint|sincos|ldexp|frexp|scalbl?n|nextafter|j[01n]|y[01n])[fl]?\("
)


def calls_of(text: str) -> list[str]:
    return [match[1] for match in LEFT_TO_THE_LIBRARY.finditer(house.COMMENT_OR_TEXT.sub(" ", text))]


def test_the_core_calls_no_elementary_function_of_the_c_library():
    """Call elementary_exp(), max_of(), ... of fmu_src/elementary/elementary.h instead."""
    found = [
        f"{path.relative_to(ROOT)}: {name}()"
        for path in house.source_files(ROOT)
        if house.room_of(ROOT, path) in OF_THE_FMUS
        for name in calls_of(path.read_text(encoding="utf-8"))
    ]
    assert found == []


@pytest.mark.parametrize(
    "call", ["exp(x)", "fmax (a, b)", "sinf(x)", "atan2(y, x)", "lround(x)", "fma(a, b, c)"]
)
def test_the_search_finds_calls(call):
    assert calls_of(f"y = {call.replace(' (', '(')};")
    assert not calls_of(f"/* {call} */ elementary_{call}; sqrt(x); fabs(x); max_of(a, b); table_log(x)")
