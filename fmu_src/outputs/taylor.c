#include "outputs/taylor.h"

#include "elementary/elementary.h"

static Dual constant(double value) {
    return (Dual){value, 0.0};
}

/* ---- along a given motion ---- */

/* The polynomial p(x) as a polynomial in t, where x = start + rate t: its first coefficients, by Horner's scheme. */
static void expand(const double p[TRANSMISSION_DEGREE + 1], double start, double rate, double out[JET_TERMS]) {
    for (int k = 0; k < JET_TERMS; k++) out[k] = 0.0;
    for (int n = TRANSMISSION_DEGREE; n >= 0; n--) {
        for (int k = JET_TERMS - 1; k > 0; k--) out[k] = 0.0 + out[k - 1] * rate + out[k] * start;
        out[0] = out[0] * start + p[n];
    }
}

void taylor_expand_grooves(const SlipMode *slip, Taylor *t) {
    const TransmissionPiece *piece = slip->piece;
    const double start = (t->theta.c[0].value - piece->middle) * piece->scale;
    for (int i = 0; i < 2; i++) {
        double slope[TRANSMISSION_DEGREE + 1];
        for (int k = 0; k <= TRANSMISSION_DEGREE; k++) slope[k] = piece->slope[k][i];
        expand(slope, start, piece->scale, t->slope[i]);
        t->slope[i][0] = max_of(t->slope[i][0], 0.0); /* the polynomial of a level groove rounds below 0 */
    }
    expand(piece->z, start, piece->scale, t->height);
}

/* A parameter and its derivative by the known. */
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

/* The grooves along the motion. */
typedef struct {
    Jet slope[2], sum, dgamma_dtheta; /* a_i, a_1 + a_2, gamma' */
} GroovesAlong;

/* psi_i' */
static Jet dpsi_along(const GroovesAlong *g, int i) {
    return i == 0 ? g->dgamma_dtheta : jet_divide(&g->slope[0], &g->sum);
}

/* hypot(r_i, a_i) */
static Jet length_along(const SlipMode *slip, const GroovesAlong *g, int i) {
    const double r = slip->params->cam[i].radius;
    Jet length2 = jet_multiply(&g->slope[i], &g->slope[i]);
    length2.c[0].value += r * r;
    return jet_sqrt(&length2);
}

/* Where friction varies: f_i along the motion, from v_i = sigma omega psi_i' hypot(r_i, a_i) and the nominal load under
 * the force F (model/friction_law.h). */
static Jet friction_of(const SlipMode *slip, const GroovesAlong *g, const Jet *force, const Taylor *t, int i) {
    const Jet length = length_along(slip, g, i), dpsi_dtheta = dpsi_along(g, i);
    const Jet sliding = jet_multiply(&dpsi_dtheta, &length), load = jet_multiply(force, &sliding);
    const double per_sliding = slip_load_per_sliding(slip, i);
    Jet v = {.c = {{0.0, 0.0}}}, load2 = {.c = {{0.0, 0.0}}}, f = {.c = {{0.0, 0.0}}};
    if (slip->regime != REGIME_RATE_INDEPENDENT) jet_add_product(&v, slip->direction, &sliding, &t->omega);
    jet_add_product(&load2, per_sliding * per_sliding, &load, &load);
    const Jet mu = friction_along(&slip->params->cam[i], i, &v, &load2, t->known);
    jet_add_scaled(&f, slip->direction * slip->flank[i], &mu);
    return f;
}

/* The factors under the force F. */
static void factors_along(const SlipMode *slip, const GroovesAlong *g, const Jet *force, Taylor *t) {
    for (int i = 0; i < 2; i++) {
        const CamParams *cam = &slip->params->cam[i];
        const Dual mu = seeded(t, cam->friction, (Known)(KNOWN_FRICTION_1 + i));
        const bool varies = slip->friction_varies || (t->known >= KNOWN_PEAK_1 && t->known <= KNOWN_LOAD_2);
        const Jet f =
            varies ? friction_of(slip, g, force, t, i) : (Jet){.c = {dual_scale(slip->direction * slip->flank[i], mu)}};
        jet_contact_factors_set(&t->factors, i, cam->radius, &f, &g->slope[i]);
    }
    jet_contact_factors_multiply(&t->factors);
}

/* Kinematics; returns d gamma/dt. */
static Jet follow_grooves(GroovesAlong *g, Taylor *t) {
    const Jet from_here = jet_line(constant(-t->theta.c[0].value), constant(1.0), &t->theta);
    for (int i = 0; i < 2; i++) g->slope[i] = jet_polynomial(t->slope[i], JET_TERMS - 1, &from_here);
    g->sum = g->slope[0];
    jet_add_scaled(&g->sum, 1.0, &g->slope[1]);
    g->dgamma_dtheta = jet_divide(&g->slope[1], &g->sum);
    const Jet dz_dtheta = jet_multiply(&g->slope[0], &g->dgamma_dtheta);
    t->z = jet_polynomial(t->height, JET_TERMS - 1, &from_here);
    t->v = jet_multiply(&dz_dtheta, &t->omega);
    return jet_multiply(&g->dgamma_dtheta, &t->omega);
}

void taylor_balance(const SlipMode *slip, Taylor *t) {
    const InertiaParams *inertia = &slip->params->inertia;
    GroovesAlong grooves;
    const Jet gamma_rate = follow_grooves(&grooves, t);
    t->load = spring_along(&slip->params->spring, t);
    jet_add_scaled(&t->load, 1.0, &t->F_ext);
    t->moment = (Jet){.c = {{0.0, 0.0}}};
    if (t->stiffness > 0.0) t->tau = jet_line(constant(0.0), constant(t->stiffness), &t->far);
    if (t->stiffness > 0.0) jet_add_scaled(&t->tau, -t->stiffness, &t->theta);
    Jet torque = t->tau, force = t->load;
    if (slip->regime != REGIME_RATE_INDEPENDENT) {
        const Jet damper = damper_along(slip, t), alpha = jet_rate(&t->omega);
        const Jet follower_acceleration = jet_rate(&t->v), gamma_acceleration = jet_rate(&gamma_rate);
        jet_add_scaled(&torque, -slip->params->shaft.damping, &t->omega);
        jet_add_scaled(&torque, -inertia->shaft, &alpha);
        jet_add_scaled(&force, 1.0, &damper);
        jet_add_scaled(&t->load, 1.0, &damper);
        jet_add_scaled(&t->load, inertia->follower_mass, &follower_acceleration);
        jet_add_scaled(&t->moment, inertia->follower, &gamma_acceleration);
    }
    factors_along(slip, &grooves, &force, t);
    t->residual = jet_multiply(&t->factors.delta, &torque);
    jet_add_product(&t->residual, -1.0, &t->factors.p, &t->load);
    jet_add_product(&t->residual, -1.0, &t->factors.q, &t->moment);
}

/* ---- the motion itself ---- */

/* The derivative by omega_k of the coefficient of R that omega_k is found from. */
static double residual_by_speed(Regime regime, const Partials *by, int k, double stiffness) {
    switch (regime) {
        case REGIME_INERTIAL: return by->by[KNOWN_ALPHA] * k;
        case REGIME_VISCOUS: return by->by[KNOWN_OMEGA];
        default: return (by->by[KNOWN_THETA] - stiffness * by->by[KNOWN_TAU]) / (k + 1);
    }
}

/* Finds omega_k. The first pass finds the value; the second pass, with this value, the derivative by the known. */
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

void taylor_follow(const SlipMode *slip, const Balance *balance, int last, Taylor *t) {
    const Regime regime = slip->regime;
    Partials by;
    balance_partials(slip, balance, &by);
    t->omega = (Jet){.c = {{0.0, 0.0}}};
    if (regime != REGIME_RATE_INDEPENDENT) t->omega.c[0].value = balance->omega;
    if (regime == REGIME_INERTIAL) t->omega.c[1].value = balance->alpha;
    for (int k = 0; k < 2; k++) t->theta.c[k + 1] = dual_scale(1.0 / (k + 1), t->omega.c[k]);
    taylor_expand_grooves(slip, t);
    const double first = residual_by_speed(regime, &by, 0, t->stiffness);
    const bool follows = regime != REGIME_RATE_INDEPENDENT || first * by.by[KNOWN_TAU] < 0.0;
    int k = regime == REGIME_INERTIAL ? 2 : 0;
    if (regime == REGIME_VISCOUS && t->known == KNOWN_COUNT) k = 1; /* the balance gives omega_0, not its derivative */
    /* At most JET_TERMS turns. */
    for (; follows && k <= last; k++) solve(slip, k, residual_by_speed(regime, &by, k, t->stiffness), t);
    taylor_balance(slip, t);
}
