#include "collocation/event_location.h"

#include <float.h>
#include <math.h>

#include "collocation/breakpoint.h"
#include "collocation/step_control.h"
#include "collocation/step_indicator.h"
#include "elementary/elementary.h"
#include "numerics/tolerances.h"

/* ---- a step that ends on a crossing ---- */

typedef enum {
    CROSSING_REACHED,
    CROSSING_NONE,    /* the indicator does not fall below zero in the step: the step is as it was */
    CROSSING_BLOCKED, /* no step reaches the crossing: the contacts jam before. The step now ends before that place */
} CrossingResult;

/* Lengths of the step, s. */
typedef struct {
    double left, right; /* see the bracket invariant in event_location.h */
    bool closed;        /* the indicator is known to be negative at `right` */
} Bracket;

static void narrow(Bracket *bracket, double t, double f) {
    if (f > 0.0) {
        bracket->left = max_of(bracket->left, t);
    } else {
        bracket->right = min_of(bracket->right, t);
        bracket->closed = true;
    }
}

/* True if the next length is t to rounding, or if the bracket has no number inside. */
static bool is_found(const Bracket *bracket, double t, double next) {
    return fabs(next - t) <= LOCATION_ROUNDING * t ||
           (bracket->closed && bracket->right - bracket->left <= LOCATION_ROUNDING * bracket->right);
}

/* A step to a breakpoint may end within half the overshoot of the limit, on either side. */
static bool is_reached(const SegmentLimits *limits, StepIndicator indicator, double f) {
    return f == 0.0 || (indicator == STEP_BREAKPOINT && fabs(f) <= 0.5 * limits->breakpoint.overshoot);
}

/* Keeps the next length inside the bracket. False if the indicator is not negative at the full length: it turned before
 * it reached zero. */
static bool keep_in_bracket(const Bracket *bracket, double full, double t, double *next) {
    if (*next > bracket->left && *next < bracket->right) return true;
    if (!bracket->closed && t >= full) return false;
    *next = bracket->closed ? 0.5 * (bracket->left + bracket->right) : full;
    return true;
}

/* Shortens the step so that it ends on the crossing at the share x of the step. The edge of the stick band is bisected:
 * its rate is not known. So is a reaction that is a difference of far larger terms, whose rate is rounding: Newton's
 * method would creep. */
static CrossingResult end_on_crossing(const SegmentLimits *limits, StepIndicator indicator, double x, RadauStep *step) {
    const RadauStep whole = *step;
    SlipMode slip = *limits->slip;
    slip.to_rounding = indicator != STEP_BREAKPOINT;
    const int stages = whole.method->stages;
    const double allowance = step_indicator_allowance(limits, indicator, &whole);
    Bracket bracket = {0.0, whole.h, step_indicator_at_end(limits, indicator, &whole) + allowance < 0.0};
    bool blocked = false;
    double t = x * whole.h;
    for (int n = 0; n < LOCATION_ITERATIONS && !work_is_spent(slip.work); n++) {
        t = max_of(t, DBL_MIN);
        if (!radau_step_solve(&slip, &whole.start, t, stages, step)) {
            blocked = true;
            t = 0.5 * (bracket.left + t);
            continue;
        }
        const double f = step_indicator_at_end(limits, indicator, step) + allowance;
        if (is_reached(limits, indicator, f)) return CROSSING_REACHED;
        narrow(&bracket, t, f);
        const bool bisects = indicator == STEP_BAND_EDGE || (n >= LOCATION_NEWTON && bracket.closed);
        const IndicatorRate slope =
            bisects ? (IndicatorRate){-1.0, 0.0} : step_indicator_rate(limits, indicator, radau_step_end(step), t);
        if (fabs(f) <= slope.rounding) return CROSSING_REACHED;
        double next = bisects ? 0.5 * (bracket.left + bracket.right) : t - f / slope.rate;
        if (is_found(&bracket, t, next)) return CROSSING_REACHED;
        if (!keep_in_bracket(&bracket, whole.h, t, &next)) break;
        t = next;
    }
    /* An indicator that is all but zero at the start has its zero closer to the start than the halvings come. */
    if (!blocked && indicator != STEP_BREAKPOINT && bracket.closed &&
        radau_step_solve(&slip, &whole.start, bracket.right, stages, step))
        return CROSSING_REACHED;
    if (blocked && bracket.closed && bracket.left > 0.0 &&
        radau_step_solve(limits->slip, &whole.start, bracket.left, stages, step))
        return CROSSING_BLOCKED;
    *step = whole;
    return CROSSING_NONE;
}

/* Lengthens the step by roundings until the indicator is not positive at its end: a reaction that is only nearly zero
 * would keep its flank, and without inertia a speed its direction. If no such step is found, the step stays as it
 * is. */
static void step_past_zero(const SegmentLimits *limits, StepIndicator indicator, RadauStep *step) {
    const RadauStep landed = *step;
    SlipMode slip = *limits->slip;
    slip.to_rounding = true;
    const int stages = step->method->stages;
    double share = LOCATION_FIRST_EXTENSION;
    /* At most LOCATION_EXTENSIONS turns. */
    for (int n = 0; step_indicator_at_end(limits, indicator, step) > 0.0; n++, share *= 4.0) {
        if (n < LOCATION_EXTENSIONS && radau_step_solve(&slip, &landed.start, landed.h * (1.0 + share), stages, step))
            continue;
        *step = landed;
        return;
    }
}

/* At the end stop: true if the motion would turn back no farther beyond the stop than theta is known. Then the stop is
 * not hit. Example: a swing that began at the stop without speed returns to it. An error of its energy would let it
 * touch the stop and lose time. So a kinetic energy that the steps have gained by their errors, which the balance of
 * energy tells, hits no stop; such an error reaches no farther than the tolerance. */
static bool turns_at_stop(const SlipMode *slip, const StopAhead *stop, const RadauStep *step) {
    const Params *p = slip->params;
    const Balance *end = radau_step_end(step);
    const double doubt = p->tolerance * fabs(end->rhs.by_omega * end->omega); /* of alpha, by the error of the speed */
    const double braking = -slip->direction * end->alpha - doubt;
    if (!(braking > 0.0)) return false;
    const double beyond = end->omega * end->omega / (2.0 * braking); /* rad */
    if (beyond <= ANGLE_ROUNDING * largest_angle(p)) return true;
    const double kinetic = kinetic_energy_of(&p->inertia, end->dz_dtheta, end->dpsi_dtheta[0], end->omega);
    const double gained = stop->energy_gained + step->energy_gained;
    return beyond <= angle_tolerance(p) && kinetic <= LOCATION_STOP_GAIN * gained;
}

/* Which reactions pass zero at the end of the step? Without a moment W both are in proportion to the axial load, and
 * pass zero with it; else the one that was located. */
static void note_crossing(const SegmentLimits *limits, StepIndicator indicator, EventLocation *location) {
    const SlipMode *slip = limits->slip;
    const Balance *end = radau_step_end(&location->step);
    const bool has_moment = slip->regime == REGIME_INERTIAL && slip->params->inertia.follower > 0.0;
    const int i = step_indicator_contact(indicator);
    double size[2];
    balance_contact_sizes(slip, end, size);
    location->crossed[i] = true;
    location->crossed[1 - i] = !has_moment && fabs(end->x[1 - i]) <= CROSSING_TOGETHER * size[1 - i];
}

/* ---- the first event ---- */

static bool must_step_past(const SegmentLimits *limits, StepIndicator indicator) {
    return step_indicator_is_flank(indicator) || (indicator == STEP_SPEED && limits->slip->regime != REGIME_INERTIAL);
}

/* Ends the step on the first event in it, if there is one. An event found on the polynomial may prove to be later than
 * another one, so the indicators of the shortened step are searched again. False if what happens in the step shows in
 * a shorter step only. *solved: the length up to which the step has a solution, s. */
static bool end_on_first_event(const SegmentLimits *limits, const StopAhead *stop, EventLocation *location,
                               double *solved) {
    RadauStep *step = &location->step;
    unsigned ignored = 0;
    for (int n = 0; n < 2 * STEP_INDICATORS; n++) {
        StepIndicator first = STEP_SPEED;
        const double x = step_indicator_first_crossing(limits, step, ignored, &first);
        if (!(x < INFINITY)) break;
        *solved = step->h;
        if (x == CROSSING_UNRESOLVED) return false;
        const RadauStep before = *step;
        const CrossingResult result = end_on_crossing(limits, first, x, step);
        if (result == CROSSING_REACHED && must_step_past(limits, first)) step_past_zero(limits, first, step);
        *solved = step->h;
        if (result == CROSSING_BLOCKED) return false;
        const bool turns = first == STEP_TO_STOP && turns_at_stop(limits->slip, stop, step);
        if (result == CROSSING_REACHED && !turns) {
            location->kind = step_indicator_event(first);
            location->crossed[0] = location->crossed[1] = false;
            if (location->kind == EVENT_FLANK) note_crossing(limits, first, location);
            location->at_breakpoint = first == STEP_BREAKPOINT;
        } else {
            *step = before;
        }
        ignored |= 1u << first;
    }
    return true;
}

/* A step to a breakpoint, or to a sample of a friction table, says little about the length of the next step: the
 * earlier proposal stays. */
static void propose_next(const StepProposal *first, double to_breakpoint, EventLocation *location) {
    const RadauStep *step = &location->step;
    location->next = step_control_next(step);
    location->aimed_at_breakpoint = step->h == to_breakpoint || step->at_sample;
    if (location->aimed_at_breakpoint)
        location->next = (StepProposal){max_of(location->next.h, first->h), first->stages};
}

bool event_location_find(const SlipMode *slip, const Balance *start, const StopAhead *stop, double left,
                         const StepProposal *first, EventLocation *location) {
    const SegmentLimits limits = segment_limits_of(slip, start, stop->angle);
    const double to_breakpoint = breakpoint_time(slip, start, &limits.breakpoint);
    const double shortest = LOCATION_SHORTEST * left;
    double length = first->h < INFINITY ? first->h : step_control_first_length(slip, start), solved = 0.0;
    do { /* at most 15 turns: the length falls to LOCATION_SHORTEST */
        const double longest = min_of(min_of(left, length), to_breakpoint);
        if (!step_control_solve(slip, start, longest, first, &location->step)) return false;
        location->kind = EVENT_NONE;
        location->at_breakpoint = false;
        propose_next(first, to_breakpoint, location);
        if (end_on_first_event(&limits, stop, location, &solved)) return true;
        length = LOCATION_SHORTENING * solved;
    } while (length > shortest && !work_is_spent(slip->work));
    return false;
}
