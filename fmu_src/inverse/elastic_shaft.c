#include "inverse/elastic_shaft.h"

#include "elementary/elementary.h"
#include "inverse/band_edge.h"
#include "model/friction_law.h"

static BandEdge edge_of(const ElasticCam *cam, double theta, int direction) {
    return (BandEdge){
        .params = &cam->m->params,
        .piece = inverse_piece(cam->m, cam->x, direction),
        .direction = direction,
        .F_ext = cam->F_ext,
        .theta = theta,
    };
}

static bool is_free(const ElasticCam *cam, int direction) {
    return direction * (stop_ahead(&cam->m->params.stop, direction) - cam->x) > 0.0;
}

bool elastic_shaft_is_on_edge(const Inverse *m, double x, int direction, ContactForces *forces) {
    const ElasticCam cam = {.m = m, .x = x, .F_ext = m->inputs.F_ext[0]};
    const BandEdge edge = edge_of(&cam, m->inputs.theta[0], direction);
    EdgePoint point;
    band_edge_at(&edge, x, &point);
    *forces = point.forces;
    return point.finite && is_free(&cam, direction) && band_edge_side(&edge, x, &point) == 0;
}

/* Is cam 2 at a stop, and pressed into the stop by a torque beyond the band? */
static bool is_stopped(const ElasticCam *cam, double theta, int direction) {
    if (is_free(cam, direction)) return false;
    const BandEdge edge = edge_of(cam, theta, direction);
    EdgePoint point;
    band_edge_at(&edge, cam->x, &point);
    return band_edge_side(&edge, cam->x, &point) > 0;
}

/* dx/dtheta of cam 2 on the edge: 1/(d theta_h/dx). */
static double speed_ratio(const BandEdge *edge, const EdgePoint *point) {
    const double slope = edge_point_slope(edge, point);
    return slope > 0.0 ? 1.0 / slope : 0.0;
}

/* Does cam 2 slip in this direction while the far end turns at omega? The edge E = rho F_0 moves with F_ext, so the far
 * end turns against the edge at omega - dE/dF_0 F_ext'/K. */
static bool slips(const ElasticCam *cam, double theta, double omega, int direction, EdgePoint *point, double *speed) {
    const BandEdge edge = edge_of(cam, theta, direction);
    band_edge_at(&edge, cam->x, point);
    const double against_edge =
        point->finite ? omega - point->forces.transfer.rho_rate * cam->F_ext_rate / edge.params->shaft.stiffness
                      : omega;
    *speed = against_edge * speed_ratio(&edge, point);
    return direction * against_edge > 0.0 && is_free(cam, direction) && band_edge_side(&edge, cam->x, point) == 0;
}

static Mode mode_at_rest(const ElasticCam *cam, double theta) {
    if (is_stopped(cam, theta, 1)) return MODE_UPPER_STOP;
    return is_stopped(cam, theta, -1) ? MODE_LOWER_STOP : MODE_STICK;
}

void elastic_shaft_state(const ElasticCam *cam, double theta, double omega, ElasticShaftState *out) {
    const Params *p = &cam->m->params;
    EdgePoint point;
    double speed;
    int direction = omega < 0.0 ? -1 : 1;
    bool moves = slips(cam, theta, omega, direction, &point, &speed);
    if (!moves && cam->F_ext_rate != 0.0) {
        direction = -direction;
        moves = slips(cam, theta, omega, direction, &point, &speed);
    }
    const Mode slip_mode = direction > 0 ? MODE_LOADING : MODE_RELEASING;
    *out = (ElasticShaftState){
        .x = cam->x,
        .tau = p->shaft.stiffness * (theta - cam->x),
        .speed = moves ? speed : 0.0,
        .statics = point.statics,
        .mode = moves ? slip_mode : mode_at_rest(cam, theta),
    };
    Geometry *g = &out->statics.geometry;
    for (int i = 0; i < 2; i++) {
        const double frictionless = point.F_0 * g->dpsi_dtheta[i] / g->radius[i];
        out->reaction[i] = (moves && point.finite ? point.forces.x[i] : frictionless) * cam_length(g, i) / p->contacts;
        if (!moves) g->friction[i] = friction_at_rest(&p->cam[i], fabs(out->reaction[i]));
    }
}

double elastic_shaft_start(const Inverse *m) {
    const StopParams *stop = &m->params.stop;
    const double theta = m->inputs.theta[0];
    Work work = work_of_call(m->work_limit);
    ElasticCam cam = {.m = m, .F_ext = m->inputs.F_ext[0], .work = &work};
    cam.x = min_of(max_of(theta, stop->lower), stop->upper);
    elastic_cam_relax(&cam, theta);
    return work_is_spent(&work) ? NAN : cam.x;
}

void elastic_shaft_present(const Inverse *m, ElasticShaftState *out) {
    const double theta = m->inputs.theta[0];
    Work work = work_of_call(m->work_limit);
    ElasticCam cam = {.m = m, .x = m->state.cam, .F_ext = m->inputs.F_ext[0], .F_ext_rate = m->inputs.F_ext[1]};
    cam.work = &work;
    elastic_cam_follow(&cam, m->state.theta, theta);
    if (work_is_spent(&work)) cam.x = NAN;
    elastic_shaft_state(&cam, theta, m->inputs.omega[0], out);
}
