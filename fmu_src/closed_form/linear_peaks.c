#include "closed_form/linear_peaks.h"

#include "closed_form/linear_search.h"

static void search_speed_peak(const LinearSegment *s, const SegmentEnds *ends, Peaks *peak) {
    Kernel latest;
    const LinearIndicator speed = {s, QUANTITY_SPEED, 1.0, &latest};
    peak_raise(&peak->omega, linear_search_peak(&speed, ends->motion.t, peak->omega));
}

static void search_reaction_peak(const LinearSegment *s, const SegmentEnds *ends, int i, Peaks *peak) {
    Kernel latest;
    const LinearIndicator contact = {s, linear_quantity_of_contact(i), 1.0, &latest};
    const double unit = s->linear->reaction[i];
    peak_raise(&peak->reaction[i], unit * linear_search_peak(&contact, ends->motion.t, peak->reaction[i] / unit));
}

/* Searches for the peaks of the quantities that may be largest inside the segment. */
static void raise_inner_peaks(const LinearSegment *s, const SegmentEnds *ends, Peaks *peak) {
    if (linear_segment_is_steady(s, ends)) return;
    if (!linear_segment_speed_is_monotone(s, ends)) search_speed_peak(s, ends, peak);
    for (int i = 0; i < 2; i++)
        if (!linear_segment_contact_is_monotone(s, ends, i)) search_reaction_peak(s, ends, i, peak);
}

static inline void raise_reaction_at_ends(const LinearSegment *s, const SegmentEnds *ends, int i, Peaks *peak) {
    peak_raise(&peak->reaction[i], s->linear->reaction[i] * ends->start.value[i]);
    peak_raise(&peak->reaction[i], s->linear->reaction[i] * ends->end.value[i]);
}

/* The two contacts are written out: compilers do not unroll a loop over them here. */
void linear_segment_peaks(const LinearSegment *s, const SegmentEnds *ends, Peaks *peak) {
    peak_raise(&peak->omega, s->start.omega);
    peak_raise(&peak->omega, ends->motion.omega);
    raise_reaction_at_ends(s, ends, 0, peak);
    raise_reaction_at_ends(s, ends, 1, peak);
    if (!ends->monotone) raise_inner_peaks(s, ends, peak);
}
