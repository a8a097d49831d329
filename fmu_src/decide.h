/* Which mode comes next: the friction inclusion, decided from torque and never from a small velocity. */
#ifndef DUALCAM_DECIDE_H
#define DUALCAM_DECIDE_H

#include "mechanism.h"

typedef struct {
    Mode mode;
    int slip; /* index into Model.slip; used in the slip modes */
} Decision;

/* The mode that state and present inputs ask for. */
Decision decide(const Mechanism *m);

/* The way to slip in `direction` (+1, -1) whose flanks agree with their own reactions, or -1: index into
 * Model.slip. Several can agree where a contact locks; then both supporting flanks come first, as in section 3
 * of the mechanism page. */
int decide_slip(const Mechanism *m, int direction, bool at_rest);

/* Quasi-static slip begins with a jump unless the torque is on the edge of the band already. */
bool decide_jump(const Mechanism *m, const Slip *slip, const Launch *launch);

Launch launch_of(const Mechanism *m, const Slip *slip);

static inline bool is_slip(Mode mode) {
    return mode == MODE_LOADING || mode == MODE_RELEASING;
}

static inline int sign_of(double x) {
    return (x > 0.0) - (x < 0.0);
}

#endif
