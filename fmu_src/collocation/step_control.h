/* Step control: length and number of stages of a Radau step, by its error estimates.
 * (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.8.) */
#ifndef DUALCAM_STEP_CONTROL_H
#define DUALCAM_STEP_CONTROL_H

#include "collocation/radau_step.h"

/* Length to try first, s, where nothing is known of the motion: infinite unless the motion vibrates. */
double step_control_first_length(const SlipMode *slip, const Balance *start);

/* The longest accepted step of at most `longest` seconds. A rejected step is tried with more stages before it is made
 * shorter. `first` is the proposal of the step before. False if no trial is accepted. */
bool step_control_solve(const SlipMode *slip, const Balance *start, double longest, const StepProposal *first,
                        RadauStep *step);

/* What to try after an accepted step. */
StepProposal step_control_next(const RadauStep *step);

#endif
