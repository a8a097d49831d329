#include "contact/balance.h"

#include <math.h>

#include "contact/residual.h"

/* ---- along the motion ---- */

/* Time derivatives along the motion, and the loads that they belong to. */
typedef struct {
    double rhs;                     /* d RightHandSide.value/dt */
    double alpha;                   /* rad/s^2: d omega/dt */
    double axial, moment;           /* N, N.m: A and W of the balance */
    double axial_rate, moment_rate; /* N/s, N.m/s */
    double F_ext_rate;              /* N/s */
} MotionRates;

static MotionRates motion_rates_of(const SlipMode *slip, const SlipCoefficients *k, const InputValues *in,
                                   const Balance *balance) {
    const Params *p = slip->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower;
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const double omega = balance->omega, omega2 = omega * omega, v = k->dz_dtheta.value * omega;
    MotionRates d = {
        .rhs = balance->rhs.by_time + (slip->regime == REGIME_RATE_INDEPENDENT ? 0.0 : balance->rhs.by_theta * omega) +
               balance->rhs.by_omega * balance->alpha,
        .F_ext_rate = in->F_ext_rate,
    };
    d.alpha = inertial ? balance->alpha : d.rhs;
    const double jerk = inertial ? d.rhs : 0.0; /* as far as a mass acts */
    const double follower_acceleration = k->dz_dtheta.value * d.alpha + k->d2z_dtheta2.value * omega2; /* d^2 z/dt^2 */
    d.axial = balance->force + balance->damper + m * (inertial ? follower_acceleration : 0.0);
    d.moment = I * (k->dpsi_dtheta[0].value * balance->alpha + k->d2gamma_dtheta2.value * omega2);
    d.axial_rate = spring_rate(&p->spring, balance->z) * v + d.F_ext_rate +
                   slip_damper_rate(slip, v) * follower_acceleration +
                   m * (k->dz_dtheta.value * jerk + 3.0 * k->d2z_dtheta2.value * omega * d.alpha +
                        k->d2z_dtheta2.slope * omega2 * omega);
    d.moment_rate = I * (k->dpsi_dtheta[0].value * jerk + 3.0 * k->d2gamma_dtheta2.value * omega * d.alpha +
                         k->d2gamma_dtheta2.slope * omega2 * omega);
    return d;
}

/* The time derivative of the factors through the friction coefficients, at constant theta. */
static ContactFactors factors_rate_by_friction(const SlipMode *slip, const SlipCoefficients *k,
                                               const MotionRates *rates) {
    const CamParams *cam = slip->params->cam;
    const double radius[2] = {cam[0].radius, cam[1].radius}, slope[2] = {k->slope[0].value, k->slope[1].value};
    double rate[2];
    for (int i = 0; i < 2; i++)
        rate[i] = k->dfriction_domega[i] * rates->alpha + k->dfriction_dload[i] * rates->F_ext_rate;
    const ContactFactors values = dual_contact_factors_values(&k->factors);
    return contact_factors_change(&values, radius, slope, rate);
}

/* d x_i/dt from x_1 = (r_2 n_2 A - d_2 W)/Delta and x_2 = (r_1 n_1 A + d_1 W)/Delta. */
static double contact_rate(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance,
                           const MotionRates *rates, int i) {
    const DualContactFactors *f = &k->factors;
    const double omega = balance->omega;
    const Dual rn = f->rn[1 - i], signed_d = dual_scale(i == 0 ? -1.0 : 1.0, f->d[1 - i]);
    const double rate =
        (rn.slope * omega * rates->axial + rn.value * rates->axial_rate + signed_d.slope * omega * rates->moment +
         signed_d.value * rates->moment_rate - balance->x[i] * f->delta.slope * omega) /
        f->delta.value;
    if (!slip->friction_varies) return rate;
    const ContactFactors by_friction = factors_rate_by_friction(slip, k, rates);
    return rate + contact_load_by_factors(k, &by_friction, i, rates->axial, rates->moment, balance->x[i]);
}

void balance_rates(const SlipMode *slip, const Balance *balance, double t, BalanceRates *out) {
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k =
        slip_coefficients_at(slip, balance->theta, balance->omega, balance->F_ext, &storage, &z);
    const InputValues in = slip_inputs_at(slip, t);
    const MotionRates rates = motion_rates_of(slip, k, &in, balance);
    out->rhs = rates.rhs;
    for (int i = 0; i < 2; i++) out->contact[i] = contact_rate(slip, k, balance, &rates, i);
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
    return (fabs(f->delta.value) * torque + fabs(f->p.value) * force + by_speed) / fabs(balance->rhs.resistance);
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
