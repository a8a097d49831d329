/* Segments of slip by collocation, in grooves of any shape and under any forces: Lobatto steps where nothing happens,
 * Radau steps with event location elsewhere. */
#ifndef DUALCAM_COLLOCATION_SLIP_H
#define DUALCAM_COLLOCATION_SLIP_H

#include "contact/balance.h"
#include "forward/segment.h"

typedef enum {
    SLIP_PROPOSED,   /* *segment is the proposal */
    SLIP_UNDECIDED,  /* the mode is to be decided first */
    SLIP_NOT_FINITE, /* a value is not finite */
} SlipProposal;

/* What is known of a Lobatto step before it is sought. */
typedef struct {
    bool refused;  /* it has been sought here, and there is none */
    bool accurate; /* so few stages suffice for the tolerance, whatever else was wrong with the step */
} LobattoHint;

/* The fast exit of a slipping step: proposes up to h seconds in one Lobatto step, in the present mode. Returns false if
 * there is no such step; *hint then says why. */
bool collocation_slip_quiet(const Mechanism *m, double h, LobattoHint *hint, Segment *segment);

/* Goes on in the present slip mode if a short test shows that a decision would find the mode again. `hint` is that of
 * collocation_slip_quiet() if the segment begins where the step begins, else zero. */
SlipProposal collocation_slip_continue(Mechanism *m, double left, const LobattoHint *hint, EventLocation *location,
                                       Segment *segment);

/* Proposes slip for up to `left` seconds, to the first event. *location holds the collocation step. False if a value
 * is not finite. */
bool collocation_slip_propose(Mechanism *m, double left, EventLocation *location, Segment *segment);

#endif
