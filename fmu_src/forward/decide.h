/* The decision of the mode: the friction inclusion of docs/mechanism.md, section 3, decided by the torque and never by a
 * small velocity.
 *
 * A pair of flanks carries a motion if more torque means more of it (D/Delta > 0) and each reaction presses on its flank. In
 * a mechanism of the unique class one pair carries at most, but for reactions that are zero, whose flank does not matter. In
 * a self-locking mechanism this order is the rule: the present pair, the pair that supports the axial load, its neighbours,
 * the opposite pair. Where none carries, the contacts wedge. */
#ifndef DUALCAM_DECIDE_H
#define DUALCAM_DECIDE_H

#include "forward/candidate.h"
#include "forward/state.h"

typedef struct {
    Mode mode;
    int slip_index; /* see slip_index(); -1 in the modes of rest */
} Decision;

/* The mode that belongs to the state and the present inputs. In model exchange modes change at events only, and the
 * mode is the present one. */
Decision decision_of(const Mechanism *m);

/* Decides the mode and enters it: a mode that differs from the present one counts as an event. */
void enter_decided_mode(Mechanism *m);

/* The slip mode in `direction` of a mechanism that moves, or is about to, after an impact: its index, or -1 if the
 * contacts wedge. */
int slip_after_impact(const Mechanism *m, int direction);

/* Does rate-independent slip begin with a jump? True unless the torque is on the edge of the stick band already. */
bool begins_with_jump(const Candidate *candidate, int direction);

#endif
