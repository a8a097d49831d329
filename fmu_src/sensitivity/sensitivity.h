/* Partial derivatives of what the mechanism puts out, one-sided at mode changes: those of what comes next. */
#ifndef DUALCAM_SENSITIVITY_H
#define DUALCAM_SENSITIVITY_H

#include "forward/state.h"
#include "model/fault.h"
#include "model/known.h"

/* Of z (order 0) and v (order 1): they follow from theta and omega alone. */
void mechanism_axial_partials(const Mechanism *m, int order, Partials *out);

/* Of alpha. Where the mechanism rests they are 0. False, with the reason, while it slips without inertia and damping:
 * then theta is no state. */
bool mechanism_alpha_partials(const Mechanism *m, Partials *out, Fault *fault);

#endif
