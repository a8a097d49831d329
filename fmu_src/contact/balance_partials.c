#include "contact/balance.h"

#include <math.h>

#include "contact/residual.h"

static MotionTerms terms_of(const SlipMode *slip, const Balance *balance) {
    return (MotionTerms){
        .torque = balance->tau - slip->params->shaft.damping * balance->omega,
        .load = balance->force + balance->damper,
        .omega = balance->omega,
        .alpha = balance->alpha,
    };
}

/* By the friction coefficient of contact i. */
static double partial_by_friction(const SlipMode *slip, const SlipCoefficients *k, const MotionTerms *terms, int i) {
    double df[2] = {0.0, 0.0};
    df[i] = slip->direction * slip->flank[i];
    const ContactFactors by = slip_factors_by(slip, k, df);
    return residual_change(slip, k, &by, terms);
}

/* d mu_i/d known, at constant speed and load. */
static double friction_by(const SlipMode *slip, const SlipCoefficients *k, const Balance *b, int i, Known known) {
    const CamParams *cam = &slip->params->cam[i];
    const double length = sqrt(cam->radius * cam->radius + k->slope[i].value * k->slope[i].value);
    const double sliding = k->dpsi_dtheta[i].value * length;
    const double load = (b->force + b->damper) * sliding * slip_load_per_sliding(slip, i);
    const double omega = slip->regime == REGIME_RATE_INDEPENDENT ? 0.0 : b->omega;
    const Jet v = {.c = {{slip->direction * omega * sliding, 0.0}}}, load2 = {.c = {{load * load, 0.0}}};
    return friction_along(cam, i, &v, &load2, known).c[0].slope;
}

/* By the parameters of the friction law of contact i; from `by_friction`, the derivative by its coefficient. */
static void partials_by_law(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance, int i,
                            double by_friction, Partials *out) {
    static const Known FIRST[] = {KNOWN_FRICTION_1, KNOWN_PEAK_1,          KNOWN_STRIBECK_VELOCITY_1,
                                  KNOWN_VISCOUS_1,  KNOWN_LOAD_EXPONENT_1, KNOWN_LOAD_1};
    for (size_t n = 0; n < sizeof FIRST / sizeof FIRST[0]; n++) {
        const Known known = (Known)(FIRST[n] + (Known)i);
        out->by[known] = by_friction * friction_by(slip, k, balance, i, known);
    }
}

double balance_force_by(const SlipMode *slip, Known known, double factor, double z, double v) {
    const bool rises = slip->direction > 0;
    switch (known) {
        case KNOWN_F_EXT:
        case KNOWN_PRELOAD: return factor;
        case KNOWN_STIFFNESS: return factor * z;
        case KNOWN_STIFFNESS2: return factor * z * z;
        case KNOWN_STIFFNESS3: return factor * z * z * z;
        case KNOWN_C_LOAD: return rises ? factor * v : 0.0;
        case KNOWN_Q_LOAD: return rises ? factor * v * fabs(v) : 0.0;
        case KNOWN_C_RELEASE: return rises ? 0.0 : factor * v;
        case KNOWN_Q_RELEASE: return rises ? 0.0 : factor * v * fabs(v);
        default: return 0.0;
    }
}

void balance_partials(const SlipMode *slip, const Balance *balance, Partials *out) {
    const Params *p = slip->params;
    const double b = p->shaft.damping, omega = balance->omega;
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, balance->theta, omega, balance->F_ext, &storage, &z);
    const DualContactFactors *f = &k->factors;
    const MotionTerms terms = terms_of(slip, balance);
    const double v = k->dz_dtheta.value * omega;
    const double damper_rate = slip_damper_rate(slip, v);
    const double load_slope =
        spring_rate(&p->spring, z) * k->dz_dtheta.value + damper_rate * k->dz_dtheta.slope * omega;
    const Dual by_speed = slip_inertia_by_speed(slip, k), inertia = slip_inertia(slip, k);
    const double by_load = slip->friction_varies ? residual_change(slip, k, &k->dfactors_dload, &terms) : 0.0;
    double *by = out->by;
    *out = (Partials){.by = {0.0}};
    by[KNOWN_THETA] = f->delta.slope * terms.torque - f->p.slope * terms.load - f->p.value * load_slope -
                      by_speed.slope * (omega * omega) - inertia.slope * balance->alpha;
    by[KNOWN_OMEGA] =
        -f->delta.value * b - f->p.value * damper_rate * k->dz_dtheta.value - 2.0 * by_speed.value * omega;
    by[KNOWN_ALPHA] = -inertia.value;
    by[KNOWN_TAU] = f->delta.value;
    for (int known = KNOWN_F_EXT; known < KNOWN_COUNT; known++)
        by[known] = balance_force_by(slip, (Known)known, by_load - f->p.value, z, v);
    for (int i = 0; i < 2; i++) {
        by[KNOWN_FRICTION_1 + i] = partial_by_friction(slip, k, &terms, i);
        partials_by_law(slip, k, balance, i, by[KNOWN_FRICTION_1 + i], out);
    }
    if (slip->friction_varies) by[KNOWN_OMEGA] += residual_change(slip, k, &k->dfactors_domega, &terms);
}

void balance_response(const SlipMode *slip, const Balance *balance, Partials *out) {
    const Known own = slip->regime == REGIME_INERTIAL ? KNOWN_ALPHA : KNOWN_OMEGA;
    Partials residual;
    balance_partials(slip, balance, &residual);
    *out = (Partials){.by = {0.0}};
    for (int known = 0; known < KNOWN_COUNT; known++)
        if (known != (int)own) out->by[known] = -residual.by[known] / residual.by[own];
}

BalanceChange balance_change_by(const SlipMode *slip, const Balance *b, Known known) {
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, b->theta, b->omega, b->F_ext, &storage, &z);
    BalanceChange change = {.axial = balance_force_by(slip, known, 1.0, z, k->dz_dtheta.value * b->omega)};
    for (int i = 0; i < 2; i++)
        change.friction[i] = slip->direction * slip->flank[i] * friction_by(slip, k, b, i, known);
    return change;
}

/* The change of the acceleration k alpha + k' omega^2, with k = z' or gamma' and `k_rate` k'. */
static double acceleration_change(const Balance *b, Dual k, Dual k_rate, const BalanceChange *c) {
    const double omega2 = b->omega * b->omega;
    return (k.slope * b->alpha + k_rate.slope * omega2) * c->theta + 2.0 * k_rate.value * b->omega * c->omega +
           k.value * c->alpha;
}

/* x_i = (r n A -+ d W)/Delta with n and d of the other contact, see balance.h. */
void balance_contact_changes(const SlipMode *slip, const Balance *b, const BalanceChange *c, double change[2]) {
    const Params *p = slip->params;
    SlipCoefficients storage;
    double z, df[2] = {c->friction[0], c->friction[1]};
    const SlipCoefficients *k = slip_coefficients_at(slip, b->theta, b->omega, b->F_ext, &storage, &z);
    const DualContactFactors *f = &k->factors;
    const Loads load = loads_of(slip, k, b->force + b->damper, b->omega, b->alpha);
    const double damper_rate = slip_damper_rate(slip, k->dz_dtheta.value * b->omega);
    const double axial = c->axial + spring_rate(&p->spring, z) * k->dz_dtheta.value * c->theta +
                         damper_rate * (k->dz_dtheta.slope * b->omega * c->theta + k->dz_dtheta.value * c->omega) +
                         p->inertia.follower_mass * acceleration_change(b, k->dz_dtheta, k->d2z_dtheta2, c);
    const double moment = p->inertia.follower * acceleration_change(b, k->dpsi_dtheta[0], k->d2gamma_dtheta2, c);
    for (int i = 0; slip->friction_varies && i < 2; i++)
        df[i] += k->dfriction_domega[i] * c->omega + k->dfriction_dload[i] * c->axial;
    const ContactFactors by = slip_factors_by(slip, k, df); /* and by theta: */
    for (int i = 0; i < 2; i++) {
        const int j = 1 - i;
        const double rn = f->rn[j].slope * c->theta + by.rn[j], d = f->d[j].slope * c->theta + by.d[j];
        const double by_moment = f->d[j].value * moment + d * load.moment;
        change[i] = (f->rn[j].value * axial + rn * load.axial + (i == 0 ? -by_moment : by_moment) -
                     b->x[i] * (f->delta.slope * c->theta + by.delta)) /
                    f->delta.value;
    }
}

void balance_rates(const SlipMode *slip, const Balance *b, double t, BalanceRates *out) {
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const double by_theta = slip->regime == REGIME_RATE_INDEPENDENT ? 0.0 : b->rhs.by_theta;
    out->rhs = b->rhs.by_time + by_theta * b->omega + b->rhs.by_omega * b->alpha;
    const BalanceChange along = {
        .theta = b->omega,
        .omega = inertial ? b->alpha : out->rhs,
        .alpha = inertial ? out->rhs : 0.0,
        .axial = slip_inputs_at(slip, t).F_ext_rate,
    };
    balance_contact_changes(slip, b, &along, out->contact);
}

/* ---- sizes ---- */

/* Sums of the magnitudes of the terms of A and W. */
typedef struct {
    double axial, moment; /* N, N.m */
} LoadSizes;

/* rad/s^2, of alpha. */
static double alpha_size(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance, double force) {
    const InertiaParams *inertia = &slip->params->inertia;
    const DualContactFactors *f = &k->factors;
    const double by_speed = (fabs(f->p.value) * inertia->follower_mass * fabs(k->d2z_dtheta2.value) +
                             fabs(f->q.value) * inertia->follower * fabs(k->d2gamma_dtheta2.value)) *
                            (balance->omega * balance->omega);
    const double torque = fabs(balance->tau) + slip->params->shaft.damping * fabs(balance->omega);
    return (fabs(f->delta.value) * torque + fabs(f->p.value) * force + by_speed) / fabs(slip_inertia(slip, k).value);
}

static LoadSizes load_sizes(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance) {
    const Params *p = slip->params;
    const double z_rounding = TRANSMISSION_TERM_SHARE * slip->transmission->z_size; /* counts as a term beside z */
    const double force = fabs(p->spring.preload) + fabs(balance->F_ext) + fabs(balance->damper) +
                         spring_terms(&p->spring, balance->z, z_rounding);
    if (!slip->follower_has_inertia || slip->regime != REGIME_INERTIAL) return (LoadSizes){force, 0.0};
    const double alpha = alpha_size(slip, k, balance, force), omega2 = balance->omega * balance->omega;
    return (LoadSizes){
        force + p->inertia.follower_mass * (fabs(k->dz_dtheta.value) * alpha + fabs(k->d2z_dtheta2.value) * omega2),
        p->inertia.follower * (fabs(k->dpsi_dtheta[0].value) * alpha + fabs(k->d2gamma_dtheta2.value) * omega2),
    };
}

/* m^2: r_i n_i = r_i (a_i + f_i r_i), whose terms cancel where a contact begins to lock, with the rounding of a_i. */
static double lever_size(const SlipMode *slip, const SlipCoefficients *k, int i) {
    const double r = slip->params->cam[i].radius, rounded = r * slip->transmission->steepest[i];
    if (!slip->friction_varies) return fabs(k->factors.rn[i].value) + rounded;
    return fabs(k->factors.rn[i].value) + rounded + r * (fabs(k->slope[i].value) + fabs(k->friction[i]) * r);
}

void balance_contact_sizes(const SlipMode *slip, const Balance *balance, double size[2]) {
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k =
        slip_coefficients_at(slip, balance->theta, balance->omega, balance->F_ext, &storage, &z);
    const LoadSizes load = load_sizes(slip, k, balance);
    for (int i = 0; i < 2; i++)
        size[i] = (lever_size(slip, k, 1 - i) * load.axial + fabs(k->factors.d[1 - i].value) * load.moment) /
                  fabs(k->factors.delta.value);
}
