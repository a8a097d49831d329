/* Which mode comes next: the friction inclusion, decided from torque and never from a small velocity. */
#ifndef DUALCAM_DECIDE_H
#define DUALCAM_DECIDE_H

#include "contact/balance.h"
#include "forward/mechanism.h"

typedef struct {
    Mode mode;
    int slip_index; /* index into Model.linear_slip; used in the slip modes */
} Decision;

/* The mode that state and present inputs ask for. Of the ways to slip that the model has not built, the last that had
 * to be for it is in *built, mostly the one that is taken; if none had to be, *built is left alone. */
Decision decide(const Mechanism *m, LinearSlipMode *built);

/* The mode that counts at this instant: that one, or, where somebody else integrates, the present one. */
Decision decision_of(const Mechanism *m);

/* The way to slip in `direction` (+1, -1) whose flanks agree with their own reactions, or -1: index into
 * Model.slip. Several can agree where a contact locks; then both supporting flanks come first, as in section 3
 * of the mechanism page. *built: as in decide(). */
int decide_slip(const Mechanism *m, int direction, bool at_rest, LinearSlipMode *built);

/* The coefficients of a way to slip in closed form, see linear_slip.h: the model's, or, if that has not built them, in *room.
 * index: see slip_index(). */
const LinearSlipMode *linear_slip_of(const Mechanism *m, int index, LinearSlipMode *room);

/* What one way to slip would be like from the present state on. */
typedef struct {
    bool possible;
    bool stable; /* more torque means more speed; else taken only where nothing else agrees */
    Regime regime;
    double net, net_size;   /* N.m: torque that drives it, beyond what holds the load, and the size of its terms */
    double tie;             /* share of net_size below which net is none */
    double omega, alpha;    /* rad/s, rad/s^2 */
    double jerk;            /* rad/s^3 */
    double stiffness;       /* N.m/rad: how the torque that holds the load grows along the way */
    double axial[2];        /* x_i per z, 1/m^2 N: through the spring */
    ContactLoad contact[2]; /* x_i and its derivatives, only with friction */
    ContactLoad size[2];    /* sizes of the terms in them */
} Candidate;

/* index: see slip_index(). */
Candidate candidate_of(const Mechanism *m, int index);

/* Quasi-static slip begins with a jump unless the torque is on the edge of the band already. */
bool decide_jump(const Candidate *candidate, int direction);

/* Does the closed form hold now? */
bool is_closed_form(const Mechanism *m);

SlipStart slip_start_of(const Mechanism *m, const LinearSlipMode *slip);
SlipMode present_slip_mode(const Mechanism *m, int index);

/* The balance on that way now. Where slip begins it keeps to its direction: rounding at the edge of the band does not
 * start it backwards. */
Balance balance_from_here(const Mechanism *m, const SlipMode *slip);

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
