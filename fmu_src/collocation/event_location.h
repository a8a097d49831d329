/* Event location: a segment of slip through grooves of any shape, up to its first event.
 *
 * The room collocation/ holds slip in grooves of any shape and under any forces, by integration: the Radau step, its
 * step control and event location; the Lobatto step for quiet motion. May include: platform, elementary, numerics,
 * model, geometry, contact.
 *
 * One Radau step is taken, as long as the step control accepts. If an indicator crosses zero on the step's polynomial,
 * the step is solved again with a shorter length, until it ends on the crossing to rounding (docs/mechanism.md, section 6;
 * L. F. Shampine, S. Thompson, Computers and Mathematics with Applications 39, 2000). Bracket invariant: the indicator is
 * not negative at the end of a step of length `left`, and is negative at the end of a step of length `right`, once the
 * bracket is closed. */
#ifndef DUALCAM_EVENT_LOCATION_H
#define DUALCAM_EVENT_LOCATION_H

#include "collocation/radau_step.h"
#include "model/mode.h"

typedef struct {
    RadauStep step;
    EventKind kind;           /* what ended the segment */
    bool crossed[2];          /* of EVENT_FLANK: the reactions that pass zero */
    bool at_breakpoint;       /* the segment ended at a breakpoint of the transmission */
    bool aimed_at_breakpoint; /* the step was to end at the breakpoint, or at a sample of a friction table */
    StepProposal next;        /* for the next segment */
} EventLocation;

/* The end stop ahead. */
typedef struct {
    double angle;         /* rad, to the stop */
    double energy_gained; /* J, since the last impact, by the errors of the steps before: see step_energy.h */
} StopAhead;

/* The longest segment of at most `left` seconds from `start`. `first`: the proposal of the segment before. False where
 * no step is accepted: the contacts jam the motion on the spot. */
bool event_location_find(const SlipMode *slip, const Balance *start, const StopAhead *stop, double left,
                         const StepProposal *first, EventLocation *location);

#endif
