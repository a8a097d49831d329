#include "contact/balance.h"

#include <math.h>

#include "platform/attributes.h"

/* By the friction coefficient of contact i. */
static double partial_by_friction(const SlipMode *slip, const SlipCoefficients *k, const Balance *balance, int i) {
    const InertiaParams *inertia = &slip->params->inertia;
    const double J = inertia->shaft, m = inertia->follower_mass, I = inertia->follower;
    const double torque = balance->tau - slip->params->shaft.damping * balance->omega;
    const double load = balance->force + balance->damper, omega2 = balance->omega * balance->omega;
    const DualContactFactors by = dual_contact_factors_by_friction(&k->factors, i, slip->params->cam[i].radius,
                                                                   slip->direction * slip->flank[i], k->slope[i].value);
    const double delta = by.delta.slope, p = by.p.slope, q = by.q.slope;
    const double inertia_by = J * delta + m * p * k->dz_dtheta.value + I * q * k->dpsi_dtheta[0].value;
    const double inertia_by_speed_by = m * p * k->d2z_dtheta2.value + I * q * k->d2gamma_dtheta2.value;
    return delta * torque - p * load - inertia_by_speed_by * omega2 - inertia_by * balance->alpha;
}

void balance_partials(const SlipMode *slip, const Balance *balance, Partials *out) {
    const Params *p = slip->params;
    const double b = p->shaft.damping, omega = balance->omega, torque = balance->tau - b * omega;
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, balance->theta, &storage, &z);
    const DualContactFactors *f = &k->factors;
    const double v = k->dz_dtheta.value * omega, load = balance->force + balance->damper;
    const double damper_rate = slip_damper_rate(slip, v);
    const double load_slope =
        spring_rate(&p->spring, z) * k->dz_dtheta.value + damper_rate * k->dz_dtheta.slope * omega;
    const Dual by_speed = slip_inertia_by_speed(slip, k), inertia = slip_inertia(slip, k);
    double *by = out->by;
    *out = (Partials){.by = {0.0}};
    by[KNOWN_THETA] = f->delta.slope * torque - f->p.slope * load - f->p.value * load_slope -
                      by_speed.slope * (omega * omega) - inertia.slope * balance->alpha;
    by[KNOWN_OMEGA] =
        -f->delta.value * b - f->p.value * damper_rate * k->dz_dtheta.value - 2.0 * by_speed.value * omega;
    by[KNOWN_ALPHA] = -inertia.value;
    by[KNOWN_TAU] = f->delta.value;
    by[KNOWN_F_EXT] = by[KNOWN_PRELOAD] = -f->p.value;
    by[KNOWN_STIFFNESS] = -f->p.value * z;
    by[KNOWN_STIFFNESS2] = -f->p.value * z * z;
    by[KNOWN_STIFFNESS3] = -f->p.value * z * z * z;
    by[slip->direction > 0 ? KNOWN_C_LOAD : KNOWN_C_RELEASE] = -f->p.value * v;
    by[slip->direction > 0 ? KNOWN_Q_LOAD : KNOWN_Q_RELEASE] = -f->p.value * v * fabs(v);
    for (int i = 0; i < 2; i++) by[KNOWN_FRICTION_1 + i] = partial_by_friction(slip, k, balance, i);
}

double balance_mobility(const SlipMode *slip, const Balance *balance) {
    Partials p;
    balance_partials(slip, balance, &p);
    return -p.by[KNOWN_TAU] / p.by[slip->regime == REGIME_INERTIAL ? KNOWN_ALPHA : KNOWN_OMEGA];
}

/* The change of the acceleration k alpha + k' omega^2, with k = z' or gamma' and `k_rate` k'. */
static double acceleration_change(const Balance *b, Dual k, Dual k_rate, double dtheta, double domega, double dalpha) {
    const double omega2 = b->omega * b->omega;
    return (k.slope * b->alpha + k_rate.slope * omega2) * dtheta + 2.0 * k_rate.value * b->omega * domega +
           k.value * dalpha;
}

/* x_i = (r n A -+ d W)/Delta with n and d of the other contact, see balance.h. */
COLD double balance_contact_change(const SlipMode *slip, const Balance *balance, int i, double dtheta, double domega,
                                   double dalpha) {
    const Params *p = slip->params;
    const double m = p->inertia.follower_mass, I = p->inertia.follower, omega = balance->omega, alpha = balance->alpha;
    SlipCoefficients storage;
    double z;
    const SlipCoefficients *k = slip_coefficients_at(slip, balance->theta, &storage, &z);
    const DualContactFactors *f = &k->factors;
    const Dual rn = f->rn[1 - i], signed_d = dual_scale(i == 0 ? -1.0 : 1.0, f->d[1 - i]);
    const double follower_acceleration = k->dz_dtheta.value * alpha + k->d2z_dtheta2.value * omega * omega;
    const double axial = balance->force + balance->damper + m * follower_acceleration;
    const double moment = I * (k->dpsi_dtheta[0].value * alpha + k->d2gamma_dtheta2.value * omega * omega);
    const double damper_rate = slip_damper_rate(slip, k->dz_dtheta.value * omega);
    const double axial_change = spring_rate(&p->spring, z) * k->dz_dtheta.value * dtheta +
                                damper_rate * (k->dz_dtheta.slope * omega * dtheta + k->dz_dtheta.value * domega) +
                                m * acceleration_change(balance, k->dz_dtheta, k->d2z_dtheta2, dtheta, domega, dalpha);
    const double moment_change =
        I * acceleration_change(balance, k->dpsi_dtheta[0], k->d2gamma_dtheta2, dtheta, domega, dalpha);
    return (rn.value * axial_change + signed_d.value * moment_change +
            (rn.slope * axial + signed_d.slope * moment - balance->x[i] * f->delta.slope) * dtheta) /
           f->delta.value;
}
