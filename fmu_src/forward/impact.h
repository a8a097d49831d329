/* Impacts: end stops and jams, which change the speed at once. */
#ifndef DUALCAM_IMPACT_H
#define DUALCAM_IMPACT_H

#include "contact/balance.h"
#include "forward/segment.h"

/* Handles the event that ended a segment which has been applied. Rest sets the speed to zero. A stop sets the angle to
 * that of the stop and reverses the speed. Contacts that let go take other flanks. A change of flanks changes nothing:
 * the next decision finds the flanks. */
void handle_event(Mechanism *m, int direction, EventKind end);

/* Impact on the end stop ahead in `direction`: omega -> -e omega. */
void hit_stop(Mechanism *m, int direction);

/* Does the mechanism move, in a mode that allows no motion? */
bool is_jammed(const Mechanism *m);

/* Does the motion along `slip` run into a jam now, to the rounding of theta? Reactions and acceleration have the factor
 * D = J Delta + P m z' + Q I gamma' of the equation of motion (slip_mode.h) in their denominator. Where D falls to zero
 * while the mechanism moves, the reactions grow without bound and stop the mechanism at once: the impact without
 * collision of Painleve's paradox (A. R. Champneys, P. L. Varkonyi, The Painleve paradox in contact mechanics, IMA
 * Journal of Applied Mathematics 81, 2016). Other flanks may agree there, too, but the impact comes first. Not found
 * where friction depends on the load. */
bool runs_into_jam(const Mechanism *m, const SlipMode *slip, const Balance *now);

/* Proposes a jam: no pair of flanks agrees with the motion, and the contacts stop it at once. The kinetic energy
 * becomes friction heat, shared between the contacts as under frictionless loads. */
void jam_propose(const Mechanism *m, Segment *segment);

#endif
