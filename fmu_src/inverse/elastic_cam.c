#include "inverse/elastic_cam.h"

#include <math.h>

#include "elementary/elementary.h"
#include "inverse/band_edge.h"
#include "numerics/root.h"
#include "numerics/sign.h"
#include "numerics/tolerances.h"

/* ---- booking the path of cam 2 ---- */

/* A path of cam 2 on one piece of the transmission. */
typedef struct {
    BandEdge edge;
    double highest; /* rad, the largest holding angle so far, times the direction */
} SlipPath;

/* Work and heat per radian of x; x falls where cam 2 releases. While cam 2 is at x, the far end stands at the largest
 * holding angle so far. Where the holding angle has fallen below, cam 2 snaps: the torque is beyond the edge, and the
 * difference counts as heat of the damper. */
static void slip_integrand(const void *scene, double x, QuadratureSample *out) {
    const SlipPath *path = scene;
    const BandEdge *edge = &path->edge;
    const Params *p = edge->params;
    EdgePoint point;
    band_edge_at(edge, x, &point);
    *out = (QuadratureSample){.branch = -1};
    if (!isfinite(point.torque) || work_is_spent(edge->work)) return;
    const double shaft_torque = p->shaft.stiffness * (edge->direction * path->highest - x);
    const bool snaps = edge->direction * (shaft_torque - point.torque) > 0.0;
    const double tau = snaps ? shaft_torque : point.torque;
    out->branch = edge_point_branch(&point) + 8 * snaps;
    out->rate[RATE_WORK_IN] = tau;
    out->rate[RATE_WORK_EXT] = edge->F_ext * point.statics.geometry.dz_dtheta;
    out->rate[RATE_HEAT_DAMPER] = tau - point.torque;
    out->size[SIZE_TORQUE] = fabs(tau);
    for (int i = 0; i < 2 && point.finite; i++) {
        out->rate[RATE_HEAT_CAM1 + i] = edge->direction * contact_statics_heat(&point.statics, &point.forces, i);
        out->size[SIZE_REACTION1 + i] = fabs(point.forces.x[i]) * cam_length(&point.statics.geometry, i) / p->contacts;
        if (has_wear(p))
            out->rate[RATE_SLIDING1 + i] = edge->direction * contact_statics_sliding(&point.statics, &point.forces, i);
    }
}

static double sample_angle(double from, double to, int k, int count) {
    return k == count ? to : from + (to - from) * k / count;
}

/* The first reversal of the holding angle between two angles of cam 2, or the end. */
static void next_reversal(const BandEdge *edge, double from, double to, double *before, double *after) {
    EdgeSample a = band_edge_sample(edge, from);
    for (int k = 1; k <= ELASTIC_SNAP_SAMPLES; k++) {
        const EdgeSample b = band_edge_sample(edge, sample_angle(from, to, k, ELASTIC_SNAP_SAMPLES));
        if (band_edge_has_reversal(edge, &a, &b, before, after)) return;
        a = b;
    }
    *before = *after = to;
}

/* Books the slip part by part: each part ends at a reversal, where the integrand changes its formula. */
static bool book_slip(SlipPath *path, Quadrature *quadrature, double from, double to) {
    for (int part = 0; part < ELASTIC_PATH_PARTS && from != to; part++) {
        double before = to, after = to;
        if (part < ELASTIC_PATH_PARTS - 1) next_reversal(&path->edge, from, to, &before, &after);
        if (!quadrature_over(quadrature, from, before)) return false;
        path->highest = max_of(path->highest, band_edge_holding_angle(&path->edge, before));
        from = after;
    }
    return true;
}

static bool book_path(SlipPath *path, const ElasticCam *cam, double from, double to) {
    cam->quadrature->integrand = slip_integrand;
    cam->quadrature->scene = path;
    const bool booked = book_slip(path, cam->quadrature, from, to);
    cam->quadrature->scene = NULL; /* the path ends with the call */
    return booked;
}

/* ---- where cam 2 comes to rest ---- */

/* The end of the interval of search from x: a breakpoint of the transmission, a stop, or a share of the range. */
static double interval_end(const BandEdge *edge, double x) {
    const StopParams *stop = &edge->params->stop;
    const double limit =
        edge->direction > 0 ? min_of(edge->piece->upper, stop->upper) : max_of(edge->piece->lower, stop->lower);
    const double share = x + edge->direction * (stop->upper - stop->lower) / (int)ELASTIC_SEARCH_INTERVALS;
    return edge->direction * (share - limit) < 0.0 ? share : limit;
}

static double rest_between(const BandEdge *edge, double a, double b) {
    return root_between(band_edge_excess, edge, a, band_edge_excess(edge, a), b, band_edge_excess(edge, b));
}

/* The angle between x and `end` where cam 2 comes to rest, or `end` with *rests = false. Between two samples a maximum
 * of the holding angle may hold cam 2, so that each reversal is tested, too. */
static double rest_on_interval(const BandEdge *edge, double x, double end, bool *rests) {
    EdgeSample a = band_edge_sample(edge, x);
    *rests = true;
    for (int k = 1; k <= ELASTIC_REST_SAMPLES; k++) {
        const EdgeSample b = band_edge_sample(edge, sample_angle(x, end, k, ELASTIC_REST_SAMPLES));
        double maximum, after;
        if (band_edge_excess(edge, b.x) <= 0.0) return rest_between(edge, a.x, b.x);
        if (band_edge_has_reversal(edge, &a, &b, &maximum, &after) && band_edge_excess(edge, maximum) <= 0.0)
            return rest_between(edge, a.x, maximum);
        a = b;
    }
    *rests = false;
    return end;
}

bool elastic_cam_slip(ElasticCam *cam, double theta_from, double theta_to, int direction) {
    const Inverse *m = cam->m;
    SlipPath path = {
        .edge = {
            .params = &m->params, .direction = direction, .F_ext = cam->F_ext, .theta = theta_to, .work = cam->work}};
    BandEdge *edge = &path.edge;
    const double stop = stop_ahead(&m->params.stop, direction);
    bool first = true, rests = false;
    while (!rests && direction * (stop - cam->x) > 0.0) { /* at most one turn per piece and per share of the range */
        if (work_is_spent(cam->work)) return false;
        edge->piece = transmission_piece(&m->transmission, cam->x, direction);
        if (!band_edge_is_exceeded(edge, cam->x)) break;
        if (first) path.highest = max_of(direction * theta_from, band_edge_holding_angle(edge, cam->x));
        first = false;
        const double x = rest_on_interval(edge, cam->x, interval_end(edge, cam->x), &rests);
        if (x == cam->x) break;
        if (cam->quadrature != NULL && !book_path(&path, cam, cam->x, x)) return false;
        cam->x = x;
        cam->moved = true;
    }
    return true;
}

bool elastic_cam_relax(ElasticCam *cam, double theta) {
    return elastic_cam_slip(cam, theta, theta, 1) && elastic_cam_slip(cam, theta, theta, -1);
}

bool elastic_cam_follow(ElasticCam *cam, double theta_from, double theta_to) {
    return elastic_cam_relax(cam, theta_from) &&
           (theta_from == theta_to || elastic_cam_slip(cam, theta_from, theta_to, sign_of(theta_to - theta_from)));
}
