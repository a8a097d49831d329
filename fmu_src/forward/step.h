/* The step: how time passes, as an outline. */
#ifndef DUALCAM_STEP_H
#define DUALCAM_STEP_H

#include "forward/segment.h"
#include "model/fault.h"
#include "model/watcher.h"

/* Advances by h > 0 seconds with m->inputs and leaves in m->inputs their values at the end of the step. Returns false,
 * with the mechanism as before, if mode changes do not end (the limits stand in tolerances.h) or a value is no longer
 * finite; `fault` says which. */
bool mechanism_advance(Mechanism *m, double h, Fault *fault);

/* The same. `watcher`, with mode and cut zero, is told of each instant after the start at which the mode is another one;
 * the watcher sees the mechanism as it is then, and may end the step there, `cut` seconds early. The motion is that of
 * one step, however often the watcher is told. */
bool mechanism_advance_watched(Mechanism *m, double h, Watcher *watcher, Fault *fault);

/* Carries out the mode changes that are due now. In model exchange the mechanism may stand at an end stop or at
 * velocity zero to the rounding of a solver, on either side, and the accounts stay as they are. Returns false, with the
 * mechanism as before, if the mode changes do not end. */
bool mechanism_settle(Mechanism *m, Fault *fault);

/* What a segment that has been carried out does not tell any more. */
typedef struct {
    Inputs inputs; /* at its start */
    Mode mode;     /* in which it was made */
    double omega;  /* rad/s, at its end, before its event was handled */
} SegmentPast;

/* Somebody who goes through a step segment by segment. */
typedef struct StepVisitor StepVisitor;
struct StepVisitor {
    void (*before_decision)(StepVisitor *visitor, const Mechanism *m); /* or NULL */
    /* The mode has been decided and `left` >= 0 seconds are left. Returns for how long the step is to go on. */
    double (*after_decision)(StepVisitor *visitor, const Mechanism *m, double left);
    /* The segment has been applied and its event handled. Returns false to stop. */
    bool (*after_segment)(StepVisitor *visitor, const Mechanism *m, const Segment *segment, const SegmentPast *past);
    bool every_decision; /* each segment begins with a decision, also where the mode is known to go on */
};

/* Goes through h seconds from the present state with the visitor; nothing is remembered as a step. Returns false if the
 * visitor stopped or the step cannot be made; the mechanism is then where that happened. */
bool mechanism_go_through(Mechanism *m, double h, StepVisitor *visitor);

#endif
