/* Explicit Runge-Kutta methods: DP5(4) and DOP853. Their stages are in integrator_tables.h. */
#ifndef EXPLICIT_H
#define EXPLICIT_H

#include "step_control.h"
#include "integrator_tables.h" /* uses step_control.h */

/* One step: the new state and, relative to the scales, its error. `alpha` is that at the start, `last`
 * gets that at the end, or NAN if the method does not have it. */
typedef double Explicit(const Scene *m, const State *y, double h, double alpha, State *next, double *last);

static double dp5_step(const Scene *m, const State *y, double h, double alpha, State *next, double *last) {
    double w[7], f[7], error[2] = {0.0, 0.0};
    f[0] = alpha;
    dp5_stages(m, y, h, w, f);
    const double end[2] = {y->theta + h * dp5_weigh(w), y->omega + h * dp5_weigh(f)};
    w[6] = end[1];
    f[6] = acceleration(m, y->t + h, end[0], end[1]);
    for (int i = 0; i < 7; i++) {
        error[0] += DP5_ERROR[i] * w[i];
        error[1] += DP5_ERROR[i] * f[i];
    }
    *next = (State){y->t + h, end[0], end[1]};
    *last = f[6];
    return size(m, h * error[0], h * error[1]);
}

static double dop853_step(const Scene *m, const State *y, double h, double alpha, State *next,
                          double *last) {
    double w[12], f[12], e3[2] = {0.0, 0.0}, e5[2] = {0.0, 0.0};
    f[0] = alpha;
    dop853_stages(m, y, h, w, f);
    *next = (State){y->t + h, y->theta + h * dop853_weigh(w), y->omega + h * dop853_weigh(f)};
    for (int i = 0; i < 12; i++) {
        e3[0] += DOP853_ERROR3[i] * w[i];
        e3[1] += DOP853_ERROR3[i] * f[i];
        e5[0] += DOP853_ERROR5[i] * w[i];
        e5[1] += DOP853_ERROR5[i] * f[i];
    }
    const double third = size(m, e3[0], e3[1]), fifth = size(m, e5[0], e5[1]);
    *last = NAN;
    if (!isfinite(third) || !isfinite(fifth)) return INFINITY;
    return fifth == 0.0 ? 0.0 : h * fifth * (fifth / hypot(fifth, 0.1 * third));
}

/* Runs over one communication step. */
INLINE bool explicit_run(const Scene *m, State *y, double end, double *h, double tolerance, Explicit *step,
                         double order, int stages, Outcome *o, long limit) {
    double alpha = acceleration(m, y->t, y->theta, y->omega);
    o->values++;
    if (*h <= 0.0) *h = first_step(m, y, alpha, tolerance, order, o);
    double cap = 8.0;
    while (y->t < end) {
        const bool final = *h >= (end - y->t) * (1.0 - 1e-12);
        const double used = final ? end - y->t : *h;
        State next;
        double last;
        const double error = step(m, y, used, alpha, &next, &last) / tolerance;
        o->values += stages - 1;
        const double scale = fmin(cap, factor(error, order));
        if (error <= 1.0) {
            accept(y, &next, final ? end : next.t, o);
            cap = 8.0;
            if (isnan(last) && !final) {
                last = acceleration(m, y->t, y->theta, y->omega);
                o->values++;
            }
            alpha = last;
            if (!final || scale < 1.0) *h = used * scale;
        } else {
            o->rejected++;
            cap = 1.0;
            *h = used * scale;
        }
        if (o->steps + o->rejected > limit || *h < 1e-18) return false;
    }
    return true;
}

#endif
