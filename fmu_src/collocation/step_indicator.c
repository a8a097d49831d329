#include "collocation/step_indicator.h"

#include <float.h>
#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- what may end the segment ---- */

SegmentLimits segment_limits_of(const SlipMode *slip, const Balance *start, double to_stop) {
    return (SegmentLimits){
        .slip = slip,
        .to_stop = to_stop,
        .breakpoint = breakpoint_ahead(slip, start->theta),
        .has_band_edge = slip->regime == REGIME_VISCOUS && has_friction(slip->params),
        .has_friction = has_friction(slip->params),
    };
}

/* ---- values ---- */

/* N.m, in the direction of slip. */
NOINLINE static double torque_beyond_edge(const SlipMode *slip, const Balance *b) {
    const TransmissionPoint point = piece_at(slip->piece, b->theta);
    Geometry g = cam_geometry(slip->params->cam, point.slope);
    cam_set_load(slip->params, b->force, &g);
    const BandFactors band = contact_band(&g);
    const bool loads = (slip->direction > 0) == (b->force >= 0.0);
    const double edge = min_of(max_of(loads ? band.load : band.release, -STEEPEST_EDGE), STEEPEST_EDGE);
    return slip->direction * (b->tau - edge * b->force);
}

/* Inlined where the indicator is a constant: every node of every step asks for all indicators. */
static inline double value_at(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step, int node) {
    const SlipMode *slip = limits->slip;
    const Balance *b = node < 0 ? &step->start : &step->node[node];
    const double advance = node < 0 ? 0.0 : slip->direction * step->node_dtheta[node];
    switch (indicator) {
        case STEP_SPEED: return slip->direction * b->omega;
        case STEP_TO_STOP: return limits->to_stop - advance;
        case STEP_BREAKPOINT: return breakpoint_limit(&limits->breakpoint) - advance;
        case STEP_BAND_EDGE: return torque_beyond_edge(slip, b);
        case STEP_FLANK_1: return slip->flank[0] * b->x[0];
        default: return slip->flank[1] * b->x[1];
    }
}

double step_indicator_at_end(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step) {
    return value_at(limits, indicator, step, step->method->stages - 1);
}

IndicatorRate step_indicator_rate(const SegmentLimits *limits, StepIndicator indicator, const Balance *b, double t) {
    const SlipMode *slip = limits->slip;
    const int sign = slip->direction;
    if (indicator == STEP_TO_STOP || indicator == STEP_BREAKPOINT) return (IndicatorRate){-sign * b->omega, 0.0};
    if (indicator == STEP_SPEED && slip->regime == REGIME_INERTIAL) return (IndicatorRate){sign * b->alpha, 0.0};
    BalanceRates rates;
    balance_rates(slip, b, t, &rates);
    if (indicator == STEP_SPEED) return (IndicatorRate){sign * rates.rhs, 0.0};
    const int i = step_indicator_contact(indicator);
    double size[2];
    balance_contact_sizes(slip, b, size);
    return (IndicatorRate){slip->flank[i] * rates.contact[i], DBL_EPSILON * size[i]};
}

/* ---- crossings ---- */

/* A smaller |value| of the indicator is rounding. */
static double rounding_of(const SegmentLimits *limits, StepIndicator indicator, const Balance *start) {
    if (!step_indicator_is_flank(indicator)) return 0.0;
    double size[2];
    balance_contact_sizes(limits->slip, start, size);
    return REACTION_ZERO_SHARE * size[step_indicator_contact(indicator)];
}

static inline RadauValues values_of(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step) {
    RadauValues v;
    v.value[0] = max_of(value_at(limits, indicator, step, -1), 0.0);
    for (int j = 0; j < step->method->stages; j++) v.value[j + 1] = value_at(limits, indicator, step, j);
    radau_find_range(&v, step->method->stages);
    return v;
}

/* The polynomial through the values, with rounding set to zero in values and coefficients. */
static Bernstein polynomial_of(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step,
                               RadauValues *v) {
    const int stages = step->method->stages;
    const double rounding = rounding_of(limits, indicator, &step->start);
    for (int j = 0; j <= stages; j++)
        if (fabs(v->value[j]) <= rounding) v->value[j] = 0.0;
    Bernstein p = radau_polynomial(step->method, v->value);
    const double coefficient_rounding = CROSSING_COEFFICIENT * max_of(fabs(v->low), fabs(v->high));
    for (int i = 0; i <= p.degree; i++)
        if (fabs(p.c[i]) <= coefficient_rounding) p.c[i] = 0.0;
    return p;
}

/* True if the mode decision has found this indicator to rise from zero: a crossing at once is then rounding. */
static bool starts_rising(StepIndicator indicator, double start) {
    return start == 0.0 && indicator != STEP_TO_STOP && indicator != STEP_BREAKPOINT;
}

double step_indicator_allowance(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step) {
    if (!step_indicator_is_flank(indicator) || value_at(limits, indicator, step, -1) > 0.0) return 0.0;
    return CROSSING_ALLOWANCE * CANDIDATE_COARSE * rounding_of(limits, indicator, &step->start);
}

/* Share of the step at which the indicator crosses zero, CROSSING_UNRESOLVED, or infinity. */
static double polynomial_crossing(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step,
                                  RadauValues v) {
    Bernstein p = polynomial_of(limits, indicator, step, &v);
    double x = bernstein_descent(&p);
    if (!(x < CROSSING_AT_ONCE && starts_rising(indicator, v.value[0]))) return x;
    p.c[0] = p.c[1] = 0.0;
    x = bernstein_descent(&p);
    if (!(x < CROSSING_AT_ONCE)) return x;
    const int stages = step->method->stages;
    const double allowance = step_indicator_allowance(limits, indicator, step);
    radau_find_range(&v, stages); /* rounding is zero now */
    if (!(v.value[stages] < -allowance)) {
        const bool may_dip = indicator == STEP_SPEED || step_indicator_is_flank(indicator);
        return may_dip && v.low < -max_of(allowance, CROSSING_DIP * v.high) ? CROSSING_UNRESOLVED : INFINITY;
    }
    if (step_indicator_is_flank(indicator)) return CROSSING_AT_ONCE;
    return indicator == STEP_SPEED ? x : CROSSING_UNRESOLVED;
}

static inline double crossing_of(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step) {
    const RadauValues v = values_of(limits, indicator, step);
    if (v.low > BEYOND_NODES * (v.high - v.low)) return INFINITY;
    return polynomial_crossing(limits, indicator, step, v);
}

typedef struct {
    double x;
    StepIndicator indicator;
} Crossing;

static void keep_earlier(double x, StepIndicator indicator, Crossing *first) {
    if (x < first->x) *first = (Crossing){x, indicator};
}

static bool counts(StepIndicator indicator, unsigned ignored) {
    return (ignored & (1u << indicator)) == 0;
}

/* While the speed keeps its sign, stop and breakpoint are passed only if they are passed at the end of the step. */
double step_indicator_first_crossing(const SegmentLimits *limits, const RadauStep *step, unsigned ignored,
                                     StepIndicator *which) {
    const double rest = crossing_of(limits, STEP_SPEED, step);
    Crossing first = {INFINITY, *which};
    if (counts(STEP_SPEED, ignored)) keep_earlier(rest, STEP_SPEED, &first);
    for (StepIndicator k = STEP_TO_STOP; k <= STEP_BREAKPOINT; k++) {
        if (!counts(k, ignored) || (rest == INFINITY && step_indicator_at_end(limits, k, step) > 0.0)) continue;
        const double x = crossing_of(limits, k, step);
        /* However near the stop is, the time to it follows from the acceleration. */
        keep_earlier(k == STEP_TO_STOP ? max_of(x, DBL_MIN) : x, k, &first);
    }
    if (limits->has_band_edge && counts(STEP_BAND_EDGE, ignored))
        keep_earlier(crossing_of(limits, STEP_BAND_EDGE, step), STEP_BAND_EDGE, &first);
    for (StepIndicator k = STEP_FLANK_1; limits->has_friction && k <= STEP_FLANK_2; k++)
        if (counts(k, ignored)) keep_earlier(crossing_of(limits, k, step), k, &first);
    *which = first.indicator;
    return first.x;
}
