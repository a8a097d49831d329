/* The motion that is imposed over one step, and the axial force: polynomials of s = t/h, where t is the time since the
 * start of the step, h is the length of the step, and s runs from 0 to 1. */
#ifndef DUALCAM_IMPOSED_MOTION_H
#define DUALCAM_IMPOSED_MOTION_H

#include "model/params.h"
#include "numerics/bernstein.h"

/* Element k is the k-th time derivative. Where derivatives are given, the values are those at the start of the step. */
typedef struct {
    double theta[INPUT_ORDER + 1]; /* rad */
    double omega[INPUT_ORDER + 1]; /* rad/s */
    double alpha[INPUT_ORDER + 1]; /* rad/s^2 */
    double F_ext[INPUT_ORDER + 1]; /* N, on the follower, + opposes loading */
} InverseInputs;

/* What determines theta over the step: the values at both ends, or the derivatives that are given for one input. */
typedef enum { GIVEN_ENDS, GIVEN_THETA, GIVEN_OMEGA, GIVEN_ALPHA } GivenInput;

typedef struct {
    double h;              /* s */
    Bernstein theta;       /* rad */
    Bernstein dtheta_ds;   /* rad */
    Bernstein d2theta_ds2; /* rad */
    Bernstein F_ext;       /* N */
} ImposedMotion;

/* The motion over a step of h seconds that starts at theta and omega.
 * GIVEN_ENDS: the cubic through theta and omega at the start and the inputs' theta and omega at the end.
 * Otherwise the inputs hold values at the start, and their polynomial is that of theta, of omega or of alpha.
 * F_ext is always a polynomial from its value at the start. */
ImposedMotion imposed_motion_over(const InverseInputs *inputs, GivenInput given, double theta, double omega, double h);

/* Sets the inputs to their values at the end of the step. With GIVEN_ENDS theta, omega and alpha are those values
 * already, and the derivatives of alpha become zero. Otherwise all values and derivatives are the polynomials'.
 * The derivatives of theta and omega become zero: the present omega and alpha stand for them. */
void imposed_motion_finish(const ImposedMotion *motion, GivenInput given, InverseInputs *inputs);

static inline double imposed_theta(const ImposedMotion *motion, double s) {
    return bernstein_value(&motion->theta, s);
}

static inline double imposed_omega(const ImposedMotion *motion, double s) {
    return bernstein_value(&motion->dtheta_ds, s) / motion->h;
}

static inline double imposed_alpha(const ImposedMotion *motion, double s) {
    return bernstein_value(&motion->d2theta_ds2, s) / motion->h / motion->h;
}

#endif
