/* Derivatives of the outputs of inverse dynamics: by time, along the motion that the inputs describe now, and partial
 * ones. */
#ifndef DUALCAM_INVERSE_DERIVATIVES_H
#define DUALCAM_INVERSE_DERIVATIVES_H

#include "inverse/inverse_state.h"
#include "model/fault.h"
#include "model/known.h"

typedef struct {
    double tau[2]; /* orders 1 and 2 */
    double z[3];   /* orders 1 to 3 */
} InverseDerivatives;

/* To be called where tau and z exist. theta' = omega and omega' = alpha. alpha' and alpha'' are those given for alpha;
 * else they follow from the higher derivatives given for omega or theta; else they are 0. F_ext' and F_ext'' are as
 * given. After a step the polynomials of the step go on.
 *
 * The derivatives are those of the motion that follows. Where omega = 0, its direction is that of alpha, or of the
 * first of alpha's derivatives that is not 0. If all are 0, or if no torque moves cam 2 in this direction, it is the
 * direction of the last motion. */
void inverse_derivatives(const Inverse *m, InverseDerivatives *out);

/* Both return false, with the reason, where the derivatives do not exist: beyond the stops, where the contacts wedge,
 * and those of v with an elastic shaft. */

/* Of tau: one-sided, in the direction of motion; at rest in that of the last motion. */
bool inverse_torque_partials(const Inverse *m, Partials *out, Fault *fault);

/* Of z (order 0) and of v (order 1). */
bool inverse_axial_partials(const Inverse *m, int order, Partials *out, Fault *fault);

#endif
