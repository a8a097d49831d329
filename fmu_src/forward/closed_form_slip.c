#include "forward/closed_form_slip.h"

#include "elementary/elementary.h"

static void raise_peaks(const LinearSegment *s, const SegmentEnds *ends, Peaks *peak) {
    linear_segment_peaks(s, ends, peak);
    peak_raise(&peak->torque, s->start.tau);
    peak_raise(&peak->torque, s->start.tau + s->start.tau_rate * ends->motion.t);
}

/* The segment that `ends` and `kernel` describe. */
static inline void propose(const Mechanism *m, const LinearSegment *s, const SegmentEnds *ends, Kernel *kernel,
                           Segment *segment) {
    const LinearMotion *motion = &ends->motion;
    segment_begin(m, SEGMENT_CLOSED_FORM, segment);
    if (m->params.ledger) {
        linear_slip_book(s->linear, s->params, s->geometry, &s->start, motion, kernel, &segment->booking);
        segment->books = true;
        raise_peaks(s, ends, &segment->peak);
    }
    segment->duration = motion->t;
    segment->dtheta = motion->dtheta;
    segment->omega_is_increment = s->linear->regime == REGIME_INERTIAL && !motion->settled;
    segment->omega = segment->omega_is_increment ? motion->domega : motion->omega;
    segment->varies = s->start.tau_rate != 0.0 || s->start.F_ext_rate != 0.0;
}

bool closed_form_slip_quiet(Mechanism *m, double h, Segment *segment) {
    if (!is_slip(m->state.mode)) return false;
    const int index = present_slip_index(m);
    const LinearSlipMode *linear = kept_linear_slip(m, index);
    if (linear->regime != REGIME_INERTIAL || !(linear->direction * m->state.omega.hi > 0.0)) return false;
    const LinearSegment s = linear_segment_from_here(m, linear);
    Kernel *kernel = &m->cache.kernel[index];
    if (kernel->t != h) oscillator_kernel(&linear->oscillator, h, kernel);
    SegmentEnds ends;
    linear_segment_ends(&s, kernel, &ends);
    if (!linear_segment_is_quiet(&s, &ends)) return false;
    propose(m, &s, &ends, kernel, segment);
    return true;
}

/* Does reaction i pass zero where that of `contact` does? Without a moment W both are in proportion to the axial load.
 * */
static bool crosses(const Mechanism *m, int contact, int i) {
    return i == contact || m->params.inertia.follower == 0.0;
}

void closed_form_slip_propose(Mechanism *m, double left, Segment *segment) {
    const int index = present_slip_index(m);
    const LinearSlipMode *linear = kept_linear_slip(m, index);
    const LinearSegment s = linear_segment_from_here(m, linear);
    const LinearEvent last = linear_event_horizon(&s, min_of(left, linear->oscillator.horizon));
    Kernel kernel = m->cache.kernel[index];
    if (kernel.t != last.t) oscillator_kernel(&linear->oscillator, last.t, &kernel);
    SegmentEnds ends;
    linear_segment_ends(&s, &kernel, &ends);
    const bool quiet = last.kind == EVENT_NONE && linear_segment_is_quiet(&s, &ends);
    const LinearEvent end = quiet ? (LinearEvent){.kind = EVENT_NONE} : linear_event_first(&s, last, &kernel, &ends);
    propose(m, &s, &ends, &kernel, segment);
    segment->end = end.kind;
    for (int i = 0; end.kind == EVENT_FLANK && i < 2; i++) segment->crossed[i] = crosses(m, end.contact, i);
    segment->duration = kernel.t;
}
