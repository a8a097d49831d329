#include "contact/balance.h"

#include <math.h>

#include "contact/residual.h"
#include "platform/attributes.h"

static MotionTerms terms_of(const SlipMode *slip, const Balance *balance) {
    return (MotionTerms){
        .torque = balance->tau - slip->params->shaft.damping * balance->omega,
        .load = balance->force + balance->damper,
        .omega = balance->omega,
        .alpha = balance->alpha,
    };
}

/* By the friction coefficient of contact i. */
static double partial_by_friction(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance, int i) {
    const CamParams *cam = slip->params->cam;
    const double radius[2] = {cam[0].radius, cam[1].radius}, slope[2] = {k->slope[0].value, k->slope[1].value};
    double df[2] = {0.0, 0.0};
    df[i] = slip->direction * slip->flank[i];
    const ContactFactors values = dual_contact_factors_values(&k->factors);
    const ContactFactors by = contact_factors_change(&values, radius, slope, df);
    const MotionTerms terms = terms_of(slip, balance);
    return residual_change(slip, k, &by, &terms);
}

/* d mu_i/d known, at constant speed and load. */
static double friction_by(const SlipMode *slip, const SlipCoefficients *k, const Balance *b, int i, Known known) {
    const CamParams *cam = &slip->params->cam[i];
    const double length = sqrt(cam->radius * cam->radius + k->slope[i].value * k->slope[i].value);
    const double sliding = k->dpsi_dtheta[i].value * length;
    const double load = (b->force + b->damper) * sliding / (slip->params->contacts * cam->radius);
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
    const double b = p->shaft.damping, omega = balance->omega, torque = balance->tau - b * omega;
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, balance->theta, omega, balance->F_ext, &storage, &z);
    const DualContactFactors *f = &k->factors;
    const MotionTerms terms = terms_of(slip, balance);
    const double v = k->dz_dtheta.value * omega, load = balance->force + balance->damper;
    const double damper_rate = slip_damper_rate(slip, v);
    const double load_slope =
        spring_rate(&p->spring, z) * k->dz_dtheta.value + damper_rate * k->dz_dtheta.slope * omega;
    const Dual by_speed = slip_inertia_by_speed(slip, k), inertia = slip_inertia(slip, k);
    const double by_load = slip->friction_varies ? residual_change(slip, k, &k->dfactors_dload, &terms) : 0.0;
    double *by = out->by;
    *out = (Partials){.by = {0.0}};
    by[KNOWN_THETA] = f->delta.slope * torque - f->p.slope * load - f->p.value * load_slope -
                      by_speed.slope * (omega * omega) - inertia.slope * balance->alpha;
    by[KNOWN_OMEGA] =
        -f->delta.value * b - f->p.value * damper_rate * k->dz_dtheta.value - 2.0 * by_speed.value * omega;
    by[KNOWN_ALPHA] = -inertia.value;
    by[KNOWN_TAU] = f->delta.value;
    for (int known = KNOWN_F_EXT; known < KNOWN_COUNT; known++)
        by[known] = balance_force_by(slip, (Known)known, by_load - f->p.value, z, v);
    for (int i = 0; i < 2; i++) {
        by[KNOWN_FRICTION_1 + i] = partial_by_friction(slip, k, balance, i);
        partials_by_law(slip, k, balance, i, by[KNOWN_FRICTION_1 + i], out);
    }
    if (slip->friction_varies) by[KNOWN_OMEGA] += residual_change(slip, k, &k->dfactors_domega, &terms);
}

/* ---- loads of a known motion ---- */

/* x_i from two of the three equations d_1 x_1 + d_2 x_2 = A, r_1 n_1 x_1 = T - W, r_2 n_2 x_2 = T. Near a jam Delta,
 * the determinant of the axial balance and the difference of the moments, is small; the determinant P of both moments
 * is small where a contact is about to lock. The larger one, as a share of its terms, loses fewer digits. */
static void solve_loads(const DualContactFactors *f, double axial, double torque, double moment, double x[2]) {
    const double rn[2] = {f->rn[0].value, f->rn[1].value}, d[2] = {f->d[0].value, f->d[1].value};
    const double delta_terms = fabs(d[0] * rn[1]) + fabs(rn[0] * d[1]);
    const double p_terms = (fabs(rn[0]) + fabs(d[0])) * (fabs(rn[1]) + fabs(d[1]));
    if (fabs(f->delta.value) * p_terms >= fabs(f->p.value) * delta_terms) {
        x[0] = (rn[1] * axial - d[1] * moment) / f->delta.value;
        x[1] = (rn[0] * axial + d[0] * moment) / f->delta.value;
    } else {
        x[0] = (torque - moment) / rn[0];
        x[1] = torque / rn[1];
    }
}

void balance_set_motion(const SlipMode *slip, double theta, double omega, double alpha, Balance *b) {
    const Params *p = slip->params;
    const InertiaParams *in = &p->inertia;
    SlipCoefficients storage;
    const SlipCoefficients *k = slip_coefficients_at(slip, theta, omega, b->F_ext, &storage, &b->z);
    const DualContactFactors *f = &k->factors;
    b->theta = theta;
    b->omega = omega;
    b->alpha = alpha;
    b->dz_dtheta = k->dz_dtheta.value;
    b->force = spring_force(&p->spring, b->z) + b->F_ext;
    b->damper = slip_damper_force(slip, b->dz_dtheta * omega);
    const double torque = b->tau - p->shaft.damping * omega - in->shaft * alpha;
    const double follower_acceleration = b->dz_dtheta * alpha + k->d2z_dtheta2.value * omega * omega;
    const double axial = b->force + b->damper + in->follower_mass * follower_acceleration;
    const double moment = in->follower * (k->dpsi_dtheta[0].value * alpha + k->d2gamma_dtheta2.value * omega * omega);
    solve_loads(f, axial, torque, moment, b->x);
    for (int i = 0; i < 2; i++) {
        b->dpsi_dtheta[i] = k->dpsi_dtheta[i].value;
        b->friction[i] = slip_friction(slip, k, i);
        b->axial[i] = f->rn[1 - i].value / f->delta.value;
        b->length2[i] = p->cam[i].radius * p->cam[i].radius + k->slope[i].value * k->slope[i].value;
    }
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
double balance_contact_change(const SlipMode *slip, const Balance *balance, int i, const BalanceChange *c) {
    const Params *p = slip->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower, omega = balance->omega, alpha = balance->alpha;
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, balance->theta, omega, balance->F_ext, &storage, &z);
    const DualContactFactors *f = &k->factors;
    const Dual rn = f->rn[1 - i], signed_d = dual_scale(i == 0 ? -1.0 : 1.0, f->d[1 - i]);
    const double follower_acceleration = k->dz_dtheta.value * alpha + k->d2z_dtheta2.value * omega * omega;
    const double axial = balance->force + balance->damper + m * follower_acceleration;
    const double moment = I * (k->dpsi_dtheta[0].value * alpha + k->d2gamma_dtheta2.value * omega * omega);
    const double damper_rate = slip_damper_rate(slip, k->dz_dtheta.value * omega);
    const double axial_change = c->axial + spring_rate(&p->spring, z) * k->dz_dtheta.value * c->theta +
                                damper_rate * (k->dz_dtheta.slope * omega * c->theta + k->dz_dtheta.value * c->omega) +
                                m * acceleration_change(balance, k->dz_dtheta, k->d2z_dtheta2, c);
    const double moment_change = I * acceleration_change(balance, k->dpsi_dtheta[0], k->d2gamma_dtheta2, c);
    const double radius[2] = {p->cam[0].radius, p->cam[1].radius}, slope[2] = {k->slope[0].value, k->slope[1].value};
    double df[2];
    for (int j = 0; j < 2; j++) {
        df[j] = c->friction[j];
        if (slip->friction_varies) df[j] += k->dfriction_domega[j] * c->omega + k->dfriction_dload[j] * c->axial;
    }
    const ContactFactors values = dual_contact_factors_values(f);
    const ContactFactors by = contact_factors_change(&values, radius, slope, df);
    return contact_load_by_factors(k, &by, i, axial, moment, balance->x[i]) +
           (rn.value * axial_change + signed_d.value * moment_change +
            (rn.slope * axial + signed_d.slope * moment - balance->x[i] * f->delta.slope) * c->theta) /
               f->delta.value;
}
