#include "closed_form/linear_search.h"

#include <float.h>
#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

/* Under constant inputs the indicator is a constant plus a decaying oscillation. Its first minimum is the lowest, its
 * first maximum the highest; both are among the first two extrema. */
enum { EXTREMA = 2 };

static const Oscillator *oscillator_of_indicator(const LinearIndicator *indicator) {
    return &indicator->segment->linear->oscillator;
}

/* ---- root finder ---- */

typedef enum { OF_VALUE, OF_RATE } RootOrder;

/* f and its derivatives. f is the indicator (OF_VALUE) or its rate (OF_RATE). */
typedef struct {
    double f, first, second, third;
} Derivatives;

static Derivatives derivatives_of(const LinearIndicator *indicator, const IndicatorSample *k, RootOrder order) {
    const Oscillator *osc = oscillator_of_indicator(indicator);
    if (order == OF_VALUE) return (Derivatives){k->value, k->rate, k->second, k->third};
    return (Derivatives){k->rate, k->second, k->third, -osc->decay2 * k->third - osc->stiffness * k->second};
}

/* The zero that f would have after `a` without damping and without a drive; the middle of the bracket if that zero is
 * outside. */
static double first_guess(const LinearIndicator *indicator, RootOrder order, const IndicatorSample *a, double right) {
    const Derivatives f = derivatives_of(indicator, a, order);
    const double t = a->t + oscillator_offset_zero(oscillator_of_indicator(indicator), f.f, f.first, f.second);
    return t > a->t && t < right ? t : 0.5 * (a->t + right);
}

/* True if a Newton step from t ends at the root to rounding. Newton's method misses the root by at most half the
 * largest |f''| on the step times step^2/|f'|. f'' is homogeneous, so |f''| + |f'''| |step| bounds it where the step
 * is short against the motion. A motion that is over within the rounding of t does not satisfy this. */
static bool is_last_step(const LinearIndicator *indicator, const Derivatives *f, double step, double t) {
    const double size = fabs(step), second = fabs(f->second) + fabs(f->third) * size;
    const bool exact = size <= DBL_EPSILON * t || second * size * size <= 0.25 * DBL_EPSILON * t * fabs(f->first);
    return exact && oscillator_of_indicator(indicator)->rate * size <= LINEAR_NEWTON_SHORT;
}

/* The root of f in [a->t, right], where f changes its sign. Ends when the Newton step is exact to rounding, when the
 * bracket is two neighbouring numbers, or when the indicator is 0. A rate that has decayed counts as past its zero. */
static double find_root(const LinearIndicator *indicator, RootOrder order, const IndicatorSample *a, double right) {
    const double f_left = derivatives_of(indicator, a, order).f;
    const double decayed = order == OF_VALUE ? 0.0 : LINEAR_DECAYED_RATE * fabs(f_left);
    double left = a->t, t = first_guess(indicator, order, a, right), width = right - left;
    for (int n = 0; n < ROOT_MAX_ITERATIONS; n++) {
        const IndicatorSample k = linear_indicator_at(indicator, t);
        const Derivatives f = derivatives_of(indicator, &k, order);
        if (f.f == 0.0 && order == OF_VALUE) return t;
        const bool significant = fabs(f.f) > decayed;
        if (significant && (f.f > 0.0) == (f_left > 0.0)) {
            left = t;
        } else {
            right = t;
        }
        const double step = -f.f / f.first;
        double next = t + step;
        if (significant && is_last_step(indicator, &f, step, t))
            return fabs(step) <= DBL_EPSILON * t ? t : min_of(max_of(next, left), right);
        const bool inside = next > left && next < right, slow = right - left > 0.5 * width;
        width = right - left;
        if (!inside || (slow && n % 2 == 1)) next = 0.5 * (left + right);
        if (!(next > left && next < right)) return right;
        t = next;
    }
    return right;
}

double linear_search_zero(const LinearIndicator *indicator, double t_end) {
    const IndicatorSample start = linear_indicator_at_start(indicator);
    return find_root(indicator, OF_VALUE, &start, t_end);
}

/* ---- intervals ---- */

/* Downward crossing between a and b, where the indicator is monotone, or infinity. */
static double crossing_if_monotone(const LinearIndicator *indicator, const IndicatorSample *a,
                                   const IndicatorSample *b) {
    if (!(b->value < -b->rounding)) return INFINITY;
    if (a->value <= 0.0) return a->rate > 0.0 ? INFINITY : a->t;
    return find_root(indicator, OF_VALUE, a, b->t);
}

/* The rate is monotone between a and b. True if the rate may have a zero there. A rate that has decayed at b may. */
static bool has_extremum(const IndicatorSample *a, const IndicatorSample *b) {
    if (a->rate == 0.0) return false;
    return (a->rate > 0.0) != (b->rate > 0.0) || fabs(b->rate) < LINEAR_DECAYED_RATE * fabs(a->rate);
}

/* The value where the tangents at a and b intersect. With a monotone rate the indicator lies between its chord and
 * that value. */
static double tangents_intersection(const IndicatorSample *a, const IndicatorSample *b) {
    const double length = b->t - a->t;
    const double x = (b->value - a->value - b->rate * length) / (a->rate - b->rate);
    return a->value + a->rate * min_of(max_of(x, 0.0), length);
}

/* True if the indicator stays above zero between a and b: then its extremum need not be found. */
static bool is_above_zero(const IndicatorSample *a, const IndicatorSample *b) {
    return min_of(min_of(a->value, b->value), tangents_intersection(a, b)) > a->rounding + b->rounding;
}

/* Downward crossing between a and b, where the rate is monotone, or infinity. */
static double crossing_if_rate_monotone(const LinearIndicator *indicator, const IndicatorSample *a,
                                        const IndicatorSample *b) {
    if (!has_extremum(a, b)) return crossing_if_monotone(indicator, a, b);
    if (is_above_zero(a, b)) return INFINITY;
    const IndicatorSample extremum = linear_indicator_at(indicator, find_root(indicator, OF_RATE, a, b->t));
    const double t = crossing_if_monotone(indicator, a, &extremum);
    return t < INFINITY ? t : crossing_if_monotone(indicator, &extremum, b);
}

/* ---- first crossing ---- */

static double first_extremum(const LinearIndicator *indicator, const IndicatorSample *start) {
    return oscillator_zero(oscillator_of_indicator(indicator), start->rate, start->second);
}

/* Constant inputs: the indicator is monotone between the zeros of its rate. */
static double crossing_at_constant_inputs(const LinearIndicator *indicator, double t_end) {
    IndicatorSample a = linear_indicator_at_start(indicator);
    double next = first_extremum(indicator, &a);
    for (int n = 0; n < EXTREMA; n++) {
        const IndicatorSample b = linear_indicator_at(indicator, min_of(next, t_end));
        const double t = crossing_if_monotone(indicator, &a, &b);
        if (t < INFINITY || next >= t_end) return t;
        a = b;
        next += oscillator_of_indicator(indicator)->half_period;
    }
    return INFINITY;
}

/* How many whole half periods after `k` hold no crossing. The indicator is a straight line plus a decaying oscillation
 * y; y and y' follow from y'' and y''' by the homogeneous equation. */
static double half_periods_to_skip(const LinearIndicator *indicator, const IndicatorSample *k) {
    const Oscillator *osc = oscillator_of_indicator(indicator);
    const double dy = -(k->third + osc->decay2 * k->second) / osc->stiffness;
    const double y = -(k->second + osc->decay2 * dy) / osc->stiffness;
    const double drift = k->rate - dy;
    if (!(drift < 0.0)) return INFINITY; /* later minima lie higher than the earlier ones */
    const double phase = (dy + 0.5 * osc->decay2 * y) / osc->frequency, amplitude = sqrt(y * y + phase * phase);
    const double clear = (k->value - y - amplitude) / -drift;
    return floor(max_of(clear, 0.0) / osc->half_period);
}

/* End of the interval after `a` in which the rate is monotone: the next zero of the second derivative. */
static double next_monotone_rate_end(const Oscillator *osc, const IndicatorSample *a) {
    return a->t + oscillator_zero(osc, a->second, a->third);
}

/* End of the first interval in which the rate is monotone. Where damping is strong, the slow part of the motion is lost
 * in the rounding of the derivatives at the start, and so is a zero of the second derivative. The interval ends at the
 * latest where the fast part has decayed. */
static double first_monotone_rate_end(const Oscillator *osc, const IndicatorSample *start) {
    const double fast = osc->separation > 0.0 ? 0.5 * osc->decay2 + osc->frequency : 0.0; /* 1/s */
    const double faded = fast > 0.0 ? LINEAR_FAST_DECAY / fast : INFINITY;
    return min_of(next_monotone_rate_end(osc, start), faded);
}

/* Searches one half period after the other. After the first minimum, half periods that hold no crossing are skipped.
 * Where the minima stay just above zero for very many periods, the search ends with the work of the step. */
double linear_search_crossing(const LinearIndicator *indicator, double t_end) {
    enum { WITH_FIRST_MINIMUM = 3 }; /* intervals that hold the first minimum, whatever the phase */
    if (has_constant_inputs(&indicator->segment->start)) return crossing_at_constant_inputs(indicator, t_end);
    const Oscillator *osc = oscillator_of_indicator(indicator);
    IndicatorSample a = linear_indicator_at_start(indicator);
    double next = first_monotone_rate_end(osc, &a);
    for (int interval = 1; !work_is_spent(indicator->segment->work); interval++) { /* at most MAX_WORK turns */
        const IndicatorSample b = linear_indicator_at(indicator, min_of(next, t_end));
        const double t = crossing_if_rate_monotone(indicator, &a, &b);
        if (t < INFINITY) return t;
        if (!(next < t_end)) return INFINITY;
        a = b;
        if (interval >= WITH_FIRST_MINIMUM) {
            const double skip = half_periods_to_skip(indicator, &a);
            if (next + skip * osc->half_period >= t_end) return INFINITY;
            if (skip > 0.0) {
                next += skip * osc->half_period;
                a = linear_indicator_at(indicator, next);
            }
        }
        if (next + osc->half_period == next) return INFINITY; /* the rounding of time hides the vibration */
        next = osc->separation > 0.0 && interval == 1 ? next_monotone_rate_end(osc, &a) : next + osc->half_period;
    }
    return INFINITY;
}

/* ---- peaks ---- */

/* Largest |indicator| between a and b, where the rate is monotone, as far as it exceeds `known`. */
static double peak_if_rate_monotone(const LinearIndicator *indicator, const IndicatorSample *a,
                                    const IndicatorSample *b, double known) {
    const double ends = max_of(fabs(a->value), fabs(b->value));
    if (!has_extremum(a, b) || fabs(tangents_intersection(a, b)) <= max_of(ends, known)) return ends;
    return max_of(ends, fabs(linear_indicator_at(indicator, find_root(indicator, OF_RATE, a, b->t)).value));
}

/* Largest |indicator| from `from` on, over `intervals` intervals of monotone rate, of which the first ends at
 * `next`. */
static double peak_in_intervals(const LinearIndicator *indicator, double from, double next, double t_end, int intervals,
                                double known) {
    double peak = 0.0;
    IndicatorSample a = linear_indicator_at(indicator, from);
    for (int n = 0; n < intervals && a.t < t_end; n++) {
        const IndicatorSample b = linear_indicator_at(indicator, min_of(next, t_end));
        peak = max_of(peak, peak_if_rate_monotone(indicator, &a, &b, max_of(peak, known)));
        a = b;
        next += oscillator_of_indicator(indicator)->half_period;
    }
    return peak;
}

static double peak_at_constant_inputs(const LinearIndicator *indicator, double t_end) {
    const IndicatorSample start = linear_indicator_at_start(indicator);
    double t = first_extremum(indicator, &start), peak = 0.0;
    for (int n = 0; n < EXTREMA && t < t_end; n++) {
        peak = max_of(peak, fabs(linear_indicator_at(indicator, t).value));
        t += oscillator_of_indicator(indicator)->half_period;
    }
    return peak;
}

/* A straight line plus a decaying oscillation: successive maxima form a convex sequence, so the largest maximum is
 * among the first ones or the last ones. */
double linear_search_peak(const LinearIndicator *indicator, double t_end, double known) {
    enum { INTERVALS = 4 };
    if (has_constant_inputs(&indicator->segment->start)) return peak_at_constant_inputs(indicator, t_end);
    const Oscillator *osc = oscillator_of_indicator(indicator);
    const IndicatorSample start = linear_indicator_at_start(indicator);
    const double first = oscillator_zero(osc, start.second, start.third);
    double peak = peak_in_intervals(indicator, 0.0, first, t_end, INTERVALS, known);
    const double late = floor((t_end - first) / osc->half_period) - (INTERVALS - 2);
    if (late > 0.0) {
        const double from = first + late * osc->half_period;
        peak = max_of(
            peak, peak_in_intervals(indicator, from, from + osc->half_period, t_end, INTERVALS, max_of(peak, known)));
    }
    return peak;
}

/* ---- peaks of a segment ---- */

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

/* ---- events ---- */

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
