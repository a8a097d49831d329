/* Jumps: without inertia and damping the angle follows the torque along the edge of the stick band, and jumps where the
 * torque is beyond the edge or where the edge stops rising (a fold). A jump takes no time. */
#ifndef DUALCAM_JUMP_H
#define DUALCAM_JUMP_H

#include "forward/segment.h"

/* Two helices: proposes the jump to the edge of the band, to the end stop, or to where F_0 changes its sign and with it
 * the flanks. False if the torque is on the edge already. */
bool jump_of_helices(const Mechanism *m, const LinearSlipMode *linear, Segment *segment);

/* Grooves of any shape: does the slip mode that has been decided begin with a jump? */
bool jump_is_due(const Mechanism *m);

/* Grooves of any shape: proposes the jump to where the torque is held, or the end stop. If the edge holds the torque
 * to rounding, so that the jump is zero, proposes rest for up to `left` seconds. */
void jump_propose(Mechanism *m, double left, Segment *segment);

/* Has the step along the edge come so close to a fold that only rounding moves the angle? */
bool jump_is_at_fold(const SlipMode *slip, const EventLocation *location, double left);

/* Proposes the motion past a fold or a level part of the edge. While the torque grows and F_ext is constant, the
 * segment takes up to `left` seconds and ends at the angle to which a jump of the torque would lead; its speed then
 * follows from the mode that is decided at its end. Else the segment is a jump. False if there is no fold ahead. */
bool jump_past_fold(const Mechanism *m, const SlipMode *slip, const Balance *start, double left, Segment *segment);

/* After a segment with finds_speed: decides the mode at its end and sets the speed along the edge. */
void jump_find_speed(Mechanism *m);

#endif
