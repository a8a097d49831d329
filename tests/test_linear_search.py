"""The search for events and peaks of slip in closed form (closed_form/linear_search.c).

Oracles: derivatives by differences, and thousands of samples of the motion, none of which the search knows.
"""

import ctypes
import math

import numpy as np
import pytest

CONTACTS, SPEED, EDGE, STOP = (0, 1), 2, 3, 5
COUNT = 4_000  # samples
CODE = """
typedef struct {
    Params p;
    Geometry g;
    LinearSlipMode mode;
    LinearSegment segment;
    Work work;
    Kernel kernel;
} Case;

enum { R = 0, A = 2, MU = 4, DIRECTION = 6, FLANK, SPRING = 9, C = 11, B, J, M, I };
enum { THETA = 16, OMEGA, TAU, F = 20 };

static bool build(const double *v, Case *c) {
    *c = (Case){.p = {.contacts = 1}, .work = {.most = 1 << 30}};
    CamParams cam[2] = {{.radius = v[R], .friction = v[MU]}, {.radius = v[R + 1], .friction = v[MU + 1]}};
    c->p.cam[0] = cam[0];
    c->p.cam[1] = cam[1];
    c->p.spring = (SpringParams){.preload = v[SPRING], .stiffness = v[SPRING + 1]};
    c->p.damper = (DamperParams){.c_load = v[C], .c_release = v[C]};
    c->p.shaft.damping = v[B];
    c->p.inertia = (InertiaParams){.shaft = v[J], .follower_mass = v[M], .follower = v[I]};
    c->g = cam_geometry(cam, &v[A]);
    c->g.friction[0] = v[MU];
    c->g.friction[1] = v[MU + 1];
    const int flank[2] = {(int)v[FLANK], (int)v[FLANK + 1]};
    linear_slip_build(&c->mode, &c->p, &c->g, (int)v[DIRECTION], flank);
    const Inputs inputs = {.tau = {v[TAU], v[TAU + 1]}, .F_ext = {v[F], v[F + 1]}};
    c->segment = (LinearSegment){.linear = &c->mode, .params = &c->p, .geometry = &c->g, .work = &c->work,
                                 .to_stop = 1.0, .flanks = true, .edge = {0.01, 0.02}};
    if (!c->mode.possible) return false;
    c->segment.start = linear_slip_start(&c->mode, &c->p, &c->g, v[THETA], v[OMEGA], &inputs);
    return true;
}

double half_period(const double *v) {
    Case c;
    return build(v, &c) ? c.mode.oscillator.half_period : NAN;
}

void samples(const double *v, int quantity, double sign, double end, int count, IndicatorSample *out) {
    Case c;
    build(v, &c);
    const LinearIndicator indicator = {&c.segment, (LinearQuantity)quantity, sign, &c.kernel};
    out[0] = linear_indicator_at_start(&indicator);
    for (int k = 1; k <= count; k++) out[k] = linear_indicator_at(&indicator, end * k / count);
}

double found(const double *v, int quantity, double sign, double end, bool peak) {
    Case c;
    build(v, &c);
    const LinearIndicator indicator = {&c.segment, (LinearQuantity)quantity, sign, &c.kernel};
    return peak ? linear_search_peak(&indicator, end, 0.0) : linear_search_crossing(&indicator, end);
}
"""


class IndicatorSample(ctypes.Structure):
    _fields_ = [(name, ctypes.c_double) for name in ("t", "value", "rate", "second", "third", "rounding")]


@pytest.fixture(scope="module")
def library(core):
    c = core(["closed_form/linear_search"], [IndicatorSample], CODE)
    c.half_period.restype = c.found.restype = ctypes.c_double
    return c


class Motion:
    """A slip of helices under inputs linear in time."""

    def __init__(self, library, values):
        self.library, self.values = library, (ctypes.c_double * len(values))(*values)
        self.half_period = library.half_period(self.values)

    def samples(self, quantity, sign, end, count=COUNT):
        """Times, values and derivatives, one row each."""
        made = (IndicatorSample * (count + 1))()
        self.library.samples(self.values, quantity, ctypes.c_double(sign), ctypes.c_double(end), count, made)
        return np.frombuffer(made, dtype=float).reshape(-1, 6).T

    def found(self, quantity, sign, end, peak):
        arguments = ctypes.c_double(sign), ctypes.c_double(end), peak
        return self.library.found(self.values, quantity, *arguments)


@pytest.fixture(scope="module")
def motions(library):
    """Vibrations with and without damping, with and without rates of the inputs."""
    rng, made = np.random.default_rng(12), []
    while len(made) < 100:
        geometry = [*rng.uniform(0.01, 0.05, 2), *rng.uniform(0.005, 0.05, 2), *rng.uniform(0.0, 0.2, 2)]
        mode = [*rng.choice([-1.0, 1.0], 3), rng.uniform(-50.0, 100.0), 10 ** rng.uniform(3, 5)]
        damping = rng.choice([0.0, 1.0]) * np.array([10 ** rng.uniform(-1, 1.5), 10 ** rng.uniform(-5, -3)])
        inertia = [10 ** rng.uniform(-4, -2), rng.uniform(0.0, 1.0), 10 ** rng.uniform(-6, -4)]
        start = [rng.uniform(0.0, 1.0), rng.uniform(-30.0, 30.0)]
        rates = rng.choice([0.0, 1.0]) * rng.normal(0.0, 1.0, 2)
        loads = [rng.normal(0, 3), 20.0 * rates[0], rng.normal(0, 50), 300.0 * rates[1]]
        motion = Motion(library, [*geometry, *mode, *damping, *inertia, *start, *loads])
        if math.isfinite(motion.half_period):
            made.append(motion)
    return made


@pytest.mark.parametrize("quantity", [*CONTACTS, SPEED, EDGE, STOP])
def test_rates_of_an_indicator_are_its_derivatives(motions, quantity):
    for number, motion in enumerate(motions):
        end = 2.0 * motion.half_period
        rows = motion.samples(quantity, 1.0, end)
        h = end / COUNT
        for order in range(1, 4):
            differences = (rows[order][2:] - rows[order][:-2]) / (2.0 * h)
            size = np.abs(rows[order]).max() / motion.half_period
            assert np.abs(differences - rows[order + 1][1:-1]).max() <= 1e-5 * size, (number, order)


def first_crossing(rows):
    """The interval of the first change from + to -; NaN where a minimum too close to zero leaves it open."""
    t, value = rows[0], rows[1]
    size = 1e-5 * np.abs(value).max()
    lows = (value[1:-1] < value[:-2]) & (value[1:-1] <= value[2:])
    close = np.flatnonzero(lows & (np.abs(value[1:-1]) < size)) + 1
    down = np.flatnonzero((value[:-1] > 0.0) & (value[1:] <= 0.0))
    if close.size and (down.size == 0 or close[0] <= down[0] + 1):
        return math.nan, math.nan
    return (t[down[0]], t[down[0] + 1]) if down.size else (math.inf, math.inf)


@pytest.mark.parametrize("quantity", [*CONTACTS, SPEED])
def test_the_first_crossing_is_found(motions, quantity):
    found = 0
    for number, motion in enumerate(motions):
        for sign in (1.0, -1.0):
            end = (3.3, 47.7)[number % 2] * motion.half_period
            rows = motion.samples(quantity, sign, end)
            before, after = first_crossing(rows)
            if math.isnan(before) or rows[1][0] < 1e-6 * np.abs(rows[1]).max():
                continue
            t = motion.found(quantity, sign, end, False)
            found += math.isfinite(before)
            assert (t > end) if before == math.inf else (before - 1e-9 * end <= t <= after + 1e-9 * end), (
                number
            )
    assert found > 50


@pytest.mark.parametrize("quantity", [*CONTACTS, SPEED])
def test_the_largest_value_is_found(motions, quantity):
    for number, motion in enumerate(motions):
        end = (3.3, 47.7)[number % 2] * motion.half_period
        values = np.abs(motion.samples(quantity, 1.0, end)[1])
        largest = max(motion.found(quantity, 1.0, end, True), values[0], values[-1])
        assert largest == pytest.approx(values.max(), rel=1e-3), number
