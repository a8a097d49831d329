"""The elementary functions of the core against 60 digits, and no others in the core."""

import ctypes
import math
import re
import subprocess
import sys
from collections.abc import Sequence

import house
import numpy as np
import pytest
from driver import ROOT

from verification.elementary import arguments
from verification.elementary.errors import EXACT, OF_TWO, Reference, exact_error

COUNT = 1000  # arguments of each function
HARD = 5000  # of the hard ones
LEAST_NORMAL, LARGEST, LEAST = arguments.LEAST_NORMAL, arguments.LARGEST, math.ulp(0.0)
INFINITY, NAN = math.inf, math.nan


VECTORS = dict(zip(OF_TWO, ("vector2_exp", "vector2_exp_small", "vector2_log"), strict=True))


@pytest.fixture(scope="module")
def functions(core):
    """The functions by name: exp, sin, max, ..."""
    code = """
        double shim_sin(double x) { return elementary_sin_cos(x).sin; }
        double shim_cos(double x) { return elementary_sin_cos(x).cos; }
        double shim_max(double x, double y) { return max_of(x, y); }
        double shim_min(double x, double y) { return min_of(x, y); }\n"""
    code += "".join(
        f"double shim_{function}(double x) {{ return {function}((Vector2){{x, 1.0}})[0]; }}\n"
        for function in VECTORS.values()
    )
    library = core(["elementary/elementary", "elementary/vector2"], [], code)
    names = {name: f"elementary_{name}" for name in EXACT if name not in ("sin", "cos")}
    names |= {name: f"shim_{name}" for name in ("sin", "cos", "max", "min")}
    names |= {name: f"shim_{function}" for name, function in VECTORS.items()}
    found = {}
    for name, symbol in names.items():
        found[name] = getattr(library, symbol)
        found[name].restype = ctypes.c_double
        count = 2 if name in ("atan2", "max", "min") else 1
        found[name].argtypes = (ctypes.c_double,) * count
    return found


def value(functions, name: str, x: float, second: float) -> float:
    return functions[name](x, second) if name == "atan2" else functions[name](x)


def off(functions, name: str, x: float, second: float = 1.0) -> float:
    """The size of the error by 60 digits, in units of the last place of the exact value."""
    return abs(exact_error(name, x, second, value(functions, name, x, second)))


@pytest.mark.parametrize("name", [*EXACT, *OF_TWO])
def test_less_than_a_unit_in_the_last_place(functions, name):
    numbers = arguments.random_arguments(name, np.random.default_rng(5), COUNT)
    for x, second in zip(*(part.tolist() for part in numbers), strict=True):
        assert off(functions, name, x, second) < 1.0, (x.hex(), second.hex())


@pytest.fixture(scope="module")
def reference():
    return Reference(["-O2", "-fPIC", "-shared"])


@pytest.mark.parametrize("name", [*EXACT, *OF_TWO])
def test_less_than_a_unit_at_hard_arguments(functions, reference, name):
    """Double-double arithmetic gives all errors, 60 digits those of each 25th argument."""
    x, second = arguments.hard_arguments(name)
    chosen = np.linspace(0, len(x) - 1, HARD).astype(int)
    x, second = x[chosen].copy(), second[chosen].copy()
    y = np.array([value(functions, name, *pair) for pair in zip(x.tolist(), second.tolist(), strict=True)])
    found = reference.errors(name, x, second, y)
    assert np.max(abs(found)) < 1.0
    for k in range(0, HARD, 25):
        assert exact_error(name, float(x[k]), float(second[k]), float(y[k])) == pytest.approx(
            found[k], rel=0.0, abs=1e-9
        )


@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
def test_near_multiples_of_a_right_angle(functions, name):
    """The closest of all doubles is 6381956970095103 2^797, by 4.7e-19."""
    numbers = arguments.near_multiples_of_a_right_angle(8)
    assert math.ldexp(6381956970095103, 797) in numbers
    for x in numbers:
        assert off(functions, name, x) < 1.0, x.hex()


def test_at_the_ends_of_ranges(functions):
    """The doubles beside each border between two ways of computing."""
    ends: dict[str, Sequence[float]] = {
        "exp": [700.0, -700.0, 709.782712893384, -708.3964185322641, -745.1332191019411],
        "expm1": [0.25, -0.25, 2.0**-54, -40.0, 60.0],
        "log": [
            1.0,
            2.0,
            4.0,
            LEAST_NORMAL,
            2.0 * LEAST,
            LARGEST,
            0.96484375,
            1.0390625,
            math.ldexp(0.70703125, 1023),
        ],
        "log1p": [2.0**-54, 2.0**53, 2.0**60, 2.0**-52 - 1.0, -0.03515625, 0.0390625, LARGEST],
        **dict.fromkeys(("sin", "cos", "tan"), (math.pi / 4, 2.0**-27, 2.0**20, LARGEST, 0.125)),
        "atan": [1 / 8, 1.0, 8.0, 2.0**60, LARGEST, LEAST],
        "cbrt": [1.0, 2.0, 8.0, 27.0, LEAST, LEAST_NORMAL, LARGEST],
    }
    for name, numbers in ends.items():
        for number in numbers:
            for x in (math.nextafter(number, -INFINITY), number, math.nextafter(number, INFINITY)):
                if math.isfinite(x) and x != 0.0 and not (name == "exp" and x > 709.782712893384):
                    assert off(functions, name, x) <= 1.0, (name, x.hex())


@pytest.mark.parametrize("scale", [1e-320, 1e-300, 1e-150, 1.0, 1e160, 1e307])
def test_angle_of_coordinates_of_any_size(functions, scale):
    for tangent in (1e-15, 0.0624, 0.0626, 0.7, 15.9, 16.1, 7.99, 8.01, 0.1249, 0.1251, 1e15):
        for x in (scale, -scale, 2.7 * scale, -2.7 * scale):
            y = x * tangent
            if math.isfinite(y) and y != 0.0:
                assert off(functions, "atan2", y, x) < 1.0, (y.hex(), x.hex())


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
    *[(name, (NAN,), NAN) for name in EXACT if name != "atan2"],
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

OF_THE_FMUS = {room for room in house.MAY_INCLUDE if room != "tools"}
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
