/* How the residual of the equation of motion changes with the factors of the contacts. */
#ifndef DUALCAM_RESIDUAL_H
#define DUALCAM_RESIDUAL_H

#include "contact/slip_mode.h"

/* The terms of the equation of motion that the factors multiply. */
typedef struct {
    double torque;       /* N.m, tau - b omega */
    double load;         /* N, F_0 + D */
    double omega, alpha; /* rad/s, rad/s^2 */
} MotionTerms;

/* The change of the residual (see balance_partials() in balance.h), if the factors change by `by`. */
static inline double residual_change(const SlipMode *slip, const SlipCoefficients *k, const ContactFactors *by,
                                     const MotionTerms *t) {
    const InertiaParams *inertia = &slip->params->inertia;
    const double J = inertia->shaft, m = inertia->follower_mass, I = inertia->follower;
    const double inertia_by = J * by->delta + m * by->p * k->dz_dtheta.value + I * by->q * k->dpsi_dtheta[0].value;
    const double inertia_by_speed_by = m * by->p * k->d2z_dtheta2.value + I * by->q * k->d2gamma_dtheta2.value;
    return by->delta * t->torque - by->p * t->load - inertia_by_speed_by * (t->omega * t->omega) -
           inertia_by * t->alpha;
}

/* N/m: the change of x_i, if the factors change by `by`; x_i = (r n A -+ d W)/Delta with n and d of the other
 * contact. */
static inline double contact_load_by_factors(const SlipCoefficients *k, const ContactFactors *by, int i, double axial,
                                             double moment, double x) {
    const double signed_d = i == 0 ? -by->d[1 - i] : by->d[1 - i];
    return (by->rn[1 - i] * axial + signed_d * moment - x * by->delta) / k->factors.delta.value;
}

#endif
