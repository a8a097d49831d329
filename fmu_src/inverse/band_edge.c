#include "inverse/band_edge.h"

#include <math.h>

#include "elementary/elementary.h"
#include "model/elements.h"
#include "numerics/golden_section.h"
#include "numerics/root.h"
#include "numerics/sign.h"
#include "numerics/tolerances.h"

enum { NO_FLANKS_BEAR = 4 }; /* flank_branch() is 0 to 3 */

void band_edge_at(const BandEdge *edge, double x, EdgePoint *out) {
    work_add(edge->work, 1);
    out->statics = contact_statics_at(edge->params, edge->piece, x);
    out->F_0 = spring_force(&edge->params->spring, out->statics.z) + edge->F_ext;
    out->finite = contact_statics_on_edge(&out->statics, edge->direction, out->F_0, &out->forces);
    out->torque = out->finite ? out->forces.torque : (edge->direction > 0 ? INFINITY : -INFINITY);
    if (out->F_0 == 0.0) out->torque = 0.0; /* without a load there is no friction, even if a contact locks */
}

int edge_point_branch(const EdgePoint *point) {
    return point->finite ? flank_branch(point->forces.flank) : NO_FLANKS_BEAR;
}

/* ---- the shaft's torque against the edge ---- */

static double excess_of(const BandEdge *edge, double x, const EdgePoint *point) {
    return edge->direction * (edge->params->shaft.stiffness * (edge->theta - x) - point->torque);
}

/* N.m, the sum of the magnitudes that excess_of() adds up. */
static double excess_size(const BandEdge *edge, double x, const EdgePoint *point) {
    return edge->params->shaft.stiffness * (fabs(edge->theta) + fabs(x)) + fabs(point->torque);
}

double band_edge_excess(const void *edge, double x) {
    EdgePoint point;
    band_edge_at(edge, x, &point);
    return excess_of(edge, x, &point);
}

bool band_edge_is_exceeded(const BandEdge *edge, double x) {
    EdgePoint point;
    band_edge_at(edge, x, &point);
    if (!isfinite(point.torque)) return false;
    return excess_of(edge, x, &point) > BAND_EDGE_ROUNDING * excess_size(edge, x, &point);
}

int band_edge_side(const BandEdge *edge, double x, const EdgePoint *point) {
    if (!isfinite(point->torque)) return -1;
    const double excess = excess_of(edge, x, point);
    return fabs(excess) <= BAND_EDGE_TIE * excess_size(edge, x, point) ? 0 : sign_of(excess);
}

/* ---- the holding angle ---- */

static double holding_angle_of(const BandEdge *edge, double x, const EdgePoint *point) {
    return edge->direction * (x + point->torque / edge->params->shaft.stiffness);
}

double band_edge_holding_angle(const BandEdge *edge, double x) {
    EdgePoint point;
    band_edge_at(edge, x, &point);
    return holding_angle_of(edge, x, &point);
}

double edge_point_slope(const BandEdge *edge, const EdgePoint *point) {
    if (!point->finite) return 1.0;
    const double dedge_dx = contact_statics_edge_rise(&point->statics, edge->direction, point->F_0, &point->forces) +
                            point->forces.transfer.rho_rate * spring_rate(&edge->params->spring, point->statics.z) *
                                point->statics.geometry.dz_dtheta;
    return 1.0 + dedge_dx / edge->params->shaft.stiffness;
}

EdgeSample band_edge_sample(const BandEdge *edge, double x) {
    EdgePoint point;
    band_edge_at(edge, x, &point);
    return (EdgeSample){
        .x = x,
        .holding_angle = holding_angle_of(edge, x, &point),
        .slope = edge_point_slope(edge, &point),
        .branch = edge_point_branch(&point),
    };
}

/* ---- reversals of the holding angle ---- */

/* A ScalarFunction of a BandEdge. */
static double slope_at(const void *edge, double x) {
    EdgePoint point;
    band_edge_at(edge, x, &point);
    return edge_point_slope(edge, &point);
}

/* A ScalarFunction of a BandEdge: golden section looks for a maximum. */
static double negative_slope_at(const void *edge, double x) {
    return -slope_at(edge, x);
}

/* May theta_h fall between two samples at which it rises? The slope halfway of the cubic through both samples decides:
 * a slope that is small against the largest one leaves a doubt. */
static bool may_fall_between(const EdgeSample *a, const EdgeSample *b) {
    const double halfway =
        1.5 * (b->holding_angle - a->holding_angle) / fabs(b->x - a->x) - 0.25 * (a->slope + b->slope);
    return min_of(min_of(a->slope, b->slope), halfway) < SMALL_EDGE_SLOPE * max_of(max_of(a->slope, b->slope), halfway);
}

/* Does theta_h jump down where other flanks take over between a and b? Bisection ends at two neighbouring doubles. */
static bool jumps_down(const BandEdge *edge, const EdgeSample *a, const EdgeSample *b, double *before, double *after) {
    if (a->branch == b->branch) return false;
    EdgeSample left = *a, right = *b;
    for (int n = 0; n < BISECTIONS_MAX; n++) {
        const double x = 0.5 * (left.x + right.x);
        if (x == left.x || x == right.x) break;
        const EdgeSample middle = band_edge_sample(edge, x);
        if (middle.branch == a->branch) left = middle;
        else right = middle;
    }
    *before = left.x;
    *after = right.x;
    return right.holding_angle < left.holding_angle - BAND_EDGE_TIE * (fabs(left.holding_angle) + fabs(left.x));
}

bool band_edge_has_reversal(const BandEdge *edge, const EdgeSample *a, const EdgeSample *b, double *before,
                            double *after) {
    if (jumps_down(edge, a, b, before, after)) return true;
    EdgeSample last = *b;
    if (a->slope >= 0.0 && b->slope >= 0.0) {
        if (!may_fall_between(a, b)) return false;
        last = band_edge_sample(edge,
                                golden_section_maximum(negative_slope_at, edge, a->x, b->x, BAND_EDGE_GOLDEN_STEPS).x);
    }
    if ((a->slope >= 0.0) == (last.slope >= 0.0)) return false;
    *before = *after = root_between(slope_at, edge, a->x, a->slope, last.x, last.slope);
    return *before != a->x;
}
