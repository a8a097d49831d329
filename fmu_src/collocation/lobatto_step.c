#include "collocation/lobatto_step.h"

#include <float.h>
#include <math.h>

#include "platform/attributes.h"

/* One value per node: the start and three more, of which the last is the end. Two of them share a vector, and one piece
 * of code serves both halves: half the size of all four in a row. */
enum { NODES = 4, END = NODES - 1, HALVES = 2 };
typedef union {
    double at[NODES];
    Both half[HALVES];
} Nodes;

typedef struct {
    Nodes node;
    Nodes once[NODES], twice[NODES];  /* [j]: the integrals, up to each node, of what is 1 at node j, else 0 */
    Nodes weight;                     /* the integral over the step */
    double missed;                    /* what a parabola through the last three nodes misses at the start, of c^3 */
    double missed_once, missed_twice; /* largest single and double integral of prod(1 - c/c_i), the shape of that */
    Nodes bernstein[NODES];           /* [j]: Bernstein coefficients of the cubic that is 1 at node j */
} Lobatto;

#include "numerics/lobatto_table.h"

/* A step that needs more is for the leaps of event_location.h: they solve by Newton's method. */
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
    Both slope[2], dpsi_dtheta[2], dz_dtheta;
    Both d2z_dtheta2, d2gamma_dtheta2; /* only where the follower is heavy */
    Both rn[2], d[2], p, q, delta;
    Both z, force, damper;
    Both mass;         /* J Delta + P m z' + Q I gamma', or without inertia what resists the speed */
    Both damping_rate; /* 1/s, -d alpha/d omega; only where the speed matters */
} Pair;

typedef struct {
    const SlipMode *slip;
    double theta, omega, h; /* at the start, and the length of the step */
    Nodes tau, F_ext;
    Nodes turned, speed; /* rad, rad/s: theta less that of the start, omega */
    Nodes y;             /* alpha, or omega without inertia */
    double lag;          /* rad, from where the balance was taken last to where the end is now */
    Pair pair[HALVES];
} Attempt;

/* What the polynomials give at two nodes. */
typedef struct {
    Both slope[2], dslope_dtheta[2], z;
} PointPair;

static inline PointPair point_pair(const TransmissionPiece *piece, Both theta, TransmissionDepth depth) {
    const TransmissionPoint a = piece_point(piece, theta[0], depth), b = piece_point(piece, theta[1], depth);
    PointPair points = {.z = {a.z, b.z}};
    for (int i = 0; i < 2; i++) {
        points.slope[i] = (Both){a.slope[i], b.slope[i]};
        points.dslope_dtheta[i] = (Both){a.dslope_dtheta[i], b.dslope_dtheta[i]};
    }
    return points;
}

NOINLINE static void find_slopes(const TransmissionPiece *piece, Both theta, PointPair *out) {
    *out = point_pair(piece, theta, TRANSMISSION_SLOPES);
}

NOINLINE static void find_slopes_and_bends(const TransmissionPiece *piece, Both theta, PointPair *out) {
    *out = point_pair(piece, theta, TRANSMISSION_FIRST_DERIVATIVES);
}

/* Less than zero is rounding of the polynomial of a level groove. */
static inline Both not_negative(Both v) {
    return (Both){v[0] > 0.0 ? v[0] : 0.0, v[1] > 0.0 ? v[1] : 0.0};
}

static inline PointPair points_at(const SlipMode *slip, Both theta) {
    const TransmissionPiece *piece = slip->piece;
    PointPair points;
    if (slip->transmission->straight) {
        const Both none = {0.0, 0.0};
        points = (PointPair){.slope = {none + piece->slope[0][0], none + piece->slope[0][1]}};
        points.z = piece->z[0] + theta * piece->z[1];
    } else if (slip->heavy) {
        find_slopes_and_bends(piece, theta, &points);
    } else {
        find_slopes(piece, theta, &points);
    }
    return points;
}

static inline void follow_grooves(const SlipMode *slip, Both theta, Pair *n) {
    const PointPair points = points_at(slip, theta);
    for (int i = 0; i < 2; i++) n->slope[i] = not_negative(points.slope[i]);
    const Both inverse = 1.0 / (n->slope[0] + n->slope[1]);
    n->z = points.z;
    n->dpsi_dtheta[0] = n->slope[1] * inverse;
    n->dpsi_dtheta[1] = n->slope[0] * inverse;
    n->dz_dtheta = n->slope[0] * n->dpsi_dtheta[0];
    if (!slip->heavy) return;
    n->d2gamma_dtheta2 =
        (points.dslope_dtheta[1] * n->dpsi_dtheta[1] - points.dslope_dtheta[0] * n->dpsi_dtheta[0]) * inverse;
    n->d2z_dtheta2 = points.dslope_dtheta[0] * n->dpsi_dtheta[0] * n->dpsi_dtheta[0] +
                     points.dslope_dtheta[1] * n->dpsi_dtheta[1] * n->dpsi_dtheta[1];
}

/* All that depends on theta, and F_0. */
static inline void shape_pair(const SlipMode *slip, Both theta, Both F_ext, Pair *n) {
    const SpringParams *spring = &slip->params->spring;
    follow_grooves(slip, theta, n);
    for (int i = 0; i < 2; i++) {
        const double r = slip->params->cam[i].radius;
        n->rn[i] = r * (n->slope[i] + slip->mu[i] * r);
        n->d[i] = r - slip->mu[i] * n->slope[i];
    }
    n->q = n->d[0] * n->rn[1];
    n->p = n->rn[0] * n->rn[1];
    n->delta = n->q + n->rn[0] * n->d[1];
    const Both rate = spring->stiffness + n->z * (spring->stiffness2 + n->z * spring->stiffness3);
    n->force = spring->preload + n->z * rate + F_ext;
}

static inline bool has_damper(const SlipMode *slip) {
    return slip->c + slip->q > 0.0;
}

/* Does the speed matter to the acceleration? */
static inline bool is_resisted(const SlipMode *slip) {
    return slip->heavy || has_damper(slip) || slip->params->shaft.damping > 0.0;
}

/* D; to wait for z' and a product with zero would cost as much as the rest of a step's forces. */
static inline Both damper_at(const SlipMode *slip, Both dz_dtheta, Both omega) {
    const Both none = {0.0, 0.0}, v = dz_dtheta * omega;
    return has_damper(slip) ? v * (slip->c + slip->q * slip->direction * v) : none;
}

static inline Both inertial_rhs(const SlipMode *slip, Both tau, Both omega, Pair *n) {
    const InertiaParams *in = &slip->params->inertia;
    const double b = slip->params->shaft.damping;
    n->damper = damper_at(slip, n->dz_dtheta, omega);
    Both net = n->delta * (tau - b * omega) - n->p * (n->force + n->damper), swirl = {0.0, 0.0};
    n->mass = in->shaft * n->delta;
    if (slip->heavy) {
        const Both m = n->p * in->follower_mass, I = n->q * in->follower;
        n->mass += m * n->dz_dtheta + I * n->dpsi_dtheta[0];
        swirl = (m * n->d2z_dtheta2 + I * n->d2gamma_dtheta2) * omega;
        net -= swirl * omega;
    }
    if (is_resisted(slip)) {
        const Both resistance = slip->c + 2.0 * slip->q * slip->direction * (n->dz_dtheta * omega); /* dD/dv */
        n->damping_rate = (b * n->delta + n->p * n->dz_dtheta * resistance + 2.0 * swirl) / n->mass;
    }
    return net / n->mass;
}

/* B omega + C omega |omega| = N, see balance.c. */
static inline Both viscous_rhs(const SlipMode *slip, Both tau, Pair *n) {
    const Both grip = n->p * n->dz_dtheta, net = n->delta * tau - n->p * n->force;
    n->mass = slip->params->shaft.damping * n->delta + slip->c * grip;
    Both sum = 2.0 * n->mass;
    if (slip->q > 0.0) {
        const Both square = n->mass * n->mass + (4.0 * slip->q * slip->direction) * grip * n->dz_dtheta * net;
        sum = n->mass + (Both){sqrt(square[0]), sqrt(square[1])};
    }
    const Both omega = 2.0 * net / sum;
    n->damper = damper_at(slip, n->dz_dtheta, omega);
    return omega;
}

/* ---- the collocation equations ---- */

static inline bool is_inertial(const Attempt *s) {
    return s->slip->regime == REGIME_INERTIAL;
}

/* The balance where the nodes are. */
static inline void balance_nodes(Attempt *s) {
    const SlipMode *slip = s->slip;
    for (int k = 0; k < HALVES; k++) {
        Pair *n = &s->pair[k];
        shape_pair(slip, s->theta + s->turned.half[k], s->F_ext.half[k], n);
        if (is_inertial(s)) s->y.half[k] = inertial_rhs(slip, s->tau.half[k], s->speed.half[k], n);
        else s->y.half[k] = s->speed.half[k] = viscous_rhs(slip, s->tau.half[k], n);
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
    const bool resisted = is_resisted(s->slip);
    if (resisted) growth += s->pair[HALVES - 1].damping_rate[1] * (s->speed.at[END] - s->omega) * per_turn;
    const Nodes twice = combine(LOBATTO.twice, change);
    for (int k = 0; k < HALVES; k++) {
        const Both by_angle = growth * h * h * twice.half[k];
        next.half[k] = resisted ? by_angle - s->pair[k].damping_rate * (h * next.half[k]) : by_angle;
    }
    return next;
}

static inline void drive_nodes(Attempt *s) {
    const Inputs *in = s->slip->inputs;
    s->tau = all(in->tau[0]);
    s->F_ext = all(in->F_ext[0]);
    for (int k = 1; k < NODES && !s->slip->steady; k++) {
        const double t = s->h * LOBATTO.node.at[k];
        s->tau.at[k] = input_value(in->tau, t);
        s->F_ext.at[k] = input_value(in->F_ext, t);
    }
}

/* The pace at the start, nearly: a first guess. */
static inline double first_rhs(const SlipMode *slip, const LobattoStart *from) {
    const Params *p = slip->params;
    const Geometry *g = from->geometry;
    double rn[2], d[2];
    for (int i = 0; i < 2; i++) {
        rn[i] = g->radius[i] * (g->slope[i] + slip->mu[i] * g->radius[i]);
        d[i] = g->radius[i] - slip->mu[i] * g->slope[i];
    }
    const double grip = rn[0] * rn[1], delta = d[0] * rn[1] + rn[0] * d[1];
    double damping_rate = delta * p->shaft.damping;
    if (has_damper(slip)) damping_rate += grip * g->dz_dtheta * (slip->c + slip->q * fabs(g->dz_dtheta * from->omega));
    const double net =
        delta * slip->inputs->tau[0] - grip * (spring_force(&p->spring, from->z) + slip->inputs->F_ext[0]);
    if (slip->regime != REGIME_INERTIAL) return net / damping_rate;
    double mass = delta * p->inertia.shaft;
    if (slip->heavy) mass += grip * p->inertia.follower_mass * g->dz_dtheta;
    return (net - damping_rate * from->omega) / mass;
}

/* Where the step must end: at `distance`, rad from the start on, give or take `slack`. */
typedef struct {
    bool given;
    double distance, slack;
} Goal;

/* Sweeps until the equations hold to a share of the tolerance. With a goal, h is sought along with them. */
static bool sweep(Attempt *s, const Goal *goal) {
    static const double SHARE = 0.05, ON_GOAL = 1e-8;
    const SlipMode *slip = s->slip;
    const double wanted = SHARE * slip->params->tolerance * fabs(s->omega) / (is_inertial(s) ? s->h : 1.0);
    double before = INFINITY, missed = 0.0;
    for (int n = 0; n < MAX_SWEEPS; n++) {
        Nodes change = s->y;
        const double end = s->turned.at[END];
        if (n == 0 || (goal->given && !slip->steady)) drive_nodes(s);
        balance_nodes(s);
        for (int k = 0; k < HALVES; k++) change.half[k] = s->y.half[k] - change.half[k];
        const double size = size_of(range_of(&change));
        const Nodes next = next_change(s, &change);
        const bool done = n > 0 && size_of(range_of(&next)) <= wanted;
        for (int k = 0; k < HALVES && !done; k++) s->y.half[k] += next.half[k];
        place_nodes(s);
        if (goal->given) {
            missed = goal->distance - slip->direction * s->turned.at[END];
            s->h += slip->direction * missed / s->speed.at[END];
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
    const double *b = c.at, tolerance = s->slip->params->tolerance;
    const double rise = 3.0 * fabs(b[1] - b[0]), dslope_dtheta = 3.0 * fabs(b[0] - 2.0 * b[1] + b[2]);
    const double cubic = fmax(fabs(b[3] - b[0] + 3.0 * (b[1] - b[2])),
                              DECAY * dslope_dtheta * dslope_dtheta / (rise + dslope_dtheta + DBL_MIN));
    const double missed = s->h * LOBATTO.missed * cubic;
    const double slip = fabs(s->turned.at[END]), noise = 64.0 * DBL_EPSILON * fabs(s->theta);
    double by_speed = 0.0, by_angle = missed * LOBATTO.missed_once;
    if (is_inertial(s)) {
        by_speed = missed * LOBATTO.missed_once / size_of(range_of(&s->speed));
        by_angle = missed * LOBATTO.missed_twice * s->h;
    }
    const double x = fmax(by_speed, fmax(by_angle - noise, 0.0) / (slip + DBL_MIN));
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
    const SlipMode *slip = s->slip;
    const InertiaParams *in = &slip->params->inertia;
    const Pair *n = &s->pair[k];
    const Both omega = s->speed.half[k], v = n->dz_dtheta * omega, inverse = 1.0 / n->delta;
    const Both turns = s->h * LOBATTO.weight.half[k] * omega; /* of theta and z, by the rule of the integral */
    const Both lifts = s->h * LOBATTO.weight.half[k] * v;
    Both axial = n->force + n->damper, moment = {0.0, 0.0};
    if (slip->heavy) {
        const Both y = s->y.half[k], spin2 = omega * omega;
        axial += in->follower_mass * (n->dz_dtheta * y + n->d2z_dtheta2 * spin2);
        moment = in->follower * (n->dpsi_dtheta[0] * y + n->d2gamma_dtheta2 * spin2);
    }
    Booking *b = &out->booking;
    b->work_in += sum_of_pair(s->tau.half[k] * turns);
    b->work_ext += sum_of_pair(s->F_ext.half[k] * lifts);
    b->heat_damper += sum_of_pair(n->damper * lifts);
    b->heat_shaft += slip->params->shaft.damping * sum_of_pair(omega * turns);
    for (int i = 0; i < 2; i++) {
        const double r = slip->params->cam[i].radius;
        const Both length2 = r * r + n->slope[i] * n->slope[i];
        const Both arm = i == 0 ? -n->d[1] : n->d[0];
        const Both x = (n->rn[1 - i] * axial + arm * moment) * inverse;
        out->x[i].half[k] = x;
        out->reaction[i].half[k] = x * (Both){sqrt(length2[0]), sqrt(length2[1])};
        b->heat_cam[i] += slip->mu[i] * sum_of_pair(x * length2 * n->dpsi_dtheta[i] * turns);
    }
}

static inline double kinetic_energy(const Attempt *s, int k) {
    const Pair *n = &s->pair[k / 2];
    if (!is_inertial(s)) return 0.0;
    return kinetic_energy_of(&s->slip->params->inertia, n->dz_dtheta[k % 2], n->dpsi_dtheta[0][k % 2], s->speed.at[k]);
}

static bool keeps_energy(const Attempt *s, const Booking *b) {
    const Pair *first = &s->pair[0], *last = &s->pair[HALVES - 1];
    const EnergyEnds ends = {
        .z = {first->z[0], last->z[1] + last->dz_dtheta[1] * s->lag},
        .kinetic = {kinetic_energy(s, 0), kinetic_energy(s, END)},
        .spring_force = first->force[0] - s->F_ext.at[0],
        .tau = s->tau.at[END],
    };
    return radau_step_energy_error(s->slip, b, &ends) <= 1.0;
}

/* Each contact firmly on its flank, by more than rounding at the start, and throughout? */
static bool stay_on_flanks(const Attempt *s, const Loading *loading) {
    const SlipMode *slip = s->slip;
    const Pair *n = &s->pair[0];
    const double load = balance_load_size(slip->params, n->force[0], n->damper[0], n->dz_dtheta[0] * s->y.at[0]);
    for (int i = 0; i < 2; i++) {
        const Nodes *x = &loading->x[i];
        if (!balance_is_firm(slip, i, x->at[0], n->rn[1 - i][0] / n->delta[0], load)) return false;
        if (!keeps_sign(x, slip->flank[i])) return false;
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

static void find_peaks(const Attempt *s, const Loading *loading, const Peaks *known, LobattoStep *out) {
    const double contacts = s->slip->params->contacts;
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
static bool is_quiet(const Attempt *s, const LobattoStart *from, LobattoStep *out) {
    const SlipMode *slip = s->slip;
    const bool moves = keeps_sign(&s->speed, slip->direction) && slip->direction * s->turned.at[END] < from->room;
    out->accurate = is_accurate(s);
    if (!moves || !out->accurate) return false;
    Loading loading;
    loading.booking = (Booking){.work_in = 0.0};
    for (int k = 0; k < HALVES; k++) load_pair(s, k, &loading);
    if (has_friction(slip->params) && !stay_on_flanks(s, &loading)) return false;
    if (!keeps_energy(s, &loading.booking)) return false;
    out->booking = loading.booking;
    if (slip->params->ledger) find_peaks(s, &loading, from->known, out);
    return true;
}

/* Without inertia: the law's own speed at the end, not where the last sweep was. */
static double speed_at_end(const Attempt *s) {
    const Both theta = s->theta + s->turned.half[HALVES - 1];
    Pair last;
    shape_pair(s->slip, theta, s->F_ext.half[HALVES - 1], &last);
    return viscous_rhs(s->slip, s->tau.half[HALVES - 1], &last)[1];
}

/* Under constant acceleration. */
static void guess_nodes(Attempt *s, double rhs) {
    const double alpha = is_inertial(s) ? rhs : 0.0;
    s->y = all(rhs);
    for (int k = 0; k < HALVES; k++) {
        const Both t = s->h * LOBATTO.node.half[k];
        s->speed.half[k] = s->omega + alpha * t;
        s->turned.half[k] = t * (s->omega + 0.5 * alpha * t);
    }
}

bool lobatto_step_along(const SlipMode *slip, const LobattoStart *from, double left, LobattoStep *out) {
    const Breakpoint breakpoint = event_location_breakpoint(slip, from->theta);
    const double edge = breakpoint.distance + breakpoint.beyond, rhs = first_rhs(slip, from);
    Goal goal = {.distance = breakpoint.distance + 0.5 * breakpoint.beyond, .slack = 0.25 * breakpoint.beyond};
    Attempt s;
    s.slip = slip;
    s.theta = from->theta;
    s.omega = slip->regime == REGIME_INERTIAL ? from->omega : rhs;
    s.h = left;
    guess_nodes(&s, rhs);
    do {
        if (slip->direction * s.turned.at[END] > edge) {
            const double alpha = is_inertial(&s) ? slip->direction * rhs : 0.0;
            goal.given = true;
            s.h = ballistic_time(slip->direction * s.omega, alpha, goal.distance);
            guess_nodes(&s, rhs);
        }
        if (!sweep(&s, &goal)) return false;
    } while (!goal.given && slip->direction * s.turned.at[END] > edge);
    if (!(s.h > 0.0 && s.h <= left) || !is_quiet(&s, from, out)) return false;
    const Both rise = LOBATTO.weight.half[0] * s.y.half[0] + LOBATTO.weight.half[1] * s.y.half[1];
    out->h = s.h;
    out->dtheta = s.turned.at[END];
    out->domega = s.h * sum_of_pair(rise);
    out->omega = is_inertial(&s) ? s.speed.at[END] : speed_at_end(&s);
    out->tau = s.tau.at[END];
    return isfinite(out->dtheta + out->omega);
}
