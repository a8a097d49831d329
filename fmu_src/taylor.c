#include "taylor.h"

#include <math.h>

static Dual plain(double value) {
    return (Dual){value, 0.0};
}

/* ---- along a given motion ---- */

static void around(const double p[COURSE_DEGREE + 1], const Jet *x, double out[JET_TERMS]) {
    const Jet value = jet_polynomial(p, COURSE_DEGREE, x);
    for (int k = 0; k < JET_TERMS; k++) out[k] = value.c[k].value;
}

void taylor_place(const Way *w, Taylor *t) {
    const Piece *piece = w->piece;
    const Jet x = {.c = {plain((t->theta.c[0].value - piece->middle) * piece->scale), plain(piece->scale)}};
    for (int i = 0; i < 2; i++) {
        double slope[COURSE_DEGREE + 1];
        for (int k = 0; k <= COURSE_DEGREE; k++) slope[k] = piece->slope[k][i];
        around(slope, &x, t->slope[i]);
        t->slope[i][0] = fmax(t->slope[i][0], 0.0); /* level, but for the polynomial's rounding */
    }
    around(piece->z, &x, t->height);
}

/* A parameter, and its derivative by the knob. */
static Dual seeded(const Taylor *t, double value, Knob knob) {
    return (Dual){value, t->knob == knob ? 1.0 : 0.0};
}

static Jet spring_along(const SpringParams *s, const Taylor *t) {
    const double law[] = {s->preload, s->stiffness, s->stiffness2, s->stiffness3};
    Jet force = jet_polynomial(law, 3, &t->z);
    if (t->knob >= KNOB_PRELOAD && t->knob <= KNOB_STIFFNESS3) {
        double unit[4] = {0.0};
        unit[t->knob - KNOB_PRELOAD] = 1.0;
        const Jet power = jet_polynomial(unit, 3, &t->z);
        for (int k = 0; k < JET_TERMS; k++) force.c[k].slope += power.c[k].value;
    }
    return force;
}

/* v (c + q |v|) */
static Jet damper_along(const Way *w, const Taylor *t) {
    const bool up = w->direction > 0;
    const Dual c = seeded(t, w->c, up ? KNOB_C_LOAD : KNOB_C_RELEASE);
    const Dual q = seeded(t, w->q, up ? KNOB_Q_LOAD : KNOB_Q_RELEASE);
    const Jet resistance = jet_line(c, dual_scale(w->direction, q), &t->v);
    return jet_multiply(&t->v, &resistance);
}

static void grip_along(const Way *w, const Jet slope[2], Taylor *t) {
    for (int i = 0; i < 2; i++) {
        const double r = w->params->cam[i].radius;
        const Dual mu = dual_scale(w->direction * w->flank[i],
                                   seeded(t, w->params->cam[i].friction, (Knob)(KNOB_FRICTION_1 + i)));
        t->rn[i] = jet_line(dual_scale(r * r, mu), plain(r), &slope[i]);
        t->d[i] = jet_line(plain(r), dual_scale(-1.0, mu), &slope[i]);
    }
}

/* Kinematics, and n_i, d_i; returns d gamma/dt. */
static Jet move(const Way *w, Taylor *t) {
    const Jet from_here = jet_line(plain(-t->theta.c[0].value), plain(1.0), &t->theta);
    const Jet slope[2] = {jet_polynomial(t->slope[0], JET_TERMS - 1, &from_here),
                          jet_polynomial(t->slope[1], JET_TERMS - 1, &from_here)};
    Jet sum = slope[0];
    jet_add_scaled(&sum, 1.0, &slope[1]);
    const Jet turn = jet_divide(&slope[1], &sum), lift = jet_multiply(&slope[0], &turn);
    t->z = jet_polynomial(t->height, JET_TERMS - 1, &from_here);
    t->v = jet_multiply(&lift, &t->omega);
    grip_along(w, slope, t);
    return jet_multiply(&turn, &t->omega);
}

void taylor_balance(const Way *w, Taylor *t) {
    const InertiaParams *inertia = &w->params->inertia;
    const Jet gamma_rate = move(w, t);
    t->load = spring_along(&w->params->spring, t);
    jet_add_scaled(&t->load, 1.0, &t->F_ext);
    t->twist = (Jet){.c = {{0.0, 0.0}}};
    if (t->stiffness > 0.0) t->tau = jet_line(plain(0.0), plain(t->stiffness), &t->far);
    if (t->stiffness > 0.0) jet_add_scaled(&t->tau, -t->stiffness, &t->theta);
    Jet torque = t->tau;
    if (w->kind != FLOW_QUASISTATIC) {
        const Jet damper = damper_along(w, t), alpha = jet_rate(&t->omega);
        const Jet follow = jet_rate(&t->v), twisting = jet_rate(&gamma_rate);
        jet_add_scaled(&torque, -w->params->shaft.damping, &t->omega);
        jet_add_scaled(&torque, -inertia->shaft, &alpha);
        jet_add_scaled(&t->load, 1.0, &damper);
        jet_add_scaled(&t->load, inertia->follower_mass, &follow);
        jet_add_scaled(&t->twist, inertia->follower, &twisting);
    }
    const Jet q = jet_multiply(&t->d[0], &t->rn[1]), p = jet_multiply(&t->rn[0], &t->rn[1]);
    t->delta = q;
    jet_add_product(&t->delta, 1.0, &t->rn[0], &t->d[1]);
    t->residual = jet_multiply(&t->delta, &torque);
    jet_add_product(&t->residual, -1.0, &p, &t->load);
    jet_add_product(&t->residual, -1.0, &q, &t->twist);
}

/* ---- the motion itself ---- */

/* The coefficient of R that has omega_k as its newest is linear in it, with this factor. */
static double steepness(FlowKind kind, const Partials *by, int k, double stiffness) {
    switch (kind) {
        case FLOW_INERTIAL: return by->by[KNOB_ALPHA] * k;
        case FLOW_VISCOUS: return by->by[KNOB_OMEGA];
        default: return (by->by[KNOB_THETA] - stiffness * by->by[KNOB_TAU]) / (k + 1);
    }
}

/* The value first, then, with it, the derivative by the knob. */
static void solve(const Way *w, int k, double by, Taylor *t) {
    const int shift = w->kind == FLOW_INERTIAL ? -1 : w->kind == FLOW_VISCOUS ? 0 : 1;
    const int passes = t->knob == KNOB_COUNT ? 1 : 2;
    for (int pass = 0; by != 0.0 && pass < passes; pass++) {
        taylor_balance(w, t);
        Dual *omega = &t->omega.c[k];
        *omega = dual_add(*omega, dual_scale(-1.0 / by, t->residual.c[k + shift]));
        t->theta.c[k + 1] = dual_scale(1.0 / (k + 1), *omega);
    }
}

void taylor_follow(const Way *w, const Balance *now, int last, Taylor *t) {
    const FlowKind kind = w->kind;
    Partials by;
    balance_partials(w, now, &by);
    t->omega = (Jet){.c = {{0.0, 0.0}}};
    if (kind != FLOW_QUASISTATIC) t->omega.c[0].value = now->omega;
    if (kind == FLOW_INERTIAL) t->omega.c[1].value = now->alpha;
    for (int k = 0; k < 2; k++) t->theta.c[k + 1] = dual_scale(1.0 / (k + 1), t->omega.c[k]);
    taylor_place(w, t);
    const double first = steepness(kind, &by, 0, t->stiffness);
    const bool follows = kind != FLOW_QUASISTATIC || first * by.by[KNOB_TAU] < 0.0;
    int k = kind == FLOW_INERTIAL ? 2 : 0;
    if (kind == FLOW_VISCOUS && t->knob == KNOB_COUNT) k = 1; /* omega is known, but not how it depends on the knob */
    for (; follows && k <= last; k++) solve(w, k, steepness(kind, &by, k, t->stiffness), t);
    taylor_balance(w, t);
}
