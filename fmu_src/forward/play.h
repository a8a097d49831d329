/* The play operator: without inertia and damping theta follows the torque. Where the torque is beyond the stick band,
 * theta moves at once, along the band's edge, to the first angle at which the torque is held
 * (docs/mechanism.md, section 6). */
#ifndef DUALCAM_PLAY_H
#define DUALCAM_PLAY_H

#include "forward/state.h"

typedef struct {
    double dtheta;      /* rad */
    bool stopped;       /* the jump ends at the end stop */
    Booking booking;    /* J; during the jump the torque counts as that of the edge */
    double reaction[2]; /* N, total of all pin ends: largest |R_i| of the run, the jump included */
} Jump;

/* The jump from m->state.theta in `direction`, under the present F_ext, to where `torque`, N.m, is held. An edge that
 * exceeds the torque by less than `bump`, N.m, does not hold the torque. A torque that only grows leads to the same
 * angle and the same accounts in one jump as in many. */
void play_jump(const Mechanism *m, int direction, double torque, double bump, Jump *jump);

#endif
