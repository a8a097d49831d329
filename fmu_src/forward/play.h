/* Without inertia and damping theta is the play operator of tau: where the torque is beyond the stick band, it moves
 * at once, along the band's edge, to the first place that holds the torque. */
#ifndef DUALCAM_PLAY_H
#define DUALCAM_PLAY_H

#include "forward/mechanism.h"

typedef struct {
    double dtheta;      /* rad */
    bool stopped;       /* at the end stop */
    Booking booking;    /* the torque taken is that of the edge */
    double reaction[2]; /* N, total: largest |R_i| so far, the way included */
} Jump;

/* From m->state.theta in `direction`, under the present F_ext, to where `torque`, N.m, is held. An edge that exceeds it by
 * less than `bump`, N.m, does not hold it. A torque that only grows leads to the same place, with the same accounts. */
void play_jump(const Mechanism *m, int direction, double torque, double bump, Jump *jump);

#endif
