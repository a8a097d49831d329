/* Indicator functions along a Radau step: quantities whose downward crossing of zero ends a segment of slip.
 *
 * An indicator is known at the start of the step and at its nodes; in between it is the polynomial through these
 * values. The polynomial's first crossing is found in Bernstein form, none is stepped over (bernstein.h).
 *
 * Where friction grows with the speed, a contact can hold the speed at the limit at which friction would jam, Delta =
 * 0: the reactions x_i = (r n A -+ d W)/Delta grow without bound toward the limit. Delta reaches zero with finite
 * reactions only where the loads vanish at the same instant. There the motion is not unique (F. Genot, B. Brogliato,
 * New results on Painleve paradoxes, European Journal of Mechanics A 18, 1999): rigid contacts could keep their
 * reactions against each other, hold, or let go. The contacts are defined to let go. */
#ifndef DUALCAM_STEP_INDICATOR_H
#define DUALCAM_STEP_INDICATOR_H

#include "collocation/breakpoint.h"
#include "collocation/radau_step.h"
#include "model/event_kind.h"

typedef enum {
    STEP_SPEED,      /* rad/s, speed in the direction of the slip */
    STEP_TO_STOP,    /* rad, angle left to the end stop */
    STEP_BREAKPOINT, /* rad, angle left to the limit of the breakpoint */
    STEP_BAND_EDGE,  /* N.m, viscous only: torque beyond the edge of the stick band */
    STEP_JAM,        /* m^3, where friction varies: Delta with the sign that Delta has at the start */
    STEP_FLANK_1,    /* N/m, x_1 on the flank on which contact 1 bears */
    STEP_FLANK_2,
    STEP_INDICATORS
} StepIndicator;

/* What may end the segment. */
typedef struct {
    const SlipMode *slip;
    double to_stop;        /* rad, to the end stop */
    Breakpoint breakpoint; /* ahead */
    bool has_band_edge;    /* viscous, with the damper's load on other flanks than the spring's */
    bool may_have_edge;    /* viscous: has_band_edge once F_0 has changed its sign, or a contact locks */
    bool has_friction;     /* else it does not matter on which flank a contact bears */
    bool has_jam;          /* friction varies, and the mechanism has inertia */
    double jam_sign;       /* of Delta at the start */
} SegmentLimits;

SegmentLimits segment_limits_of(const SlipMode *slip, const Balance *start, double to_stop);

/* A reaction that counts as zero at the start can be on the wrong side of zero there, by rounding: the mode decision takes
 * either flank. The indicator plus this allowance, N/m, then begins above zero; 0 for all other indicators. A flank is
 * left where the indicator is below zero by this much, which the decision sees. */
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
        case STEP_JAM: return EVENT_LET_GO;
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
