/* The price of one evaluation of the acceleration in general grooves with every force, with no code of fmu_src:
 * equations of docs/mechanism.md, section 6, with slopes a_i = dz_i/dpsi and z as polynomials of the angle. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stddef.h>

#include "../harness/clock.h"

enum { DEGREE = 12 };

typedef struct {
    double a1[DEGREE + 1], a2[DEGREE + 1], z[DEGREE + 1]; /* of x = (theta - middle) scale, lowest power first */
    double middle, scale;
    double r1, r2, mu1, mu2;   /* m, - */
    double inertia, mass, spin; /* J, m, I */
    double preload, k, k2, k3; /* spring */
    double c, q, b;            /* damper, shaft */
    double tau;                /* N.m */
} Mechanism;

EXPORT double acceleration(const Mechanism *m, double theta, double omega) {
    const double x = (theta - m->middle) * m->scale;
    double a1 = 0.0, a1p = 0.0, a2 = 0.0, a2p = 0.0, z = 0.0;
    for (int k = DEGREE; k >= 0; k--) {
        a1p = a1p * x + a1;
        a2p = a2p * x + a2;
        a1 = a1 * x + m->a1[k];
        a2 = a2 * x + m->a2[k];
        z = z * x + m->z[k];
    }
    a1p *= m->scale;
    a2p *= m->scale;
    const double share = 1.0 / (a1 + a2), dgamma = a2 * share, dz = a1 * dgamma;
    const double n1 = a1 + m->mu1 * m->r1, n2 = a2 + m->mu2 * m->r2;
    const double e1 = m->r2 * (m->r1 - m->mu1 * a1) * n2, e2 = m->r1 * (m->r2 - m->mu2 * a2) * n1;
    const double delta = e1 + e2, p = m->r1 * m->r2 * n1 * n2;
    const double d2gamma = (a2p * a1 - a2 * a1p) * share * share;
    const double d2z = a1p * dgamma + a1 * d2gamma;
    const double v = dz * omega, spring = m->preload + z * (m->k + z * (m->k2 + z * m->k3));
    const double force = spring + v * (m->c + m->q * fabs(v));
    const double centrifugal = m->mass * p * d2z + m->spin * e1 * d2gamma;
    const double weight = m->inertia * delta + m->mass * p * dz + m->spin * e1 * dgamma;
    return (delta * (m->tau - m->b * omega) - p * force - centrifugal * omega * omega) / weight;
}

/* Seconds of n evaluations, which do not wait for each other. */
EXPORT double seconds_evaluations(const Mechanism *m, double omega, size_t n, double *sum) {
    double total = 0.0;
    const double start = now();
    for (size_t i = 0; i < n; i++) total += acceleration(m, 0.1 * (double)i / (double)n, omega);
    *sum = total;
    return now() - start;
}
