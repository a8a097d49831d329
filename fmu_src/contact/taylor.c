#include "contact/taylor.h"

#include <math.h>

static Dual plain(double value) {
    return (Dual){value, 0.0};
}

/* ---- along a given motion ---- */

static void around(const double p[TRANSMISSION_DEGREE + 1], const Jet *x, double out[JET_TERMS]) {
    const Jet value = jet_polynomial(p, TRANSMISSION_DEGREE, x);
    for (int k = 0; k < JET_TERMS; k++) out[k] = value.c[k].value;
}

void taylor_place(const SlipMode *slip, Taylor *t) {
    const TransmissionPiece *piece = slip->piece;
    const Jet x = {.c = {plain((t->theta.c[0].value - piece->middle) * piece->scale), plain(piece->scale)}};
    for (int i = 0; i < 2; i++) {
        double slope[TRANSMISSION_DEGREE + 1];
        for (int k = 0; k <= TRANSMISSION_DEGREE; k++) slope[k] = piece->slope[k][i];
        around(slope, &x, t->slope[i]);
        t->slope[i][0] = fmax(t->slope[i][0], 0.0); /* level, but for the polynomial's rounding */
    }
    around(piece->z, &x, t->height);
}

/* A parameter, and its derivative by the knob. */
static Dual seeded(const Taylor *t, double value, Known known) {
    return (Dual){value, t->known == known ? 1.0 : 0.0};
}

static Jet spring_along(const SpringParams *s, const Taylor *t) {
    const double law[] = {s->preload, s->stiffness, s->stiffness2, s->stiffness3};
    Jet force = jet_polynomial(law, 3, &t->z);
    if (t->known >= KNOWN_PRELOAD && t->known <= KNOWN_STIFFNESS3) {
        double unit[4] = {0.0};
        unit[t->known - KNOWN_PRELOAD] = 1.0;
        const Jet power = jet_polynomial(unit, 3, &t->z);
        for (int k = 0; k < JET_TERMS; k++) force.c[k].slope += power.c[k].value;
    }
    return force;
}

/* v (c + q |v|) */
static Jet damper_along(const SlipMode *slip, const Taylor *t) {
    const bool up = slip->direction > 0;
    const Dual c = seeded(t, slip->c, up ? KNOWN_C_LOAD : KNOWN_C_RELEASE);
    const Dual q = seeded(t, slip->q, up ? KNOWN_Q_LOAD : KNOWN_Q_RELEASE);
    const Jet resistance = jet_line(c, dual_scale(slip->direction, q), &t->v);
    return jet_multiply(&t->v, &resistance);
}

static void grip_along(const SlipMode *slip, const Jet slope[2], Taylor *t) {
    for (int i = 0; i < 2; i++) {
        const double r = slip->params->cam[i].radius;
        const Dual mu = dual_scale(slip->direction * slip->flank[i],
                                   seeded(t, slip->params->cam[i].friction, (Known)(KNOWN_FRICTION_1 + i)));
        t->rn[i] = jet_line(dual_scale(r * r, mu), plain(r), &slope[i]);
        t->d[i] = jet_line(plain(r), dual_scale(-1.0, mu), &slope[i]);
    }
}

/* Kinematics, and n_i, d_i; returns d gamma/dt. */
static Jet move(const SlipMode *slip, Taylor *t) {
    const Jet from_here = jet_line(plain(-t->theta.c[0].value), plain(1.0), &t->theta);
    const Jet slope[2] = {jet_polynomial(t->slope[0], JET_TERMS - 1, &from_here),
                          jet_polynomial(t->slope[1], JET_TERMS - 1, &from_here)};
    Jet sum = slope[0];
    jet_add_scaled(&sum, 1.0, &slope[1]);
    const Jet dpsi_dtheta = jet_divide(&slope[1], &sum), dz_dtheta = jet_multiply(&slope[0], &dpsi_dtheta);
    t->z = jet_polynomial(t->height, JET_TERMS - 1, &from_here);
    t->v = jet_multiply(&dz_dtheta, &t->omega);
    grip_along(slip, slope, t);
    return jet_multiply(&dpsi_dtheta, &t->omega);
}

void taylor_balance(const SlipMode *slip, Taylor *t) {
    const InertiaParams *inertia = &slip->params->inertia;
    const Jet gamma_rate = move(slip, t);
    t->load = spring_along(&slip->params->spring, t);
    jet_add_scaled(&t->load, 1.0, &t->F_ext);
    t->moment = (Jet){.c = {{0.0, 0.0}}};
    if (t->stiffness > 0.0) t->tau = jet_line(plain(0.0), plain(t->stiffness), &t->far);
    if (t->stiffness > 0.0) jet_add_scaled(&t->tau, -t->stiffness, &t->theta);
    Jet torque = t->tau;
    if (slip->regime != REGIME_RATE_INDEPENDENT) {
        const Jet damper = damper_along(slip, t), alpha = jet_rate(&t->omega);
        const Jet follow = jet_rate(&t->v), moment_along = jet_rate(&gamma_rate);
        jet_add_scaled(&torque, -slip->params->shaft.damping, &t->omega);
        jet_add_scaled(&torque, -inertia->shaft, &alpha);
        jet_add_scaled(&t->load, 1.0, &damper);
        jet_add_scaled(&t->load, inertia->follower_mass, &follow);
        jet_add_scaled(&t->moment, inertia->follower, &moment_along);
    }
    const Jet q = jet_multiply(&t->d[0], &t->rn[1]), p = jet_multiply(&t->rn[0], &t->rn[1]);
    t->delta = q;
    jet_add_product(&t->delta, 1.0, &t->rn[0], &t->d[1]);
    t->residual = jet_multiply(&t->delta, &torque);
    jet_add_product(&t->residual, -1.0, &p, &t->load);
    jet_add_product(&t->residual, -1.0, &q, &t->moment);
}

/* ---- the motion itself ---- */

/* The coefficient of R that has omega_k as its newest is linear in it, with this factor. */
static double steepness(Regime kind, const Partials *by, int k, double stiffness) {
    switch (kind) {
        case REGIME_INERTIAL: return by->by[KNOWN_ALPHA] * k;
        case REGIME_VISCOUS: return by->by[KNOWN_OMEGA];
        default: return (by->by[KNOWN_THETA] - stiffness * by->by[KNOWN_TAU]) / (k + 1);
    }
}

/* The value first, then, with it, the derivative by the knob. */
static void solve(const SlipMode *slip, int k, double by, Taylor *t) {
    const int shift = slip->regime == REGIME_INERTIAL ? -1 : slip->regime == REGIME_VISCOUS ? 0 : 1;
    const int passes = t->known == KNOWN_COUNT ? 1 : 2;
    for (int pass = 0; by != 0.0 && pass < passes; pass++) {
        taylor_balance(slip, t);
        Dual *omega = &t->omega.c[k];
        *omega = dual_add(*omega, dual_scale(-1.0 / by, t->residual.c[k + shift]));
        t->theta.c[k + 1] = dual_scale(1.0 / (k + 1), *omega);
    }
}

void taylor_follow(const SlipMode *slip, const Balance *now, int last, Taylor *t) {
    const Regime kind = slip->regime;
    Partials by;
    balance_partials(slip, now, &by);
    t->omega = (Jet){.c = {{0.0, 0.0}}};
    if (kind != REGIME_RATE_INDEPENDENT) t->omega.c[0].value = now->omega;
    if (kind == REGIME_INERTIAL) t->omega.c[1].value = now->alpha;
    for (int k = 0; k < 2; k++) t->theta.c[k + 1] = dual_scale(1.0 / (k + 1), t->omega.c[k]);
    taylor_place(slip, t);
    const double first = steepness(kind, &by, 0, t->stiffness);
    const bool follows = kind != REGIME_RATE_INDEPENDENT || first * by.by[KNOWN_TAU] < 0.0;
    int k = kind == REGIME_INERTIAL ? 2 : 0;
    if (kind == REGIME_VISCOUS && t->known == KNOWN_COUNT)
        k = 1; /* omega is known, but not how it depends on the knob */
    for (; follows && k <= last; k++) solve(slip, k, steepness(kind, &by, k, t->stiffness), t);
    taylor_balance(slip, t);
}
