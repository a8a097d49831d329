/* Event location in closed form: the first velocity zero, end stop or flank change in a segment of slip.
 *
 * Every event is the downward crossing of zero of an indicator (linear_indicator.h). linear_search.h finds the first
 * crossing to rounding; none is stepped over. */
#ifndef DUALCAM_LINEAR_EVENT_H
#define DUALCAM_LINEAR_EVENT_H

#include "closed_form/linear_search.h"
#include "closed_form/linear_segment.h"
#include "model/event_kind.h"
#include "numerics/tolerances.h"

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
