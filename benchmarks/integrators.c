/* Candidate integrators for theta'' = alpha(t, theta, omega), all on the same mechanism, and the loops
 * that time them. Driven by integrators.py, which also writes integrator_tables.h (coefficients of the
 * methods, to the last digit). Stands alone: nothing of fmu_src is used.
 *
 * Every method takes one step from one state and keeps nothing else, so that it may start anew at every
 * communication point. Tolerances are local errors relative to the largest |theta - theta_0| and |omega|
 * of the scene.
 */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>
#include <time.h>

#define EXPORT __attribute__((visibility("default")))
#define INLINE static inline __attribute__((always_inline))

enum { DEGREE = 12, NODES = 7, TERMS = 40, ITERATIONS = 10 };

static const double PI = 3.14159265358979323846;

/* ---- The mechanism ------------------------------------------------------------------------------- */

/* An elliptical groove: S = start + rate psi, slope = steepness S / sqrt(1 - S^2). */
typedef struct {
    double start, rate, steepness; /* -, 1/rad, m/rad */
    double height;                 /* m: z = height (sqrt(1 - start^2) - sqrt(1 - S^2)) */
} Ellipse;

/* Polynomials in x = (theta - middle) scale, lowest power first. */
typedef struct {
    double a1[DEGREE + 1], a2[DEGREE + 1], z[DEGREE + 1], gamma[DEGREE + 1];
    double middle, scale;
} Course;

typedef struct {
    double r1, r2, mu1, mu2;     /* m, - */
    double inertia, mass, spin;  /* J, m, I */
    double preload, k, k2, k3;   /* spring */
    double c, q, b;              /* damper, shaft */
    double tau0, tau1;           /* tau = tau0 + tau1 t */
    double theta, omega;         /* at t = 0 */
    double span;                 /* s */
    int parts;                   /* communication steps: the span is cut into so many equal parts */
    Ellipse groove1, groove2;
    Course course;
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

typedef struct {
    double a1, a2, z, a1p, a2p, a1pp, a2pp;
} Spot;

typedef struct {
    double alpha, by_time, by_theta, by_omega;
} Partials;

INLINE Spot spot(const Course *course, double theta, bool second) {
    const double x = (theta - course->middle) * course->scale;
    double v1 = 0.0, p1 = 0.0, h1 = 0.0, v2 = 0.0, p2 = 0.0, h2 = 0.0, z = 0.0;
    for (int k = DEGREE; k >= 0; k--) {
        if (second) {
            h1 = h1 * x + p1;
            h2 = h2 * x + p2;
        }
        p1 = p1 * x + v1;
        p2 = p2 * x + v2;
        v1 = v1 * x + course->a1[k];
        v2 = v2 * x + course->a2[k];
        z = z * x + course->z[k];
    }
    const double s = course->scale, ss = 2.0 * s * s;
    return (Spot){v1, v2, z, p1 * s, p2 * s, h1 * ss, h2 * ss};
}

INLINE double spring(const Scene *m, double z) {
    return m->preload + z * (m->k + z * (m->k2 + z * m->k3));
}

static double acceleration(const Scene *m, double t, double theta, double omega) {
    const Spot g = spot(&m->course, theta, false);
    const double share = 1.0 / (g.a1 + g.a2), turn = g.a2 * share, lift = g.a1 * turn;
    const double n1 = g.a1 + m->mu1 * m->r1, n2 = g.a2 + m->mu2 * m->r2;
    const double e1 = m->r2 * (m->r1 - m->mu1 * g.a1) * n2, e2 = m->r1 * (m->r2 - m->mu2 * g.a2) * n1;
    const double delta = e1 + e2, p = m->r1 * m->r2 * n1 * n2;
    const double turnp = (g.a2p * g.a1 - g.a2 * g.a1p) * share * share;
    const double liftp = g.a1p * turn + g.a1 * turnp;
    const double v = lift * omega, force = spring(m, g.z) + v * (m->c + m->q * fabs(v));
    const double torque = m->tau0 + m->tau1 * t - m->b * omega;
    const double centrifugal = m->mass * p * liftp + m->spin * e1 * turnp;
    const double weight = m->inertia * delta + m->mass * p * lift + m->spin * e1 * turn;
    return (delta * torque - p * force - centrifugal * omega * omega) / weight;
}

static Partials partials(const Scene *m, double t, double theta, double omega) {
    const Spot g = spot(&m->course, theta, true);
    const double share = 1.0 / (g.a1 + g.a2), turn = g.a2 * share, lift = g.a1 * turn;
    const double turnp = (g.a2p * g.a1 - g.a2 * g.a1p) * share * share;
    const double liftp = g.a1p * turn + g.a1 * turnp;
    const double turnpp =
        share * ((g.a2pp * g.a1 - g.a2 * g.a1pp) * share - 2.0 * turnp * (g.a1p + g.a2p));
    const double liftpp = g.a1pp * turn + 2.0 * g.a1p * turnp + g.a1 * turnpp;
    const double n1 = g.a1 + m->mu1 * m->r1, n2 = g.a2 + m->mu2 * m->r2;
    const double d1 = m->r1 - m->mu1 * g.a1, d2 = m->r2 - m->mu2 * g.a2;
    const double e1 = m->r2 * d1 * n2, e1p = m->r2 * (d1 * g.a2p - m->mu1 * g.a1p * n2);
    const double e2 = m->r1 * d2 * n1, e2p = m->r1 * (d2 * g.a1p - m->mu2 * g.a2p * n1);
    const double delta = e1 + e2, deltap = e1p + e2p, rr = m->r1 * m->r2;
    const double p = rr * n1 * n2, pp = rr * (g.a1p * n2 + n1 * g.a2p);
    const double v = lift * omega, force = spring(m, g.z) + v * (m->c + m->q * fabs(v));
    const double force_z = m->k + g.z * (2.0 * m->k2 + 3.0 * g.z * m->k3);
    const double force_v = m->c + 2.0 * m->q * fabs(v);
    const double torque = m->tau0 + m->tau1 * t - m->b * omega, ww = omega * omega;
    const double centrifugal = m->mass * p * liftp + m->spin * e1 * turnp;
    const double centrifugalp =
        m->mass * (pp * liftp + p * liftpp) + m->spin * (e1p * turnp + e1 * turnpp);
    const double weight = m->inertia * delta + m->mass * p * lift + m->spin * e1 * turn;
    const double weightp = m->inertia * deltap + m->mass * (pp * lift + p * liftp) +
                           m->spin * (e1p * turn + e1 * turnp);
    const double inverse = 1.0 / weight;
    const double alpha = (delta * torque - p * force - centrifugal * ww) * inverse;
    const double by_theta = deltap * torque - pp * force -
                            p * (force_z * lift + force_v * liftp * omega) - centrifugalp * ww;
    const double by_omega = -delta * m->b - p * force_v * lift - 2.0 * centrifugal * omega;
    return (Partials){alpha, delta * m->tau1 * inverse, (by_theta - alpha * weightp) * inverse,
                      by_omega * inverse};
}

/* ---- Fitting the course to the grooves ------------------------------------------------------------ */

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

static void fit_course(Scene *m, double lower, double upper) {
    double a1[DEGREE + 1], a2[DEGREE + 1], z[DEGREE + 1], gamma[DEGREE + 1];
    Course *c = &m->course;
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

/* Largest relative error of the slopes over the piece. */
EXPORT double fit_error(const Scene *m) {
    double worst = 0.0;
    for (int i = 0; i <= 200; i++) {
        const double x = i / 100.0 - 1.0, theta = m->course.middle + x / m->course.scale;
        const double gamma = gamma_at(m, theta);
        const double s1 = groove_slope(&m->groove1, gamma), s2 = groove_slope(&m->groove2, theta - gamma);
        worst = fmax(worst, fabs(polynomial(m->course.a1, x) / s1 - 1.0));
        worst = fmax(worst, fabs(polynomial(m->course.a2, x) / s2 - 1.0));
    }
    return worst;
}

/* ---- What the methods share ----------------------------------------------------------------------- */

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
    const double bend = size(m, alpha, (there - alpha) / h0);
    o->values++;
    return fmin(m->span, fmin(100.0 * h0, pow(tolerance / fmax(slow, bend * h0), 1.0 / order) * 0.5 + h0));
}

/* ---- Explicit Runge-Kutta ------------------------------------------------------------------------- */

#include "integrator_tables.h"

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

/* Over one communication step. */
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
            next.t = final ? end : next.t;
            *y = next;
            o->steps++;
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

/* ---- Rosenbrock: RODAS, order 4(3), six stages, stiffly accurate ----------------------------------- */

static const double RODAS_GAMMA = 0.25;
static const double RODAS_A[6][5] = {
    {0.0},
    {1.544},
    {0.9466785280815826, 0.2557011698983284},
    {3.314825187068521, 2.896124015972201, 0.9986419139977817},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
};
static const double RODAS_C[6][5] = {
    {0.0},
    {-5.6688},
    {-2.430093356833875, -0.2063599157091915},
    {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
    {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
    {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054},
};
static const double RODAS_TIME[6] = {0.0, 0.386, 0.21, 0.63, 1.0, 1.0};
static const double RODAS_D[6] = {0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0};

/* Solves ((1/(gamma h)) I - Jacobian) u = r for the first-order form of the second-order equation. */
INLINE void rodas_solve(const Partials *p, double g, const double r[2], double u[2]) {
    u[1] = (r[1] + p->by_theta * r[0] / g) / (g - p->by_omega - p->by_theta / g);
    u[0] = (r[0] + u[1]) / g;
}

INLINE void rodas_stage(const Scene *m, const State *y, double h, const Partials *p, int i, double at[2],
                        double u[6][2]) {
    double r[2] = {0.0, 0.0};
    for (int j = 0; j < i; j++)
        for (int d = 0; d < 2; d++) r[d] += RODAS_C[i][j] / h * u[j][d];
    const double alpha =
        i == 0 ? p->alpha : acceleration(m, y->t + RODAS_TIME[i] * h, at[0], at[1]);
    r[0] += at[1];
    r[1] += alpha + h * RODAS_D[i] * p->by_time;
    rodas_solve(p, 1.0 / (RODAS_GAMMA * h), r, u[i]);
}

static double rodas_step(const Scene *m, const State *y, double h, const Partials *p, State *next) {
    double u[6][2], at[2] = {y->theta, y->omega};
    for (int i = 0; i < 5; i++) {
        at[0] = y->theta;
        at[1] = y->omega;
        for (int j = 0; j < i; j++)
            for (int d = 0; d < 2; d++) at[d] += RODAS_A[i][j] * u[j][d];
        rodas_stage(m, y, h, p, i, at, u);
    }
    for (int d = 0; d < 2; d++) at[d] += u[4][d];
    rodas_stage(m, y, h, p, 5, at, u);
    *next = (State){y->t + h, at[0] + u[5][0], at[1] + u[5][1]};
    return size(m, u[5][0], u[5][1]);
}

static bool rodas_run(const Scene *m, State *y, double end, double *h, double tolerance, Outcome *o,
                      long limit) {
    double cap = 8.0;
    while (y->t < end) {
        const Partials p = partials(m, y->t, y->theta, y->omega);
        o->partials++;
        if (*h <= 0.0) *h = first_step(m, y, p.alpha, tolerance, 4.0, o);
        for (bool accepted = false; !accepted;) {
            const bool final = *h >= (end - y->t) * (1.0 - 1e-12);
            const double used = final ? end - y->t : *h;
            State next;
            const double error = rodas_step(m, y, used, &p, &next) / tolerance;
            const double scale = fmin(cap, factor(error, 4.0));
            o->values += 5;
            accepted = error <= 1.0;
            cap = accepted ? 8.0 : 1.0;
            if (!accepted || !final || scale < 1.0) *h = used * scale;
            if (accepted) {
                *y = next;
                if (final) y->t = end;
                o->steps++;
            } else {
                o->rejected++;
            }
            if (o->steps + o->rejected > limit || *h < 1e-18) return false;
        }
    }
    return true;
}

/* ---- Taylor series with the grooves' closed form --------------------------------------------------- */

typedef double Series[TERMS + 3];

typedef struct {
    Series theta, omega, alpha, gamma;
    Series s[2], square[2], root[2], slope[2], z, sum, turn, lift;
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
    x->turn[n] = quotient(x->slope[1][n], x->sum, x->turn, n);
    x->lift[n] = product(x->slope[0], x->turn, n);
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
    if (m->mass != 0.0) x->weight[n] += m->mass * product(x->nn, x->lift, n);
    if (m->spin != 0.0) x->weight[n] += m->spin * product(x->dn[0], x->turn, n);
}

static double taylor_force(const Scene *m, Taylor *x, int n) {
    double force = (n == 0 ? m->preload : 0.0) + m->k * x->z[n];
    if (m->k2 != 0.0 || m->k3 != 0.0) {
        x->zz[n] = product(x->z, x->z, n);
        force += m->k2 * x->zz[n] + m->k3 * product(x->zz, x->z, n);
    }
    if (m->c != 0.0 || m->q != 0.0) {
        x->v[n] = product(x->lift, x->omega, n);
        force += m->c * x->v[n];
        if (m->q != 0.0) force += (x->v[0] < 0.0 ? -m->q : m->q) * product(x->v, x->v, n);
    }
    return force;
}

/* n-th coefficient of (m p lift' + I e turn') omega, from derivatives of the series by time. */
static double taylor_whirl(const Scene *m, const Taylor *x, int n) {
    double sum = 0.0;
    for (int k = 0; k <= n; k++) {
        const double axial = m->mass * x->nn[n - k] * x->lift[k + 1];
        sum += (k + 1) * (axial + m->spin * x->dn[0][n - k] * x->turn[k + 1]);
    }
    return sum;
}

/* From coefficients up to n of omega and n + 1 of theta: one more of each. */
static void taylor_order(const Scene *m, Taylor *x, double t, int n) {
    const bool heavy = m->mass != 0.0 || m->spin != 0.0;
    x->gamma[n + 1] = product(x->turn, x->omega, n) / (n + 1);
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

/* Adds orders until the rest of the way is covered or the highest order is reached; returns the step. */
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
    double gamma = polynomial(m->course.gamma, (y->theta - m->course.middle) * m->course.scale);
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

/* ---- Collocation ---------------------------------------------------------------------------------- */

typedef struct {
    int matrix;      /* where its derivatives are from: 0 every iteration, 1 the first one, 2 the start */
    bool linear;     /* stiff predictor: the solution of the equation linearised at the start */
    bool slaved;     /* estimate theta also from the defect in omega, which does not vanish when stiff */
    double power;    /* the controlled error is (interior error)^power */
    double order;    /* of the controlled error */
} Control;

typedef struct {
    double m[NODES][NODES];
    int row[NODES];
} Lu;

/* LU with partial pivoting; false if singular. */
INLINE bool lu_factor(Lu *lu, int s) {
    for (int k = 0; k < s; k++) {
        int best = k;
        for (int i = k + 1; i < s; i++)
            if (fabs(lu->m[i][k]) > fabs(lu->m[best][k])) best = i;
        lu->row[k] = best;
        for (int j = 0; best != k && j < s; j++) {
            const double swap = lu->m[k][j];
            lu->m[k][j] = lu->m[best][j];
            lu->m[best][j] = swap;
        }
        if (!(fabs(lu->m[k][k]) > 0.0)) return false;
        const double inverse = 1.0 / lu->m[k][k];
        for (int i = k + 1; i < s; i++) {
            const double f = lu->m[i][k] *= inverse;
            for (int j = k + 1; j < s; j++) lu->m[i][j] -= f * lu->m[k][j];
        }
        lu->m[k][k] = inverse;
    }
    return true;
}

INLINE void lu_solve(const Lu *lu, int s, double x[]) {
    for (int k = 0; k < s; k++) {
        const double swap = x[k];
        x[k] = x[lu->row[k]];
        x[lu->row[k]] = swap;
    }
    for (int i = 1; i < s; i++)
        for (int j = 0; j < i; j++) x[i] -= lu->m[i][j] * x[j];
    for (int i = s - 1; i >= 0; i--) {
        for (int j = i + 1; j < s; j++) x[i] -= lu->m[i][j] * x[j];
        x[i] *= lu->m[i][i];
    }
}

INLINE double dot(const double *x, const double *y, int s) {
    double sum = 0.0;
    for (int k = 0; k < s; k++) sum += x[k] * y[k];
    return sum;
}

INLINE void lu_row(Lu *lu, const Collocation *c, int s, int j, double h, double by_theta, double by_omega) {
    const double f1 = h * by_omega, f2 = h * h * by_theta;
    for (int k = 0; k < s; k++)
        lu->m[j][k] = (j == k ? 1.0 : 0.0) - f1 * c->a[j][k] - f2 * c->aa[j][k];
}

/* Node values to start from: along the tangent or, if asked for and stiff, linearised. */
INLINE bool predict(const Collocation *c, int s, const State *y, double h, const Partials *p,
                    const Control *how, Lu *lu, double alpha[]) {
    const double drift = p->by_time + p->by_theta * y->omega;
    const bool stiff = how->linear && h * fabs(p->by_omega) + h * h * fabs(p->by_theta) > 0.3;
    const bool linear = stiff || how->matrix == 2;
    for (int j = 0; j < s; j++)
        alpha[j] = p->alpha + (drift + (linear ? 0.0 : p->by_omega * p->alpha)) * c->c[j] * h;
    if (!linear) return true;
    for (int j = 0; j < s; j++) lu_row(lu, c, s, j, h, p->by_theta, p->by_omega);
    if (!lu_factor(lu, s)) return false;
    lu_solve(lu, s, alpha);
    return true;
}

/* One iteration; the largest change of omega and theta at the end of the step, relative to the scales. */
INLINE double iterate(const Scene *m, const Collocation *c, int s, const State *y, double h, Lu *lu,
                      bool renew, double alpha[], Outcome *o) {
    double residual[NODES], largest = 0.0;
    for (int j = 0; j < s; j++) {
        const double t = y->t + c->c[j] * h, omega = y->omega + h * dot(c->a[j], alpha, s);
        const double theta = y->theta + h * (c->c[j] * y->omega + h * dot(c->aa[j], alpha, s));
        if (renew) {
            const Partials p = partials(m, t, theta, omega);
            residual[j] = p.alpha - alpha[j];
            lu_row(lu, c, s, j, h, p.by_theta, p.by_omega);
        } else {
            residual[j] = acceleration(m, t, theta, omega) - alpha[j];
        }
    }
    if (renew) o->partials += s;
    else o->values += s;
    o->newton++;
    if (renew && !lu_factor(lu, s)) return INFINITY;
    lu_solve(lu, s, residual);
    for (int j = 0; j < s; j++) {
        alpha[j] += residual[j];
        largest = fmax(largest, fabs(residual[j]));
        if (isnan(residual[j])) return INFINITY;
    }
    return size(m, h * h * largest, h * largest);
}

/* Newton's method until what is left is below `enough`; false if it does not get there. */
INLINE bool solve_nodes(const Scene *m, const Collocation *c, int s, const State *y, double h,
                        const Partials *p, const Control *how, double enough, double alpha[], Outcome *o) {
    Lu lu;
    double last = INFINITY;
    o->solves++;
    if (!predict(c, s, y, h, p, how, &lu, alpha)) return false;
    for (int i = 0; i < ITERATIONS; i++) {
        const bool renew = how->matrix == 0 || (how->matrix == 1 && i == 0);
        const double change = iterate(m, c, s, y, h, &lu, renew, alpha, o);
        if (!(change < 1e6)) return false;
        const double ratio = change / last, next = change * ratio * (how->matrix ? 1.0 : ratio);
        if (change <= enough || (i > 0 && ratio < 0.5 && next <= enough)) return true;
        if (i > 0 && ratio > 0.3 && change < 1e-12) return true; /* rounding */
        if (i > 1 && ratio > 2.0) return false;
        last = change;
    }
    return false;
}

/* One step: the new state and the error estimate from the defect at the start. Negative: no solution. */
INLINE double collocation_step(const Scene *m, const Collocation *c, int s, const State *y, double h,
                               const Partials *p, const Control *how, double tolerance, State *next,
                               Outcome *o) {
    double alpha[NODES];
    if (!solve_nodes(m, c, s, y, h, p, how, 0.03 * tolerance, alpha, o)) return -1.0;
    const double stiff = h * fabs(p->by_omega) + h * h * fabs(p->by_theta);
    const double defect = h * fabs(p->alpha - dot(c->start, alpha, s)) / (1.0 + stiff);
    double theta_error = h * defect * c->theta_error;
    if (how->slaved) {
        double slip = 0.0; /* omega_0 minus the polynomial through omega at the nodes */
        for (int j = 0; j < s; j++) slip -= c->start[j] * dot(c->a[j], alpha, s);
        theta_error += h * h * fabs(slip) * c->omega_error * stiff / (1.0 + stiff);
    }
    *next = (State){y->t + h, y->theta + h * (y->omega + h * dot(c->ba, alpha, s)),
                    y->omega + h * dot(c->b, alpha, s)};
    return size(m, theta_error, defect * c->omega_error);
}

/* The error that is compared with the tolerance. */
INLINE double controlled(double raw, const Control *how) {
    if (raw < 0.0) return INFINITY;
    return how->power == 1.0 ? raw : pow(raw, how->power);
}

INLINE bool collocation_run(const Scene *m, const Collocation *c, int s, State *y, double end, double *h,
                            double tolerance, const Control *how, Outcome *o, long limit) {
    double cap = 8.0;
    while (y->t < end) {
        const Partials p = partials(m, y->t, y->theta, y->omega);
        o->partials++;
        if (*h <= 0.0) *h = first_step(m, y, p.alpha, tolerance, how->order, o);
        for (bool accepted = false; !accepted;) {
            const bool final = *h >= (end - y->t) * (1.0 - 1e-12);
            const double used = final ? end - y->t : *h;
            State next;
            const double raw = collocation_step(m, c, s, y, used, &p, how, tolerance, &next, o);
            const double error = controlled(raw, how) / tolerance;
            const double scale = raw < 0.0 ? 0.2 : fmin(cap, factor(error, how->order));
            accepted = error <= 1.0;
            cap = accepted ? 8.0 : 1.0;
            if (!accepted || !final || scale < 1.0) *h = used * scale;
            if (accepted) {
                *y = next;
                if (final) y->t = end;
                o->steps++;
            } else {
                o->rejected++;
            }
            if (raw < 0.0) o->failed++;
            if (o->steps + o->rejected > limit || *h < 1e-18) return false;
        }
    }
    return true;
}

/* ---- Methods by number ---------------------------------------------------------------------------- */

typedef struct {
    int kind;     /* 0 DP5, 1 DOP853, 2 Taylor, 3 RODAS, 4 Radau IIA, 5 Gauss */
    int stages;   /* collocation */
    Control control;
} Method;

static bool advance(const Scene *m, const Method *w, State *y, double end, double *h, double tolerance,
                    Outcome *o, long limit) {
    const Control *how = &w->control;
    switch (w->kind * 10 + w->stages) {
    case 0: return explicit_run(m, y, end, h, tolerance, dp5_step, 5.0, 7, o, limit);
    case 10: return explicit_run(m, y, end, h, tolerance, dop853_step, 8.0, 12, o, limit);
    case 20: return taylor_run(m, y, end, tolerance, o, limit);
    case 30: return rodas_run(m, y, end, h, tolerance, o, limit);
    case 42: return collocation_run(m, &RADAU2, 2, y, end, h, tolerance, how, o, limit);
    case 43: return collocation_run(m, &RADAU3, 3, y, end, h, tolerance, how, o, limit);
    case 45: return collocation_run(m, &RADAU5, 5, y, end, h, tolerance, how, o, limit);
    case 47: return collocation_run(m, &RADAU7, 7, y, end, h, tolerance, how, o, limit);
    case 53: return collocation_run(m, &GAUSS3, 3, y, end, h, tolerance, how, o, limit);
    case 55: return collocation_run(m, &GAUSS5, 5, y, end, h, tolerance, how, o, limit);
    default: return false;
    }
}

/* The whole scene. Nothing but the state survives a communication point. */
static __attribute__((noinline)) void integrate(const Scene *m, const Method *w, double tolerance,
                                                long limit, Outcome *o) {
    State y = {0.0, m->theta, m->omega};
    *o = (Outcome){0};
    for (int i = 0; i < m->parts; i++) {
        double h = 0.0;
        const double end = i + 1 == m->parts ? m->span : m->span * (i + 1) / m->parts;
        if (!advance(m, w, &y, end, &h, tolerance, o, limit)) {
            o->failed = -1;
            break;
        }
    }
    o->theta = y.theta;
    o->omega = y.omega;
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seconds of `repeats` runs of the scene. */
EXPORT double seconds_run(const Scene *m, const Method *w, double tolerance, long limit, int repeats,
                          Outcome *o) {
    const double start = now();
    for (int i = 0; i < repeats; i++) integrate(m, w, tolerance, limit, o);
    return now() - start;
}

/* Seconds of n evaluations of alpha, with its partial derivatives or without; they do not wait for each
 * other. */
EXPORT double seconds_evaluations(const Scene *m, bool with_partials, int n, double *sum) {
    double total = 0.0;
    const double start = now();
    for (int i = 0; i < n; i++) {
        const double theta = m->theta + 0.1 * i / n;
        total += with_partials ? partials(m, 0.0, theta, m->omega).by_theta
                               : acceleration(m, 0.0, theta, m->omega);
    }
    *sum = total;
    return now() - start;
}

typedef double Exp(double x);
typedef void Sincos(double x, double *sine, double *cosine);

/* Seconds of n times one exp and one sincos, as in step_cost.c. */
EXPORT double seconds_plain(Exp *exp_, Sincos *sincos_, const double x[], size_t n, double *sum) {
    const double start = now();
    double total = 0.0;
    for (size_t i = 0; i < n; i++) {
        double sine, cosine;
        sincos_(x[i], &sine, &cosine);
        total += exp_(-x[i]) + sine + cosine;
    }
    *sum = total;
    return now() - start;
}

/* Fits the course over [lower, upper] and finds the scales by running the scene once. */
EXPORT void prepare(Scene *m, double lower, double upper, const Method *w) {
    Scene probe;
    fit_course(m, lower, upper);
    m->theta_scale = m->omega_scale = 1.0;
    probe = *m;
    double theta = 0.0, omega = 0.0;
    for (int i = 1; i <= 64; i++) {
        Outcome o;
        probe.span = m->span * i / 64.0;
        probe.parts = 1;
        integrate(&probe, w, 1e-10, 1000000, &o);
        theta = fmax(theta, fabs(o.theta - m->theta));
        omega = fmax(omega, fabs(o.omega));
    }
    m->theta_scale = theta;
    m->omega_scale = fmax(omega, fabs(m->omega));
}

/* Values for checking: alpha and its partial derivatives, and alpha alone in the last. */
EXPORT void values_at(const Scene *m, double t, double theta, double omega, double out[5]) {
    const Partials p = partials(m, t, theta, omega);
    out[0] = p.alpha;
    out[1] = p.by_time;
    out[2] = p.by_theta;
    out[3] = p.by_omega;
    out[4] = acceleration(m, t, theta, omega);
}

EXPORT size_t scene_size(void) {
    return sizeof(Scene);
}
