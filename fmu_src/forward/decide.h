/* The decision of the mode: the friction inclusion of docs/mechanism.md, section 3, decided by the torque and
 * never by a small velocity. */
#ifndef DUALCAM_DECIDE_H
#define DUALCAM_DECIDE_H

#include "forward/candidate.h"
#include "forward/state.h"

typedef struct {
    Mode mode;
    int slip_index; /* see slip_index(); -1 in the modes of rest */
} Decision;

/* The mode at this instant: the decision for state and present inputs. In model exchange modes change at events only,
 * and the mode is the present one. */
Decision decision_of(const Mechanism *m);

/* Decides the mode and enters it: a mode that differs from the present one counts as an event. Coefficients of the
 * closed form that the decision had to build are kept in the model. False, and the mode stays, where rest balances the torque
 * and the present motion does, too: only an inertia decides. */
bool enter_decided_mode(Mechanism *m);

/* The slip mode in `direction` (+1, -1) whose flanks agree with their own reactions: its index, or -1 if there is
 * none. Several slip modes can agree where a contact locks; then the pair of supporting flanks comes first
 * (docs/mechanism.md, section 3), except where the load of a moving contact passes zero (decide.c). The mechanism moves
 * in that direction, or is about to. */
int slip_mode_of_moving(Mechanism *m, int direction);

/* Contacts that held the speed at the limit of a jam let go (collocation/step_indicator.h): they take the flanks that
 * support the coming axial load, if these agree with their reactions. */
void let_go(Mechanism *m, int direction);

/* The present flanks have lost their motion, although a decision finds them possible. Where friction depends on the load, the
 * present pair searches if the reactions of the motion go on: Newton's method has lost them. Else the first other pair is taken
 * that agrees and has a motion, and where there is none, the answers are searched, of the present pair first. False if there
 * is none. */
bool leave_lost_flanks(Mechanism *m);

/* Does rate-independent slip begin with a jump? True unless the torque is on the edge of the stick band already. */
bool begins_with_jump(const Candidate *candidate, int direction);

/* Builds the coefficients of the closed form of one slip mode and keeps them in the model. */
void build_linear_slip(Mechanism *m, int index);

/* The coefficients of the closed form of one slip mode, built at their first use. */
static inline const LinearSlipMode *kept_linear_slip(Mechanism *m, int index) {
    if ((m->model.linear_slips >> index & 1u) == 0) build_linear_slip(m, index);
    return &m->model.linear_slip[index];
}

#endif
