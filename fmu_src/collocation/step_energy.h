/* The energy balance of one collocation step, as a check of the step.
 *
 * docs/mechanism.md, section 4: the work of the torque equals the work against F_ext, the heat and the change of the
 * stored energy. The integrals of work and heat are taken at the nodes. The defect of the motion does not show their
 * error; the energy balance does. */
#ifndef DUALCAM_STEP_ENERGY_H
#define DUALCAM_STEP_ENERGY_H

#include "contact/balance.h"

/* What the balance needs of the ends of the step: [0] the start, [1] the end. */
typedef struct {
    double z[2], kinetic[2]; /* m, J; without inertia no kinetic energy counts */
    double spring_force;     /* N, at the start */
    double tau;              /* N.m, at the end */
    double angle_noise;      /* rad, how far rounding moves theta */
} EnergyEnds;

typedef struct {
    double gained; /* J, what the step has added to the stored energy out of nothing: the residual of the balance */
    double error;  /* the residual over the residual that the tolerance allows: the step is good up to 1 */
} EnergyBalance;

EnergyBalance step_energy_balance(const SlipMode *slip, const Booking *booking, const EnergyEnds *ends);

#endif
