/* Impacts: end stops and wedges, which change the speed at once. */
#ifndef DUALCAM_IMPACT_H
#define DUALCAM_IMPACT_H

#include "contact/balance.h"
#include "forward/segment.h"

/* Handles the event that ended a segment which has been applied. Rest sets the speed to zero. A stop sets the angle to
 * that of the stop and reverses the speed. A change of flanks changes nothing: the next decision turns the flanks. */
void handle_event(Mechanism *m, int direction, EventKind end);

/* Impact on the end stop ahead in `direction`: omega -> -e omega. */
void hit_stop(Mechanism *m, int direction);

/* Does the mechanism move, in a mode that allows no motion? */
bool is_wedging(const Mechanism *m);

/* Proposes a wedge: no pair of flanks carries the motion, and the contacts stop it at once. The kinetic energy becomes
 * friction heat, shared between the contacts as under frictionless loads. */
void wedge_propose(const Mechanism *m, Segment *segment);

#endif
