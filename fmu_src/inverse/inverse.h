/* Inverse dynamics: the torque that an imposed motion of cam 2's shaft takes (docs/mechanism.md, section 7).
 *
 * The room inverse/ holds the imposed motion, the torque with a rigid and with an elastic shaft, the step and its
 * booking, and the outputs. Nothing here knows of FMI. All values are in SI units.
 *
 * May include: platform, elementary, numerics, model, geometry, contact, closed_form, collocation; not forward.
 *
 * At rest friction acts as in the direction of the last motion; before any motion this is loading. */
#ifndef DUALCAM_INVERSE_H
#define DUALCAM_INVERSE_H

#include "inverse/inverse_outputs.h"
#include "inverse/inverse_state.h"
#include "model/fault.h"

/* Functions that return bool return false, with the reason in `fault`, if the request cannot be carried out. Then
 * nothing but the transmission has changed. */

/* Starts from m->params and m->inputs: at theta and omega now, and at rest before. */
bool inverse_start(Inverse *m, Fault *fault);

/* Builds the transmission that m->params ask for, or keeps the one that was built from the same cams and stops. To be
 * called after params, inputs and state were replaced from a snapshot. */
bool inverse_rebuild(Inverse *m, Fault *fault);

/* Replaces m->params at a communication point. Only friction, spring and damper may differ. Books the spring's jump in
 * stored energy as work_tuning. */
bool inverse_retune(Inverse *m, const Params *params, Fault *fault);

/* Frees the memory of *m. Safe on a zeroed Inverse, and twice. */
void inverse_free(Inverse *m);

/* Moves as imposed (imposed_motion.h) for h > 0 seconds and leaves in m->inputs their values at the end. If angle and
 * speed are those of the latest communication point, cam 2 does not move. Refused are angles beyond the stops, and
 * motion that no torque brings about. */
bool inverse_advance(Inverse *m, double h, GivenInput given, Fault *fault);

/* Model exchange: takes on the direction of the present motion, if there is motion. From now on friction acts against
 * it. */
void inverse_settle(Inverse *m);

/* Model exchange: the event indicator, rad/s, is the speed in the present direction. Its sign change asks for
 * inverse_settle(). */
double inverse_indicator(const Inverse *m);

#endif
