#include "collocation/step_indicator.h"

#include <float.h>
#include <math.h>

#include "contact/loaded_contacts.h"
#include "elementary/elementary.h"
#include "numerics/golden_section.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- what may end the segment ---- */

/* Torque beyond the edge of the stick band, N.m, with the slopes a_i, m/rad, and the axial load F_0, N. */
NOINLINE static double torque_beyond(const SlipMode *slip, const double slope[2], double force, double tau) {
    const Geometry g = cam_geometry(slip->params->cam, slope);
    const BandFactors band = contact_band_under(slip->params, &g, fabs(force), slip->work);
    const bool loads = (slip->direction > 0) == (force >= 0.0);
    const double edge = min_of(max_of(loads ? band.load : band.release, -LINEAR_STEEPEST_EDGE), LINEAR_STEEPEST_EDGE);
    return slip->direction * (tau - edge * force);
}

/* a_i = z'/psi_i'. From r_i^2 + a_i^2 a nearly level groove would lose its digits, and the edge would be another one than
 * that of the decision. Where psi_i' = 0, the groove is the steeper one. */
COMPACT static double slope_of(const SlipMode *slip, const Balance *b, int i) {
    const double r = slip->params->cam[i].radius;
    return b->dpsi_dtheta[i] > 0.0 ? b->dz_dtheta / b->dpsi_dtheta[i] : sqrt(max_of(b->length2[i] - r * r, 0.0));
}

static double torque_beyond_edge(const SlipMode *slip, const Balance *b) {
    const double slope[2] = {slope_of(slip, b, 0), slope_of(slip, b, 1)};
    return torque_beyond(slip, slope, b->force, b->tau);
}

/* True if the damper's load is on the flanks that the spring presses on. */
static bool is_on_spring_flanks(const SlipMode *slip, const Balance *start) {
    return slip->flank[0] * start->force > 0.0 && slip->flank[1] * start->force > 0.0;
}

/* True if friction locks a contact that bears on the flank of its direction, n_i = a_i + f_i r_i < 0. The edge of the
 * stick band is then that of another pair of flanks. */
COMPACT static bool is_locked(const SlipMode *slip, const Balance *b) {
    bool locked = false;
    for (int i = 0; i < 2; i++) {
        const double r = slip->params->cam[i].radius, f = b->friction[i];
        locked |= f < 0.0 && b->length2[i] < r * r * (1.0 + f * f); /* a_i < |f_i| r_i */
    }
    return locked;
}

/* True if the edge of the stick band is another torque than the one at which this slip mode has no speed. */
static bool differs_from_edge(const SlipMode *slip, const Balance *start) {
    BalanceRates rates;
    balance_rates(slip, start, 0.0, &rates);
    const double difference = torque_beyond_edge(slip, start) - slip->direction * rates.net;
    return !(fabs(difference) <= BAND_EDGE_SAME * rates.net_size);
}

static ContactFactors factors_of(const SlipMode *slip, const Balance *b) {
    ContactFactors f;
    for (int i = 0; i < 2; i++)
        contact_factors_set(&f, i, slip->params->cam[i].radius, b->friction[i], slope_of(slip, b, i));
    contact_factors_multiply(&f);
    return f;
}

/* Delta, m^3. Where friction depends on the load, reactions grow without bound at a zero of the inertia instead. */
static double jam_determinant(const SlipMode *slip, const Balance *b) {
    return slip->friction_is_loaded ? b->rhs.resistance : factors_of(slip, b).delta;
}

/* A, N: with a mass from the reactions that balance A. */
static double axial_load(const SlipMode *slip, const Balance *b) {
    if (slip->params->inertia.follower_mass == 0.0) return b->force + b->damper;
    const ContactFactors f = factors_of(slip, b);
    return f.d[0] * b->x[0] + f.d[1] * b->x[1];
}

SegmentLimits segment_limits_of(const SlipMode *slip, const Balance *start, double to_stop) {
    SegmentLimits limits = {
        .slip = slip,
        .to_stop = to_stop,
        .breakpoint = breakpoint_ahead(slip, start->theta),
        .has_friction = has_friction(slip->params),
        .has_jam = slip->friction_varies && slip->regime == REGIME_INERTIAL,
    };
    if (limits.has_jam) limits.jam_sign = jam_determinant(slip, start) < 0.0 ? -1.0 : 1.0;
    if (slip->regime == REGIME_VISCOUS && limits.has_friction) {
        limits.has_band_edge = !is_on_spring_flanks(slip, start) && differs_from_edge(slip, start);
        limits.may_have_edge = !limits.has_band_edge;
    }
    return limits;
}

/* ---- values ---- */

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
        case STEP_JAM: return limits->jam_sign * jam_determinant(slip, b);
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
    return (IndicatorRate){slip->flank[i] * rates.contact[i], DBL_EPSILON * rates.size[i]};
}

/* ---- crossings ---- */

/* A smaller |value| of the indicator is rounding. */
COMPACT static double rounding_of(const SegmentLimits *limits, StepIndicator indicator, const Balance *start) {
    if (!step_indicator_is_flank(indicator)) return 0.0;
    BalanceRates rates;
    balance_rates(limits->slip, start, 0.0, &rates);
    return REACTION_ZERO_SHARE * rates.size[step_indicator_contact(indicator)];
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

/* Where friction depends on the load, several answers of the balance can lie within the allowance. */
COMPACT double step_indicator_allowance(const SegmentLimits *limits, StepIndicator indicator, const RadauStep *step) {
    if (limits->slip->friction_is_loaded || !step_indicator_is_flank(indicator)) return 0.0;
    if (value_at(limits, indicator, step, -1) > 0.0) return 0.0;
    const double coarse = limits->slip->friction_varies ? CANDIDATE_COARSE_VARYING : CANDIDATE_COARSE;
    return CROSSING_ALLOWANCE * coarse * rounding_of(limits, indicator, &step->start);
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

/* Can the torque come back into the stick band in the step while the mechanism moves? */
COMPACT static bool reaches_band_edge(const SegmentLimits *limits, const RadauStep *step) {
    bool reaches = limits->has_band_edge;
    for (int j = 0; limits->may_have_edge && j < step->method->stages; j++)
        reaches |= !is_on_spring_flanks(limits->slip, &step->node[j]) || is_locked(limits->slip, &step->node[j]);
    return reaches;
}

/* Where friction depends on the load, the edge of the stick band jumps where another pair of flanks begins to carry the
 * load, and bends where F_0 is zero: no polynomial through the nodes shows it. */
typedef struct {
    const SlipMode *slip;
    const RadauStep *step;
    Bernstein angle; /* rad, since the start, over the share of the step */
} LoadedEdge;

/* N.m, by which the torque lies inside the band at the share x of the step. */
COMPACT static double inside_loaded_band(const void *context, double x) {
    const LoadedEdge *edge = context;
    const SlipMode *slip = edge->slip;
    SlipCoefficients storage;
    double z;
    const double theta = edge->step->start.theta + bernstein_value(&edge->angle, x);
    const SlipCoefficients *k = slip_coefficients_at(slip, theta, 0.0, &storage, &z);
    const InputValues in = slip_inputs_at(slip, x * edge->step->h);
    const double slope[2] = {k->slope[0].value, k->slope[1].value};
    return -torque_beyond(slip, slope, spring_force(&slip->params->spring, z) + in.F_ext, in.tau);
}

/* The first place of the step, as a share of it, at which the torque is found inside the band. */
COLD static double loaded_edge_crossing(const SlipMode *slip, const RadauStep *step) {
    double angle[RADAU_MAX + 1] = {0.0};
    for (int j = 0; j < step->method->stages; j++) angle[j + 1] = step->node_dtheta[j];
    const LoadedEdge edge = {slip, step, radau_polynomial(step->method, angle)};
    return golden_section_first_positive(inside_loaded_band, &edge, -torque_beyond_edge(slip, &step->start), 1.0,
                                         LOADED_EDGE_SAMPLES, LOADED_GOLDEN_STEPS)
        .x;
}

/* Delta passes zero where the axial load does, with finite reactions; or the step has stepped over the infinite
 * reactions of a jam, which stop the motion. */
static double jam_crossing(const SegmentLimits *limits, const RadauStep *step) {
    const double x = crossing_of(limits, STEP_JAM, step);
    if (!(x < INFINITY)) return x;
    const double before = axial_load(limits->slip, &step->start);
    return before * axial_load(limits->slip, radau_step_end(step)) < 0.0 ? x : CROSSING_UNRESOLVED;
}

static double band_edge_crossing(const SegmentLimits *limits, const RadauStep *step) {
    return limits->slip->friction_is_loaded ? loaded_edge_crossing(limits->slip, step)
                                            : crossing_of(limits, STEP_BAND_EDGE, step);
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
    if (reaches_band_edge(limits, step) && counts(STEP_BAND_EDGE, ignored))
        keep_earlier(band_edge_crossing(limits, step), STEP_BAND_EDGE, &first);
    if (limits->has_jam && counts(STEP_JAM, ignored)) keep_earlier(jam_crossing(limits, step), STEP_JAM, &first);
    for (StepIndicator k = STEP_FLANK_1; limits->has_friction && k <= STEP_FLANK_2; k++)
        if (counts(k, ignored)) keep_earlier(crossing_of(limits, k, step), k, &first);
    *which = first.indicator;
    return first.x;
}
