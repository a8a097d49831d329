/* State, error norm and step control that all methods share. */
#ifndef STEP_CONTROL_H
#define STEP_CONTROL_H

#include "mechanism.h"

typedef struct {
    double t, theta, omega;
} State;

/* Relative to the scales of the scene. */
INLINE double size(const Scene *m, double theta, double omega) {
    return fmax(fabs(theta) / m->theta_scale, fabs(omega) / m->omega_scale);
}

/* Factor for the next step from error / tolerance and the order of the error. */
INLINE double factor(double error, double order) {
    if (!(error < 1e30)) return 0.1;
    return fmin(8.0, fmax(0.15, 0.9 * pow(error + 1e-30, -1.0 / order)));
}

/* A first step that makes the second-order term 0.01 of the scale, as Hairer and Wanner do it; costs one
 * evaluation. A communication step is tried whole. */
static double first_step(const Scene *m, const State *y, double alpha, double tolerance, double order,
                         Outcome *o) {
    if (m->parts > 1) return m->span / m->parts;
    const double slow = size(m, y->omega, alpha);
    const double h0 = slow > 0.0 ? fmin(m->span, 0.01 / slow) : 1e-6 * m->span;
    const double there = acceleration(m, y->t + h0, y->theta + h0 * y->omega, y->omega + h0 * alpha);
    const double jerk = size(m, alpha, (there - alpha) / h0);
    o->values++;
    return fmin(m->span, fmin(100.0 * h0, pow(tolerance / fmax(slow, jerk * h0), 1.0 / order) * 0.5 + h0));
}

/* Goes on to the end of a step, which is at the time t. */
INLINE void accept(State *y, const State *next, double t, Outcome *o) {
    *y = *next;
    y->t = t;
    o->steps++;
}

#endif
