/* The derivative of a Radau step: how a small change of the start and of the torque changes its end. */
#ifndef DUALCAM_RADAU_VARIATION_H
#define DUALCAM_RADAU_VARIATION_H

#include "collocation/radau_step.h"

/* A small change of angle and speed. Without inertia the angle alone is a state. */
typedef struct {
    double theta, omega; /* rad, rad/s */
} Variation;

/* Replaces the variation at the start of the step by the variation at its end, while the torque is shifted by the
 * constant `torque`, N.m. Not for the rate-independent regime. False if the equations have no solution. */
bool radau_step_vary(const SlipMode *slip, const RadauStep *step, double torque, Variation *v);

#endif
