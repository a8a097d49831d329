#include "closed_form/linear_event.h"

#include <math.h>

/* Without a drive omega itself is homogeneous. */
LinearEvent linear_event_horizon(const LinearSegment *s, double horizon) {
    const SlipStart *l = &s->start;
    const double rest = l->drive == 0.0 ? oscillator_zero(&s->linear->oscillator, l->omega, l->alpha) : INFINITY;
    return rest <= horizon ? (LinearEvent){EVENT_REST, rest, 0} : (LinearEvent){EVENT_NONE, horizon, 0};
}

/* The earliest event found so far, and what describes the segment up to it. */
typedef struct {
    const LinearSegment *segment;
    LinearEvent event;
    Kernel *kernel;
    SegmentEnds *ends;
    Kernel latest; /* of the latest sample of an indicator */
} EventSearch;

/* Ends the segment with the event, unless its time is infinite: there is no such event. */
static void end_segment_at(EventSearch *search, LinearEvent event) {
    if (!(event.t < INFINITY)) return;
    search->event = event;
    if (search->latest.t == event.t) *search->kernel = search->latest;
    else oscillator_kernel(&search->segment->linear->oscillator, event.t, search->kernel);
    linear_segment_ends(search->segment, search->kernel, search->ends);
}

static void search_crossing(EventSearch *search, EventKind kind, LinearQuantity quantity, double sign) {
    const LinearIndicator indicator = {search->segment, quantity, sign, &search->latest};
    const double t = linear_search_crossing(&indicator, search->event.t);
    const int contact = quantity == QUANTITY_CONTACT_2 ? 1 : 0;
    if (t < search->event.t || search->event.kind == EVENT_NONE)
        end_segment_at(search, (LinearEvent){kind, t, contact});
}

/* Time at which theta reaches the stop. theta is monotone up to the present event, where the stop is reached or
 * passed. */
static double time_to_stop(EventSearch *search) {
    const LinearSegment *s = search->segment;
    if (s->to_stop <= 0.0) return 0.0;
    const LinearIndicator to_stop = {s, QUANTITY_TO_STOP, s->linear->direction, &search->latest};
    return linear_search_zero(&to_stop, search->event.t);
}

LinearEvent linear_event_first(const LinearSegment *s, LinearEvent last, Kernel *kernel, SegmentEnds *ends) {
    EventSearch search = {.segment = s, .kernel = kernel, .ends = ends, .event = last};
    search.latest.t = NAN;
    const double direction = s->linear->direction;
    if (s->start.drive != 0.0 && !linear_segment_keeps_speed(s, ends))
        search_crossing(&search, EVENT_REST, QUANTITY_SPEED, direction);
    /* The segment now ends at the first velocity zero at the latest, so theta is monotone in it. */
    if (direction * ends->motion.dtheta >= s->to_stop)
        end_segment_at(&search, (LinearEvent){EVENT_STOP, time_to_stop(&search), 0});
    for (int i = 0; s->flanks && i < 2; i++) {
        if (linear_segment_has_band_edge(s, i))
            search_crossing(&search, EVENT_REST, linear_quantity_of_edge(i), direction);
        if (!linear_segment_keeps_flank(s, ends, i))
            search_crossing(&search, EVENT_FLANK, linear_quantity_of_contact(i), s->linear->flank[i]);
    }
    return search.event;
}
