"""The closed forms inside one mode (fmu_src/closed_form/oscillator.c) against 50-digit arithmetic."""

import ctypes

import mpmath
import numpy as np
import pytest

mpmath.mp.dps = 50


class Oscillator(ctypes.Structure):
    _fields_ = [
        (n, ctypes.c_double)
        for n in ("decay2", "stiffness", "separation", "frequency", "half_period", "rate", "horizon")
    ]


class Kernel(ctypes.Structure):
    _fields_ = [
        *((n, ctypes.c_double) for n in ("t", "s", "ds", "p1", "p2", "p3")),
        ("lead", ctypes.c_double),
        ("square", ctypes.c_double * 6),
        ("has_square", ctypes.c_bool),
    ]


@pytest.fixture(scope="module")
def library(core):
    c = core(["closed_form/oscillator"], [Oscillator, Kernel])
    c.oscillator_of.restype = Oscillator
    c.oscillator_of.argtypes = [ctypes.c_double, ctypes.c_double]
    c.oscillator_zero.restype = ctypes.c_double
    c.oscillator_zero.argtypes = [ctypes.POINTER(Oscillator), ctypes.c_double, ctypes.c_double]
    c.oscillator_offset_zero.restype = ctypes.c_double
    c.oscillator_offset_zero.argtypes = [ctypes.POINTER(Oscillator), *[ctypes.c_double] * 3]
    c.oscillator_kernel.argtypes = [ctypes.POINTER(Oscillator), ctypes.c_double, ctypes.POINTER(Kernel)]
    return c


def kernel_of(library, decay2, stiffness, t):
    osc, kernel = library.oscillator_of(decay2, stiffness), Kernel()
    library.oscillator_kernel(osc, t, kernel)
    return osc, kernel


def roots(decay2, stiffness):
    a = mpmath.mpf(decay2) / 2
    d = mpmath.sqrt(a * a - mpmath.mpf(stiffness))
    if d == 0:
        d = mpmath.mpf(10) ** -22  # the double root as the limit of two: error of the order d^2
    return -a + d, -a - d


def phi(k, x):
    if abs(x) < 2:
        return sum(x**n / mpmath.factorial(n + k) for n in range(60))
    value = mpmath.exp(x)
    for j in range(k):
        value = (value - 1 / mpmath.factorial(j)) / x
    return value


def exact(decay2, stiffness, t):
    """s, s', p1, p2, p3: divided differences of the exponential over the two roots and k zeros."""
    one, two = roots(decay2, stiffness)
    t = mpmath.mpf(t)
    e1, e2 = mpmath.exp(one * t), mpmath.exp(two * t)
    values = [(e1 - e2) / (one - two), (one * e1 - two * e2) / (one - two)]
    values += [t**k * (phi(k, one * t) - phi(k, two * t)) / (one - two) for k in (1, 2, 3)]
    return [mpmath.re(v) for v in values]


def random_rates(rng, kind, t):
    x = 10 ** rng.uniform(-3, 2)
    if kind == "undamped":
        return 0.0, (x / t) ** 2
    if kind == "unsprung":
        return x / t, 0.0
    if kind == "nearly critical":
        return x / t, (rng.uniform(0.49, 0.51) * x / t) ** 2
    if kind == "exactly critical":
        return x / t, (0.5 * x / t) ** 2
    if kind == "stiff":
        return x / t, (x / t) ** 2 * 10 ** rng.uniform(-12, 0)
    if kind == "hyperbolic":
        return rng.uniform(-1, 1) * min(x, 10) / t, -((min(x, 20) / t) ** 2)
    return x / t * 10 ** rng.uniform(-3, 1), (x / t) ** 2


KINDS = ["undamped", "unsprung", "nearly critical", "exactly critical", "stiff", "hyperbolic", "any"]


@pytest.mark.parametrize("kind", KINDS)
def test_kernel(library, kind):
    rng = np.random.default_rng(KINDS.index(kind))
    for _ in range(60):
        t = 10 ** rng.uniform(-6, 1)
        decay2, stiffness = random_rates(rng, kind, t)
        _, k = kernel_of(library, decay2, stiffness, t)
        got = [k.s, k.ds, k.p1, k.p2, k.p3]
        # s and s' pass through zero and decay; their error counts against t and 1, which multiply them
        growth = max(1, *(abs(mpmath.exp(r * t)) for r in roots(decay2, stiffness)))
        reference = exact(decay2, stiffness, t)
        for value, r, size in zip(got[:2], reference[:2], [t * growth, growth], strict=True):
            assert abs(value - r) <= 2e-15 * size * (1 + mpmath.sqrt(abs(stiffness)) * t)
        for n, (value, r) in enumerate(zip(got[2:], reference[2:], strict=True), start=2):
            floor = (
                abs(r) if kind != "undamped" else max(abs(r), 1 / mpmath.mpf(stiffness) * t ** (n - 2) / 100)
            )
            assert abs(value - r) <= 1e-13 * floor


@pytest.mark.parametrize("kind", ["undamped", "unsprung", "nearly critical", "stiff", "any"])
def test_integral_of_square(library, kind):
    rng = np.random.default_rng(100 + KINDS.index(kind))
    for _ in range(2):
        decay2, stiffness = random_rates(rng, kind, 1.0)
        osc, k = kernel_of(library, decay2, stiffness, 1.0)
        library.oscillator_square(ctypes.byref(osc), ctypes.byref(k))
        omega, alpha, drive = rng.normal(size=3) * [1, 10, 30]

        one, two = roots(decay2, stiffness)

        def square(t, one=one, two=two, stiffness=stiffness, start=(omega, alpha, drive)):
            e1, e2 = mpmath.exp(one * t), mpmath.exp(two * t)
            s, c1, c2 = (e1 - e2) / (one - two), (e1 - 1) / one if one else t, (e2 - 1) / two
            p1 = (c1 - c2) / (one - two)
            return mpmath.re(start[0] * (1 - stiffness * p1) + start[1] * s + start[2] * p1) ** 2

        fast = abs(two)
        cuts = sorted({0, 1, *(10**-i for i in range(1, 4)), *np.linspace(0, 1, 3 + int(fast / 2)).tolist()})
        q, b = list(k.square), omega + k.lead * alpha
        got = q[0] * b**2 + 2 * q[1] * b * alpha + 2 * q[2] * b * drive
        got += q[3] * alpha**2 + 2 * q[4] * alpha * drive + q[5] * drive**2
        with mpmath.workdps(25):
            assert got == pytest.approx(float(mpmath.quad(square, cuts)), rel=1e-13)


def gram(decay2, stiffness, t, lead):
    """The quadratic form of oscillator_square, by integrals of exponentials."""
    one, two = roots(decay2, stiffness)
    w2 = mpmath.mpf(stiffness)
    c = (-two / (one - two), one / (one - two), 0)  # of exp(one t), exp(two t) and 1
    s = (1 / (one - two), -1 / (one - two), 0)
    p1 = (-c[0] / w2, -c[1] / w2, 1 / w2)
    of_alpha = tuple(x - mpmath.mpf(lead) * y for x, y in zip(s, c, strict=True))

    def integral(rate):
        return mpmath.expm1(rate * t) / rate if rate != 0 else mpmath.mpf(t)

    def product(u, v):
        rates = (one, two, 0)
        return mpmath.re(sum(u[i] * v[j] * integral(rates[i] + rates[j]) for i in range(3) for j in range(3)))

    forms = (c, of_alpha, p1)
    return [product(forms[i], forms[j]) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]


@pytest.mark.parametrize("ratio", [0.0, 1e-9, 1e-5, 2e-3, 0.03, 0.3, 0.99, 1.01, 1.9])
@pytest.mark.parametrize("angle", [3.0, 70.0, 5e4])
def test_integral_of_square_of_a_vibration(library, ratio, angle):
    """2a = ratio w over many turns of w t: what vibrates for long must not lose digits to what settles."""
    t, w = 0.7, angle / 0.7
    osc, k = kernel_of(library, ratio * w, w * w, t)
    library.oscillator_square(ctypes.byref(osc), ctypes.byref(k))
    form = gram(ratio * w, w * w, t, k.lead)
    size = [mpmath.sqrt(form[i]) for i in (0, 3, 5)]
    pairs = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    for got, wanted, (i, j) in zip(k.square, form, pairs, strict=True):
        assert abs(got - wanted) <= 1e-14 * size[i] * size[j]


@pytest.mark.parametrize("stiffness", [100.0, 0.0, -100.0])
def test_zero_of_an_undamped_offset(library, stiffness):
    """y = offset + y0 C + dy0 S vanishes at t* to rounding and not before; NAN or < 0: it does not vanish."""
    rng = np.random.default_rng(300)
    osc, w = library.oscillator_of(0.0, stiffness), 10.0
    seen = 0
    for offset, y0, dy0 in rng.normal(size=(200, 3)):
        if stiffness == 0.0:  # offset stands for y''/2
            at = lambda t, p=(y0, w * dy0, w * w * offset): p[0] + t * (p[1] + t * p[2])  # noqa: E731
            t = library.oscillator_offset_zero(osc, y0, w * dy0, 2 * w * w * offset)
        else:
            C, S = (np.cos, np.sin) if stiffness > 0 else (np.cosh, np.sinh)
            at = lambda t, p=(offset, y0, dy0), f=(C, S): p[0] + p[1] * f[0](w * t) + p[2] * f[1](w * t)  # noqa: E731
            t = library.oscillator_offset_zero(osc, offset + y0, w * dy0, -stiffness * y0)
        before = np.linspace(0.0, t if t > 0 else 1.0, 2000)[:-1]
        if t > 0:
            seen += 1
            growth = np.cosh(w * t) if stiffness <= 0 else 1.0
            assert abs(at(t)) <= 1e-13 * growth * (abs(offset) + abs(y0) + abs(dy0))
        assert len(set(np.sign(at(before)))) == 1
    assert seen > 60


@pytest.mark.parametrize("kind", KINDS)
def test_first_zero(library, kind):
    """y(t*) = 0 and y keeps its sign before."""
    rng = np.random.default_rng(200 + KINDS.index(kind))
    for _ in range(25):
        decay2, stiffness = random_rates(rng, kind, 1.0)
        osc = library.oscillator_of(decay2, stiffness)
        y0, dy0 = rng.normal(), rng.normal() * (abs(decay2) + np.sqrt(abs(stiffness)))
        t = library.oscillator_zero(osc, y0, dy0)
        one, two = roots(decay2, stiffness)
        a, b = (dy0 - two * y0) / (one - two), (one * y0 - dy0) / (one - two)

        def y(x, a=a, b=b, one=one, two=two):
            return mpmath.re(a * mpmath.exp(one * x) + b * mpmath.exp(two * x))

        if t == np.inf:
            span = 50 / abs(one) if one != 0 else 50
            assert all(y(span * x) * y0 > 0 for x in (0.001, 0.01, 0.1, 1))
        else:
            width = 1e-12 * t
            assert y(t - width) * y(t + width) < 0
            assert all(y(t * x) * y0 > 0 for x in (0.01, 0.2, 0.5, 0.8, 0.999))
