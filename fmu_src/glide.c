#include "glide.h"

#include <float.h>
#include <math.h>

/* Vectors are passed to and from static functions only: how, is nobody else's business. */
#pragma GCC diagnostic ignored "-Wpsabi"

/* One value per node: the start and three more, of which the last is the end. */
enum { LANES = 4, END = LANES - 1 };
typedef double Four __attribute__((vector_size(LANES * sizeof(double))));

typedef struct {
    Four node;
    Four once[LANES], twice[LANES]; /* [j]: the integrals, up to each node, of what is 1 at node j and 0 at the others */
    Four weight;                    /* the integral over the step */
    double missed;                  /* what a parabola through the last three nodes misses at the start, of c^3 */
    double missed_once, missed_twice; /* largest single and double integral of prod(1 - c/c_i), the shape of that */
    Four bernstein[LANES];            /* [j]: Bernstein coefficients of the cubic that is 1 at node j */
} Lobatto;

#include "lobatto_table.h"

/* More are for the leaps of passage.h: they solve by Newton's method. */
enum { MAX_SWEEPS = 8 };

/* Each sweep is to bring it nearer by this factor at least. */
static const double CONTRACTION = 0.1;

/* ---- lanes ---- */

static inline Four all(double x) {
    return (Four){x, x, x, x};
}

static const Four NONE = {0.0, 0.0, 0.0, 0.0};

static inline double lowest(Four v) {
    const double a = v[1] < v[0] ? v[1] : v[0], b = v[3] < v[2] ? v[3] : v[2];
    return b < a ? b : a;
}

static inline double highest(Four v) {
    const double a = v[1] > v[0] ? v[1] : v[0], b = v[3] > v[2] ? v[3] : v[2];
    return b > a ? b : a;
}

static inline double largest(Four v) {
    return fmax(highest(v), -lowest(v));
}

static inline double total(Four v) {
    return (v[0] + v[3]) + (v[1] + v[2]);
}

/* Columns times the lanes of y. */
static inline Four combine(const Four columns[LANES], Four y) {
    return (columns[0] * y[0] + columns[1] * y[1]) + (columns[2] * y[2] + columns[3] * y[3]);
}

/* Is it surely above zero throughout? A cubic through its lanes leaves their range by less than this share of it (the
 * Lebesgue constant of the nodes is below 2.2). */
static const double SURE = 0.6;

static inline bool is_positive(Four v) {
    const double low = lowest(v);
    return low > SURE * (highest(v) - low);
}

/* ---- the balance at the nodes, see balance.h ---- */

typedef struct {
    Four slope[2], turn[2], lift;
    Four lift_rate, turn_rate; /* only where the follower is heavy */
    Four rn[2], d[2], p, q, delta;
    Four z;
} Shapes;

typedef struct {
    const Way *way;
    double theta, omega, h; /* at the start, and the length of the step */
    Four tau, F_ext;
    Four turned, speed;  /* rad, rad/s: theta less that of the start, omega */
    double lag;          /* rad, from where the balance was taken last to where the end is: what the last sweep changed */
    Four y;              /* alpha, or omega without inertia */
    Shapes shapes;
    Four force, damper;
    Four mass; /* J Delta + P m z' + Q I gamma', or without inertia what resists the speed */
} Lanes;

/* Half the lanes at a time: more would not stay in the registers. Horner's rule for even and odd parts, see piece_spot(). */
static inline void spots_of_half(const Piece *piece, Both theta, bool bends, Both slope[2], Both bend[2], Both *z) {
    const Both x = (theta - piece->middle) * piece->scale, y = x * x, none = {0.0, 0.0};
    const double *const c[3] = {piece->slope[0], piece->slope[1], piece->z};
    Both even[3], odd[3], even_rate[2] = {none, none}, odd_rate[2] = {none, none};
    for (int i = 0; i < 3; i++) {
        even[i] = none + c[i][COURSE_DEGREE];
        odd[i] = none + c[i][COURSE_DEGREE - 1];
    }
    for (int k = COURSE_DEGREE - 2; k >= 2; k -= 2) {
        for (int i = 0; bends && i < 2; i++) {
            even_rate[i] = even_rate[i] * y + even[i];
            odd_rate[i] = odd_rate[i] * y + odd[i];
        }
        for (int i = 0; i < 3; i++) {
            even[i] = even[i] * y + c[i][k];
            odd[i] = odd[i] * y + c[i][k - 1];
        }
    }
    for (int i = 0; bends && i < 2; i++) {
        even_rate[i] = even_rate[i] * y + even[i];
        bend[i] = (odd[i] + 2.0 * (x * even_rate[i] + y * odd_rate[i])) * piece->scale;
    }
    for (int i = 0; i < 3; i++) even[i] = even[i] * y + c[i][0];
    for (int i = 0; i < 2; i++) slope[i] = even[i] + x * odd[i];
    *z = even[2] + x * odd[2];
}

static inline Four join(Both low, Both high) {
    return (Four){low[0], low[1], high[0], high[1]};
}

static inline void spots_at(const Piece *piece, Four theta, bool bends, Four bend[2], Shapes *s) {
    Both slopes[2][2], bent[2][2], z[2];
    for (int half = 0; half < 2; half++) {
        const Both here = {theta[2 * half], theta[2 * half + 1]};
        spots_of_half(piece, here, bends, slopes[half], bent[half], &z[half]);
    }
    for (int i = 0; i < 2; i++) s->slope[i] = join(slopes[0][i], slopes[1][i]);
    for (int i = 0; bends && i < 2; i++) bend[i] = join(bent[0][i], bent[1][i]);
    s->z = join(z[0], z[1]);
}

/* Less than zero is rounding of the polynomial of a level groove. */
static inline Four not_negative(Four v) {
    for (int k = 0; k < LANES; k++) v[k] = v[k] > 0.0 ? v[k] : 0.0;
    return v;
}

static inline void follow_grooves(const Way *w, Four theta, Shapes *s) {
    Four bend[2];
    const Piece *piece = w->piece;
    if (w->course->straight) {
        for (int i = 0; i < 2; i++) s->slope[i] = all(piece->slope[i][0]);
        for (int i = 0; i < 2; i++) bend[i] = NONE;
        s->z = piece->z[0] + theta * piece->z[1];
    } else if (w->heavy) {
        spots_at(piece, theta, true, bend, s);
    } else {
        spots_at(piece, theta, false, bend, s);
    }
    for (int i = 0; i < 2; i++) s->slope[i] = not_negative(s->slope[i]);
    const Four inverse = 1.0 / (s->slope[0] + s->slope[1]);
    s->turn[0] = s->slope[1] * inverse;
    s->turn[1] = s->slope[0] * inverse;
    s->lift = s->slope[0] * s->turn[0];
    if (!w->heavy) return;
    s->turn_rate = (bend[1] * s->turn[1] - bend[0] * s->turn[0]) * inverse;
    s->lift_rate = bend[0] * s->turn[0] * s->turn[0] + bend[1] * s->turn[1] * s->turn[1];
}

static inline void rub(const Way *w, Shapes *s) {
    for (int i = 0; i < 2; i++) {
        const double r = w->params->cam[i].radius;
        s->rn[i] = r * (s->slope[i] + w->mu[i] * r);
        s->d[i] = r - w->mu[i] * s->slope[i];
    }
    s->q = s->d[0] * s->rn[1];
    s->p = s->rn[0] * s->rn[1];
    s->delta = s->q + s->rn[0] * s->d[1];
}

static inline Four spring_at(const SpringParams *spring, Four z) {
    if (spring->stiffness2 == 0.0 && spring->stiffness3 == 0.0) return spring->preload + z * spring->stiffness;
    return spring->preload + z * (spring->stiffness + z * (spring->stiffness2 + z * spring->stiffness3));
}

static inline Four damper_at(const Way *w, Four v) {
    return w->q == 0.0 ? w->c * v : v * (w->c + w->q * w->direction * v);
}

static inline Four inertial_pace(Lanes *l) {
    const Way *w = l->way;
    const Shapes *s = &l->shapes;
    const InertiaParams *in = &w->params->inertia;
    const Four omega = l->speed;
    l->damper = w->c + w->q > 0.0 ? damper_at(w, s->lift * omega) : NONE;
    Four net = s->delta * (l->tau - w->params->shaft.damping * omega) - s->p * (l->force + l->damper);
    l->mass = in->shaft * s->delta;
    if (w->heavy) {
        const Four m = s->p * in->follower_mass, I = s->q * in->follower;
        l->mass += m * s->lift + I * s->turn[0];
        net -= (m * s->lift_rate + I * s->turn_rate) * omega * omega;
    }
    return net / l->mass;
}

/* B omega + C omega |omega| = N, see balance.c. */
static inline Four viscous_pace(Lanes *l) {
    const Way *w = l->way;
    const Shapes *s = &l->shapes;
    const Four grip = s->p * s->lift;
    const Four net = s->delta * l->tau - s->p * l->force;
    l->mass = w->params->shaft.damping * s->delta + w->c * grip;
    Four sum = 2.0 * l->mass;
    if (w->q > 0.0) {
        const Four square = l->mass * l->mass + (4.0 * w->q * w->direction) * grip * s->lift * net;
        sum = l->mass;
        for (int k = 0; k < LANES; k++) sum[k] += sqrt(square[k]);
    }
    l->speed = 2.0 * net / sum;
    l->damper = damper_at(w, s->lift * l->speed);
    return l->speed;
}

static inline void shape_nodes(Lanes *l) {
    const Way *w = l->way;
    follow_grooves(w, l->theta + l->turned, &l->shapes);
    rub(w, &l->shapes);
    l->force = spring_at(&w->params->spring, l->shapes.z) + l->F_ext;
}

/* Is there a motion where the nodes are, and is it this one? */
static inline bool is_possible(const Lanes *l) {
    const Shapes *s = &l->shapes;
    if (l->way->kind == FLOW_INERTIAL) return lowest(l->mass * s->delta) > 0.0;
    return lowest(s->delta) > 0.0 && lowest(l->mass) >= 0.0 && lowest(s->p) > 0.0;
}

/* Does the speed matter to the acceleration? */
static inline bool is_resisted(const Way *w) {
    return w->heavy || w->c + w->q + w->params->shaft.damping > 0.0;
}

/* ---- the collocation equations ---- */

static inline void place_nodes(Lanes *l) {
    const double h = l->h;
    const Four once = combine(LOBATTO.once, l->y);
    if (l->way->kind == FLOW_INERTIAL) {
        l->turned = h * (LOBATTO.node * l->omega + h * combine(LOBATTO.twice, l->y));
        l->speed = l->omega + h * once;
    } else {
        l->turned = h * once;
    }
}

static inline Four input_at(const double u[INPUT_ORDER + 1], Four t) {
    return u[0] + t * (u[1] + t / 2.0 * (u[2] + t / 3.0 * u[3]));
}

/* The balance where the nodes are. A change of speed needs no new look at the grooves. */
static inline void balance_nodes(Lanes *l) {
    shape_nodes(l);
    if (l->way->kind != FLOW_INERTIAL) {
        l->y = viscous_pace(l);
        return;
    }
    l->y = inertial_pace(l);
    if (!is_resisted(l->way)) return;
    l->speed = l->omega + l->h * combine(LOBATTO.once, l->y);
    l->y = inertial_pace(l);
}

/* What the next sweep would change, nearly, if y grew with theta in the same way everywhere. */
static inline Four foresee(const Lanes *l, Four change) {
    const double slope = (l->y[END] - l->y[0]) / l->turned[END];
    const bool inertial = l->way->kind == FLOW_INERTIAL;
    return slope * l->h * (inertial ? l->h * combine(LOBATTO.twice, change) : combine(LOBATTO.once, change));
}

static inline void drive_nodes(Lanes *l) {
    const Inputs *in = l->way->inputs;
    if (l->way->steady) {
        l->tau = all(in->tau[0]);
        l->F_ext = all(in->F_ext[0]);
    } else {
        const Four t = l->h * LOBATTO.node;
        l->tau = input_at(in->tau, t);
        l->F_ext = input_at(in->F_ext, t);
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
    const double rho = rn[0] * rn[1] / (d[0] * rn[1] + rn[0] * d[1]);
    const double drag = p->shaft.damping + rho * g->lift * (w->c + w->q * fabs(g->lift * from->omega));
    const double net = w->inputs->tau[0] - rho * (spring_force(&p->spring, from->z) + w->inputs->F_ext[0]);
    if (w->kind != FLOW_INERTIAL) return net / drag;
    return (net - drag * from->omega) / (p->inertia.shaft + rho * p->inertia.follower_mass * g->lift);
}

/* Where the step must end: at `distance`, rad from the start on, give or take `slack`. */
typedef struct {
    bool given;
    double distance, slack;
} Goal;

/* Sweeps until the equations hold to a share of the tolerance. With a goal, h is sought along with them. */
static bool sweep(Lanes *l, const Goal *goal) {
    static const double SHARE = 0.05, ON_GOAL = 1e-8;
    const Way *w = l->way;
    const bool inertial = w->kind == FLOW_INERTIAL;
    const double wanted = SHARE * w->params->tolerance * fabs(l->omega) / (inertial ? l->h : 1.0);
    double before = INFINITY, missed = 0.0;
    for (int n = 0; n < MAX_SWEEPS; n++) {
        const Four guess = l->y;
        const double end = l->turned[END];
        drive_nodes(l);
        balance_nodes(l);
        if (!is_possible(l)) return false;
        Four change = l->y - guess;
        l->y += foresee(l, change);
        place_nodes(l);
        if (goal->given) {
            missed = goal->distance - w->direction * l->turned[END];
            l->h += w->direction * missed / l->speed[END];
            place_nodes(l);
        }
        l->lag = l->turned[END] - end;
        change[0] = 0.0; /* the start's is not solved for */
        const double size = largest(change), rounding = 8.0 * DBL_EPSILON * largest(l->y);
        const bool there = !goal->given || fabs(missed) <= fmin(goal->slack, ON_GOAL * goal->distance);
        /* the next change is about size^2/before */
        if (n > 0 && there && (size <= rounding || size * size <= wanted * before)) return true;
        if (n > 0 && !(size <= CONTRACTION * before + rounding)) return false;
        before = size;
    }
    return false;
}

/* ---- is it good enough? ---- */

/* A parabola through the last three nodes would miss as much at the start as the cubic's highest term tells, and in
 * between the integrals of prod(1 - c/c_i) times that. Where that term happens to be small, the decay of the lower ones
 * stands for it. The cubic itself misses far less: the power of what the parabola misses, relative to speed and way, is
 * set so that of 5000 random steps that just pass all are within the tolerance, and 99 of 100 within half of it. */
static bool is_accurate(const Lanes *l) {
    static const double DECAY = 0.3;
    const Four b = combine(LOBATTO.bernstein, l->y);
    const double rise = 3.0 * fabs(b[1] - b[0]), bend = 3.0 * fabs(b[0] - 2.0 * b[1] + b[2]);
    const double cubic = fmax(fabs(b[3] - b[0] + 3.0 * (b[1] - b[2])), DECAY * bend * bend / (rise + bend + DBL_MIN));
    const double missed = l->h * LOBATTO.missed * cubic;
    const double way = fabs(l->turned[END]), noise = 64.0 * DBL_EPSILON * fabs(l->theta);
    double by_speed = 0.0, by_angle = missed * LOBATTO.missed_once;
    if (l->way->kind == FLOW_INERTIAL) {
        by_speed = missed * LOBATTO.missed_once / highest(l->way->direction * l->speed);
        by_angle = missed * LOBATTO.missed_twice * l->h;
    }
    const double x = fmax(by_speed, fmax(by_angle - noise, 0.0) / (way + DBL_MIN)), tolerance = l->way->params->tolerance;
    const double x2 = x * x, x8 = (x2 * x2) * (x2 * x2), t2 = tolerance * tolerance;
    return x < 1.0 && x8 * x2 * x <= (t2 * t2) * (t2 * t2); /* x^(11/8) <= tolerance */
}

/* ---- contacts and accounts ---- */

/* x_i = R_i/hypot(r_i, a_i) */
static inline void load_contacts(const Lanes *l, Four inverse, Four x[2]) {
    const Shapes *s = &l->shapes;
    const Way *w = l->way;
    const InertiaParams *in = &w->params->inertia;
    Four axial = l->force + l->damper;
    if (!w->heavy) {
        for (int i = 0; i < 2; i++) x[i] = s->rn[1 - i] * axial * inverse;
        return;
    }
    const Four spin2 = l->speed * l->speed;
    axial += in->follower_mass * (s->lift * l->y + s->lift_rate * spin2);
    const Four twist = in->follower * (s->turn[0] * l->y + s->turn_rate * spin2);
    x[0] = (s->rn[1] * axial - s->d[1] * twist) * inverse;
    x[1] = (s->rn[0] * axial + s->d[0] * twist) * inverse;
}

static inline double integral(const Lanes *l, Four rate) {
    return l->h * total(LOBATTO.weight * rate);
}

static inline void book(const Lanes *l, const Four x[2], const Four length2[2], Booking *b) {
    const Way *w = l->way;
    const Four omega = l->speed, v = l->shapes.lift * omega;
    *b = (Booking){.work_in = integral(l, l->tau * omega)};
    if (!w->steady || w->inputs->F_ext[0] != 0.0) b->work_ext = integral(l, l->F_ext * v);
    if (w->c + w->q > 0.0) b->heat_damper = integral(l, l->damper * v);
    if (w->params->shaft.damping > 0.0) b->heat_shaft = w->params->shaft.damping * integral(l, omega * omega);
    for (int i = 0; i < 2; i++)
        if (w->mu[i] != 0.0) b->heat_cam[i] = w->mu[i] * integral(l, x[i] * length2[i] * l->shapes.turn[i] * omega);
}

static inline double kinetic_energy(const Lanes *l, int k) {
    const Shapes *s = &l->shapes;
    const InertiaParams *in = &l->way->params->inertia;
    const double inertia = in->shaft + in->follower_mass * s->lift[k] * s->lift[k] +
                           in->follower * s->turn[0][k] * s->turn[0][k];
    return 0.5 * inertia * l->speed[k] * l->speed[k];
}

static bool keeps_energy(const Lanes *l, const Booking *b) {
    const bool inertial = l->way->kind == FLOW_INERTIAL;
    const EnergyEnds ends = {
        .z = {l->shapes.z[0], l->shapes.z[END] + l->shapes.lift[END] * l->lag},
        .kinetic = {inertial ? kinetic_energy(l, 0) : 0.0, inertial ? kinetic_energy(l, END) : 0.0},
        .spring_force = l->force[0] - l->F_ext[0],
        .tau = l->tau[END],
    };
    return leap_energy_error(l->way, b, &ends) <= 1.0;
}

/* Each contact firmly on its flank, by more than rounding at the start, and throughout? */
static bool stay_on_flanks(const Lanes *l, const Four x[2], Four inverse) {
    static const double CLEAR = 1e-9; /* of the loads that add up to it */
    const Way *w = l->way;
    const double inertia = w->params->inertia.follower_mass * fabs(l->shapes.lift[0] * l->y[0]);
    const double load = fabs(l->force[0]) + fabs(l->damper[0]) + inertia;
    for (int i = 0; i < 2; i++) {
        const Four on = w->flank[i] * x[i];
        if (!(on[0] > CLEAR * fabs(l->shapes.rn[1 - i][0] * inverse[0]) * load) || !is_positive(on)) return false;
    }
    return true;
}

/* Is |v|, where it exceeds what is known, largest at an end? */
static bool peaks_at_end(Four v, double known) {
    const double low = lowest(v), high = highest(v);
    if (fmax(high, -low) + SURE * (high - low) <= known) return true;
    const Four c = combine(LOBATTO.bernstein, v);
    const double a = c[1] - c[0], b = c[2] - c[1], d = c[3] - c[2];
    return (a >= 0.0 && b >= 0.0 && d >= 0.0) || (a <= 0.0 && b <= 0.0 && d <= 0.0);
}

static double at_ends(Four v) {
    return fmax(fabs(v[0]), fabs(v[END]));
}

static void find_peaks(const Lanes *l, const Four x[2], const Four length2[2], const Peaks *known, Glide *out) {
    const double contacts = l->way->params->contacts;
    const bool steady = l->way->kind == FLOW_INERTIAL && (is_positive(l->y) || is_positive(-l->y));
    out->peaks_inside = !steady && !peaks_at_end(l->speed, known->omega);
    out->peak_omega = at_ends(l->speed);
    for (int i = 0; i < 2; i++) {
        Four reaction = x[i];
        for (int k = 0; k < LANES; k++) reaction[k] *= sqrt(length2[i][k]);
        out->peaks_inside = out->peaks_inside || !peaks_at_end(reaction, known->reaction[i] * contacts);
        out->peak_reaction[i] = at_ends(reaction) / contacts;
    }
}

/* ---- the step ---- */

/* Does nothing happen in it, and is it good enough? That does not depend on whether there is a ledger. */
static bool is_quiet(const Lanes *l, const Launchpad *from, Glide *out) {
    const Way *w = l->way;
    if (!is_positive(w->direction * l->speed) || !(w->direction * l->turned[END] < from->room) || !is_accurate(l))
        return false;
    Four x[2], length2[2];
    const Four inverse = 1.0 / l->shapes.delta;
    load_contacts(l, inverse, x);
    if (has_friction(w->params) && !stay_on_flanks(l, x, inverse)) return false;
    for (int i = 0; i < 2; i++) {
        const double r = w->params->cam[i].radius;
        length2[i] = r * r + l->shapes.slope[i] * l->shapes.slope[i];
    }
    book(l, x, length2, &out->booking);
    if (!keeps_energy(l, &out->booking)) return false;
    if (w->params->ledger) find_peaks(l, x, length2, from->known, out);
    return true;
}

bool glide_along(const Way *way, const Launchpad *from, double left, Glide *out) {
    const Border border = passage_border(way, from->theta);
    const double edge = border.distance + border.beyond, pace = first_pace(way, from);
    Lanes l;
    l.way = way;
    l.theta = from->theta;
    l.omega = way->kind == FLOW_INERTIAL ? from->omega : pace;
    l.h = left;
    const Four t = left * LOBATTO.node;
    l.y = all(pace);
    l.speed = all(l.omega);
    if (way->kind == FLOW_INERTIAL) l.speed += pace * t;
    l.turned = t * (l.omega + (way->kind == FLOW_INERTIAL ? 0.5 * pace : 0.0) * t);
    Goal goal = {.distance = border.distance + 0.5 * border.beyond, .slack = 0.25 * border.beyond};
    for (int n = 0; n < 2; n++) {
        if (way->direction * l.turned[END] > edge) {
            goal.given = true;
            l.h *= goal.distance / (way->direction * l.turned[END]);
            place_nodes(&l);
        }
        if (!sweep(&l, &goal)) return false;
        if (goal.given || way->direction * l.turned[END] <= edge) break;
    }
    if (!(l.h > 0.0 && l.h <= left) || !is_quiet(&l, from, out)) return false;
    out->h = l.h;
    out->dtheta = l.turned[END];
    out->domega = l.h * total(LOBATTO.weight * l.y);
    out->omega = l.speed[END];
    out->tau = l.tau[END];
    return isfinite(out->dtheta + out->omega);
}
