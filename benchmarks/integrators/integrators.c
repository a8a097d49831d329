/* Candidate integrators for theta'' = alpha(t, theta, omega), all on the same mechanism, and the loops that time them.
 * The methods are included as headers, so that the compiler sees all of them together. `tables.py` writes
 * integrator_tables.h, the coefficients to the last digit. No file of fmu_src is used.
 *
 * Every method takes a step from a state and keeps nothing else, so that it may start anew at every communication
 * point. Tolerances are local errors relative to the largest |theta - theta_0| and |omega| of the scene. */
#define _POSIX_C_SOURCE 199309L
#include "../harness/unit.h"
#include "collocation.h"
#include "explicit.h"
#include "rodas.h"
#include "taylor_series.h"

typedef struct {
    int kind;     /* 0 DP5, 1 DOP853, 2 Taylor, 3 RODAS, 4 Radau IIA, 5 Gauss */
    int stages;   /* collocation */
    Control control;
} Method;

static bool advance(const Scene *m, const Method *w, State *y, double end, double *h, double tolerance,
                    Outcome *o, long limit) {
    const Control *how = &w->control;
    switch (w->kind * 10 + w->stages) {
    case 0: return explicit_run(m, y, end, h, tolerance, dp5_step, 5.0, 7, o, limit);
    case 10: return explicit_run(m, y, end, h, tolerance, dop853_step, 8.0, 12, o, limit);
    case 20: return taylor_run(m, y, end, tolerance, o, limit);
    case 30: return rodas_run(m, y, end, h, tolerance, o, limit);
    case 42: return collocation_run(m, &RADAU2, 2, y, end, h, tolerance, how, o, limit);
    case 43: return collocation_run(m, &RADAU3, 3, y, end, h, tolerance, how, o, limit);
    case 45: return collocation_run(m, &RADAU5, 5, y, end, h, tolerance, how, o, limit);
    case 47: return collocation_run(m, &RADAU7, 7, y, end, h, tolerance, how, o, limit);
    case 53: return collocation_run(m, &GAUSS3, 3, y, end, h, tolerance, how, o, limit);
    case 55: return collocation_run(m, &GAUSS5, 5, y, end, h, tolerance, how, o, limit);
    default: return false;
    }
}

/* The whole scene. Nothing but the state survives a communication point. */
static __attribute__((noinline)) void integrate(const Scene *m, const Method *w, double tolerance,
                                                long limit, Outcome *o) {
    State y = {0.0, m->theta, m->omega};
    *o = (Outcome){0};
    for (int i = 0; i < m->parts; i++) {
        double h = 0.0;
        const double end = i + 1 == m->parts ? m->span : m->span * (i + 1) / m->parts;
        if (!advance(m, w, &y, end, &h, tolerance, o, limit)) {
            o->failed = -1;
            break;
        }
    }
    o->theta = y.theta;
    o->omega = y.omega;
}

/* Seconds of `repeats` runs of the scene. */
EXPORT double seconds_run(const Scene *m, const Method *w, double tolerance, long limit, int repeats,
                          Outcome *o) {
    const double start = now();
    for (int i = 0; i < repeats; i++) integrate(m, w, tolerance, limit, o);
    return now() - start;
}

/* Seconds of n evaluations of alpha, with its partial derivatives or without; the evaluations do not wait
 * for each other. */
EXPORT double seconds_evaluations(const Scene *m, bool with_partials, int n, double *sum) {
    double total = 0.0;
    const double start = now();
    for (int i = 0; i < n; i++) {
        const double theta = m->theta + 0.1 * i / n;
        total += with_partials ? partials(m, 0.0, theta, m->omega).by_theta
                               : acceleration(m, 0.0, theta, m->omega);
    }
    *sum = total;
    return now() - start;
}

/* Fits the transmission over [lower, upper] and finds the scales by running the scene once. */
EXPORT void prepare(Scene *m, double lower, double upper, const Method *w) {
    Scene probe;
    fit_transmission(m, lower, upper);
    m->theta_scale = m->omega_scale = 1.0;
    probe = *m;
    double theta = 0.0, omega = 0.0;
    for (int i = 1; i <= 64; i++) {
        Outcome o;
        probe.span = m->span * i / 64.0;
        probe.parts = 1;
        integrate(&probe, w, 1e-10, 1000000, &o);
        theta = fmax(theta, fabs(o.theta - m->theta));
        omega = fmax(omega, fabs(o.omega));
    }
    m->theta_scale = theta;
    m->omega_scale = fmax(omega, fabs(m->omega));
}

/* For the check that Python lays the structure out in the same way. */
EXPORT size_t scene_size(void) {
    return sizeof(Scene);
}
