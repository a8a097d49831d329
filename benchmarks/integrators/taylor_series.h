/* Taylor series of the motion, with the closed form of the grooves. */
#ifndef TAYLOR_SERIES_H
#define TAYLOR_SERIES_H

#include "step_control.h"

enum { TERMS = 40 };

typedef double Series[TERMS + 3];

typedef struct {
    Series theta, omega, alpha, gamma;
    Series s[2], square[2], root[2], slope[2], z, sum, dgamma, dz;
    Series n[2], d[2], nn, dn[2], delta, v, force, torque, weight, whirl, zz;
} Taylor;

INLINE double convolve(const double *x, const double *y, int from, int to, int n) {
    double sum = 0.0;
    for (int k = from; k <= to; k++) sum += x[k] * y[n - k];
    return sum;
}

INLINE double product(const double *x, const double *y, int n) {
    return convolve(x, y, 0, n, n);
}

/* Coefficient n of numerator / denominator. */
INLINE double quotient(double numerator, const double *denominator, const double *result, int n) {
    return (numerator - convolve(denominator, result, 1, n, n)) / denominator[0];
}

static void taylor_groove(const Ellipse *g, Taylor *x, int i, double psi, int n) {
    x->s[i][n] = (n == 0 ? g->start : 0.0) + g->rate * psi;
    x->square[i][n] = (n == 0 ? 1.0 : 0.0) - product(x->s[i], x->s[i], n);
    x->root[i][n] = n == 0 ? sqrt(x->square[i][0])
                           : (x->square[i][n] - convolve(x->root[i], x->root[i], 1, n - 1, n)) /
                                 (2.0 * x->root[i][0]);
    x->slope[i][n] = quotient(g->steepness * x->s[i][n], x->root[i], x->slope[i], n);
}

static void taylor_geometry(const Scene *m, Taylor *x, int n) {
    taylor_groove(&m->groove1, x, 0, x->gamma[n], n);
    taylor_groove(&m->groove2, x, 1, x->theta[n] - x->gamma[n], n);
    x->z[n] = (n == 0 ? m->groove1.height * groove_root(&m->groove1, 0.0) : 0.0) -
              m->groove1.height * x->root[0][n];
    x->sum[n] = x->slope[0][n] + x->slope[1][n];
    x->dgamma[n] = quotient(x->slope[1][n], x->sum, x->dgamma, n);
    x->dz[n] = product(x->slope[0], x->dgamma, n);
    const double one = n == 0 ? 1.0 : 0.0;
    const double a1 = x->slope[0][n], a2 = x->slope[1][n];
    x->n[0][n] = a1 + one * m->mu1 * m->r1;
    x->n[1][n] = a2 + one * m->mu2 * m->r2;
    x->d[0][n] = one * m->r1 - m->mu1 * a1;
    x->d[1][n] = one * m->r2 - m->mu2 * a2;
    x->nn[n] = m->r1 * m->r2 * product(x->n[0], x->n[1], n);
    x->dn[0][n] = m->r2 * product(x->d[0], x->n[1], n);
    x->dn[1][n] = m->r1 * product(x->d[1], x->n[0], n);
    x->delta[n] = x->dn[0][n] + x->dn[1][n];
    x->weight[n] = m->inertia * x->delta[n];
    if (m->mass != 0.0) x->weight[n] += m->mass * product(x->nn, x->dz, n);
    if (m->spin != 0.0) x->weight[n] += m->spin * product(x->dn[0], x->dgamma, n);
}

static double taylor_force(const Scene *m, Taylor *x, int n) {
    double force = (n == 0 ? m->preload : 0.0) + m->k * x->z[n];
    if (m->k2 != 0.0 || m->k3 != 0.0) {
        x->zz[n] = product(x->z, x->z, n);
        force += m->k2 * x->zz[n] + m->k3 * product(x->zz, x->z, n);
    }
    if (m->c != 0.0 || m->q != 0.0) {
        x->v[n] = product(x->dz, x->omega, n);
        force += m->c * x->v[n];
        if (m->q != 0.0) force += (x->v[0] < 0.0 ? -m->q : m->q) * product(x->v, x->v, n);
    }
    return force;
}

/* n-th coefficient of (m p dz' + I e dgamma') omega, from derivatives of the series by time. */
static double taylor_whirl(const Scene *m, const Taylor *x, int n) {
    double sum = 0.0;
    for (int k = 0; k <= n; k++) {
        const double axial = m->mass * x->nn[n - k] * x->dz[k + 1];
        sum += (k + 1) * (axial + m->spin * x->dn[0][n - k] * x->dgamma[k + 1]);
    }
    return sum;
}

/* From coefficients up to n of omega and n + 1 of theta: one more of each. */
static void taylor_order(const Scene *m, Taylor *x, double t, int n) {
    const bool heavy = m->mass != 0.0 || m->spin != 0.0;
    x->gamma[n + 1] = product(x->dgamma, x->omega, n) / (n + 1);
    taylor_geometry(m, x, n + 1);
    const double tau = n == 0 ? m->tau0 + m->tau1 * t : n == 1 ? m->tau1 : 0.0;
    x->torque[n] = tau - m->b * x->omega[n];
    x->force[n] = taylor_force(m, x, n);
    double top = product(x->delta, x->torque, n) - product(x->nn, x->force, n);
    if (heavy) {
        x->whirl[n] = taylor_whirl(m, x, n);
        top -= product(x->whirl, x->omega, n);
    }
    x->alpha[n] = quotient(top, x->weight, x->alpha, n);
    x->omega[n + 1] = x->alpha[n] / (n + 1);
    x->theta[n + 2] = x->omega[n + 1] / (n + 2);
}

static State taylor_sum(const Taylor *x, const State *y, double h, int order, double *gamma) {
    double theta = x->theta[order + 1], omega = x->omega[order];
    *gamma = x->gamma[order];
    for (int k = order; k >= 0; k--) theta = theta * h + x->theta[k];
    for (int k = order - 1; k >= 0; k--) {
        omega = omega * h + x->omega[k];
        *gamma = *gamma * h + x->gamma[k];
    }
    return (State){y->t + h, theta, omega};
}

/* Adds orders until the series covers the rest of the time or reaches the highest order; returns the step. */
static double taylor_expand(const Scene *m, Taylor *x, double t, double rest, double tolerance, int highest,
                            int *order) {
    double last = INFINITY, power = 1.0, term = INFINITY;
    int n = 0;
    while (n < highest) {
        taylor_order(m, x, t, n++);
        power *= rest;
        last = term;
        term = size(m, x->theta[n + 1] * rest, x->omega[n]);
        if (n > 1 && fmax(term * power, last * power / rest) < 0.2 * tolerance) break;
    }
    *order = n;
    const double one = pow(tolerance / (term + 1e-300), 1.0 / n);
    const double two = pow(tolerance / (last + 1e-300), 1.0 / (n - 1));
    return fmin(rest, 0.9 * fmin(one, two));
}

static bool taylor_run(const Scene *m, State *y, double end, double tolerance, Outcome *o, long limit) {
    Taylor x;
    const int highest = (int)fmin(TERMS - 1, ceil(1.0 - 0.5 * log(tolerance)) + 1.0);
    double gamma = polynomial(m->transmission.gamma, (y->theta - m->transmission.middle) * m->transmission.scale);
    while (y->t < end) {
        int order;
        x.theta[0] = y->theta;
        x.theta[1] = x.omega[0] = y->omega;
        x.gamma[0] = gamma;
        taylor_geometry(m, &x, 0);
        const double rest = end - y->t;
        const double h = taylor_expand(m, &x, y->t, rest, tolerance, highest, &order);
        *y = taylor_sum(&x, y, h, order, &gamma);
        if (h >= rest) y->t = end;
        o->partials += order;
        o->steps++;
        if (o->steps > limit || !(h > 1e-18)) return false;
    }
    return true;
}

#endif
