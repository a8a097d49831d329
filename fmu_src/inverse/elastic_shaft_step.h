/* One step of inverse dynamics with an elastic shaft. */
#ifndef DUALCAM_ELASTIC_SHAFT_STEP_H
#define DUALCAM_ELASTIC_SHAFT_STEP_H

#include "inverse/inverse_state.h"
#include "model/fault.h"

/* Carries `next`, the state at the start, along the motion, which ends at the speed `omega`. In each monotone part of
 * the motion a polynomial F_ext is followed in ELASTIC_FORCE_INTERVALS intervals of constant F_ext. False, with the
 * reason, where the contacts wedge on the path of cam 2. */
bool elastic_shaft_advance(const Inverse *m, const ImposedMotion *motion, double omega, InverseState *next,
                           Fault *fault);

#endif
