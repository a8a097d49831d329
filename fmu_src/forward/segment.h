/* The legs of a step: from one event to the next, in one mode each. mechanism_advance() is a chain of them, less what
 * it can shorten; who wants to know what happened inside a step goes through them one by one. */
#ifndef DUALCAM_SEGMENT_H
#define DUALCAM_SEGMENT_H

#include "collocation/event_location.h"
#include "forward/mechanism.h"

typedef enum {
    SEGMENT_REST,        /* it stands still */
    SEGMENT_CLOSED_FORM, /* slip along the closed form */
    SEGMENT_RADAU,       /* slip along a leap of the integrator */
    SEGMENT_JUMP, /* without inertia and damping, along the band's edge to where the torque is held, or the stop */
    SEGMENT_NONE, /* no time: it stood at the stop that it moves into, or the contacts jammed */
} SegmentKind;

typedef struct {
    SegmentKind kind;
    EventKind end;          /* what ended it */
    double omega;           /* rad/s, after slip: before what ended it changed the speed */
    EventLocation location; /* of a SEGMENT_RADAU */
} Segment;

/* Sets the mode that state and inputs ask for. To be called before each leg, and once at the end of the step. */
void segment_enter(Mechanism *m);

/* Spends up to `left` > 0 seconds; returns how long, or NAN if a value is not finite. */
double segment_run(Mechanism *m, double left, Segment *segment);

#endif
