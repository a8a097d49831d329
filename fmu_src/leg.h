/* The legs of a step: from one event to the next, in one mode each. mechanism_advance() is a chain of them, less what
 * it can shorten; who wants to know what happened inside a step goes through them one by one. */
#ifndef DUALCAM_LEG_H
#define DUALCAM_LEG_H

#include "mechanism.h"
#include "passage.h"

typedef enum {
    LEG_REST, /* it stands still */
    LEG_ARC,  /* slip along the closed form */
    LEG_LEAP, /* slip along a leap of the integrator */
    LEG_JUMP, /* without inertia and damping, along the band's edge to where the torque is held, or the stop */
    LEG_NONE, /* no time: it stood at the stop that it moves into, or the contacts jammed */
} LegKind;

typedef struct {
    LegKind kind;
    EventKind end;   /* what ended it */
    double omega;    /* rad/s, after slip: before what ended it changed the speed */
    Passage passage; /* of a LEG_LEAP */
} Leg;

/* Sets the mode that state and inputs ask for. To be called before each leg, and once at the end of the step. */
void leg_enter(Mechanism *m);

/* Spends up to `left` > 0 seconds; returns how long, or NAN if a value is not finite. */
double leg_run(Mechanism *m, double left, Leg *leg);

#endif
