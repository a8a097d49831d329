#include "glide.h"

#include <float.h>
#include <math.h>

#include "rare.h"

/* One value per node: the start and three more, of which the last is the end. Two of them share a vector, and one piece
 * of code serves both halves: half the size of all four in a row. */
enum { NODES = 4, END = NODES - 1, HALVES = 2 };
typedef union {
    double at[NODES];
    Both half[HALVES];
} Nodes;

typedef struct {
    Nodes node;
    Nodes once[NODES], twice[NODES]; /* [j]: the integrals, up to each node, of what is 1 at node j, else 0 */
    Nodes weight;                    /* the integral over the step */
    double missed;                   /* what a parabola through the last three nodes misses at the start, of c^3 */
    double missed_once, missed_twice; /* largest single and double integral of prod(1 - c/c_i), the shape of that */
    Nodes bernstein[NODES];           /* [j]: Bernstein coefficients of the cubic that is 1 at node j */
} Lobatto;

#include "lobatto_table.h"

/* A step that needs more is for the leaps of passage.h: they solve by Newton's method. */
enum { MAX_SWEEPS = 8 };

/* Each sweep is to bring it nearer by this factor at least. */
static const double CONTRACTION = 0.1;

/* ---- four values ---- */

static inline Nodes all(double x) {
    return (Nodes){{x, x, x, x}};
}

typedef struct {
    double low, high;
} Range;

static inline Range range_of(const Nodes *v) {
    const double *x = v->at;
    const double low[2] = {x[2] < x[0] ? x[2] : x[0], x[3] < x[1] ? x[3] : x[1]};
    const double high[2] = {x[2] > x[0] ? x[2] : x[0], x[3] > x[1] ? x[3] : x[1]};
    return (Range){low[1] < low[0] ? low[1] : low[0], high[1] > high[0] ? high[1] : high[0]};
}

static inline double size_of(Range r) {
    return fmax(r.high, -r.low);
}

/* Columns times y. */
static inline Nodes combine(const Nodes column[NODES], const Nodes *y) {
    Nodes sum;
    for (int k = 0; k < HALVES; k++)
        sum.half[k] = (column[0].half[k] * y->at[0] + column[1].half[k] * y->at[1]) +
                      (column[2].half[k] * y->at[2] + column[3].half[k] * y->at[3]);
    return sum;
}

/* Is it surely above zero throughout, times `sign`? */
static bool keeps_sign(const Nodes *v, int sign) {
    const Range r = range_of(v);
    const double low = sign > 0 ? r.low : -r.high;
    return low > BEYOND_NODES * (r.high - r.low);
}

/* ---- the balance, see balance.h, at two nodes ---- */

typedef struct {
    Both slope[2], turn[2], lift;
    Both lift_rate, turn_rate; /* only where the follower is heavy */
    Both rn[2], d[2], p, q, delta;
    Both z, force, damper;
    Both mass; /* J Delta + P m z' + Q I gamma', or without inertia what resists the speed */
    Both drag; /* 1/s, -d alpha/d omega; only where the speed matters */
} Pair;

typedef struct {
    const Way *way;
    double theta, omega, h; /* at the start, and the length of the step */
    Nodes tau, F_ext;
    Nodes turned, speed; /* rad, rad/s: theta less that of the start, omega */
    Nodes y;             /* alpha, or omega without inertia */
    double lag;          /* rad, from where the balance was taken last to where the end is now */
    Pair pair[HALVES];
} Attempt;

/* What the polynomials give at two nodes. */
typedef struct {
    Both slope[2], bend[2], z;
} Spots;

static inline Spots look(const Piece *piece, Both theta, SpotDepth depth) {
    const Spot a = piece_spot(piece, theta[0], depth), b = piece_spot(piece, theta[1], depth);
    Spots spots = {.z = {a.z, b.z}};
    for (int i = 0; i < 2; i++) {
        spots.slope[i] = (Both){a.slope[i], b.slope[i]};
        spots.bend[i] = (Both){a.bend[i], b.bend[i]};
    }
    return spots;
}

APART static void find_slopes(const Piece *piece, Both theta, Spots *out) {
    *out = look(piece, theta, SPOT_SLOPES);
}

APART static void find_slopes_and_bends(const Piece *piece, Both theta, Spots *out) {
    *out = look(piece, theta, SPOT_BENDS);
}

/* Less than zero is rounding of the polynomial of a level groove. */
static inline Both not_negative(Both v) {
    return (Both){v[0] > 0.0 ? v[0] : 0.0, v[1] > 0.0 ? v[1] : 0.0};
}

static inline Spots spots_at(const Way *w, Both theta) {
    const Piece *piece = w->piece;
    Spots spots;
    if (w->course->straight) {
        const Both none = {0.0, 0.0};
        spots = (Spots){.slope = {none + piece->slope[0][0], none + piece->slope[0][1]}};
        spots.z = piece->z[0] + theta * piece->z[1];
    } else if (w->heavy) {
        find_slopes_and_bends(piece, theta, &spots);
    } else {
        find_slopes(piece, theta, &spots);
    }
    return spots;
}

static inline void follow_grooves(const Way *w, Both theta, Pair *n) {
    const Spots spots = spots_at(w, theta);
    for (int i = 0; i < 2; i++) n->slope[i] = not_negative(spots.slope[i]);
    const Both inverse = 1.0 / (n->slope[0] + n->slope[1]);
    n->z = spots.z;
    n->turn[0] = n->slope[1] * inverse;
    n->turn[1] = n->slope[0] * inverse;
    n->lift = n->slope[0] * n->turn[0];
    if (!w->heavy) return;
    n->turn_rate = (spots.bend[1] * n->turn[1] - spots.bend[0] * n->turn[0]) * inverse;
    n->lift_rate = spots.bend[0] * n->turn[0] * n->turn[0] + spots.bend[1] * n->turn[1] * n->turn[1];
}

/* All that depends on theta, and F_0. */
static inline void shape_pair(const Way *w, Both theta, Both F_ext, Pair *n) {
    const SpringParams *spring = &w->params->spring;
    follow_grooves(w, theta, n);
    for (int i = 0; i < 2; i++) {
        const double r = w->params->cam[i].radius;
        n->rn[i] = r * (n->slope[i] + w->mu[i] * r);
        n->d[i] = r - w->mu[i] * n->slope[i];
    }
    n->q = n->d[0] * n->rn[1];
    n->p = n->rn[0] * n->rn[1];
    n->delta = n->q + n->rn[0] * n->d[1];
    const Both rate = spring->stiffness + n->z * (spring->stiffness2 + n->z * spring->stiffness3);
    n->force = spring->preload + n->z * rate + F_ext;
}

static inline bool has_damper(const Way *w) {
    return w->c + w->q > 0.0;
}

/* Does the speed matter to the acceleration? */
static inline bool is_resisted(const Way *w) {
    return w->heavy || has_damper(w) || w->params->shaft.damping > 0.0;
}

/* D; to wait for z' and a product with zero would cost as much as the rest of a step's forces. */
static inline Both damper_at(const Way *w, Both lift, Both omega) {
    const Both none = {0.0, 0.0}, v = lift * omega;
    return has_damper(w) ? v * (w->c + w->q * w->direction * v) : none;
}

static inline Both inertial_pace(const Way *w, Both tau, Both omega, Pair *n) {
    const InertiaParams *in = &w->params->inertia;
    const double b = w->params->shaft.damping;
    n->damper = damper_at(w, n->lift, omega);
    Both net = n->delta * (tau - b * omega) - n->p * (n->force + n->damper), swirl = {0.0, 0.0};
    n->mass = in->shaft * n->delta;
    if (w->heavy) {
        const Both m = n->p * in->follower_mass, I = n->q * in->follower;
        n->mass += m * n->lift + I * n->turn[0];
        swirl = (m * n->lift_rate + I * n->turn_rate) * omega;
        net -= swirl * omega;
    }
    if (is_resisted(w)) {
        const Both resistance = w->c + 2.0 * w->q * w->direction * (n->lift * omega); /* dD/dv */
        n->drag = (b * n->delta + n->p * n->lift * resistance + 2.0 * swirl) / n->mass;
    }
    return net / n->mass;
}

/* B omega + C omega |omega| = N, see balance.c. */
static inline Both viscous_pace(const Way *w, Both tau, Pair *n) {
    const Both grip = n->p * n->lift, net = n->delta * tau - n->p * n->force;
    n->mass = w->params->shaft.damping * n->delta + w->c * grip;
    Both sum = 2.0 * n->mass;
    if (w->q > 0.0) {
        const Both square = n->mass * n->mass + (4.0 * w->q * w->direction) * grip * n->lift * net;
        sum = n->mass + (Both){sqrt(square[0]), sqrt(square[1])};
    }
    const Both omega = 2.0 * net / sum;
    n->damper = damper_at(w, n->lift, omega);
    return omega;
}

/* ---- the collocation equations ---- */

static inline bool is_inertial(const Attempt *s) {
    return s->way->kind == FLOW_INERTIAL;
}

/* The balance where the nodes are. */
static inline void balance_nodes(Attempt *s) {
    const Way *w = s->way;
    for (int k = 0; k < HALVES; k++) {
        Pair *n = &s->pair[k];
        shape_pair(w, s->theta + s->turned.half[k], s->F_ext.half[k], n);
        if (is_inertial(s)) s->y.half[k] = inertial_pace(w, s->tau.half[k], s->speed.half[k], n);
        else s->y.half[k] = s->speed.half[k] = viscous_pace(w, s->tau.half[k], n);
    }
}

/* Is there a motion where the nodes are, and is it this one? */
static inline bool is_possible(const Attempt *s) {
    bool possible = true;
    for (int k = 0; k < NODES; k++) {
        const Pair *n = &s->pair[k / 2];
        const double mass = n->mass[k % 2], delta = n->delta[k % 2];
        possible &= is_inertial(s) ? mass * delta > 0.0 : delta > 0.0 && mass >= 0.0 && n->p[k % 2] > 0.0;
    }
    return possible;
}

static inline void place_nodes(Attempt *s) {
    const double h = s->h;
    const Nodes once = combine(LOBATTO.once, &s->y);
    if (!is_inertial(s)) {
        for (int k = 0; k < HALVES; k++) s->turned.half[k] = h * once.half[k];
        return;
    }
    const Nodes twice = combine(LOBATTO.twice, &s->y);
    for (int k = 0; k < HALVES; k++) {
        s->turned.half[k] = h * (LOBATTO.node.half[k] * s->omega + h * twice.half[k]);
        s->speed.half[k] = s->omega + h * once.half[k];
    }
}

/* What the next sweep would change, nearly: if y grew with theta everywhere as it does in the mean, less what the speed
 * does, which is known. */
static inline Nodes next_change(const Attempt *s, const Nodes *change) {
    const double h = s->h, per_turn = 1.0 / s->turned.at[END];
    double growth = (s->y.at[END] - s->y.at[0]) * per_turn;
    Nodes next = combine(LOBATTO.once, change);
    if (!is_inertial(s)) {
        for (int k = 0; k < HALVES; k++) next.half[k] *= growth * h;
        return next;
    }
    const bool resisted = is_resisted(s->way);
    if (resisted) growth += s->pair[HALVES - 1].drag[1] * (s->speed.at[END] - s->omega) * per_turn;
    const Nodes twice = combine(LOBATTO.twice, change);
    for (int k = 0; k < HALVES; k++) {
        const Both by_angle = growth * h * h * twice.half[k];
        next.half[k] = resisted ? by_angle - s->pair[k].drag * (h * next.half[k]) : by_angle;
    }
    return next;
}

static inline void drive_nodes(Attempt *s) {
    const Inputs *in = s->way->inputs;
    s->tau = all(in->tau[0]);
    s->F_ext = all(in->F_ext[0]);
    for (int k = 1; k < NODES && !s->way->steady; k++) {
        const double t = s->h * LOBATTO.node.at[k];
        s->tau.at[k] = input_value(in->tau, t);
        s->F_ext.at[k] = input_value(in->F_ext, t);
    }
}

/* The pace at the start, nearly: a first guess. */
static inline double first_pace(const Way *w, const Launchpad *from) {
    const Params *p = w->params;
    const Geometry *g = from->geometry;
    double rn[2], d[2];
    for (int i = 0; i < 2; i++) {
        rn[i] = g->radius[i] * (g->slope[i] + w->mu[i] * g->radius[i]);
        d[i] = g->radius[i] - w->mu[i] * g->slope[i];
    }
    const double grip = rn[0] * rn[1], delta = d[0] * rn[1] + rn[0] * d[1];
    double drag = delta * p->shaft.damping;
    if (has_damper(w)) drag += grip * g->lift * (w->c + w->q * fabs(g->lift * from->omega));
    const double net =
        delta * w->inputs->tau[0] - grip * (spring_force(&p->spring, from->z) + w->inputs->F_ext[0]);
    if (w->kind != FLOW_INERTIAL) return net / drag;
    double mass = delta * p->inertia.shaft;
    if (w->heavy) mass += grip * p->inertia.follower_mass * g->lift;
    return (net - drag * from->omega) / mass;
}

/* Where the step must end: at `distance`, rad from the start on, give or take `slack`. */
typedef struct {
    bool given;
    double distance, slack;
} Goal;

/* Sweeps until the equations hold to a share of the tolerance. With a goal, h is sought along with them. */
static bool sweep(Attempt *s, const Goal *goal) {
    static const double SHARE = 0.05, ON_GOAL = 1e-8;
    const Way *w = s->way;
    const double wanted = SHARE * w->params->tolerance * fabs(s->omega) / (is_inertial(s) ? s->h : 1.0);
    double before = INFINITY, missed = 0.0;
    for (int n = 0; n < MAX_SWEEPS; n++) {
        Nodes change = s->y;
        const double end = s->turned.at[END];
        if (n == 0 || (goal->given && !w->steady)) drive_nodes(s);
        balance_nodes(s);
        for (int k = 0; k < HALVES; k++) change.half[k] = s->y.half[k] - change.half[k];
        const double size = size_of(range_of(&change));
        const Nodes next = next_change(s, &change);
        const bool done = n > 0 && size_of(range_of(&next)) <= wanted;
        for (int k = 0; k < HALVES && !done; k++) s->y.half[k] += next.half[k];
        place_nodes(s);
        if (goal->given) {
            missed = goal->distance - w->direction * s->turned.at[END];
            s->h += w->direction * missed / s->speed.at[END];
            place_nodes(s);
        }
        s->lag = s->turned.at[END] - end;
        const bool there = !goal->given || fabs(missed) <= fmin(goal->slack, ON_GOAL * goal->distance);
        if (done && there) return is_possible(s);
        if (n > 0 && !(size <= CONTRACTION * before)) {
            const double rounding = 8.0 * DBL_EPSILON * size_of(range_of(&s->y));
            return there && size <= rounding && is_possible(s);
        }
        before = size;
    }
    return false;
}

/* ---- is it good enough? ---- */

/* A parabola through the last three nodes would miss as much at the start as the cubic's highest term tells, and in
 * between the integrals of prod(1 - c/c_i) times that. Where that term happens to be small, the decay of the lower ones
 * stands for it. The cubic itself misses far less: the power of what the parabola misses, relative to speed and way, is
 * set so that of 5000 random steps that just pass all are within the tolerance, and 99 of 100 within half of it. */
static bool is_accurate(const Attempt *s) {
    static const double DECAY = 0.3;
    const Nodes c = combine(LOBATTO.bernstein, &s->y);
    const double *b = c.at, tolerance = s->way->params->tolerance;
    const double rise = 3.0 * fabs(b[1] - b[0]), bend = 3.0 * fabs(b[0] - 2.0 * b[1] + b[2]);
    const double cubic = fmax(fabs(b[3] - b[0] + 3.0 * (b[1] - b[2])), DECAY * bend * bend / (rise + bend + DBL_MIN));
    const double missed = s->h * LOBATTO.missed * cubic;
    const double way = fabs(s->turned.at[END]), noise = 64.0 * DBL_EPSILON * fabs(s->theta);
    double by_speed = 0.0, by_angle = missed * LOBATTO.missed_once;
    if (is_inertial(s)) {
        by_speed = missed * LOBATTO.missed_once / size_of(range_of(&s->speed));
        by_angle = missed * LOBATTO.missed_twice * s->h;
    }
    const double x = fmax(by_speed, fmax(by_angle - noise, 0.0) / (way + DBL_MIN));
    const double x2 = x * x, x8 = (x2 * x2) * (x2 * x2), t2 = tolerance * tolerance;
    return x < 1.0 && x8 * x2 * x <= (t2 * t2) * (t2 * t2); /* x^(11/8) <= tolerance */
}

/* ---- contacts and accounts ---- */

/* Contacts, and what they and the rest do: integrals over half of the nodes. */
typedef struct {
    Nodes x[2];        /* R_i/hypot(r_i, a_i) */
    Nodes reaction[2]; /* N, R_i, total */
    Booking booking;
} Loading;

static inline double sum_of_pair(Both v) {
    return v[0] + v[1];
}

static void load_pair(const Attempt *s, int k, Loading *out) {
    const Way *w = s->way;
    const InertiaParams *in = &w->params->inertia;
    const Pair *n = &s->pair[k];
    const Both omega = s->speed.half[k], v = n->lift * omega, inverse = 1.0 / n->delta;
    const Both turns = s->h * LOBATTO.weight.half[k] * omega; /* of theta and z, by the rule of the integral */
    const Both lifts = s->h * LOBATTO.weight.half[k] * v;
    Both axial = n->force + n->damper, twist = {0.0, 0.0};
    if (w->heavy) {
        const Both y = s->y.half[k], spin2 = omega * omega;
        axial += in->follower_mass * (n->lift * y + n->lift_rate * spin2);
        twist = in->follower * (n->turn[0] * y + n->turn_rate * spin2);
    }
    Booking *b = &out->booking;
    b->work_in += sum_of_pair(s->tau.half[k] * turns);
    b->work_ext += sum_of_pair(s->F_ext.half[k] * lifts);
    b->heat_damper += sum_of_pair(n->damper * lifts);
    b->heat_shaft += w->params->shaft.damping * sum_of_pair(omega * turns);
    for (int i = 0; i < 2; i++) {
        const double r = w->params->cam[i].radius;
        const Both length2 = r * r + n->slope[i] * n->slope[i];
        const Both arm = i == 0 ? -n->d[1] : n->d[0];
        const Both x = (n->rn[1 - i] * axial + arm * twist) * inverse;
        out->x[i].half[k] = x;
        out->reaction[i].half[k] = x * (Both){sqrt(length2[0]), sqrt(length2[1])};
        b->heat_cam[i] += w->mu[i] * sum_of_pair(x * length2 * n->turn[i] * turns);
    }
}

static inline double kinetic_energy(const Attempt *s, int k) {
    const Pair *n = &s->pair[k / 2];
    if (!is_inertial(s)) return 0.0;
    return kinetic_energy_of(&s->way->params->inertia, n->lift[k % 2], n->turn[0][k % 2], s->speed.at[k]);
}

static bool keeps_energy(const Attempt *s, const Booking *b) {
    const Pair *first = &s->pair[0], *last = &s->pair[HALVES - 1];
    const EnergyEnds ends = {
        .z = {first->z[0], last->z[1] + last->lift[1] * s->lag},
        .kinetic = {kinetic_energy(s, 0), kinetic_energy(s, END)},
        .spring_force = first->force[0] - s->F_ext.at[0],
        .tau = s->tau.at[END],
    };
    return leap_energy_error(s->way, b, &ends) <= 1.0;
}

/* Each contact firmly on its flank, by more than rounding at the start, and throughout? */
static bool stay_on_flanks(const Attempt *s, const Loading *loading) {
    const Way *w = s->way;
    const Pair *n = &s->pair[0];
    const double load = balance_load_size(w->params, n->force[0], n->damper[0], n->lift[0] * s->y.at[0]);
    for (int i = 0; i < 2; i++) {
        const Nodes *x = &loading->x[i];
        if (!balance_is_firm(w, i, x->at[0], n->rn[1 - i][0] / n->delta[0], load)) return false;
        if (!keeps_sign(x, w->flank[i])) return false;
    }
    return true;
}

/* Is |v|, where it exceeds what is known, largest at an end? */
static bool peaks_at_end(const Nodes *v, double known) {
    const Range r = range_of(v);
    if (size_of(r) + BEYOND_NODES * (r.high - r.low) <= known) return true;
    const Nodes c = combine(LOBATTO.bernstein, v);
    const double a = c.at[1] - c.at[0], b = c.at[2] - c.at[1], d = c.at[3] - c.at[2];
    return (a >= 0.0 && b >= 0.0 && d >= 0.0) || (a <= 0.0 && b <= 0.0 && d <= 0.0);
}

static inline double at_ends(const Nodes *v) {
    return fmax(fabs(v->at[0]), fabs(v->at[END]));
}

static void find_peaks(const Attempt *s, const Loading *loading, const Peaks *known, Glide *out) {
    const double contacts = s->way->params->contacts;
    const bool steady = is_inertial(s) && keeps_sign(&s->y, s->y.at[0] > 0.0 ? 1 : -1);
    out->peaks_inside = !steady && !peaks_at_end(&s->speed, known->omega);
    out->peak_omega = at_ends(&s->speed);
    for (int i = 0; i < 2; i++) {
        const Nodes *reaction = &loading->reaction[i];
        out->peaks_inside = out->peaks_inside || !peaks_at_end(reaction, known->reaction[i] * contacts);
        out->peak_reaction[i] = at_ends(reaction) / contacts;
    }
}

/* ---- the step ---- */

/* Does nothing happen in it, and is it good enough? That does not depend on whether there is a ledger. */
static bool is_quiet(const Attempt *s, const Launchpad *from, Glide *out) {
    const Way *w = s->way;
    const bool moves = keeps_sign(&s->speed, w->direction) && w->direction * s->turned.at[END] < from->room;
    out->accurate = is_accurate(s);
    if (!moves || !out->accurate) return false;
    Loading loading;
    loading.booking = (Booking){.work_in = 0.0};
    for (int k = 0; k < HALVES; k++) load_pair(s, k, &loading);
    if (has_friction(w->params) && !stay_on_flanks(s, &loading)) return false;
    if (!keeps_energy(s, &loading.booking)) return false;
    out->booking = loading.booking;
    if (w->params->ledger) find_peaks(s, &loading, from->known, out);
    return true;
}

/* Without inertia: the law's own speed at the end, not where the last sweep was. */
static double speed_at_end(const Attempt *s) {
    const Both theta = s->theta + s->turned.half[HALVES - 1];
    Pair last;
    shape_pair(s->way, theta, s->F_ext.half[HALVES - 1], &last);
    return viscous_pace(s->way, s->tau.half[HALVES - 1], &last)[1];
}

/* Under constant acceleration. */
static void guess_nodes(Attempt *s, double pace) {
    const double alpha = is_inertial(s) ? pace : 0.0;
    s->y = all(pace);
    for (int k = 0; k < HALVES; k++) {
        const Both t = s->h * LOBATTO.node.half[k];
        s->speed.half[k] = s->omega + alpha * t;
        s->turned.half[k] = t * (s->omega + 0.5 * alpha * t);
    }
}

bool glide_along(const Way *way, const Launchpad *from, double left, Glide *out) {
    const Border border = passage_border(way, from->theta);
    const double edge = border.distance + border.beyond, pace = first_pace(way, from);
    Goal goal = {.distance = border.distance + 0.5 * border.beyond, .slack = 0.25 * border.beyond};
    Attempt s;
    s.way = way;
    s.theta = from->theta;
    s.omega = way->kind == FLOW_INERTIAL ? from->omega : pace;
    s.h = left;
    guess_nodes(&s, pace);
    do {
        if (way->direction * s.turned.at[END] > edge) {
            const double alpha = is_inertial(&s) ? way->direction * pace : 0.0;
            goal.given = true;
            s.h = passage_ballistic_time(way->direction * s.omega, alpha, goal.distance);
            guess_nodes(&s, pace);
        }
        if (!sweep(&s, &goal)) return false;
    } while (!goal.given && way->direction * s.turned.at[END] > edge);
    if (!(s.h > 0.0 && s.h <= left) || !is_quiet(&s, from, out)) return false;
    const Both rise = LOBATTO.weight.half[0] * s.y.half[0] + LOBATTO.weight.half[1] * s.y.half[1];
    out->h = s.h;
    out->dtheta = s.turned.at[END];
    out->domega = s.h * sum_of_pair(rise);
    out->omega = is_inertial(&s) ? s.speed.at[END] : speed_at_end(&s);
    out->tau = s.tau.at[END];
    return isfinite(out->dtheta + out->omega);
}
