/* Rosenbrock method RODAS: order 4(3), six stages, stiffly accurate. */
#ifndef RODAS_H
#define RODAS_H

#include "step_control.h"

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
            if (accepted) accept(y, &next, final ? end : next.t, o);
            else o->rejected++;
            if (o->steps + o->rejected > limit || *h < 1e-18) return false;
        }
    }
    return true;
}

#endif
