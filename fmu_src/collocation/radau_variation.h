/* The derivative of a Radau step: how small changes of the start, of the inputs and of the parameters change
 * its end. */
#ifndef DUALCAM_RADAU_VARIATION_H
#define DUALCAM_RADAU_VARIATION_H

#include "collocation/radau_step.h"

/* A small change of angle and speed for each known from `first` to `end` - 1, per unit of the known. Without inertia
 * the angle alone is a state. */
typedef struct {
    int first, end;
    double theta[KNOWN_COUNT], omega[KNOWN_COUNT]; /* rad, rad/s */
} Variation;

/* Replaces the variation at the start of the step by the variation at its end. Inputs change by a constant over the
 * whole step. Not for the rate-independent regime. False if the equations have no solution. */
bool radau_step_vary(const SlipMode *slip, const RadauStep *step, Variation *v);

#endif
