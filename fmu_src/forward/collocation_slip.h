/* Segments of slip by collocation, in grooves of any shape and under any forces: Lobatto steps where no event can lie,
 * Radau steps with event location elsewhere. */
#ifndef DUALCAM_COLLOCATION_SLIP_H
#define DUALCAM_COLLOCATION_SLIP_H

#include "contact/balance.h"
#include "forward/segment.h"

typedef enum {
    SLIP_PROPOSED,  /* *segment is the proposal */
    SLIP_UNDECIDED, /* the mode must be decided first */
    SLIP_LOST,      /* no step goes on: D of the pair falls to zero (docs/mechanism.md, section 3) */
} SlipProposal;

/* The result of an earlier trial of a Lobatto step. */
typedef struct {
    bool refused;  /* a Lobatto step from this state has been tried, and refused */
    bool accurate; /* four nodes suffice for the tolerance; the step was refused for another reason */
} LobattoHint;

/* The fast exit of a slipping step: proposes up to h seconds in one Lobatto step, in the present mode. Returns false if
 * the step is refused; *hint then has the result of the trial. */
bool collocation_slip_quiet(const Mechanism *m, double h, LobattoHint *hint, Segment *segment);

/* Proposes a segment in the present slip mode if a short test shows that a decision would find the mode again. `hint`
 * is that of collocation_slip_quiet() if the segment begins at the start of the step, else zero. */
SlipProposal collocation_slip_continue(Mechanism *m, double left, const LobattoHint *hint, EventLocation *location,
                                       Segment *segment);

/* Proposes slip for up to `left` seconds, to the first event. *location holds the collocation step. */
SlipProposal collocation_slip_propose(Mechanism *m, double left, EventLocation *location, Segment *segment);

#endif
