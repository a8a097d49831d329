/* Zeros and peaks of an indicator of the closed form, none of them missed; and the event that ends a segment of slip, the
 * first velocity zero, end stop or flank change.
 *
 * The zeros of the indicator's second derivative are known (oscillator_zero). Between two of them the rate is
 * monotone, so the rate has at most one zero there. The zero of the rate divides the interval into two intervals on
 * which the indicator itself is monotone. On such an interval the signs at the two ends tell whether the indicator
 * crosses zero. Under constant inputs the rate is homogeneous too: its zeros are known and divide time directly.
 *
 * Root finder: Newton's method inside a bracket. Bracket invariant: the indicator has the sign of the left end at
 * `left` and not at `right`. A Newton step that leaves the bracket, or that follows a step in which the bracket was
 * not halved, is replaced by a bisection. (W. H. Press et al., Numerical Recipes, 3rd ed., section 9.4.) */
#ifndef DUALCAM_LINEAR_SEARCH_H
#define DUALCAM_LINEAR_SEARCH_H

#include "closed_form/linear_indicator.h"
#include "closed_form/linear_segment.h"
#include "model/mode.h"
#include "numerics/tolerances.h"

/* Time of the first downward crossing of zero in [0, t_end], s, or infinity. */
double linear_search_crossing(const LinearIndicator *indicator, double t_end);

/* Time of the zero in [0, t_end], s. The indicator is positive at 0, monotone, and not positive at t_end. */
double linear_search_zero(const LinearIndicator *indicator, double t_end);

/* Largest |indicator| at an extremum in [0, t_end], where it exceeds `known`. Values at the ends of the segment may be
 * included. */
double linear_search_peak(const LinearIndicator *indicator, double t_end, double known);

/* Raises the peaks of |omega| and |R_i| to the largest values in a segment of the length ends->motion.t. */
void linear_segment_peaks(const LinearSegment *segment, const SegmentEnds *ends, Peaks *peak);

typedef struct {
    EventKind kind;
    double t;    /* s since the start of the segment */
    int contact; /* of EVENT_FLANK: the contact whose reaction passes zero */
} LinearEvent;

/* The latest end of the segment: velocity zero, if its time follows without a search, else EVENT_NONE at `horizon`. */
LinearEvent linear_event_horizon(const LinearSegment *segment, double horizon);

/* The first event up to `last`, or `last` itself. On entry `kernel` and `ends` describe the segment up to last.t; on
 * return they describe the segment up to the event that is returned. */
LinearEvent linear_event_first(const LinearSegment *segment, LinearEvent last, Kernel *kernel, SegmentEnds *ends);

#endif
