/* The loads from outside during a step: polynomials of the time since the inputs were written. */
#ifndef DUALCAM_INPUTS_H
#define DUALCAM_INPUTS_H

#include <math.h>
#include <stdbool.h>

enum { INPUT_ORDER = 3 }; /* highest time derivative of an input that a step can carry */

/* value[k] is the k-th time derivative at the start of the step: u(t) = sum value[k] t^k / k! */
typedef struct {
    double tau[INPUT_ORDER + 1];   /* N.m, applied to cam 2, + loads */
    double F_ext[INPUT_ORDER + 1]; /* N, on the follower, + opposes loading */
} Inputs;

/* u(t) */
static inline double input_value(const double u[INPUT_ORDER + 1], double t) {
    return u[0] + t * (u[1] + t / 2.0 * (u[2] + t / 3.0 * u[3]));
}

/* du/dt(t) */
static inline double input_rate(const double u[INPUT_ORDER + 1], double t) {
    return u[1] + t * (u[2] + t / 2.0 * u[3]);
}

/* Rewrites u for an origin of time t later. */
static inline void input_shift(double u[INPUT_ORDER + 1], double t) {
    u[0] += t * (u[1] + t / 2.0 * (u[2] + t / 3.0 * u[3]));
    u[1] += t * (u[2] + t / 2.0 * u[3]);
    u[2] += t * u[3];
}

/* Rewrites both inputs for an origin of time t later. */
static inline void inputs_advance(Inputs *inputs, double t) {
    input_shift(inputs->tau, t);
    input_shift(inputs->F_ext, t);
}

/* Are both inputs polynomials of at most this degree? */
static inline bool inputs_within(const Inputs *inputs, int degree) {
    for (int k = degree + 1; k <= INPUT_ORDER; k++)
        if (inputs->tau[k] != 0.0 || inputs->F_ext[k] != 0.0) return false;
    return true;
}

/* Does u stay finite for h seconds? The sizes of the terms bound u and all that input_shift() adds up. */
static inline bool input_stays_finite(const double u[INPUT_ORDER + 1], double h) {
    return isfinite(fabs(u[0]) + h * (fabs(u[1]) + h * (fabs(u[2]) + h * fabs(u[3]))));
}

/* One comparison takes fewer instructions than one for each derivative. */
static inline bool inputs_constant(const Inputs *inputs) {
    double size = 0.0;
    for (int k = 1; k <= INPUT_ORDER; k++) size += fabs(inputs->tau[k]) + fabs(inputs->F_ext[k]);
    return size == 0.0;
}

/* Is F_ext constant? */
static inline bool inputs_load_constant(const Inputs *inputs) {
    for (int k = 1; k <= INPUT_ORDER; k++)
        if (inputs->F_ext[k] != 0.0) return false;
    return true;
}

#endif
