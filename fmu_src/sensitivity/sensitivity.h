/* Partial derivatives of the outputs of forward dynamics. At a mode change they are one-sided: those of the motion
 * that follows.
 *
 * The room sensitivity/ holds derivatives: partial derivatives of outputs by inputs, states and tunable parameters,
 * time derivatives of the inverse outputs, and the Jacobian of a whole step.
 *
 * May include: platform, elementary, numerics, model, geometry, contact, closed_form, collocation, forward, inverse,
 * outputs. */
#ifndef DUALCAM_SENSITIVITY_H
#define DUALCAM_SENSITIVITY_H

#include "forward/state.h"
#include "model/fault.h"
#include "model/known.h"

/* Of z (order 0) and of v (order 1): both follow from theta and omega alone. */
void mechanism_axial_partials(const Mechanism *m, int order, Partials *out);

/* Of alpha. At rest they are 0. False, with the reason, while cam 2 slips without inertia and without damping: then
 * theta is no state. */
bool mechanism_alpha_partials(const Mechanism *m, Partials *out, Fault *fault);

#endif
