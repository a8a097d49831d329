/* Segments of slip whose motion is known in closed form: helices, linear forces, inputs that are ramps. */
#ifndef DUALCAM_CLOSED_FORM_SLIP_H
#define DUALCAM_CLOSED_FORM_SLIP_H

#include "closed_form/linear_search.h"
#include "forward/segment.h"

/* The fast exit of a slipping step: proposes h seconds of inertial slip if they have no event, else returns false.
 * The kernel of the step is kept, so that a step of the same length evaluates no transcendental function. */
bool closed_form_slip_quiet(Mechanism *m, double h, Segment *segment);

/* The motion from the present state on, in the slip mode `linear`. */
LinearSegment linear_segment_from_here(const Mechanism *m, const LinearSlipMode *linear);

/* Proposes slip for up to `left` seconds, to the first event. False if a value is not finite. */
bool closed_form_slip_propose(Mechanism *m, double left, Segment *segment);

#endif
