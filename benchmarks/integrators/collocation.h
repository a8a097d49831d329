/* Collocation: Radau IIA and Gauss methods, whose equations Newton's method solves. Their coefficients are in
 * integrator_tables.h. */
#ifndef COLLOCATION_H
#define COLLOCATION_H

#include "step_control.h"
#include "integrator_tables.h" /* uses step_control.h */

enum { NODES = 7, ITERATIONS = 10 };

typedef struct {
    int matrix;      /* derivatives in Newton's matrix: 0 of every iteration, 1 of the first one, 2 of the start */
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

/* Newton's method until the change that is still to come is below `enough`; false if it does not converge. */
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

/* One step: finds the new state and returns the error estimate from the defect at the start. Negative: no solution. */
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
            if (accepted) accept(y, &next, final ? end : next.t, o);
            else o->rejected++;
            if (raw < 0.0) o->failed++;
            if (o->steps + o->rejected > limit || *h < 1e-18) return false;
        }
    }
    return true;
}

#endif
