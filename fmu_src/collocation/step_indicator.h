/* Indicator functions along a Radau step: quantities whose downward crossing of zero ends a segment of slip.
 *
 * An indicator is known at the start of the step and at its nodes; in between it is the polynomial through these
 * values. The polynomial's first crossing is found in Bernstein form, none is stepped over (bernstein.h). */
#ifndef DUALCAM_STEP_INDICATOR_H
#define DUALCAM_STEP_INDICATOR_H

#include "collocation/breakpoint.h"
#include "collocation/radau_step.h"
#include "model/mode.h"

typedef enum {
    STEP_SPEED,      /* rad/s, speed in the direction of the slip */
    STEP_TO_STOP,    /* rad, angle left to the end stop */
    STEP_BREAKPOINT, /* rad, angle left to the limit of the breakpoint */
    STEP_BAND_EDGE,  /* N.m, viscous only: torque beyond the edge of the stick band, inside which the mechanism rests */
    STEP_FLANK_1,    /* N/m, x_1 on the flank on which contact 1 bears */
    STEP_FLANK_2,
    STEP_INDICATORS
} StepIndicator;

/* What may end the segment. */
typedef struct {
    const SlipMode *slip;
    double to_stop;        /* rad, to the end stop */
    Breakpoint breakpoint; /* ahead */
    bool has_band_edge;    /* viscous; with inertia the speed tells the rest */
    bool has_friction;     /* else it does not matter on which flank a contact bears */
} SegmentLimits;

SegmentLimits segment_limits_of(const SlipMode *slip, const Balance *start, double to_stop);

/* N/m: a reaction that begins on the wrong side of zero, by rounding, leaves its flank this much below zero, which the
 * mode decision sees; 0 for all other indicators, and for a reaction that begins on its flank. */
double step_indicator_allowance(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step);

/* The indicator at the end of the step. */
double step_indicator_at_end(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step);

/* The time derivative of the indicator, and the |value| of the indicator below which it is rounding. */
typedef struct {
    double rate, rounding;
} IndicatorRate;

/* At balance `b`, t seconds after the start. */
IndicatorRate step_indicator_rate(const SegmentLimits *limits, StepIndicator indicator, const Balance *b, double t);

/* An indicator that starts from zero was found to rise, and yet has fallen at the end of the step: the crossing shows
 * in a shorter step only. */
static const double CROSSING_UNRESOLVED = 0.0;

/* Share of the step at which the first of the indicators crosses zero, which is then *first; or CROSSING_UNRESOLVED;
 * or infinity if none crosses. Bit k of `ignored`: indicator k does not count. */
double step_indicator_first_crossing(const SegmentLimits *limits, const RadauStep *step, unsigned ignored,
                                     StepIndicator *first);

static inline EventKind step_indicator_event(StepIndicator indicator) {
    switch (indicator) {
        case STEP_SPEED:
        case STEP_BAND_EDGE: return EVENT_REST;
        case STEP_TO_STOP: return EVENT_STOP;
        case STEP_BREAKPOINT: return EVENT_NONE;
        default: return EVENT_FLANK;
    }
}

/* The contact of STEP_FLANK_1 or STEP_FLANK_2, 0 or 1. */
static inline int step_indicator_contact(StepIndicator indicator) {
    return indicator == STEP_FLANK_1 ? 0 : 1;
}

static inline bool step_indicator_is_flank(StepIndicator indicator) {
    return indicator == STEP_FLANK_1 || indicator == STEP_FLANK_2;
}

#endif
