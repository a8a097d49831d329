#include "collocation/radau_edge.h"

#include <float.h>
#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"

/* Bracket invariant: the edge is below the torque at `from`, and not below the torque at `to`, which may be infinite.
 * `from` is the start of the search until the edge has been found below the torque. */
typedef struct {
    double from, to; /* rad */
    double last;     /* rad, latest Newton step; infinite after a bisection */
} EdgeBracket;

typedef enum { EDGE_FOUND, EDGE_SEARCHING, EDGE_LOST } EdgeProgress;

/* One iteration from *theta: a Newton step, or the middle of the bracket if the Newton step leaves it. EDGE_FOUND:
 * *theta is the solution. EDGE_LOST: the edge does not rise to the torque. */
static EdgeProgress improve_angle(const RadauSystem *s, double t, int n, EdgeBracket *bracket, double *theta) {
    const int sign = s->slip->direction;
    const RightHandSide rhs = balance_rhs(s->slip, *theta, 0.0, t);
    const double torque_left = sign * rhs.net; /* in the direction of the motion */
    const bool rises = rhs.by_theta > 0.0;
    if (!rhs.possible || (torque_left > 0.0 && !rises)) return EDGE_LOST;
    if (torque_left > 0.0) {
        bracket->from = *theta;
    } else {
        bracket->to = *theta;
    }
    const double step = rhs.net / rhs.by_theta;
    double next = *theta + step;
    const bool exact = fabs(step) <= EDGE_ROUNDING * fabs(*theta) || (n > 4 && fabs(step) >= fabs(bracket->last));
    const bool inside = rises && sign * (next - bracket->from) >= 0.0 && sign * (bracket->to - next) >= 0.0;
    const bool starts_past_edge = !inside && n == 0 && torque_left <= 0.0; /* by rounding */
    if ((rises && exact) || starts_past_edge) {
        *theta = next;
        return EDGE_FOUND;
    }
    bracket->last = inside ? step : INFINITY;
    if (!inside) next = isfinite(bracket->to) ? 0.5 * (bracket->from + bracket->to) : *theta + 0.5 * step;
    if (next == *theta) return EDGE_FOUND;
    *theta = next;
    return EDGE_SEARCHING;
}

/* Moves *theta, in the direction of the slip, to where the edge of the band is the torque at time t. Newton's method
 * inside a bracket: an edge that begins level sends the first Newton steps far off. */
static bool find_angle_on_edge(const RadauSystem *s, double t, double *theta) {
    EdgeBracket bracket = {
        .from = *theta,
        .to = s->slip->direction > 0 ? s->highest : s->lowest,
        .last = INFINITY,
    };
    for (int n = 0; n < EDGE_ITERATIONS; n++) {
        slip_count(s->slip, 1);
        const EdgeProgress progress = improve_angle(s, t, n, &bracket, theta);
        if (progress != EDGE_SEARCHING) return progress == EDGE_FOUND;
    }
    return false;
}

bool radau_edge_follow(const RadauSystem *s, Balance node[RADAU_MAX]) {
    double theta = s->start->theta;
    for (int i = 0; i < s->method->stages; i++) {
        const double t = s->method->node[i] * s->h;
        if (!find_angle_on_edge(s, t, &theta) || !radau_system_is_inside(s, theta)) return false;
        balance_at(s->slip, theta, 0.0, t, &node[i]);
        if (!(node[i].rhs.by_theta > 0.0)) return false;
    }
    return true;
}

double radau_edge_noise(const RadauSystem *s, const Balance node[RADAU_MAX]) {
    double noise = 0.0;
    for (int i = 0; i < s->method->stages; i++) {
        const Balance *b = &node[i];
        const double rho = b->force != 0.0 ? b->tau / b->force : 0.0;
        const double torque = fabs(b->tau) + fabs(rho) * (fabs(b->force - b->F_ext) + fabs(b->F_ext));
        noise = max_of(noise, EDGE_TORQUE_ROUNDING * torque / b->rhs.by_theta);
    }
    return noise;
}
