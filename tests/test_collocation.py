"""The numbers and the polynomials that the integrator of general grooves rests on."""

import ctypes
import json
import math
import re
import subprocess
import sys
from fractions import Fraction
from itertools import pairwise, permutations, product

import numpy as np
import pytest
from driver import ROOT, Structure
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import cumulative_simpson

MOST, WIDTH = 7, 8  # stages; entries of a column


class Radau(Structure):
    """radau.h"""

    _fields_ = (
        ("stages", ctypes.c_int),
        ("node", ctypes.c_double * MOST),
        ("once", (ctypes.c_double * WIDTH) * MOST),
        ("twice", (ctypes.c_double * WIDTH) * MOST),
        ("weight", ctypes.c_double * MOST),
        ("at_start", ctypes.c_double * MOST),
        ("defect_once", ctypes.c_double),
        ("defect_twice", ctypes.c_double),
        ("bernstein", (ctypes.c_double * WIDTH) * (MOST + 1)),
    )


class Bernstein(Structure):
    """bernstein.h"""

    _fields_ = (("degree", ctypes.c_int), ("c", ctypes.c_double * 9))


CODE = """\
#include "collocation/lobatto_system.h"
double cubic_term(const double *x) {
    const LobattoValues v = {{x[0], x[1], x[2], x[3]}};
    return lobatto_cubic_term(&v);
}
double largest(const double *x) {
    const LobattoValues v = {{x[0], x[1], x[2], x[3]}};
    return lobatto_largest(lobatto_range(&v));
}
"""


@pytest.fixture(scope="module")
def library(core):
    made = core(["numerics/bernstein", "numerics/lobatto", "numerics/radau"], [Radau, Bernstein], CODE)
    made.cubic_term.restype = made.largest.restype = ctypes.c_double
    made.radau_of.restype = ctypes.POINTER(Radau)
    made.radau_polynomial.restype = Bernstein
    made.radau_polynomial.argtypes = (ctypes.POINTER(Radau), ctypes.POINTER(ctypes.c_double))
    for name in ("bernstein_descent", "bernstein_peak", "bernstein_value"):
        getattr(made, name).restype = ctypes.c_double
    made.bernstein_value.argtypes = (ctypes.POINTER(Bernstein), ctypes.c_double)
    made.bernstein_is_monotone.restype = ctypes.c_bool
    return made


def test_table_is_what_its_script_computes():
    command = [sys.executable, str(ROOT / "fmu_src/tools/make_collocation.py"), "--check"]
    assert subprocess.run(command, capture_output=True, text=True).returncode == 0


@pytest.mark.parametrize("stages", [3, 5, 7])
def test_order_conditions(library, stages):
    """Exact integrals of monomials: at the end to degree 2s - 2, inside to degree s - 1, once and twice."""
    r = library.radau_of(stages).contents
    assert r.stages == stages
    c = np.array(r.node[:stages])
    once = np.array([column[:stages] for column in r.once[:stages]]).T
    twice = np.array([column[:stages] for column in r.twice[:stages]]).T
    np.testing.assert_array_equal(once[-1], r.weight[:stages])
    assert not any(any(column[stages:]) for matrix in (r.once, r.twice) for column in matrix)
    assert c[-1] == 1
    assert np.all(np.diff(c) > 0)
    for k in range(2 * stages - 1):
        assert once[-1] @ c**k == pytest.approx(float(Fraction(1, k + 1)), abs=2e-16 * 8)
    for k in range(stages):
        np.testing.assert_allclose(once @ c**k, c ** (k + 1) / (k + 1), atol=2e-15)
        np.testing.assert_allclose(twice @ c**k, c ** (k + 2) / (k + 1) / (k + 2), atol=2e-15)
        assert np.array(r.at_start[:stages]) @ c**k == pytest.approx(float(k == 0), abs=1e-14)


def lobatto() -> dict[str, np.ndarray]:
    """The numbers of lobatto_table.h; of a matrix those that belong to one node are a row."""
    text = (ROOT / "fmu_src/numerics/lobatto_table.h").read_text()
    found = re.findall(r"\.(\w+) = ([{}\d.,e\s-]+),\n", text)
    lists = {name: json.loads(value.translate(str.maketrans("{}", "[]"))) for name, value in found}
    return {name: np.squeeze(np.array(numbers)) for name, numbers in lists.items()}


def test_order_conditions_of_lobatto():
    """Exact integrals of monomials: at the end to degree 5, inside to degree 3, once and twice."""
    table = lobatto()
    c, once, twice, weight = (table[name] for name in ("node", "once", "twice", "weight"))
    assert c[0] == 0
    assert c[3] == 1
    np.testing.assert_allclose(c[1:3], [0.5 - math.sqrt(0.05), 0.5 + math.sqrt(0.05)], atol=1e-16)
    np.testing.assert_array_equal(once[:, 3], weight)
    for k in range(6):
        assert weight @ c**k == pytest.approx(1 / (k + 1), abs=1e-15)
    for k in range(5):
        assert twice[:, 3] @ c**k == pytest.approx(1 / (k + 1) / (k + 2), abs=1e-15)
    for k in range(4):
        np.testing.assert_allclose(c**k @ once, c ** (k + 1) / (k + 1), atol=1e-15)
        np.testing.assert_allclose(c**k @ twice, c ** (k + 2) / (k + 1) / (k + 2), atol=1e-15)


def test_largest_size_of_four_values(library):
    """The largest size stands at each node in turn, above and below zero."""
    for signs in product([1.0, -1.0], repeat=4):
        for order in permutations([0.5, 1.0, 2.0, 4.0]):
            values = [sign * size for sign, size in zip(signs, order, strict=True)]
            assert library.largest((ctypes.c_double * 4)(*values)) == 4.0


@pytest.mark.parametrize("c", [(2.0, -1.0, 0.0, 1.0), (0.0, 0.5, 0.02, -3.0), (1.0, 0.0, 0.0, -0.25)])
def test_cubic_term_of_the_values_of_a_cubic(library, c):
    """It is the coefficient of the cubic itself, also where both ends agree."""
    values = np.polynomial.Polynomial(c)(lobatto()["node"])
    assert library.cubic_term((ctypes.c_double * 4)(*values)) == pytest.approx(abs(c[3]), rel=1e-12)


def test_cubic_and_what_a_parabola_misses():
    table = lobatto()
    c = table["node"]
    x = np.linspace(0, 1, 10001)
    cubic = np.random.default_rng(3).normal(size=4)
    coefficients = np.polyval(cubic, c) @ table["bernstein"]
    basis = [math.comb(3, i) * x**i * (1 - x) ** (3 - i) for i in range(4)]
    np.testing.assert_allclose(coefficients @ basis, np.polyval(cubic, x), atol=1e-14)
    parabola = np.polyfit(c[1:], c[1:] ** 3, 2)  # of the monomial c^3, whose coefficient is 1
    assert table["missed"] == pytest.approx(abs(parabola[-1]), rel=1e-13)
    shape = np.prod([1 - x / node for node in c[1:]], axis=0)
    sweep = cumulative_simpson(shape, x=x, initial=0)
    assert table["missed_once"] == pytest.approx(abs(sweep).max(), rel=1e-4)
    assert table["missed_twice"] == pytest.approx(abs(cumulative_simpson(sweep, x=x)).max(), rel=1e-4)


@pytest.mark.parametrize("stages", [3, 5, 7])
def test_polynomial_through_start_and_nodes(library, stages):
    r = library.radau_of(stages)
    c = np.array([0.0, *r.contents.node[:stages]])
    coefficients = np.random.default_rng(stages).normal(size=stages + 1)
    values = (ctypes.c_double * (MOST + 1))(*np.polyval(coefficients, c))
    p = library.radau_polynomial(r, values)
    for x in np.linspace(0, 1, 21):
        expected = np.polyval(coefficients, x)
        assert library.bernstein_value(ctypes.byref(p), x) == pytest.approx(expected, abs=1e-11)


def polynomial(roots, lead):
    """Bernstein form of lead times the product of (x - root)."""
    degree = len(roots)
    power = (lead * np.poly(roots))[::-1]
    c = [
        math.fsum(math.comb(i, k) / math.comb(degree, k) * power[k] for k in range(i + 1))
        for i in range(degree + 1)
    ]
    return Bernstein(degree, (ctypes.c_double * 9)(*c))


@given(
    st.lists(st.floats(-0.5, 1.5), min_size=1, max_size=7),
    st.sampled_from([-1.0, 1.0]),
)
def test_first_descent(library, roots, lead):
    """The first sign change from + to -, with every root well apart from the others and from 0 and 1."""
    marks = sorted([*roots, 0.0, 1.0])
    if min(b - a for a, b in pairwise(marks)) < 0.02:
        return
    p = polynomial(roots, lead)
    found = library.bernstein_descent(ctypes.byref(p))
    inside = sorted(r for r in roots if 0 < r < 1)
    above = [r for r in roots if r > 0]
    positive = lead * (-1) ** len(above) > 0  # at 0
    if not positive:
        rises = library.bernstein_value(ctypes.byref(p), 1e-9) > library.bernstein_value(ctypes.byref(p), 0.0)
        if not rises:
            assert found == 0
        return
    assert found == (pytest.approx(inside[0], abs=1e-9) if inside else math.inf)


def test_a_double_zero_is_not_stepped_over(library):
    """Two zeros a millionth apart, between any samples."""
    p = polynomial([0.37, 0.370001, 1.7], -1.0)
    assert library.bernstein_descent(ctypes.byref(p)) == pytest.approx(0.37, abs=1e-9)


def test_peak_and_monotone(library):
    p = polynomial([0.2, 0.8], 1.0)
    assert library.bernstein_peak(ctypes.byref(p)) in (0.0, 1.0)
    p = polynomial([-0.1, 1.1], 1.0)
    assert library.bernstein_peak(ctypes.byref(p)) == pytest.approx(0.5, abs=1e-9)
    assert not library.bernstein_is_monotone(ctypes.byref(p))
    rising = polynomial([-0.5], 1.0)
    assert library.bernstein_is_monotone(ctypes.byref(rising))
