/* One step of inverse dynamics with a rigid shaft. */
#ifndef DUALCAM_RIGID_SHAFT_STEP_H
#define DUALCAM_RIGID_SHAFT_STEP_H

#include "inverse/inverse_state.h"
#include "model/fault.h"

/* Carries `next`, the state at the start, along the motion, which ends at the speed `omega`. Between two angles inside
 * the stops a cubic may overshoot a stop: there cam 2 is held at the stop. False, with the reason, if the contacts
 * wedge during the motion, or if the motion swings too far beyond the stops to be known to the tolerance. */
bool rigid_shaft_advance(const Inverse *m, const ImposedMotion *motion, double omega, InverseState *next, Fault *fault);

#endif
