/* A stretch of slip through grooves of any shape, to its end: the step's end, or the first event in it. */
#ifndef DUALCAM_EVENT_LOCATION_H
#define DUALCAM_EVENT_LOCATION_H

#include "closed_form/linear_event.h"
#include "collocation/radau_step.h"

typedef struct {
    RadauStep radau;
    EventKind kind;      /* what ended it */
    bool at_breakpoint;  /* it ended at the end of a piece */
    bool for_breakpoint; /* its length was that to the end of a piece, as far as could be told */
    StepProposal next;   /* to try for the next one */
    double reaction[2];  /* N, largest |R_i| on the way, total */
    double omega;        /* rad/s, largest |omega| on the way */
} EventLocation;

/* The end of the piece ahead, rad from the start on, and how far a step may go beyond. */
typedef struct {
    double distance, beyond;
} Breakpoint;

Breakpoint event_location_breakpoint(const SlipMode *slip, double theta);

/* Time, s, in which constant acceleration takes it over `distance`, rad; speed and alpha in the direction of the way.
 * Infinite if it never gets there. */
double ballistic_time(double speed, double alpha, double distance);

/* The longest passage of at most `left` seconds from `start`. `room` is the way to the end stop ahead, rad; `first` what
 * to try first. Returns false where the contacts jam it on the spot. */
bool event_location_find(const SlipMode *slip, const Balance *start, double room, double left,
                         const StepProposal *first, EventLocation *location);

/* Fills in the largest speed and reactions; below `known` they are not looked for closely. */
void event_location_peaks(const SlipMode *slip, EventLocation *location, double known_omega,
                          const double known_reaction[2]);

#endif
