/* Partial derivatives of the outputs of inverse dynamics. */
#ifndef DUALCAM_INVERSE_SENSITIVITY_H
#define DUALCAM_INVERSE_SENSITIVITY_H

#include "inverse/inverse_state.h"
#include "model/fault.h"
#include "model/known.h"

/* Both return false, with the reason, where the derivatives do not exist: beyond the stops, where the contacts wedge,
 * and those of v with an elastic shaft. */

/* Of tau: one-sided, in the direction of motion; at rest in that of the last motion. */
bool inverse_torque_partials(const Inverse *m, Partials *out, Fault *fault);

/* Of z (order 0) and of v (order 1). */
bool inverse_axial_partials(const Inverse *m, int order, Partials *out, Fault *fault);

#endif
