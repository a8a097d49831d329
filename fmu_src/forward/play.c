#include "forward/play.h"

#include <math.h>

#include "contact/contact.h"
#include "elementary/elementary.h"
#include "forward/configuration.h"
#include "forward/stick.h"
#include "numerics/golden_section.h"
#include "numerics/radau.h"
#include "platform/attributes.h"

/* Along the edge of the band, through one piece. */
typedef struct {
    const Mechanism *m;
    const TransmissionPiece *piece;
    int direction;
    double torque;   /* N.m, to be held */
    double unloaded; /* rad, from the start, within which F_0 is zero to rounding; 0: F_0 counts at the start */
    int *halvings;   /* that are left, which bounds the work of a jump */
} EdgePath;

/* The band's edge at one angle. */
typedef struct {
    double torque;      /* N.m; infinite: no torque moves the mechanism on */
    int pattern;        /* sign of F_0 and flanks; the edge has a kink where the pattern changes */
    double dz_dtheta;   /* m/rad */
    double heat[2];     /* N.m, friction heat per angle at contact i */
    double wear[2];     /* m^3 per angle at contact i */
    double reaction[2]; /* N, |R_i|, total of all pin ends */
} Edge;

NOINLINE static Edge edge_at(const EdgePath *path, double theta) {
    const Mechanism *m = path->m;
    work_add(m->work, 1);
    const TransmissionPoint point = piece_at(path->piece, theta);
    Geometry g = cam_geometry(m->params.cam, point.slope);
    const double F_0 = spring_force(&m->params.spring, point.z) + m->inputs.F_ext[0];
    const int away = F_0 < 0.0 ? -path->direction : path->direction; /* the band is mirrored */
    Edge edge = {.dz_dtheta = g.dz_dtheta, .pattern = F_0 < 0.0 ? 8 : 0};
    int flank[2];
    Transfer t;
    cam_set_load(&m->params, F_0, &g);
    if (!contact_edge(&g, away, flank, &t)) {
        const bool begins = fabs(theta - m->state.theta.hi) <= path->unloaded && !stick_force_counts(m, F_0);
        edge.torque = F_0 == 0.0 || begins ? 0.0 : (double)path->direction * (double)INFINITY;
        return edge;
    }
    edge.torque = t.rho * F_0;
    edge.pattern += 4 + (flank[0] > 0 ? 2 : 0) + (flank[1] > 0 ? 1 : 0);
    for (int i = 0; i < 2; i++) {
        const double x = fabs(t.axial[i] * F_0);
        edge.heat[i] = cam_heat(&g, i) * x;
        edge.reaction[i] = x * cam_length(&g, i);
        edge.wear[i] = wear_per_sliding(&m->params, i) * edge.reaction[i] * cam_sliding(&g, i);
    }
    return edge;
}

/* Torque beyond the edge, in the direction of the jump. */
static double beyond(const EdgePath *path, double theta) {
    return path->direction * (path->torque - edge_at(path, theta).torque);
}

/* The angle at which the torque is held: at `from` the torque is beyond the edge, at `to` it is not. */
static double held_between(const EdgePath *path, double from, double to) {
    double f_from = beyond(path, from), f_to = beyond(path, to);
    for (int n = 0; n < PLAY_MAX_BISECTIONS; n++) {
        const double middle = 0.5 * (from + to), span = f_from - f_to;
        double theta =
            n % 3 != 2 && span > 0.0 && isfinite(span) && f_from > 0.0 ? from + (to - from) * f_from / span : middle;
        if (!(path->direction * (theta - from) > 0.0 && path->direction * (to - theta) > 0.0)) theta = middle;
        if (theta == from || theta == to) break;
        const double f = beyond(path, theta);
        if (f == 0.0) return theta;
        if (f > 0.0) {
            from = theta;
            f_from = f;
        } else {
            to = theta;
            f_to = f;
        }
    }
    return isfinite(f_to) ? to : from; /* a contact locks there */
}

/* The heats and the work along the edge over [from, to], by the Radau rule of order 13. */
NOINLINE static Booking sum_over(const EdgePath *path, double from, double to) {
    const Radau *r = radau_of(RADAU_MAX);
    Booking sum = {.work_in = 0.0};
    for (int j = 0; j < r->stages; j++) {
        const Edge edge = edge_at(path, from + r->node[j] * (to - from));
        const double weight = (to - from) * r->weight[j];
        sum.work_in += weight * edge.torque;
        for (int i = 0; i < 2; i++) {
            sum.heat_cam[i] += fabs(weight) * edge.heat[i];
            sum.wear[i] += fabs(weight) * edge.wear[i];
        }
        sum.work_ext += weight * edge.dz_dtheta * path->m->inputs.F_ext[0];
    }
    return sum;
}

static void add(Booking *sum, const Booking *part) {
    sum->work_in += part->work_in;
    sum->work_ext += part->work_ext;
    for (int i = 0; i < 2; i++) {
        sum->heat_cam[i] += part->heat_cam[i];
        sum->wear[i] += part->wear[i];
    }
}

static bool alike(const Booking *a, const Booking *b, double scale) {
    double differ = fabs(a->work_in - b->work_in) + fabs(a->work_ext - b->work_ext);
    for (int i = 0; i < 2; i++) differ += fabs(a->heat_cam[i] - b->heat_cam[i]);
    return !(differ > scale); /* NaN counts as alike: halving does not mend a NaN */
}

/* The booking over [from, to]; the interval is halved until the halves agree with `whole`. */
static Booking integrate(const EdgePath *path, double from, double to, const Booking *whole, double allowed,
                         int depth) {
    const double middle = 0.5 * (from + to);
    const Booking left = sum_over(path, from, middle);
    const Booking right = sum_over(path, middle, to);
    Booking sum = left;
    add(&sum, &right);
    if (depth >= PLAY_MAX_DEPTH || --*path->halvings < 0 || alike(&sum, whole, allowed)) return sum;
    sum = integrate(path, from, middle, &left, allowed, depth + 1);
    const Booking rest = integrate(path, middle, to, &right, allowed, depth + 1);
    add(&sum, &rest);
    return sum;
}

/* Reaction i along the edge. */
typedef struct {
    const EdgePath *path;
    int i;
} EdgeReaction;

static double reaction_at(const void *context, double theta) {
    const EdgeReaction *r = context;
    return edge_at(r->path, theta).reaction[r->i];
}

/* Raises the largest reactions to those between `from` and `to`. */
static void look_for_peaks(const EdgePath *path, double from, double to, Jump *jump) {
    double reaction[2][PLAY_PEAK_PARTS + 1];
    for (int k = 0; k <= PLAY_PEAK_PARTS; k++) {
        const Edge edge = edge_at(path, from + (to - from) * k / (int)PLAY_PEAK_PARTS);
        for (int i = 0; i < 2; i++) reaction[i][k] = edge.reaction[i];
    }
    for (int i = 0; i < 2; i++) {
        int best = 0;
        for (int k = 1; k <= PLAY_PEAK_PARTS; k++) best = reaction[i][k] > reaction[i][best] ? k : best;
        double largest = reaction[i][best];
        const double step = (to - from) / (int)PLAY_PEAK_PARTS;
        const double left = from + step * max_of(best - 1, 0.0),
                     right = from + step * min_of(best + 1, (double)(int)PLAY_PEAK_PARTS);
        if (largest > PLAY_NEAR_PEAK * jump->reaction[i]) {
            const EdgeReaction reaction_i = {path, i};
            const int steps = GOLDEN_STEPS;
            largest = max_of(largest, golden_section_maximum(reaction_at, &reaction_i, left, right, steps).value);
        }
        jump->reaction[i] = max_of(jump->reaction[i], largest);
    }
}

static void book(const EdgePath *path, double from, double to, Jump *jump) {
    const Mechanism *m = path->m;
    if (!m->params.ledger || from == to) return;
    look_for_peaks(path, from, to, jump);
    const Booking whole = sum_over(path, from, to);
    const double size = fabs(whole.work_in) + fabs(whole.work_ext) + whole.heat_cam[0] + whole.heat_cam[1];
    /* On a dwell z is constant, and every energy changes by rounding only. */
    const double z = fabs(m->configuration.z) + m->model.transmission.z_size;
    const double rounding = PLAY_ROUNDING * (size + stick_axial_size(m) * z);
    const double allowed = PLAY_SHARE_OF_TOLERANCE * m->params.tolerance * size + rounding;
    const Booking sum = integrate(path, from, to, &whole, allowed, 0);
    add(&jump->booking, &sum);
}

/* Books the path from `from` to `to`, which has at most one kink. */
static void book_past_kink(const EdgePath *path, double from, double to, Jump *jump) {
    if (!path->m->params.ledger) return;
    const int pattern = edge_at(path, from).pattern;
    double left = from, right = to;
    if (edge_at(path, to).pattern == pattern) left = right;
    for (int n = 0; n < PLAY_KINK_BISECTIONS && left != right; n++) {
        const double middle = 0.5 * (left + right);
        if (middle == left || middle == right) break;
        if (edge_at(path, middle).pattern == pattern) {
            left = middle;
        } else {
            right = middle;
        }
    }
    book(path, from, left, jump);
    book(path, left, to, jump);
}

/* The first angle between `from` and `to` at which a contact locks, or NAN. */
static double lock_between(const EdgePath *path, double from, double to) {
    const Radau *r = radau_of(RADAU_MAX);
    for (int j = 0; has_friction(&path->m->params) && j < r->stages; j++) {
        const double theta = from + r->node[j] * (to - from);
        if (isinf(edge_at(path, theta).torque)) return theta;
    }
    return NAN;
}

/* Extends the jump through one piece, to the angle at which the torque is held or to the angle `end`. Returns true if
 * the torque is held. */
static bool cross_piece(const EdgePath *path, double end, double bump, Jump *jump) {
    const Mechanism *m = path->m;
    /* A torque on a level edge, to rounding, is not held: theta goes on. */
    const double tie = stick_tie(m) * stick_torque_size(m, m->configuration.geometry.dz_dtheta) + bump;
    const double start = m->state.theta.hi, width = path->piece->upper - path->piece->lower;
    const int direction = path->direction;
    double from = start + jump->dtheta, step = PLAY_FIRST_SAMPLE * width;
    while (direction * (end - from) > 0.0 && !work_is_spent(m->work)) { /* at most 64 turns per piece */
        double to = from + direction * step;
        if (!(direction * (end - to) > 0.0)) to = end;
        const double lock = lock_between(path, from, to);
        if (!isnan(lock)) to = lock;
        const double left = beyond(path, to);
        const bool held = isinf(left) || !(left >= -tie);
        if (held) to = held_between(path, from, to);
        book_past_kink(path, from, to, jump);
        jump->dtheta = to - start;
        if (held) return true;
        from = to;
        step = min_of(2.0 * step, width / (int)PLAY_SAMPLES);
    }
    return false;
}

void play_jump(const Mechanism *m, int direction, double torque, double bump, Jump *jump) {
    const Transmission *transmission = &m->model.transmission;
    const double stop = direction > 0 ? m->params.stop.upper : m->params.stop.lower;
    const TransmissionPiece *last = direction > 0 ? transmission->piece + transmission->count - 1 : transmission->piece;
    int halvings = PLAY_MAX_HALVINGS;
    const TransmissionPiece *first = transmission_piece(transmission, m->state.theta.hi, direction);
    const double unloaded = stick_is_unloaded(m) ? PLAY_FIRST_SAMPLE * (first->upper - first->lower) : 0.0;
    EdgePath path = {m, first, direction, torque, unloaded, &halvings};
    *jump = (Jump){.stopped = false};
    for (int i = 0; i < 2; i++) jump->reaction[i] = m->state.ledger.peak.reaction[i] * m->params.contacts;
    for (;; path.piece += direction) { /* at most one turn per piece */
        const double breakpoint = direction > 0 ? path.piece->upper : path.piece->lower;
        if (cross_piece(&path, path.piece == last ? stop : breakpoint, bump, jump)) return;
        if (path.piece == last || work_is_spent(m->work)) break;
    }
    jump->stopped = true;
}
