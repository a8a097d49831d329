/* The step as an outline: decide the mode, propose a segment, apply the segment, handle its event. */
#ifndef DUALCAM_STEP_H
#define DUALCAM_STEP_H

#include "forward/segment.h"
#include "model/fault.h"
#include "model/watcher.h"

/* Advances by h > 0 seconds with m->inputs and leaves in m->inputs their values at the end of the step. Returns false,
 * with the mechanism as before, if the step needs too many segments or wedges (the limits stand in tolerances.h), or if a
 * value is not finite; `fault` names the reason.
 *
 * `watcher`, unless NULL, has the members `mode` and `cut` zero. It is told of each instant after the start at which the
 * mode changes, sees the mechanism at that instant, and may end the step there, `cut` seconds early. It does not change
 * the motion. */
bool mechanism_advance(Mechanism *m, double h, Watcher *watcher, Fault *fault);

/* Carries out the mode changes that are due now. In model exchange the mechanism may stand at an end stop or at
 * velocity zero to the rounding of a solver, on either side, and the accounts stay as they are. */
void mechanism_settle(Mechanism *m);

/* Values from before and during a segment that its visitor cannot find in the mechanism any more. */
typedef struct {
    Inputs inputs; /* at the start of the segment */
    Mode mode;     /* of the segment */
    double omega;  /* rad/s, at the end of the segment, before its event was handled */
} SegmentPast;

/* Follows a step segment by segment. */
typedef struct StepVisitor StepVisitor;
struct StepVisitor {
    void (*before_decision)(StepVisitor *visitor, const Mechanism *m); /* or NULL */
    /* The mode has been decided and `left` >= 0 seconds are left. Returns the time, s, for which the step goes on. */
    double (*after_decision)(StepVisitor *visitor, const Mechanism *m, double left);
    /* The segment has been applied and its event handled. Returns false to stop. */
    bool (*after_segment)(StepVisitor *visitor, const Mechanism *m, const Segment *segment, const SegmentPast *past);
    bool every_decision; /* each segment begins with a decision, also where the mode is known to last */
};

/* Makes h seconds from the present state with the visitor; State.step stays as it is. Returns false if the visitor
 * stopped or the step cannot be made; the mechanism then stays at the instant at which the step ended. */
bool mechanism_go_through(Mechanism *m, double h, StepVisitor *visitor);

#endif
