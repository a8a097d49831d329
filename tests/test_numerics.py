"""Methods of fmu_src/numerics/ that know no cam, against polynomials with given zeros and integrals in closed
form: sign changes, zeros, linear systems, quadrature."""

import math
from ctypes import CFUNCTYPE, POINTER, byref, c_bool, c_double, c_int, c_void_p

import numpy as np
import pytest
from driver import Structure

DEGREE, WIDTH = 8, 1e-15  # highest degree; to which a zero is found
UNKNOWNS, RATES, SIZES = 7, 8, 4


class Bernstein(Structure):
    """bernstein.h"""

    _fields_ = (("degree", c_int), ("c", c_double * (DEGREE + 1)))


class Lu(Structure):
    """lu.h"""

    _fields_ = (("n", c_int), ("a", (c_double * UNKNOWNS) * UNKNOWNS), ("pivot", c_int * UNKNOWNS))


class QuadratureSample(Structure):
    """quadrature.h"""

    _fields_ = (("rate", c_double * RATES), ("size", c_double * SIZES), ("branch", c_int))


FUNCTION = CFUNCTYPE(c_double, c_void_p, c_double)
INTEGRAND = CFUNCTYPE(None, c_void_p, c_double, POINTER(QuadratureSample))


class Quadrature(Structure):
    """quadrature.h"""

    _fields_ = (
        ("integrand", INTEGRAND),
        ("scene", c_void_p),
        ("tolerance", c_double),
        ("rounding", c_double),
        ("total", c_double * RATES),
        ("peak", c_double * SIZES),
        ("bad", c_double),
        ("panels", c_int),
    )


@pytest.fixture(scope="module")
def library(core):
    made = core(
        ["numerics/bernstein", "numerics/lu", "numerics/quadrature", "numerics/root"],
        [Bernstein, Lu, QuadratureSample, Quadrature],
    )
    made.bernstein_descent.restype = made.root_between.restype = c_double
    made.bernstein_derivative.restype = Bernstein
    made.root_between.argtypes = (FUNCTION, c_void_p, *[c_double] * 4)
    made.taylor_leaving_sign.argtypes = (POINTER(c_double), c_double)
    made.quadrature_over.argtypes = (POINTER(Quadrature), c_double, c_double)
    for name in ("lu_factorize", "quadrature_over"):
        getattr(made, name).restype = c_bool
    return made


# ---- sign changes ----


def product(roots, lead=1.0):
    """lead times the product of (x - root): the blossom of each factor, whose values at 0 and 1 are exact."""
    c = np.array([lead])
    for root in roots:
        n = len(c)
        k = np.arange(n + 1)
        c = (k * np.append(0.0, c) * (1.0 - root) - (n - k) * np.append(c, 0.0) * root) / n
    return Bernstein(len(roots), (c_double * (DEGREE + 1))(*c))


def crossings(library, p):
    x = (c_double * DEGREE)()
    return list(x[: library.bernstein_crossings(byref(p), x)])


@pytest.mark.parametrize("lead", [1.0, -1.0])
@pytest.mark.parametrize(
    "roots",
    [
        [],
        [0.3],
        [0.25, 0.5, 0.75],  # the middle one is an end of both halves
        [0.5, 0.5, 0.5],
        [0.0, 0.4, 1.0],  # zero at both ends, which are no sign changes
        [-0.2, 0.1, 0.2, 0.4, 0.6, 0.8, 0.9, 1.3],
        [0.1, 0.2, 0.3, 0.45, 0.6, 0.7, 0.8, 0.9],
        [0.25, 0.5, 0.5, 0.75],  # touches zero in the middle
        [0.375, 0.375, 0.8125],  # touches zero at 0.375
    ],
)
def test_sign_changes_are_the_zeros_inside(library, roots, lead):
    found = crossings(library, product(roots, lead))
    odd = [r for r in sorted(set(roots)) if 0.0 < r < 1.0 and roots.count(r) % 2]
    assert found == pytest.approx(odd, abs=1e-12)


@pytest.mark.parametrize(("count", "found"), [(2, 0), (3, 1)])
def test_zeros_closer_than_the_last_halving_count_by_their_parity(library, count, found):
    """The sign after them is what counts."""
    roots = [(1.2 + 0.1 * k) * 2.0**-50 for k in range(count)]
    assert crossings(library, product(roots)) == pytest.approx(roots[:found], abs=2.0**-48)


@pytest.mark.parametrize(
    ("roots", "lead", "first"),
    [
        ([1.5 * 2.0**-50, 1.7 * 2.0**-50], 1.0, math.inf),  # below zero in no interval of the last halving
        ([1.2 * 2.0**-50, 1.3 * 2.0**-50, 1.4 * 2.0**-50], -1.0, 2.0**-48),  # at the end of such an interval
        ([-1e-20, 0.4], -1.0, 0.4),  # positive from 0 on
        ([1e-20, 0.4], -1.0, 0.4),  # below zero at 0 by rounding, and rises
        ([0.0, 0.4], -1.0, 0.4),
        ([0.4], 1.0, 0.0),  # below zero at 0, and rises
    ],
)
def test_first_descent_beside_zeros_of_rounding(library, roots, lead, first):
    p = product(roots, lead)
    found = library.bernstein_descent(byref(p))
    if lead > 0.0 and len(roots) == 1:
        assert found == math.inf  # it is zero at 0 to rounding, then rises
    else:
        assert found == pytest.approx(first, abs=2.0**-48) or found == first


def test_a_constant_below_zero_falls_at_0(library):
    assert library.bernstein_descent(byref(product([], -1.0))) == 0.0
    assert library.bernstein_descent(byref(product([], 1.0))) == math.inf
    assert library.bernstein_descent(byref(product([], 0.0))) == math.inf
    flat = library.bernstein_derivative(byref(product([], 3.0)))
    assert (flat.degree, flat.c[0]) == (0, 0.0)


def test_a_polynomial_of_no_numbers_has_no_sign_changes(library):
    """A search among NaN would halve for ever."""
    p = Bernstein(2, (c_double * (DEGREE + 1))(1.0, math.nan, -1.0))
    assert crossings(library, p) == []
    assert library.bernstein_descent(byref(p)) == math.inf


@pytest.mark.parametrize(
    ("turns", "width", "sign"),
    [
        ([1.0, 3.0], 0.1, 1),
        ([1.0, 3.0], 5.0, 1),
        ([1.0, 3.0], 1.0, 1),
        ([3.0], 3.0, -1),
        ([-1.0, 3.0], 3.5, -1),
        ([-1.0, 3.0], 2.5, 1),
        ([], 1.0, 1),
    ],
)
def test_sign_with_which_a_polynomial_leaves_a_strip(library, turns, width, sign):
    """u(0) = 0, u'(t) the product of (1 - t/turn): u rises; only times after 0 are turns."""
    rate = np.poly1d([1.0])
    for turn in turns:
        rate *= np.poly1d([-1.0 / turn, 1.0])
    u = rate.integ()
    taylor = (c_double * 4)(*(u.deriv(k)(0.0) if k else 0.0 for k in range(4)))
    outside = next(v for v in u(np.linspace(0.0, 30.0, 300_001)) if abs(v) > width)
    assert np.sign(outside) == sign
    assert library.taylor_leaving_sign(taylor, width) == sign


# ---- one zero ----


@pytest.mark.parametrize(
    ("function", "a", "b", "zero"),
    [
        (lambda x: x**3 - 2.0, 0.0, 5.0, 2.0 ** (1 / 3)),
        (lambda x: math.expm1(50.0 * (x - 0.7)), 0.0, 1.0, 0.7),
        (lambda x: math.inf if x > 0.3 else x - 0.3 - 1e-9, 0.0, 1.0, 0.3),  # no zero, a change of sign
        (lambda x: x - 1.0, 1.0, 4.0, 1.0),  # zero at an end
        (lambda x: x - 4.0, 1.0, 4.0, 4.0),
        (lambda x: math.copysign(abs(x - 0.6) ** 0.01, x - 0.6), 0.0, 1.0, 0.6),  # as steep as a jump
    ],
)
def test_zero_between_two_points(library, function, a, b, zero):
    called = FUNCTION(lambda _, x: function(x))
    for first, last in ((a, b), (b, a)):
        found = library.root_between(called, None, first, function(first), last, function(last))
        assert found == pytest.approx(zero, rel=4e-16)


# ---- linear systems ----


def test_linear_systems_against_numpy(library):
    rng = np.random.default_rng(5)
    for n in range(1, UNKNOWNS + 1):
        matrix, right = rng.normal(size=(n, n)), rng.normal(size=n)
        lu = Lu(n)
        for i in range(n):
            lu.a[i][:n] = matrix[i]
        assert library.lu_factorize(byref(lu))
        x = (c_double * UNKNOWNS)(*right)
        library.lu_solve(byref(lu), x)
        np.testing.assert_allclose(x[:n], np.linalg.solve(matrix, right), rtol=1e-11)


def test_a_singular_matrix_is_refused(library):
    lu = Lu(2)
    for row in range(2):
        lu.a[row][:2] = [1.0, 2.0]
    assert not library.lu_factorize(byref(lu))


# ---- quadrature ----


def integrate(library, rate, start, end, branch=lambda x: 0, tolerance=1e-9, panels=0):
    """Integrates `rate` as the first account; its magnitude is the first one whose peak is wanted."""

    def at(_, x, out):
        out[0] = QuadratureSample((c_double * RATES)(rate(x)), (c_double * SIZES)(abs(rate(x))), branch(x))

    q = Quadrature(INTEGRAND(at), None, tolerance, panels=panels)
    return library.quadrature_over(byref(q), start, end), q


@pytest.mark.parametrize(("start", "end"), [(0.0, 2.0), (2.0, 0.0)])
def test_integral_and_peak(library, start, end):
    good, q = integrate(library, lambda x: x * (2.0 - x) ** 3, start, end)
    assert good
    assert q.total[0] == pytest.approx(math.copysign(1.6, end - start), rel=1e-14)
    assert q.peak[0] == pytest.approx(27.0 / 16.0, rel=1e-14)  # at x = 1/2
    assert not any((*q.total[1:], *q.peak[1:]))


def test_an_integral_is_divided_where_another_formula_takes_over(library):
    """The second one differs by a jump of 1e6: without a division no rule would agree with another one."""
    kink = math.pi / 4
    good, q = integrate(
        library, lambda x: math.exp(x) + 1e6 * (x > kink), 0.0, 1.0, branch=lambda x: int(x > kink)
    )
    assert good
    assert q.total[0] == pytest.approx(math.expm1(1.0) + 1e6 * (1.0 - kink), rel=1e-14)
    assert q.panels <= 3


def test_a_point_without_a_formula_is_named(library):
    """Also where it shows only after the first division."""
    for kink in (0.5, 0.9999):
        good, q = integrate(
            library, lambda x: x, 0.0, 1.0, branch=lambda x, kink=kink: -1 if x >= kink else int(x > 0.25)
        )
        assert not good
        assert q.bad >= kink


def test_a_jump_that_no_formula_tells_ends_at_the_deepest_halving(library):
    """A step at 1/3, which no halving meets: the last interval is 2^-40 of the whole."""
    good, q = integrate(library, lambda x: float(x > 1.0 / 3.0), 0.0, 1.0, tolerance=1e-14)
    assert good
    assert q.total[0] == pytest.approx(2.0 / 3.0, abs=2.0**-39)


def test_an_integrand_that_is_noise_costs_no_more_than_its_panels(library):
    """Of 20,000 panels 100 are left. Once they are spent, no interval is halved any more."""
    good, q = integrate(library, lambda x: math.sin(1e9 * x), 0.0, 1.0, tolerance=1e-14, panels=19_900)
    assert good
    assert 20_000 <= q.panels <= 20_000 + 41
    assert abs(q.total[0]) <= 1.0
