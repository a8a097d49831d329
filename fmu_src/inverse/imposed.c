#include "inverse/imposed.h"

#include <float.h>
#include <math.h>

enum { DEGREE = INPUT_ORDER + 2 }; /* of theta, where alpha has all its derivatives */
_Static_assert(DEGREE <= BERNSTEIN_MAX, "room for the motion");

/* The ends of theta and of dtheta/ds are what they are given as, to the last digit: a speed that is zero at an end
 * is no reversal just before it. */
static void set_cubic(Imposed *m, double theta0, double omega0, double theta1, double omega1) {
    const double distance = theta1 - theta0, start = omega0 * m->h, end = omega1 * m->h;
    m->theta = (Bernstein){3, {theta0, theta0 + start / 3.0, theta1 - end / 3.0, theta1}};
    m->turning = (Bernstein){2, {start, 3.0 * distance - start - end, end}};
}

static double binomial(int n, int k) {
    double value = 1.0;
    for (int i = 1; i <= k; i++) value = value * (n - k + i) / i;
    return value;
}

/* sum c_k s^k. An end that is zero but for rounding is zero. */
static Bernstein of_powers(const double *c, int degree) {
    Bernstein p = {.degree = degree};
    double size = 0.0;
    for (int k = 0; k <= degree; k++) size += fabs(c[k]);
    for (int j = 0; j <= degree; j++)
        for (int k = 0; k <= j; k++) p.c[j] += binomial(j, k) / binomial(degree, k) * c[k];
    if (fabs(p.c[degree]) <= 8.0 * DBL_EPSILON * size) p.c[degree] = 0.0;
    return p;
}

/* derivative[k] is d^k theta/dt^k at the start. */
static void set_polynomial(Imposed *m, const double derivative[DEGREE + 1]) {
    double theta[DEGREE + 1], turning[DEGREE], factor = 1.0;
    for (int k = 0; k <= DEGREE; k++) {
        theta[k] = derivative[k] * factor; /* h^k/k! */
        if (k > 0) turning[k - 1] = k * theta[k];
        factor *= m->h / (k + 1);
    }
    m->theta = of_powers(theta, DEGREE);
    m->turning = of_powers(turning, DEGREE - 1);
}

Imposed imposed_motion(const InverseInputs *u, Given given, double theta, double omega, double h) {
    Imposed motion = {.h = h, .F_ext = bernstein_of_taylor(u->F_ext, h)};
    const double by_theta[DEGREE + 1] = {u->theta[0], u->theta[1], u->theta[2], u->theta[3]};
    const double by_omega[DEGREE + 1] = {u->theta[0], u->omega[0], u->omega[1], u->omega[2], u->omega[3]};
    const double by_alpha[DEGREE + 1] = {u->theta[0], u->omega[0], u->alpha[0], u->alpha[1], u->alpha[2], u->alpha[3]};
    switch (given) {
        case GIVEN_ENDS: set_cubic(&motion, theta, omega, u->theta[0], u->omega[0]); break;
        case GIVEN_THETA: set_polynomial(&motion, by_theta); break;
        case GIVEN_OMEGA: set_polynomial(&motion, by_omega); break;
        case GIVEN_ALPHA: set_polynomial(&motion, by_alpha); break;
    }
    motion.quickening = bernstein_derivative(&motion.turning);
    return motion;
}

static double last(const Bernstein *p) {
    return p->c[p->degree];
}

/* d^2 theta/dt^2 as the polynomial has it, which goes on beyond the step. */
static void quickening_after(Given given, double h, InverseInputs *u) {
    double by_theta[INPUT_ORDER + 1] = {u->theta[2], u->theta[3]};
    double by_omega[INPUT_ORDER + 1] = {u->omega[1], u->omega[2], u->omega[3]};
    double none[INPUT_ORDER + 1] = {0.0};
    double *const polynomial[] = {
        [GIVEN_ENDS] = none, [GIVEN_THETA] = by_theta, [GIVEN_OMEGA] = by_omega, [GIVEN_ALPHA] = u->alpha};
    double *alpha = polynomial[given];
    input_shift(alpha, h);
    for (int k = 1; k <= INPUT_ORDER; k++) u->alpha[k] = alpha[k];
}

void imposed_finish(const Imposed *motion, Given given, InverseInputs *inputs) {
    const double h = motion->h;
    quickening_after(given, h, inputs);
    input_shift(inputs->F_ext, h);
    inputs->F_ext[0] = last(&motion->F_ext);
    if (given != GIVEN_ENDS) {
        inputs->theta[0] = last(&motion->theta);
        inputs->omega[0] = last(&motion->turning) / h;
        inputs->alpha[0] = last(&motion->quickening) / h / h;
    }
    for (int k = 1; k <= INPUT_ORDER; k++) inputs->theta[k] = inputs->omega[k] = 0.0;
}
