#include "inverse/imposed_motion.h"

#include <math.h>

#include "numerics/tolerances.h"

enum { DEGREE = INPUT_ORDER + 2 }; /* of theta, where all derivatives of alpha are given */
_Static_assert((int)DEGREE <= (int)BERNSTEIN_MAX, "room for the motion");

/* The Bernstein coefficients at both ends are the given values, to the last digit. So a speed of zero at the end makes
 * no reversal just before the end. */
static void set_cubic(ImposedMotion *m, double theta0, double omega0, double theta1, double omega1) {
    const double distance = theta1 - theta0, start = omega0 * m->h, end = omega1 * m->h;
    m->theta = (Bernstein){3, {theta0, theta0 + start / 3.0, theta1 - end / 3.0, theta1}};
    m->dtheta_ds = (Bernstein){2, {start, 3.0 * distance - start - end, end}};
}

static double binomial(int n, int k) {
    double value = 1.0;
    for (int i = 1; i <= k; i++) value = value * (n - k + i) / i;
    return value;
}

/* The polynomial sum c_k s^k. A value at s = 1 that is zero to rounding becomes zero. */
static Bernstein of_powers(const double *c, int degree) {
    Bernstein p = {.degree = degree};
    double size = 0.0;
    for (int k = 0; k <= degree; k++) size += fabs(c[k]);
    for (int j = 0; j <= degree; j++)
        for (int k = 0; k <= j; k++) p.c[j] += binomial(j, k) / binomial(degree, k) * c[k];
    if (fabs(p.c[degree]) <= INPUT_ROUNDING * size) p.c[degree] = 0.0;
    return p;
}

/* derivative[k] is d^k theta/dt^k at the start of the step. */
static void set_polynomial(ImposedMotion *m, const double derivative[DEGREE + 1]) {
    double theta[DEGREE + 1], dtheta_ds[DEGREE], factor = 1.0;
    for (int k = 0; k <= DEGREE; k++) {
        theta[k] = derivative[k] * factor; /* factor = h^k/k! */
        if (k > 0) dtheta_ds[k - 1] = k * theta[k];
        factor *= m->h / (k + 1);
    }
    m->theta = of_powers(theta, DEGREE);
    m->dtheta_ds = of_powers(dtheta_ds, DEGREE - 1);
}

ImposedMotion imposed_motion_over(const InverseInputs *u, GivenInput given, double theta, double omega, double h) {
    ImposedMotion motion = {.h = h, .F_ext = bernstein_of_taylor(u->F_ext, h)};
    const double by_theta[DEGREE + 1] = {u->theta[0], u->theta[1], u->theta[2], u->theta[3]};
    const double by_omega[DEGREE + 1] = {u->theta[0], u->omega[0], u->omega[1], u->omega[2], u->omega[3]};
    const double by_alpha[DEGREE + 1] = {u->theta[0], u->omega[0], u->alpha[0], u->alpha[1], u->alpha[2], u->alpha[3]};
    switch (given) {
        case GIVEN_ENDS: set_cubic(&motion, theta, omega, u->theta[0], u->omega[0]); break;
        case GIVEN_THETA: set_polynomial(&motion, by_theta); break;
        case GIVEN_OMEGA: set_polynomial(&motion, by_omega); break;
        case GIVEN_ALPHA: set_polynomial(&motion, by_alpha); break;
    }
    motion.d2theta_ds2 = bernstein_derivative(&motion.dtheta_ds);
    return motion;
}

static double last(const Bernstein *p) {
    return p->c[p->degree];
}

/* Sets the derivatives of alpha at the end of the step to those of the imposed polynomial. */
static void shift_alpha(GivenInput given, double h, InverseInputs *u) {
    double by_theta[INPUT_ORDER + 1] = {u->theta[2], u->theta[3]};
    double by_omega[INPUT_ORDER + 1] = {u->omega[1], u->omega[2], u->omega[3]};
    double none[INPUT_ORDER + 1] = {0.0};
    double *const polynomial[] = {
        [GIVEN_ENDS] = none, [GIVEN_THETA] = by_theta, [GIVEN_OMEGA] = by_omega, [GIVEN_ALPHA] = u->alpha};
    double *alpha = polynomial[given];
    input_shift(alpha, h);
    for (int k = 1; k <= INPUT_ORDER; k++) u->alpha[k] = alpha[k];
}

void imposed_motion_finish(const ImposedMotion *motion, GivenInput given, InverseInputs *inputs) {
    const double h = motion->h;
    shift_alpha(given, h, inputs);
    input_shift(inputs->F_ext, h);
    inputs->F_ext[0] = last(&motion->F_ext);
    if (given != GIVEN_ENDS) {
        inputs->theta[0] = last(&motion->theta);
        inputs->omega[0] = last(&motion->dtheta_ds) / h;
        inputs->alpha[0] = last(&motion->d2theta_ds2) / h / h;
    }
    for (int k = 1; k <= INPUT_ORDER; k++) inputs->theta[k] = inputs->omega[k] = 0.0;
}
