#include "contact/balance.h"

#include <math.h>

#include "contact/loaded_slip.h"
#include "contact/residual.h"

/* ---- along the motion ---- */

/* Time derivatives along the motion, and the loads that they belong to. */
typedef struct {
    double rhs;                     /* d RightHandSide.value/dt */
    double alpha, jerk;             /* rad/s^2, rad/s^3: as far as they act on the loads */
    double axial, moment;           /* N, N.m: A and W of the balance */
    double axial_rate, moment_rate; /* N/s, N.m/s */
    double spring_rate, F_ext_rate; /* N/s: dF_s/dt, dF_ext/dt */
    double damper_by_speed;         /* N.s/m: dD/dv */
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
        .spring_rate = spring_rate(&p->spring, balance->z) * v,
        .damper_by_speed = slip_damper_rate(slip, v),
        .F_ext_rate = in->F_ext_rate,
    };
    d.alpha = inertial ? balance->alpha : d.rhs;
    d.jerk = inertial ? d.rhs : 0.0;
    const double follower_acceleration = k->dz_dtheta.value * d.alpha + k->d2z_dtheta2.value * omega2; /* d^2 z/dt^2 */
    d.axial = balance->force + balance->damper + m * (inertial ? follower_acceleration : 0.0);
    d.moment = I * (k->dpsi_dtheta[0].value * balance->alpha + k->d2gamma_dtheta2.value * omega2);
    d.axial_rate = d.spring_rate + d.F_ext_rate + d.damper_by_speed * follower_acceleration +
                   m * (k->dz_dtheta.value * d.jerk + 3.0 * k->d2z_dtheta2.value * omega * d.alpha +
                        k->d2z_dtheta2.slope * omega2 * omega);
    d.moment_rate = I * (k->dpsi_dtheta[0].value * d.jerk + 3.0 * k->d2gamma_dtheta2.value * omega * d.alpha +
                         k->d2gamma_dtheta2.slope * omega2 * omega);
    return d;
}

/* ---- sizes ---- */

/* Sums of the magnitudes of the terms: the rounding error of each quantity is a few eps of its size. */
typedef struct {
    double force, torque, rhs; /* N, N.m, rad/s^2 */
    double axial, moment;      /* N, N.m */
    double axial_rate, moment_rate;
} Sizes;

/* Of P, which vanishes on a dwell or where a contact begins to lock. */
static double p_size(const SlipMode *slip, const SlipCoefficients *k) {
    double size = 1.0;
    for (int i = 0; i < 2; i++) {
        const CamParams *cam = &slip->params->cam[i];
        const double rounded = TRANSMISSION_TERM_SHARE * slip->transmission->steepest[i];
        size *= cam->radius * (k->slope[i].value + fabs(slip_friction(slip, k, i)) * cam->radius + rounded);
    }
    return size;
}

/* m, what counts as a term of z beside z. */
static double z_rounding(const SlipMode *slip) {
    return TRANSMISSION_TERM_SHARE * slip->transmission->z_size;
}

static double force_size(const SlipMode *slip, const Balance *balance) {
    const SpringParams *spring = &slip->params->spring;
    return fabs(spring->preload) + fabs(balance->F_ext) + fabs(balance->damper) +
           spring_terms(spring, balance->z, z_rounding(slip));
}

/* Of alpha. */
static double rhs_size(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance, const Sizes *size) {
    const InertiaParams *inertia = &slip->params->inertia;
    const DualContactFactors *f = &k->factors;
    const double by_speed = (fabs(f->p.value) * inertia->follower_mass * fabs(k->d2z_dtheta2.value) +
                             fabs(f->q.value) * inertia->follower * fabs(k->d2gamma_dtheta2.value)) *
                            (balance->omega * balance->omega);
    return (fabs(f->delta.value) * size->torque + fabs(f->p.value) * size->force + by_speed) /
           fabs(balance->rhs.resistance);
}

static Sizes sizes_of(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance,
                      const MotionRates *rates) {
    const Params *p = slip->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower;
    const double omega = fabs(balance->omega), omega2 = omega * omega;
    const double dz_dtheta = fabs(k->dz_dtheta.value), d2z_dtheta2 = fabs(k->d2z_dtheta2.value);
    const double dgamma_dtheta = fabs(k->dpsi_dtheta[0].value), d2gamma_dtheta2 = fabs(k->d2gamma_dtheta2.value);
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const RightHandSide *rhs = &balance->rhs;
    Sizes size = {.force = force_size(slip, balance), .torque = fabs(balance->tau) + p->shaft.damping * omega};
    if (inertial) size.rhs = rhs_size(slip, k, balance, &size);
    const double alpha = inertial ? size.rhs : fabs(rates->alpha);
    const double jerk =
        inertial ? fabs(rhs->by_theta) * omega + fabs(rhs->by_omega) * size.rhs + fabs(rhs->by_time) : 0.0;
    size.axial = size.force + m * (dz_dtheta * size.rhs + d2z_dtheta2 * omega2);
    size.moment = I * (dgamma_dtheta * size.rhs + d2gamma_dtheta2 * omega2);
    size.axial_rate = spring_rate_terms(&p->spring, balance->z, z_rounding(slip)) * dz_dtheta * omega +
                      fabs(rates->F_ext_rate) + rates->damper_by_speed * (dz_dtheta * alpha + d2z_dtheta2 * omega2) +
                      m * (dz_dtheta * jerk + 3.0 * d2z_dtheta2 * omega * alpha);
    size.moment_rate = I * (dgamma_dtheta * jerk + 3.0 * d2gamma_dtheta2 * omega * alpha);
    return size;
}

/* ---- contact loads ---- */

/* Of r_i n_i = r_i (a_i + f_i r_i), whose terms cancel where a contact begins to lock at the speed. */
static double rn_terms(const SlipMode *slip, const SlipCoefficients *k, int i) {
    const double r = slip->params->cam[i].radius;
    return r * (fabs(k->slope[i].value) + fabs(slip_friction(slip, k, i)) * r);
}

/* Rounding of d x_i/dt as a motion begins under friction by load and speed: the speed changes f_i, and f_i changes x_i in
 * proportion to the loads. `size`: of x_i. In motion a change of flanks is an event, whose location the rate does not tell. */
static double friction_rate_size(const SlipMode *slip, const SlipCoefficients *k, const MotionRates *rates, int i,
                                 double size) {
    const DualContactFactors *f = &k->factors;
    const LoadStep by_speed = {.omega = rates->alpha};
    const double rate = loaded_slip_response(slip, 0.0, k, &by_speed).x[i];
    const double terms = fabs(f->rn[1 - i].value * rates->axial) + fabs(f->d[1 - i].value * rates->moment);
    return terms > 0.0 ? fabs(rate) * size * fabs(f->delta.value) / terms : 0.0;
}

/* d x_i/dt from x_1 = (r_2 n_2 A - d_2 W)/Delta and x_2 = (r_1 n_1 A + d_1 W)/Delta, and the sizes of both. */
static void contact_rates(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance,
                          const MotionRates *rates, const Sizes *size, int i, BalanceRates *out) {
    const DualContactFactors *f = &k->factors;
    const int other = 1 - i;
    const double omega = balance->omega, inverse = 1.0 / fabs(f->delta.value);
    const Dual rn = f->rn[other], signed_d = dual_scale(i == 0 ? -1.0 : 1.0, f->d[other]);
    const double rounded = slip->params->cam[other].radius * slip->transmission->steepest[other];
    double rn_size = fabs(rn.value) + rounded;
    const double rn_rate_size = fabs(rn.slope) + rounded * slip->piece->scale;
    if (slip->friction_varies) rn_size += rn_terms(slip, k, other);
    out->contact[i] =
        (rn.slope * omega * rates->axial + rn.value * rates->axial_rate + signed_d.slope * omega * rates->moment +
         signed_d.value * rates->moment_rate - balance->x[i] * f->delta.slope * omega) /
        f->delta.value;
    out->size[i] = (rn_size * size->axial + fabs(signed_d.value) * size->moment) * inverse;
    out->rate_size[i] = (rn_rate_size * fabs(omega) * size->axial + fabs(rn.value) * size->axial_rate +
                         fabs(signed_d.slope * omega) * size->moment + fabs(signed_d.value) * size->moment_rate +
                         out->size[i] * fabs(f->delta.slope * omega)) *
                        inverse;
    if (!slip->friction_varies) return;
    if (slip->friction_is_loaded) {
        const LoadStep step = {
            .theta = omega, .omega = rates->alpha, .axial = rates->axial_rate, .moment = rates->moment_rate};
        out->contact[i] = loaded_slip_response(slip, omega, k, &step).x[i];
        out->rate_size[i] += fabs(out->contact[i]);
        if (omega == 0.0) out->rate_size[i] += friction_rate_size(slip, k, rates, i, out->size[i]);
        return;
    }
    const ContactFactors *by = &k->dfactors_domega;
    const double by_friction =
        contact_load_by_factors(k, by, i, rates->axial, rates->moment, balance->x[i]) * rates->alpha;
    out->contact[i] += by_friction;
    out->rate_size[i] +=
        (fabs(by->rn[other]) * size->axial + fabs(by->d[other]) * size->moment + out->size[i] * fabs(by->delta)) *
        inverse * fabs(rates->alpha);
}

/* rho of the net torque. Without inertia the speed that the balance has found adds friction, which acts as a damper:
 * the torque beyond the band counts against friction at rest. */
static double holding_lever(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance) {
    if (!slip->friction_varies || slip->regime != REGIME_VISCOUS) return k->factors.p.value / k->factors.delta.value;
    SlipCoefficients at_rest = *k;
    const LoadedMotion rest = {.z = balance->z, .force = balance->force, .F_ext = balance->F_ext};
    if (slip->friction_is_loaded) loaded_slip_set_under(slip, &rest, &at_rest);
    else slip_set_friction(slip, 0.0, &at_rest);
    return at_rest.factors.p.value / at_rest.factors.delta.value;
}

/* Reactions round as the balance with the tangent factors does (loaded_slip.h). */
static void use_tangents(SlipCoefficients *k) {
    const ContactFactors *tangent = &k->loaded.tangent;
    DualContactFactors *f = &k->factors;
    for (int i = 0; i < 2; i++) {
        f->rn[i].value = tangent->rn[i];
        f->d[i].value = tangent->d[i];
    }
    f->delta.value = tangent->delta;
    f->p.value = tangent->p;
    f->q.value = tangent->q;
}

void balance_rates(const SlipMode *slip, const Balance *balance, double t, BalanceRates *out) {
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, balance->theta, balance->omega, &storage, &z);
    const LoadedMotion motion = balance_loaded_motion(balance, z);
    if (slip->friction_is_loaded) loaded_slip_set_under(slip, &motion, &storage);
    const double lever = holding_lever(slip, k, balance);
    if (slip->friction_is_loaded && slip->regime == REGIME_INERTIAL) use_tangents(&storage);
    const DualContactFactors *f = &k->factors;
    const InputValues in = slip_inputs_at(slip, t);
    const MotionRates rates = motion_rates_of(slip, k, &in, balance);
    const Sizes size = sizes_of(slip, k, balance, &rates);
    const double shaft_torque = slip->regime == REGIME_INERTIAL ? slip->params->shaft.damping * balance->omega : 0.0;
    *out = (BalanceRates){
        .rhs = rates.rhs,
        .rhs_size = size.rhs,
        .net = balance->tau - shaft_torque - lever * balance->force,
        .net_size = size.torque + p_size(slip, k) / fabs(f->delta.value) * size.force,
    };
    for (int i = 0; i < 2; i++) contact_rates(slip, k, balance, &rates, &size, i, out);
}
