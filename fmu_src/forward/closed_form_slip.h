/* Segments of slip whose motion is known in closed form: helices, linear forces, inputs that are ramps. */
#ifndef DUALCAM_CLOSED_FORM_SLIP_H
#define DUALCAM_CLOSED_FORM_SLIP_H

#include "closed_form/linear_search.h"
#include "elementary/elementary.h"
#include "forward/candidate.h"
#include "forward/segment.h"

/* The fast exit of a slipping step: proposes h seconds of inertial slip if they have no event, else returns false.
 * The kernel of the step is kept, so that a step of the same length evaluates no transcendental function. */
bool closed_form_slip_quiet(Mechanism *m, double h, Segment *segment);

/* The motion from the present state on, in the slip mode `linear`. Inlined: a step takes no longer than the copy of the
 * struct. */
static inline LinearSegment linear_segment_from_here(const Mechanism *m, const LinearSlipMode *linear) {
    return (LinearSegment){
        .linear = linear,
        .params = &m->params,
        .geometry = &m->configuration.geometry,
        .start = slip_start_of(m, linear),
        .work = m->work,
        .to_stop = angle_to_stop(m, linear->direction),
        .flanks = has_friction(&m->params),
        .edge = {min_of(m->configuration.band.load, STEEPEST_EDGE),
                 max_of(m->configuration.band.release, -STEEPEST_EDGE)},
    };
}

/* Proposes slip for up to `left` seconds, to the first event. */
void closed_form_slip_propose(Mechanism *m, double left, Segment *segment);

#endif
