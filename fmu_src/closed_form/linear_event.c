#include "closed_form/linear_event.h"

#include <float.h>
#include <math.h>

/* A quantity along an arc with its derivatives. curvature is homogeneous in oscillator.h's sense. */
typedef struct {
    double t, value, rate, curvature, third;
    double noise; /* a value of less than this is rounding */
} Track;

enum { TRACK_SPEED = 2, TRACK_EDGE = 3, TRACK_WAY = 4 }; /* 0, 1: contact i */

typedef struct {
    const LinearSegment *stretch;
    int quantity;   /* contact 0 or 1, or TRACK_* */
    double sign;    /* the track is sign * quantity: events are descents through zero */
    Kernel *kernel; /* of where the track was looked at last */
} Probe;

static Track track_of_speed(const Probe *probe, const LinearMotion *motion) {
    const Oscillator *osc = &probe->stretch->linear->oscillator;
    return (Track){
        .t = motion->t,
        .value = probe->sign * motion->omega,
        .rate = probe->sign * motion->alpha,
        .curvature = probe->sign * motion->jerk,
        .third = probe->sign * (-osc->decay2 * motion->jerk - osc->stiffness * motion->alpha),
    };
}

/* Rounding of x_i at the end of the arc: that of its terms, and of what is left of the start in omega, alpha. */
static double contact_noise(const LinearSegment *s, const LinearMotion *motion, int i) {
    const double LEFT = 0.01; /* of the start's size: with NO_REACTION a few eps */
    const SlipStart *l = &s->start;
    const double spring = fabs(s->params->spring.stiffness * s->geometry->dz_dtheta);
    const double force = fabs(s->params->spring.preload) + spring * (fabs(l->theta) + fabs(motion->dtheta)) +
                         fabs(l->F_ext) + fabs(l->F_ext_rate) * motion->t;
    return NO_REACTION * (fabs(s->linear->transfer.axial[i]) * force +
                          fabs(s->linear->speed[i]) * (fabs(motion->omega) + LEFT * fabs(l->omega)) +
                          fabs(s->linear->acceleration[i]) * (fabs(motion->alpha) + LEFT * fabs(l->alpha)));
}

static Track track_of_contact(const Probe *probe, const LinearMotion *motion) {
    const LinearSegment *s = probe->stretch;
    const Oscillator *osc = &s->linear->oscillator;
    const int i = probe->quantity;
    const ContactLoad c = linear_slip_contact(s->linear, s->params, s->geometry, &s->start, motion, i);
    const double snap = -osc->decay2 * motion->jerk - osc->stiffness * motion->alpha;
    const double crackle = -osc->decay2 * snap - osc->stiffness * motion->jerk;
    const double spring = s->linear->transfer.axial[i] * s->params->spring.stiffness * s->geometry->dz_dtheta;
    return (Track){
        .t = motion->t,
        .value = probe->sign * c.value,
        .rate = probe->sign * c.rate,
        .curvature = probe->sign * c.curvature,
        .third =
            probe->sign * (spring * motion->jerk + s->linear->speed[i] * snap + s->linear->acceleration[i] * crackle),
        .noise = contact_noise(s, motion, i),
    };
}

/* Torque beyond the edge of the stick band, tau - edge F_0. */
static Track track_of_edge(const Probe *probe, const LinearMotion *motion) {
    const LinearSegment *s = probe->stretch;
    const SlipStart *l = &s->start;
    const double spring = s->edge * s->params->spring.stiffness * s->geometry->dz_dtheta;
    const double rate = l->tau_rate - s->edge * l->F_ext_rate;
    return (Track){
        .t = motion->t,
        .value = probe->sign * (l->tau - s->edge * l->force - spring * motion->dtheta + rate * motion->t),
        .rate = probe->sign * (rate - spring * motion->omega),
        .curvature = probe->sign * -spring * motion->alpha,
        .third = probe->sign * -spring * motion->jerk,
    };
}

/* What is left of the way to the stop. */
static Track track_of_way(const Probe *probe, const LinearMotion *motion) {
    return (Track){
        .t = motion->t,
        .value = probe->stretch->room - probe->sign * motion->dtheta,
        .rate = -probe->sign * motion->omega,
        .curvature = -probe->sign * motion->alpha,
        .third = -probe->sign * motion->jerk,
    };
}

static Track track_of(const Probe *probe, const LinearMotion *motion) {
    switch (probe->quantity) {
        case TRACK_SPEED: return track_of_speed(probe, motion);
        case TRACK_EDGE: return track_of_edge(probe, motion);
        case TRACK_WAY: return track_of_way(probe, motion);
        default: return track_of_contact(probe, motion);
    }
}

static Track track_start(const Probe *probe) {
    const LinearMotion motion = linear_slip_motion_at_start(probe->stretch->linear, &probe->stretch->start);
    return track_of(probe, &motion);
}

static Track track_at(const Probe *probe, double t) {
    const LinearSlipMode *linear = probe->stretch->linear;
    oscillator_kernel(&linear->oscillator, t, probe->kernel);
    LinearMotion motion;
    linear_slip_motion(linear, &probe->stretch->start, probe->kernel, &motion);
    return track_of(probe, &motion);
}

/* A rate of less than this share of the one at the start of its bow has died away: its sign is rounding. */
static const double DEAD_RATE = 1e-13;

/* f and its derivatives: of the value (order 0) or of the rate (order 1). */
typedef struct {
    double f, slope, second, third_derivative;
} Slope;

static Slope slope_of(const Probe *probe, const Track *k, int order) {
    const Oscillator *osc = &probe->stretch->linear->oscillator;
    if (order == 0) return (Slope){k->value, k->rate, k->curvature, k->third};
    return (Slope){k->rate, k->curvature, k->third, -osc->decay2 * k->third - osc->stiffness * k->curvature};
}

/* Where between a and right to look first: at the zero that f had without damping and drive. */
static double first_guess(const Probe *probe, int order, const Track *a, double right) {
    const Slope f = slope_of(probe, a, order);
    const double t = a->t + oscillator_offset_zero(&probe->stretch->linear->oscillator, f.f, f.slope, f.second);
    return t > a->t && t < right ? t : 0.5 * (a->t + right);
}

/* Does a Newton step from t end at the root, to rounding? It misses by at most half the largest |bend| on it times
 * step^2/|slope|, and the bend, which is homogeneous, stays that large where the step is short against the motion. A motion
 * that is over within the rounding of t says nothing there. */
static bool is_last(const Probe *probe, const Slope *f, double step, double t) {
    const double SHORT = 0.1, size = fabs(step), second = fabs(f->second) + fabs(f->third_derivative) * size;
    const bool exact = size <= DBL_EPSILON * t || second * size * size <= 0.25 * DBL_EPSILON * t * fabs(f->slope);
    return exact && probe->stretch->linear->oscillator.rate * size <= SHORT;
}

/* Root of f = value (order 0) or rate (order 1) in [a->t, right] where f changes sign: Newton, kept
 * inside a shrinking bracket, until what it misses is rounding, the bracket is two neighbouring numbers or f is 0.
 * Each step that Newton does not halve the bracket is followed by a bisection, so about 2 x 60 steps bound it. A rate
 * that has died away counts as past its zero. */
static double root(const Probe *probe, int order, const Track *a, double right) {
    const double f_left = slope_of(probe, a, order).f, dead = order == 0 ? 0.0 : DEAD_RATE * fabs(f_left);
    double left = a->t, t = first_guess(probe, order, a, right), width = right - left;
    for (int n = 0; n < 200; n++) {
        const Track k = track_at(probe, t);
        const Slope f = slope_of(probe, &k, order);
        if (f.f == 0.0 && order == 0) return t;
        const bool lives = fabs(f.f) > dead;
        if (lives && (f.f > 0.0) == (f_left > 0.0)) {
            left = t;
        } else {
            right = t;
        }
        const double step = -f.f / f.slope;
        double next = t + step;
        if (lives && is_last(probe, &f, step, t))
            return fabs(step) <= DBL_EPSILON * t ? t : fmin(fmax(next, left), right);
        const bool inside = next > left && next < right, slow = right - left > 0.5 * width;
        width = right - left;
        if (!inside || (slow && n % 2 == 1)) next = 0.5 * (left + right);
        if (!(next > left && next < right)) return right;
        t = next;
    }
    return right;
}

/* Descent through zero where the track is monotone between a and b, or infinity. */
static double descent_in_piece(const Probe *probe, const Track *a, const Track *b) {
    if (!(b->value < -b->noise)) return INFINITY;
    if (a->value <= 0.0) return a->rate > 0.0 ? INFINITY : a->t;
    return root(probe, 0, a, b->t);
}

/* The rate is monotone between a and b: might it have a zero? One that has died away at b might. */
static bool has_extremum(const Track *a, const Track *b) {
    if (a->rate == 0.0) return false;
    return (a->rate > 0.0) != (b->rate > 0.0) || fabs(b->rate) < DEAD_RATE * fabs(a->rate);
}

/* Where the tangents at a and b cross: with a monotone rate the track in between lies between that and its chord. */
static double tangents_cross(const Track *a, const Track *b) {
    const double length = b->t - a->t;
    const double x = (b->value - a->value - b->rate * length) / (a->rate - b->rate);
    return a->value + a->rate * fmin(fmax(x, 0.0), length);
}

/* Is the track above zero between a and b for sure? Then an extremum cannot matter, and is not looked for. */
static bool clear_of_zero(const Track *a, const Track *b) {
    return fmin(fmin(a->value, b->value), tangents_cross(a, b)) > a->noise + b->noise;
}

/* Descent where the rate is monotone between a and b. */
static double descent_in_bow(const Probe *probe, const Track *a, const Track *b) {
    if (!has_extremum(a, b)) return descent_in_piece(probe, a, b);
    if (clear_of_zero(a, b)) return INFINITY;
    const Track m = track_at(probe, root(probe, 1, a, b->t));
    const double t = descent_in_piece(probe, a, &m);
    return t < INFINITY ? t : descent_in_piece(probe, &m, b);
}

/* How many whole half periods from `k` on surely hold no descent. The track is a straight line plus a
 * decaying oscillation y; y and y' follow from y'' and y''' by the homogeneous equation. */
static double bows_to_skip(const Probe *probe, const Track *k) {
    const Oscillator *osc = &probe->stretch->linear->oscillator;
    const double dy = -(k->third + osc->decay2 * k->curvature) / osc->stiffness;
    const double y = -(k->curvature + osc->decay2 * dy) / osc->stiffness;
    const double drift = k->rate - dy;
    if (!(drift < 0.0)) return INFINITY; /* later minima lie higher than the ones seen */
    const double phase = (dy + 0.5 * osc->decay2 * y) / osc->frequency, amplitude = sqrt(y * y + phase * phase);
    const double clear = (k->value - y - amplitude) / -drift;
    return floor(fmax(clear, 0.0) / osc->half_period);
}

static bool constant_inputs(const SlipStart *l) {
    return l->tau_rate == 0.0 && l->F_ext_rate == 0.0;
}

/* Under constant inputs the rate is homogeneous too: the track is monotone between its zeros, and its first minimum, which
 * is among the first two extrema, is the lowest. */
enum { EXTREMA = 2 };

static double first_extremum(const Probe *probe, const Track *start) {
    return oscillator_zero(&probe->stretch->linear->oscillator, start->rate, start->curvature);
}

static double descent_of_oscillation(const Probe *probe, double t_end) {
    Track a = track_start(probe);
    double next = first_extremum(probe, &a);
    for (int n = 0; n < EXTREMA; n++) {
        const Track b = track_at(probe, fmin(next, t_end));
        const double t = descent_in_piece(probe, &a, &b);
        if (t < INFINITY || next >= t_end) return t;
        a = b;
        next += probe->stretch->linear->oscillator.half_period;
    }
    return INFINITY;
}

/* First descent through zero in [0, t_end], or infinity. */
static double first_descent(const Probe *probe, double t_end) {
    enum { SURE_BOWS = 3 }; /* hold the first minimum, whatever the phase */
    if (constant_inputs(&probe->stretch->start)) return descent_of_oscillation(probe, t_end);
    const Oscillator *osc = &probe->stretch->linear->oscillator;
    Track a = track_start(probe);
    double next = oscillator_zero(osc, a.curvature, a.third);
    for (int bow = 1;; bow++) {
        const Track b = track_at(probe, fmin(next, t_end));
        const double t = descent_in_bow(probe, &a, &b);
        if (t < INFINITY) return t;
        if (next >= t_end) return INFINITY;
        a = b;
        if (bow >= SURE_BOWS) {
            const double skip = bows_to_skip(probe, &a);
            if (next + skip * osc->half_period >= t_end) return INFINITY;
            if (skip > 0.0) {
                next += skip * osc->half_period;
                a = track_at(probe, next);
            }
        }
        next += osc->half_period;
    }
}

/* Without a drive omega itself is homogeneous. */
Event event_last(const LinearSegment *s, double horizon) {
    const SlipStart *l = &s->start;
    const double rest = l->drive == 0.0 ? oscillator_zero(&s->linear->oscillator, l->omega, l->alpha) : INFINITY;
    return rest <= horizon ? (Event){EVENT_REST, rest} : (Event){EVENT_NONE, horizon};
}

/* Has a quantity with at most one zero between start and end none for sure? If it starts from zero it has had it;
 * where it has all but died away, its last sign is rounding. */
static inline bool keeps_sign(double start, double end) {
    const double DEAD = 1e-12;
    return end * start > DEAD * start * start || start == 0.0;
}

/* Has a homogeneous quantity at most one zero on the arc? */
static bool is_short(const LinearSegment *s, const SegmentEnds *ends) {
    return ends->motion.t < s->linear->oscillator.half_period;
}

/* Has the rate of x_i at most one zero on a short arc? It has if it is homogeneous (constant inputs) or monotone (no
 * zero of the curvature). */
static bool bends_once(const LinearSegment *s, const SegmentEnds *ends, int i) {
    if (constant_inputs(&s->start)) return true;
    const LinearMotion start = linear_slip_motion_at_start(s->linear, &s->start);
    return keeps_sign(linear_slip_contact(s->linear, s->params, s->geometry, &s->start, &start, i).curvature,
                      linear_slip_contact(s->linear, s->params, s->geometry, &s->start, &ends->motion, i).curvature);
}

static bool contact_is_monotone(const LinearSegment *s, const SegmentEnds *ends, int i) {
    return keeps_sign(ends->start.rate[i], ends->end.rate[i]) && bends_once(s, ends, i);
}

static bool speed_is_monotone(const LinearSegment *s, const SegmentEnds *ends) {
    return keeps_sign(s->start.alpha, ends->motion.alpha);
}

void event_ends(const LinearSegment *s, const Kernel *kernel, SegmentEnds *ends) {
    const SlipStart *l = &s->start;
    const LinearMotion start = linear_slip_motion_at_start(s->linear, l), *motion = &ends->motion;
    linear_slip_motion(s->linear, l, kernel, &ends->motion);
    ends->monotone = is_short(s, ends) && speed_is_monotone(s, ends);
    if (!s->flanks && !s->params->ledger) return;
    const double spring = s->params->spring.stiffness * s->geometry->dz_dtheta, rate = l->F_ext_rate;
    const double force = l->force + spring * motion->dtheta + rate * motion->t;
    ends->start = linear_slip_contacts(s->linear, l->force, spring * l->omega + rate, &start);
    ends->end = linear_slip_contacts(s->linear, force, spring * motion->omega + rate, motion);
    ends->monotone = ends->monotone && keeps_sign(ends->start.rate[0], ends->end.rate[0]) &&
                     keeps_sign(ends->start.rate[1], ends->end.rate[1]) &&
                     (constant_inputs(l) || (bends_once(s, ends, 0) && bends_once(s, ends, 1)));
}

/* Inertial slip at constant speed: is alpha at both ends no more than the rounding of the torques that make it? */
static bool alpha_is_noise(const LinearSegment *s, const SegmentEnds *ends) {
    const SlipStart *l = &s->start;
    if (s->linear->regime != REGIME_INERTIAL) return false;
    const double spring = fabs(s->params->spring.preload) +
                          fabs(s->params->spring.stiffness * s->geometry->dz_dtheta * l->theta) + fabs(l->F_ext);
    const double torque = fabs(l->tau) + fabs(s->linear->transfer.rho) * spring + fabs(s->linear->damping * l->omega);
    const double ROUNDING = 1e-14;
    return fmax(fabs(l->alpha), fabs(ends->motion.alpha)) * s->linear->mass <= ROUNDING * torque;
}

static inline bool ends_on_flank(const LinearSegment *s, const SegmentEnds *ends, int i) {
    const double sign = s->linear->flank[i];
    return sign * ends->start.value[i] >= 0.0 && sign * ends->end.value[i] >= 0.0;
}

/* Does x_i surely never leave its flank? If its rate has at most one zero, one that rises at the start is lowest
 * at an end; one that falls is so unless its rate turns. */
static bool contact_quiet(const LinearSegment *s, const SegmentEnds *ends, int i) {
    if (!is_short(s, ends) || !ends_on_flank(s, ends, i) || !bends_once(s, ends, i)) return false;
    return s->linear->flank[i] * ends->start.rate[i] >= 0.0 || keeps_sign(ends->start.rate[i], ends->end.rate[i]);
}

/* Does omega surely never vanish? */
static bool speed_quiet(const LinearSegment *s, const SegmentEnds *ends) {
    const double sign = s->linear->direction;
    if (!(sign * ends->motion.omega > 0.0) || !is_short(s, ends)) return false;
    return sign * s->start.alpha >= 0.0 || speed_is_monotone(s, ends) || alpha_is_noise(s, ends);
}

/* Without inertia the pin can rest elsewhere than where its speed vanishes, see LinearSegment.edge. */
static bool has_edge(const LinearSegment *s) {
    return s->linear->regime == REGIME_VISCOUS && s->edge != s->linear->transfer.rho;
}

bool event_quiet(const LinearSegment *s, const SegmentEnds *ends) {
    const LinearMotion *motion = &ends->motion;
    const double sign = s->linear->direction;
    if (!(sign * motion->dtheta < s->room && sign * motion->omega > 0.0)) return false;
    if (!(motion->t <= s->linear->oscillator.horizon) || has_edge(s)) return false;
    if (s->flanks && !(ends_on_flank(s, ends, 0) && ends_on_flank(s, ends, 1))) return false;
    if (ends->monotone) return true;
    return speed_quiet(s, ends) && (!s->flanks || (contact_quiet(s, ends, 0) && contact_quiet(s, ends, 1)));
}

typedef struct {
    const LinearSegment *stretch;
    Kernel *kernel;    /* of the arc up to the event */
    SegmentEnds *ends; /* likewise */
    Event event;
    Kernel latest; /* where a track was looked at last */
} Search;

/* The search goes on before t, unless that is INFINITY: there is no such event. */
static void keep(Search *search, EventKind kind, double t) {
    if (!(t < INFINITY)) return;
    search->event = (Event){.kind = kind, .t = t};
    if (search->latest.t == t) *search->kernel = search->latest;
    else oscillator_kernel(&search->stretch->linear->oscillator, t, search->kernel);
    event_ends(search->stretch, search->kernel, search->ends);
}

static Probe probe_of(Search *search, int quantity, double sign) {
    return (Probe){.stretch = search->stretch, .quantity = quantity, .sign = sign, .kernel = &search->latest};
}

static void keep_descent(Search *search, EventKind kind, int quantity, double sign) {
    const Probe probe = probe_of(search, quantity, sign);
    const double t = first_descent(&probe, search->event.t);
    if (t < search->event.t || search->event.kind == EVENT_NONE) keep(search, kind, t);
}

/* Time at which the way `room` is used up; theta is monotone up to t_end, where it is used up. */
static double time_of_way(Search *search) {
    if (search->stretch->room <= 0.0) return 0.0;
    const Probe probe = probe_of(search, TRACK_WAY, search->stretch->linear->direction);
    const Track start = track_start(&probe);
    return root(&probe, 0, &start, search->event.t);
}

Event event_first(const LinearSegment *s, Event last, Kernel *kernel, SegmentEnds *ends) {
    Search search = {.stretch = s, .kernel = kernel, .ends = ends, .event = last};
    search.latest.t = NAN;
    const double direction = s->linear->direction;
    if (s->start.drive != 0.0 && !speed_quiet(s, ends)) keep_descent(&search, EVENT_REST, TRACK_SPEED, direction);
    /* theta is monotone by now */
    if (direction * ends->motion.dtheta >= s->room) keep(&search, EVENT_STOP, time_of_way(&search));
    if (has_edge(s)) keep_descent(&search, EVENT_REST, TRACK_EDGE, direction);
    for (int i = 0; s->flanks && i < 2; i++)
        if (!contact_quiet(s, ends, i)) keep_descent(&search, EVENT_FLANK, i, s->linear->flank[i]);
    return search.event;
}

/* Largest |track| between a and b, rate monotone between them, as far as it is more than `known`. */
static double peak_in_bow(const Probe *probe, const Track *a, const Track *b, double known) {
    const double ends = fmax(fabs(a->value), fabs(b->value));
    if (!has_extremum(a, b) || fabs(tangents_cross(a, b)) <= fmax(ends, known)) return ends;
    return fmax(ends, fabs(track_at(probe, root(probe, 1, a, b->t)).value));
}

/* Largest |track| over `bows` bows from the zero of the curvature at or after `from`, up to t_end. */
static double peak_in_bows(const Probe *probe, double from, double next, double t_end, int bows, double known) {
    double peak = 0.0;
    Track a = track_at(probe, from);
    for (int bow = 0; bow < bows && a.t < t_end; bow++) {
        const Track b = track_at(probe, fmin(next, t_end));
        peak = fmax(peak, peak_in_bow(probe, &a, &b, fmax(peak, known)));
        a = b;
        next += probe->stretch->linear->oscillator.half_period;
    }
    return peak;
}

/* Largest |track| at an extremum before t_end. */
static double peak_of_oscillation(const Probe *probe, double t_end) {
    const Track start = track_start(probe);
    double t = first_extremum(probe, &start), peak = 0.0;
    for (int n = 0; n < EXTREMA && t < t_end; n++) {
        peak = fmax(peak, fabs(track_at(probe, t).value));
        t += probe->stretch->linear->oscillator.half_period;
    }
    return peak;
}

/* A line plus a decaying oscillation: successive maxima form a convex sequence, so the largest is
 * among the first or the last ones. */
static double peak_of(const Probe *probe, double t_end, double known) {
    enum { BOWS = 4 };
    if (constant_inputs(&probe->stretch->start)) return peak_of_oscillation(probe, t_end);
    const Oscillator *osc = &probe->stretch->linear->oscillator;
    const Track start = track_start(probe);
    const double first = oscillator_zero(osc, start.curvature, start.third);
    double peak = peak_in_bows(probe, 0.0, first, t_end, BOWS, known);
    const double late = floor((t_end - first) / osc->half_period) - (BOWS - 2);
    if (late > 0.0) {
        const double from = first + late * osc->half_period;
        peak = fmax(peak, peak_in_bows(probe, from, from + osc->half_period, t_end, BOWS, fmax(peak, known)));
    }
    return peak;
}

/* Where it might not be at an end. */
static void look_for_peaks(const LinearSegment *s, const SegmentEnds *ends, Peaks *peak) {
    if (alpha_is_noise(s, ends)) return;
    const double t = ends->motion.t;
    Kernel latest;
    const Probe speed = {.stretch = s, .quantity = TRACK_SPEED, .sign = 1.0, .kernel = &latest};
    if (!is_short(s, ends) || !speed_is_monotone(s, ends)) peak_raise(&peak->omega, peak_of(&speed, t, peak->omega));
    for (int i = 0; i < 2; i++) {
        const Probe contact = {.stretch = s, .quantity = i, .sign = 1.0, .kernel = &latest};
        const double unit = s->linear->reaction[i];
        if (!is_short(s, ends) || !contact_is_monotone(s, ends, i))
            peak_raise(&peak->reaction[i], unit * peak_of(&contact, t, peak->reaction[i] / unit));
    }
}

/* Not as a loop, which would not be unrolled. */
static inline void raise_reaction(const LinearSegment *s, const SegmentEnds *ends, int i, Peaks *peak) {
    peak_raise(&peak->reaction[i], s->linear->reaction[i] * ends->start.value[i]);
    peak_raise(&peak->reaction[i], s->linear->reaction[i] * ends->end.value[i]);
}

void event_peaks(const LinearSegment *s, const SegmentEnds *ends, Peaks *peak) {
    peak_raise(&peak->omega, s->start.omega);
    peak_raise(&peak->omega, ends->motion.omega);
    raise_reaction(s, ends, 0, peak);
    raise_reaction(s, ends, 1, peak);
    if (!ends->monotone) look_for_peaks(s, ends, peak);
}
