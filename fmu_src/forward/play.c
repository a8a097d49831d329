#include "forward/play.h"

#include <float.h>
#include <math.h>

#include "contact/contact.h"
#include "elementary/elementary.h"
#include "forward/configuration.h"
#include "forward/stick.h"
#include "numerics/quadrature.h"
#include "numerics/radau.h"
#include "numerics/root.h"
#include "platform/attributes.h"

/* Along the edge of the band, through one piece. */
typedef struct {
    const Mechanism *m;
    const TransmissionPiece *piece;
    int direction;
    double torque;   /* N.m, to be held */
    double unloaded; /* rad, from the start, within which F_0 is zero to rounding; 0: F_0 counts at the start */
} EdgePath;

/* The band's edge at one angle. */
typedef struct {
    double torque; /* N.m; infinite: no torque moves the mechanism on */
    int pattern; /* sign of F_0 and flanks, or that no torque moves the mechanism; the edge has a kink where it changes */
    double dz_dtheta;   /* m/rad */
    double heat[2];     /* N.m, friction heat per angle at contact i */
    double sliding[2];  /* N.m, reaction times sliding distance per angle at contact i */
    double reaction[2]; /* N, |R_i|, total of all pin ends */
} Edge;

NOINLINE static Edge edge_at(const EdgePath *path, double theta) {
    const Mechanism *m = path->m;
    work_add(m->work, 1);
    const TransmissionPoint point = piece_at(path->piece, theta);
    Geometry g = cam_geometry(m->params.cam, point.slope);
    const double F_0 = spring_force(&m->params.spring, point.z) + m->inputs.F_ext[0];
    const int side = F_0 < 0.0 ? -1 : 1; /* where F_0 < 0 the band is mirrored */
    Edge edge = {.dz_dtheta = g.dz_dtheta, .pattern = SLIP_MODE_COUNT};
    int flank[2];
    Transfer t;
    cam_set_load(&m->params, F_0, &g);
    if (!contact_edge(&g, side * path->direction, flank, &t)) {
        const bool begins = fabs(theta - m->state.theta.hi) <= path->unloaded && !stick_force_counts(m, F_0);
        edge.torque = F_0 == 0.0 || begins ? 0.0 : (double)path->direction * (double)INFINITY;
        return edge;
    }
    edge.torque = t.rho * F_0;
    edge.pattern = slip_index(side, flank);
    for (int i = 0; i < 2; i++) {
        const double x = fabs(t.axial[i] * F_0);
        edge.heat[i] = cam_heat(&g, i) * x;
        edge.reaction[i] = x * cam_length(&g, i);
        edge.sliding[i] = edge.reaction[i] * cam_sliding(&g, i);
    }
    return edge;
}

/* Torque beyond the edge, in the direction of the jump. A ScalarFunction of an EdgePath. */
static double beyond(const void *context, double theta) {
    const EdgePath *path = context;
    return path->direction * (path->torque - edge_at(path, theta).torque);
}

/* The angle at which the torque is held: at `from` the torque is beyond the edge or on it, at `to` it is not; before
 * the angle at which a contact locks. */
static double held_between(const EdgePath *path, double from, double to, double f_to) {
    return root_between(beyond, path, from, max_of(beyond(path, from), DBL_MIN), to, f_to);
}

/* Work, heats, reactions and, for the wear, reaction times sliding distance along the edge. */
static void edge_integrand(const void *context, double theta, QuadratureSample *out) {
    const EdgePath *path = context;
    const Edge edge = edge_at(path, theta);
    *out = (QuadratureSample){.branch = work_is_spent(path->m->work) ? -1 : edge.pattern};
    out->rate[RATE_WORK_IN] = edge.torque;
    out->rate[RATE_WORK_EXT] = edge.dz_dtheta * path->m->inputs.F_ext[0];
    for (int i = 0; i < 2; i++) {
        out->rate[RATE_HEAT_CAM1 + i] = path->direction * edge.heat[i];
        out->rate[RATE_SLIDING1 + i] = path->direction * edge.sliding[i];
        out->size[SIZE_REACTION1 + i] = edge.reaction[i];
    }
}

/* Books the path from `from` to `to`; where the work is spent, the step is refused. */
static void book(const EdgePath *path, double from, double to, Jump *jump) {
    const Mechanism *m = path->m;
    if (!m->params.ledger) return;
    /* On a dwell z is constant, and every energy changes by rounding only. */
    const double z = fabs(m->configuration.z) + m->model.transmission.z_size;
    Quadrature q = {
        .integrand = edge_integrand,
        .scene = path,
        .tolerance = PLAY_SHARE_OF_TOLERANCE * m->params.tolerance,
        .rounding = PLAY_ROUNDING * stick_axial_size(m) * z,
        .peak = {[SIZE_REACTION1] = jump->reaction[0], [SIZE_REACTION2] = jump->reaction[1]},
    };
    (void)quadrature_over(&q, from, to);
    jump->booking.work_in += q.total[RATE_WORK_IN];
    jump->booking.work_ext += q.total[RATE_WORK_EXT];
    for (int i = 0; i < 2; i++) {
        jump->booking.heat_cam[i] += q.total[RATE_HEAT_CAM1 + i];
        jump->booking.wear[i] += wear_per_sliding(&m->params, i) * q.total[RATE_SLIDING1 + i];
        jump->reaction[i] = q.peak[SIZE_REACTION1 + i];
    }
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
        if (held) to = held_between(path, from, to, left);
        book(path, from, to, jump);
        jump->dtheta = to - start;
        if (held) return true;
        from = to;
        step = min_of(2.0 * step, width / (int)PLAY_SAMPLES);
    }
    return false;
}

void play_jump(const Mechanism *m, int direction, double torque, double bump, Jump *jump) {
    const Transmission *transmission = &m->model.transmission;
    const double stop = stop_ahead(&m->params.stop, direction);
    const TransmissionPiece *last = direction > 0 ? transmission->piece + transmission->count - 1 : transmission->piece;
    const TransmissionPiece *first = transmission_piece(transmission, m->state.theta.hi, direction);
    const double unloaded = stick_is_unloaded(m) ? PLAY_FIRST_SAMPLE * (first->upper - first->lower) : 0.0;
    EdgePath path = {m, first, direction, torque, unloaded};
    *jump = (Jump){.stopped = false};
    for (int i = 0; i < 2; i++) jump->reaction[i] = m->state.ledger.peak.reaction[i] * m->params.contacts;
    for (;; path.piece += direction) { /* at most one turn per piece */
        const double breakpoint = direction > 0 ? path.piece->upper : path.piece->lower;
        if (cross_piece(&path, path.piece == last ? stop : breakpoint, bump, jump)) return;
        if (path.piece == last || work_is_spent(m->work)) break;
    }
    jump->stopped = true;
}
