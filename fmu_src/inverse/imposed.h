/* The motion imposed over one step, and the axial force: polynomials in s = t/h, which runs from 0 to 1. */
#ifndef DUALCAM_IMPOSED_H
#define DUALCAM_IMPOSED_H

#include "model/params.h"
#include "numerics/bernstein.h"

/* value[k] is the k-th time derivative: where derivatives are given, at the start of the step. */
typedef struct {
    double theta[INPUT_ORDER + 1]; /* rad */
    double omega[INPUT_ORDER + 1]; /* rad/s */
    double alpha[INPUT_ORDER + 1]; /* rad/s^2 */
    double F_ext[INPUT_ORDER + 1]; /* N, on the follower, + opposes loading */
} InverseInputs;

/* Which input's derivatives say how theta goes on. */
typedef enum { GIVEN_ENDS, GIVEN_THETA, GIVEN_OMEGA, GIVEN_ALPHA } Given;

typedef struct {
    double h;             /* s */
    Bernstein theta;      /* rad */
    Bernstein turning;    /* rad, dtheta/ds */
    Bernstein quickening; /* rad, d2theta/ds2 */
    Bernstein F_ext;      /* N */
} Imposed;

/* GIVEN_ENDS: the cubic through angle and speed at the start and those that the inputs hold, which are reached at
 * the end. Else the inputs hold the values at the start, and the polynomial is that of theta, of omega, or of
 * alpha. F_ext is a polynomial from its value at the start in any case. */
Imposed imposed_motion(const InverseInputs *inputs, Given given, double theta, double omega, double h);

/* What the inputs are at the end of the step. With GIVEN_ENDS theta, omega and alpha are so already, and alpha's
 * derivatives become zero; else these are the polynomial's, as F_ext's always are. Those of theta and omega become
 * zero: the present omega and alpha stand for them. */
void imposed_finish(const Imposed *motion, Given given, InverseInputs *inputs);

static inline double imposed_theta(const Imposed *motion, double s) {
    return bernstein_value(&motion->theta, s);
}

static inline double imposed_omega(const Imposed *motion, double s) {
    return bernstein_value(&motion->turning, s) / motion->h;
}

static inline double imposed_alpha(const Imposed *motion, double s) {
    return bernstein_value(&motion->quickening, s) / motion->h / motion->h;
}

#endif
