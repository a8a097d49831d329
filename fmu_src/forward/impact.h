/* What ends a motion at once: end stops and jams. */
#ifndef DUALCAM_IMPACT_H
#define DUALCAM_IMPACT_H

#include "forward/segment.h"

/* Handles the event that ended a segment which has been applied. Speed zero and stops are set to what they are by
 * definition; a stop reverses the speed. A change of flanks moves nothing: the next decision finds the flanks. */
void handle_event(Mechanism *m, int direction, EventKind end);

/* Arrival at the end stop ahead in `direction`: omega -> -e omega. */
void hit_stop(Mechanism *m, int direction);

/* Is the mechanism moving, and in a mode in which it cannot move? */
bool is_jammed(const Mechanism *m);

/* Proposes the end of a motion that no pair of flanks agrees with: the contacts jam it at once. The kinetic energy
 * becomes friction heat, shared as frictionless loads would share the sliding. */
void jam_propose(const Mechanism *m, Segment *segment);

#endif
