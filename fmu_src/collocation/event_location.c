#include "collocation/event_location.h"

#include <float.h>
#include <math.h>

#include "contact/contact.h"

/* A contact rises from zero where decide() has found it to; a descent this early is rounding. */
static const double AT_ONCE = 1e-9;

/* Smooth borders between pieces may be passed by this share of a piece's width. */
static const double BREAKPOINT_PASSED = 0.02;

/* A table's knot by this share of the narrower piece, times the root of the tolerance: what third derivatives of the other
 * side do in passing is of its square. */
static const double KNOT_PASSED = 0.03;

/* Along the edge of the stick band, which may fold there, by this one. */
static const double FOLD_PASSED = 1e-10;

/* Instead of a crossing: decide() has found it to rise, and all that the leap shows is that it has fallen. */
static const double TOO_SOON = 0.0;

/* It is looked at in ever shorter leaps, down to this share of the time left. */
static const double SHORTEST = 1e-13;

enum { MAX_SHORTENINGS = 60 };

/* ---- the length of a step ---- */

/* Few stages while the motion is slow against the step. Along the edge of the band, which is solved for, stages cost
 * little against short steps. */
static int stages_for(const SlipMode *slip, const Balance *start, double h) {
    if (slip->regime == REGIME_RATE_INDEPENDENT) return RADAU_MAX;
    const double ratio = h / radau_step_time_scale(slip, start);
    if (ratio < 0.06) return 3;
    return slip->params->tolerance > 1e-6 || ratio < 0.5 ? 5 : 7;
}

double ballistic_time(double speed, double alpha, double distance) {
    const double root = speed * speed + 2.0 * alpha * distance;
    if (!(root > 0.0)) return INFINITY;
    const double sum = speed + sqrt(root);
    return sum > 0.0 ? 2.0 * distance / sum : INFINITY;
}

static double ballistic_time_of(const SlipMode *slip, const Balance *start, double distance) {
    return ballistic_time(slip->direction * start->omega, slip->direction * start->alpha, distance);
}

static double width_of_next(const SlipMode *slip) {
    const TransmissionPiece *piece = slip->piece, *first = slip->transmission->piece,
                            *last = first + slip->transmission->count - 1;
    if (piece == (slip->direction > 0 ? last : first)) return INFINITY;
    const TransmissionPiece *next = piece + slip->direction;
    return next->upper - next->lower;
}

Breakpoint event_location_breakpoint(const SlipMode *slip, double theta) {
    if (slip->transmission->straight) return (Breakpoint){INFINITY, 0.0};
    const TransmissionPiece *piece = slip->piece;
    const bool up = slip->direction > 0, knot = up ? piece->knot_upper : piece->knot_lower;
    const double by_knot =
        slip->regime == REGIME_RATE_INDEPENDENT ? FOLD_PASSED : KNOT_PASSED * sqrt(slip->params->tolerance);
    const double share = knot ? by_knot : BREAKPOINT_PASSED;
    const double next = width_of_next(slip);
    return (Breakpoint){
        .distance = fmax(slip->direction * ((up ? piece->upper : piece->lower) - theta), 0.0),
        .beyond = share * fmin(piece->upper - piece->lower, next),
    };
}

/* Time to the middle of what lies beyond the border, as seen from the start: with a pace that grows evenly, so that most
 * leaps that are to end there do. */
static double time_to_breakpoint(const SlipMode *slip, const Balance *start, const Breakpoint *breakpoint) {
    const double distance = breakpoint->distance + 0.5 * breakpoint->beyond;
    double t = ballistic_time_of(slip, start, distance);
    if (slip->regime == REGIME_RATE_INDEPENDENT) return t;
    const RightHandSide *p = &start->rhs;
    const double speed = slip->direction * start->omega;
    const double rate = slip->direction * (p->by_time + p->by_theta * start->omega + p->by_omega * start->alpha);
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const double grows = inertial ? slip->direction * start->alpha : rate, jerk = inertial ? rate : 0.0;
    for (int n = 0; n < 2 && t < INFINITY; n++) {
        const double missed = distance - t * (speed + t / 2.0 * (grows + t / 3.0 * jerk));
        const double arrival = speed + t * (grows + t / 2.0 * jerk);
        const double next = t + missed / arrival;
        if (!(fabs(next - t) < 0.1 * t)) break; /* too far off for a parabola */
        t = next;
    }
    return t;
}

/* x^(1/order), by functions that the closed form needs as well: a power would take kilobytes of tables more. */
static double root_of(double x, double order) {
    return exp(log1p(x - 1.0) / order);
}

/* How long a leap may be tried first where a vibration begins: about as long as turns out to be good with most stages.
 * Where damping rules the motion, stiffness may do no harm. */
static double first_length(const SlipMode *slip, const Balance *start) {
    static const double ORDER = 11.0, AT_ONE = 6.6; /* a length of T at 1e-9 */
    const RightHandSide *p = &start->rhs;
    const bool vibrates = slip->regime == REGIME_INERTIAL && p->by_omega * p->by_omega < fabs(p->by_theta);
    if (!vibrates) return INFINITY;
    return AT_ONE * root_of(slip->params->tolerance, ORDER) / sqrt(fabs(p->by_theta));
}

/* Of the error estimate in h. */
static double order_of(const RadauStep *radau) {
    const double n = radau->method->stages;
    return (n + 1.0) * (0.5 + n / (n + 1.0));
}

/* error^(-1/order), less a margin. */
static double factor_of(const RadauStep *radau, double order) {
    return 0.9 / root_of(fmax(fmax(radau->error, radau->energy_error), 1e-12), order);
}

/* By how much a step that has failed is to be shorter: where it is too long the error falls more slowly than its order
 * says, except along the edge of the band, which is solved for. */
static double shortening(const SlipMode *slip, const RadauStep *radau) {
    const double falls = slip->regime == REGIME_RATE_INDEPENDENT ? 1.0 : 0.7;
    return fmin(0.8, fmax(0.1, factor_of(radau, falls * order_of(radau))));
}

/* The longest good step of at most `longest`, with more stages before a shorter one. What the energy
 * balance misses may be the last digits of the course itself, which no shorter step makes better. */
static bool solve_well(const SlipMode *slip, const Balance *start, double longest, const StepProposal *first,
                       RadauStep *radau) {
    static const double ALIKE = 0.5; /* a step of less than that share of the one before needs no more stages */
    double h = longest, energy_before = INFINITY;
    int stages = stages_for(slip, start, h);
    const bool alike = first->h == INFINITY || h >= ALIKE * first->h;
    if (alike && stages < first->stages) stages = first->stages;
    for (int n = 0; n < MAX_SHORTENINGS; n++) {
        if (!radau_step_solve(slip, start, h, stages, radau)) {
            h *= 0.25;
            continue;
        }
        const bool unhelped = radau->energy_error > 0.5 * energy_before;
        if (radau->error <= 1.0 && (radau->energy_error <= 1.0 || unhelped)) return true;
        energy_before = radau->error <= 1.0 ? radau->energy_error : INFINITY;
        if (stages < RADAU_MAX) {
            stages += 2;
        } else {
            h *= shortening(slip, radau);
        }
    }
    return false;
}

/* ---- events ---- */

typedef enum { WATCH_REST, WATCH_STOP, WATCH_BREAKPOINT, WATCH_EDGE, WATCH_FLANK_1, WATCH_FLANK_2, WATCH_COUNT } Watch;

typedef struct {
    const SlipMode *slip;
    double room;       /* rad, to the stop */
    double breakpoint; /* rad, how far it may go: beyond the end of the piece by `beyond`; or infinity */
    double beyond;     /* rad */
    bool edge;         /* viscous, with the damper's load on other flanks than the spring's */
    bool friction;     /* else it does not matter on which flank a contact is */
} Guard;

/* Torque beyond the edge of the stick band, N.m. */
static double beyond_edge(const SlipMode *slip, const Balance *b) {
    const CamParams *cam = slip->params->cam;
    double slope[2];
    for (int i = 0; i < 2; i++) slope[i] = sqrt(fmax(b->length2[i] - cam[i].radius * cam[i].radius, 0.0));
    const Geometry g = cam_geometry(cam, slope);
    const BandFactors band = contact_band(&g);
    const bool loads = (slip->direction > 0) == (b->force >= 0.0);
    return slip->direction * (b->tau - (loads ? band.load : band.release) * b->force);
}

/* What must not fall below zero, at the start of a leap (node -1) or at a node. */
static inline double watched(const Guard *g, Watch watch, const RadauStep *radau, int node) {
    const Balance *b = node < 0 ? &radau->start : &radau->node[node];
    const double turned = node < 0 ? 0.0 : g->slip->direction * radau->turned[node];
    switch (watch) {
        case WATCH_REST: return g->slip->direction * b->omega;
        case WATCH_STOP: return g->room - turned;
        case WATCH_BREAKPOINT: return g->breakpoint - turned;
        case WATCH_EDGE: return beyond_edge(g->slip, b);
        case WATCH_FLANK_1: return g->slip->flank[0] * b->x[0];
        default: return g->slip->flank[1] * b->x[1];
    }
}

/* A value of x_i of less than this is zero. */
static double noise_of(const Guard *g, Watch watch, const Balance *start) {
    if (watch != WATCH_FLANK_1 && watch != WATCH_FLANK_2) return 0.0;
    BalanceRates rates;
    balance_rates(g->slip, start, 0.0, &rates);
    return NO_REACTION * rates.size[watch == WATCH_FLANK_1 ? 0 : 1];
}

static EventKind kind_of_watch(Watch watch) {
    switch (watch) {
        case WATCH_REST:
        case WATCH_EDGE: return EVENT_REST;
        case WATCH_STOP: return EVENT_STOP;
        case WATCH_BREAKPOINT: return EVENT_NONE;
        default: return EVENT_FLANK;
    }
}

/* Values at the start and at the nodes. */
typedef struct {
    double value[RADAU_MAX + 1];
    double low, high;
} Trace;

static inline void enclose(Trace *s, int stages) {
    s->low = s->high = s->value[0];
    for (int j = 1; j <= stages; j++) {
        s->low = s->value[j] < s->low ? s->value[j] : s->low;
        s->high = s->value[j] > s->high ? s->value[j] : s->high;
    }
}

static inline Trace trace_of(const Guard *g, Watch watch, const RadauStep *radau) {
    Trace s;
    s.value[0] = fmax(watched(g, watch, radau, -1), 0.0);
    for (int j = 0; j < radau->method->stages; j++) s.value[j + 1] = watched(g, watch, radau, j);
    enclose(&s, radau->method->stages);
    return s;
}

/* Share of the leap at which what is watched falls below zero, or infinity. */
static double descent(const Guard *g, Watch watch, const RadauStep *radau, Trace s) {
    const Radau *r = radau->method;
    const double noise = noise_of(g, watch, &radau->start);
    for (int j = 0; j <= r->stages; j++)
        if (fabs(s.value[j]) <= noise) s.value[j] = 0.0;
    Bernstein p = radau_polynomial(r, s.value);
    const double rounding = 1e-14 * fmax(fabs(s.low), fabs(s.high));
    for (int i = 0; i <= p.degree; i++)
        if (fabs(p.c[i]) <= rounding) p.c[i] = 0.0;
    double x = bernstein_descent(&p);
    if (x < AT_ONCE && s.value[0] == 0.0 && watch != WATCH_STOP && watch != WATCH_BREAKPOINT) {
        p.c[0] = p.c[1] = 0.0; /* decide() has found it to rise */
        x = bernstein_descent(&p);
        if (x < AT_ONCE) return s.value[r->stages] < 0.0 ? (watch == WATCH_REST ? x : TOO_SOON) : INFINITY;
    }
    return x;
}

static inline double crossing(const Guard *g, Watch watch, const RadauStep *radau) {
    const Trace s = trace_of(g, watch, radau);
    return s.low > BEYOND_NODES * (s.high - s.low) ? INFINITY : descent(g, watch, radau, s);
}

/* How what is watched changes at the end of a leap, and what of it is rounding. */
typedef struct {
    double rate, noise;
} Slope;

static Slope slope_of(const Guard *g, Watch watch, const Balance *b, double t) {
    const int sign = g->slip->direction;
    if (watch == WATCH_STOP || watch == WATCH_BREAKPOINT) return (Slope){-sign * b->omega, 0.0};
    if (watch == WATCH_REST && g->slip->regime == REGIME_INERTIAL) return (Slope){sign * b->alpha, 0.0};
    BalanceRates rates;
    balance_rates(g->slip, b, t, &rates);
    if (watch == WATCH_REST) return (Slope){sign * rates.rhs, 0.0};
    const int i = watch == WATCH_FLANK_1 ? 0 : 1;
    return (Slope){g->slip->flank[i] * rates.contact[i], DBL_EPSILON * rates.size[i]};
}

typedef enum { LANDED, NO_EVENT, BLOCKED } Landing;

/* Shortens the leap so that it ends on the event to rounding: solved again to the time that its own polynomial gives,
 * then corrected by Newton's method inside the bracket [left, right], f >= 0 at its left and (if `closed`) f < 0 at
 * its right. NO_EVENT, and the leap as it was, if it turns out that f does not fall below zero in the leap. BLOCKED if
 * there is no way to get so far: the leap has stepped over a place where the contacts jam; it then ends before that. */
static Landing shorten(const Guard *g, Watch watch, double x, RadauStep *radau) {
    enum { ITERATIONS = 150 };
    const RadauStep whole = *radau;
    SlipMode slip = *g->slip;
    slip.to_rounding = watch != WATCH_BREAKPOINT;
    const int stages = whole.method->stages;
    double left = 0.0, right = whole.h, t = x * whole.h;
    bool closed = watched(g, watch, &whole, stages - 1) < 0.0, blocked = false;
    if (x < 1e-3 && watch == WATCH_STOP) t = fmin(ballistic_time_of(g->slip, &whole.start, g->room), whole.h);
    for (int n = 0; n < ITERATIONS; n++) {
        t = fmax(t, DBL_MIN);
        if (!radau_step_solve(&slip, &whole.start, t, stages, radau)) {
            blocked = true;
            t = 0.5 * (left + t);
            continue;
        }
        const Balance *end = &radau->node[stages - 1];
        const double f = watched(g, watch, radau, stages - 1);
        if (f == 0.0 || (watch == WATCH_BREAKPOINT && fabs(f) <= 0.5 * g->beyond)) return LANDED;
        if (f > 0.0) {
            left = fmax(left, t);
        } else {
            right = fmin(right, t);
            closed = true;
        }
        const Slope slope = slope_of(g, watch, end, t);
        if (fabs(f) <= slope.noise) return LANDED;
        double next = watch == WATCH_EDGE ? 0.5 * (left + right) : t - f / slope.rate;
        if (fabs(next - t) <= 4.0 * DBL_EPSILON * t || (closed && right - left <= 4.0 * DBL_EPSILON * right))
            return LANDED;
        if (!(next > left && next < right)) {
            if (!closed && t >= whole.h) break; /* it turned before it reached zero */
            next = closed ? 0.5 * (left + right) : whole.h;
        }
        t = next;
    }
    if (blocked && closed && left > 0.0 && radau_step_solve(g->slip, &whole.start, left, stages, radau)) return BLOCKED;
    *radau = whole;
    return NO_EVENT;
}

/* At the stop, would it have turned back no farther beyond than theta is known? Then it is not stopped: a swing returns to
 * the stop where it began without speed, but an error of its energy has it touch there, and lose the time that its root of
 * a speed takes to vanish. */
static bool turns_at_stop(const Guard *g, const RadauStep *radau) {
    static const double ROUNDING = 64.0 * DBL_EPSILON; /* of the angles involved: a stretch adds up that much */
    const Params *p = g->slip->params;
    const Balance *end = &radau->node[radau->method->stages - 1];
    const double unseen = fmax(ROUNDING, p->tolerance) * largest_angle(p);
    const double braking = -g->slip->direction * end->alpha;
    return braking > 0.0 && end->omega * end->omega <= 2.0 * braking * unseen;
}

/* A load that is only nearly zero would keep its flank, and without inertia a speed its direction: the leap is made
 * longer by roundings until it is past zero. One that comes no nearer to zero stays as it is. */
static void step_past(const Guard *g, Watch watch, RadauStep *radau) {
    enum { NUDGES = 11 };
    const RadauStep landed = *radau;
    SlipMode slip = *g->slip;
    slip.to_rounding = true;
    const int stages = radau->method->stages;
    double nudge = 8.0 * DBL_EPSILON;
    for (int n = 0; watched(g, watch, radau, stages - 1) > 0.0; n++, nudge *= 4.0) {
        if (n < NUDGES && radau_step_solve(&slip, &landed.start, landed.h * (1.0 + nudge), stages, radau)) continue;
        *radau = landed;
        return;
    }
}

static Landing confirm(const Guard *g, Watch watch, double x, RadauStep *radau) {
    const Landing landing = shorten(g, watch, x, radau);
    const bool flank = watch == WATCH_FLANK_1 || watch == WATCH_FLANK_2;
    if (landing == LANDED && (flank || (watch == WATCH_REST && g->slip->regime != REGIME_INERTIAL)))
        step_past(g, watch, radau);
    return landing;
}

/* Is the damper's load on the flanks that the spring presses on? */
static bool is_on_springs_flanks(const SlipMode *slip, const Balance *start) {
    return slip->flank[0] * start->force > 0.0 && slip->flank[1] * start->force > 0.0;
}

static Guard guard_of(const SlipMode *slip, const Balance *start, double room, const Breakpoint *breakpoint) {
    Guard g = {
        .slip = slip,
        .room = room,
        .breakpoint = breakpoint->distance + breakpoint->beyond,
        .beyond = breakpoint->beyond,
        .friction = has_friction(slip->params),
    };
    if (slip->regime == REGIME_VISCOUS && g.friction && !is_on_springs_flanks(slip, start)) {
        BalanceRates rates;
        balance_rates(slip, start, 0.0, &rates);
        const double differs = beyond_edge(slip, start) - slip->direction * rates.net;
        g.edge = !(fabs(differs) <= 1e-12 * rates.net_size);
    }
    return g;
}

/* ---- peaks ---- */

/* N, total */
static double reaction_of(const Balance *b, int i) {
    return b->x[i] * sqrt(b->length2[i]);
}

/* Is alpha of one sign throughout, so that |omega| is largest at an end? */
static bool is_speed_monotone(const RadauStep *radau) {
    Trace s = {.value = {radau->start.alpha}};
    for (int j = 0; j < radau->method->stages; j++) s.value[j + 1] = radau->node[j].alpha;
    enclose(&s, radau->method->stages);
    return fmax(s.low, -s.high) > BEYOND_NODES * (s.high - s.low);
}

/* The largest size of what the trace is of. */
static double peak_of(const SlipMode *slip, const RadauStep *radau, const Trace *s, double known, int contact) {
    const Radau *r = radau->method;
    const double ends = fmax(fabs(s->value[0]), fabs(s->value[r->stages]));
    if (fmax(fabs(s->low), fabs(s->high)) + BEYOND_NODES * (s->high - s->low) <= known) return ends;
    const Bernstein p = radau_polynomial(r, s->value);
    if (bernstein_is_monotone(&p)) return ends;
    const double x = bernstein_peak(&p);
    const double size = fabs(bernstein_value(&p, x));
    if (!(size > ends) || x <= 0.0 || x >= 1.0) return ends;
    RadauStep part; /* ends at the peak: its end is more exact than nodes and polynomial inside a step */
    if (!radau_step_solve(slip, &radau->start, x * radau->h, r->stages, &part)) return size;
    if (contact < 0) return fmax(ends, fabs(part.node[r->stages - 1].omega));
    return fmax(ends, fabs(reaction_of(&part.node[r->stages - 1], contact)));
}

static double peak_of_speed(const SlipMode *slip, const RadauStep *radau, double known) {
    const int n = radau->method->stages;
    if (is_speed_monotone(radau)) return fmax(fabs(radau->start.omega), fabs(radau->node[n - 1].omega));
    Trace s = {.value = {radau->start.omega}};
    for (int j = 0; j < n; j++) s.value[j + 1] = radau->node[j].omega;
    enclose(&s, n);
    return peak_of(slip, radau, &s, known, -1);
}

void event_location_peaks(const SlipMode *slip, EventLocation *location, double known_omega,
                          const double known_reaction[2]) {
    const RadauStep *radau = &location->radau;
    const int n = radau->method->stages;
    location->omega = peak_of_speed(slip, radau, known_omega);
    for (int i = 0; i < 2; i++) {
        Trace s = {.value = {reaction_of(&radau->start, i)}};
        for (int j = 0; j < n; j++) s.value[j + 1] = reaction_of(&radau->node[j], i);
        enclose(&s, n);
        location->reaction[i] = peak_of(slip, radau, &s, known_reaction[i], i);
    }
}

/* ---- the passage ---- */

static void keep_earlier(double x, Watch watch, double *first, Watch *which) {
    if (!(x < *first)) return;
    *first = x;
    *which = watch;
}

/* The first crossing in the leap; infinity if nothing happens. While the speed keeps its sign, a stop or border is
 * passed only if it is at the end. */
static double first_crossing(const Guard *g, const RadauStep *radau, unsigned ignored, Watch *which) {
    const int end = radau->method->stages - 1;
    const double rest = crossing(g, WATCH_REST, radau);
    double first = INFINITY;
    if (!(ignored & (1u << WATCH_REST))) keep_earlier(rest, WATCH_REST, &first, which);
    for (Watch watch = WATCH_STOP; watch <= WATCH_BREAKPOINT; watch++) {
        if (ignored & (1u << watch) || (rest == INFINITY && watched(g, watch, radau, end) > 0.0)) continue;
        keep_earlier(crossing(g, watch, radau), watch, &first, which);
    }
    if (g->edge && !(ignored & (1u << WATCH_EDGE)))
        keep_earlier(crossing(g, WATCH_EDGE, radau), WATCH_EDGE, &first, which);
    for (Watch watch = WATCH_FLANK_1; g->friction && watch <= WATCH_FLANK_2; watch++)
        if (!(ignored & (1u << watch))) keep_earlier(crossing(g, watch, radau), watch, &first, which);
    return first;
}

typedef enum { SETTLED, TOO_LONG } Search;

/* Ends the leap on the first event in it, if any. An event found by its polynomial may prove later than another one, so the
 * shortened leap is looked at again. TOO_LONG: what happens in it shows in a shorter leap only; `good` is the length up
 * to which there is a way. */
static Search find_event(const Guard *g, EventLocation *location, double *good) {
    RadauStep *radau = &location->radau;
    unsigned ignored = 0;
    for (int n = 0; n < 2 * WATCH_COUNT; n++) {
        Watch which = WATCH_REST;
        const double x = first_crossing(g, radau, ignored, &which);
        if (!(x < INFINITY)) break;
        *good = radau->h;
        if (x == TOO_SOON) return TOO_LONG;
        const RadauStep before = *radau;
        const Landing landing = confirm(g, which, x, radau);
        *good = radau->h;
        if (landing == BLOCKED) return TOO_LONG;
        if (landing == LANDED && !(which == WATCH_STOP && turns_at_stop(g, radau))) {
            location->kind = kind_of_watch(which);
            location->at_breakpoint = which == WATCH_BREAKPOINT;
        } else {
            *radau = before;
        }
        ignored |= 1u << which;
    }
    return SETTLED;
}

bool event_location_find(const SlipMode *slip, const Balance *start, double room, double left,
                         const StepProposal *first, EventLocation *location) {
    RadauStep *radau = &location->radau;
    const Breakpoint breakpoint = event_location_breakpoint(slip, start->theta);
    const Guard g = guard_of(slip, start, room, &breakpoint);
    const double to_breakpoint = time_to_breakpoint(slip, start, &breakpoint), shortest = SHORTEST * left;
    double length = first->h < INFINITY ? first->h : first_length(slip, start), good = 0.0;
    do {
        if (!solve_well(slip, start, fmin(fmin(left, length), to_breakpoint), first, radau)) return false;
        location->kind = EVENT_NONE;
        location->at_breakpoint = false;
        const double longer = fmin(4.0, fmax(factor_of(radau, order_of(radau)), 1.0));
        location->next = (StepProposal){radau->h * longer, radau->method->stages};
        location->for_breakpoint = radau->h == to_breakpoint; /* then its length says little */
        if (location->for_breakpoint) location->next = (StepProposal){fmax(location->next.h, first->h), first->stages};
        if (find_event(&g, location, &good) == SETTLED) return true;
        length = 0.125 * good;
    } while (length > shortest);
    return false;
}
