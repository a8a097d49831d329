/* The mechanism of the candidate integrators: theta'' = alpha(t, theta, omega) with its partial derivatives, for two
 * elliptical grooves whose transmission is fitted by polynomials. */
#ifndef MECHANISM_H
#define MECHANISM_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "../harness/clock.h"

#define INLINE static inline __attribute__((always_inline))

enum { DEGREE = 12 }; /* of the polynomials of the transmission */

static const double PI = 3.14159265358979323846;

/* An elliptical groove: S = start + rate psi, slope = steepness S / sqrt(1 - S^2). */
typedef struct {
    double start, rate, steepness; /* -, 1/rad, m/rad */
    double height;                 /* m: z = height (sqrt(1 - start^2) - sqrt(1 - S^2)) */
} Ellipse;

/* Polynomials in x = (theta - middle) scale, lowest power first. */
typedef struct {
    double a1[DEGREE + 1], a2[DEGREE + 1], z[DEGREE + 1], gamma[DEGREE + 1];
    double middle, scale;
} Transmission;

typedef struct {
    double r1, r2, mu1, mu2;     /* m, - */
    double inertia, mass, spin;  /* J, m, I */
    double preload, k, k2, k3;   /* spring */
    double c, q, b;              /* damper, shaft */
    double tau0, tau1;           /* tau = tau0 + tau1 t */
    double theta, omega;         /* at t = 0 */
    double span;                 /* s */
    int parts;                   /* number of communication steps, which divide the span equally */
    Ellipse groove1, groove2;
    Transmission transmission;
    double theta_scale, omega_scale;
} Scene;

typedef struct {
    long steps, rejected; /* accepted, refused */
    long values;          /* evaluations of alpha alone */
    long partials;        /* evaluations of alpha with its partial derivatives (for Taylor: of one order) */
    long solves, newton;  /* systems solved by Newton's method, iterations over all of them */
    long failed;          /* Newton did not converge, or no step was small enough */
    double theta, omega;
} Outcome;

/* The transmission at one theta: slopes a_i and z, first (p) and second (pp) derivatives of the slopes by theta. */
typedef struct {
    double a1, a2, z, a1p, a2p, a1pp, a2pp;
} Sample;

typedef struct {
    double alpha, by_time, by_theta, by_omega;
} Partials;

INLINE Sample sample(const Transmission *transmission, double theta, bool second) {
    const double x = (theta - transmission->middle) * transmission->scale;
    double v1 = 0.0, p1 = 0.0, h1 = 0.0, v2 = 0.0, p2 = 0.0, h2 = 0.0, z = 0.0;
    for (int k = DEGREE; k >= 0; k--) {
        if (second) {
            h1 = h1 * x + p1;
            h2 = h2 * x + p2;
        }
        p1 = p1 * x + v1;
        p2 = p2 * x + v2;
        v1 = v1 * x + transmission->a1[k];
        v2 = v2 * x + transmission->a2[k];
        z = z * x + transmission->z[k];
    }
    const double s = transmission->scale, ss = 2.0 * s * s;
    return (Sample){v1, v2, z, p1 * s, p2 * s, h1 * ss, h2 * ss};
}

INLINE double spring(const Scene *m, double z) {
    return m->preload + z * (m->k + z * (m->k2 + z * m->k3));
}

static double acceleration(const Scene *m, double t, double theta, double omega) {
    const Sample g = sample(&m->transmission, theta, false);
    const double share = 1.0 / (g.a1 + g.a2), dgamma = g.a2 * share, dz = g.a1 * dgamma;
    const double n1 = g.a1 + m->mu1 * m->r1, n2 = g.a2 + m->mu2 * m->r2;
    const double e1 = m->r2 * (m->r1 - m->mu1 * g.a1) * n2, e2 = m->r1 * (m->r2 - m->mu2 * g.a2) * n1;
    const double delta = e1 + e2, p = m->r1 * m->r2 * n1 * n2;
    const double d2gamma = (g.a2p * g.a1 - g.a2 * g.a1p) * share * share;
    const double d2z = g.a1p * dgamma + g.a1 * d2gamma;
    const double v = dz * omega, force = spring(m, g.z) + v * (m->c + m->q * fabs(v));
    const double torque = m->tau0 + m->tau1 * t - m->b * omega;
    const double centrifugal = m->mass * p * d2z + m->spin * e1 * d2gamma;
    const double weight = m->inertia * delta + m->mass * p * dz + m->spin * e1 * dgamma;
    return (delta * torque - p * force - centrifugal * omega * omega) / weight;
}

static Partials partials(const Scene *m, double t, double theta, double omega) {
    const Sample g = sample(&m->transmission, theta, true);
    const double share = 1.0 / (g.a1 + g.a2), dgamma = g.a2 * share, dz = g.a1 * dgamma;
    const double d2gamma = (g.a2p * g.a1 - g.a2 * g.a1p) * share * share;
    const double d2z = g.a1p * dgamma + g.a1 * d2gamma;
    const double d3gamma =
        share * ((g.a2pp * g.a1 - g.a2 * g.a1pp) * share - 2.0 * d2gamma * (g.a1p + g.a2p));
    const double d3z = g.a1pp * dgamma + 2.0 * g.a1p * d2gamma + g.a1 * d3gamma;
    const double n1 = g.a1 + m->mu1 * m->r1, n2 = g.a2 + m->mu2 * m->r2;
    const double d1 = m->r1 - m->mu1 * g.a1, d2 = m->r2 - m->mu2 * g.a2;
    const double e1 = m->r2 * d1 * n2, e1p = m->r2 * (d1 * g.a2p - m->mu1 * g.a1p * n2);
    const double e2 = m->r1 * d2 * n1, e2p = m->r1 * (d2 * g.a1p - m->mu2 * g.a2p * n1);
    const double delta = e1 + e2, deltap = e1p + e2p, rr = m->r1 * m->r2;
    const double p = rr * n1 * n2, pp = rr * (g.a1p * n2 + n1 * g.a2p);
    const double v = dz * omega, force = spring(m, g.z) + v * (m->c + m->q * fabs(v));
    const double force_z = m->k + g.z * (2.0 * m->k2 + 3.0 * g.z * m->k3);
    const double force_v = m->c + 2.0 * m->q * fabs(v);
    const double torque = m->tau0 + m->tau1 * t - m->b * omega, ww = omega * omega;
    const double centrifugal = m->mass * p * d2z + m->spin * e1 * d2gamma;
    const double centrifugalp =
        m->mass * (pp * d2z + p * d3z) + m->spin * (e1p * d2gamma + e1 * d3gamma);
    const double weight = m->inertia * delta + m->mass * p * dz + m->spin * e1 * dgamma;
    const double weightp = m->inertia * deltap + m->mass * (pp * dz + p * d2z) +
                           m->spin * (e1p * dgamma + e1 * d2gamma);
    const double inverse = 1.0 / weight;
    const double alpha = (delta * torque - p * force - centrifugal * ww) * inverse;
    const double by_theta = deltap * torque - pp * force -
                            p * (force_z * dz + force_v * d2z * omega) - centrifugalp * ww;
    const double by_omega = -delta * m->b - p * force_v * dz - 2.0 * centrifugal * omega;
    return (Partials){alpha, delta * m->tau1 * inverse, (by_theta - alpha * weightp) * inverse,
                      by_omega * inverse};
}

/* Fitting the transmission to the grooves. */

static double groove_root(const Ellipse *g, double psi) {
    const double s = g->start + g->rate * psi;
    return sqrt(1.0 - s * s);
}

static double groove_slope(const Ellipse *g, double psi) {
    return g->steepness * (g->start + g->rate * psi) / groove_root(g, psi);
}

static double groove_z(const Ellipse *g, double psi) {
    return g->height * (groove_root(g, 0.0) - groove_root(g, psi));
}

static double gamma_at(const Scene *m, double theta) {
    double gamma = 0.5 * theta;
    for (int i = 0; i < 50; i++) {
        const double gap = groove_z(&m->groove1, gamma) - groove_z(&m->groove2, theta - gamma);
        const double step =
            gap / (groove_slope(&m->groove1, gamma) + groove_slope(&m->groove2, theta - gamma));
        gamma -= step;
        if (fabs(step) < 1e-17) break;
    }
    return gamma;
}

/* Chebyshev interpolation of `value` at the DEGREE + 1 roots, turned into monomials. */
static void fit(const double value[DEGREE + 1], double monomial[DEGREE + 1]) {
    const int n = DEGREE + 1;
    double last[DEGREE + 1] = {0.0}, now[DEGREE + 1] = {0.0};
    memset(monomial, 0, sizeof(double) * (size_t)n);
    now[0] = 1.0;
    for (int k = 0; k < n; k++) {
        double sum = 0.0, next[DEGREE + 1];
        for (int j = 0; j < n; j++) sum += value[j] * cos(PI * k * (j + 0.5) / n);
        sum *= (k == 0 ? 1.0 : 2.0) / n;
        for (int i = 0; i < n; i++) monomial[i] += sum * now[i];
        for (int i = 0; i < n; i++)
            next[i] = (k == 0 ? 1.0 : 2.0) * (i > 0 ? now[i - 1] : 0.0) - (k == 0 ? 0.0 : last[i]);
        memcpy(last, now, sizeof last);
        memcpy(now, next, sizeof now);
    }
}

static double polynomial(const double c[DEGREE + 1], double x) {
    double sum = 0.0;
    for (int k = DEGREE; k >= 0; k--) sum = sum * x + c[k];
    return sum;
}

static void fit_transmission(Scene *m, double lower, double upper) {
    double a1[DEGREE + 1], a2[DEGREE + 1], z[DEGREE + 1], gamma[DEGREE + 1];
    Transmission *c = &m->transmission;
    c->middle = 0.5 * (lower + upper);
    c->scale = 2.0 / (upper - lower);
    for (int j = 0; j <= DEGREE; j++) {
        const double theta = c->middle + cos(PI * (j + 0.5) / (DEGREE + 1)) / c->scale;
        gamma[j] = gamma_at(m, theta);
        a1[j] = groove_slope(&m->groove1, gamma[j]);
        a2[j] = groove_slope(&m->groove2, theta - gamma[j]);
        z[j] = groove_z(&m->groove1, gamma[j]);
    }
    fit(a1, c->a1);
    fit(a2, c->a2);
    fit(z, c->z);
    fit(gamma, c->gamma);
}

/* Largest relative error of the slopes over the fitted range. */
EXPORT double fit_error(const Scene *m) {
    double worst = 0.0;
    for (int i = 0; i <= 200; i++) {
        const double x = i / 100.0 - 1.0, theta = m->transmission.middle + x / m->transmission.scale;
        const double gamma = gamma_at(m, theta);
        const double s1 = groove_slope(&m->groove1, gamma), s2 = groove_slope(&m->groove2, theta - gamma);
        worst = fmax(worst, fabs(polynomial(m->transmission.a1, x) / s1 - 1.0));
        worst = fmax(worst, fabs(polynomial(m->transmission.a2, x) / s2 - 1.0));
    }
    return worst;
}

#endif
