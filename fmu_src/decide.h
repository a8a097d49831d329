/* Which mode comes next: the friction inclusion, decided from torque and never from a small velocity. */
#ifndef DUALCAM_DECIDE_H
#define DUALCAM_DECIDE_H

#include "balance.h"
#include "mechanism.h"

typedef struct {
    Mode mode;
    int slip; /* index into Model.slip; used in the slip modes */
} Decision;

/* The mode that state and present inputs ask for. Of the ways to slip that the model has not built, the last that had
 * to be for it is in *built, mostly the one that is taken; if none had to be, *built is left alone. */
Decision decide(const Mechanism *m, Slip *built);

/* The mode that counts at this instant: that one, or, where somebody else integrates, the present one. */
Decision decision_of(const Mechanism *m);

/* The way to slip in `direction` (+1, -1) whose flanks agree with their own reactions, or -1: index into
 * Model.slip. Several can agree where a contact locks; then both supporting flanks come first, as in section 3
 * of the mechanism page. *built: as in decide(). */
int decide_slip(const Mechanism *m, int direction, bool at_rest, Slip *built);

/* The coefficients of a way to slip in closed form, see flow.h: the model's, or, if that has not built them, in *room.
 * index: see slip_index(). */
const Slip *slip_of(const Mechanism *m, int index, Slip *room);

/* What one way to slip would be like from the present state on. */
typedef struct {
    bool possible;
    bool stable; /* more torque means more speed; else taken only where nothing else agrees */
    FlowKind kind;
    double net, net_size;    /* N.m: torque that drives it, beyond what holds the load, and the size of its terms */
    double tie;              /* share of net_size below which net is none */
    double omega, alpha;     /* rad/s, rad/s^2 */
    double jerk;             /* rad/s^3 */
    double stiffness;        /* N.m/rad: how the torque that holds the load grows along the way */
    double axial[2];         /* x_i per z, 1/m^2 N: through the spring */
    Contact contact[2];      /* x_i and its derivatives, only with friction */
    Contact size[2];         /* sizes of the terms in them */
} Look;

/* index: see slip_index(). */
Look look_at(const Mechanism *m, int index);

/* Quasi-static slip begins with a jump unless the torque is on the edge of the band already. */
bool decide_jump(const Look *look, int direction);

/* Does the closed form hold now? */
bool is_closed_form(const Mechanism *m);

Launch launch_of(const Mechanism *m, const Slip *slip);
Way way_from_here(const Mechanism *m, int index);

/* The balance on that way now. Where slip begins it keeps to its direction: rounding at the edge of the band does not
 * start it backwards. */
Balance balance_from_here(const Mechanism *m, const Way *way);

static inline int slip_direction(int index) {
    return index < 4 ? 1 : -1;
}

static inline void slip_flanks(int index, int flank[2]) {
    flank[0] = index & 2 ? -1 : 1;
    flank[1] = index & 1 ? -1 : 1;
}

static inline bool is_slip(Mode mode) {
    return mode == MODE_LOADING || mode == MODE_RELEASING;
}

static inline int sign_of(double x) {
    return (x > 0.0) - (x < 0.0);
}

#endif
