"""Rates of the balance of forces (contact/balance.h) against differences of the balance itself.

Event location, the choice of a mode and the derivatives of a step rest on these rates. An error in a rate
hardly shows in a trajectory.
"""

import ctypes

import numpy as np
import pytest

CODE = """
typedef struct {
    Params p;
    Transmission transmission;
    Inputs inputs;
    SlipMode slip;
} Case;

enum { CAM_SIZE = 10, SPRING = 20, DAMPER = 24, INERTIA = 26, B = 29, STATE = 30, INPUTS = 32, MODE = 38 };

static CamParams cam_of(const double *v) {
    const FrictionParams law = {.peak = v[5], .stribeck_velocity = v[6], .stribeck_exponent = 2,
                                .viscous = v[7], .load_exponent = v[8], .load = v[9]};
    return (CamParams){.radius = v[0], .lead_angle = v[1], .ellipse_a = v[2], .ellipse_b = v[3],
                       .profile = 2, .ellipse_curvature = -1, .friction = v[4], .law = law};
}

static bool build(const double *v, Case *c) {
    *c = (Case){.p = {.contacts = 1, .tolerance = 1e-9, .stop = {.upper = 0.6}}};
    for (int i = 0; i < 2; i++) c->p.cam[i] = cam_of(&v[CAM_SIZE * i]);
    c->p.spring = (SpringParams){v[SPRING], v[SPRING + 1], v[SPRING + 2], v[SPRING + 3]};
    c->p.damper = (DamperParams){v[DAMPER], v[DAMPER + 1], v[DAMPER], v[DAMPER + 1]};
    c->p.inertia = (InertiaParams){v[INERTIA], v[INERTIA + 1], v[INERTIA + 2]};
    c->p.shaft.damping = v[B];
    for (int k = 0; k < 3; k++) {
        c->inputs.tau[k] = v[INPUTS + k];
        c->inputs.F_ext[k] = v[INPUTS + 3 + k];
    }
    Fault fault;
    if (!transmission_build(&c->transmission, &c->p, "", &fault)) return false;
    const int flank[2] = {(int)v[MODE], (int)v[MODE + 1]}, direction = v[STATE + 1] > 0.0 ? 1 : -1;
    c->slip = slip_mode_of(&c->p, &c->transmission, NULL, &c->inputs, v[STATE], direction, flank);
    return true;
}

/* alpha, or without inertia omega; x_1; x_2. */
bool rates(const double *v, double value[3], double rate[3]) {
    Case c;
    if (!build(v, &c)) return false;
    Balance b;
    BalanceRates r;
    balance_at(&c.slip, v[STATE], v[STATE + 1], 0.0, &b);
    balance_rates(&c.slip, &b, 0.0, &r);
    const double values[3] = {b.rhs.value, b.x[0], b.x[1]}, found[3] = {r.rhs, r.contact[0], r.contact[1]};
    memcpy(value, values, sizeof values);
    memcpy(rate, found, sizeof found);
    transmission_free(&c.transmission);
    return b.rhs.possible;
}

/* The same values at time t, by steps of the classical Runge-Kutta method. */
void later(const double *v, double t, double value[3]) {
    enum { STEPS = 4 };
    Case c;
    build(v, &c);
    const bool inertial = c.slip.regime == REGIME_INERTIAL;
    double theta = v[STATE], omega = v[STATE + 1];
    const double h = t / (double)STEPS;
    for (int n = 0; n < STEPS; n++) {
        double dtheta[4] = {0.0}, domega[4] = {0.0};
        for (int k = 0; k < 4; k++) {
            const double part = k == 0 ? 0.0 : k == 3 ? h : 0.5 * h;
            const double angle = k == 0 ? theta : theta + part * dtheta[k - 1];
            const double speed = k == 0 ? omega : omega + part * domega[k - 1];
            const double rhs = balance_rhs(&c.slip, angle, speed, n * h + part).value;
            dtheta[k] = inertial ? speed : rhs;
            domega[k] = inertial ? rhs : 0.0;
        }
        theta += h / 6.0 * (dtheta[0] + 2.0 * dtheta[1] + 2.0 * dtheta[2] + dtheta[3]);
        omega += h / 6.0 * (domega[0] + 2.0 * domega[1] + 2.0 * domega[2] + domega[3]);
    }
    Balance b;
    balance_at(&c.slip, theta, omega, t, &b);
    const double values[3] = {b.rhs.value, b.x[0], b.x[1]};
    memcpy(value, values, sizeof values);
    transmission_free(&c.transmission);
}

/* x_1, x_2 and alpha where theta, omega, tau and the axial force are moved. */
void contacts(const double *v, const double by[4], double found[3]) {
    double moved[MODE + 2];
    memcpy(moved, v, sizeof moved);
    moved[STATE] += by[0];
    moved[STATE + 1] += by[1];
    moved[INPUTS] += by[2];
    moved[INPUTS + 3] += by[3];
    Case c;
    build(moved, &c);
    Balance b;
    balance_at(&c.slip, moved[STATE], moved[STATE + 1], 0.0, &b);
    const double values[3] = {b.x[0], b.x[1], b.alpha};
    memcpy(found, values, sizeof values);
    transmission_free(&c.transmission);
}

void changes(const double *v, int known, double change[2]) {
    Case c;
    build(v, &c);
    Balance b;
    balance_at(&c.slip, v[STATE], v[STATE + 1], 0.0, &b);
    const BalanceChange by = {
        .theta = known == 0, .omega = known == 1, .alpha = known == 2, .axial = known == 3};
    balance_contact_changes(&c.slip, &b, &by, change);
    transmission_free(&c.transmission);
}
"""
LAWS = {
    "Coulomb": [1.0, 0.1, 0.0, 0.0, 100.0],
    "Stribeck": [1.6, 0.2, 0.05, 0.0, 100.0],
    "of the load": [1.0, 0.1, 0.0, -0.2, 100.0],
    "of both": [1.6, 0.2, 0.05, -0.2, 100.0],
}
KNOWNS = {"theta": 1e-5, "omega": 1e-4, "alpha": 1e-2, "axial": 1e-2}  # and the change for a difference


@pytest.fixture(scope="module")
def library(core):
    made = core(["geometry/transmission_build", "contact/balance"], [], "#include <string.h>\n" + CODE)
    made.rates.restype = ctypes.c_bool
    return made


def array(values):
    return (ctypes.c_double * len(values))(*values)


def drawn(rng, law, inertial):
    """Numbers of a slip: see the enum of CODE."""
    cams = [
        [rng.uniform(0.01, 0.03), rng.uniform(0.5, 0.9), 0.06, 0.05, rng.uniform(0.03, 0.15), *LAWS[law]]
        for _ in range(2)
    ]
    spring = [rng.uniform(50.0, 100.0), rng.uniform(1e3, 2e4), 1e5, 1e6]
    masses = [10 ** rng.uniform(-3, -2), rng.uniform(0.1, 1.0), 10 ** rng.uniform(-5, -4)]
    inertia = masses if inertial else [0.0, 0.0, 0.0]
    state = [rng.uniform(0.1, 0.5), rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 5.0)]
    inputs = [
        state[1] * rng.uniform(0.5, 1.5),
        *rng.normal(0, 20, 2),
        *rng.uniform(0, 50, 1),
        *rng.normal(0, 300, 2),
    ]
    flanks = rng.choice([-1.0, 1.0], 2) if rng.uniform() < 0.3 else [1.0, 1.0]
    return array([*cams[0], *cams[1], *spring, 30.0, 20.0, *inertia, 0.01, *state, *inputs, *flanks])


def cases(library, law, inertial, wanted=12):
    rng, made = np.random.default_rng(5), []
    while len(made) < wanted:
        values, value, rate = drawn(rng, law, inertial), array([0.0] * 3), array([0.0] * 3)
        possible = library.rates(values, value, rate) and np.isfinite([*value, *rate]).all()
        if possible and (inertial or value[0] * values[31] > 0.0):
            made.append((values, np.array(value), np.array(rate)))
    return made


@pytest.mark.parametrize("law, inertial", [*((law, True) for law in LAWS), ("Coulomb", False)])
def test_rates_along_the_motion(library, law, inertial):
    for number, (values, value, rate) in enumerate(cases(library, law, inertial)):
        nodes, h = np.array([-2, -1, 1, 2]), 2e-5
        found = []
        for node in nodes:
            at = array([0.0] * 3)
            library.later(values, ctypes.c_double(node * h), at)
            found.append(list(at))
        expected = np.array([1, -8, 8, -1]) @ np.array(found) / (12 * h)
        assert (np.abs(rate - expected) <= 1e-6 * np.abs(expected) + 1e-5 * np.abs(value)).all(), number


def slopes(library, values, k, h):
    """Derivatives of x_1, x_2 and alpha by theta, omega, tau or the axial force."""
    sums = np.zeros(3)
    for node, weight in ((-2, 1), (-1, -8), (1, 8), (2, -1)):
        by, found = [0.0] * 4, array([0.0] * 3)
        by[k] = node * h
        library.contacts(values, array(by), found)
        sums += weight * np.array(list(found)) / (12 * h)
    return sums


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("known", KNOWNS)
def test_changes_of_the_contact_loads(library, law, known):
    """At a given acceleration. The torque reaches the contacts by the acceleration alone."""
    k, h = list(KNOWNS).index(known), KNOWNS[known]
    for number, (values, _, _) in enumerate(cases(library, law, True)):
        by_tau = slopes(library, values, 2, 1e-2)
        by_alpha = by_tau[:2] / by_tau[2]
        moved = slopes(library, values, k, h)
        expected = by_alpha if known == "alpha" else moved[:2] - by_alpha * moved[2]
        change = array([0.0] * 2)
        library.changes(values, k, change)
        assert list(change) == pytest.approx(list(expected), rel=1e-6), number
