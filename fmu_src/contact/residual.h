/* Terms that the balance of forces and its derivatives share. */
#ifndef DUALCAM_RESIDUAL_H
#define DUALCAM_RESIDUAL_H

#include "contact/slip_mode.h"

/* A and W. */
typedef struct {
    double axial, moment; /* N, N.m */
} Loads;

/* `force`: F_0 + D, N. */
static inline Loads loads_of(const SlipMode *slip, const SlipCoefficients *k, double force, double omega,
                             double alpha) {
    if (!slip->follower_has_inertia) return (Loads){force, 0.0};
    const InertiaParams *i = &slip->params->inertia;
    return (Loads){
        force + i->follower_mass * (k->dz_dtheta.value * alpha + k->d2z_dtheta2.value * omega * omega),
        i->follower * (k->dpsi_dtheta[0].value * alpha + k->d2gamma_dtheta2.value * omega * omega),
    };
}

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

#endif
